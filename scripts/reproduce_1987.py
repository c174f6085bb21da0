"""The counterparts of figures 4 to 10 of the 1987 paper, as one HTML page of pictures and findings.

    python -m scripts.reproduce_1987 --out reproduction-1987.html [--points 400]

The figures themselves are lost; what the text, the captions and Table 1 say of them is set against what the
paper's equations give. What agrees and what does not is computed each time.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from jaxstick.output import atomic_write_text
from jaxstick.sweep import sweep
from scripts.paper1987 import claims, conditions, figures
from scripts.paper1987.page import Picture, Rows, Section, changes_table, page, stops_table
from scripts.paper1987.states import Curve, Response, curve, responses

FRICTION_RATIOS = (0.70, 0.78, 0.86, 0.94)
LEVELS = (0.75, 1.0, 1.25)
STIFFER = 10.0
TYPICAL = 0.190
LOWEST, HIGHEST = 0.04, 0.98


@click.command()
@click.option("--out", default="reproduction-1987.html", type=click.Path(path_type=Path), show_default=True)
@click.option("--points", default=400, type=click.IntRange(min=20), show_default=True, help="On a curve.")
def main(out: Path, points: int) -> None:
    """Write the page and print the findings."""
    text, findings = reproduce(points)
    atomic_write_text(out, text)
    for finding in findings:
        click.echo(f"{finding.verdict.upper()}: {finding.claim}\n    {finding.found}")
    click.echo(f"The page is {out}.")


def reproduce(points: int) -> tuple[str, list[claims.Finding]]:
    """The page, its curves of so many points each, and the findings on it."""
    rig = conditions.rig()
    motions = responses(rig, conditions.constants(), conditions.RATIOS, conditions.BASE_AMPLITUDE)
    typical = next(motion for motion in motions if motion.ratio == TYPICAL)
    ratios = np.geomspace(LOWEST, HIGHEST, points)
    drives = [_drive(drive, ratios) for drive in conditions.DRIVES]
    stiffer = _drive(conditions.DRIVES[1], ratios, STIFFER)
    held_dynamic = [_held_dynamic(ratio, ratios) for ratio in FRICTION_RATIOS]
    held_static = [_held_static(ratio, ratios) for ratio in FRICTION_RATIOS]
    levels = [_level(share, ratios) for share in LEVELS]

    traces = [claims.odd_harmonics(typical)]
    times = [claims.stops_at_the_ratios(motions), claims.transients(motions)]
    nine = [
        claims.minima_at_changes(drives),
        claims.shift(
            "Figure 9: a larger amplitude of the base moves the changes to higher frequency.",
            drives,
            f"With y0/x_static = {', '.join(f'{drive[0]:g}' for drive in conditions.DRIVES)}",
        ),
        claims.odd_stops(drives[1], stiffer, STIFFER),
        claims.drives_within_reach(),
    ]
    ten = [
        claims.minima_at_changes(held_dynamic),
        claims.clearness(held_dynamic),
        claims.contact_ring(drives[1], stiffer, STIFFER),
        claims.shift(
            "Figure 10: a larger ratio of dynamic to static friction moves the changes to higher frequency "
            "(y0/x_static, and so the dynamic force, held).",
            held_dynamic,
            f"With F_dynamic/F_static = {', '.join(map(str, FRICTION_RATIOS))}",
        ),
        claims.shift(
            "The same, with the static force held.",
            held_static,
            f"With F_dynamic/F_static = {', '.join(map(str, FRICTION_RATIOS))}",
        ),
        claims.shift(
            "More friction, at one ratio of dynamic to static, moves the changes to higher frequency.",
            levels,
            f"With {', '.join(f'{share * conditions.STATIC_FRICTION:.2f} N' for share in LEVELS)} static "
            "friction",
        ),
        claims.static_deflection(),
    ]
    sections = [
        _conditions(),
        Section("Figures 4 to 6: a typical record", [*_typical(typical), traces]),
        Section("Figures 7 and 8: time responses at the five ratios", [*_time_responses(motions), times]),
        Section("Figure 9: amplitude over frequency for the three drives", [*_figure_9(drives), nine]),
        Section(
            "Figure 10: amplitude over frequency for several friction ratios",
            [*_figure_10(held_dynamic, held_static, levels), ten],
        ),
        _accuracy(motions, [*drives, stiffer, *held_dynamic, *held_static, *levels]),
    ]
    title = "Stick-slip, Barcelona 1987: the paper's figures computed again"
    opening = [
        "The figures of the paper are lost; its equations, Table 1, captions and text remain. Below are "
        "counterparts of figures 4 to 10, computed from those equations alone with the loaded contact "
        "(the friction force is continuous from slip to stick). They can be set against what the text says, "
        "not against the recorded curves.",
    ]
    return page(title, opening, sections), [*traces, *times, *nine, *ten]


def _drive(drive: tuple[float, float], ratios: np.ndarray, stiffer: float = 1.0) -> Curve:
    over_static, mu = drive
    amplitude = conditions.base_amplitude(over_static, mu)
    label = f"y0/x_static = {over_static:g}, µ = {mu:g} ({2e3 * amplitude:.1f} mm peak to peak)"
    constants = conditions.constants(conditions.static_friction(mu), stiffer=stiffer)
    return curve(label, conditions.rig(), constants, ratios, amplitude)


def _held_dynamic(ratio: float, ratios: np.ndarray) -> Curve:
    static = conditions.STATIC_DEFLECTION_SHARE * conditions.STATIC_FRICTION / ratio
    label = f"F_dynamic/F_static = {ratio:g}"
    constants = conditions.constants(static, ratio)
    return curve(label, conditions.rig(), constants, ratios, conditions.BASE_AMPLITUDE)


def _held_static(ratio: float, ratios: np.ndarray) -> Curve:
    label = f"F_dynamic/F_static = {ratio:g}"
    constants = conditions.constants(ratio=ratio)
    return curve(label, conditions.rig(), constants, ratios, conditions.BASE_AMPLITUDE)


def _level(share: float, ratios: np.ndarray) -> Curve:
    static = share * conditions.STATIC_FRICTION
    label = f"F_static = {static:.2f} N"
    return curve(label, conditions.rig(), conditions.constants(static), ratios, conditions.BASE_AMPLITUDE)


def _conditions() -> Section:
    by_ratio = claims.stops_by_friction_ratio((0.70, 0.78, 0.80, 0.85, 0.86, 0.88, 0.90, 0.95))
    head = "stops a cycle at f/fn ="
    return Section(
        "What the paper leaves open or misprints",
        [
            "Table 1 prints “damping ratio 4.6 Hz”, which is the natural frequency again; the logarithmic "
            "decrement of 0.207 is a damping ratio of 0.0329 and is used here. It gives the stiffness of "
            "one spring as 1986 N/m, but 4.6 Hz is sqrt(1986/2.38)/(2π): 1986 N/m is the total. Equation (1) "
            "with 2k would vibrate at 6.5 Hz. Equations (1) and (4) have the signs of drive and spring the "
            "other way round. A + C is called a coefficient once and a force elsewhere; here it is µ m g.",
            stops_table(claims.stops_by_reading(), conditions.RATIOS, head),
            "The ratio of dynamic to static friction is not stated. The stops at the five ratios of figures "
            f"7 and 8 bound it; {conditions.FRICTION_RATIO:g} is used below where nothing else is said, with "
            f"µ = 0.320, that is {conditions.STATIC_FRICTION:.2f} N static friction.",
            stops_table(by_ratio, conditions.RATIOS, head),
        ],
    )


def _typical(typical: Response) -> list[Picture]:
    lost = "The paper does not say at which frequency; four stops are shown."
    return [
        Picture(
            figures.figure_4(typical), f"Counterpart of figure 4: mass displacement, base motion. {lost}"
        ),
        Picture(
            figures.figure_5(typical),
            "Counterpart of figure 5: mass velocity and friction force. The force is largest when the mass "
            "starts, as the paper says. The ring in stick is that of the undamped contact spring; the "
            "paper's records, through a low-pass filter and a damped contact, do not show it. The shift in "
            "time between figures 4 and 5 came from two analysers and is not reproduced.",
        ),
        Picture(
            figures.figure_6(typical),
            "Counterpart of figure 6: spectrum of the displacement, relative to the first line.",
        ),
    ]


def _time_responses(motions: list[Response]) -> list[Picture]:
    return [
        Picture(figures.time_responses(motions[:3]), "Counterpart of figure 7. Dashed: the base."),
        Picture(figures.time_responses(motions[3:]), "Counterpart of figure 8. Dashed: the base."),
    ]


def _figure_9(drives: list[Curve]) -> list[Picture | Rows]:
    return [
        Picture(
            figures.amplitude_curves(drives),
            "Counterpart of figure 9, which shows measured curves; these are computed. Numbers above the "
            "frames: stops a cycle in each region; crosses: no period found. The frames are cut at 2.5; the "
            "resonance goes on above.",
        ),
        changes_table(drives),
    ]


def _figure_10(
    held_dynamic: list[Curve], held_static: list[Curve], levels: list[Curve]
) -> list[Picture | Rows]:
    return [
        Picture(
            figures.amplitude_curves(held_dynamic),
            "Counterpart of figure 10: the drive and y0/x_static = 3.51 held, so the dynamic friction force "
            "is held and the static one changes.",
        ),
        changes_table(held_dynamic),
        Picture(
            figures.curves_together(held_dynamic),
            "The same curves in one frame; dots: where the number of stops changes.",
        ),
        Picture(figures.curves_together(held_static), "The other reading: the static friction force held."),
        Picture(
            figures.curves_together(levels),
            f"More or less friction at a ratio of {conditions.FRICTION_RATIO:g}.",
        ),
    ]


def _accuracy(motions: list[Response], curves: list[Curve]) -> Section:
    states = sum(len(each.ratios) for each in curves)
    residual = max(float(np.max(each.residual[np.isfinite(each.stops)], initial=0.0)) for each in curves)
    lost = sum(int(np.sum(~np.isfinite(each.stops))) for each in curves)
    found = sweep(
        conditions.rig(),
        conditions.constants(),
        ratios=conditions.RATIOS,
        amplitudes=conditions.BASE_AMPLITUDE,
    )
    heads = ("f/fn", "stops", "period in cycles", "residual", "multiplier", "amplitude", "marched", "closing")
    cells = tuple(
        (
            f"{motion.ratio:g}",
            f"{found['stops'][lane]:g}",
            f"{found['period'][lane]}" if found["period"][lane] else "none",
            f"{found['residual'][lane]:.0e}",
            f"{found['multiplier'][lane]:.2f}",
            f"{1e3 * found['amplitude_m'][lane]:.4f} mm",
            f"{1e3 * motion.amplitude:.4f} mm",
            f"{motion.change:.0e}",
        )
        for lane, motion in enumerate(motions)
    )
    return Section(
        "How far the numbers can be trusted",
        [
            f"The curves hold {states} states, each searched for as a periodic one; {lost} of them have no "
            f"period. The largest residual of the others is {residual:.1e} of the stroke, so no transient is "
            "in them.",
            "The traces are motions after 24 cycles from rest. Beside the periodic states at the five ratios "
            "their amplitudes, and how far the last cycle is from the one before it (over the amplitude). "
            "Where the two amplitudes differ, more than one state is stable at that frequency; where the "
            "period is more than one cycle, a cycle does not close.",
            Rows(heads, cells),
        ],
    )


if __name__ == "__main__":
    main()
