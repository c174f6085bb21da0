"""Data sets: what is read from a folder, what a run inherits and overrides, and that saving loses nothing."""

import math
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxstick.errors import UserError
from jaxstick.record import (
    AssumedConstants,
    DataSet,
    KnownRig,
    Noise,
    Run,
    load_dataset,
    load_rig,
    save_dataset,
)
from tests.jaxstick import datasets


def test_a_data_set_is_read_in_si(tmp_path):
    channels = datasets.record()
    millimetres = {
        "time_ms": channels["time"] * 1e3,
        "base_um": channels["base"] * 1e6,
        "displacement_mm": channels["displacement"] * 1e3,
        "friction_kn": channels["friction"] * 1e-3,
        "velocity_mm_per_s": np.gradient(channels["displacement"], channels["time"]) * 1e3,
    }
    rig = datasets.RIG + "[noise]\ndisplacement_um = 8.0\n"
    dataset = load_dataset(datasets.write(tmp_path / "mine", rig, run_01=datasets.csv_text(millimetres)))
    (run,) = dataset.runs
    for name in ("time", "base", "displacement", "friction"):
        np.testing.assert_allclose(getattr(run, name), channels[name], rtol=1e-12, atol=1e-15)
    assert run.velocity is not None and run.force is None
    assert run.interval == pytest.approx(1 / 64, rel=1e-12)
    assert dataset.name == "mine"
    assert dataset.noise == Noise(displacement=8e-6)
    assert (run.frequency, run.base_amplitude, run.base_phase) == (1.0, 0.01, 0.0)
    assert run.assumed == dataset.assumed == AssumedConstants(1.5, 100.0, 5.0, 0.002, 1e5)
    assert dataset.notices == ()


def test_samples_cannot_be_changed(tmp_path):
    (run,) = load_dataset(datasets.write(tmp_path)).runs
    with pytest.raises(ValueError, match="read-only"):
        run.displacement[0] = 1.0


@pytest.mark.parametrize(
    ("damping", "expected"),
    [
        ("log_decrement = 0.207", 4.543),
        ("damping_ratio = 0.0329", 4.538),
        ("damping_n_s_per_m = 4.53", 4.53),
        ("damping_n_s_per_mm = 0.00453", 4.53),
    ],
)
def test_damping_in_each_of_its_forms(tmp_path, damping, expected):
    # c = 2 zeta sqrt(K m), zeta = 0.207 / (2 pi): 2 * 0.032945 * sqrt(2000 * 2.38) = 4.546 by hand
    folder = datasets.write(tmp_path, datasets.RIG.replace("log_decrement = 0.207", damping))
    assert load_dataset(folder).rig.damping == pytest.approx(expected, rel=1e-3)


def test_table_1_of_the_1987_paper(tmp_path):
    rig = datasets.RIG.replace("stiffness_n_per_m = 2000.0", "stiffness_n_per_m = 1986.0")
    sheet = load_rig(datasets.write(tmp_path, rig))
    assert sheet.rig.natural_frequency == pytest.approx(4.60, abs=0.005)
    assert sheet.rig.damping == pytest.approx(4.53, abs=0.005)


def test_what_is_not_said_has_its_default(tmp_path):
    rig = datasets.RIG.replace("log_decrement = 0.207\n", "")
    dataset = load_dataset(datasets.write(tmp_path, rig))
    assert dataset.rig == KnownRig(2.38, 2000.0, 2000.0, 0.0, 0.0, "ground")
    assert len(dataset.notices) == 1 and "damping" in dataset.notices[0]


def test_a_run_overrides_what_its_data_set_says(tmp_path):
    rig = (
        datasets.RIG
        + "hold_out = true\nassumed = { C_kn = 0.0031 }\n"
        + 'rig = { damping_ratio = 0.1, friction_against = "base" }\n'
        + '[[run]]\nfile = "run-02.csv"\nfrequency_hz = 1\nbase_amplitude_m = 0.01\n[run.rig]\n'
        + "mass_g = 2500\n"
    )
    text = datasets.standard_csv()
    dataset = load_dataset(datasets.write(tmp_path, rig, run_01=text, run_02=text))
    first, second = dataset.runs
    assert first.hold_out and not second.hold_out
    assert first.assumed == replace(dataset.assumed, C=3.1)
    assert first.rig.friction_against == "base"
    assert first.rig.damping == pytest.approx(0.2 * math.sqrt(2000 * 2.38))
    assert second.assumed == dataset.assumed
    assert second.rig.mass == 2.5
    assert second.rig.damping == pytest.approx(0.207 / math.pi * math.sqrt(2000 * 2.5))
    assert dataset.rig.friction_against == "ground"


