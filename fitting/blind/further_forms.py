"""Third forms of effects on friction, mechanics and channels (B2), beside those of the other files."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from fitting.blind.filters import lag, resonance
from fitting.blind.formulation import Formulation, RunFacts, Shape, Signals, between, no_shape
from fitting.blind.friction_effects import FRICTION, breathing, sine_track, with_early
from fitting.blind.measurement_effects import MEASUREMENT
from fitting.blind.mechanics_effects import MECHANICS
from fitting.blind.physics import Elements, Physics

STAGES = 4
"""RC stages of an amplifier, one after another."""


def _distance(p: Physics, time: float, shape: Shape, run: RunFacts) -> Physics:
    """The law sees a speed that follows |w| over a distance slid: s' = |w| (|w| - s)/(time speed)."""
    return replace(p, memory=time, memory_of_speed=1.0, memory_length=time * shape["speed"])


def _saturating(p: Physics, growth: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + growth (1 - exp(-age/time))), the age as in the catalogue's formula."""
    return replace(p, dwell=growth, dwell_end=shape["time"], dwell_slip=shape["distance"])


def _worn_end(p: Physics, slope: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + slope L tanh((s - middle)/L)): another level on one end of the track."""
    return replace(p, track=slope, track_length=shape["length"], track_middle=shape["middle"])


def _uneven_track(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """A ripple that is no sine: with a second harmonic of two fifths."""
    return replace(sine_track(p, share, shape, run), waviness_second=0.4)


def _lifting_load(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """A load with a second harmonic of a third."""
    return replace(breathing(p, share, shape, run), load_second=0.35)


def _ever_slower(p: Physics, rate: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + rate sqrt(t T)), T the run's duration."""
    return replace(p, drift=rate, drift_root=run.duration)


