"""Lanes as compiled programs take them: with room for more samples, leaf by leaf."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from fitting.diagnosis.lanes.programs import Pack
from fitting.lanes import Lanes
from jaxstick.traced import Program, Traced

ROOMS = (264, 1032)
"""Programs are compiled for lanes of so many samples, of which they compute as many as there are. No powers
of two: all lanes and directions write the same sample at a time, which should not all fall on one line of a
cache."""


class Roomy:
    """The lanes of a bench in the smallest room that holds them, and the programs that have been asked for
    them, which take a pack of them as a list of arrays: a pack is computed in about a millisecond, and to put
    a tree together and take it apart again takes as long.

    given: the lanes themselves; reach, room: how many samples they have, and have room for; pace: integration
    steps a sample, and reach, as programs take them.
    """

    def __init__(self, lanes: Lanes) -> None:
        self.given, self.reach = lanes, lanes.displacement.shape[1]
        self.room = next(room for room in ROOMS if room >= self.reach)
        self.pace = tuple(np.asarray(each) for each in lanes.pace())
        leaves, self._structure = jax.tree.flatten(lanes.filled(self.room))
        self._leaves = [np.asarray(leaf) for leaf in leaves]
        self._deviation: int = jax.tree.unflatten(self._structure, range(len(leaves))).start_deviation
        self._programs: dict[tuple[Traced, tuple[str, ...]], tuple[Program, list[np.ndarray]]] = {}

    def taken(self, index: np.ndarray, deviation: np.ndarray) -> list[np.ndarray]:
        """The arrays of the lanes at these indices, counted on from the first once all are through, with
        these standard deviations of what they have of their own."""
        index = index % len(self.given)
        leaves = [leaf[index] for leaf in self._leaves]
        leaves[self._deviation] = deviation
        return leaves

    def program(
        self, traced: Traced, keys: tuple[str, ...], hypothesis: Any, chart: Any, points: Sequence[np.ndarray]
    ) -> tuple[Program, list[np.ndarray]]:
        """What runs packs of these lanes with these effects attached: to be called with the arrays that it
        gives, those of the lanes (`taken`), the pace and the points. `points`: coordinates, what lanes have
        of their own, and what they are differentiated by, as of every pack."""
        if (traced, keys) not in self._programs:
            coordinates, own, chosen = points
            some = self.taken(np.arange(len(own)), own)
            lanes = jax.tree.unflatten(self._structure, some)
            pack = Pack(lanes, self.given.pace(), coordinates, own, chosen)
            constant = [np.asarray(leaf) for leaf in jax.tree.leaves((hypothesis, chart))]
            self._programs[traced, keys] = traced.program(hypothesis, chart, pack), constant
        return self._programs[traced, keys]
