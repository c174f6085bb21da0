"""Effects that the catalogue does not know: the right answer to them is that none of it explains the gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fitting.blind.formulation import (
    Floats,
    Formulation,
    RunFacts,
    Shape,
    Signals,
    angle,
    between,
)
from fitting.blind.physics import Physics
from fitting.blind.scales import Scales


def _random(shape: Shape, run: RunFacts) -> np.random.Generator:
    return np.random.default_rng([int(shape["seed"]), run.index])


def _seed(random: np.random.Generator) -> float:
    return float(random.integers(2**31))


def _well(p: Physics, force: float, shape: Shape, run: RunFacts) -> Physics:
    """A magnet at one place of the track."""
    return replace(p, well=force, well_place=shape["place"], well_width=shape["width"])


def _pulsation(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """A stiffness that a rotating part modulates."""
    phase = shape["phase"] + 2.1 * run.index
    omega = 2.0 * np.pi * shape["frequency"]
    return replace(p, pulsation=share, pulsation_omega=omega, pulsation_phase=phase)


def _rider(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """A second degree of freedom: a lateral mode, as a small mass on a spring of its own."""
    mass, omega = share * p.mass, 2.0 * np.pi * shape["frequency"]
    return replace(
        p,
        rider_mass=mass,
        rider_stiffness=mass * omega**2,
        rider_damping=2.0 * shape["damping_ratio"] * mass * omega,
    )


def _bursts(series: Floats, time: Floats, share: float, shape: Shape, run: RunFacts) -> Floats:
    """Particles under the slider: now and then friction rises for a moment."""
    random = _random(shape, run)
    result = series.copy()
    for start in random.uniform(time[0], time[-1], random.poisson((time[-1] - time[0]) * shape["rate"])):
        length = shape["length"] * random.uniform(0.5, 1.5)
        result[(time >= start) & (time < start + length)] += share * random.uniform(0.5, 1.5)
    return result


def _rocking(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """Harmonics of the base that its sensor does not see."""
    return replace(
        p,
        second_harmonic=share,
        second_phase=shape["phase"],
        third_harmonic=0.6 * share,
        third_phase=2.0 * shape["phase"],
    )


def _held(signals: Signals, share: float, shape: Shape, run: RunFacts) -> None:
    """The converter of the force now and then repeats its last value for a while."""
    random = _random(shape, run)
    samples = signals.friction.copy()
    length = max(int(shape["length"] / signals.step), 1)
    for start in random.integers(0, len(samples), round(share * len(samples) / length)):
        samples[start : start + length] = samples[start]
    signals.friction = samples


def _bit_errors(signals: Signals, size: float, shape: Shape, run: RunFacts) -> None:
    """Single samples of the displacement off by a power of two of a converter's step."""
    random = _random(shape, run)
    index = np.flatnonzero(random.random(len(signals.time)) < shape["share"])
    wide = np.zeros(len(signals.time))
    for place in index:
        wide[max(place - 4, 0) : place + 4] = (
            size * random.choice([-1.0, 1.0]) * 2.0 ** random.integers(-2, 1)
        )
    signals.displacement = signals.displacement + wide


