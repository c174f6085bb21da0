"""What every stateful part has in common: a private state that it alone understands."""

from __future__ import annotations

from typing import Any

import equinox as eqx

from jaxstick.parts.motion import Motion, Scalar


class AbstractPart(eqx.Module):
    """A part of the oscillator with a private state, opaque to everyone else.

    A part without memory keeps the defaults: its state is None and nothing advances.
    """

    def initial(self) -> Any:
        """The private state of a part that has been at rest for long."""
        return None

    def advance(self, state: Any, motion: Motion, step: Scalar) -> Any:
        """The private state one step later [s]; `motion` is the motion at the end of the step."""
        del motion, step
        return state
