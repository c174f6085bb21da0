"""CSV files of every dialect give the same numbers, in blocks of any size."""

import itertools
import sys
import tracemalloc
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxstick.errors import UserError
from jaxstick.formats import lines
from jaxstick.formats.table import read_table
from jaxstick.formats.units import column_quantity
from tests.jaxstick import datasets


def everything(names: Sequence[str]) -> dict[str, int]:
    return {name: position for position, name in enumerate(names) if name != "remark"}


numbers = st.floats(-1e6, 1e6, allow_nan=False).map(lambda value: float(f"{value:.9g}"))


@settings(max_examples=150, deadline=None)
@given(
    rows=st.lists(st.tuples(numbers, numbers), min_size=1, max_size=30),
    separator=st.sampled_from([",", ";", "\t", " ; ", ", "]),
    comma=st.booleans(),
    style=st.sampled_from(["{!r}", "{:.9g}", "{:+.12e}", '"{!r}"']),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
    mark=st.sampled_from([b"", b"\xef\xbb\xbf"]),
    head=st.sampled_from(["", "# made by {}\n", "\n  \n#\n"]),
    tail=st.sampled_from(["", "\n", "\n\n \n", "# end\n", ";;;\n"]),
    remark=st.sampled_from([None, "ok", "\u00b5-stop", '"a;b, c"']),
    block=st.sampled_from([4, 7, 64, 1 << 21]),
)
def test_every_dialect_gives_the_same_numbers(
    tmp_path_factory, rows, separator, comma, style, end, mark, head, tail, remark, block
):
    comma = comma and separator.strip(" ") != ","
    tail = tail.replace(";", separator.strip(" ") or "\t")
    cells = [[style.format(value) for value in row] for row in rows]
    if comma:
        cells = [[cell.replace(".", ",") for cell in row] for row in cells]
    table = [
        ["x", "y"] + ["remark"] * (remark is not None),
        *([*row, *([remark] if remark else [])] for row in cells),
    ]
    text = head + "".join(separator.join(row) + "\n" for row in table) + tail
    path = tmp_path_factory.mktemp("table") / "a.csv"
    path.write_bytes(mark + text.replace("\n", end).encode())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lines, "BLOCK_BYTES", block)
        found = read_table(path, everything)
    np.testing.assert_array_equal(np.stack([found.columns["x"], found.columns["y"]], axis=1), rows)
    first = text.count("\n", 0, text.index("x")) + 2
    np.testing.assert_array_equal(found.lines, first + np.arange(len(rows)))


def test_a_line_may_not_fill_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(lines, "BLOCK_BYTES", 16)
    monkeypatch.setattr(lines, "MAX_LINE_BYTES", 64)
    path = tmp_path / "a.csv"
    path.write_text("x,y\n1,2\n" + "3" * 200 + ",4\n")
    with pytest.raises(UserError, match=r"line 3: the line is longer than 64 bytes"):
        read_table(path, everything)


def test_lines_are_counted_across_blocks(tmp_path, monkeypatch):
    monkeypatch.setattr(lines, "BLOCK_BYTES", 16)
    path = tmp_path / "a.csv"
    path.write_bytes(b"# head\r\n\r\nx;y\r\n" + b"1;2\r\n\r\n# c\r\n" * 40 + b"1;oops\r\n")
    with pytest.raises(UserError, match=r"line 124, column y: 'oops' is not a number"):
        read_table(path, everything)


def test_lines_are_counted_in_files_of_old_macs(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes(b"x,y\r1,2\r3,4\r5,six\r7,8\r")
    with pytest.raises(UserError, match=r"line 4, column y: 'six' is not a number"):
        read_table(path, everything)


def test_a_cut_is_seen_across_blocks(tmp_path, monkeypatch):
    path = tmp_path / "a.csv"
    whole = "x,y\n" + "1.5,2.125\n" * 40
    for size in (8, 1 << 21):
        monkeypatch.setattr(lines, "BLOCK_BYTES", size)
        path.write_text(whole + "1.5,2.12")
        with pytest.raises(UserError, match=r"line 42: the file seems cut off inside its last number"):
            read_table(path, everything)
        path.write_text(whole + "1.5,2.125")
        assert len(read_table(path, everything).lines) == 41


def test_what_is_not_chosen_is_not_parsed(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("x,remark,y\n1,nan,2\n3,,4\n")
    assert read_table(path, everything).columns["y"].tolist() == [2.0, 4.0]


def test_memory_beside_the_arrays_is_bounded(tmp_path):
    path = tmp_path / "a.csv"
    row = ",".join(["0.123456789012345678"] * 6) + "\n"
    path.write_text("a,b,c,d,e,f\n" + row * 60_000)
    size = path.stat().st_size
    tracemalloc.start()
    try:
        table = read_table(path, lambda names: {"a": 0})
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(table.lines) == 60_000
    assert size > 7e6
    # One block of 2 MB as text, as lines and as cells; reading the file whole would take some 50 MB more.
    assert peak < 25e6


@pytest.mark.parametrize(
    ("header", "quantity", "factor"),
    [
        ("time_ms", "time", 1e-3),
        (" Displacement_MM ", "displacement", 1e-3),
        ("base_\u00b5m", "base", 1e-6),
        ("base_\u03bcm", "base", 1e-6),
        ("friction_N", "friction", 1.0),
        ("force_kn", "force", 1e3),
        ("velocity_mm_per_s", "velocity", 1e-3),
        ("velocity_furlong_per_s", "velocity", None),
        ("displacement", "displacement", None),
        ("force_lbf", "force", None),
    ],
)
def test_a_header_is_a_quantity_and_a_unit(header, quantity, factor):
    column = column_quantity(header)
    assert column is not None
    assert (column.quantity, column.factor) == (quantity, factor)


@pytest.mark.parametrize(
    "header", ["timestamp", "temperature_c", "force_table_temp_c", "", "basement_m", "m"]
)
def test_other_headers_are_no_channels(header):
    assert column_quantity(header) is None


def test_work_grows_with_the_rows_and_no_faster(tmp_path):
    """Calls of Python functions, fifty times as many rows; what does not depend on them is small."""
    header, body = datasets.csv_text(datasets.record(samples=2000)).split("\n", 1)

    def calls(times: int) -> int:
        path = tmp_path / f"{times}.csv"
        path.write_text(header + "\n" + body * times)
        count = itertools.count()
        sys.setprofile(lambda *_: next(count))
        try:
            lines = read_table(path, everything).lines
        finally:
            sys.setprofile(None)
        assert len(lines) == 2000 * times
        return next(count)

    assert calls(50) < 1.1 * 50 * calls(1)
