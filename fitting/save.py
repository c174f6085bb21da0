"""A fit as files: fit.json and one table of traces for each run."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from fitting.against import against
from fitting.corrected_rig import entries, save_corrected
from fitting.correction import correction_of
from fitting.result import Constant, Fit, Gap, Trace
from fitting.saved import FIT_FILE, SCHEMA, SavedRun, rig_entry, run_entry
from jaxstick.cycle import cycle_of, outcome_of
from jaxstick.output import OutputFolder
from jaxstick.record import DataSet
from jaxstick.version import version

UNITS = {"displacement": "m", "friction": "N"}


def save_fit(fit: Fit, dataset: DataSet, output: OutputFolder) -> dict[str, Any]:
    """Writes fit.json, corrected_rig.toml and traces/*.csv into the folder; returns what fit.json holds."""
    content = fit_content(fit, dataset)
    output.write_json(FIT_FILE, content)
    save_corrected(
        correction_of(fit.hypothesis, dataset.rig),
        dataset,
        output,
        [f"It is the fit in {FIT_FILE} ({fit.outcome}) to the data set {dataset.name!r}."],
        entries((*fit.constants, *fit.others)),
    )
    for trace in fit.traces:
        name = PurePosixPath("traces", trace.run.file).with_suffix(".csv")
        output.write_text(str(name), _table(trace))
    return content


def fit_content(fit: Fit, dataset: DataSet) -> dict[str, Any]:
    """What fit.json holds: the fixed keys, and under keys of its own what a reader may want to know."""
    return {
        "schema": SCHEMA,
        "outcome": fit.outcome,
        "constants": constant_entries(fit.constants),
        "others": constant_entries(fit.others),
        "gap": {"runs": [_gap(gap) for gap in fit.gaps], "chi2_per_sample": fit.chi2_per_sample},
        "free_run": [
            {
                "file": run.file,
                "rms_displacement_m": run.rms_displacement,
                "nrms_percent": run.nrms_percent,
                "floor_m": run.floor,
            }
            for run in fit.free_runs
        ],
        "hypothesis": {"words": _words(fit), "effects": list(fit.hypothesis.order)},
        "segments": {"number": fit.segments, "excluded": fit.excluded_segments},
        "search": {
            "starts": int(fit.descent.shape[1]),
            "descent_iterations": int(fit.descent.shape[0]),
            "loss_at_start": fit.descent[0],
            "loss_at_end": np.nanmin(fit.descent, axis=0),
            "least_squares_steps": len(fit.finish) - 1,
        },
        "settings": {name: value for name, value in fit.settings.items() if name != "workers"},
        "rig": rig_entry(dataset.rig),
        **({"effects": dataset.effects} if dataset.effects else {}),
        "runs": [
            {
                **run_entry(SavedRun(run.file, cycle_of(run), run.rig, run.assumed, outcome_of(run))),
                "hold_out": run.hold_out,
            }
            for run in dataset.runs
        ],
        "notices": list(fit.notices),
        "runs_disagree": fit.runs_disagree,
        "data": {"sha256": fit.sha256, "name": dataset.name},
        "version": version(),
    }


def constant_entries(constants: Iterable[Constant]) -> dict[str, dict[str, Any]]:
    """Constants as they stand in fit.json and diagnosis.json, by name."""
    return {constant.name: constant_entry(constant) for constant in constants}


def constant_entry(constant: Constant) -> dict[str, Any]:
    """A constant as it stands in fit.json and diagnosis.json."""
    entry = {
        "value": constant.value,
        "low": constant.low,
        "high": constant.high,
        "unit": constant.unit,
        "identifiable": constant.identifiable,
        "standard_error": constant.standard_error,
        "method": constant.method,
    }
    return against(entry, constant.assumed)


def _gap(gap: Gap) -> dict[str, Any]:
    return {
        "file": gap.file,
        "channel": gap.channel,
        "unit": UNITS[gap.channel],
        "rms": gap.rms,
        "nrms_percent": gap.nrms_percent,
        "floor": gap.floor,
    }


def _words(fit: Fit) -> str:
    words = (
        "friction F = -sign(v) [A exp(-B |v|) + C + D |v|] in slip, a spring k1 in stick, force continuous "
        "between them"
    )
    effects = [fit.hypothesis.effects[key] for key in fit.hypothesis.order]
    titles = [effect.card.title.lower() for effect in effects]
    return words + (f"; with {', '.join(titles)}" if titles else "")


def _table(trace: Trace) -> str:
    """Measured and fitted samples as CSV. `segment` counts the pieces with a start of their own; `excluded`
    is 1 in those that fit far worse than the rest."""
    run = trace.run
    segment = np.searchsorted(trace.segment_starts, np.arange(len(run.time)), side="right") - 1
    columns: dict[str, np.ndarray | None] = {
        "displacement_m": run.displacement,
        "fitted_displacement_m": trace.displacement,
        "free_run_displacement_m": trace.free_displacement,
        "friction_n": run.friction,
        "fitted_friction_n": trace.friction,
        "free_run_friction_n": trace.free_friction,
    }
    given = {name: np.asarray(values) for name, values in columns.items() if values is not None}
    excluded = np.asarray(trace.excluded)[segment].astype(int)
    lines = [",".join(["time_s", *given, "segment", "excluded"])]
    for row in zip(
        *(column.tolist() for column in (run.time, *given.values(), segment, excluded)), strict=True
    ):
        time, *values, piece, out = row
        lines.append(f"{time!r},{','.join(f'{value:.9g}' for value in values)},{piece},{out}")
    return "\n".join(lines) + "\n"
