"""What our own program costs: a Jacobian in simulations, time over lanes, cores, memory, an accelerator."""

from __future__ import annotations

import multiprocessing
import resource
from collections.abc import Sequence
from typing import NamedTuple

import jax

from jaxstick.compiled import cores
from jaxstick.precision import float64
from scripts.benchmark_parts import ours
from scripts.benchmark_parts.clock import fastest
from scripts.benchmark_parts.lanes import lanes

MANY = 1_000_000
"""Lanes of the run that measures memory."""


class Growth(NamedTuple):
    """A number of lanes; a lane's time of the processor on one core, of the wall's clock on all cores [s];
    how many times faster all cores are by that clock; the processor's time for a Jacobian over five constants
    [s]."""

    lanes: int
    one_core: float
    all_cores: float
    gain_of_all_cores: float
    jacobian: float | None


def growth(counts: Sequence[int], steps: int, repeats: int, most_for_jacobian: int) -> list[Growth]:
    """Times over the number of lanes; Jacobians up to so many lanes."""
    found = []
    for count in counts:
        many = lanes(count)
        candidates = {
            "one": lambda many=many: ours.simulate(many, steps, 1),
            "all": lambda many=many: ours.simulate(many, steps, cores()),
        }
        if count <= most_for_jacobian:
            candidates["jacobian"] = lambda many=many: ours.jacobian(many, steps, 1)
        times = fastest(candidates, repeats)
        found.append(
            Growth(
                count,
                times["one"].processor / count,
                times["all"].wall / count,
                times["one"].wall / times["all"].wall,
                times["jacobian"].processor / count if "jacobian" in times else None,
            )
        )
    return found


def memory(steps: int) -> float:
    """The most memory [GB] that a process takes which finds the amplitudes of a million lanes."""
    context = multiprocessing.get_context("spawn")
    with context.Pool(1) as pool:
        return pool.apply(_peak, (steps,))


def accelerator(count: int, steps: int, repeats: int) -> tuple[str, float] | None:
    """Name of the accelerator that jax sees and its time a lane [s]; None where it sees none."""
    others = [device for device in jax.devices() if device.platform != "cpu"]
    if not others:
        return None
    many = lanes(count)
    with jax.default_device(others[0]):
        run = {"accelerator": lambda: ours.amplitude(many, steps, 1, pack=count)}
        return others[0].device_kind, fastest(run, repeats)["accelerator"].wall / count


def _peak(steps: int) -> float:
    with float64():
        ours.amplitude(lanes(MANY), steps)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
