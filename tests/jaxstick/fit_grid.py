"""The grid of a fit, for tests of many motions."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from jaxstick.simulate import OpenGrid


def open_grid(begin: float, interval: Any, samples: int, substeps: int) -> OpenGrid:
    """It is traced and compiled fastest, as programs with the options of a fit (`QUICKLY`) are."""
    return OpenGrid(begin, interval, jnp.asarray(substeps), jnp.asarray(samples), samples)
