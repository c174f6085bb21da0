"""The figures of a diagnosis: what they show and in which units."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from fitting.plots.before_after import before_after, worst_window
from fitting.plots.diagnosis_gallery import draw_diagnosis, frequencies, worst_first, worst_residual_run
from fitting.plots.probabilities import probabilities
from fitting.plots.residual_force import residual_force
from fitting.progress import Silent
from jaxstick.output import OutputFolder
from tests.fitting.diagnosis.fabricated import FREQUENCIES, TRUTH, nothing_found, silent


def test_the_window_is_where_the_nominal_model_misses_most(diagnosis):
    trace = diagnosis.traces[0]
    quiet = dataclasses.replace(
        trace, before_displacement=trace.displacement.copy(), before_friction=np.array(trace.friction)
    )
    quiet.before_displacement[700:720] += 1e-3
    window = worst_window(quiet, FREQUENCIES[0] * 8)
    assert window.start <= 700 and window.stop >= 720
    assert window.stop - window.start == round(2 / (8 * FREQUENCIES[0]) * 250) + 1
    assert worst_window(trace, 0.01) == slice(0, len(trace.time))
    assert worst_window(dataclasses.replace(quiet, friction=None), None).stop - 1000 >= 0


def test_before_and_after_in_readable_units(diagnosis):
    trace = worst_first(diagnosis)[0]
    figure = before_after(trace, FREQUENCIES[3])
    axes = figure.axes[0]
    lines = {line.get_label(): np.asarray(line.get_ydata(), float) for line in axes.get_lines()}
    shown = worst_window(trace, FREQUENCIES[3])
    np.testing.assert_allclose(lines["with the effect"], 1e3 * trace.after_displacement[shown])
    np.testing.assert_allclose(lines["nominal, fitted"], 1e3 * trace.before_displacement[shown])
    assert axes.get_ylabel() == "displacement x [mm]" and axes.get_xlabel() == "time [s]"
    assert figure.axes[3].get_ylabel() == "F, measured - model [N]"
    band = figure.axes[3].patches[0].get_extents().transformed(figure.axes[3].transData.inverted())
    assert band.y1 == pytest.approx(2 * 0.03) and band.y0 == pytest.approx(-band.y1)


def test_a_model_without_effect_is_drawn_once(diagnosis):
    trace = diagnosis.traces[0]
    same = dataclasses.replace(
        trace, after_displacement=trace.before_displacement, after_friction=trace.before_friction
    )
    labels = [line.get_label() for line in before_after(same, None).axes[0].get_lines()]
    assert labels == ["measured", "nominal, fitted"]
    mute = before_after(silent(diagnosis).traces[0], None)
    assert [line.get_label() for line in mute.axes[1].get_lines()] == ["nominal, fitted", "with the effect"]
    assert not mute.axes[3].get_visible()


def test_the_residual_force_shows_a_step_that_is_put_in(diagnosis):
    found = diagnosis.residual_force
    made = dataclasses.replace(found, force=np.where(found.slide_rate > 0, 0.2, -0.1))
    figure = residual_force(made, *worst_residual_run(diagnosis))
    lines = {line.get_label(): np.asarray(line.get_ydata(), float) for line in figure.axes[0].get_lines()}
    np.testing.assert_allclose(lines["forward"], 200.0)
    np.testing.assert_allclose(lines["backward"], -100.0)
    assert figure.axes[0].get_ylabel() == "residual force [mN]"
    low, high = figure.axes[0].get_ylim()
    assert low == -high and high > 200
    cells = figure.axes[2].collections[0]
    values = np.asarray(cells.get_array())
    corners = [path.vertices for path in cells.get_paths()]
    above = np.array([np.min(np.asarray(corner)[:, 1]) > 0 for corner in corners])
    assert above.any() and np.all(values[above] > 0)


def test_stretches_that_were_lost_are_left_out(diagnosis):
    found = diagnosis.residual_force
    gone = np.arange(len(found.force)) % 5 == 0
    made = dataclasses.replace(found, force=np.where(gone, np.nan, 0.2))
    figure = residual_force(made, *worst_residual_run(diagnosis))
    for axes in (figure.axes[0], figure.axes[1], figure.axes[3]):
        for line in axes.get_lines()[1:]:
            values = np.asarray(line.get_ydata(), float)
            np.testing.assert_allclose(values[values != 0], 200.0)
    figure.canvas.draw()
    nothing = dataclasses.replace(found, force=np.full(len(found.force), np.nan))
    residual_force(nothing, 0, "run-01.csv").canvas.draw()
    trace = diagnosis.traces[0]
    before = trace.before_displacement.copy()
    before[40:90] = np.nan
    before_after(dataclasses.replace(trace, before_displacement=before), FREQUENCIES[0]).canvas.draw()


def test_runs_are_ordered_by_their_share(diagnosis):
    assert [trace.file for trace in worst_first(diagnosis)][:2] == ["run-04.csv", "run-05.csv"]
    assert worst_residual_run(diagnosis) == (3, "run-04.csv")
    nowhere = dataclasses.replace(
        diagnosis, residual_force=dataclasses.replace(diagnosis.residual_force, run=np.empty(0, int))
    )
    assert worst_residual_run(nowhere) == (0, "")


def test_the_likeliest_is_on_top_and_in_colour(diagnosis):
    axes = probabilities(diagnosis).axes[0]
    assert axes.get_yticklabels()[0].get_text() == TRUTH
    widths = [bar.get_width() for bar in axes.patches]  # pyright: ignore[reportAttributeAccessIssue]
    assert widths[0] == 0.93 and widths == sorted(widths, reverse=True)
    colours = [bar.get_facecolor() for bar in axes.patches]
    assert colours[0] != colours[1] and len(set(colours[1:])) == 1
    clear = probabilities(nothing_found(diagnosis)).axes[0]
    assert clear.get_yticklabels()[0].get_text() == "none"
    assert clear.patches[0].get_facecolor() == colours[0]


def test_all_are_saved(diagnosis, dataset, tmp_path):
    found = frequencies(dataset)
    assert found["run-02.csv"] == pytest.approx(0.92, rel=1e-3)
    with OutputFolder(tmp_path / "out") as output:
        draw_diagnosis(diagnosis, dataset, output, Silent())
    names = set(json.loads((tmp_path / "out" / ".jaxstick").read_text())["files"])
    runs = {f"plots/run-{number:02d}-before-after.png" for number in range(1, 7)}
    assert names == runs | {"plots/probabilities.png", "plots/residual-force.png"}
