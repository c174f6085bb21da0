"""What the process does with memory that it has freed."""

from __future__ import annotations

import ctypes
import os
import sys

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
"""The parameters of glibc's `mallopt` (malloc.h)."""
AT_THE_END = 1 << 30
"""Bytes that are free at the end of the heap before any go back to the system,"""
BY_ITSELF = 32 << 20
"""and those of an array that gets memory of its own, which does so at once (the most that glibc takes)."""
SAID = ("glibc.malloc", "MALLOC_")
"""By what is known in the environment that somebody has set this already."""


def keep_freed_memory() -> None:
    """Lets what is freed stay with the process, up to `AT_THE_END`. For a process that does one thing: one
    that goes on to compile ever other programs grows by what they leave.

    What a compiled program computes with is freed at its end, and the next one begins by having the system
    set up every page anew: a twentieth of the time of a diagnosis. What the environment says of malloc
    stands. Only glibc is told; elsewhere nothing happens.
    """
    said = (f"{name}={value}" for name, value in os.environ.items())
    if sys.platform != "linux" or any(word in each for each in said for word in SAID):
        return
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(TRIM_THRESHOLD, AT_THE_END)
        mallopt(MMAP_THRESHOLD, BY_ITSELF)
