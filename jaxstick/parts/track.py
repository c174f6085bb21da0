"""Where the mass has been before a motion begins, and what has followed it there."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


class Track(NamedTuple):
    """Displacement of the mass [m] at times before a start, as it was recorded.

    lags: by how long each lies before the start [s], from 0 on, growing.
    """

    lags: Float[Array | np.ndarray, " points"]
    displacement: Float[Array | np.ndarray, " points"]

    def oldest(self) -> tuple[Array | float, Array | float]:
        """Displacement and velocity at the beginning of the track [m, m/s]."""
        x = self.displacement[-1]
        return x, (self.displacement[-2] - x) / (self.lags[-1] - self.lags[-2])

    def followed(self, time: Array | float, begin: Array | float) -> Array:
        """Where w, with time w' = x - w, has come to at the start, from `begin` at the oldest point [m].

        Exact for straight lines between the points: over a span d on which x goes from a with slope g,
        w = x - g time + (w_a - a + g time) exp(-d/time).
        """
        lags, x = jnp.asarray(self.lags), jnp.asarray(self.displacement)
        new, old, spans = x[:-1], x[1:], jnp.diff(lags)
        behind = time * (new - old) / spans
        arrived = new - behind + (behind - old) * jnp.exp(-spans / time)
        fades = jnp.exp(-lags / time)
        return jnp.sum(arrived * fades[:-1]) + begin * fades[-1]
