"""Contacts: how the friction force arises from the sliding of the mass, through stick and slip.

A contact advances from node to node of the time grid. Around each node lies a window of one step in which the
mass moves with a known mean velocity before the node; the contact answers with the friction force at the node
and with the mean force over the window, so that an event inside the window costs no order of accuracy.
"""

import abc
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxstick.parameter import parameter
from jaxstick.parts.motion import Scalar
from jaxstick.parts.track import Trace
from jaxstick.parts.yielding import Window, yielding


class Traction(NamedTuple):
    """The friction law at the present motion, as functions of sliding velocity and direction of loading."""

    limit: Callable[[Scalar, Scalar], Scalar]
    viscous: Callable[[Scalar, Scalar], Scalar]


class Passage(NamedTuple):
    """The passage from one node to the next as the contact sees it.

    step [s]; slide, by how much the mass slid between the nodes [m]; rate, the sliding velocity expected at
    the node [m/s]; acceleration, the sliding acceleration there without friction [m/s^2]; inertia [kg].
    """

    step: Scalar
    slide: Scalar
    rate: Scalar
    acceleration: Scalar
    inertia: Scalar


class Approach(NamedTuple):
    """How the contact comes to the first node: the force on the mass that its spring holds there [N], the
    sliding velocity [m/s], for how long it has held [s], the sense of the sliding before that, 1 or
    -1, 0 where it is not known: what yields element by element remembers it; and the sliding velocity in the
    time before the start [m/s], None where that is not known."""

    force: Scalar
    rate: Scalar
    rest: Scalar
    slid: Scalar = 0.0
    rates: Trace | None = None


class Grip(NamedTuple):
    """The contact's answer at a node: friction force on the mass there [N], its mean over the window [N],
    the factor on the inertia that the contact spring asks for in stick, and the share of the window in which
    the contact slips, 0 to 1."""

    friction: Scalar
    mean: Scalar
    inertia_factor: Scalar
    slip: Scalar
    state: Any


class AbstractContact(eqx.Module):
    """A contact between mass and guide with a local spring k1 (equations (3) and (4) of the 1987 paper)."""

    k1: eqx.AbstractVar[Float[Array, ""] | float]

    @abc.abstractmethod
    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Any]:
        """Friction force and private state at the first node; of the force that the spring is said to hold,
        what the law does not allow at this sliding velocity is cut to the limit.
        """

    @abc.abstractmethod
    def grip(self, state: Any, passage: Passage, traction: Traction) -> Grip:
        """The friction force at the node at the end of a passage, and the private state there."""


class AbstractFlowingContact(AbstractContact):
    """A contact whose spring deflection z obeys a differential equation: z' = rate, F = friction."""

    @abc.abstractmethod
    def rate(self, deflection: Scalar, slide_rate: Scalar, traction: Traction) -> Scalar:
        """The rate of the spring's deflection [m/s]."""

    @abc.abstractmethod
    def friction(self, deflection: Scalar, slide_rate: Scalar, traction: Traction) -> Scalar:
        """The friction force on the mass [N]."""


def sense_of(value: Scalar) -> Scalar:
    """+1 or -1, never 0."""
    return jnp.where(value < 0, -1.0, 1.0)


def fitted_inertia(k1: Scalar, passage: Passage) -> Scalar:
    """By what share to raise the mass so that the contact rings at its own frequency at any step.

    A central difference with step h makes a spring-mass of frequency w ring at 2/h asin(w h/2). With the mass
    multiplied by 1 + q/12 + q^2/144, q = k1 h^2/m, the frequency is right to order h^4 and the step is
    stable for every k1 (Numerov's method is the first correction; the second is the least that never lets
    the factor fall below q/4).
    """
    twelfth = k1 * passage.step**2 / (12 * passage.inertia)
    return twelfth * (1 + twelfth)


class LoadedState(NamedTuple):
    """Deflection of the contact spring [m]; by how much the last trial force exceeded the limit [N], above 0
    in slip."""

    deflection: Scalar
    excess: Scalar