def _softening(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """The spring warms up and yields within the run."""
    return replace(p, softening=share, softening_time=0.4 * run.duration)


def _wedging(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """The load on the contact rises with the pull of spring and drive."""
    return replace(p, wedging=share)


def _mesh(p: Physics, force: float, shape: Shape, run: RunFacts) -> Physics:
    """The ripple of a gear: a force fixed in time, not in the phase of the drive."""
    phase = shape["phase"] + 2.9 * run.index
    return replace(p, mesh=force, mesh_omega=2.0 * np.pi * shape["frequency"], mesh_phase=phase)


def _clock(signals: Signals, rate: float, shape: Shape, run: RunFacts) -> None:
    """The clock of the force's converter goes wrong."""
    signals.friction = np.interp(signals.time * (1.0 - rate), signals.time, signals.friction)


def _irreversible(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """Friction differs between speeding up and slowing down."""
    return replace(p, irreversible=share, irreversible_acceleration=shape["acceleration"])


def _away_from(scales: Scales, random: np.random.Generator) -> Shape:
    """A frequency [Hz] between the natural one and a tenth of the sampling, and a phase."""
    return {"frequency": between(random, 1.6, 7.0) / scales.period, "phase": angle(random)}


UNLISTED = (
    Formulation(
        key="magnet", version="unlisted", strength="force", unit="N",
        typical=lambda s: 0.05 * s.force, most=lambda s: 1.0 * s.force,
        shape=lambda s, random: {
            "place": s.stroke * float(random.uniform(-0.7, 0.7)),
            "width": s.stroke * between(random, 0.05, 0.2),
        },
        shape_units={"place": "m", "width": "m"}, physics=_well,
    ),
    Formulation(
        key="pulsating_stiffness", version="unlisted", strength="share", unit="1", signed=False,
        typical=lambda s: 0.02, most=lambda s: 0.5, shape=_away_from,
        shape_units={"frequency": "Hz", "phase": "rad"}, physics=_pulsation,
    ),
    Formulation(
        key="lateral_mode", version="unlisted", strength="share", unit="1", signed=False,
        typical=lambda s: 0.02, most=lambda s: 0.3,
        shape=lambda s, random: {
            "frequency": between(random, 1.5, 5.0) / s.period, "damping_ratio": between(random, 0.01, 0.1)
        },
        shape_units={"frequency": "Hz"}, physics=_rider,
    ),
    Formulation(
        key="particles", version="unlisted", strength="share", unit="1", signed=False,
        typical=lambda s: 0.1, most=lambda s: 0.8,
        shape=lambda s, random: {
            "rate": between(random, 0.15, 0.5) / s.period,
            "length": s.period * between(random, 0.1, 0.4),
            "seed": _seed(random),
        },
        shape_units={"rate": "1/s", "length": "s"}, series=_bursts,
    ),
    Formulation(
        key="rocking_base", version="unlisted", strength="share", unit="1", signed=False,
        typical=lambda s: 0.01, most=lambda s: 0.3,
        shape=lambda s, random: {"phase": angle(random)}, shape_units={"phase": "rad"}, physics=_rocking,
    ),
    Formulation(
        key="held_samples", version="unlisted", strength="share", unit="1", signed=False,
        typical=lambda s: 0.02, most=lambda s: 0.5,
        shape=lambda s, random: {"length": s.interval * between(random, 3.0, 20.0), "seed": _seed(random)},
        shape_units={"length": "s"}, chain=_held,
    ),
    Formulation(
        key="bit_errors", version="unlisted", strength="size", unit="m", signed=False,
        typical=lambda s: 0.05 * s.stroke, most=lambda s: 2.0 * s.stroke,
        shape=lambda s, random: {"share": between(random, 0.001, 0.01) / 8.0, "seed": _seed(random)},
        chain=_bit_errors,
    ),
    Formulation(
        key="thermal_softening", version="unlisted", strength="share", unit="1", signed=False,
        typical=lambda s: 0.03, most=lambda s: 0.4, physics=_softening,
    ),
    Formulation(
        key="wedging_load", version="unlisted", strength="share", unit="1",
        typical=lambda s: 0.03, most=lambda s: 0.25, physics=_wedging,
    ),
    Formulation(
        key="gear_mesh", version="unlisted", strength="force", unit="N", signed=False,
        typical=lambda s: 0.03 * s.force, most=lambda s: 0.6 * s.force, shape=_away_from,
        shape_units={"frequency": "Hz", "phase": "rad"}, physics=_mesh,
    ),
    Formulation(
        key="clock_mismatch", version="unlisted", strength="rate", unit="1",
        typical=lambda s: 0.002 * s.period / s.duration, most=lambda s: 0.3 * s.period / s.duration,
        chain=_clock,
    ),
    Formulation(
        key="irreversible_friction", version="unlisted", strength="share", unit="1",
        typical=lambda s: 0.03, most=lambda s: 0.4,
        shape=lambda s, random: {"acceleration": s.acceleration * between(random, 0.1, 0.5)},
        shape_units={"acceleration": "m/s^2"}, physics=_irreversible,
    ),
)  # fmt: skip
"""Twelve kinds of effects that have no place in the catalogue."""
