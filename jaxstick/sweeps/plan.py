"""What a sweep is to compute, as plain values that can be shown, compared and made into lanes."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.record import AssumedConstants, Effects, KnownRig, RigSheet
from jaxstick.version import version

grid = deferred("jaxstick.sweep", "grid")
effects_of = deferred("jaxstick.nominal", "effects_of")
effects_as_stated = deferred("jaxstick.hypothesis", "effects_as_stated")
steady_notices = deferred("jaxstick.steady_effects", "steady_notices")

MOST_LANES = 10_000_000
MOST_RINGS = 2e4
"""Periods of the contact's ring that a cycle may hold: some hundred million steps to its periodic state."""


@dataclass(frozen=True)
class Axis:
    """One axis of a sweep: what it is, the unit in which it is shown and how many of it are one SI unit,
    whether 0 is a value, and the largest value."""

    meaning: str
    unit: str = ""
    factor: float = 1.0
    zero: bool = False
    largest: float = math.inf

    def shown(self, value: float) -> str:
        """A value in SI units as people read it."""
        return f"{self.factor * value:.5g} {self.unit}".rstrip()


AXES: Mapping[str, Axis] = {
    "ratios": Axis("frequency ratio"),
    "amplitudes": Axis("base amplitude", "mm", 1e3),
    "A": Axis("A", "N", zero=True),
    "B": Axis("B", "s/m", zero=True),
    "C": Axis("C", "N", zero=True),
    "D": Axis("D", "N s/m", zero=True),
    "k1": Axis("k1", "N/m"),
    "friction_ratio": Axis("friction ratio C/(A + C)", largest=1.0),
    "level": Axis("static friction A + C", "N"),
}
"""The axes by the names that `jaxstick.sweep.grid` gives them."""

REPLACED = {"friction_ratio": ("A", "C"), "level": ("A", "C")}
"""The constants that stand aside where an axis is given."""