class LoadedContact(AbstractFlowingContact):
    """An elastic-plastic (Jenkins) contact whose limit depends on the sliding velocity.

    z' = v while |k1 z| is below g(|v|) or while z unloads; otherwise k1 z = sign(v) g(|v|), and the viscous
    part of the law acts. The force is continuous from slip to stick.
    """

    k1: Float[Array, ""] | float = parameter("N/m", "stiffness of the contact in stick", lower=0.0)

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, LoadedState]:
        force, rate, *_ = approach
        direction = sense_of(-force)
        limit = traction.limit(rate, direction)
        static = traction.limit(0.0, direction)
        held = jnp.clip(force, -static, static)
        slips = (-held * rate > 0) & (jnp.abs(held) >= limit)
        held = jnp.where(slips, -direction * limit, held)
        drag = jnp.where(slips, traction.viscous(rate, direction) * rate, 0.0)
        excess = jnp.where(slips, jnp.abs(force) - limit, jnp.minimum(jnp.abs(held) - limit, 0.0))
        return held - drag, LoadedState(-held / self.k1, excess)

    def grip(self, state: LoadedState, passage: Passage, traction: Traction) -> Grip:
        trial = state.deflection + passage.slide
        direction = sense_of(trial)
        mobility = passage.step / 2 * (1 / passage.inertia)
        window = Window(
            slide=passage.slide,
            trial=trial,
            limit=traction.limit(passage.rate, direction),
            before=state.excess,
            stiffness=self.k1,
            viscous=traction.viscous(passage.rate, direction),
            coasting=passage.slide * (1 / passage.step) + passage.step / 2 * passage.acceleration,
            mobility=mobility,
            fitting=fitted_inertia(self.k1, passage),
        )
        found = yielding(window)
        return Grip(
            found.friction,
            found.mean,
            found.inertia_factor,
            found.slip,
            LoadedState(found.deflection, found.excess),
        )

    def rate(self, deflection: Scalar, slide_rate: Scalar, traction: Traction) -> Scalar:
        return jnp.where(self._slips(deflection, slide_rate, traction), 0.0, slide_rate)

    def friction(self, deflection: Scalar, slide_rate: Scalar, traction: Traction) -> Scalar:
        direction = sense_of(deflection)
        limit = traction.limit(slide_rate, direction)
        slip = -direction * limit - traction.viscous(slide_rate, direction) * slide_rate
        return jnp.where(self._slips(deflection, slide_rate, traction), slip, -self.k1 * deflection)

    def _slips(self, deflection: Scalar, slide_rate: Scalar, traction: Traction) -> Array:
        limit = traction.limit(slide_rate, sense_of(deflection))
        return (self.k1 * jnp.abs(deflection) >= limit) & (deflection * slide_rate > 0)


class PaperState(NamedTuple):
    """Deflection since the last arrest [m]; sense of slip, +1 or -1, or 0 in stick."""

    deflection: Scalar
    slip: Scalar


class PaperContact(AbstractContact):
    """The contact in the words of the 1987 paper.

    At arrest (v changes sign in slip) x_stop = x, so the spring and the force restart from zero; the contact
    holds while |k1 (x - x_stop)| < A + C, whatever the velocity, and then slips by the law. The force jumps
    at both events; each is placed inside its window by the time at which it falls.
    """

    k1: Float[Array, ""] | float = parameter("N/m", "stiffness of the contact in stick", lower=0.0)

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, PaperState]:
        force, rate, *_ = approach
        direction = sense_of(-force)
        slips = jnp.abs(force) >= traction.limit(0.0, direction)
        onward = sense_of(rate)
        slip = -onward * traction.limit(rate, onward) - traction.viscous(rate, onward) * rate
        return (
            jnp.where(slips, slip, force),
            PaperState(jnp.where(slips, 0.0, -force / self.k1), jnp.where(slips, onward, 0.0)),
        )

    def grip(self, state: PaperState, passage: Passage, traction: Traction) -> Grip:
        h = passage.step
        before = passage.slide / h
        sticks = state.slip == 0
        direction = jnp.where(sticks, sense_of(before), state.slip)
        slipping = -direction * traction.limit(passage.rate, direction)
        slipping -= traction.viscous(passage.rate, direction) * passage.rate

        # Stuck when the window opens: the spring is wound up at the rate `before` and may break away.
        wound = state.deflection + passage.slide
        opening = wound - passage.slide / 2
        static = direction * traction.limit(0.0, direction) / self.k1
        winding = jnp.where(before == 0, 1.0, before)
        breakaway = jnp.where(before == 0, jnp.inf, (static - opening) / winding)
        breaks = breakaway < h
        held = jnp.where(breaks, jnp.clip(breakaway / h, 0.0, 1.0), 1.0)
        mean_stuck = (
            held * (-self.k1) * jnp.where(breaks, (opening + static) / 2, wound) + (1 - held) * slipping
        )

        # Slipping when the window opens: the mass is slowed by the full law and may come to rest.
        change = h * (passage.acceleration + slipping / passage.inertia)
        stops = direction * (before + change) <= 0
        gone = jnp.where(stops, jnp.clip(-before / jnp.where(stops, change, 1.0), 0.0, 1.0), 1.0)
        stop = (gone * before - before) * h / 2  # where it rests, counted from the node
        mean_slip = gone * slipping

        node_slips = jnp.where(sticks, breaks & (breakaway < h / 2), ~(stops & (gone < 0.5)))
        deflection = jnp.where(sticks, wound, -stop)
        after = jnp.where(sticks, jnp.where(breaks, direction, 0.0), jnp.where(stops, 0.0, direction))
        return Grip(
            jnp.where(node_slips, slipping, -self.k1 * deflection),
            jnp.where(sticks, mean_stuck, mean_slip),
            jnp.where(sticks & ~breaks, 1 + fitted_inertia(self.k1, passage), 1.0),
            jnp.where(sticks, 1 - held, gone),
            PaperState(jnp.where(after == 0, deflection, 0.0), after),
        )


