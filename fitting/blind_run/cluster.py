"""Cases on the workers of a Dask cluster that is there already."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from distributed import Future, KilledWorker

from fitting.blind_run.case_work import Outcome, diagnose_sent
from jaxstick.sweeps.workers import client_of, finished, result_of
from jaxstick.version import version


def on_cluster(folders: Mapping[str, Path], seed: int, address: str) -> Iterator[tuple[str, Outcome]]:
    """The outcome of every case by its name, in the order in which the workers finish them.

    The files travel with the case, so the workers need not share our disk. A case whose workers die one after
    the other is a failure of that case.

    Raises:
        UserError: where no scheduler answers within 15 s, it has no workers, or one of them lacks jaxstick or
            runs another version.
        ClusterLostError: where the scheduler goes away meanwhile, or has no worker for two minutes.
    """
    with client_of(address) as client:

        def submit(name: str) -> Future:
            folder = folders[name]
            files = {
                path.relative_to(folder).as_posix(): path.read_bytes()
                for path in sorted(folder.rglob("*"))
                if path.is_file()
            }
            return client.submit(diagnose_sent, name, files, seed, version(), pure=False)

        yield from finished(client, folders, submit, _outcome)


def _outcome(future: Future) -> Outcome:
    try:
        return Outcome(*result_of(future))
    except KilledWorker:
        return Outcome(None, "The case has killed one worker of the cluster after the other.")
