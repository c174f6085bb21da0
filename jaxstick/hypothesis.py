"""A hypothesis: the nominal oscillator together with the effects that are taken to act on it."""

from __future__ import annotations

import difflib

import equinox as eqx

from jaxstick.catalogue import catalogue
from jaxstick.effect import AbstractEffect
from jaxstick.errors import UserError
from jaxstick.oscillator import Oscillator


class Hypothesis(eqx.Module):
    """The nominal oscillator and effects under their keys; its parameters are those of both."""

    nominal: Oscillator
    effects: dict[str, AbstractEffect] = eqx.field(default_factory=dict)

    def oscillator(self) -> Oscillator:
        """The oscillator with every effect attached."""
        oscillator = self.nominal
        for effect in self.effects.values():
            oscillator = effect.attach(oscillator)
        return oscillator


def effects_at_null(keys: tuple[str, ...]) -> dict[str, AbstractEffect]:
    """The effects with these keys, each at its null value.

    Raises UserError for a key that is not on the shelf, with the nearest one that is.
    """
    shelf = catalogue()
    for key in keys:
        if key not in shelf:
            near = difflib.get_close_matches(key, shelf, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(shelf)}."
            raise UserError(f"There is no effect called {key!r}; {hint}")
    return {key: shelf[key]() for key in keys}  # pyright: ignore[reportCallIssue]
