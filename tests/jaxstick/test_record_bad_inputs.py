"""Every mistake a user can make in a data set ends in one sentence that says where it is and what to do."""

import os
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxstick.check import describe
from jaxstick.errors import UserError
from jaxstick.record import load_dataset
from tests.jaxstick import datasets

CSV = datasets.standard_csv()
LINES = CSV.splitlines(keepends=True)


def refusal(folder: Path) -> str:
    """The sentence with which the folder is refused."""
    with pytest.raises(UserError) as caught:
        load_dataset(folder)
    message = str(caught.value)
    assert re.fullmatch(r"[^\n]+[.?]", message), message
    assert str(folder) in message
    return message


def assert_says(message: str, *pieces: str) -> None:
    for piece in pieces:
        assert piece in message, message


def edited(line: int, cell: int, text: str) -> str:
    """The standard CSV with one cell replaced; lines count from 1."""
    lines = list(LINES)
    cells = lines[line - 1].rstrip("\n").split(",")
    cells[cell] = text
    lines[line - 1] = ",".join(cells) + "\n"
    return "".join(lines)


def columns(**changes: np.ndarray | None) -> str:
    """The standard CSV with columns replaced, added, or (None) left out."""
    channels = datasets.record()
    table: dict[str, np.ndarray | None] = {
        "time_s": channels["time"],
        "base_m": channels["base"],
        "displacement_m": channels["displacement"],
        "friction_n": channels["friction"],
    } | changes
    return datasets.csv_text({name: samples for name, samples in table.items() if samples is not None})


CHANNELS = datasets.record()
TIME = CHANNELS["time"]

