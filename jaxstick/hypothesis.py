"""A hypothesis: the nominal oscillator together with the effects that are taken to act on it."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping

import equinox as eqx

from jaxstick.catalogue import catalogue
from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.oscillator import Oscillator
from jaxstick.parameter import Parameter, parameters, replace


class Hypothesis(eqx.Module):
    """The nominal oscillator and effects under their keys; its parameters are those of both.

    order: the keys, sorted, but for faults of the measuring chain: these stand as they were given, which is
    as the signal passes through them from the contact to the record. A force that is clipped before a hum
    comes to it shows another record than one that is clipped with the hum on it.
    """

    nominal: Oscillator
    effects: dict[str, AbstractEffect] = eqx.field(default_factory=dict)
    order: tuple[str, ...] = eqx.field(static=True, default=())

    def __post_init__(self) -> None:
        if {*self.order} != {*self.effects}:
            given = iter(self._chain(self.effects))
            self.order = tuple(
                next(given) if self.effects[key].on_chain() else key for key in sorted(self.effects)
            )

    def oscillator(self) -> Oscillator:
        """The oscillator with every effect attached, of the measuring chain's the one nearest to the contact
        last."""
        oscillator, chain = self.nominal, self._chain(self.order)
        for key in self.order:
            nearer = chain.pop() if self.effects[key].on_chain() else key
            oscillator = self.effects[nearer].attach(oscillator)
        return oscillator

    def _chain(self, keys: Iterable[str]) -> list[str]:
        return [key for key in keys if self.effects[key].on_chain()]


def effects_at_null(keys: tuple[str, ...]) -> dict[str, AbstractEffect]:
    """The effects with these keys, each at its null value.

    Raises UserError for a key that is not on the shelf, with the nearest one that is.
    """
    shelf = catalogue()
    for key in keys:
        if key not in shelf:
            raise UserError(f"There is no effect called {key!r}; {_hint(key, shelf)}")
    return {key: shelf[key]() for key in keys}  # pyright: ignore[reportCallIssue]


def effects_as_stated(stated: Mapping[str, Mapping[str, float]], where: object) -> dict[str, AbstractEffect]:
    """The effects of a rig file, in its order, with the values that it gives them [SI]; strengths that it
    does not give are at null, shapes as the shelf has them.

    Raises UserError, beginning with `where`, the file's name, for a key that is not on the shelf, a parameter
    that the effect does not have, and a value beyond its bounds.
    """
    shelf = catalogue()
    for key in stated:
        if key not in shelf:
            raise UserError(f"{where}: there is no effect called {key!r} for [effects]; {_hint(key, shelf)}")
    effects = effects_at_null(tuple(stated))
    for key, values in stated.items():
        known = {place.path[-1]: place.parameter for place in parameters(effects[key])}
        for name, value in values.items():
            if name not in known:
                raise UserError(
                    f"{where}: [effects.{key}] has no parameter called {name!r}; {_hint(name, known)}"
                )
            if not known[name].lower <= value <= known[name].upper:
                raise UserError(f"{where}: [effects.{key}] {name} is {value:g}; {_bounds(known[name])}")
    return {key: replace(effect, dict(stated[key])) for key, effect in effects.items()}


def _hint(name: str, known: Iterable[str]) -> str:
    """What else may have been meant, as the end of a sentence."""
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known)}."


def _bounds(kind: Parameter) -> str:
    unit = "" if kind.unit == "1" else f" {kind.unit}"
    if math.isinf(kind.upper):
        return f"it must be at least {kind.lower:g}{unit}."
    if math.isinf(kind.lower):
        return f"it must be at most {kind.upper:g}{unit}."
    return f"it must lie between {kind.lower:g} and {kind.upper:g}{unit}."
