"""The converters of foreign records, on made-up files of the same layout."""

from pathlib import Path

import numpy as np
import pytest

from jaxstick.record import AssumedConstants, KnownRig, load_dataset
from scripts import convert_emps, convert_frame
from tests.jaxstick import datasets


def frame_file(path: Path, gain: float = 1.0) -> np.ndarray:
    """A frame's record: 250 Hz, 1 Hz, a base of 1.82 mm, times with three digits; returns the
    displacement."""
    time = np.arange(600) / 250
    rng = np.random.default_rng(1)
    base = 1.82e-3 * np.sin(2 * np.pi * time) + rng.normal(0, 1e-6, 600)
    mass = gain * 1.5e-3 * np.sin(2 * np.pi * time - 0.3)
    rows = (f"{t:.3f},{y!r},{x!r}" for t, y, x in zip(time, base.tolist(), mass.tolist(), strict=True))
    path.write_text("\n".join(["t_s,base_y_m,mass_x_m", *rows]) + "\n")
    return mass


def emps_file(path: Path) -> dict[str, np.ndarray]:
    """A record of the joint: 1 kHz, a chirp of the force."""
    time = np.arange(500) / 1000
    force = 80 * np.cos(40 * time**2)
    columns = {
        "t_s": time,
        "q_m": 0.01 * np.sin(9 * time),
        "q_ref_m": 0.01 * np.sin(9 * time),
        "force_N": force,
    }
    path.write_text(datasets.csv_text(columns))
    return columns


def test_frames_become_one_data_set(tmp_path, capsys):
    first = frame_file(tmp_path / "350g.csv")
    second = frame_file(tmp_path / "450g.csv", gain=0.9)
    words = [str(tmp_path / "350g.csv"), str(tmp_path / "450g.csv"), "--hold-out", "450g.csv"]
    words += ["--disc-mass", "0.35", "--disc-mass", "0.45", "--out", str(tmp_path / "frame")]
    assert convert_frame.main(words) == 0
    assert "2 runs" in capsys.readouterr().out
    dataset = load_dataset(tmp_path / "frame")
    assert dataset.name == "frame" and dataset.notices == ()
    assert dataset.rig == KnownRig(3.0799, 1191.0, 1191.0, 0.669, 0.669, "ground")
    for run, displacement in zip(dataset.runs, (first, second), strict=True):
        np.testing.assert_array_equal(run.displacement, displacement)
        assert run.base is not None and run.friction is None and run.frequency == 1.0
        assert run.interval == pytest.approx(0.004)
    assert [run.hold_out for run in dataset.runs] == [False, True]
    # mu m g by hand: 0.29 * 0.35 * 9.81 and 0.29 * 0.45 * 9.81
    assert [run.assumed.C for run in dataset.runs] == pytest.approx([0.9957, 1.2802], abs=1e-4)
    assert (dataset.runs[0].assumed.A, dataset.runs[0].assumed.D) == (0.0, 0.0)
    assert "arXiv 2303.03858" in (tmp_path / "frame" / "rig.toml").read_text()


def test_without_a_disc_nothing_is_assumed_of_the_level(tmp_path):
    frame_file(tmp_path / "a.csv")
    assert convert_frame.main([str(tmp_path / "a.csv"), "--mass", "3", "--out", str(tmp_path / "out")]) == 0
    (run,) = load_dataset(tmp_path / "out").runs
    assert run.assumed.C is None and run.rig.mass == 3.0


def test_the_joint_becomes_a_data_set(tmp_path):
    columns = emps_file(tmp_path / "emps.csv")
    assert convert_emps.main([str(tmp_path / "emps.csv"), "--out", str(tmp_path / "joint")]) == 0
    dataset = load_dataset(tmp_path / "joint")
    assert dataset.rig == KnownRig(95.1, 0.0, 0.0, 0.0, 0.0, "ground")
    assert dataset.assumed == AssumedConstants(0.0, 100.0, 20.4, 203.0, None)
    (run,) = dataset.runs
    assert run.frequency is None and run.base is None and run.force is not None
    np.testing.assert_array_equal(run.displacement, columns["q_m"])
    np.testing.assert_array_equal(run.force, columns["force_N"])


def mistakes(folder: Path) -> dict[str, tuple[int, list[str], str]]:
    frame_file(folder / "a.csv")
    emps_file(folder / "emps.csv")
    (folder / "deep").mkdir()
    frame_file(folder / "deep" / "a.csv")
    a, out = str(folder / "a.csv"), ["--out", str(folder / "out")]
    return {
        "layout": (2, [str(folder / "emps.csv"), *out], "no column 'base_y_m'"),
        "missing": (2, [str(folder / "b.csv"), *out], "no such file"),
        "discs": (
            2,
            [a, "--disc-mass", "1", "--disc-mass", "2", *out],
            "--disc-mass is given 2 times for 1 files",
        ),
        "held out": (2, [a, "--hold-out", "c.csv", *out], "--hold-out c.csv is none of the files a.csv"),
        "names": (2, [a, str(folder / "deep" / "a.csv"), *out], "same name"),
        "negative": (2, [a, "--mass", "-1", *out], "mass_kg is -1"),
        "taken": (2, [a, "--out", str(folder / "deep")], "not written by jaxstick"),
    }


@pytest.mark.parametrize("mistake", ["layout", "missing", "discs", "held out", "names", "negative", "taken"])
def test_a_mistake_is_one_sentence_and_leaves_nothing(tmp_path, capsys, mistake):
    status, words, piece = mistakes(tmp_path)[mistake]
    before = sorted(tmp_path.rglob("*"))
    assert convert_frame.main(words) == status
    said = capsys.readouterr().err
    assert piece in said and said.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_the_joint_refuses_another_layout(tmp_path, capsys):
    frame_file(tmp_path / "a.csv")
    assert convert_emps.main([str(tmp_path / "a.csv"), "--out", str(tmp_path / "out")]) == 2
    assert "no column 'q_m'" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