def test_a_stiffer_run_keeps_its_drive_through_the_whole_stiffness(tmp_path):
    rig = datasets.RIG + "rig = { stiffness_n_per_mm = 2.5 }\n"
    (run,) = load_dataset(datasets.write(tmp_path, rig)).runs
    assert (run.rig.stiffness, run.rig.drive_stiffness) == (2500.0, 2500.0)


def test_the_drive_may_be_stated_recorded_or_a_force(tmp_path):
    channels = datasets.record()
    plain = {"time_s": channels["time"], "displacement_m": channels["displacement"]}
    bare = datasets.RIG.replace("frequency_hz = 1.0\nbase_amplitude_mm = 10.0\n", "")
    stated = load_dataset(datasets.write(tmp_path / "stated", run_01=datasets.csv_text(plain)))
    with_base = datasets.csv_text(plain | {"base_m": channels["base"]})
    recorded = load_dataset(datasets.write(tmp_path / "base", bare, run_01=with_base))
    with_force = datasets.csv_text(plain | {"force_n": 2000 * channels["base"]})
    free = bare.replace("= 2000.0", "= 0").replace("log_decrement = 0.207", "damping_n_s_per_m = 1.0")
    pushed = load_dataset(datasets.write(tmp_path / "force", free, run_01=with_force))
    assert stated.runs[0].base is None and stated.runs[0].base_amplitude == 0.01
    assert recorded.runs[0].frequency is None and recorded.runs[0].base is not None
    assert pushed.rig.stiffness == 0 and pushed.runs[0].force is not None


def test_friction_against_the_base_is_judged_by_the_motion_against_it(tmp_path):
    channels = datasets.record()
    against = datasets.RIG.replace("[assumed]", 'friction_against = "base"\n[assumed]')
    relative = np.gradient(channels["displacement"] - channels["base"])
    columns = {
        "time_s": channels["time"],
        "base_m": channels["base"],
        "displacement_m": channels["displacement"],
        "friction_n": -10 * np.sign(relative) - relative,
    }
    assert load_dataset(datasets.write(tmp_path / "against", against, run_01=datasets.csv_text(columns))).runs
    columns["friction_n"] = -columns["friction_n"]
    with pytest.raises(UserError, match="along with the motion"):
        load_dataset(datasets.write(tmp_path / "along", against, run_01=datasets.csv_text(columns)))
    # Without the base's record its phase is not known, and so neither is the direction of sliding.
    del columns["base_m"]
    assert load_dataset(datasets.write(tmp_path / "unknown", against, run_01=datasets.csv_text(columns))).runs


def changed(**columns: np.ndarray) -> str:
    """The standard record as CSV with some columns in another form."""
    channels = datasets.record()
    plain = {
        "time_s": channels["time"],
        "base_m": channels["base"],
        "displacement_m": channels["displacement"],
    }
    return datasets.csv_text(plain | columns)


def test_what_is_odd_but_possible_is_a_notice(tmp_path):
    channels = datasets.record()
    time = channels["time"]
    odd = {
        "moves by only 1e-07 m": changed(displacement_m=1e-7 * np.sign(channels["displacement"] + 1e-9)),
        "moves at 1.1 Hz where rig.toml says 1 Hz": changed(base_m=0.01 * np.sin(2.2 * np.pi * time)),
        "shorter than one cycle of the drive (0.62)": "\n".join(changed().splitlines()[:41]) + "\n",
    }
    for number, (piece, text) in enumerate(odd.items()):
        (notice,) = load_dataset(datasets.write(tmp_path / str(number), run_01=text)).notices
        assert "run-01.csv" in notice and piece in notice


def test_a_part_above_its_whole_is_a_notice(tmp_path):
    parts = "drive_stiffness_n_per_m = 2001\ndrive_damping_n_s_per_m = 4.6\n[assumed]"
    sheet = load_rig(datasets.write(tmp_path, datasets.RIG.replace("[assumed]", parts)))
    assert ["stiffness" in sheet.notices[0], "damping" in sheet.notices[1]] == [True, True]
    whole = "drive_stiffness_n_per_m = 2000\ndrive_damping_n_s_per_m = 4.5\n[assumed]"
    (tmp_path / "rig.toml").write_text(datasets.RIG.replace("[assumed]", whole))
    assert load_rig(tmp_path).notices == ()


