"""The mechanics around the contact: mass, springs and viscous dampers."""

from __future__ import annotations

import abc
from typing import Any

from jaxtyping import Array, Float

from jaxstick.parameter import parameter
from jaxstick.parts.drive import Excitation
from jaxstick.parts.guide import AbstractGuide, GroundGuide, Surface
from jaxstick.parts.motion import Motion, Scalar
from jaxstick.parts.part import AbstractPart


class AbstractRig(AbstractPart):
    """A moving mass, the surface it rubs on and every force on it except friction."""

    @abc.abstractmethod
    def surface(self, excitation: Excitation) -> Surface:
        """How the surface that the mass rubs on moves under this excitation."""

    @abc.abstractmethod
    def inertia(self) -> Scalar:
        """The moving mass m [kg]."""

    @abc.abstractmethod
    def force(self, state: Any, motion: Motion) -> Scalar:
        """The force on the mass without friction [N]."""


class Rig(AbstractRig):
    """One mass on linear springs: m x'' = F + u + k_d y + c_d y' - K x - c x'  (physics of the 1987 paper).

    K and c are totals; k_d and c_d are the parts of them that join the mass to the base. K = 0 is a mass
    that only a force and friction move.
    """

    mass: Float[Array, ""] | float = parameter("kg", "moving mass m", lower=0.0)
    stiffness: Float[Array, ""] | float = parameter("N/m", "total stiffness K", lower=0.0)
    drive_stiffness: Float[Array, ""] | float = parameter("N/m", "stiffness k_d to the base", lower=0.0)
    damping: Float[Array, ""] | float = parameter("N s/m", "total damping c", lower=0.0, default=0.0)
    drive_damping: Float[Array, ""] | float = parameter(
        "N s/m", "damping c_d to the base", lower=0.0, default=0.0
    )
    guide: AbstractGuide = GroundGuide()

    def surface(self, excitation: Excitation) -> Surface:
        return self.guide.surface(excitation)

    def inertia(self) -> Scalar:
        return self.mass

    def force(self, state: Any, motion: Motion) -> Scalar:
        spring = self.drive_stiffness * motion.y - self.stiffness * motion.x
        damper = self.drive_damping * motion.y_rate - self.damping * motion.v
        return spring + damper + motion.u
