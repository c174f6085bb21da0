"""The same scheme in C, compiled on the spot: vectors over lanes, blocks of lanes over the cores."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

from jaxstick.compiled import cores
from scripts.benchmark_parts.clock import fastest
from scripts.benchmark_parts.lanes import SAMPLES, Lanes

SOURCE = Path(__file__).parents[1] / "benchmark_lanes.c"
FLAGS = ("-O3", "-march=native", "-ffast-math", "-fno-math-errno", "-fopenmp", "-shared", "-fPIC")
WIDEST = "-mprefer-vector-width=512"
"""Vectors as wide as the CPU has them; a compiler that does not know the flag goes without."""

BLOCKS = (16, 64, 256)
"""Lanes a block, of which the fastest on this machine is taken."""

Simulate = Callable[..., np.ndarray]


def simulator(folder: Path, block: int = 64) -> Simulate | None:
    """`simulate(lanes, steps, workers)` in C, or None where no compiler can build it; compiles into
    `folder`."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return None
    library = folder / f"benchmark_lanes_{block}.so"
    for flags in ((*FLAGS, WIDEST), FLAGS):
        command = [compiler, *flags, f"-DBLOCK={block}", str(SOURCE), "-o", str(library), "-lm"]
        if subprocess.run(command, capture_output=True, check=False).returncode == 0:
            return _bound(ctypes.CDLL(str(library)))
    return None


def fastest_simulator(folder: Path, lanes: Lanes, steps: int) -> Simulate | None:
    """The simulator with the block that suits this machine."""
    built = {str(block): simulator(folder, block) for block in BLOCKS}
    found = {block: build for block, build in built.items() if build is not None}
    if not found:
        return None
    candidates = {
        block: lambda simulate=simulate: simulate(lanes, steps, 1) for block, simulate in found.items()
    }
    times = fastest(candidates, 5)
    return found[min(times, key=lambda block: times[block].processor)]


def _bound(library: ctypes.CDLL) -> Simulate:
    def simulate(lanes: Lanes, steps: int, workers: int | None = None) -> np.ndarray:
        constants = np.ascontiguousarray([*lanes, lanes.interval])
        displacement = np.empty((lanes.size, SAMPLES))
        library.march_lanes(
            ctypes.c_long(lanes.size),
            ctypes.c_long(SAMPLES),
            ctypes.c_long(steps),
            constants.ctypes.data_as(ctypes.c_void_p),
            displacement.ctypes.data_as(ctypes.c_void_p),
            ctypes.c_int(cores() if workers is None else workers),
        )
        return displacement

    return simulate
