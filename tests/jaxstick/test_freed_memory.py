"""Memory that is freed stays with the process, unless somebody has said otherwise."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

FAULTS = """
import resource
from jaxstick.freed_memory import keep_freed_memory
keep_freed_memory()
def computed():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    arrays = [b"1" * (20 << 20) for _ in range(8)]
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
computed()
print(computed())
"""
PAGES = 8 * (20 << 20) // os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 0


def page_faults(**said: str) -> int:
    """How many there are in a process that computes what it has computed before."""
    bare = {k: v for k, v in os.environ.items() if k != "GLIBC_TUNABLES" and not k.startswith("MALLOC_")}
    done = subprocess.run(
        [sys.executable, "-c", FAULTS], env=bare | said, capture_output=True, text=True, check=True
    )
    return int(done.stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="malloc is not glibc's")
def test_what_was_freed_is_used_again():
    assert page_faults() < 0.1 * PAGES


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="malloc is not glibc's")
def test_what_the_user_says_of_malloc_stands():
    assert page_faults(MALLOC_TRIM_THRESHOLD_="100000") > 0.5 * PAGES
