"""Effects on springs, dampers and drive, each by the catalogue's formula (A) and by another (B)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fitting.blind.formulation import Formulation, RunFacts, Shape, Signals, between
from fitting.blind.physics import Physics
from fitting.blind.scales import Scales


def _cubic(p: Physics, k3: float, shape: Shape, run: RunFacts) -> Physics:
    """- k3 x^3."""
    return replace(p, cubic=k3)


def _quintic(p: Physics, k3: float, shape: Shape, run: RunFacts) -> Physics:
    """- k3 x^3 (1 + x^2/L^2)."""
    return replace(p, cubic=k3, cubic_length=shape["length"])


def _square(p: Physics, k2: float, shape: Shape, run: RunFacts) -> Physics:
    """- k2 x^2."""
    return replace(p, square=k2)


def _hyperbola(p: Physics, k2: float, shape: Shape, run: RunFacts) -> Physics:
    """- 2 k2 L (sqrt(x^2 + L^2) - L): a parabola that turns into straight lines."""
    return replace(p, square=k2, square_length=shape["length"])


def _stop_at(scales: Scales, random: np.random.Generator) -> Shape:
    return {"gap": scales.reach * float(random.uniform(0.4, 0.8))}


def _stop(p: Physics, stiffness: float, shape: Shape, run: RunFacts) -> Physics:
    """A spring beyond |x| = gap."""
    return replace(p, stop=stiffness, stop_place=shape["gap"])


def _buffer(p: Physics, stiffness: float, shape: Shape, run: RunFacts) -> Physics:
    """The same as a rubber ball: force as the power 3/2 of the way."""
    return replace(p, stop=stiffness, stop_place=shape["gap"], stop_power=1.5)


def _drag(p: Physics, c2: float, shape: Shape, run: RunFacts) -> Physics:
    """- c2 v |v|."""
    return replace(p, drag=c2)


def _turbulent(p: Physics, c2: float, shape: Shape, run: RunFacts) -> Physics:
    """- c2 v |v|^0.75 V^0.25."""
    return replace(p, drag=c2, drag_power=0.75, drag_speed=shape["speed"])


def _guide(p: Physics, level: float, shape: Shape, run: RunFacts) -> Physics:
    """Coulomb friction that yields after `deflection`, unseen by the table."""
    return replace(p, guide=level, guide_stiffness=level / shape["deflection"])


def _smooth_guide(p: Physics, level: float, shape: Shape, run: RunFacts) -> Physics:
    """- level tanh(v/speed)."""
    return replace(p, guide=level, guide_speed=shape["speed"])


def _maxwell(p: Physics, stiffness: float, shape: Shape, run: RunFacts) -> Physics:
    """- stiffness (x - w), time w' = x - w."""
    return replace(p, branch_1=stiffness, branch_time_1=shape["time"])


def _spectrum(p: Physics, stiffness: float, shape: Shape, run: RunFacts) -> Physics:
    """Three such branches spread over a decade of times."""
    third, time = stiffness / 3.0, shape["time"]
    return replace(
        p,
        branch_1=third, branch_2=third, branch_3=third,
        branch_time_1=0.3 * time, branch_time_2=time, branch_time_3=3.0 * time,
    )  # fmt: skip


def _push(p: Physics, force: float, shape: Shape, run: RunFacts) -> Physics:
    """+ force."""
    return replace(p, push=force)


def _shifted_zero(signals: Signals, force: float, shape: Shape, run: RunFacts) -> None:
    """The zero of the displacement sensor lies off by what the force would shift the rest position."""
    signals.displacement = signals.displacement + force / shape["stiffness"]


def _dashpot(p: Physics, damping: float, shape: Shape, run: RunFacts) -> Physics:
    """+ damping y'."""
    return replace(p, base_damping=damping)


