"""What `jaxstick check` says of a data set."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from jaxstick.check import describe, quantity
from jaxstick.output import to_json
from jaxstick.record import load_dataset
from tests.jaxstick import datasets

ROOT = Path(__file__).resolve().parents[2]


def csv(samples: int = 1280, per_cycle: int = 128, noise: float = 0.0, **left_out: bool) -> str:
    channels = datasets.record(samples, per_cycle)
    rng = np.random.default_rng(0)
    columns = {
        "time_s": channels["time"],
        "base_m": channels["base"],
        "displacement_m": channels["displacement"] + rng.normal(0, noise or 1e-12, samples),
        "friction_n": channels["friction"] + rng.normal(0, 0.01, samples),
    }
    return datasets.csv_text(
        {name: column for name, column in columns.items() if name.split("_")[0] not in left_out}
    )


SECOND = '[[run]]\nfile = "run-02.csv"\nfrequency_hz = 1.0\nbase_amplitude_mm = 10\nhold_out = true\n'


def texts(folder: Path, kind: str) -> str:
    return "\n".join(
        finding.text for finding in describe(load_dataset(folder)).findings if finding.kind == kind
    )


def test_the_numbers_of_a_run(tmp_path):
    folder = datasets.write(tmp_path, datasets.RIG + SECOND, run_01=csv(noise=2e-5), run_02=csv())
    found = describe(load_dataset(folder))
    run = found.runs[0]
    assert (run.file, run.samples, run.hold_out, found.runs[1].hold_out) == ("run-01.csv", 1280, False, True)
    assert run.rate == pytest.approx(128)
    assert run.duration == pytest.approx(10)
    assert run.frequency == pytest.approx(1.0, abs=1e-6)
    assert run.cycles == pytest.approx(10)
    assert run.samples_per_cycle == pytest.approx(128)
    assert run.ratio == pytest.approx(1 / 4.6136, rel=1e-4)
    assert run.base_amplitude == pytest.approx(0.01, rel=1e-6)
    assert run.amplitudes["displacement"] == pytest.approx(0.007, abs=1e-4)
    assert found.noise[0].channel == "displacement"
    assert found.noise[0].found.sd == pytest.approx(2e-5, rel=0.15)


def test_the_tables_are_whole_and_json_holds_everything(tmp_path):
    found = describe(load_dataset(datasets.write(tmp_path, run_01=csv())))
    assert [section.title for section in found.sections] == ["Rig", "Runs", "Channels"]
    for section in found.sections:
        assert section.rows
        assert all(len(row) == len(section.columns) for row in section.rows)
    again = json.loads(to_json(found))
    assert again["runs"][0]["samples"] == 1280
    assert again["sha256"] == found.sha256
    assert again["rig"]["mass"] == 2.38
    assert again["noise"][0]["found"]["sd"] > 0


def test_a_full_data_set_lacks_little(tmp_path):
    rig = datasets.RIG + SECOND.replace("_hz = 1.0", "_hz = 1.25")
    other = csv(noise=1e-5).splitlines()
    header, rows = other[0], [line.split(",") for line in other[1:]]
    faster = "\n".join([header, *(",".join([repr(float(row[0]) / 1.25), *row[1:]]) for row in rows)]) + "\n"
    folder = datasets.write(tmp_path, rig, run_01=csv(noise=1e-5), run_02=faster)
    assert texts(folder, "missing") == ""
    assert texts(folder, "notice") == ""


def test_what_is_missing_is_named_with_its_cost(tmp_path):
    rig = datasets.RIG.replace("C_n = 5.0\n", "")
    missing = texts(
        datasets.write(tmp_path, rig, run_01=csv(noise=1e-5, friction=True, base=True)), "missing"
    )
    for piece in (
        "no friction force in any run",
        "no base motion in any run",
        "only one drive frequency (1 Hz)",
        "no run is held out",
        "no assumed C:",
    ):
        assert piece in missing


def test_one_frequency_is_one_whatever_it_is(tmp_path):
    lines = csv(noise=1e-5).splitlines()
    rows = [line.split(",") for line in lines[1:]]
    for factor in (0.5, 2.0):
        text = (
            "\n".join([lines[0], *(",".join([repr(float(row[0]) / factor), *row[1:]]) for row in rows)])
            + "\n"
        )
        rig = datasets.RIG.replace("frequency_hz = 1.0", f"frequency_hz = {factor}")
        found = texts(datasets.write(tmp_path / str(factor), rig, run_01=text), "missing")
        assert f"only one drive frequency ({factor:g} Hz)" in found


def test_less_than_a_cycle_does_not_tell_the_frequency(tmp_path):
    text = "\n".join(csv(noise=1e-5).splitlines()[:81]) + "\n"
    (run,) = describe(load_dataset(datasets.write(tmp_path, run_01=text))).runs
    assert (run.frequency, run.base_amplitude) == (1.0, 0.01)
    assert run.cycles == pytest.approx(0.625)


def test_poor_sampling_is_named(tmp_path):
    folder = datasets.write(tmp_path, run_01=csv(samples=128, per_cycle=40, noise=1e-5))
    warnings = texts(folder, "warning")
    assert "3.2 cycles" in warnings
    assert "40 samples a cycle" in warnings
    assert "ring on the assumed k1 at 32.95 Hz" in warnings


@pytest.mark.parametrize(
    ("stated", "piece"),
    [(1e-6, "more than the stated 1 um"), (1e-5, ""), (1e-4, "less than the stated 100 um")],
)
def test_stated_noise_is_compared_with_the_record(tmp_path, stated, piece):
    rig = datasets.RIG + f"[noise]\ndisplacement_m = {stated}\n"
    warnings = texts(datasets.write(tmp_path, rig, run_01=csv(noise=1e-5)), "warning")
    assert piece in warnings
    assert ("the stated" in warnings) == bool(piece)


def test_samples_that_are_off_are_pointed_at(tmp_path):
    head, *rows = csv(noise=1e-5).splitlines()
    column = head.split(",").index("displacement_m")
    cells = rows[100].split(",")
    time, cells[column] = cells[0], repr(float(cells[column]) + 2e-3)
    text = "\n".join([head, *rows[:100], ",".join(cells), *rows[101:]]) + "\n"
    assert "single" not in texts(datasets.write(tmp_path / "good", run_01=csv(noise=1e-5)), "warning")
    warnings = texts(datasets.write(tmp_path / "bad", run_01=text), "warning")
    assert "run-01.csv, displacement: 1 single sample is off by up to 2.0" in warnings
    assert f"the first at {float(time):.6g} s" in warnings


def test_what_reading_changed_is_a_notice(tmp_path):
    text = csv(noise=1e-5).replace("friction_n", "humidity")
    assert "'humidity' is not used" in texts(datasets.write(tmp_path, run_01=text), "notice")


def test_a_record_driven_by_a_force_needs_no_frequency(tmp_path):
    channels = datasets.record(640, 128)
    text = datasets.csv_text(
        {
            "time_s": channels["time"],
            "displacement_m": channels["displacement"],
            "force_n": 2000 * channels["base"],
        }
    )
    rig = datasets.RIG.replace("frequency_hz = 1.0\nbase_amplitude_mm = 10.0\n", "")
    found = describe(load_dataset(datasets.write(tmp_path, rig, run_01=text)))
    assert (found.runs[0].frequency, found.runs[0].cycles, found.runs[0].base_amplitude) == (None, None, None)
    assert found.sections[1].rows[0][4] == "-"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.010326, "m", "10.33 mm"),
        (8e-6, "m", "8 um"),
        (3e-13, "m", "0.0003 nm"),
        (-0.25, "N", "-250 mN"),
        (7.47, "N", "7.47 N"),
        (0.0, "m", "0 m"),
        (0.9999999, "m", "1 m"),
        (1986.0, "N/m", "1986 N/m"),
        (None, "m", "-"),
        (0.25, "", "0.25"),
    ],
)
def test_numbers_for_reading(value, unit, text):
    assert quantity(value, unit) == text


def test_checking_needs_no_jax(tmp_path):
    """`jaxstick check` starts fast because nothing it needs imports jax or scipy."""
    code = (
        "import sys; import jaxstick.check, jaxstick.output;"
        "print([name for name in ('jax', 'scipy', 'matplotlib', 'equinox') if name in sys.modules])"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout
    assert said.strip() == "[]"
