"""The command's frame: options that every verb has, and one sentence and an exit code for every mishap."""

import errno
import os
import re
import sys
import traceback
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, NoReturn

import click

from jaxstick.errors import UserError
from jaxstick.terminal import Terminal

DONE, FAILED, MISTAKE = 0, 1, 2

DEBUG = "JAXSTICK_DEBUG"
"""The environment variable that asks for a traceback where jaxstick fails."""


class Verbs(click.Group):
    """A group of commands that ends with 0 (done), 2 (the user's mistake) or 1 (a failure of ours).

    A mistake and a failure are one sentence on standard error. A command that returns a number ends with it.
    """

    def main(self, *args: Any, **kwargs: Any) -> NoReturn:
        """Runs one command line and exits."""
        kwargs["standalone_mode"] = False
        try:
            code = super().main(*args, **kwargs)
            sys.stdout.flush()
        except UserError as error:
            code = _end(MISTAKE, str(error))
        except click.exceptions.NoArgsIsHelpError as error:
            click.echo(error.format_message())
            code = DONE
        except click.ClickException as error:
            code = _end(MISTAKE, _usage(error))
        except (click.Abort, KeyboardInterrupt):
            code = _end(FAILED, "stopped before it was done; nothing was written.")
        except OSError as error:
            code = _closed_pipe() if error.errno == errno.EPIPE else _failed(error)
        except Exception as error:
            code = _failed(error)
        sys.exit(code if isinstance(code, int) else DONE)


def common(function: Callable[..., Any]) -> Callable[..., Any]:
    """Gives a command the options --quiet, --json and --seed, handed to it as `terminal`."""

    @click.option("--quiet", is_flag=True, help="Say nothing but what went wrong.")
    @click.option("--json", is_flag=True, help="Print the result as JSON, and words to standard error.")
    @click.option(
        "--seed", type=click.IntRange(min=0), default=0, metavar="N", help="Seed of everything random (0)."
    )
    @wraps(function)
    def with_terminal(*args: Any, quiet: bool, json: bool, seed: int, **kwargs: Any) -> Any:
        return function(*args, terminal=Terminal(quiet, json, seed), **kwargs)

    return with_terminal


def rig_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """Gives a command the option --rig, a file to be read in place of the data set's rig.toml."""
    return click.option(
        "--rig",
        metavar="RIG.toml",
        type=click.Path(path_type=Path),
        help="Read this rig file in place of the data set's own rig.toml.",
    )(function)


def _end(code: int, sentence: str) -> int:
    click.echo(f"jaxstick: {sentence}", err=True)
    return code


def _usage(error: click.ClickException) -> str:
    """Click's own message as one sentence."""
    message = " ".join(error.format_message().split())
    message = re.sub(r"\. Did you mean (.*)\?$", r" (did you mean \1?)", message).rstrip(".")
    context = getattr(error, "ctx", None)
    return f"{message}; see {context.command_path} --help." if context else f"{message}."


def _failed(error: Exception) -> int:
    if os.environ.get(DEBUG):
        traceback.print_exception(error)
    said = " ".join(str(error).split())
    what = f"{type(error).__name__}: {said}" if said else type(error).__name__
    return _end(FAILED, f"this failed through a fault of its own ({what[:300]}); {DEBUG}=1 shows where.")


def _closed_pipe() -> int:
    """Whoever read our output has gone; what is still buffered goes nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return FAILED