@dataclass(frozen=True)
class Plan:
    """A sweep: the rig, the constants that hold where no axis says otherwise, the contact ("loaded", "paper"
    or "smooth"), the values of each given axis in SI units, the constants by which to differentiate, the
    effects as stated, and sentences on these."""

    rig: KnownRig
    constants: AssumedConstants
    contact: str
    axes: Mapping[str, tuple[float, ...]]
    derivatives: tuple[str, ...] = ()
    effects: Effects = field(default_factory=dict)
    notices: tuple[str, ...] = ()

    @property
    def lanes(self) -> int:
        """How many combinations of values there are."""
        return math.prod(len(values) for values in self.axes.values())

    @property
    def varied(self) -> dict[str, tuple[float, ...]]:
        """The axes that have more than one value."""
        return {name: values for name, values in self.axes.items() if len(values) > 1}

    def points(self) -> Any:
        """The lanes, as `jaxstick.sweep.compute` takes them; the frequency ratio runs fastest."""
        effects = effects_as_stated(self.effects, "the sweep") if self.effects else None
        return grid(self.rig, self.constants, contact=self.contact, effects=effects, **self.axes)

    def described(self) -> dict[str, Any]:
        """The plan as JSON shows it."""
        effects = {key: dict(values) for key, values in self.effects.items()}
        return {
            "rig": asdict(self.rig),
            "assumed": asdict(self.constants),
            **({"effects": effects} if effects else {}),
            "contact": self.contact,
            "axes": {name: list(values) for name, values in self.axes.items()},
            "derivatives": list(self.derivatives),
        }

    @property
    def fingerprint(self) -> str:
        """SHA-256 of all that the result depends on, the version of jaxstick included."""
        content = json.dumps([self.described(), list(self.effects), version()], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()


def plan_sweep(
    sheet: RigSheet,
    axes: Mapping[str, tuple[float, ...] | None],
    contact: str = "loaded",
    derivatives: tuple[str, ...] = (),
) -> Plan:
    """The plan of a sweep of the rig in `sheet` over the axes that are given, by their names in AXES.

    Without amplitudes those of the base in the runs that the sheet lists are taken. A constant that is not
    swept is the sheet's assumed one.

    Raises UserError for a rig that has no natural frequency or that its base does not move, for values out of
    range, constants that are missing or given twice, no amplitude at all, more than ten million lanes, and
    effects that are not there or rule out a periodic state.
    """
    rig, path = sheet.rig, sheet.path
    if rig.stiffness == 0:
        raise UserError(
            f"{path}: [rig] has stiffness 0 and so no natural frequency for a frequency ratio to refer to."
        )
    if rig.drive_stiffness == 0 and rig.drive_damping == 0 and rig.friction_against == "ground":
        raise UserError(
            f"{path}: [rig] joins the base to the mass by neither spring nor damper, so no base motion can "
            "be swept."
        )
    given = {name: tuple(values) for name, values in axes.items() if values}
    if "ratios" not in given:
        raise UserError("A sweep needs at least one frequency ratio.")
    if "amplitudes" not in given:
        given["amplitudes"] = _listed_amplitudes(sheet)
    for name, values in given.items():
        _check_range(name, values)
    for name, others in REPLACED.items():
        for other in others:
            if name in given and other in given:
                raise UserError(
                    f"The {AXES[name].meaning} and {other} are both given; one of them says the other."
                )
    _check_constants(sheet, given)
    _check_length(sheet, given)
    notices = steady_notices(effects_of(sheet), path) if sheet.effects else ()
    plan = Plan(rig, sheet.assumed, contact, given, derivatives, sheet.effects, tuple(notices))
    if plan.lanes > MOST_LANES:
        raise UserError(
            f"The sweep would have {plan.lanes:.6g} lanes; at most {MOST_LANES:.0e} can be computed in one."
        )
    return plan


def _listed_amplitudes(sheet: RigSheet) -> tuple[float, ...]:
    listed = tuple(dict.fromkeys(plan.base_amplitude for plan in sheet.runs if plan.base_amplitude))
    if not listed:
        raise UserError(
            f"{sheet.path}: no run is listed with base_amplitude_mm, so the amplitude of the base has to be "
            "given (--amplitudes-mm 8,10.325)."
        )
    return listed


def _check_range(name: str, values: tuple[float, ...]) -> None:
    axis = AXES[name]
    for value in values:
        if not math.isfinite(value) or value < 0 or (value == 0 and not axis.zero):
            asked = "0 or more" if axis.zero else "greater than 0"
            raise UserError(f"The {axis.meaning} must be {asked}; {axis.shown(value)} is given.")
        if value > axis.largest:
            raise UserError(f"The {axis.meaning} must not exceed {axis.largest:g}; {value:g} is given.")


def _check_length(sheet: RigSheet, given: Mapping[str, tuple[float, ...]]) -> None:
    """A cycle of the drive must not hold too many periods of the contact's ring, which the steps resolve."""
    k1 = max(given.get("k1", (sheet.assumed.k1 or 0.0,)))
    ratio = min(given["ratios"])
    rings = math.sqrt((k1 + sheet.rig.stiffness) / sheet.rig.stiffness) / ratio
    if rings > MOST_RINGS:
        raise UserError(
            f"At a frequency ratio of {ratio:g} a cycle holds {rings:.2g} periods of the contact's ring (k1 "
            f"= {k1:g} N/m); at most {MOST_RINGS:.0e} can be computed."
        )


def _check_constants(sheet: RigSheet, given: Mapping[str, tuple[float, ...]]) -> None:
    """C and k1 come from an axis or from the sheet; a friction ratio or a level alone needs the other."""
    needed = {"k1": "k1" in given or sheet.assumed.k1 is not None}
    level, ratio = "level" in given, "friction_ratio" in given
    needed["C"] = "C" in given or sheet.assumed.C is not None or (level and ratio)
    missing = [name for name, there in needed.items() if not there]
    if missing:
        raise UserError(
            f"{sheet.path}: [assumed] does not give {' and '.join(sorted(missing))}, and no option does; a "
            "sweep needs both C and k1."
        )
    static = (sheet.assumed.A or 0.0) + (sheet.assumed.C or 0.0)
    if level != ratio and static == 0:
        raise UserError(
            f"{sheet.path}: [assumed] has no friction A + C that a friction ratio or level could refer to; "
            "give both."
        )