class SmoothContact(AbstractFlowingContact):
    """An elasto-plastic bristle, an ordinary differential equation that every diffrax solver takes.

    z' = v (1 - alpha z sign(v) / z_ss), z_ss = g(|v|)/k1, F = -k1 z - D (v - z'), with alpha rising from 0 at
    |z| = breakaway z_ss to 1 at |z| = z_ss along half a sine, and 0 while z unloads. Source: Dupont, Hayward,
    Armstrong, Altpeter, IEEE Trans. Automatic Control 47 (2002) 787, with sigma_0 = k1 and sigma_1 = 0; the
    viscous part acts on the plastic rate, so that it is silent in stick.
    """

    k1: Float[Array, ""] | float = parameter("N/m", "stiffness of the contact in stick", lower=0.0)
    breakaway: Float[Array, ""] | float = parameter(
        "1", "share of the limit at which yielding begins", lower=0.0, upper=1.0, default=0.9
    )

    def initial(self, approach: Approach, traction: Traction) -> tuple[Scalar, Scalar]:
        force, rate, *_ = approach
        direction = sense_of(-force)
        limit = traction.limit(rate, direction)
        deflection = -jnp.where(-force * rate > 0, jnp.clip(force, -limit, limit), force) / self.k1
        return self.friction(deflection, rate, traction), deflection

    def rate(self, deflection: Scalar, slide_rate: Scalar, traction: Traction) -> Scalar:
        yielding, full = self._yielding(deflection, slide_rate, traction)
        return slide_rate * (1 - yielding * jnp.abs(deflection) / full)

    def friction(self, deflection: Scalar, slide_rate: Scalar, traction: Traction) -> Scalar:
        plastic = slide_rate - self.rate(deflection, slide_rate, traction)
        viscous = traction.viscous(slide_rate, sense_of(deflection))
        return -self.k1 * deflection - viscous * plastic

    def grip(self, state: Scalar, passage: Passage, traction: Traction) -> Grip:
        middle = self._flow(state, passage.slide / 2, state, passage.rate, traction)
        deflection = self._flow(state, passage.slide, middle, passage.rate, traction)
        friction = self.friction(deflection, passage.rate, traction)
        yielding, full = self._yielding(deflection, passage.rate, traction)
        slip = yielding * jnp.abs(deflection) / full
        return Grip(friction, friction, jnp.ones_like(friction), slip, deflection)

    def _yielding(self, deflection: Scalar, slide_rate: Scalar, traction: Traction) -> tuple[Scalar, Scalar]:
        full = traction.limit(slide_rate, sense_of(deflection)) / self.k1
        share = jnp.clip((jnp.abs(deflection) / full - self.breakaway) / (1 - self.breakaway), 0.0, 1.0)
        loading = deflection * slide_rate > 0
        return jnp.where(loading, 0.5 - 0.5 * jnp.cos(jnp.pi * share), 0.0), full

    def _flow(
        self, start: Scalar, slide: Scalar, at: Scalar, slide_rate: Scalar, traction: Traction
    ) -> Scalar:
        """The deflection after sliding by `slide`, with the yielding frozen at deflection `at`."""
        yielding, full = self._yielding(
            at, slide, traction._replace(limit=lambda _, s: traction.limit(slide_rate, s))
        )
        exponent = yielding * jnp.abs(slide) / full
        mean = jnp.where(
            exponent > 1e-12, -jnp.expm1(-exponent) / jnp.where(exponent > 1e-12, exponent, 1.0), 1.0
        )
        return start + slide * (1 - yielding * jnp.abs(start) / full) * mean
