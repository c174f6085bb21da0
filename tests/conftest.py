"""Strict numerics for every test: float64, no silent rank or type promotion, warnings are errors; programs
are compiled as they are for the command, and shared by the processes of one session."""

from __future__ import annotations

import contextlib
import os
import tempfile

import hypothesis
import jax
import pytest

from jaxstick.compilation_cache import set_up_jax
from jaxstick.precision import float64

hypothesis.settings.register_profile("dev", deadline=None, max_examples=25)
hypothesis.settings.register_profile(
    "ci", deadline=None, max_examples=25, derandomize=True, database=None, print_blob=True
)

SESSION = contextlib.ExitStack()
CACHE = "JAX_COMPILATION_CACHE_DIR"
LEAST_SECONDS = "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"


def pytest_configure(config: pytest.Config) -> None:
    """Before the test files are read, so that the arrays they make at the top are float64 too."""
    hypothesis.settings.load_profile("ci" if os.environ.get("CI") else "dev")
    _share_programs()
    set_up_jax()
    SESSION.enter_context(float64())
    SESSION.enter_context(jax.numpy_rank_promotion("raise"))
    SESSION.enter_context(jax.numpy_dtype_promotion("strict"))


def _share_programs() -> None:
    """One folder for a session: the first process makes it, those that it starts find it in their
    environment."""
    if CACHE not in os.environ:
        os.environ[CACHE] = SESSION.enter_context(tempfile.TemporaryDirectory(prefix="jaxstick-programs-"))
        os.environ.setdefault(LEAST_SECONDS, "0.5")


def pytest_unconfigure(config: pytest.Config) -> None:
    """Leaves jax as it was found."""
    SESSION.close()


@pytest.fixture
def user_session():
    """A session as jax comes out of the box: float32, lenient promotion."""
    with (
        jax.enable_x64(False),
        jax.numpy_rank_promotion("allow"),
        jax.numpy_dtype_promotion("standard"),
    ):
        yield