CSV_MISTAKES = {
    "empty file": ("", "the file is empty"),
    "header only": (LINES[0], "no samples"),
    "comments only": ("# nothing\n\n# here\n", "no header line"),
    "too few samples": ("".join(LINES[:20]), "19 samples", "at least 32"),
    "no header": ("".join(LINES[1:]), "line 1", "column names such as time_s"),
    "text": (edited(40, 2, "broken"), "line 40", "column displacement_m", "'broken' is not a number"),
    "nan": (edited(41, 3, "NaN"), "line 41", "column friction_n", "'NaN' is not a finite number"),
    "infinity": (edited(42, 1, "-inf"), "line 42", "column base_m", "'-inf' is not a finite number"),
    "too large": (edited(43, 1, "1e999"), "line 43", "'1e999' is not a finite number"),
    "absurd": (edited(43, 1, "1e300"), "column base_m", "values reach 1e+300"),
    "absurd time": (edited(129, 0, "1e300"), "column time_s", "values reach 1e+300"),
    "underscore": (edited(44, 1, "1_0"), "line 44", "'1_0' is not a number"),
    "other digits": (edited(44, 1, "\u0661"), "line 44", "is not a number"),
    "empty cell": (edited(45, 0, ""), "line 45", "column time_s", "empty"),
    "long nonsense": (edited(46, 2, "x\x07" * 5000), "line 46", "...'"),
    "few cells": (edited(47, 3, "1").replace(",1\n", "\n"), "line 47", "3 cells where the header has 4"),
    "many cells": (edited(48, 3, "1,2,3"), "line 48", "6 cells where the header has 4"),
    "decimal comma between commas": (CSV.replace(".", ","), "line 2", "8 cells", "need ; or a tab"),
    "mixed decimal marks": (edited(49, 2, '"0,5"'), "line 49", "column displacement_m", "decimal mark"),
    "open quote": (edited(50, 2, '"0.5'), "line 50", "quotation mark"),
    "cut between cells": (CSV[: CSV.rindex(",")], "line 129", "cut off", "3 of 4 cells"),
    "cut in a number": (
        columns(friction_n=None, base_m=None, base_mm=1e3 * CHANNELS["base"])[:-13],
        "line 129",
        "cut off",
    ),
    "cut after a separator": (CSV[: CSV.rindex(",") + 1], "line 129", "cut off"),
    "time goes back": (edited(60, 0, "0.5"), "line 60", "goes back"),
    "time stands still": (edited(60, 0, repr(float(TIME[57]))), "line 60", "stands still at 0.890625 s"),
    "time rounded away": (columns(time_s=np.round(TIME, 1)), "line 3", "stands still", "rounded"),
    "a gap": ("".join(LINES[:70] + LINES[90:]), "line 71", "samples are missing"),
    "two rates": (
        columns(time_s=np.where(TIME < 1, TIME, 1 + 2 * (TIME - 1))),
        "line 67",
        "the rate changed",
    ),
    "bursts": (edited(60, 0, repr(float(TIME[57]) + 1e-5)), "line 60", "1e-05 s where 0.01562 s is usual"),
    "no time": (columns(time_s=None), "no column time_s, time_ms or time_us among 'base_m'"),
    "no displacement": (columns(displacement_m=None), "no column displacement_m, displacement_mm"),
    "misspelt displacement": (
        CSV.replace("displacement_m", "displacment_m"),
        "no column displacement_m",
        "did you mean displacement_m for 'displacment_m'?",
    ),
    "unknown unit": (
        CSV.replace("friction_n", "friction_lbf"),
        "'friction_lbf'",
        "friction_n or friction_kn",
    ),
    "unknown rate unit": (columns(velocity_km_per_h=TIME), "'velocity_km_per_h'", "velocity_mm_per_s"),
    "no unit": (CSV.replace("base_m", "base"), "'base'", "does not say its unit", "base_mm"),
    "one quantity twice": (columns(displacement_mm=TIME), "displacement_m and displacement_mm", "keep one"),
    "one column twice": (CSV.replace("base_m", "friction_n"), "friction_n and friction_n", "keep one"),
    "dead channel": (columns(friction_n=0 * TIME + 3), "column friction_n", "never changes from 3"),
    "base in mm called m": (
        columns(base_m=1e3 * CHANNELS["base"]),
        "is 10 m where",
        "is it in mm (base_mm)?",
    ),
    "base in m called mm": (CSV.replace("base_m", "base_mm"), "column base_mm", "is it in m (base_m)?"),
    "base in um called mm": (
        columns(base_m=None, base_mm=1e6 * CHANNELS["base"]),
        "column base_mm",
        "is it in um (base_um)?",
    ),
    "wrong amplitude": (columns(base_m=6 * CHANNELS["base"]), "is 0.06 m where rig.toml says 0.01 m."),
    "displacement in mm called m": (
        columns(displacement_m=1e3 * CHANNELS["displacement"]),
        "moves by 7 m where the drive would push it by 0.01 m",
        "is it in mm (displacement_mm)?",
    ),
    "velocity in mm/s called m/s": (
        columns(velocity_m_per_s=1e3 * np.gradient(CHANNELS["displacement"], TIME)),
        "column velocity_m_per_s",
        "is it in mm_per_s (velocity_mm_per_s)?",
    ),
    "friction in N called kN": (CSV.replace("friction_n", "friction_kn"), "is it in n (friction_n)?"),
    "friction with the motion": (
        columns(friction_n=-CHANNELS["friction"]),
        "column friction_n",
        "opposes its motion",
        "sign",
    ),
    "time in ms called s": (columns(time_s=1e3 * TIME), "0.064 samples a cycle", "unit of time"),
    "time in s called ms": (CSV.replace("time_s", "time_ms"), "0.002 cycles", "unit of time"),
    "another frequency": (
        columns(base_m=0.01 * np.sin(2 * np.pi * 3 * TIME), friction_n=None),
        "moves at 3 Hz where rig.toml says 1 Hz",
    ),
}


@pytest.mark.parametrize("mistake", CSV_MISTAKES)
def test_a_mistake_in_a_csv_file(tmp_path, mistake):
    text, *pieces = CSV_MISTAKES[mistake]
    message = refusal(datasets.write(tmp_path / "data", run_01=text))
    assert_says(message, "run-01.csv", *pieces)


RIG = datasets.RIG
NOTHING = "frequency_hz = 1.0\nbase_amplitude_mm = 10.0\n"
NO_DRIVE = {"base_m": None, "friction_n": None}

