"""The return mapping of a loaded contact over one window, and its derivative in closed form.

The derivative is written out because the force hangs on nine quantities alone: whatever the number of
parameters one differentiates by, their tangents pass through the same few coefficients, which are computed
once, where differentiation line by line would carry every tangent through every line.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jaxtyping import Array

from jaxstick.parts.motion import Scalar


class Window(NamedTuple):
    """What the contact knows of a window of one step around a node.

    slide, by how much the mass slid since the last node [m], of which only the sign counts; trial, the
    deflection of the contact spring if it only sticks [m]; limit, the force at which it yields [N]; before,
    the excess of the last trial force over the limit [N]; stiffness k1 [N/m]; viscous slope of the law
    [N s/m]; coasting, the velocity at the node if nothing but the friction were absent [m/s]; mobility, half
    a step over the inertia [s/kg]; fitting, by what share stick raises the inertia.
    """

    slide: Scalar
    trial: Scalar
    limit: Scalar
    before: Scalar
    stiffness: Scalar
    viscous: Scalar
    coasting: Scalar
    mobility: Scalar
    fitting: Scalar


class Yielding(NamedTuple):
    """friction at the node and its mean over the window [N]; the factor on the inertia; the share of the
    window in which the contact slips; deflection of its spring at the node [m]; the excess to keep [N]."""

    friction: Array
    mean: Array
    inertia_factor: Array
    slip: Array
    deflection: Array
    excess: Array


class _Branch(NamedTuple):
    """Where in its window the contact is, and the quantities from which force and derivative follow.

    sense of the deflection; excess of the trial force over the limit [N]; slips, whether the node lies in
    slip; slid, whether the last one did; change of the excess over the window and its size [N]; share of slip
    in the window; mean force of the spring [N]; drag, the viscous force [N]; withheld, by what the drag
    divides the velocity that it acts on.
    """

    sense: Array
    excess: Array
    slips: Array
    slid: Array
    change: Array
    size: Array
    share: Array
    mean: Array
    drag: Array
    withheld: Array


def _least(value: Scalar, other: Scalar) -> Array:
    """The lesser; unlike `jnp.minimum` one instruction, since neither is NaN unless all is."""
    return jnp.where(value < other, value, other)


def _between(value: Scalar, upper: Scalar) -> Array:
    """The value cut to 0 and `upper`."""
    return _least(jnp.where(value > 0, value, 0.0), upper)


def _branch(window: Window, *, apart: bool) -> _Branch:
    """The two excesses at the last node and at this one, the middle of the window, are joined by a line.

    In stick both are at most zero; the line crosses zero at breakaway, and the mean force falls short of the
    limit by the mean of its negative part, which places the kink of the force where it falls. In slip each is
    the plastic part of its step, and the line crosses zero where sliding ends, without a kink.

    `apart` says whether the share of slip is to be a result of its own, for many to use: XLA's compiler for
    CPUs computes anew in every loop what ends in anything but a division.
    """
    slide, trial, limit, before, stiffness, viscous, coasting, mobility, _ = window
    sense = jnp.where(trial < 0, -1.0, 1.0)
    excess = stiffness * jnp.abs(trial) - limit
    loads = slide * sense > 0
    slid = jnp.asarray(before > 0)
    change = excess - before
    size = jnp.where(change == 0, 1.0, jnp.abs(change))
    breaking = jnp.where(change > 0, _between(excess + 0.5 * size, size), 0.0)
    ending = jnp.where(change < 0, _between(excess, size), size)
    slipped = jnp.where(slid, ending, breaking)
    share = jnp.where(loads, slipped, 0.0) / size if apart else jnp.where(loads, slipped / size, 0.0)
    shortfall = jnp.where(slid, 0.0, 0.5 * (1 - share) * (1 - share) * change)
    mean = jnp.where(share > 0, sense * (shortfall - limit), -stiffness * trial)
    withheld = 1 + mobility * share * viscous
    drag = viscous * (coasting + mobility * mean) / withheld
    return _Branch(sense, excess, loads & (excess > 0), slid, change, size, share, mean, drag, withheld)


def _force(window: Window, at: _Branch) -> Yielding:
    # The reciprocal of a constant is taken once, outside the loop over time.
    deflection = jnp.where(at.slips, at.sense * window.limit * (1 / window.stiffness), window.trial)
    return Yielding(
        -window.stiffness * deflection - jnp.where(at.slips, at.drag, 0.0),
        at.mean - at.share * at.drag,
        1 + (1 - at.share) * window.fitting,
        at.share,
        deflection,
        jnp.where(at.slips, at.excess, _least(at.excess, 0.0)),
    )


@jax.custom_jvp
def yielding(window: Window) -> Yielding:
    """The friction of a loaded contact over one window.

    The trial force is cut to the limit where it is beyond it; the viscous part of the law acts in slip, on
    the velocity that it changes itself (implicitly, so that no slope asks for a smaller step).
    """
    return _force(window, _branch(window, apart=False))


def _derivative(primals: tuple[Window], tangents: tuple[Window]) -> tuple[Yielding, Yielding]:
    (window,), (moved,) = primals, tangents
    at = _branch(window, apart=True)
    _, trial, limit, _, stiffness, viscous, _, mobility, fitting = window
    yields = at.share > 0
    slope = jnp.where(yields & (at.share < 1), 1.0, 0.0) / at.size
    share_excess = slope * jnp.where(at.slid, 1 + at.share, 1.5 - at.share)
    share_before = slope * jnp.where(at.slid, -at.share, at.share - 0.5)
    stick = jnp.where(at.slid, 0.0, 1 - at.share)
    half = 0.5 * stick * stick
    lack_excess = half - stick * at.change * share_excess
    lack_before = -half - stick * at.change * share_before

    per_excess = {"trial": stiffness * at.sense, "limit": -1.0, "stiffness": jnp.abs(trial)}
    stuck = {"trial": -stiffness, "limit": 0.0, "stiffness": -trial}
    share = {name: share_excess * by for name, by in per_excess.items()} | {"before": share_before}
    mean = {
        name: jnp.where(yields, at.sense * lack_excess * by, stuck[name]) for name, by in per_excess.items()
    }
    mean["limit"] = mean["limit"] - jnp.where(yields, at.sense, 0.0)
    mean["before"] = jnp.where(yields, at.sense * lack_before, 0.0)

    passed = 1 / at.withheld
    whole = {name: passed * (by - at.drag * share[name]) for name, by in mean.items()}
    drag = {name: mobility * viscous * by for name, by in whole.items()} | {
        "viscous": passed * (window.coasting + mobility * (at.mean - at.share * at.drag)),
        "coasting": passed * viscous,
        "mobility": passed * viscous * (at.mean - at.share * at.drag),
    }
    whole |= {name: -at.share * drag[name] for name in ("viscous", "coasting", "mobility")}
    factor = {name: -fitting * by for name, by in share.items()} | {"fitting": 1 - at.share}
    per_stiffness = 1 / stiffness
    deflection = {
        "trial": jnp.where(at.slips, 0.0, 1.0),
        "limit": jnp.where(at.slips, at.sense * per_stiffness, 0.0),
        "stiffness": jnp.where(at.slips, -at.sense * limit * per_stiffness * per_stiffness, 0.0),
    }
    node = {
        "trial": jnp.where(at.slips, 0.0, -stiffness),
        "limit": jnp.where(at.slips, -at.sense, 0.0),
        "stiffness": jnp.where(at.slips, 0.0, -trial),
    }
    friction = {name: node.get(name, 0.0) - jnp.where(at.slips, by, 0.0) for name, by in drag.items()}
    kept = at.slips | (at.excess < 0)
    excess = {name: jnp.where(kept, by, 0.0) for name, by in per_excess.items()}
    rows = (friction, whole, factor, share, deflection, excess)
    value = _force(window, at)
    return value, Yielding(*(_along(row, moved, like) for row, like in zip(rows, value, strict=True)))


def _along(slopes: dict[str, Any], moved: Window, like: Array) -> Array:
    """The sum of slope times tangent over what moves at all."""
    terms: Sequence[Any] = [
        slope * getattr(moved, name)
        for name, slope in slopes.items()
        if not isinstance(getattr(moved, name), SymbolicZero)
    ]
    return functools.reduce(operator.add, terms) if terms else jnp.zeros_like(like)


yielding.defjvp(_derivative, symbolic_zeros=True)
