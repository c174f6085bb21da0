"""The oscillator: its parts put together, its state and its equation of motion."""

from __future__ import annotations

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from jaxstick.parts.before import Before
from jaxstick.parts.contact import AbstractContact, AbstractFlowingContact, Approach, Passage, Traction
from jaxstick.parts.drive import AbstractDrive, Excitation
from jaxstick.parts.friction import AbstractFriction
from jaxstick.parts.guide import Surface
from jaxstick.parts.instrument import AbstractInstrument, IdealInstrument, Past
from jaxstick.parts.kept import kept
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig
from jaxstick.parts.track import Stick, Trace, Track

PROBE = 1e-7
"""Time [s] over which the rate of the friction force is taken at the start of a motion."""


class Start(NamedTuple):
    """How a motion begins: displacement [m], velocity [m/s], friction force held by the contact [N]; and,
    where it is picked up in the middle of a record, what is known of the time before."""

    displacement: Scalar = 0.0
    velocity: Scalar = 0.0
    friction: Scalar = 0.0
    before: Before = Before()


class State(NamedTuple):
    """Displacement, velocity of the mass [m, m/s], friction force on it [N], private states of the parts."""

    x: Scalar
    v: Scalar
    friction: Scalar
    contact: Any
    rig: Any
    law: Any
    instrument: Any


class Flow(NamedTuple):
    """The state of an oscillator as a differential equation: x [m], v [m/s], spring deflection [m]."""

    x: Scalar
    v: Scalar
    deflection: Scalar


class Oscillator(eqx.Module):
    """A mass on a rig, excited by a drive, rubbing by a law through a contact, seen by an instrument.

    m x'' = rig force + F. Every part can be replaced or wrapped on its own.
    """

    rig: AbstractRig
    drive: AbstractDrive
    friction: AbstractFriction
    contact: AbstractContact
    instrument: AbstractInstrument = IdealInstrument()

    def motion(self, t: Scalar, excitation: Excitation, x: Scalar, v: Scalar, a: Scalar) -> Motion:
        """What the parts see when the mass is at `x` with velocity `v` under this excitation at time `t`."""
        surface = self.rig.surface(excitation)
        return Motion(
            t, x, v, a, *excitation, slide=x - surface.position, slide_rate=v - surface.rate, direction=1.0
        )

    def traction(self, law_state: Any, motion: Motion) -> Traction:
        """The friction law at this motion, open in sliding velocity and direction of loading."""

        def at(rate: Scalar, direction: Scalar) -> Motion:
            return motion._replace(slide_rate=rate, direction=direction)

        return Traction(
            limit=lambda rate, direction: kept(self.friction.limit(law_state, at(rate, direction))),
            viscous=lambda rate, direction: kept(self.friction.viscous(law_state, at(rate, direction))),
        )

    def initial(self, t: Scalar, start: Start) -> State:
        """The state at time `t` [s] of a motion that begins as `start` says."""
        before = start.before
        excitation = self.drive.at(t)
        motion = self.motion(t, excitation, start.displacement, start.velocity, 0.0)
        motion = motion._replace(slid=before.slid, track=before.track)
        law = self.friction.initial(motion)
        traction = self.traction(law, motion)
        motion = motion._replace(stick=self._stick(motion, start, traction))
        rig = self.rig.initial(motion)
        rates = None if before.track is None else self._slid(before.track).rates()
        approach = Approach(start.friction, motion.slide_rate, before.rest, before.slid, rates)
        friction, contact = self.contact.initial(approach, traction)
        motion = motion._replace(
            track=None, stick=None, a=(self.rig.force(rig, motion) + friction) / self.rig.inertia()
        )
        rate = self._friction_rate(motion, self.rig.surface(excitation), rig, contact, traction)
        instrument = self.instrument.initial(motion, friction, Past(rate, before))
        return State(start.displacement, start.velocity, friction, contact, rig, law, instrument)

    def _slid(self, track: Track) -> Trace:
        """By how far the mass had slid before a start [m]."""
        base = jnp.asarray(track.base)
        still = jnp.zeros_like(base)
        surface = self.rig.surface(Excitation(base, still, still, still))
        return Trace(track.lags, track.displacement - surface.position)

    def _stick(self, motion: Motion, start: Start, traction: Traction) -> Stick:
        """What holds the mass at a start, which came to rest when the friction force was at its limit."""
        before = start.before
        slid = jnp.asarray(before.slid)
        sense = jnp.where(slid < 0, -1.0, 1.0)
        sticks = jnp.abs(start.friction) < traction.limit(motion.slide_rate, sense)
        arrest = -slid * traction.limit(0.0, sense)
        known = ~jnp.isnan(before.recorded)
        return Stick(sticks, start.friction, arrest, self.contact.k1, slid, before.rest, known, before.shown)

    def _friction_rate(
        self, motion: Motion, surface: Surface, rig: Any, contact: Any, traction: Traction
    ) -> Scalar:
        """The rate of the friction force at the start of a motion [N/s]: the contact's answer to a passage of
        2 `PROBE`, less that to one of `PROBE`."""
        inertia = self.rig.inertia()
        free = self.rig.force(rig, motion) / inertia - surface.acceleration

        def after(span: Scalar) -> Scalar:
            gain = span * (motion.a - surface.acceleration)
            slide = span * (motion.slide_rate + gain / 2)
            passage = Passage(span, slide, motion.slide_rate + gain, free, inertia)
            return self.contact.grip(contact, passage, traction).friction

        forces = jnp.asarray(jax.vmap(after)(PROBE * jnp.array([1.0, 2.0])))
        return (forces[1] - forces[0]) / PROBE

    def acceleration(self, t: Scalar, state: State) -> Scalar:
        """The acceleration of the mass [m/s^2] in this state."""
        motion = self.motion(t, self.drive.at(t), state.x, state.v, 0.0)
        return (self.rig.force(state.rig, motion) + state.friction) / self.rig.inertia()

    def vector_field(self, t: Scalar, flow: Flow, args: Any = None) -> Flow:
        """The rate of change of (x, v, z), a vector field as diffrax takes it.

        With the smooth contact it is an ordinary differential equation for any solver. With the loaded
        contact it is right inside each phase but jumps between them, which no adaptive solver may be given;
        `jaxstick.solver.ReturnMapping` integrates that one. Parts with memory are not part of this form.

        Raises TypeError for a contact that is not a flow (`PaperContact`).
        """
        del args
        if not isinstance(self.contact, AbstractFlowingContact):
            raise TypeError(
                f"{type(self.contact).__name__} has no vector field; integrate it with ReturnMapping"
            )
        motion = self.motion(t, self.drive.at(t), flow.x, flow.v, 0.0)
        traction = self.traction(self.friction.initial(motion), motion)
        friction = self.contact.friction(flow.deflection, motion.slide_rate, traction)
        force = self.rig.force(self.rig.initial(motion), motion) + friction
        rate = self.contact.rate(flow.deflection, motion.slide_rate, traction)
        return Flow(flow.v, force / self.rig.inertia(), rate)
