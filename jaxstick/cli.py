"""The lower commands: what can be done without fitting."""

import click

from jaxstick.command import Verbs
from jaxstick.compilation_cache import set_up_jax
from jaxstick.freed_memory import keep_freed_memory
from jaxstick.verbs.check import check
from jaxstick.verbs.effects import effects
from jaxstick.verbs.simulate import simulate
from jaxstick.verbs.sweep import sweep
from jaxstick.version import version

LOWER = (check, simulate, sweep, effects)


@click.group(cls=Verbs, commands=LOWER)
@click.version_option(version(), prog_name="jaxstick")
def jaxstick() -> None:
    """Stick-slip of a base-excited friction oscillator: look at records and simulate them."""


def main() -> None:
    """`python -m jaxstick`."""
    set_up_jax()
    keep_freed_memory()
    jaxstick(prog_name="python -m jaxstick")
