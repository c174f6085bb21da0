"""How jax compiles for the command: what for, what it keeps between two calls, and options of the whole
process."""

import os
import sys
from pathlib import Path

SWITCH = "JAXSTICK_CACHE"
"""Environment variable: "off" keeps nothing, any other value is the folder to keep it in."""

SMALL_LOOPS = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=100000000"

OPTIONS = {
    "JAX_PLATFORMS": str,
    "JAX_COMPILATION_CACHE_DIR": str,
    "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": float,
}
"""Variables that jax reads once, when it is imported, and what kind of value it takes from them."""

LARGEST = 500_000_000
"""Bytes above which the oldest programs are thrown away."""


def set_up_jax() -> None:
    """Sets up jax, before it computes anything, for one of our processes: where it computes, which programs
    it keeps, and how they are compiled. What the user has set in the environment stands."""
    compute_on_cpu()
    keep_compiled()
    compile_for_few_lanes()
    if jax := sys.modules.get("jax"):
        for name, kind in OPTIONS.items():
            if name in os.environ:
                jax.config.update(name.lower(), kind(os.environ[name]))


def keep_compiled() -> None:
    """Points a jax that is not imported yet to a folder of this user for compiled programs.

    By default $XDG_CACHE_HOME/jaxstick or ~/.cache/jaxstick; a folder that JAX_COMPILATION_CACHE_DIR names
    already stands. Where the folder cannot be made or written, nothing is kept.
    """
    if os.environ.get(SWITCH, "").lower() in ("off", "0", "no") or "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    try:
        folder = _folder()
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK | os.X_OK):
            return
        _throw_away_oldest(folder)
    except (OSError, RuntimeError):
        return
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(folder)
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")


def compute_on_cpu() -> None:
    """Tells a jax that is not imported yet to compute on the CPU where it could use a graphics
    processor, too: a motion is one short step after another, of few lanes, for which the latter takes several
    times as long. What JAX_PLATFORMS says already stands."""
    os.environ.setdefault("JAX_PLATFORMS", "cpu")


def compile_for_few_lanes() -> None:
    """Tells XLA, before jax compiles anything, to take loops over small arrays as code rather than as a chain
    of kernels: fits and diagnoses take half the time, or less. Flags that the user has set stand."""
    flags = os.environ.get("XLA_FLAGS", "")
    if "xla_backend_extra_options" not in flags:
        os.environ["XLA_FLAGS"] = f"{flags} {SMALL_LOOPS}".strip()


def _folder() -> Path:
    named = os.environ.get(SWITCH)
    if named:
        return Path(named).expanduser()
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "jaxstick"


def _throw_away_oldest(folder: Path) -> None:
    files = [(entry.stat(), entry.path) for entry in os.scandir(folder) if entry.name.endswith("-cache")]
    total = sum(status.st_size for status, _ in files)
    for status, path in sorted(files, key=lambda file: file[0].st_mtime):
        if total <= LARGEST:
            break
        os.unlink(path)
        total -= status.st_size