RIG_MISTAKES = {
    "empty": ("", "rig.toml", "empty"),
    "no rig": (RIG[RIG.index("[assumed]") :], "no [rig] section"),
    "no mass": (RIG.replace("mass_kg = 2.38\n", ""), "[rig] lacks mass_kg"),
    "no stiffness": (RIG.replace("stiffness_n_per_m = 2000.0\n", ""), "[rig] lacks stiffness_n_per_m"),
    "no TOML": (RIG.replace("[assumed]", "[assumed"), "rig.toml", "not TOML", "line 6"),
    "key twice": (RIG.replace("A_n = 1.5", "A_n = 1.5\nA_n = 2"), "not TOML", "line 8"),
    "misspelt key": (RIG.replace("mass_kg", "mas_kg"), "line 2: [rig] mas_kg", "did you mean mass_kg?"),
    "misspelt section": (RIG.replace("[assumed]", "[asumed]"), "line 6: asumed", "did you mean assumed?"),
    "wrong case": (RIG.replace("k1_n", "K1_n"), "line 11: [assumed] K1_n_per_m", "did you mean k1_n_per_m?"),
    "misspelt run key": (
        RIG.replace("frequency_hz", "frequenz_hz"),
        "line 15: [run] frequenz_hz",
        "frequency_hz",
    ),
    "unknown unit": (RIG.replace("mass_kg", "mass_lb"), "line 2: [rig] mass_lb", "mass_kg or mass_g"),
    "misspelt key like another": (
        RIG.replace("log_decrement", "damping_rato"),
        "line 4: [rig] damping_rato has an unknown unit",
        "did you mean damping_ratio?",
    ),
    "no unit": (RIG.replace("mass_kg", "mass"), "line 2: [rig] mass does not say its unit", "mass_kg"),
    "one mass twice": (RIG.replace("[assumed]", "mass_g = 1\n[assumed]"), "line 6: [rig] mass_g", "mass_kg"),
    "two dampings": (
        RIG.replace("[assumed]", "damping_ratio = 0.1\n[assumed]"),
        "log_decrement",
        "damping_ratio",
    ),
    "text": (RIG.replace("= 2.38", '= "2.38"'), "line 2: [rig] mass_kg is the text '2.38'", "a number"),
    "truth": (RIG.replace("= 2.38", "= true"), "line 2: [rig] mass_kg is true", "a number"),
    "list": (RIG.replace("= 2.38", "= [1]"), "mass_kg is a list"),
    "date": (RIG.replace("= 2.38", "= 2020-01-01"), "mass_kg is a date"),
    "nan": (RIG.replace("= 2.38", "= nan"), "mass_kg is 'nan'", "finite"),
    "huge": (RIG.replace("= 2.38", "= 1" + "0" * 400), "mass_kg is", "finite"),
    "absurd": (RIG.replace("= 2.38", "= 1e300"), "mass_kg is '1e+300'", "finite"),
    "no mass at all": (RIG.replace("= 2.38", "= 0"), "mass_kg is 0", "greater than 0"),
    "negative mass": (RIG.replace("= 2.38", "= -2.38"), "mass_kg is -2.38", "not be negative"),
    "negative stiffness": (RIG.replace("= 2000.0", "= -1"), "stiffness_n_per_m is -1", "not be negative"),
    "negative damping": (RIG.replace("= 0.207", "= -0.2"), "log_decrement is -0.2", "not be negative"),
    "negative assumed": (RIG.replace("C_n = 5.0", "C_n = -5.0"), "line 9: [assumed] C_n is -5"),
    "no contact stiffness": (RIG.replace("= 100000.0", "= 0"), "k1_n_per_m is 0", "greater than 0"),
    "no noise": (RIG + "[noise]\nfriction_n = 0\n", "line 18: [noise] friction_n is 0"),
    "no spring and no force": (
        RIG.replace("= 2000.0", "= 0").replace("log_decrement = 0.207", "damping_n_s_per_m = 1"),
        "run-01.csv",
        "stiffness 0",
        "no column force_n",
    ),
    "no spring to take a ratio of": (RIG.replace("= 2000.0", "= 0"), "stiffness 0", "damping_n_s_per_m"),
    "unknown surface": (
        RIG.replace("[assumed]", 'friction_against = "air"\n[assumed]'),
        "'air'",
        '"ground" or "base"',
    ),
    "rig is no section": (
        "rig = 3\n" + RIG[RIG.index("[assumed]") :],
        "line 1: rig is the number 3",
        "[rig]",
    ),
    "run is one section": (RIG.replace("[[run]]", "[run]"), "line 13: run is not a list", "[[run]]"),
    "no runs": (RIG[: RIG.index("[[run]]")], "no run is listed"),
    "two runs of one file": (RIG + '[[run]]\nfile = "./run-01.csv"\n', "line 18: [run] file", "another run"),
    "two runs without a file": (RIG.replace('"run-01.csv"', '"run-02.csv"') + "[[run]]\n", "'run-02.csv'"),
    "no such file": (RIG.replace("run-01", "run-07"), "run-07.csv: there is no such file"),
    "file outside": (RIG.replace("run-01.csv", "../run-01.csv"), "line 14: [run] file is '../run-01.csv'"),
    "file from the root": (RIG.replace("run-01.csv", "/etc/passwd"), "'/etc/passwd'", "data set's folder"),
    "file is a number": (RIG.replace('"run-01.csv"', "3"), "file is the number 3", "a text"),
    "hold_out is a text": (
        RIG + 'hold_out = "no"\n',
        "line 17: [run] hold_out is the text 'no'",
        "true or false",
    ),
    "all held out": (RIG + "hold_out = true\n", "hold_out = true", "none is left to fit"),
    "override is a number": (
        RIG + "assumed = 3\n",
        "line 17: [run] assumed is the number 3",
        "like { C_n = 3.1 } is",
    ),
    "override misspelt": (RIG + "assumed = { c_n = 3 }\n", "line 17: [run.assumed] c_n", "did you mean C_n?"),
    "override out of range": (RIG + "[run.rig]\nmass_kg = -1\n", "line 18: [run.rig] mass_kg is -1"),
    "two lengths": (RIG + "cycles = 3\nduration_s = 1\n", "line 17: [run] cycles", "duration"),
    "frequency of zero": (RIG.replace("frequency_hz = 1.0", "frequency_hz = 0"), "frequency_hz is 0"),
    "frequency above the sampling": (
        RIG.replace("frequency_hz = 1.0", "frequency_hz = 20"),
        "3.2 samples a cycle",
    ),
}


