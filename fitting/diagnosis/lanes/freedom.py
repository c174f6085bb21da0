"""What a diagnosis may free beside the constants, and how far: the rig, the contact, effects."""

from __future__ import annotations

import numpy as np

from fitting.of_the_rig import of_the_rig, room
from fitting.problem import Problem, natural_size
from fitting.unknowns import RIG, Unknown
from jaxstick.effect import AbstractEffect
from jaxstick.parameter import Place, find, parameters

STRENGTH_FREEDOM = 10.0
"""Standard deviation of a strength, in typical sizes;"""
DOUBT = 0.1
"""at least this share of what the rig has of the same kind."""
SHAPE_FREEDOM = 1.5
RIG_TOLERANCE = {
    "mass": (0.01, 0.025),
    "stiffness": (0.004, 0.01),
    "drive_stiffness": (0.004, 0.01),
    "damping": (0.2, 2.0),
}
"""By what share a stated property of the rig may be off without that being called an effect: one standard
deviation, and at most. Damping is hardly ever known well."""
CONTACT_FREEDOM = 0.5


def rig_unknowns(problem: Problem) -> list[Unknown]:
    """What the rig may differ by within its tolerance."""
    rig = problem.dataset.rig
    found = []
    for name, (share, most) in RIG_TOLERANCE.items():
        value = getattr(rig, name)
        if value > 0:
            found.append(
                Unknown(
                    f"{RIG}{name}",
                    find(problem.hypothesis.nominal, f"{RIG}{name}").parameter.unit,
                    value / (1 + most),
                    value * (1 + most),
                    "log",
                    1.0,
                    value,
                    share * value,
                )
            )
    return found


def contact_unknowns(problem: Problem) -> list[Unknown]:
    """What a contact that gives way gradually has besides its stiffness."""
    return [
        Unknown(
            f"contact.{place.path[-1]}",
            place.parameter.unit,
            place.parameter.lower,
            place.parameter.upper,
            "linear",
            1.0,
            place.parameter.typical,
            CONTACT_FREEDOM,
        )
        for place in parameters(problem.hypothesis.nominal.contact)
        if place.path[-1] != "k1"
    ]


def effect_unknown(name: str, effect: AbstractEffect, place: Place, problem: Problem) -> Unknown:
    """A parameter of an effect: a strength about its null, a shape about its typical size or, where it may
    have either sign, about nought."""
    kind = place.parameter
    natural = natural_size(kind.unit, problem.scale, problem.period)
    if kind.null is not None:
        scale = (kind.typical or 1.0) * natural
        whole = of_the_rig(kind.unit, problem.dataset.rig, problem.scale)
        less, more = room(whole, kind.span[1] * scale)
        freedom = max(STRENGTH_FREEDOM * scale, DOUBT * whole)
        lower, upper = max(kind.lower, -less), min(kind.upper, more)
        return Unknown(name, kind.unit, lower, upper, "linear", scale, 0.0, freedom)
    typical = kind.typical * natural if kind.typical else float(place.of(effect))
    less, more = kind.span
    if kind.signed:
        lower, upper = max(kind.lower, -less * typical), min(kind.upper, more * typical)
        return Unknown(name, kind.unit, lower, upper, "linear", typical, 0.0, SHAPE_FREEDOM * typical)
    lower, upper = max(kind.lower, typical / less), min(kind.upper, typical * more)
    centre = float(np.clip(typical, lower, upper))
    return Unknown(name, kind.unit, lower, upper, "log", 1.0, centre, SHAPE_FREEDOM * centre)
