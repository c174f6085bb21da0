"""Sweeps: the periodic states of one rig over frequency, base amplitude and the constants of its friction."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np
from numpy.typing import ArrayLike, NDArray

from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.hypothesis import Hypothesis
from jaxstick.laps import Laps
from jaxstick.nominal import nominal
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import find
from jaxstick.parameter import replace as with_values
from jaxstick.parts.contact import AbstractContact, LoadedContact, PaperContact, SmoothContact
from jaxstick.parts.drive import SineDrive
from jaxstick.precision import float64
from jaxstick.record import CONSTANTS, AssumedConstants, KnownRig
from jaxstick.sensitivity import Direction, Sensitivity, sensitivities
from jaxstick.steady import PeriodicStates, ordered_multipliers, periodic_states
from jaxstick.steady_outcome import SteadyOutcomes, steady_outcomes

Columns = dict[str, NDArray[Any]]
"""One numpy array a quantity, its first axis that of the lanes."""

CONTACTS: dict[str, Callable[[float], AbstractContact]] = {
    "loaded": LoadedContact,
    "paper": PaperContact,
    "smooth": SmoothContact,
}

LANES_AT_ONCE = 4096

FREQUENCY, AMPLITUDE = "drive.frequency", "drive.base_amplitude"
PLACES = {"A": "friction.A", "B": "friction.B", "C": "friction.C", "D": "friction.D", "k1": "contact.k1"}
"""Where the constants stand in the nominal oscillator."""

UNITS = {"A": "A_n", "B": "B_s_per_m", "C": "C_n", "D": "D_n_s_per_m", "k1": "k1_n_per_m"}
"""The columns of the constants."""

FAINT = 1e-7
"""A harmonic below this share of the first has no amplitude or phase to speak of, and no derivative."""


@dataclass(frozen=True, eq=False)
class Points:
    """The lanes of a sweep: what they share, and by name the values in which they differ.

    hypothesis: the oscillator with its effects, all values plain numbers; values: by the parameter's name in
    its nominal oscillator ("drive.frequency", "friction.A"), shape (lanes,). `len(points)` is the number of
    lanes and `points[first:last]` some of them; both are plain data that can be pickled.
    """

    hypothesis: Hypothesis
    values: Mapping[str, NDArray[np.float64]]

    def __len__(self) -> int:
        return len(next(iter(self.values.values())))

    def __getitem__(self, lanes: slice | NDArray[np.int64]) -> Points:
        return Points(self.hypothesis, {name: value[lanes] for name, value in self.values.items()})


@float64
def grid(
    rig: KnownRig,
    constants: AssumedConstants,
    *,
    ratios: ArrayLike,
    amplitudes: ArrayLike,
    A: ArrayLike | None = None,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    k1: ArrayLike | None = None,
    friction_ratio: ArrayLike | None = None,
    level: ArrayLike | None = None,
    effects: Mapping[str, AbstractEffect] | None = None,
    contact: str = "loaded",
) -> Points:
    """All combinations of the given values as lanes, the frequency ratio running fastest, then the amplitude.

    ratios: excitation over sqrt(K/m); amplitudes: of the base [m]; A [N], B [s/m], C [N], D [N s/m],
    k1 [N/m]: one or several values each in place of the one in `constants`; friction_ratio: dynamic over
    static friction C/(A + C), and level: A + C [N], either or both in place of A and C. contact: "loaded",
    "paper" or "smooth".

    Raises UserError for values that are missing, not finite, not positive where they must be, or given twice.
    """
    if contact not in CONTACTS:
        raise UserError(f"There is no contact called {contact!r}; there are {', '.join(CONTACTS)}.")
    if not rig.stiffness > 0:
        raise UserError("A rig without springs has no natural frequency, so there are no frequency ratios.")
    axes = {
        name: _axis(name, given, positive)
        for name, given, positive in (
            ("k1", k1, True),
            ("level", level, True),
            ("friction_ratio", friction_ratio, False),
            ("D", D, False),
            ("C", C, False),
            ("B", B, False),
            ("A", A, False),
            ("amplitudes", amplitudes, True),
            ("ratios", ratios, True),
        )
        if given is not None
    }
    by_level = [name for name in ("friction_ratio", "level") if name in axes]
    clash = [name for name in ("A", "C") if name in axes]
    if by_level and clash:
        raise UserError(f"{by_level[0]} and {clash[0]} cannot both be given: each says what {clash[0]} is.")
    if "friction_ratio" in axes and np.any(axes["friction_ratio"] > 1):
        raise UserError("friction_ratio is dynamic over static friction and must not exceed 1.")
    mesh = np.meshgrid(*axes.values(), indexing="ij")
    values = {name: np.ascontiguousarray(part.ravel()) for name, part in zip(axes, mesh, strict=True)}
    assumed = replace(constants, **_friction_of(values, constants, bool(by_level)))
    lanes = {
        FREQUENCY: values.pop("ratios") * rig.natural_frequency,
        AMPLITUDE: values.pop("amplitudes"),
        **{PLACES[name]: value for name, value in values.items()},
    }
    base = nominal(rig, assumed, SineDrive(0.0, 0.0))
    oscillator = replace(base, contact=CONTACTS[contact](float(assumed.k1 or 0.0)))
    return Points(Hypothesis(oscillator, dict(effects or {})), lanes)


def _axis(name: str, given: ArrayLike, positive: bool) -> NDArray[np.float64]:
    try:
        values = np.atleast_1d(np.asarray(given, np.float64)).ravel()
    except (TypeError, ValueError):
        raise UserError(f"{name} must be numbers, not {given!r}.") from None
    if not len(values):
        raise UserError(f"{name} has no values.")
    wrong = ~np.isfinite(values) | (values <= 0 if positive else values < 0)
    if wrong.any():
        bound = "positive" if positive else "not negative"
        raise UserError(f"{name} must be finite and {bound}; {values[wrong][0]:g} is not.")
    return values


def _friction_of(
    values: dict[str, NDArray[np.float64]], constants: AssumedConstants, by_level: bool
) -> dict[str, float]:
    """Turns level and friction_ratio in `values` into A and C; any one value of each for what is assumed."""
    if by_level:
        assumed = (constants.A, constants.C)
        if None in assumed and not {"level", "friction_ratio"} <= values.keys():
            raise UserError("friction_ratio or level alone needs A and C under [assumed] for the other.")
        dry, dynamic = (value or 0.0 for value in assumed)
        level = values.pop("level", np.asarray(dry + dynamic))
        ratio = values.pop("friction_ratio", np.asarray(dynamic / (dry + dynamic) if dry + dynamic else 1.0))
        lanes = values["ratios"].shape
        values["A"] = np.broadcast_to(level * (1 - ratio), lanes).copy()
        values["C"] = np.broadcast_to(level * ratio, lanes).copy()
    return {name: float(values[name][0]) for name in CONSTANTS if name in values}


@float64
def compute(points: Points, *, derivatives: Sequence[str] = ()) -> Columns:
    """The periodic states of these lanes and what they amount to; what is computed for a lane does not depend
    on which other lanes are there.

    Columns, shape (lanes,) where nothing else is said: frequency_ratio, frequency_hz, base_amplitude_m, A_n,
    B_s_per_m, C_n, D_n_s_per_m, k1_n_per_m (as computed with); amplitude_m, half of peak to peak;
    amplitude_ratio, that over the base amplitude; stops, per drive cycle; stick_fraction; period, in drive
    cycles, 0: not periodic; residual, how far the motion is from closing after a period, in strokes;
    harmonics (lanes, 9), amplitudes of the displacement's first nine harmonics [m], and harmonic_phases
    [rad]; phase_rad, by how much the first harmonic leads the base; transmissibility, first harmonic over
    base amplitude; friction_work_j, viscous_work_j and their sum energy_per_cycle_j, dissipated per drive
    cycle; multiplier, the largest modulus of the Floquet multipliers (to about 0.05 as the search leaves it;
    exact where derivatives are asked for), nan where the motion is not periodic.

    derivatives: names among A, B, C, D, k1. For each of them and each smooth outcome o there is a column
    `d_o_d_name` of the shape of o's; nan where the lane has no stable periodic state, and for harmonics that
    are not there.

    Raises UserError for a derivative with respect to anything else.
    """
    unknown = [name for name in derivatives if name not in PLACES]
    if unknown:
        raise UserError(f"There are derivatives with respect to {', '.join(PLACES)}, not {unknown[0]!r}.")
    lanes = _lanes(points)
    frequency = _of(lanes.nominal, FREQUENCY)
    base = _of(lanes.nominal, AMPLITUDE)
    stiffness, mass = _of(lanes.nominal, "rig.stiffness"), _of(lanes.nominal, "rig.mass")
    laps = Laps(_oscillators(lanes), 1 / frequency)
    states = periodic_states(laps)
    found = steady_outcomes(laps, states)
    columns = {
        "frequency_ratio": frequency * 2 * math.pi / np.sqrt(stiffness / mass),
        "frequency_hz": frequency,
        "base_amplitude_m": base,
        **{UNITS[name]: _of(lanes.nominal, place) for name, place in PLACES.items()},
        **_outcomes(found, base),
        "stops": found.stops,
        "stick_fraction": found.stick_fraction,
        "period": states.period,
        "residual": states.residual,
        "multiplier": np.abs(states.multipliers[:, 0]),
    }
    if derivatives:
        directions = [_direction(lanes, PLACES[name]) for name in derivatives]
        slopes = sensitivities(laps, states, directions)
        columns["multiplier"] = np.abs(ordered_multipliers(slopes.monodromy, states.period)[:, 0])
        for number, name in enumerate(derivatives):
            columns |= _slopes(name, number, slopes, found, base, states)
    return columns


def _lanes(points: Points) -> Hypothesis:
    """The hypothesis with a leading axis of lanes on every leaf."""
    count = len(points)
    values = {f"nominal.{name}": value for name, value in points.values.items()}
    swept = with_values(points.hypothesis, values)

    def over_lanes(leaf: Any) -> NDArray[np.float64]:
        value = np.asarray(leaf, np.float64)
        return np.broadcast_to(value, (count,)).copy() if value.ndim == 0 else value

    return jax.tree.map(over_lanes, swept)


def _of(module: Oscillator, place: str) -> NDArray[np.float64]:
    return np.asarray(find(module, place).of(module), np.float64)


def _oscillators(lanes: Hypothesis) -> Oscillator:
    return jax.vmap(lambda hypothesis: hypothesis.oscillator())(lanes)


def _direction(lanes: Hypothesis, place: str) -> Direction:
    """The direction in which one parameter of the nominal oscillator grows."""
    still = jax.tree.map(np.zeros_like, lanes)
    one = np.ones_like(_of(lanes.nominal, place))
    rates = with_values(still, {f"nominal.{place}": one})
    moving = jax.jvp(_oscillators, (lanes,), (rates,))[1]
    frequency = _of(lanes.nominal, FREQUENCY)
    return Direction(moving, -_of(rates.nominal, FREQUENCY) / frequency**2)


def _outcomes(found: SteadyOutcomes, base: NDArray[np.float64]) -> Columns:
    """The smooth outcomes."""
    return {
        "amplitude_m": found.amplitude,
        "amplitude_ratio": found.amplitude / base,
        "transmissibility": found.harmonics[:, 0] / base,
        "phase_rad": found.phases[:, 0],
        "harmonics": found.harmonics,
        "harmonic_phases": found.phases,
        "friction_work_j": found.friction_work,
        "viscous_work_j": found.viscous_work,
        "energy_per_cycle_j": found.friction_work + found.viscous_work,
    }


def _slopes(
    name: str,
    number: int,
    slopes: Sensitivity,
    found: SteadyOutcomes,
    base: NDArray[np.float64],
    states: PeriodicStates,
) -> Columns:
    """The derivatives of the smooth outcomes with respect to one constant."""
    rates = jax.tree.map(lambda leaf: np.asarray(leaf)[:, number], slopes.amounts)
    there = found.harmonics > FAINT * found.harmonics[:, :1]
    size = np.where(there, found.harmonics, np.nan)
    cosines, sines = np.sin(found.phases), np.cos(found.phases)
    moved = SteadyOutcomes(
        amplitude=rates.amplitude,
        harmonics=np.where(there, cosines * rates.cosines + sines * rates.sines, np.nan),
        phases=(sines * rates.cosines - cosines * rates.sines) / size,
        stops=found.stops,
        stick_fraction=found.stick_fraction,
        friction_work=rates.friction_work,
        viscous_work=rates.viscous_work,
    )
    columns = {}
    for outcome, values in _outcomes(moved, base).items():
        lost = (states.period == 0).reshape(-1, *[1] * (values.ndim - 1))
        columns[f"d_{outcome}_d_{name}"] = np.where(lost, np.nan, values)
    return columns


@dataclass(frozen=True, eq=False)
class Sweep:
    """The result of a sweep: columns as `compute` describes them, read-only."""

    columns: Mapping[str, NDArray[Any]]

    def __post_init__(self) -> None:
        for column in self.columns.values():
            column.flags.writeable = False

    def __len__(self) -> int:
        return len(self.columns["frequency_ratio"])

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.columns[name]


def lane_records(columns: Mapping[str, NDArray[Any]]) -> list[dict[str, Any]]:
    """The columns lane by lane, as the entries of `lanes` in sweep.json: plain numbers, None for a period 0
    and for what is not finite, derivatives under `derivatives`: {name: {outcome: value}}."""
    plain = {name: column.tolist() for name, column in columns.items() if not name.startswith("d_")}
    slopes = [(*_split(name), column.tolist()) for name, column in columns.items() if name.startswith("d_")]
    records = []
    for lane in range(len(columns["period"])):
        record = {name: _plain(column[lane]) for name, column in plain.items()}
        record["period"] = record["period"] or None
        if record["stops"] == round(record["stops"]):
            record["stops"] = round(record["stops"])
        if slopes:
            found: dict[str, dict[str, Any]] = {}
            for outcome, name, column in slopes:
                found.setdefault(name, {})[outcome] = _plain(column[lane])
            record["derivatives"] = found
        records.append(record)
    return records


def _split(column: str) -> tuple[str, str]:
    """Outcome and constant of a column `d_outcome_d_constant`."""
    outcome, _, name = column.removeprefix("d_").rpartition("_d_")
    return outcome, name


def _plain(value: Any) -> Any:
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    return value if math.isfinite(value) else None


def sweep(
    rig: KnownRig,
    constants: AssumedConstants,
    *,
    ratios: ArrayLike,
    amplitudes: ArrayLike,
    derivatives: Sequence[str] = (),
    lanes_at_once: int = LANES_AT_ONCE,
    progress: Callable[[int, int], None] | None = None,
    **others: Any,
) -> Sweep:
    """The periodic states over a grid of lanes; `others` as in `grid`, the columns as in `compute`.

    Lanes are computed `lanes_at_once` at a time, so memory does not grow with their number but for the
    columns; `progress` is called with the number of lanes done and of all lanes.
    """
    points = grid(rig, constants, ratios=ratios, amplitudes=amplitudes, **others)
    chunks = []
    for first in _starts(len(points), lanes_at_once):
        chunks.append(compute(points[first : first + lanes_at_once], derivatives=derivatives))
        if progress is not None:
            progress(min(first + lanes_at_once, len(points)), len(points))
    return Sweep({name: np.concatenate([chunk[name] for chunk in chunks]) for name in chunks[0]})


def _starts(lanes: int, at_once: int) -> Iterator[int]:
    return itertools.takewhile(lambda first: first < lanes, itertools.count(0, at_once))
