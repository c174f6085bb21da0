"""The score of a set of sealed cases."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fitting.blind.menu import FAMILIES
from fitting.blind.seal import open_seal
from fitting.blind_run.chosen import chosen
from fitting.blind_run.results import Results
from fitting.blind_score.baselines import by_bic, by_signature, chance
from fitting.blind_score.by_rig import by_rig
from fitting.blind_score.figures import answers, figures
from fitting.blind_score.intervals import mean, share
from fitting.blind_score.judged import MISSING, PAIR, SINGLE, Judged
from fitting.blind_score.limits import limits
from jaxstick.output import to_json
from jaxstick.version import version

SCHEMA = 1
NOT_RUN = "it was not diagnosed"
LEFT_OUT = (
    "Coverage of the true closure is left out: the simulations that a closure rests on are not kept in "
    "diagnosis.json.",
)


def judged_cases(
    folder: Path, results: Path, key: str, numbers: Sequence[int] | None = None
) -> tuple[list[Judged], dict[str, str], dict[str, Any]]:
    """Opens the seal and puts every case beside its diagnosis; with `numbers` those of them only.

    Returns the cases in the order of their names, why some have no diagnosis, and the manifest.

    Raises:
        UserError: for another key, for a case or the sealed answers that are missing or were changed, for a
            number that is not in the set, and where the results are missing or of another set.
    """
    opened = open_seal(folder, key)
    kept = Results(results)
    kept.check(opened.manifest)
    judged, missing = [], {}
    for case in chosen(folder, opened.manifest, numbers):
        answer = opened.answers[case]
        result = kept.read(case, opened.manifest["cases"][case])
        if result is None:
            missing[case] = kept.failure(case) or NOT_RUN
        judged.append(judge_case(case, answer, result, _samples(folder / case)))
    return judged, missing, dict(opened.manifest)


def judge_case(
    case: str, answer: Mapping[str, Any], result: Mapping[str, Any] | None, samples: int
) -> Judged:
    """One case beside its diagnosis."""
    ratios = [effect.get("limit_ratio") for effect in answer["effects"].values()]
    known = [ratio for ratio in ratios if ratio is not None]
    return Judged(
        case=case,
        kind=answer["kind"],
        tier=answer["tier"],
        truth=tuple(answer["truth"]),
        gap=float(answer["gap_ratio"] or 0.0),
        limit_ratio=max(known) if known else None,
        samples=samples,
        answer=answer,
        result=result,
    )


def score(folder: Path, results: Path, key: str, numbers: Sequence[int] | None = None) -> dict[str, Any]:
    """The whole score as plain data; takes and raises what `judged_cases` does."""
    cases, missing, manifest = judged_cases(folder, results, key, numbers)
    return scored(cases, missing, manifest)


def scored(
    cases: Sequence[Judged], missing: Mapping[str, str], manifest: Mapping[str, Any]
) -> dict[str, Any]:
    """The score of judged cases: figures over all and by tier, baselines, confusion, effects, rigs,
    mistakes."""
    tiers = sorted({case.tier for case in cases})
    possible = max((len(case.probabilities) for case in cases), default=0) or len(FAMILIES) + 2
    bic, signature = [by_bic(case) for case in cases], [by_signature(case) for case in cases]
    return {
        "schema": SCHEMA,
        "cases": len(cases),
        "set": {
            "cases": len(manifest["cases"]),
            "family": manifest.get("family"),
            "strengths": sorted({str(case.answer["strength"]) for case in cases}),
            "seed_sha256": manifest.get("seed_sha256"),
            "cases_sha256": hashlib.sha256(to_json(manifest["cases"]).encode()).hexdigest(),
            "seal_sha256": manifest["seal"]["sha256"],
            "kinds": _counted(case.kind for case in cases),
        },
        "missing": dict(missing),
        "tiers": {
            "all": figures(cases),
            **{tier: figures([case for case in cases if case.tier == tier]) for tier in tiers},
        },
        "baselines": {
            "chance": {"answers": possible, **chance(possible)},
            "bic": _beside(bic),
            "signature": _beside(signature),
        },
        "confusion": confusion(cases),
        "effects": by_effect(cases),
        "rigs": by_rig(cases),
        "mistakes": [_mistake(case, missing) for case in cases if not case.right()],
        "seconds": mean(
            [case.result["seconds"] for case in cases if case.result and "seconds" in case.result]
        ),
        "notes": list(LEFT_OUT),
        "version": version(),
    }


def confusion(cases: Sequence[Judged]) -> dict[str, dict[str, int]]:
    """How often each truth got each answer, pairs left out; an answer that is right counts as the truth."""
    table: dict[str, dict[str, int]] = {}
    for case in cases:
        if case.kind != PAIR:
            row = table.setdefault(case.truth[0], {})
            row[case.label()] = row.get(case.label(), 0) + 1
    order = {key: number for number, key in enumerate(("none", *FAMILIES, "unlisted"))}
    return {
        truth: dict(sorted(table[truth].items(), key=lambda item: -item[1]))
        for truth in sorted(table, key=lambda key: order.get(key, len(order)))
    }


def by_effect(cases: Sequence[Judged]) -> dict[str, dict[str, Any]]:
    """For every effect of the set that acted alone: how often it was named, its mean probability, and the
    ratios to the detection limits, predicted and of an ideal observer, at which nine of ten are named."""
    found = {}
    for key in (key for key in FAMILIES if any(case.truth == (key,) for case in cases)):
        own = [case for case in cases if case.kind == SINGLE and case.truth == (key,)]
        seen = limits(own)
        found[key] = {
            "family": FAMILIES[key],
            "top1": share(case.right() for case in own),
            "probability": mean([case.probability() for case in own]),
            "named_beyond_predicted": seen["named_beyond_predicted"],
            "a90_predicted": (seen["predicted_ratio"] or {}).get("a90"),
            "named_beyond": seen["named_beyond"],
            "a90": (seen["limit_ratio"] or {}).get("a90"),
        }
    return found


def _beside(cases: Sequence[Judged]) -> dict[str, Any]:
    tiers = sorted({case.tier for case in cases})
    of_tiers = {tier: answers([case for case in cases if case.tier == tier]) for tier in tiers}
    return {"all": answers(cases), **of_tiers}


def _mistake(case: Judged, missing: Mapping[str, str]) -> dict[str, Any]:
    return {
        "case": case.case,
        "tier": case.tier,
        "kind": case.kind,
        "truth": list(case.answer["unlisted"] or case.truth),
        "gap": case.gap,
        "verdict": case.verdict,
        "named": list(case.named),
        "probability": case.probability(),
        **({"error": missing[case.case]} if case.verdict == MISSING and case.case in missing else {}),
    }


def _samples(folder: Path) -> int:
    """How many values of displacement and friction the records of a case hold."""
    count = 0
    for path in sorted(folder.glob("*.csv")):
        with path.open("rb") as stream:
            rows = [line for line in stream if line.strip() and not line.startswith(b"#")]
        count += (len(rows) - 1) * (2 if b"friction" in rows[0] else 1) if rows else 0
    return count


def _counted(words: Any) -> dict[str, int]:
    counts: dict[str, int] = {}
    for word in words:
        counts[word] = counts.get(word, 0) + 1
    return dict(sorted(counts.items()))
