"""Words, tables and results on a terminal, and functions imported late."""

from __future__ import annotations

import json
import sys

import pytest

from jaxstick.deferred import deferred
from jaxstick.terminal import WIDE, Terminal, stops_text


def test_a_table_is_never_squeezed(capsys):
    long = "a" * (WIDE + 40)
    Terminal().table("Title", ("what", "two\nlines"), [(long, "1.5 mm"), ("[b]x[/b] :smile:", "-12")])
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == "Title"
    assert lines[1].endswith("two") and lines[2].endswith("lines")
    assert lines[4] == f"{long}  1.5 mm"
    assert lines[5].startswith("[b]x[/b] :smile:") and lines[5].endswith("   -12")


@pytest.mark.parametrize(
    ("json_wanted", "quiet"), [(False, False), (True, False), (False, True), (True, True)]
)
def test_where_words_and_results_go(json_wanted, quiet, capsys):
    terminal = Terminal(quiet, json_wanted)
    terminal.say("words")
    terminal.bullets(["more words"])
    terminal.result({"value": float("nan")})
    out, err = capsys.readouterr()
    assert (json.loads(out) == {"value": None}) if json_wanted else ("words" in out) is not quiet
    assert err == ("words\n  more words\n" if json_wanted and not quiet else "")


@pytest.mark.parametrize(("stops", "text"), [(None, "-"), (4.0, "4"), (3.96, "4"), (7.83, "7.8"), (0.0, "0")])
def test_stops_in_words(stops, text):
    assert stops_text(stops) == text


def test_a_deferred_function_is_imported_at_the_first_call(monkeypatch):
    monkeypatch.delitem(sys.modules, "colorsys", raising=False)
    convert = deferred("colorsys", "rgb_to_hsv")
    assert "colorsys" not in sys.modules and convert.name == "rgb_to_hsv"
    assert convert(1.0, g=0.0, b=0.0) == (0.0, 1.0, 1.0)