def test_a_velocity_sensor_may_have_an_offset(tmp_path):
    velocity = np.gradient(datasets.record()["displacement"], 1 / 64)
    text = changed(velocity_m_per_s=velocity + 1.0)
    assert load_dataset(datasets.write(tmp_path, run_01=text)).runs[0].velocity is not None


def test_other_columns_are_left_out_with_a_notice(tmp_path):
    channels = datasets.record()
    columns = {
        "time_s": channels["time"],
        "displacement_m": channels["displacement"],
        "base_m": channels["base"],
        "temperature_c": channels["time"] + 20,
        "fricton_n": channels["friction"],
        "force_table_temperature_c": channels["time"],
    }
    dataset = load_dataset(datasets.write(tmp_path, run_01=datasets.csv_text(columns)))
    assert set(dataset.runs[0].channels) == {"displacement", "base"}
    assert len(dataset.notices) == 3
    assert "temperature_c" in dataset.notices[0]
    assert "did you mean friction_n?" in dataset.notices[1]


def test_a_rig_sheet_needs_no_records(tmp_path):
    path = tmp_path / "RIG.toml"
    path.write_text(
        'name = "bench"\n[rig]\nmass_g = 2380\nstiffness_kn_per_m = 2\ndamping_ratio = 0.03\n'
        "[[run]]\nfrequency_hz = 0.92\nbase_amplitude_mm = 10\ncycles = 20\nsample_rate_khz = 1\n"
        "[[run]]\nfrequency_rad_per_s = 6.283185307179586\nbase_amplitude_um = 5e3\nduration_s = 4\n"
        "base_phase_deg = -90\nassumed = { C_n = 3 }\n"
    )
    sheet = load_rig(path)
    first, second = sheet.runs
    assert sheet.name == "bench" and sheet.rig.mass == pytest.approx(2.38) and sheet.rig.stiffness == 2000
    assert (first.file, first.frequency, first.cycles, first.sample_rate) == (
        "run-01.csv",
        0.92,
        20.0,
        1000.0,
    )
    assert first.duration is None and first.assumed == AssumedConstants()
    assert second.file == "run-02.csv" and second.duration == 4.0 and second.assumed.C == 3.0
    assert second.frequency == pytest.approx(1.0) and second.base_amplitude == pytest.approx(0.005)
    assert second.base_phase == pytest.approx(-math.pi / 2)
    assert load_rig(path).sha256 == sheet.sha256


def test_a_rig_sheet_may_list_no_runs(tmp_path):
    path = tmp_path / "rig.toml"
    path.write_text("[rig]\nmass_kg = 1\nstiffness_n_per_m = 1\ndamping_ratio = 0\n")
    assert load_rig(tmp_path).runs == ()
    with pytest.raises(UserError, match="no run"):
        load_dataset(tmp_path)


def test_the_checksum_is_of_the_bytes_alone(tmp_path):
    two = datasets.RIG + '[[run]]\nfile = "run-02.csv"\nfrequency_hz = 1\nbase_amplitude_mm = 10\n'
    text = datasets.standard_csv()
    other = text.replace("friction_n", "friction_N")
    here = load_dataset(datasets.write(tmp_path / "here", two, run_01=text, run_02=other))
    there = load_dataset(datasets.write(tmp_path / "there", two, run_02=other, run_01=text))
    swapped = load_dataset(datasets.write(tmp_path / "swapped", two, run_01=other, run_02=text))
    changed = load_dataset(
        datasets.write(tmp_path / "changed", two + "# a remark\n", run_01=text, run_02=other)
    )
    assert here.sha256 == there.sha256
    assert len({here.sha256, swapped.sha256, changed.sha256}) == 3


def test_no_file_is_overwritten_by_saving(tmp_path):
    dataset = load_dataset(datasets.write(tmp_path / "a"))
    before = (tmp_path / "a" / "rig.toml").read_bytes()
    with pytest.raises(UserError, match="exists already"):
        save_dataset(dataset, tmp_path / "a")
    assert (tmp_path / "a" / "rig.toml").read_bytes() == before


def test_a_comment_heads_the_saved_rig(tmp_path):
    dataset = load_dataset(datasets.write(tmp_path / "a"))
    save_dataset(dataset, tmp_path / "b", "where it comes from\nand why")
    text = (tmp_path / "b" / "rig.toml").read_text()
    assert text.startswith("# where it comes from\n# and why\n")
    assert load_dataset(tmp_path / "b").assumed == dataset.assumed


