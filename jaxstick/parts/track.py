"""Where mass and base have been before a motion begins, and what has followed them there."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from jaxstick.parts.by_few import by_few

Points = Float[Array | np.ndarray, " points"]


class Trace(NamedTuple):
    """What something was at times before a start; lags: by how long each lies before it [s], from 0 on,
    growing."""

    lags: Points
    values: Points

    def oldest(self) -> tuple[Array | float, Array | float]:
        """The value at the beginning of the trace, and its rate there."""
        x = self.values[-1]
        return x, (self.values[-2] - x) / (self.lags[-1] - self.lags[-2])

    def ways(self) -> Array:
        """How far it went from point to point, where the values are velocities."""
        values = jnp.asarray(self.values)
        return jnp.diff(jnp.asarray(self.lags)) * jnp.abs(values[1:] + values[:-1]) / 2

    def followed(self, time: Array | float, begin: Array | float) -> Array:
        """Where w, with time w' = x - w, has come to at the start, from `begin` at the oldest point.

        Exact for straight lines between the points: over a span d on which x goes from a with slope g,
        w = x - g time + (w_a - a + g time) exp(-d/time).
        """
        lags, x = jnp.asarray(self.lags), jnp.asarray(self.values)
        new, old, spans = x[:-1], x[1:], jnp.diff(lags)
        behind = time * (new - old) / spans
        arrived = new - behind + (behind - old) * jnp.exp(-spans / time)
        fades = jnp.exp(-lags / time)
        return jnp.sum(arrived * fades[:-1]) + begin * fades[-1]

    def played(self, gap: Array | float, begin: Array | float) -> Array:
        """Where a joint with play `gap` to either side has been taken to at the start, from `begin` at the
        oldest point: it rests until it is met by an end of the gap, which then takes it along."""

        def met(joint: Array, place: Array) -> tuple[Array, None]:
            return jnp.clip(joint, place - gap, place + gap), None

        past = self._turned()[::-1]
        joint = jnp.clip(begin, past[0] - gap, past[0] + gap)
        return jax.lax.scan(met, joint, past)[0]

    def _turned(self) -> Array:
        """The values, but where it turned back the place that it turned at: the top of the parabola through
        the point there and its neighbours."""
        x = jnp.asarray(self.values)
        spans = jnp.diff(jnp.asarray(self.lags))
        new, old, slopes = spans[:-1], spans[1:], jnp.diff(x) / spans
        both = new + old
        bend = (slopes[1:] - slopes[:-1]) / both
        slope = (slopes[:-1] * old + slopes[1:] * new) / both
        turns = slopes[:-1] * slopes[1:] < 0
        beyond = jnp.where(turns, slope**2 / (4 * jnp.where(turns, bend, 1.0)), 0.0)
        return x.at[1:-1].add(-beyond)

    def rates(self) -> Trace:
        """The rate of it before the start: the slopes between the points, each in the middle of two."""
        lags = jnp.asarray(self.lags)
        return Trace((lags[:-1] + lags[1:]) / 2, -jnp.diff(jnp.asarray(self.values)) / jnp.diff(lags))

    def up_to(self, now: Array | float) -> Trace:
        """The trace of something that was not known at the start, where it is `now`."""
        lags, values = jnp.asarray(self.lags), jnp.asarray(self.values)
        return Trace(
            jnp.concatenate([jnp.zeros(1), lags]), jnp.concatenate([jnp.atleast_1d(jnp.asarray(now)), values])
        )


class Track(NamedTuple):
    """Displacements of the mass and of the base [m] at times before a start, as they were recorded; lags: by
    how long each lies before it [s], from 0 on, growing."""

    lags: Points
    displacement: Points
    base: Points

    @property
    def mass(self) -> Trace:
        """The displacement of the mass [m]."""
        return Trace(self.lags, self.displacement)

    @property
    def drive(self) -> Trace:
        """The displacement of the base [m]."""
        return Trace(self.lags, self.base)


class Stick(NamedTuple):
    """What holds a mass at the start of a motion: sticks, whether anything does; the friction force there,
    and the one at which it came to rest [N]; stiffness: of the contact spring, which gave way by their
    difference [N/m]; slid: in which sense the mass slid before, 0 where that is not known; rest: for how long
    it has rested [s]; held: the friction force at times before the start [N], None, or not `known`, where it
    was not recorded."""

    sticks: Array | bool
    friction: Array | float
    arrest: Array | float
    stiffness: Array | float
    slid: Array | float
    rest: Array | float
    known: Array | bool
    held: Trace | None

    def yielded(self, per_metre: Array | float) -> Array:
        """What a spring that yields has come to at the start, -1 to 1 of what it yields at: it was slid along
        with the mass, and where that sticks has since been taken back, or to and fro, with 1/`per_metre` from
        nothing to where it yields [m]."""
        slid = jnp.asarray(self.slid)
        back = jnp.abs(slid) * (self.arrest - self.friction) / self.stiffness
        taken = jnp.clip(slid + per_metre * back, -1.0, 1.0)
        if self.held is not None:
            numbers = (per_metre, self.friction, self.arrest, self.stiffness)
            recorded = self.held, jnp.asarray(self.rest), slid
            rocked = by_few(_yielded, jnp.stack([jnp.asarray(number) for number in numbers]), recorded)
            taken = jnp.where(self.known, rocked, taken)
        return jnp.where(self.sticks, taken, slid)


def _yielded(numbers: Array, recorded: tuple[Trace, Array, Array]) -> Array:
    per_metre, friction, arrest, stiffness = numbers
    held, rest, slid = recorded
    lags = jnp.asarray(held.lags)
    forces = jnp.where((lags <= rest) | (slid == 0), jnp.asarray(held.values), arrest)
    places = -forces.at[0].set(friction) / stiffness
    joint = Trace(lags, places).played(1 / per_metre, places[-1] - slid / per_metre)
    return per_metre * (places[0] - joint)
