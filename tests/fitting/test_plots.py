"""The figures of a fit: what they show, in which units, and that matplotlib's own state is left alone."""

from __future__ import annotations

import dataclasses
import json

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from fitting.plots.descent import descent
from fitting.plots.friction_law import friction_law
from fitting.plots.gallery import draw_fit
from fitting.plots.loops import loops
from fitting.plots.residuals import residuals
from fitting.plots.traces import traces
from fitting.progress import Silent
from jaxstick.output import OutputFolder
from jaxstick.plots.style import length_unit, span, thinned
from tests.fitting.tiny import ASSUMED

FIGURES = {
    "traces": lambda fit: traces(fit.traces[0]),
    "loops": lambda fit: loops(fit.traces),
    "friction law": friction_law,
    "residuals": lambda fit: residuals(fit.traces[0], fit.gaps),
    "search": descent,
}


def line(figure: Figure, label: str, panel: int = 0) -> np.ndarray:
    """The points of the line with this label, shape (2, points)."""
    (found,) = [line for line in figure.axes[panel].get_lines() if line.get_label() == label]
    return np.array(found.get_data(), float)


UNITS = {"displacement x [": "mm]", "velocity v [": "mm/s]", "friction force F [": "N]", "time [": "s]"}


@pytest.mark.parametrize("name", FIGURES)
def test_axes_say_what_and_in_which_unit(name, fitted):
    figure = FIGURES[name](fitted)
    figure.canvas.draw()
    assert len(figure.axes) >= 2
    for axes in figure.axes:
        labels = axes.get_xlabel(), axes.get_ylabel()
        assert any(labels)
        for label in labels:
            for beginning, end in UNITS.items():
                assert not label.startswith(beginning) or label == beginning + end


def test_traces_show_the_last_two_cycles_in_mm(fitted):
    trace = fitted.traces[0]
    figure = traces(trace)
    shown = line(figure, "fitted in pieces")
    assert shown[0, -1] == trace.run.time[-1]
    assert np.ptp(shown[0]) == pytest.approx(2 / 1.5, abs=0.01)
    np.testing.assert_allclose(shown[1], 1e3 * trace.displacement[-shown.shape[1] :])
    np.testing.assert_allclose(line(figure, "free run", 1)[1], trace.free_friction[-shown.shape[1] :])


def test_pieces_with_less_weight_are_shaded(fitted):
    trace = fitted.traces[0]
    bare = len(traces(trace).axes[0].patches)
    marked = dataclasses.replace(trace, excluded=np.arange(len(trace.excluded)) == len(trace.excluded) - 1)
    assert len(traces(marked).axes[0].patches) == bare + 1


def test_both_laws_are_drawn_over_the_measured_points(fitted):
    figure = friction_law(fitted)
    speed, force = line(figure, "assumed law")
    v = speed * 1e-3
    a, b, c, d = (getattr(ASSUMED, name) for name in "ABCD")
    law = a * np.exp(-b * np.abs(v)) + c + d * np.abs(v)
    np.testing.assert_allclose(np.abs(force), law, rtol=1e-12)
    assert np.all(force * v <= 0)
    identified = line(figure, "identified law")
    assert np.abs(identified[1]).max() == pytest.approx(7.47, abs=0.05)
    assert line(figure, "measured").shape[1] == sum(len(trace.run.time) for trace in fitted.traces)


def test_without_assumed_constants_only_the_identified_law_is_drawn(fitted):
    bare = tuple(dataclasses.replace(constant, assumed=None) for constant in fitted.constants)
    labels = [
        line.get_label() for line in friction_law(dataclasses.replace(fitted, constants=bare)).axes[0].lines
    ]
    assert "identified law" in labels and "assumed law" not in labels


def test_runs_without_friction_force_are_drawn_without_it(fitted):
    trace = fitted.traces[0]
    silent = dataclasses.replace(trace, run=dataclasses.replace(trace.run, friction=None))
    gaps = tuple(gap for gap in fitted.gaps if gap.channel == "displacement")
    assert len(residuals(silent, gaps).axes) == 3
    assert [line.get_label() for line in traces(silent).axes[1].lines] == ["free run", "fitted in pieces"]
    assert [line.get_label() for line in loops((silent,)).axes[0].lines] == ["fitted"]
    points = line(friction_law(dataclasses.replace(fitted, traces=(silent,))), "fitted (no force measured)")
    np.testing.assert_array_equal(points[1], trace.friction)


def test_residuals_of_long_records_keep_their_extremes(fitted):
    trace = fitted.traces[0]
    long = np.arange(20000) * trace.run.interval
    random = np.random.default_rng(0)
    left = 1e-5 * random.standard_normal(len(long))
    left[12345] = 2e-4
    run = dataclasses.replace(trace.run, time=long, displacement=left, friction=None, base=None)
    figure = residuals(dataclasses.replace(trace, run=run, displacement=np.zeros_like(left)), fitted.gaps)
    drawn = figure.axes[0].collections[0].get_datalim(figure.axes[0].transData)
    assert drawn.y1 == pytest.approx(200.0, rel=0.02)


def test_the_search_is_drawn_best_first(fitted):
    axes = descent(fitted).axes[0]
    ends = [float(np.asarray(line.get_ydata())[-1]) for line in axes.get_lines()]
    assert ends == sorted(ends) and len(ends) == fitted.descent.shape[1]


def test_all_figures_are_saved_and_matplotlib_is_left_alone(fitted, tmp_path):
    with OutputFolder(tmp_path / "out") as output:
        draw_fit(fitted, output, Silent())
    own, untouched = dict(matplotlib.rcParams), dict(matplotlib.rcParamsOrig)
    assert all(own[name] == untouched[name] for name in untouched if name != "backend")
    names = json.loads((tmp_path / "out" / ".jaxstick").read_text())["files"]
    runs = ("run-01", "more/run-02")
    assert set(names) == {
        f"plots/{name}.png"
        for name in (
            "friction-law",
            "loops",
            "search",
            *(f"{run}-{kind}" for run in runs for kind in ("traces", "residuals")),
        )
    }


@pytest.mark.parametrize(
    ("size", "factor", "unit"),
    [(0.7, 1.0, "m"), (0.01, 1e3, "mm"), (2e-5, 1e6, "µm"), (1e-8, 1e9, "nm"), (0.0, 1e9, "nm")],
)
def test_lengths_in_a_readable_unit(size, factor, unit):
    assert length_unit(size) == (factor, unit)


def test_thinning_and_spans():
    assert len(range(10000)[thinned(10000, 4000)]) == 3334
    assert len(range(100)[thinned(100, 4000)]) == 100
    assert span(np.array([1.0, -3.0, np.nan])) == 3.0 and span(np.array([np.nan])) == 0.0
