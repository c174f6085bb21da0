"""What a fit returns: constants with intervals, the gap with its floor, and traces."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from jaxstick.hypothesis import Hypothesis
from jaxstick.record import Run


@dataclasses.dataclass(frozen=True)
class Constant:
    """An identified parameter in its own unit; `low` and `high` bound it with 95 %, None where nothing."""

    name: str
    value: float
    low: float | None
    high: float | None
    unit: str
    assumed: float | None
    standard_error: float | None
    method: str

    @property
    def identifiable(self) -> bool:
        """Whether the data bound the constant on both sides."""
        return self.low is not None and self.high is not None


@dataclasses.dataclass(frozen=True)
class Trace:
    """One run, measured and fitted: piecewise with a free start for each segment, and in one free run.

    `guide`: where the guide is [m], which the base may carry; `slide_rate`: how fast the mass slides over it
    [m/s].
    """

    run: Run
    guide: np.ndarray
    slide_rate: np.ndarray
    displacement: np.ndarray
    friction: np.ndarray
    free_displacement: np.ndarray
    free_friction: np.ndarray
    segment_starts: np.ndarray
    excluded: np.ndarray


@dataclasses.dataclass(frozen=True)
class Gap:
    """Root mean square of what is left between fit and record in one channel of a run, in its SI unit, beside
    the noise floor."""

    file: str
    channel: str
    rms: float
    nrms_percent: float
    floor: float


@dataclasses.dataclass(frozen=True)
class FreeRun:
    """The displacement error of one simulation from the first sample of a run to the last [m]."""

    file: str
    rms_displacement: float
    nrms_percent: float
    floor: float


@dataclasses.dataclass(frozen=True)
class Fit:
    """The outcome of a fit; `constants` are A, B, C, D, k1 and `others` what else was free.

    `horizon_periods` is the length of the segments of the last stage in natural periods, None for whole runs;
    `runs_disagree` says whether runs surely differ in what they say of the constants.
    """

    outcome: str
    constants: tuple[Constant, ...]
    others: tuple[Constant, ...]
    hypothesis: Hypothesis
    gaps: tuple[Gap, ...]
    free_runs: tuple[FreeRun, ...]
    chi2_per_sample: float
    excluded_segments: int
    segments: int
    horizon_periods: float | None
    traces: tuple[Trace, ...]
    descent: np.ndarray
    finish: tuple[float, ...]
    settings: dict[str, Any]
    sha256: str | None
    notices: tuple[str, ...]
    runs_disagree: bool = False
