"""The whole command: the lower verbs, and those that fit and judge."""

import click

from fitting.verbs.blind import blind
from fitting.verbs.compare import compare
from fitting.verbs.diagnose import diagnose
from fitting.verbs.fit import fit
from jaxstick.cli import LOWER
from jaxstick.command import Verbs
from jaxstick.compilation_cache import set_up_jax
from jaxstick.freed_memory import keep_freed_memory
from jaxstick.version import version

UPPER = (fit, compare, diagnose, blind)


@click.group(cls=Verbs, commands=(*LOWER, *UPPER))
@click.version_option(version(), prog_name="jaxstick")
def jaxstick() -> None:
    """Stick-slip of a base-excited friction oscillator: simulate it, fit its friction to records, and find
    out why simulation and records differ.

    Ends with 0 when done, 2 where the input has to be mended, 1 where jaxstick failed or a result did not
    converge.
    """


def main() -> None:
    """The command `jaxstick`."""
    set_up_jax()
    keep_freed_memory()
    jaxstick(prog_name="jaxstick")
