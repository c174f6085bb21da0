"""A call that stays in float64 when jax transforms it in a session of float32.

jax applies the setting of the moment at which it transforms or compiles a function, not of the moment at
which the function was traced: under the caller's `jit` or `grad` the inner float64 code is transposed and
lowered by float32 rules, and many operations fail there. Here the whole call is one primitive, and each of
its rules switches float64 on first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.core import ShapedArray, Tracer, eval_jaxpr
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

Arrays = Sequence[Any]


def enclosed(function: Callable[..., Any], args: tuple, kwargs: dict[str, Any]) -> Any:
    """The function called on any arguments: one primitive where jax is tracing, else a plain call."""
    traced, known = eqx.partition((args, kwargs), lambda leaf: isinstance(leaf, Tracer))
    leaves, structure = jax.tree.flatten(traced)
    if not leaves and not isinstance(jnp.zeros(()), Tracer):
        return function(*args, **kwargs)
    returned: list[Any] = []

    def flat(*leaves: Any) -> list[Any]:
        args, kwargs = eqx.combine(jax.tree.unflatten(structure, leaves), known)
        computed, rest = eqx.partition(function(*args, **kwargs), eqx.is_array)
        arrays, shape = jax.tree.flatten(computed)
        returned[:] = [shape, rest]
        return arrays

    program = jax.make_jaxpr(flat)(*leaves)
    captured = len(program.consts)

    def run(*arrays: Any) -> Arrays:
        return eval_jaxpr(program.jaxpr, arrays[:captured], *arrays[captured:])

    inputs = (*program.consts, *leaves)
    results = call_p.bind(*inputs, function=run, pullback=None, residuals=len(inputs))
    shape, rest = returned
    return eqx.combine(jax.tree.unflatten(shape, results), rest)


call_p = Primitive("float64_call")
"""Calls `function` on flat arrays.

The arguments after the first `residuals` enter linearly, if there are any, and `pullback` then takes the
residuals and the cotangents of the results to the cotangents of those arguments.
"""
call_p.multiple_results = True


@call_p.def_impl
def _evaluate(*arrays: Any, function: Callable, pullback: Callable | None, residuals: int) -> Arrays:
    with jax.enable_x64(True):
        return function(*arrays)


@call_p.def_abstract_eval
def _shapes(*arrays: Any, function: Callable, pullback: Callable | None, residuals: int) -> Arrays:
    with jax.enable_x64(True):
        results = jax.eval_shape(function, *(jax.ShapeDtypeStruct(a.shape, a.dtype) for a in arrays))
        return [ShapedArray(result.shape, result.dtype) for result in results]


def _lower(context: Any, *arrays: Any, function: Callable, pullback: Callable | None, residuals: int) -> Any:
    with jax.enable_x64(True):
        return mlir.lower_fun(function, multiple_results=True)(context, *arrays)


def _batch(
    arrays: Arrays, axes: Arrays, *, function: Callable, pullback: Callable | None, residuals: int
) -> tuple[Arrays, Arrays]:
    lanes = jax.vmap(function, in_axes=tuple(axes))
    results = call_p.bind(
        *arrays,
        function=lanes,
        pullback=pullback and _batched_pullback(pullback, axes[:residuals], axes[residuals:]),
        residuals=residuals,
    )
    return results, [0] * len(results)


def _batched_pullback(pullback: Callable, fixed_axes: Arrays, linear_axes: Arrays) -> Callable[..., Arrays]:
    """The cotangent of an argument that all lanes share is the sum over the lanes."""

    def pull_back(*values: Any) -> Arrays:
        cotangent_axes = [0] * (len(values) - len(fixed_axes))
        pulled = jax.vmap(pullback, in_axes=(*fixed_axes, *cotangent_axes))(*values)
        return [
            jnp.sum(value, axis=0) if axis is None else jnp.moveaxis(value, 0, axis)
            for value, axis in zip(pulled, linear_axes, strict=True)
        ]

    return pull_back


def _push(
    primals: Arrays, tangents: Arrays, *, function: Callable, pullback: Callable | None, residuals: int
) -> Any:
    """The tangents are a second call, linear in the moving arguments, that computes the primals anew."""
    results = call_p.bind(*primals, function=function, pullback=pullback, residuals=residuals)
    moving = [number for number, tangent in enumerate(tangents) if type(tangent) is not ad.Zero]

    def along(primals: Arrays) -> Callable[..., Arrays]:
        def moved(*arguments: Any) -> Arrays:
            placed = dict(zip(moving, arguments, strict=True))
            return list(function(*(placed.get(number, primal) for number, primal in enumerate(primals))))

        return moved

    def push_forward(*values: Any) -> Arrays:
        primals, directions = values[: len(tangents)], values[len(tangents) :]
        return jax.jvp(along(primals), [primals[number] for number in moving], list(directions))[1]

    def pull_back(*values: Any) -> Arrays:
        primals, cotangents = values[: len(tangents)], values[len(tangents) :]
        return jax.vjp(along(primals), *(primals[number] for number in moving))[1](list(cotangents))

    pushed = call_p.bind(
        *primals,
        *(tangents[number] for number in moving),
        function=push_forward,
        pullback=pull_back,
        residuals=len(primals),
    )
    return results, pushed


def _transpose(
    cotangents: Arrays, *arrays: Any, function: Callable, pullback: Callable, residuals: int
) -> list[Any | None]:
    given = [ad.instantiate_zeros(cotangent) for cotangent in cotangents]
    pulled = call_p.bind(
        *arrays[:residuals], *given, function=pullback, pullback=None, residuals=residuals + len(given)
    )
    linear = [
        value if ad.is_undefined_primal(array) else None
        for value, array in zip(pulled, arrays[residuals:], strict=True)
    ]
    return [None] * residuals + linear


mlir.register_lowering(call_p, _lower)
batching.primitive_batchers[call_p] = _batch
ad.primitive_jvps[call_p] = _push
ad.primitive_transposes[call_p] = _transpose