def _lorentzian(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """A [(1 - share) exp(-B |w|) + share/(1 + (B w)^2)]."""
    return replace(p, lorentzian=share)


def _wetted(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """+ share (A + C) sqrt(|w|/speed): a film that thickens with the speed."""
    return replace(p, rate_root=share * (p.A + p.C) / np.sqrt(shape["speed"]))


def _whole_spectrum(elements: Elements, share: float, shape: Shape) -> Elements:
    """Iwan: a share of the contact yields bit by bit all the way to the limit."""
    fractions = (0.15, 0.35, 0.6, 0.85)
    return with_early(elements, (share / len(fractions),) * len(fractions), fractions)


def _geometric(p: Physics, k3: float, shape: Shape, run: RunFacts) -> Physics:
    """- 6 k3 L^3 (sinh(x/L) - x/L): k3 x^3 at first, then ever steeper."""
    return replace(p, cubic=k3, cubic_arc=shape["length"])


def _one_stop(p: Physics, stiffness: float, shape: Shape, run: RunFacts) -> Physics:
    """A spring beyond x = gap, none on the other side."""
    return replace(p, stop=stiffness, stop_place=shape["gap"], stop_one_sided=1.0)


def _cubic_drag(p: Physics, c2: float, shape: Shape, run: RunFacts) -> Physics:
    """- c2 v^3/V."""
    return replace(p, drag=c2, drag_power=2.0, drag_speed=shape["speed"])


def _two_branches(p: Physics, stiffness: float, shape: Shape, run: RunFacts) -> Physics:
    """Two Maxwell branches, more than a decade apart."""
    half, time = stiffness / 2.0, shape["time"]
    return replace(p, branch_1=half, branch_2=half, branch_time_1=0.15 * time, branch_time_2=3.0 * time)


def _slack(p: Physics, gap: float, shape: Shape, run: RunFacts) -> Physics:
    """The drive's spring is slack while the mass is no more than `gap` from the base."""
    return replace(p, backlash=2.0 * gap, backlash_slack=1.0)


def _four_stages(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    """Four equal RC stages, a delay of `time` together."""
    for _ in range(STAGES):
        signals.friction = lag(signals.friction, signals.step, time / STAGES)


def _bent(signals: Signals, cut: float, shape: Shape, run: RunFacts) -> None:
    """The share `cut` passes level tanh(f/level)."""
    soft = shape["level"] * np.tanh(signals.friction / shape["level"])
    signals.friction = signals.friction + cut * (soft - signals.friction)


def _rectified_hum(signals: Signals, force: float, shape: Shape, run: RunFacts) -> None:
    """With half as much at twice the frequency, and a phase of its own in every run."""
    turn = 2.0 * np.pi * shape["frequency"] * signals.time + shape["phase"] + 1.7 * run.index
    signals.friction = signals.friction + force * (np.sin(turn) + 0.5 * np.sin(2.0 * turn + 1.0))


def _filtered_displacement(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    """Butterworth of second order, a delay of `time` for slow changes."""
    damping = np.sqrt(0.5)
    frequency = 2.0 * damping / (2.0 * np.pi * time)
    signals.displacement = resonance(signals.displacement, signals.step, frequency, damping)


def _creeping_zero(signals: Signals, rate: float, shape: Shape, run: RunFacts) -> None:
    """A zero that moves with the root of time."""
    signals.friction = signals.friction + rate * np.sqrt(np.maximum(signals.time, 0.0) * run.duration)


_SECOND = {one.key: one for one in (*FRICTION, *MECHANICS, *MEASUREMENT) if one.version == "B"}


def _third(key: str, **otherwise: Any) -> Formulation:
    """The second form of an effect with something else in it: of the same strength where nothing is said."""
    return replace(_SECOND[key], version="B2", **otherwise)


FURTHER = (
    _third(
        "frictional_memory",
        shape=lambda s, random: {"speed": s.speed}, shape_units={"speed": "m/s"}, physics=_distance,
    ),
    _third(
        "dwell_strengthening", typical=lambda s: 0.06, most=lambda s: 0.5,
        shape=lambda s, random: {
            "time": s.period * between(random, 0.1, 1.0),
            "distance": s.stroke * between(random, 0.01, 0.05),
        },
        shape_units={"time": "s", "distance": "m"}, physics=_saturating,
    ),
    _third(
        "position_dependent_friction",
        shape=lambda s, random: {
            "length": s.reach * between(random, 0.3, 0.8),
            "middle": s.reach * float(random.uniform(-0.4, 0.4)),
        },
        shape_units={"length": "m", "middle": "m"}, physics=_worn_end,
    ),
    _third("periodic_track", physics=_uneven_track),
    _third("load_variation", physics=_lifting_load),
    _third("friction_drift", most=lambda s: 0.6 / s.duration, physics=_ever_slower),
    _third("stribeck_shape", physics=_lorentzian),
    _third(
        "velocity_strengthening", strength="share", unit="1",
        typical=lambda s: 0.1, most=lambda s: 0.8,
        shape=lambda s, random: {"speed": s.speed}, shape_units={"speed": "m/s"}, physics=_wetted,
    ),
    _third("microslip", shape=no_shape, elements=_whole_spectrum),
    _third(
        "cubic_stiffness",
        shape=lambda s, random: {"length": s.reach * between(random, 0.4, 0.8)}, physics=_geometric,
    ),
    _third(
        "end_stop",
        shape=lambda s, random: {"gap": s.reach * float(random.uniform(0.3, 0.7))}, physics=_one_stop,
    ),
    _third("quadratic_drag", physics=_cubic_drag),
    _third("spring_relaxation", physics=_two_branches),
    _third("drive_backlash", physics=_slack),
    _third("force_lowpass", chain=_four_stages),
    _third("force_clipping", chain=_bent),
    _third("mains_hum", chain=_rectified_hum),
    _third("displacement_delay", chain=_filtered_displacement),
    _third("force_drift", chain=_creeping_zero),
)  # fmt: skip
"""Nineteen of them."""