def _relative_dashpot(p: Physics, damping: float, shape: Shape, run: RunFacts) -> Physics:
    """+ damping (y' - x')."""
    return replace(p, base_damping=damping, base_damping_relative=1.0)


def _play(p: Physics, gap: float, shape: Shape, run: RunFacts) -> Physics:
    """The joint follows y only when it is `gap` off."""
    return replace(p, backlash=2.0 * gap)


def _soft_play(p: Physics, gap: float, shape: Shape, run: RunFacts) -> Physics:
    """The same, taken up gradually."""
    return replace(p, backlash=2.0 * gap, backlash_rounded=1.0)


def _other_stiffness(p: Physics, error: float, shape: Shape, run: RunFacts) -> Physics:
    """K is not as stated: the springs to the base or, at `to_ground` 1, those to the ground."""
    more = error * shape["stated"]
    drive = p.drive_stiffness + (0.0 if shape["to_ground"] else more)
    return replace(p, stiffness=p.stiffness + more, drive_stiffness=drive)


def _other_mass(p: Physics, error: float, shape: Shape, run: RunFacts) -> Physics:
    """m is not as stated."""
    return replace(p, mass=p.mass * (1.0 + error))


MECHANICS = (
    Formulation(
        key="cubic_stiffness", version="A", strength="coefficient", unit="N/m^3",
        typical=lambda s: 0.03 * s.stiffness / s.reach**2, most=lambda s: 0.25 * s.stiffness / s.reach**2,
        physics=_cubic,
    ),
    Formulation(
        key="cubic_stiffness", version="B", strength="coefficient", unit="N/m^3",
        typical=lambda s: 0.03 * s.stiffness / s.reach**2, most=lambda s: 0.2 * s.stiffness / s.reach**2,
        shape=lambda s, random: {"length": 1.5 * s.reach}, shape_units={"length": "m"}, physics=_quintic,
    ),
    Formulation(
        key="quadratic_stiffness", version="A", strength="coefficient", unit="N/m^2",
        typical=lambda s: 0.03 * s.stiffness / s.reach, most=lambda s: 0.2 * s.stiffness / s.reach,
        physics=_square,
    ),
    Formulation(
        key="quadratic_stiffness", version="B", strength="coefficient", unit="N/m^2",
        typical=lambda s: 0.03 * s.stiffness / s.reach, most=lambda s: 0.2 * s.stiffness / s.reach,
        shape=lambda s, random: {"length": 0.8 * s.reach}, shape_units={"length": "m"},
        physics=_hyperbola,
    ),
    Formulation(
        key="end_stop", version="A", strength="stiffness", unit="N/m", signed=False,
        typical=lambda s: 0.1 * s.stiffness, most=lambda s: 4.0 * s.stiffness, shape=_stop_at,
        shape_units={"gap": "m"}, physics=_stop,
    ),
    Formulation(
        key="end_stop", version="B", strength="stiffness", unit="N/m", signed=False,
        typical=lambda s: 0.1 * s.stiffness, most=lambda s: 4.0 * s.stiffness, shape=_stop_at,
        shape_units={"gap": "m"}, physics=_buffer,
    ),
    Formulation(
        key="quadratic_drag", version="A", strength="coefficient", unit="N s^2/m^2", signed=False,
        typical=lambda s: 0.3 * s.damping / s.haste, most=lambda s: 6.0 * s.damping / s.haste,
        physics=_drag,
    ),
    Formulation(
        key="quadratic_drag", version="B", strength="coefficient", unit="N s^2/m^2", signed=False,
        typical=lambda s: 0.3 * s.damping / s.haste, most=lambda s: 6.0 * s.damping / s.haste,
        shape=lambda s, random: {"speed": s.haste}, shape_units={"speed": "m/s"}, physics=_turbulent,
    ),
    Formulation(
        key="guide_friction", version="A", strength="force", unit="N", signed=False,
        typical=lambda s: 0.03 * s.force, most=lambda s: 0.5 * s.force, physics=_guide,
        shape=lambda s, random: {"deflection": s.stroke * between(random, 1e-3, 1e-2)},
        shape_units={"deflection": "m"},
    ),
    Formulation(
        key="guide_friction", version="B", strength="force", unit="N", signed=False,
        typical=lambda s: 0.03 * s.force, most=lambda s: 0.5 * s.force,
        shape=lambda s, random: {"speed": 0.02 * s.speed}, shape_units={"speed": "m/s"},
        physics=_smooth_guide,
    ),
    Formulation(
        key="spring_relaxation", version="A", strength="stiffness", unit="N/m", signed=False,
        typical=lambda s: 0.03 * s.stiffness, most=lambda s: 0.5 * s.stiffness,
        shape=lambda s, random: {"time": s.period * between(random, 0.1, 1.5)},
        shape_units={"time": "s"}, physics=_maxwell,
    ),
    Formulation(
        key="spring_relaxation", version="B", strength="stiffness", unit="N/m", signed=False,
        typical=lambda s: 0.03 * s.stiffness, most=lambda s: 0.5 * s.stiffness,
        shape=lambda s, random: {"time": s.period * between(random, 0.2, 0.8)},
        shape_units={"time": "s"}, physics=_spectrum,
    ),
    Formulation(
        key="constant_force", version="A", strength="force", unit="N",
        typical=lambda s: 0.05 * s.force, most=lambda s: 0.6 * s.force, physics=_push,
    ),
    Formulation(
        key="constant_force", version="B", strength="force", unit="N",
        typical=lambda s: 0.05 * s.force, most=lambda s: 0.6 * s.force,
        shape=lambda s, random: {"stiffness": s.stiffness}, shape_units={"stiffness": "N/m"},
        chain=_shifted_zero,
    ),
    Formulation(
        key="base_relative_damping", version="A", strength="damping", unit="N s/m",
        typical=lambda s: 1.5 * s.damping, most=lambda s: 8.0 * s.damping, least=lambda s: s.damping,
        physics=_dashpot,
    ),
    Formulation(
        key="base_relative_damping", version="B", strength="damping", unit="N s/m", signed=False,
        typical=lambda s: 1.5 * s.damping, most=lambda s: 8.0 * s.damping, least=lambda s: s.damping,
        physics=_relative_dashpot,
    ),
    Formulation(
        key="drive_backlash", version="A", strength="gap", unit="m", signed=False,
        typical=lambda s: 0.015 * s.base, most=lambda s: 0.3 * s.base, physics=_play,
    ),
    Formulation(
        key="drive_backlash", version="B", strength="gap", unit="m", signed=False,
        typical=lambda s: 0.015 * s.base, most=lambda s: 0.3 * s.base, physics=_soft_play,
    ),
    Formulation(
        key="stiffness_error", version="A", strength="error", unit="1",
        shape_units={"stiffness": "N/m", "ground_stiffness": "N/m", "mass": "kg"},
        typical=lambda s: 0.06, most=lambda s: 0.25, least=lambda s: 0.05, physics=_other_stiffness,
        shape=lambda s, random: {"to_ground": float(random.integers(2)), "stated": s.stiffness},
        parameters=lambda error, shape: {
            "stiffness": error * shape["stated"] * (1.0 - shape["to_ground"]),
            "ground_stiffness": error * shape["stated"] * shape["to_ground"],
            "mass": 0.0,
        },
    ),
    Formulation(
        key="stiffness_error", version="B", strength="error", unit="1",
        shape_units={"mass": "kg"}, shape=lambda s, random: {"stated": s.mass},
        parameters=lambda error, shape: {"mass": error * shape["stated"]},
        typical=lambda s: 0.06, most=lambda s: 0.25, least=lambda s: 0.05, physics=_other_mass,
    ),
)  # fmt: skip
"""Both forms of every effect on the mechanics."""
