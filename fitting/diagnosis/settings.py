"""The choices of a diagnosis that are the user's."""

from __future__ import annotations

import dataclasses
import os

from jaxstick.errors import UserError
from jaxstick.record import DataSet


@dataclasses.dataclass(frozen=True)
class DiagnosisSettings:
    """How a diagnosis is done.

    hold_out: files of runs that take no part in choosing and fitting, besides those that rig.toml marks;
    where neither names any, a third of the runs or, with fewer than four runs, every third stretch of
    segments is held out. seed of everything random; workers: threads.
    """

    hold_out: tuple[str, ...] = ()
    seed: int = 0
    workers: int = dataclasses.field(default_factory=lambda: os.cpu_count() or 1)

    def held_out(self, dataset: DataSet) -> tuple[str, ...]:
        """The files that are held out, those of the settings first.

        Raises UserError for one that is no run, and where nothing would be left to fit.
        """
        files = [run.file for run in dataset.runs]
        held = tuple(dict.fromkeys((*self.hold_out, *(run.file for run in dataset.runs if run.hold_out))))
        for file in held:
            if file not in files:
                raise UserError(f"There is no run {file!r} to hold out; there are {', '.join(files)}.")
        if len(held) == len(files):
            raise UserError(f"With {', '.join(held)} held out no run is left to fit.")
        return held
