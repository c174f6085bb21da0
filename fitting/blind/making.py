"""Making a set of sealed cases: all cores, resumable, and no case that fails ends the run."""

from __future__ import annotations

import itertools
import multiprocessing
import os
import shutil
import traceback
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fitting.blind.case import Assignment, Settings, assignments, draw_case
from fitting.blind.folder import write_case
from fitting.blind.journal import JOURNAL, Journal
from fitting.blind.kinds import KINDS, SHARES, TIERS
from fitting.blind.rigs import Size
from fitting.blind.seal import MANIFEST, SEALED, checksums, seal
from fitting.blind.seeds import seed_checksum, stream
from fitting.blind.spikes import Source, read_source, spiked_case, spikes_on
from fitting.progress import Progress
from jaxstick.errors import UserError
from jaxstick.version import version

CLEAN = 0.25
"""Share of spiked sets that is left as it was."""


@dataclass(frozen=True)
class Task:
    """One case to be made: from scratch, or as a spike on the data set of that number (None: untouched)."""

    number: int
    assignment: Assignment | None = None
    source: int = 0
    spike: tuple[str, str] | None = None


@dataclass(frozen=True)
class Made:
    """What a run of `make` has done: cases in the set, cases that failed with the reason, cases made anew."""

    cases: int
    failed: Mapping[str, str]
    new: int


def case_name(number: int) -> str:
    """The folder of a case."""
    return f"case-{number:04d}"


def make_cases(
    out: Path,
    count: int,
    settings: Settings,
    key: str,
    progress: Progress,
    *,
    kinds: tuple[str, ...] = KINDS,
    tiers: tuple[str, ...] = TIERS,
    spike_on: Sequence[Path] = (),
    workers: int | None = None,
) -> Made:
    """Makes `count` cases in the folder `out`, and seals their answers.

    Goes on where an earlier run with the same options was stopped. Cases that fail are named in the manifest
    and are missing from the set.

    Raises:
        UserError: where the folder holds a finished set, something else, or one begun with other options or
            another key; and where a data set to be spiked cannot be read.
    """
    sources = tuple(read_source(folder) for folder in spike_on)
    _check_folder(out)
    out.mkdir(parents=True, exist_ok=True)
    plan = {
        "seed": settings.seed,
        "family": settings.family,
        "count": count,
        "runs": settings.size.runs,
        "samples": settings.size.samples,
        "strength": settings.strength,
        "kinds": list(kinds),
        "tiers": list(tiers),
        "spike_on": [source.name for source in sources],
        **({} if settings.spike_times is None else {"spike_times": list(settings.spike_times)}),
    }
    journal = Journal(out, key, plan)
    tasks = _tasks(count, settings, kinds, tiers, sources)
    left = [task for task in tasks if not _done(journal, out, task)]
    progress.stage("cases", len(left))
    failed: dict[str, str] = {}
    for task, entry in _all_made(left, settings, sources, out, workers):
        name = case_name(task.number)
        if "failure" in entry:
            failed[name] = entry["failure"]
        else:
            journal.add(name, entry)
        progress.advance(name)
    names = sorted(journal.entries)
    about = {
        "version": version(),
        "family": settings.family,
        "seed_sha256": seed_checksum(settings.family, settings.seed),
        "failed": sorted(failed),
    }
    seal(
        out,
        key,
        {name: journal.entries[name]["answer"] for name in names},
        {name: journal.entries[name]["files"] for name in names},
        about,
    )
    journal.remove()
    return Made(len(names), failed, len(left) - len(failed))


def _check_folder(out: Path) -> None:
    if not out.exists():
        return
    if not out.is_dir():
        raise UserError(f"{out}: this is a file; cases go to a folder.")
    if (out / MANIFEST).exists() or (out / SEALED).exists():
        raise UserError(f"{out}: the folder holds a sealed set of cases already; name another.")
    if any(out.iterdir()) and not (out / JOURNAL).exists():
        raise UserError(f"{out}: the folder is not empty and holds no cases begun earlier; name another.")


def _tasks(
    count: int,
    settings: Settings,
    kinds: tuple[str, ...],
    tiers: tuple[str, ...],
    sources: tuple[Source, ...],
) -> list[Task]:
    if not sources:
        shares = {kind: SHARES[kind] for kind in kinds}
        return [
            Task(number, assignment)
            for number, assignment in enumerate(assignments(count, settings, shares, tiers), start=1)
        ]
    random = stream(settings.family, settings.seed, "spikes")
    clean = round(CLEAN * count)
    places = [at % len(sources) for at in range(count)]
    faults = [itertools.cycle(spikes_on(source)) for source in sources]
    spikes = [None if at < clean else next(faults[place]) for at, place in enumerate(places)]
    order = random.permutation(count)
    return [Task(number, None, places[at], spikes[at]) for number, at in enumerate(order.tolist(), start=1)]


def _done(journal: Journal, out: Path, task: Task) -> bool:
    name = case_name(task.number)
    return name in journal.entries and (out / name).is_dir()


def _all_made(
    tasks: list[Task], settings: Settings, sources: tuple[Source, ...], out: Path, workers: int | None
) -> Iterator[tuple[Task, dict[str, Any]]]:
    """Each task with the journal's entry or the failure, in the order in which they are finished."""
    workers = min(workers or os.cpu_count() or 1, max(len(tasks), 1))
    if workers == 1:
        for task in tasks:
            yield task, make_one(task, settings, sources, out)
        return
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        running: dict[Future[dict[str, Any]], Task] = {}
        waiting = iter(tasks)
        try:
            for task in waiting:
                running[pool.submit(make_one, task, settings, sources, out)] = task
                if len(running) >= 2 * workers:
                    yield from _finished(running)
            while running:
                yield from _finished(running)
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _finished(running: dict[Future[dict[str, Any]], Task]) -> Iterator[tuple[Task, dict[str, Any]]]:
    for future in wait(running, return_when=FIRST_COMPLETED).done:
        yield running.pop(future), future.result()


def make_one(task: Task, settings: Settings, sources: tuple[Source, ...], out: Path) -> dict[str, Any]:
    """Makes one case: its folder appears when it is whole. Returns answer and checksums, or the failure."""
    folder = out / case_name(task.number)
    part = out / f".{folder.name}.part"
    try:
        for place in (part, folder):
            shutil.rmtree(place, ignore_errors=True)
        if task.assignment is not None:
            recipe, answer = draw_case(settings, task.number, task.assignment)
            write_case(recipe, part)
        else:
            answer = spiked_case(settings, task.number, sources[task.source], task.spike, part)
        part.rename(folder)
        return {"answer": answer, "files": checksums(folder)}
    except Exception as error:
        shutil.rmtree(part, ignore_errors=True)
        last = traceback.extract_tb(error.__traceback__)[-1]
        return {"failure": f"{type(error).__name__}: {error} ({Path(last.filename).name}:{last.lineno})"}


def settings_of(
    family: str,
    seed: int,
    runs: int,
    samples: int,
    strength: str,
    spike_times: tuple[float, float] | None = None,
) -> Settings:
    """The settings of a set from plain words and numbers."""
    return Settings(family, seed, Size(runs, samples), strength, spike_times)
