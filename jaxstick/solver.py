"""The return-mapping scheme: fixed steps through stick and slip, alone and as a diffrax solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple, Self

import diffrax
import jax
import jax.numpy as jnp

from jaxstick.oscillator import Oscillator, State
from jaxstick.parts.contact import Passage
from jaxstick.parts.drive import Excitation
from jaxstick.parts.kept import kept_slope
from jaxstick.parts.motion import Scalar


def step(
    oscillator: Oscillator,
    t: Scalar,
    h: Scalar,
    before: Excitation,
    after: Excitation,
    state: State,
    acceleration: Scalar,
) -> tuple[State, Scalar]:
    """One return-mapping step of length `h` [s] to time `t`: the state at `t` and the acceleration there.

    A central difference in the mass (the velocity form of Stormer and Verlet) with a return mapping in the
    contact:

        v_half = v0 + h/2 a0,   x1 = x0 + h v_half,
        the contact's deflection grows by the slide and is returned to the limit where it is beyond it,
        a1 = (rig force + mean friction) / m,   v1 = v_half + h/2 a1.

    Second order in h, through events too. The rig's own spring asks for h < 2 sqrt(m/K), the contact's for
    nothing (see `jaxstick.parts.contact`). `acceleration` [m/s^2] is the one at the start of the step, as
    the step before returned it; `before` and `after` are the excitations at the two ends.
    """
    half = h / 2 * acceleration
    return _advance(oscillator, t, h, before, after, state, state.v + half, state.v + 2 * half, acceleration)


class Staggered(NamedTuple):
    """A state on the way: the velocities of the mass half a step behind its time and half a step ahead
    [m/s] stand in for its velocity and acceleration, which are their mean and their difference over the step.

    Of a step nothing but `ahead` then hangs on all that happens in it.
    """

    state: State
    behind: Scalar
    ahead: Scalar

    @classmethod
    def of(cls, state: State, acceleration: Scalar, h: Scalar) -> Self:
        """The state with this acceleration [m/s^2], for steps of length `h` [s]."""
        return cls(state, state.v - h / 2 * acceleration, state.v + h / 2 * acceleration)


def leap(
    oscillator: Oscillator,
    t: Scalar,
    h: Scalar,
    before: Excitation,
    after: Excitation,
    staggered: Staggered,
) -> tuple[Staggered, Scalar]:
    """The `step` from one staggered state to the next, whose `state` has its velocity right, and the
    acceleration there; for loops that need neither from step to step."""
    state, behind, ahead = staggered
    acceleration = (ahead - behind) * (1 / h)
    expected = 1.5 * ahead - 0.5 * behind
    state, reached = _advance(oscillator, t, h, before, after, state, ahead, expected, acceleration)
    return Staggered(state, ahead, ahead + h * reached), reached


def _advance(
    oscillator: Oscillator,
    t: Scalar,
    h: Scalar,
    before: Excitation,
    after: Excitation,
    state: State,
    half_rate: Scalar,
    expected: Scalar,
    acceleration: Scalar,
) -> tuple[State, Scalar]:
    """The step with the velocity in its middle and the one expected at its end [m/s]."""
    x = state.x + h * half_rate
    motion = oscillator.motion(t, after, x, expected, acceleration)
    surface0 = oscillator.rig.surface(before)
    surface1 = oscillator.rig.surface(after)
    inertia = oscillator.rig.inertia()
    per_inertia = 1 / inertia
    free = kept_slope(oscillator.rig.force(state.rig, motion) * per_inertia - surface1.acceleration)
    slide = h * half_rate - (surface1.position - surface0.position)
    passage = Passage(h, slide, motion.slide_rate, free, inertia)
    grip = oscillator.contact.grip(state.contact, passage, oscillator.traction(state.law, motion))
    reached = kept_slope(
        _quotient(free + grip.mean * per_inertia, grip.inertia_factor) + surface1.acceleration
    )
    v, friction = half_rate + h / 2 * reached, kept_slope(grip.friction)
    motion = motion._replace(
        v=v, a=reached, slide_rate=v - surface1.rate, direction=jnp.where(friction > 0, -1.0, 1.0)
    )
    state = State(
        x,
        v,
        friction,
        grip.state,
        oscillator.rig.advance(state.rig, motion, h),
        oscillator.friction.advance(state.law, motion, h),
        oscillator.instrument.advance(state.instrument, motion, friction, h),
    )
    return state, reached


@jax.custom_jvp
def _quotient(dividend: Scalar, divisor: Scalar) -> Scalar:
    """Dividend over divisor. Its derivative is taken from the quotient itself, so that the dividend need not
    be computed again for it."""
    return dividend / divisor


@_quotient.defjvp
def _quotient_slope(primals: tuple[Scalar, Scalar], tangents: tuple[Scalar, Scalar]) -> tuple[Scalar, Scalar]:
    quotient = _quotient(*primals)
    return quotient, (tangents[0] - quotient * tangents[1]) / primals[1]


class StickSlip(diffrax.AbstractTerm):
    """An oscillator as the term of a diffrax solve with `ReturnMapping`.

    A vector field says too little for a contact that sticks and slips, so what this term gives its solver in
    place of one is the oscillator itself.
    """

    oscillator: Oscillator

    def vf(self, t: Scalar, y: State, args: Any) -> Oscillator:
        """The oscillator."""
        del t, y, args
        return self.oscillator

    def contr(self, t0: Scalar, t1: Scalar, **kwargs: Any) -> Scalar:
        """The step [s]."""
        del kwargs
        return t1 - t0

    def prod(self, vf: Oscillator, control: Scalar) -> Any:
        """There is no product of an oscillator and a step: only `ReturnMapping` takes this term."""
        raise NotImplementedError("StickSlip is a term for ReturnMapping alone")


class ReturnMapping(diffrax.AbstractSolver):
    """The return-mapping scheme as a diffrax solver, for steps of constant size.

    `diffrax.diffeqsolve(StickSlip(oscillator), ReturnMapping(), t0, t1, dt0, y0)` with
    `y0 = oscillator.initial(t0, Start())`, its leaves made arrays, solves for the `State`.
    Between the ends of a step the solution is interpolated linearly.
    """

    term_structure: ClassVar = StickSlip
    interpolation_cls: ClassVar[Callable[..., diffrax.LocalLinearInterpolation]] = (
        diffrax.LocalLinearInterpolation
    )

    def order(self, terms: StickSlip) -> int:
        del terms
        return 2

    def init(self, terms: StickSlip, t0: Scalar, t1: Scalar, y0: State, args: Any) -> Scalar:
        del t1
        return terms.vf(t0, y0, args).acceleration(t0, y0)

    def step(
        self,
        terms: StickSlip,
        t0: Scalar,
        t1: Scalar,
        y0: State,
        args: Any,
        solver_state: Scalar,
        made_jump: Any,
    ) -> tuple[State, None, dict[str, State], Scalar, diffrax.RESULTS]:
        del made_jump
        oscillator = terms.vf(t0, y0, args)
        before, after = oscillator.drive.at(t0), oscillator.drive.at(t1)
        y1, acceleration = step(oscillator, t1, t1 - t0, before, after, y0, solver_state)
        return y1, None, {"y0": y0, "y1": y1}, acceleration, diffrax.RESULTS.successful

    def func(self, terms: StickSlip, t0: Scalar, y0: State, args: Any) -> Scalar:
        return terms.vf(t0, y0, args).acceleration(t0, y0)
