"""Every solver at the setting that gives the same error, and the times of all of them taken in turns."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from jaxstick.compiled import cores
from scripts.benchmark_parts import c_lanes, numba_lanes, ours, scipy_events, tsit5
from scripts.benchmark_parts.clock import fastest
from scripts.benchmark_parts.lanes import ERROR, Checked, checked, lanes

STEPS = (8, 10, 12, 14, 16, 18, 20, 22, 24, 28, 32, 40, 48)
TOLERANCES = (1e-3, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 1e-7)
TIGHT = 1e-9
"""Tolerance at which the smooth contact's own solution is taken for exact."""


class Size(NamedTuple):
    """How much to do: lanes of the vectorised solvers, of Tsit5, lanes checked against the reference, lanes
    given to scipy, rounds of the clock."""

    lanes: int
    tsit5_lanes: int
    checked: int
    scipy_lanes: int
    repeats: int


class Entry(NamedTuple):
    """A solver in the contest: the setting chosen, its error in strokes; a lane's time of the processor where
    it has one core, and of the wall's clock where it has all of them (None where it uses only one) [s]."""

    solver: str
    setting: str
    error: float
    one_core: float
    all_cores: float | None


def loosest(
    settings: Iterable[Any], simulate: Callable[[Any], np.ndarray], against: Checked
) -> tuple[Any, float]:
    """The first of the settings, loosest first, that meets the error, with that error; the last where none
    does."""
    found: tuple[Any, float] = (None, float("inf"))
    for setting in settings:
        found = setting, against.error(simulate(setting))
        if found[1] <= ERROR:
            break
    return found


def contest(size: Size, folder: Path) -> tuple[list[Entry], int]:
    """The entries, ours first, and our steps a sample; C is compiled into `folder` and left out where there
    is no compiler."""
    few = checked(size.checked)
    steps, error = loosest(STEPS, lambda n: ours.simulate(few.lanes, n, 1), few)
    setting = f"{steps} steps a sample"
    many = lanes(size.lanes)
    candidates: dict[str, Callable[[], object]] = {}
    entries: list[tuple[str, str, float, int, bool]] = []

    def enter(
        name: str, setting: str, error: float, count: int, run: Callable[[int | None], object], parallel: bool
    ) -> None:
        candidates[f"{name}, one core"] = lambda: run(1)
        if parallel and cores() > 1:
            candidates[f"{name}, all cores"] = lambda: run(None)
        entries.append((name, setting, error, count, parallel))

    def same_scheme(name: str, simulate: Callable[..., np.ndarray]) -> None:
        found = few.error(simulate(few.lanes, steps, None))
        enter(name, setting, found, size.lanes, lambda workers: simulate(many, steps, workers), True)

    enter("jaxstick", setting, error, size.lanes, lambda workers: ours.simulate(many, steps, workers), True)
    in_c = c_lanes.fastest_simulator(folder, many, steps)
    if in_c is not None:
        same_scheme("C, vectorised", in_c)
    same_scheme("numba loop", numba_lanes.simulate)

    some = lanes(size.tsit5_lanes)
    own = Checked(few.lanes, tsit5.simulate(few.lanes, TIGHT))
    tolerance, error = loosest(TOLERANCES, lambda rtol: tsit5.simulate(few.lanes, rtol), own)
    enter(
        "diffrax Tsit5, vmap",
        f"rtol {tolerance:.0e}",
        error,
        size.tsit5_lanes,
        lambda _, rtol=tolerance: tsit5.simulate(some, rtol),
        False,
    )

    slow = lanes(size.scipy_lanes)
    for method in ("LSODA", "RK45"):
        simulate = functools.partial(scipy_events.simulate, method=method)
        tolerance, error = loosest(
            TOLERANCES, lambda rtol, simulate=simulate: simulate(few.lanes, tolerance=rtol), few
        )
        enter(
            f"scipy {method}, events",
            f"rtol {tolerance:.0e}",
            error,
            size.scipy_lanes,
            lambda _, simulate=simulate, rtol=tolerance: simulate(slow, tolerance=rtol),
            False,
        )

    times = fastest(candidates, size.repeats)
    return [
        Entry(
            name,
            setting,
            error,
            times[f"{name}, one core"].processor / count,
            times[f"{name}, all cores"].wall / count if f"{name}, all cores" in times else None,
        )
        for name, setting, error, count, _ in entries
    ], steps
