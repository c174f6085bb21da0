"""Physical parameters as typed fields: what they mean, their unit and the values they may take."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import equinox as eqx

_KEY = "parameter"
SPAN = (50.0, 50.0)


@dataclasses.dataclass(frozen=True)
class Parameter:
    """The meaning of one physical parameter: unit, admissible values and, where it has one, its null value.

    `null` is the value at which the parameter has no influence (None where there is none, such as a mass).
    `typical` is the size to be expected where it does, as a multiple of what its unit amounts to on the rig
    at hand: N the level of friction, m the stroke, s the natural period, their products and powers likewise.
    `tries` are values that it is likely to have on any rig, the mains' frequencies for one. `span`: a search
    goes from the typical size over the first to the second times it; where either sign will do, from minus
    the first times it to the second; for a strength to the second times it, either way. `by_run`: whether
    every run of a data set has one of its own.
    """

    unit: str
    meaning: str
    lower: float = -math.inf
    upper: float = math.inf
    null: float | None = None
    typical: float | None = None
    tries: tuple[float, ...] = ()
    span: tuple[float, float] = SPAN
    by_run: bool = False

    @property
    def signed(self) -> bool:
        """Whether it gives a shape to an effect that may go either way, about 0."""
        return self.null is None and self.lower < 0 < self.upper


@dataclasses.dataclass(frozen=True)
class Place:
    """Where in a tree of modules a parameter sits: attribute names and dictionary keys from the root."""

    path: tuple[str, ...]
    parameter: Parameter

    def of(self, module: Any) -> Any:
        """The value of this parameter in `module`, a tree of the same structure."""
        for name in self.path:
            module = module[name] if isinstance(module, dict) else getattr(module, name)
        return module


def parameter(
    unit: str,
    meaning: str,
    *,
    lower: float = -math.inf,
    upper: float = math.inf,
    null: float | None = None,
    typical: float | None = None,
    tries: tuple[float, ...] = (),
    span: tuple[float, float] = SPAN,
    by_run: bool = False,
    **field: Any,
) -> Any:
    """A field of an `equinox.Module` that holds a physical parameter (a float or an array of lanes)."""
    kind = Parameter(unit, meaning, lower, upper, null, typical, tries, span, by_run)
    return eqx.field(metadata={_KEY: kind}, **field)


def part_of_it(meaning: str) -> Any:
    """The field of an effect that says in which part of it another form of it acts: none unless stated."""
    return parameter("1", meaning, lower=0.0, upper=1.0, typical=0.5, default=0.0)


def parameters(module: eqx.Module) -> Iterator[Place]:
    """Every parameter in a tree of modules and dictionaries of modules, outermost first."""
    for field in dataclasses.fields(module):
        value = getattr(module, field.name)
        if _KEY in field.metadata:
            yield Place((field.name,), field.metadata[_KEY])
        for prefix, child in _children(field.name, value):
            for place in parameters(child):
                yield dataclasses.replace(place, path=(*prefix, *place.path))


def _children(name: str, value: Any) -> Iterator[tuple[tuple[str, ...], eqx.Module]]:
    if isinstance(value, eqx.Module):
        yield (name,), value
    elif isinstance(value, dict):
        yield from (((name, key), child) for key, child in value.items())


def find(module: eqx.Module, name: str) -> Place:
    """The one parameter called `name` in a tree of modules; dots narrow the search (`friction.A`).

    Raises KeyError naming what is available when there is none, or more than one.
    """
    tail = tuple(name.split("."))
    places = list(parameters(module))
    found = [place for place in places if place.path[-len(tail) :] == tail]
    if len(found) != 1:
        available = ", ".join(".".join(place.path) for place in places)
        raise KeyError(f"{len(found)} parameters are called {name!r}; available: {available}")
    return found[0]


def replace(module: Any, values: dict[str, Any]) -> Any:
    """`module` with the named parameters set to new values."""
    if not values:
        return module
    places = [find(module, name) for name in values]
    return eqx.tree_at(lambda tree: [place.of(tree) for place in places], module, list(values.values()))