def test_a_run_of_uneven_channels_is_a_bug_of_the_caller():
    with pytest.raises(ValueError, match="friction has the shape"):
        Run(
            file="a",
            time=np.arange(4.0),
            displacement=np.arange(4.0),
            friction=np.arange(3.0),
            rig=KnownRig(1.0, 1.0, 1.0, 0.0, 0.0),
        )


def positive(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False)


rigs = st.builds(
    KnownRig,
    mass=positive(1e-3, 1e3),
    stiffness=positive(1e-2, 1e6),
    drive_stiffness=positive(1e2, 1e6),
    damping=positive(0, 1e3),
    drive_damping=positive(0, 1e3),
    friction_against=st.sampled_from(["ground", "base"]),
)
constants = st.builds(
    AssumedConstants, *(st.none() | positive(0, 1e6) for _ in range(4)), k1=st.none() | positive(1e-3, 1e9)
)
noises = st.builds(Noise, *(st.none() | positive(1e-12, 1.0) for _ in range(5)))
names = st.text(st.characters(categories=["L", "N", "P", "S", "Zs"]), min_size=1, max_size=20).filter(
    str.strip
)


@st.composite
def runs(draw, number: int, rig: KnownRig, assumed: AssumedConstants) -> Run:
    """A run of odd numbers that the checks against wrong units let pass."""
    samples = draw(st.integers(64, 90))
    frequency = draw(positive(0.01, 100.0))
    amplitude = draw(positive(1e-5, 1.0))
    interval = 1 / (frequency * draw(positive(31, 33)))
    time = draw(positive(-10, 10)) * interval + interval * np.arange(samples)
    wobble = np.random.default_rng(draw(st.integers(0, 2**32))).normal(size=(4, samples))
    phase = draw(positive(-7, 7))
    sine = np.sin(2 * np.pi * frequency * time + phase) + 0.01 * wobble[0]
    against = 1 if rig.friction_against == "base" else -1
    cosine = np.cos(2 * np.pi * frequency * time + phase)
    gain = draw(positive(0.1, 1.0)) * min(rig.drive_stiffness / rig.stiffness, 1.0)
    changed = draw(st.sampled_from([{}, {"C": 3.25}, {"A": 0.1, "k1": 77.7}]))
    return Run(
        file=f"{draw(st.sampled_from(['', 'deep/']))}run-{number:02d}.csv",
        time=time,
        displacement=gain * amplitude * sine,
        base=draw(st.sampled_from([None, amplitude * sine])),
        friction=draw(
            st.sampled_from([None, rig.stiffness * gain * amplitude * (0.1 * wobble[1] + against * cosine)])
        ),
        force=draw(st.sampled_from([None, wobble[2], np.zeros(samples)])),
        frequency=frequency,
        base_amplitude=amplitude,
        base_phase=phase,
        hold_out=number > 1 and draw(st.booleans()),
        rig=replace(rig, mass=draw(st.sampled_from([rig.mass, 0.5]))),
        assumed=replace(assumed, **changed),
    )


@st.composite
def data_sets(draw) -> DataSet:
    rig, assumed = draw(rigs), draw(constants)
    count = draw(st.integers(1, 3))
    return DataSet(
        name=draw(names),
        rig=rig,
        assumed=assumed,
        noise=draw(noises),
        runs=tuple(draw(runs(number, rig, assumed)) for number in range(1, count + 1)),
    )


@settings(max_examples=60, deadline=None)
@given(dataset=data_sets())
def test_saving_and_loading_changes_nothing(tmp_path_factory, dataset):
    folder: Path = tmp_path_factory.mktemp("round") / "trip"
    save_dataset(dataset, folder)
    again = load_dataset(folder)
    assert (again.name, again.rig, again.assumed, again.noise) == (
        dataset.name,
        dataset.rig,
        dataset.assumed,
        dataset.noise,
    )
    for old, new in zip(dataset.runs, again.runs, strict=True):
        np.testing.assert_allclose(new.time, old.time, rtol=1e-13, atol=1e-13 * np.abs(old.time).max())
        assert list(new.channels) == list(old.channels)
        for name, samples in old.channels.items():
            np.testing.assert_array_equal(new.channels[name], samples)
        for name in ("file", "frequency", "base_amplitude", "base_phase", "hold_out"):
            assert getattr(new, name) == getattr(old, name)
        assert asdict(new.rig) == asdict(old.rig)
        assert asdict(new.assumed) == asdict(old.assumed)
