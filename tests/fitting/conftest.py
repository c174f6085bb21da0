"""One small fit that many tests look at."""

from __future__ import annotations

from pathlib import Path

import jax
import pytest

from fitting.fit import fit
from fitting.result import Fit
from fitting.settings import Settings
from jaxstick.record import DataSet, load_dataset, save_dataset
from tests.fitting.tiny import tiny_dataset


@pytest.fixture(scope="session")
def tiny_folder(tmp_path_factory) -> Path:
    """The small data set as a folder."""
    folder = tmp_path_factory.mktemp("data") / "tiny"
    save_dataset(tiny_dataset(), folder)
    return folder


@pytest.fixture(scope="session")
def tiny(tiny_folder) -> DataSet:
    """The small data set, read from its folder."""
    return load_dataset(tiny_folder)


@pytest.fixture(scope="session")
def fitted(tiny) -> Fit:
    """The small data set's fit; optax counts on jax's ordinary promotion of types."""
    with jax.numpy_dtype_promotion("standard"), jax.numpy_rank_promotion("allow"):
        return fit(tiny, Settings(starts=2, descent_iterations=25, workers=1))
