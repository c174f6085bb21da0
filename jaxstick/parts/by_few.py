"""Derivatives of functions of a few numbers and of much that has been recorded."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jaxtyping import Array, Float

Numbers = Float[Array, " few"]


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def by_few(function: Callable[[Numbers, Any], Array], numbers: Numbers, recorded: Any) -> Array:
    """`function(numbers, recorded)`: an array made of a vector of a few numbers and of a tree of long arrays.

    Its derivative is taken once by each of the numbers, and only the outcome is carried through the many
    directions in which a caller differentiates; plain forward differentiation would carry each of them
    through the long arrays. Derivatives by what is recorded are as ever, where a caller asks for them.
    """
    return function(numbers, recorded)


def _derivative(
    function: Callable[[Numbers, Any], Array], primals: tuple[Numbers, Any], tangents: tuple[Any, Any]
) -> tuple[Array, Array]:
    numbers, recorded = primals
    by_numbers, by_recorded = tangents

    def twice(numbers: Numbers) -> tuple[Array, Array]:
        value = function(numbers, recorded)
        return value, value

    slopes, value = jax.jacfwd(twice, has_aux=True)(numbers)
    change = jnp.zeros_like(value)
    if not _is_zero(by_numbers):
        change += slopes @ by_numbers
    if not all(map(_is_zero, jax.tree.leaves(by_recorded, is_leaf=_is_zero))):
        moved = jax.tree.map(_instantiated, by_recorded, is_leaf=_is_zero)
        change += jax.jvp(functools.partial(function, numbers), (recorded,), (moved,))[1]
    return value, change


by_few.defjvp(_derivative, symbolic_zeros=True)


def _is_zero(tangent: Any) -> bool:
    return isinstance(tangent, SymbolicZero)


def _instantiated(tangent: Any) -> Array:
    return jnp.zeros(tangent.shape, tangent.dtype) if _is_zero(tangent) else tangent
