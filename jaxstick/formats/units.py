"""Units as suffixes of a name: `displacement_mm` is a displacement in millimetres.

Each dimension is a mapping from suffix to the factor that takes a number with that suffix to SI.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

Units = Mapping[str, float]


def _units(**factors: float) -> Units:
    return MappingProxyType(factors)


PURE: Units = MappingProxyType({"": 1.0})
TIME = _units(s=1.0, ms=1e-3, us=1e-6)
LENGTH = _units(m=1.0, mm=1e-3, um=1e-6)
FORCE = _units(n=1.0, kn=1e3)
VELOCITY = _units(m_per_s=1.0, mm_per_s=1e-3)
MASS = _units(kg=1.0, g=1e-3)
STIFFNESS = _units(n_per_m=1.0, n_per_mm=1e3, kn_per_m=1e3)
DAMPING = _units(n_s_per_m=1.0, n_s_per_mm=1e3)
INVERSE_VELOCITY = _units(s_per_m=1.0, s_per_mm=1e3)
FREQUENCY = _units(hz=1.0, khz=1e3, rad_per_s=0.5 / math.pi)
ANGLE = _units(rad=1.0, deg=math.pi / 180.0)

CHANNELS: Mapping[str, Units] = MappingProxyType(
    {
        "time": TIME,
        "displacement": LENGTH,
        "base": LENGTH,
        "friction": FORCE,
        "force": FORCE,
        "velocity": VELOCITY,
    }
)
"""The quantities a CSV column may hold."""


@dataclass(frozen=True)
class Named:
    """A name taken apart: its quantity and unit suffix, with the factor to SI; `factor` is None for an
    unknown unit."""

    quantity: str
    unit: str
    factor: float | None


def spelled(quantity: str, unit: str) -> str:
    """The name of `quantity` in `unit`: 'mass_kg', or 'log_decrement' where there is no unit."""
    return f"{quantity}_{unit}" if unit else quantity


def spellings(quantities: Mapping[str, Units]) -> list[str]:
    """Every name that `quantities` allow, in their order."""
    return [spelled(quantity, unit) for quantity, units in quantities.items() for unit in units]


def take_apart(name: str, quantities: Mapping[str, Units]) -> Named | None:
    """`name` as quantity and unit, or None if it begins with no quantity of `quantities`.

    The longest quantity wins, so that 'damping_ratio' is not a damping in the unit 'ratio'.
    """
    for quantity in sorted(quantities, key=len, reverse=True):
        if name == quantity or name.startswith(quantity + "_"):
            unit = name[len(quantity) + 1 :]
            return Named(quantity, unit, quantities[quantity].get(unit))
    return None


def column_quantity(header: str) -> Named | None:
    """The channel that a CSV column's header names, or None for a column of no channel.

    Upper and lower case are one, and the micro sign is `u`. An unknown unit of one word, or of the form
    x_per_y, is returned with `factor` None; several other words after a quantity's name make a column of its
    own (`force_table_temperature_c`), which is no channel.
    """
    name = header.strip().replace("\u00b5", "u").replace("\u03bc", "u").lower()
    named = take_apart(name, CHANNELS)
    if named is None or named.factor is not None:
        return named
    return named if "_" not in named.unit or "_per_" in named.unit else None


def likely_unit(size: float, unit: str, expected: float, units: Units, within: float) -> str | None:
    """The other unit in which a value would agree with what is expected, or None.

    `size` is the value in SI as read with `unit`; the answer is a suffix of `units` that brings size within a
    factor `within` of `expected`.
    """
    for other, factor in units.items():
        corrected = size / units[unit] * factor
        if other != unit and expected / within < corrected < expected * within:
            return other
    return None
