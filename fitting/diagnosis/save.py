"""A diagnosis as diagnosis.json."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from typing import Any

from fitting.corrected_rig import Entry, entries, save_corrected
from fitting.diagnosis.findings import (
    Candidate,
    Diagnosis,
    Likeness,
    Limit,
    Parameter,
    Patterns,
    Proposal,
    Shares,
    Where,
)
from fitting.save import constant_entries
from jaxstick.output import OutputFolder
from jaxstick.record import DataSet
from jaxstick.version import version

DIAGNOSIS_FILE = "diagnosis.json"
SCHEMA = 1

CHANNELS = ("displacement", "friction")
PHASES = ("stick", "breakaway", "slip", "arrest")
SIDES = ("mechanics", "friction", "measurement")


def save_diagnosis(diagnosis: Diagnosis, dataset: DataSet, output: OutputFolder) -> dict[str, Any]:
    """Writes diagnosis.json and, where something is named, corrected_rig.toml into the folder; returns what
    diagnosis.json holds."""
    content = diagnosis_content(diagnosis, dataset)
    output.write_json(DIAGNOSIS_FILE, content)
    if diagnosis.correction is not None:
        save_corrected(
            diagnosis.correction, dataset, output, list(_origin(diagnosis, dataset)), _fitted(diagnosis)
        )
    return content


def _origin(diagnosis: Diagnosis, dataset: DataSet) -> Iterator[str]:
    """Where a corrected rig comes from and what it does not hold."""
    closure = diagnosis.closure
    yield f"It is the verdict in {DIAGNOSIS_FILE} on the data set {dataset.name!r}: {diagnosis.sentence}"
    if diagnosis.verdict == "ambiguous":
        taken = ", ".join(diagnosis.effects)
        yield (
            f"These records cannot tell {', '.join(diagnosis.named)} apart; the likeliest, {taken}, is taken."
        )
    elif len(diagnosis.named) > len(diagnosis.effects):
        yield f"It holds {' and '.join(diagnosis.effects)}, the likeliest two of what the verdict names."
    yield (
        f"The gap on what took no part falls from {closure.before:.3g} to {closure.after:.3g} standard "
        "deviations of the noise with it."
    )
    yield (
        "Properties of the rig are those found within their tolerance. The level of friction, which may "
        "differ a little from run to run, is that of the typical run."
    )


def _fitted(diagnosis: Diagnosis) -> dict[str, Entry]:
    """What was fitted, under the names of the unknowns."""
    own = {
        f"{key}.{parameter.name}": (parameter.value, parameter.low, parameter.high)
        for key, parameters in diagnosis.effects.items()
        for parameter in parameters
    }
    return {**entries((*diagnosis.constants, *diagnosis.others)), **own}


def diagnosis_content(diagnosis: Diagnosis, dataset: DataSet) -> dict[str, Any]:
    """What diagnosis.json holds: the fixed keys, and under keys of its own what a reader may want to know."""
    closure = diagnosis.closure
    return {
        "schema": SCHEMA,
        "verdict": diagnosis.verdict,
        "named": list(diagnosis.named),
        "sentence": diagnosis.sentence,
        "probabilities": dict(diagnosis.probabilities),
        "where": _where(diagnosis.where),
        "gap": {
            "before": closure.before,
            "after": closure.after,
            "floor": closure.floor,
            "assumed": closure.assumed,
            "closed": closure.closed,
            "closed_interval": list(closure.interval),
            "placebo_closed": closure.placebo,
            "best_wrong_closed": closure.wrong,
            "best_wrong": list(closure.wrong_keys),
            "held_out": list(closure.held_out),
            "by_segments": closure.by_segments,
        },
        "effects": {
            key: {"parameters": _parameters(parameters), "closed": closed_by(diagnosis, key)}
            for key, parameters in diagnosis.effects.items()
        },
        "constants": constant_entries(diagnosis.constants),
        "constants_before": constant_entries(diagnosis.constants_before),
        "others": constant_entries(diagnosis.others),
        "others_before": constant_entries(diagnosis.others_before),
        "next_experiment": diagnosis.next_experiment,
        "next_run": _proposal(diagnosis.next_run),
        "candidates": [_candidate(candidate) for candidate in diagnosis.candidates],
        "yardstick": dataclasses.asdict(diagnosis.yardstick),
        "likeness": [_likeness(pair) for pair in diagnosis.likeness],
        "detection_limits": _limits(diagnosis.limits),
        "residual_force": {"sketch_n": dict(diagnosis.residual_force.sketch)},
        "follows": {side: _patterns(found) for side, found in diagnosis.follows.items()},
        "notes": list(diagnosis.notes),
        "steps": list(diagnosis.steps),
        "settings": {name: value for name, value in diagnosis.settings.items() if name != "workers"},
        "seconds": diagnosis.seconds,
        "data": {"sha256": diagnosis.sha256, "name": dataset.name},
        "version": version(),
    }


def _patterns(found: Patterns) -> dict[str, Any]:
    return {
        "excess": found.excess,
        "significance": found.significance,
        "apart": found.apart,
        "shares": dict(found.shares),
        "beat_hz": found.beat,
    }


def closed_by(diagnosis: Diagnosis, key: str) -> float | None:
    """The share of the reducible gap that one effect in the model closes where nothing was fitted; the whole
    where it is the only one, None where nobody worked it out."""
    if key in diagnosis.closed_alone:
        return diagnosis.closed_alone[key]
    return diagnosis.closure.closed if tuple(diagnosis.effects) == (key,) else None


def _where(where: Where) -> dict[str, Any]:
    return {
        "channel": _shares(where.channel, CHANNELS),
        "phase": _shares(where.phase, PHASES),
        "direction": dict(where.direction),
        "run": dict(where.run),
        "harmonic": dict(where.harmonic),
        "time": dict(where.time),
        "side": _shares(where.side, SIDES),
        "excess": where.excess,
        "significance": where.significance,
    }


def _shares(shares: Shares, names: Iterable[str]) -> dict[str, float]:
    """The shares by name, 0 where a name has none."""
    return {**dict.fromkeys(names, 0.0), **shares}


def _parameters(parameters: Iterable[Parameter]) -> dict[str, dict[str, Any]]:
    return {
        parameter.name: {
            "value": parameter.value,
            "low": parameter.low,
            "high": parameter.high,
            "unit": parameter.unit,
        }
        for parameter in parameters
    }


def _candidate(candidate: Candidate) -> dict[str, Any]:
    return {
        "effects": list(candidate.keys),
        "probability": candidate.probability,
        "score": candidate.score,
        "chi2_per_sample": candidate.misfit,
        "closed_where_fitted": candidate.closed,
        "parameters": _parameters(candidate.parameters),
        "detection_limit": candidate.detection_limit,
    }


def _limits(limits: Iterable[Limit]) -> dict[str, dict[str, Any]]:
    """The limits by effect; null for a strength that these records do not show at any size it can have."""
    found: dict[str, dict[str, Any]] = {}
    for limit in limits:
        alike = {"likest": limit.likest, "cosine": limit.cosine}
        effect = found.setdefault(limit.effect, {"strengths": {}, **alike})
        effect["strengths"][limit.strength] = {"limit": limit.value, "unit": limit.unit}
    return found


def _proposal(proposal: Proposal | None) -> dict[str, Any] | None:
    if proposal is None:
        return None
    plan = proposal.plan
    size = {"force_amplitude_n": plan.amplitude} if plan.by_force else {"base_amplitude_m": plan.amplitude}
    return {
        "frequency_hz": plan.frequency,
        **size,
        "times_as_long": proposal.times,
        "separation": proposal.separation,
        "separation_so_far": proposal.so_far,
        "tells_apart": proposal.tells,
    }


def _likeness(pair: Likeness) -> dict[str, Any]:
    return {"effects": [pair.one, pair.other], "cosine": pair.cosine, "separation": pair.separation}
