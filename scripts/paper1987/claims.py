"""What the paper says against what its own equations give: every finding is computed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from jaxstick.sweep import sweep
from scripts.paper1987 import conditions
from scripts.paper1987.states import Curve, Response

PROMINENCE = 0.01
"""A local minimum counts where the curve rises by this share of its value on both sides."""

SAME = 0.01
"""Two changes of stops closer than this share of their frequency are at the same place."""

LOPSIDED = 1e-3
"""An even harmonic of this share of the first shows that a motion is not symmetric."""

NEAR = 0.03
"""A minimum falls on a change of stops where the two are at most this far apart, over the frequency."""

AGREES, DIFFERS, PARTLY, OPEN = "agrees", "differs", "partly", "cannot be checked"


@dataclass(frozen=True)
class Finding:
    """One claim of the paper, whether it comes out (AGREES, DIFFERS, PARTLY or OPEN), and what was found."""

    claim: str
    verdict: str
    found: str


def stops_at_the_ratios(responses: Sequence[Response]) -> Finding:
    """Two to ten stops a cycle at the five ratios of figures 7 and 8."""
    found = [response.stops for response in responses]
    agrees = found == list(conditions.STOPS)
    said = ", ".join(f"{response.stops:g} at {response.ratio:g}" for response in responses)
    return Finding(
        "Figures 7 and 8: two to ten stops a cycle as the frequency ratio falls from 0.326 to 0.046.",
        AGREES if agrees else DIFFERS,
        f"Stops a cycle: {said} (static friction {conditions.STATIC_FRICTION:.2f} N, dynamic over static "
        f"{conditions.FRICTION_RATIO:g}).",
    )


def odd_harmonics(response: Response) -> Finding:
    """The third and fifth lines are the largest of the higher ones."""
    relative = response.harmonics / response.harmonics[0]
    largest = sorted(np.argsort(-relative[1:])[:2] + 2)
    even = relative[1::2].max()
    return Finding(
        "Figure 6: of the higher harmonics of the displacement the third and the fifth matter most.",
        AGREES if largest == [3, 5] else DIFFERS,
        f"At f/fn = {response.ratio:g} the two largest are numbers {largest[0]} and {largest[1]}: the third "
        f"has {100 * relative[2]:.2f} % of the first, the fifth {100 * relative[4]:.2f} %, the seventh "
        f"{100 * relative[6]:.2f} %, and the largest even one {100 * even:.2g} %.",
    )


def transients(responses: Sequence[Response]) -> Finding:
    """The differences that the paper puts down to the transient."""
    worst = max(responses, key=lambda response: abs(response.early))
    return Finding(
        "Section 4: the little differences are due to the transient, amplitudes being read after 5 to 10 "
        "cycles.",
        AGREES if abs(worst.early) > 0.005 else DIFFERS,
        f"From rest, the seventh cycle's amplitude at the five ratios differs from the final one by at most "
        f"{100 * abs(worst.early):.1g} % (at {worst.ratio:g}); at ratios this low friction has swallowed the "
        "transient by then.",
    )


def border(curve: Curve, stops: int) -> float:
    """The highest frequency ratio at which there are at least so many stops, halfway to the next value; nan
    where the curve nowhere has so many or has them to its end."""
    there = np.flatnonzero(curve.stops >= stops)
    if len(there) == 0 or there[-1] == len(curve.ratios) - 1:
        return math.nan
    last = there[-1]
    return float((curve.ratios[last] + curve.ratios[last + 1]) / 2)


def minima(curve: Curve) -> NDArray[np.float64]:
    """The frequency ratios of the local minima that are at least 1 % deep."""
    finite = np.flatnonzero(np.isfinite(curve.amplitude))
    level = np.log(curve.amplitude[finite])
    found, _ = find_peaks(-level, prominence=PROMINENCE)
    return curve.ratios[finite[found]]


@dataclass(frozen=True)
class Change:
    """A change of the stop number along a curve: its stops below and above, its frequency ratio, the nearest
    local minimum (nan where the curve has none), and whether that is near enough to fall on the change."""

    below: int
    above: int
    place: float
    minimum: float
    meets: bool


def changes(curve: Curve) -> list[Change]:
    """The changes between even numbers of stops up to ten, from few stops to many."""
    low = minima(curve)
    found = []
    for stops in range(2, 11, 2):
        place = border(curve, stops)
        if math.isfinite(place):
            nearest = low[np.argmin(np.abs(np.log(low / place)))] if len(low) else math.nan
            meets = bool(abs(math.log(nearest / place)) < NEAR)
            found.append(Change(stops, stops - 2, place, float(nearest), meets))
    return found


def other_minima(curve: Curve) -> list[float]:
    """The local minima that fall on no change."""
    taken = np.array([change.place for change in changes(curve)])
    return [
        float(place)
        for place in minima(curve)
        if len(taken) == 0 or np.min(np.abs(np.log(taken / place))) >= NEAR
    ]


def minima_at_changes(curves: Sequence[Curve]) -> Finding:
    """Whether local minima of the amplitude and changes of the stop number coincide."""
    found = [change for curve in curves for change in changes(curve)]
    without: dict[str, int] = {}
    for change in found:
        if not change.meets:
            between = f"{change.below} to {change.above}"
            without[between] = without.get(between, 0) + 1
    elsewhere = sum(len(other_minima(curve)) for curve in curves)
    meeting = sum(change.meets for change in found)
    words = f"{meeting} of {len(found)} changes have a local minimum within 3 % of their frequency"
    if without:
        missing = ", ".join(f"{between} on {count} of the curves" for between, count in without.items())
        words += f"; none is at the change from {missing}"
    words += f". {elsewhere} minima at least 1 % deep fall on no change."
    return Finding(
        "Figures 9 and 10: one stopping region changes to another at a local minimum of the curve.",
        AGREES if not without and not elsewhere else PARTLY if meeting else DIFFERS,
        words,
    )


def odd_stops(curve: Curve, stiffer: Curve, factor: float) -> Finding:
    """Whether symmetric equations give odd numbers of stops; arguments as for `contact_ring`."""
    odd = [int(np.count_nonzero(each.stops % 2 == 1)) for each in (curve, stiffer)]
    lopsided = [int(np.count_nonzero(each.even > LOPSIDED)) for each in (curve, stiffer)]
    return Finding(
        "Figure 9: odd numbers of stops are due to some non-symmetrical conditions of the device.",
        PARTLY if odd[0] else OPEN,
        f"The equations are symmetric, yet {odd[0]} of {len(curve.ratios)} states ({curve.label}) have an "
        f"odd number, and in {lopsided[0]} an even harmonic of the displacement exceeds {100 * LOPSIDED:g} % "
        "of the first: such a state is not its own mirror image but one of a pair. With a contact "
        f"{factor:g} times as stiff it is {odd[1]} and {lopsided[1]}. The device may add its own asymmetry.",
    )


def contact_ring(curve: Curve, stiffer: Curve, factor: float) -> Finding:
    """Whether minima that fall on no change come from the ring of the contact spring.

    curve: with the paper's k1; stiffer: the same with `factor` times as stiff a contact.
    """
    before, after = other_minima(curve), other_minima(stiffer)
    lost = [int(np.count_nonzero(~np.isfinite(each.stops))) for each in (curve, stiffer)]
    said = ", ".join(f"{place:.3f}" for place in before) or "none"
    return Finding(
        "Figure 10: an other reason for the oscillation of the lowest curve is the transient.",
        DIFFERS if len(after) < len(before) else OPEN,
        f"Curves without any transient oscillate all the same ({curve.label}: minima on no change at {said}; "
        f"{lost[0]} of {len(curve.ratios)} states without a period). With a contact {factor:g} times as "
        f"stiff {len(after)} such minima and {lost[1]} such states are left: where they vanish it is the "
        "undamped contact spring, whose ring decides how the mass leaves a stop.",
    )


def clearness(curves: Sequence[Curve], below: float = 0.15) -> Finding:
    """Whether the stop regions are harder to tell at a low ratio of dynamic to static friction.

    A clear sequence of regions changes its stop number, from many to few, as often as there are even numbers
    in it; every further change is a flicker.
    """
    flickers = []
    for curve in curves:
        stops = curve.stops[curve.ratios < below]
        key = np.where(np.isfinite(stops), stops, -1.0)
        ladder = (key[0] - key[-1]) / 2 if min(key[0], key[-1]) >= 0 else 0
        flickers.append(max(int(np.count_nonzero(np.diff(key)) - max(ladder, 0)), 0))
    said = ", ".join(f"{count} ({curve.label})" for count, curve in zip(flickers, curves, strict=True))
    clearer = flickers[0] > flickers[-1]
    return Finding(
        "Figure 10: for a low friction ratio and low frequencies the stopping regions are hard to determine.",
        AGREES if clearer else DIFFERS,
        f"Changes of the stop number below f/fn = {below:g} beyond the steps from region to region: {said}.",
    )


def shift(claim: str, curves: Sequence[Curve], what: str, upwards: bool = True) -> Finding:
    """Which way the borders of the stop regions move from the first of the curves to the last."""
    said, directions = [], []
    for stops in range(2, 11, 2):
        places = [border(curve, stops) for curve in curves]
        known = [place for place in places if math.isfinite(place)]
        if len(known) < 2:
            continue
        way = _way(np.diff(np.log(known)))
        directions.append(way)
        said.append(f"{stops} to {stops - 2} goes {way} ({', '.join(f'{place:.3f}' for place in known)})")
    wanted = "up" if upwards else "down"
    agreeing = directions.count(wanted)
    verdict = AGREES if agreeing == len(directions) else PARTLY if agreeing else DIFFERS
    return Finding(claim, verdict, f"{what}: the change from {'; '.join(said)}.")


def _way(steps: NDArray[np.float64]) -> str:
    """Where a sequence with these steps goes; a step below SAME is none."""
    steps = steps[np.abs(steps) >= SAME]
    if len(steps) == 0:
        return "nowhere"
    return "up" if np.all(steps > 0) else "down" if np.all(steps < 0) else "both ways"


def drives_within_reach() -> Finding:
    """Whether the exciter could do the drives of figure 9."""
    strokes = [2 * conditions.base_amplitude(*drive) for drive in conditions.DRIVES]
    beyond = [stroke for stroke in strokes if stroke > conditions.LARGEST_STROKE]
    said = ", ".join(f"{1e3 * stroke:.1f}" for stroke in strokes)
    end = "; the last is beyond the exciter, so one of these numbers is not what it seems" if beyond else ""
    return Finding(
        "Section 3 and figure 9: the exciter reaches 30 mm peak to peak; y0/x_static is 2.63, 3.51, 4.90 "
        "with mu = 0.376, 0.320, 0.487.",
        DIFFERS if beyond else AGREES,
        f"With x_static fixed by the middle drive the three strokes are {said} mm peak to peak{end}.",
    )


def static_deflection() -> Finding:
    """Which force makes y0/x_static 3.51."""
    share = conditions.STATIC_DEFLECTION_SHARE
    return Finding(
        "Figure 10: 20.65 mm peak to peak is y0/x_static = 3.51 at mu = 0.320.",
        OPEN,
        f"This holds where x_static is {share:.2f} of the static friction force over K, that is the dynamic "
        f"force over K for F_dynamic/F_static = {share:.2f}; with the static force it would be "
        f"{conditions.BASE_OVER_STATIC * share:.2f}. The paper does not define x_static.",
    )


@dataclass(frozen=True)
class StopsRow:
    """The stops a cycle at the five ratios under one assumption."""

    assumption: str
    stops: tuple[float, ...]
    agrees: bool


def stops_by_friction_ratio(ratios: Sequence[float]) -> list[StopsRow]:
    """The stops at the five ratios for several F_dynamic/F_static, which the paper does not state."""
    found = sweep(
        conditions.rig(),
        conditions.constants(),
        ratios=conditions.RATIOS,
        amplitudes=conditions.BASE_AMPLITUDE,
        friction_ratio=ratios,
    )
    table = np.reshape(found["stops"], (len(ratios), len(conditions.RATIOS)))
    return [_row(f"F_dynamic/F_static = {ratio:g}", row) for ratio, row in zip(ratios, table, strict=True)]


def stops_by_reading() -> list[StopsRow]:
    """The stops at the five ratios for each way to read the springs of Table 1."""
    rows = []
    for reading in conditions.READINGS:
        rig = conditions.rig(reading)
        found = sweep(
            rig, conditions.constants(), ratios=conditions.RATIOS, amplitudes=conditions.BASE_AMPLITUDE
        )
        rows.append(_row(f"{reading.words}: {rig.natural_frequency:.2f} Hz", found["stops"]))
    return rows


def _row(assumption: str, stops: NDArray[np.float64]) -> StopsRow:
    values = tuple(float(number) for number in stops)
    return StopsRow(assumption, values, values == conditions.STOPS)
