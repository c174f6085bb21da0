"""The shipped data sets are what scripts/make_shipped_data.py writes, and carry the noise they state."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from scripts import make_shipped_data
from tests.reference import loaded
from tests.reference.drive import SineDrive

DATA = Path(__file__).resolve().parents[2] / "data"


def test_the_script_writes_the_shipped_bytes_and_refuses_to_do_it_twice(tmp_path: Path) -> None:
    make_shipped_data.write(tmp_path, overwrite=False)
    made = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file())
    assert len(made) == 1 + 6 + 7 + 7
    for path in made:
        assert (tmp_path / path).read_bytes() == (DATA / path).read_bytes(), path
    with pytest.raises(FileExistsError, match="--overwrite"):
        make_shipped_data.write(tmp_path, overwrite=False)
    victim = tmp_path / "rig1987" / "run-01.csv"
    victim.write_text("")
    make_shipped_data.write(tmp_path, overwrite=True)
    assert victim.stat().st_size > 0


def test_nothing_is_written_where_one_folder_is_taken(tmp_path: Path) -> None:
    (tmp_path / "tribometer").mkdir()
    (tmp_path / "tribometer" / "mine.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="tribometer"):
        make_shipped_data.write(tmp_path, overwrite=False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tribometer"]


@pytest.mark.parametrize("rig", make_shipped_data.RIGS, ids=lambda rig: rig.name)
def test_records_are_the_true_motion_plus_the_stated_noise(rig: make_shipped_data.Rig) -> None:
    folder = DATA / rig.name
    stated = tomllib.loads((folder / "rig.toml").read_text())
    residuals = []
    for plan, run in zip(rig.plans, stated["run"], strict=True):
        text = (folder / run["file"]).read_text()
        assert text.startswith("# SYNTHETIC")
        rows = np.loadtxt(text.splitlines(), delimiter=",", skiprows=3)
        time, base, x, friction = (rows * [channel.unit for channel in rig.channels]).T
        T = 1.0 / run["frequency_hz"]
        drive = SineDrive(run["frequency_hz"], 1e-3 * run["base_amplitude_mm"], plan.phase)
        true = loaded.simulate(rig.true, drive, np.concatenate([[-T], time]), tolerance=1e-9)
        y = np.array([drive.position(t) for t in time])
        units = [channel.unit for channel in rig.channels[1:]]
        residuals.append(np.stack([base - y, x - true.x[1:], friction - true.F[1:]], axis=1) / units)
    noise = np.concatenate(residuals)
    expected = [stated["noise"][channel.name] for channel in rig.channels[1:]]
    np.testing.assert_allclose(noise.std(axis=0), expected, rtol=0.02)
    assert np.all(np.abs(noise.mean(axis=0)) < 5.0 * np.array(expected) / np.sqrt(len(noise)))
    neighbours = np.mean(noise[1:] * noise[:-1], axis=0) / np.array(expected) ** 2
    assert np.all(np.abs(neighbours) < 5.0 / np.sqrt(len(noise)))


@pytest.mark.parametrize("rig", make_shipped_data.RIGS, ids=lambda rig: rig.name)
def test_every_assumed_constant_is_wrong(rig: make_shipped_data.Rig) -> None:
    for name, assumed in rig.assumed.items():
        factor = max(assumed / getattr(rig.true, name), getattr(rig.true, name) / assumed)
        assert 1.1 < factor < 2.6, name
