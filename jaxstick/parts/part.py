"""What every stateful part has in common: a private state that it alone understands."""

from __future__ import annotations

from typing import Any

import equinox as eqx

from jaxstick.parts.motion import Motion, Scalar


class AbstractPart(eqx.Module):
    """A part of the oscillator with a private state, opaque to everyone else.

    A part without memory keeps the defaults: its state is None and nothing advances.
    """

    def initial(self, motion: Motion) -> Any:
        """The private state at the start of a motion, as likely as that start allows.

        A motion need not begin at rest: it may be picked up in the middle of a record.
        """
        del motion
        return None

    def advance(self, state: Any, motion: Motion, step: Scalar) -> Any:
        """The private state one step later [s]; `motion` is the motion at the end of the step."""
        del motion, step
        return state