@pytest.mark.parametrize("mistake", RIG_MISTAKES)
def test_a_mistake_in_rig_toml(tmp_path, mistake):
    text, *pieces = RIG_MISTAKES[mistake]
    message = refusal(datasets.write(tmp_path / "data", text))
    assert_says(message, *pieces)


DRIVES = {
    "nothing": (RIG.replace(NOTHING, ""), "says nothing of the drive"),
    "frequency alone": (
        RIG.replace("base_amplitude_mm = 10.0\n", ""),
        "has a frequency but no base amplitude",
    ),
    "amplitude alone": (RIG.replace("frequency_hz = 1.0\n", ""), "has a base amplitude but no frequency"),
}


@pytest.mark.parametrize("mistake", DRIVES)
def test_a_run_that_nothing_drives(tmp_path, mistake):
    text, piece = DRIVES[mistake]
    message = refusal(datasets.write(tmp_path / "data", text, run_01=columns(**NO_DRIVE)))
    assert_says(message, "run-01.csv", piece, "neither a base nor a force column")


def test_folders_that_are_none(tmp_path):
    assert_says(refusal(tmp_path / "nowhere"), "no such file or folder")
    assert_says(refusal(tmp_path), "holds no rig.toml")
    path = tmp_path / "file.csv"
    path.write_text("a")
    assert_says(refusal(path), "a data set is a folder")
    assert_says(refusal(tmp_path / ("x" * 5000)), "cannot be opened")


@pytest.mark.parametrize("name", ["run-01.csv", "rig.toml"])
def test_a_folder_where_a_file_should_be(tmp_path, name):
    folder = datasets.write(tmp_path / "data")
    (folder / name).unlink()
    (folder / name).mkdir()
    assert_says(refusal(folder), name, "a folder where a file is expected")


def test_a_pipe_is_not_waited_for(tmp_path):
    folder = datasets.write(tmp_path / "data")
    (folder / "run-01.csv").unlink()
    os.mkfifo(folder / "run-01.csv")
    assert_says(refusal(folder), "run-01.csv", "not an ordinary file")


