"""Third forms of effects on friction, mechanics and channels (B2), beside those of the other files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fitting.blind.filters import lag, resonance
from fitting.blind.formulation import Formulation, RunFacts, Shape, Signals, angle, between
from fitting.blind.measurement_effects import LONGEST
from fitting.blind.physics import Elements, Physics
from fitting.blind.scales import Scales

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
    number = 2.0 * np.pi / shape["wavelength"]
    return replace(
        p, waviness=share, waviness_number=number, waviness_phase=shape["phase"], waviness_second=0.4
    )


def _waves(scales: Scales, random: np.random.Generator) -> Shape:
    return {"wavelength": scales.stroke * between(random, 0.1, 0.6), "phase": angle(random)}


def _lifting_load(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """A load with a second harmonic of a third."""
    return replace(p, load=share, load_phase=shape["phase"], load_second=0.35)


def _ever_slower(p: Physics, rate: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + rate sqrt(t T)), T the run's duration."""
    return replace(p, drift=rate, drift_root=run.duration)


def _lorentzian(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """A [(1 - share) exp(-B |w|) + share/(1 + (B w)^2)]."""
    return replace(p, lorentzian=share)


def _whole_spectrum(elements: Elements, share: float, shape: Shape) -> Elements:
    """Iwan: a share of the contact yields bit by bit all the way to the limit."""
    fractions = (0.15, 0.35, 0.6, 0.85)
    taken = share * float(np.mean(fractions))
    return Elements(
        tuple(k * (1.0 - share) for k in elements.stiffness) + (share / len(fractions),) * len(fractions),
        tuple(g * (1.0 - taken) for g in elements.limit)
        + tuple(share / len(fractions) * fraction for fraction in fractions),
    )


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


FURTHER = (
    Formulation(
        key="frictional_memory", version="B2", strength="time", unit="s", signed=False,
        typical=lambda s: 0.01 * s.period, most=lambda s: 0.2 * s.period,
        shape=lambda s, random: {"speed": s.speed}, shape_units={"speed": "m/s"}, physics=_distance,
    ),
    Formulation(
        key="dwell_strengthening", version="B2", strength="growth", unit="1", signed=False,
        typical=lambda s: 0.06, most=lambda s: 0.5,
        shape=lambda s, random: {
            "time": s.period * between(random, 0.1, 1.0),
            "distance": s.stroke * between(random, 0.01, 0.05),
        },
        shape_units={"time": "s", "distance": "m"}, physics=_saturating,
    ),
    Formulation(
        key="position_dependent_friction", version="B2", strength="gradient", unit="1/m",
        typical=lambda s: 0.05 / s.reach, most=lambda s: 0.6 / s.reach,
        shape=lambda s, random: {
            "length": s.reach * between(random, 0.3, 0.8),
            "middle": s.reach * float(random.uniform(-0.4, 0.4)),
        },
        shape_units={"length": "m", "middle": "m"}, physics=_worn_end,
    ),
    Formulation(
        key="periodic_track", version="B2", strength="share", unit="1", signed=False,
        typical=lambda s: 0.03, most=lambda s: 0.4, shape=_waves,
        shape_units={"wavelength": "m", "phase": "rad"}, physics=_uneven_track,
    ),
    Formulation(
        key="load_variation", version="B2", strength="share", unit="1", signed=False,
        typical=lambda s: 0.03, most=lambda s: 0.4,
        shape=lambda s, random: {"phase": angle(random)}, shape_units={"phase": "rad"},
        physics=_lifting_load,
    ),
    Formulation(
        key="friction_drift", version="B2", strength="rate", unit="1/s",
        typical=lambda s: 0.05 / s.duration, most=lambda s: 0.6 / s.duration, physics=_ever_slower,
    ),
    Formulation(
        key="stribeck_shape", version="B2", strength="share", unit="1", signed=False,
        typical=lambda s: 0.3, most=lambda s: 1.0, physics=_lorentzian,
    ),
    Formulation(
        key="microslip", version="B2", strength="share", unit="1", signed=False,
        typical=lambda s: 0.1, most=lambda s: 0.7, elements=_whole_spectrum,
    ),
    Formulation(
        key="cubic_stiffness", version="B2", strength="coefficient", unit="N/m^3",
        typical=lambda s: 0.03 * s.stiffness / s.reach**2, most=lambda s: 0.2 * s.stiffness / s.reach**2,
        shape=lambda s, random: {"length": s.reach * between(random, 0.4, 0.8)},
        shape_units={"length": "m"}, physics=_geometric,
    ),
    Formulation(
        key="end_stop", version="B2", strength="stiffness", unit="N/m", signed=False,
        typical=lambda s: 0.1 * s.stiffness, most=lambda s: 4.0 * s.stiffness,
        shape=lambda s, random: {"gap": s.reach * float(random.uniform(0.3, 0.7))},
        shape_units={"gap": "m"}, physics=_one_stop,
    ),
    Formulation(
        key="quadratic_drag", version="B2", strength="coefficient", unit="N s^2/m^2", signed=False,
        typical=lambda s: 0.3 * s.damping / s.haste, most=lambda s: 6.0 * s.damping / s.haste,
        shape=lambda s, random: {"speed": s.haste}, shape_units={"speed": "m/s"}, physics=_cubic_drag,
    ),
    Formulation(
        key="spring_relaxation", version="B2", strength="stiffness", unit="N/m", signed=False,
        typical=lambda s: 0.03 * s.stiffness, most=lambda s: 0.5 * s.stiffness,
        shape=lambda s, random: {"time": s.period * between(random, 0.2, 0.8)},
        shape_units={"time": "s"}, physics=_two_branches,
    ),
    Formulation(
        key="drive_backlash", version="B2", strength="gap", unit="m", signed=False,
        typical=lambda s: 0.015 * s.base, most=lambda s: 0.3 * s.base, physics=_slack,
    ),
    Formulation(
        key="force_lowpass", version="B2", strength="time", unit="s", signed=False,
        typical=lambda s: 0.01 * s.period, most=lambda s: min(0.3 * s.period, LONGEST), chain=_four_stages,
    ),
    Formulation(
        key="force_clipping", version="B2", strength="cut", unit="1", signed=False,
        typical=lambda s: 0.5, most=lambda s: 1.0,
        shape=lambda s, random: {"level": s.force * float(random.uniform(0.6, 0.95))},
        shape_units={"level": "N"}, chain=_bent,
    ),
    Formulation(
        key="mains_hum", version="B2", strength="force", unit="N", signed=False,
        typical=lambda s: 0.01 * s.force, most=lambda s: 0.4 * s.force,
        shape=lambda s, random: {
            "frequency": float(random.choice([50.0, 60.0])), "phase": angle(random)
        },
        shape_units={"frequency": "Hz", "phase": "rad"}, chain=_rectified_hum,
    ),
    Formulation(
        key="displacement_delay", version="B2", strength="time", unit="s", signed=False,
        typical=lambda s: 0.005 * s.period, most=lambda s: min(0.1 * s.period, LONGEST),
        chain=_filtered_displacement,
    ),
    Formulation(
        key="force_drift", version="B2", strength="rate", unit="N/s",
        typical=lambda s: 0.03 * s.force / s.duration, most=lambda s: 0.8 * s.force / s.duration,
        chain=_creeping_zero,
    ),
)  # fmt: skip
"""Eighteen of them."""
