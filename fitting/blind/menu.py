"""All effects of the truth, and which of them records cannot tell apart by any means."""

from __future__ import annotations

from fitting.blind.formulation import Formulation
from fitting.blind.friction_effects import FRICTION
from fitting.blind.further_forms import FURTHER
from fitting.blind.measurement_effects import MEASUREMENT
from fitting.blind.mechanics_effects import MECHANICS
from fitting.blind.unlisted_effects import UNLISTED

FAMILIES = {
    key: family
    for family, formulations in (
        ("friction", FRICTION),
        ("mechanics", MECHANICS),
        ("measurement", MEASUREMENT),
    )
    for key in dict.fromkeys(formulation.key for formulation in formulations)
}
"""The family of every listed effect."""

LISTED = tuple(FAMILIES)
"""The keys of the catalogue's effects."""

STRANGE = tuple(formulation.key for formulation in UNLISTED)
"""Names of the effects that no catalogue lists."""

ALIASES = (
    frozenset({"base_relative_damping", "base_delay"}),
    frozenset({"force_gain", "displacement_gain", "stiffness_error"}),
    frozenset({"base_gain", "stiffness_error"}),
)
"""Classes that x, y and F cannot separate.

A shift of y in time is a force in proportion to y'. A gain of F, one of x and an error of the mass leave the
same trace where stiffnesses and the constants of friction are free. A gain of y is an error of the drive
stiffness.
"""

HIDDEN_BY_RIG = frozenset().union(*ALIASES)
"""What a free rig (mass, stiffnesses, dampers) takes over entirely: their gap is that of a rig as stated."""

_BY_NAME = {(one.key, one.version): one for one in (*FRICTION, *MECHANICS, *MEASUREMENT, *FURTHER, *UNLISTED)}


def formulation(key: str, version: str) -> Formulation:
    """The effect `key` in its version "A", "B" or, where it has a third form, "B2", or "unlisted"; raises
    KeyError where there is none."""
    return _BY_NAME[key, version]


def other_versions(key: str) -> tuple[str, ...]:
    """The versions in which a listed effect is not by the catalogue's formula."""
    return tuple(version for name, version in _BY_NAME if name == key and version.startswith("B"))


def aliases(key: str) -> tuple[str, ...]:
    """The other effects that leave the same trace."""
    return tuple(sorted({other for group in classes(key) for other in group} - {key}))


def classes(key: str) -> tuple[frozenset[str], ...]:
    """The classes that an effect is in; a wrong stiffness is in that of a wrong mass and in that of a wrong
    stroke."""
    return tuple(group for group in ALIASES if key in group)


def may_be_paired(first: str, second: str) -> bool:
    """Whether two effects differ and neither can stand for the other."""
    return first != second and second not in aliases(first)