@pytest.mark.parametrize("name", ["run-01.csv", "rig.toml"])
def test_a_huge_file_is_refused_unread(tmp_path, name):
    folder = datasets.write(tmp_path / "data")
    os.truncate(folder / name, 2_000_000_000)
    tracemalloc.start()
    try:
        message = refusal(folder)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 50e6
    assert_says(message, name, "2000 MB, more than the")


@pytest.mark.parametrize("name", ["run-01.csv", "rig.toml"])
def test_a_file_that_may_not_be_read(tmp_path, monkeypatch, name):
    folder = datasets.write(tmp_path / "data")
    ordinary = Path.open

    def refuse(path: Path, *arguments, **options):
        if path.name == name:
            raise PermissionError(13, "Permission denied", str(path))
        return ordinary(path, *arguments, **options)

    monkeypatch.setattr(Path, "open", refuse)
    assert_says(refusal(folder), name, "may not be read")


def test_a_folder_that_may_not_be_entered(tmp_path, monkeypatch):
    folder = datasets.write(tmp_path / "data")
    ordinary = Path.exists

    def refuse(path: Path, *arguments, **options):
        if path.name == "rig.toml":
            raise PermissionError(13, "Permission denied", str(path))
        return ordinary(path, *arguments, **options)

    monkeypatch.setattr(Path, "exists", refuse)
    assert_says(refusal(folder), "rig.toml", "cannot be opened (Permission denied)")


def test_a_disk_that_fails(tmp_path, monkeypatch):
    folder = datasets.write(tmp_path / "data")

    def fail(path: Path, *arguments, **options):
        raise OSError(5, "Input/output error", str(path))

    monkeypatch.setattr(Path, "open", fail)
    assert_says(refusal(folder), "rig.toml", "Input/output error")


BINARY = {
    "zeros": (CSV.encode()[:300] + b"\0" * 1000, "binary file"),
    "UTF-16": (CSV.encode("utf-16"), "UTF-16"),
    "Latin-1": (CSV.replace("\n", "\n# \u00b5m\n", 1).encode("latin-1"), "line 2", "0xb5", "UTF-8"),
    "one long line": (b"time_s" * 500_000, "line 1", "longer than"),
}


@pytest.mark.parametrize("kind", BINARY)
def test_a_csv_file_that_is_no_text(tmp_path, kind):
    data, *pieces = BINARY[kind]
    folder = datasets.write(tmp_path / "data")
    (folder / "run-01.csv").write_bytes(data)
    assert_says(refusal(folder), "run-01.csv", *pieces)


def test_a_rig_toml_that_is_no_text(tmp_path):
    folder = datasets.write(tmp_path / "data")
    (folder / "rig.toml").write_bytes(RIG.replace("[assumed]", "# \u00b5m").encode("latin-1"))
    assert_says(refusal(folder), "rig.toml", "line 6", "0xb5")


def test_values_nested_without_end(tmp_path):
    folder = datasets.write(tmp_path / "data", "name = " + "[" * 100_000)
    assert_says(refusal(folder), "rig.toml", "nested too deeply")


@settings(max_examples=150, deadline=None)
@given(data=st.data(), name=st.sampled_from(["run-01.csv", "rig.toml"]))
def test_a_damaged_file_is_read_or_refused_in_one_sentence(tmp_path_factory, data, name):
    """Bytes cut out, put in or overwritten anywhere never end in another exception, or in a warning."""
    folder = datasets.write(tmp_path_factory.mktemp("damaged") / "data")
    content = (folder / name).read_bytes()
    first, last = sorted(data.draw(st.integers(0, len(content))) for _ in range(2))
    last = data.draw(st.sampled_from([first, min(first + 1, len(content)), last]))
    pieces = st.sampled_from(
        [b"", b"\n", b",", b"-", b"e", b"9", b'"', b"[", b"=", b"#", b"\xff", b"0" * 30, b"e300"]
    )
    (folder / name).write_bytes(content[:first] + data.draw(pieces | st.binary(max_size=4)) + content[last:])
    try:
        assert describe(load_dataset(folder)).runs
    except UserError as refused:
        assert re.fullmatch(r"[^\n]+[.?]", str(refused))
