"""The return-mapping scheme: fixed steps through stick and slip, alone and as a diffrax solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import diffrax
import jax.numpy as jnp

from jaxstick.oscillator import Oscillator, State
from jaxstick.parts.contact import Passage
from jaxstick.parts.drive import Excitation
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
    half_rate = state.v + h / 2 * acceleration
    x = state.x + h * half_rate
    expected = half_rate + h / 2 * acceleration
    motion = oscillator.motion(t, after, x, expected, acceleration)
    surface0 = oscillator.rig.surface(before)
    surface1 = oscillator.rig.surface(after)
    inertia = oscillator.rig.inertia()
    free = oscillator.rig.force(state.rig, motion) / inertia - surface1.acceleration
    slide = x - state.x - (surface1.position - surface0.position)
    passage = Passage(h, slide, motion.slide_rate, free, inertia)
    grip = oscillator.contact.grip(state.contact, passage, oscillator.traction(state.law, motion))
    reached = (free + grip.mean / inertia) / grip.inertia_factor + surface1.acceleration
    v = half_rate + h / 2 * reached
    motion = motion._replace(
        v=v, a=reached, slide_rate=v - surface1.rate, direction=jnp.where(grip.friction > 0, -1.0, 1.0)
    )
    state = State(
        x,
        v,
        grip.friction,
        grip.state,
        oscillator.rig.advance(state.rig, motion, h),
        oscillator.friction.advance(state.law, motion, h),
        oscillator.instrument.advance(state.instrument, motion, grip.friction, h),
    )
    return state, reached


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
