"""The oscillator: its parts put together, its state and its equation of motion."""

from __future__ import annotations

from typing import Any, NamedTuple

import equinox as eqx

from jaxstick.parts.contact import AbstractContact, AbstractFlowingContact, Traction
from jaxstick.parts.drive import AbstractDrive, Excitation
from jaxstick.parts.friction import AbstractFriction
from jaxstick.parts.instrument import AbstractInstrument, IdealInstrument
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.rig import AbstractRig


class Start(NamedTuple):
    """How a motion begins: displacement [m], velocity [m/s], friction force held by the contact [N]."""

    displacement: Scalar = 0.0
    velocity: Scalar = 0.0
    friction: Scalar = 0.0


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
            limit=lambda rate, direction: self.friction.limit(law_state, at(rate, direction)),
            viscous=lambda rate, direction: self.friction.viscous(law_state, at(rate, direction)),
        )

    def initial(self, t: Scalar, start: Start) -> State:
        """The state at time `t` [s] of a motion that begins as `start` says."""
        rig, law = self.rig.initial(), self.friction.initial()
        motion = self.motion(t, self.drive.at(t), start.displacement, start.velocity, 0.0)
        traction = self.traction(law, motion)
        friction, contact = self.contact.initial(start.friction, motion.slide_rate, traction)
        instrument = self.instrument.initial(motion, friction)
        return State(start.displacement, start.velocity, friction, contact, rig, law, instrument)

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
        traction = self.traction(self.friction.initial(), motion)
        friction = self.contact.friction(flow.deflection, motion.slide_rate, traction)
        force = self.rig.force(self.rig.initial(), motion) + friction
        rate = self.contact.rate(flow.deflection, motion.slide_rate, traction)
        return Flow(flow.v, force / self.rig.inertia(), rate)
