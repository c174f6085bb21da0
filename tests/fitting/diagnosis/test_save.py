"""diagnosis.json keeps to the fixed interface."""

from __future__ import annotations

import dataclasses
import json

import pytest

from fitting.diagnosis.findings import Plan, Proposal
from fitting.diagnosis.save import closed_by, diagnosis_content, save_diagnosis
from jaxstick.catalogue import catalogue
from jaxstick.output import OutputFolder, to_json
from jaxstick.record import load_rig
from tests.fitting.diagnosis.fabricated import FAR, RIG, RIVAL, TRUE, TRUTH, nothing_found, silent

FIXED = {
    "schema",
    "verdict",
    "named",
    "probabilities",
    "where",
    "gap",
    "effects",
    "constants",
    "constants_before",
    "next_experiment",
    "data",
    "version",
}


@pytest.fixture(scope="module")
def content(diagnosis, dataset, tmp_path_factory):
    out = tmp_path_factory.mktemp("saved") / "out"
    with OutputFolder(out) as output:
        save_diagnosis(diagnosis, dataset, output)
    return json.loads((out / "diagnosis.json").read_text(encoding="utf-8"), parse_constant=pytest.fail)


def test_the_fixed_keys(content):
    assert set(content) > FIXED
    assert content["schema"] == 1 and content["verdict"] == "effect" and content["named"] == [TRUTH]
    assert set(content["data"]) >= {"sha256"} and len(content["data"]["sha256"]) == 64
    assert set(content["gap"]) >= {
        "before",
        "after",
        "floor",
        "closed",
        "closed_interval",
        "held_out",
        "assumed",
    }
    low, high = content["gap"]["closed_interval"]
    assert low < content["gap"]["closed"] < high
    assert content["gap"]["held_out"] == ["run-03.csv", "run-06.csv"]
    assert content["gap"]["best_wrong"] == [FAR]
    for extra in ("candidates", "likeness", "steps", "notes", "sentence", "seconds"):
        assert extra in content
    friction = content["follows"]["friction"]
    assert friction == {
        "excess": 9.4,
        "significance": 12.1,
        "apart": 1,
        "shares": {"against the motion, by place": 0.71, "speed": 0.02},
        "beat_hz": None,
    }
    yardstick = content["yardstick"]
    (account,) = yardstick.pop("accounts")
    assert account.pop("keys") == [TRUTH] and yardstick.pop("aliases") == {TRUTH: ["force_delay"]}
    assert yardstick.pop("scatters") is False and yardstick.pop("collinear") == {}
    assert yardstick == {"nominal": 46.6, "floor": 1.0, "samples": 14210.0, "inflation": 3.0}
    assert account.pop("of_friction") == account.pop("shapes") == account.pop("changing") == []
    assert account == {"misfit": 1.02, "parameters": 2, "of_one_run": 0.0, "runs": 1, "steadier": 0.5}


def test_probabilities_are_of_the_whole_shelf_and_sum_to_one(content):
    assert set(content["probabilities"]) == {"none", "unlisted", *catalogue()}
    assert sum(content["probabilities"].values()) == pytest.approx(1.0, abs=1e-12)


def test_the_corrected_rig_lies_beside_it(content, diagnosis, dataset, tmp_path):
    del content
    ambiguous = dataclasses.replace(diagnosis, verdict="ambiguous", named=(TRUTH, RIVAL))
    heads = []
    for number, found in enumerate((diagnosis, ambiguous, nothing_found(diagnosis))):
        with OutputFolder(tmp_path / str(number)) as output:
            save_diagnosis(found, dataset, output)
            path = output.folder / "corrected_rig.toml"
            heads.append(path.read_text(encoding="utf-8") if path.exists() else None)
    sheet = load_rig(tmp_path / "0" / "corrected_rig.toml")
    assert sheet.effects == {TRUTH: {"dry": 0.1181, "viscous": 0.09, "steady": 0.1}}
    assert (sheet.rig, sheet.assumed) == (RIG, TRUE)
    assert [run.file for run in sheet.runs] == [run.file for run in dataset.runs]
    first, second, third = heads
    assert "95 %: 0.1162 to 0.1203" in first and "not bounded by the records" in first
    assert "falls from 6.83 to 1.09" in " ".join(first.replace("#", " ").split())
    assert "apart" not in first and f"cannot tell {TRUTH}, {RIVAL} apart" in second
    assert third is None


def test_each_group_of_shares_sums_to_one(content):
    where = content["where"]
    assert set(where["channel"]) == {"displacement", "friction"}
    assert set(where["phase"]) == {"stick", "breakaway", "slip", "arrest"}
    assert set(where["side"]) == {"mechanics", "friction", "measurement"}
    for group in ("channel", "phase", "run", "harmonic", "side", "direction", "time"):
        assert sum(where[group].values()) == pytest.approx(1.0, abs=1e-12), group


def test_effects_and_constants(content, diagnosis):
    effect = content["effects"][TRUTH]
    assert effect["closed"] == content["gap"]["closed"]
    assert effect["parameters"]["dry"] == {"value": 0.1181, "low": 0.1162, "high": 0.1203, "unit": "1"}
    assert effect["parameters"]["viscous"]["low"] is None
    for group in ("constants", "constants_before"):
        assert list(content[group]) == ["A", "B", "C", "D", "k1"]
        for entry in content[group].values():
            assert {"value", "low", "high", "unit", "assumed", "identifiable"} <= set(entry)
            assert entry["identifiable"] is (entry["low"] is not None and entry["high"] is not None)
    assert content["constants_before"]["B"]["value"] != content["constants"]["B"]["value"]


def test_what_was_free_within_its_tolerance(content, dataset):
    for group in ("others", "others_before"):
        mass, damping = (content[group][name] for name in ("rig.mass", "rig.damping"))
        assert mass["assumed"] == dataset.rig.mass and mass["unit"] == "kg"
        assert mass["low"] < mass["value"] < mass["high"] and mass["identifiable"]
        assert damping["low"] is None and not damping["identifiable"]
    assert content["others"]["rig.mass"]["value"] > dataset.rig.mass
    assert content["others_before"]["rig.mass"]["value"] < dataset.rig.mass


def test_what_the_records_could_have_shown(content, diagnosis):
    found = content["detection_limits"]
    assert set(found) == set(catalogue())
    own = {limit.strength: limit for limit in diagnosis.limits if limit.effect == TRUTH}
    assert list(own) == ["dry", "viscous"]
    assert found[TRUTH] == {
        "strengths": {name: {"limit": limit.value, "unit": limit.unit} for name, limit in own.items()},
        "likest": RIVAL,
        "cosine": own["dry"].cosine,
    }
    assert found["force_inertia"]["strengths"]["mass"] == {"limit": None, "unit": "kg"}


def test_what_is_not_recorded_has_no_share(diagnosis, dataset):
    where = diagnosis_content(silent(diagnosis), dataset)["where"]
    assert where["channel"] == {"displacement": 1.0, "friction": 0.0}


def test_numbers_that_are_not_finite_are_null(diagnosis, dataset):
    content = json.loads(to_json(diagnosis_content(nothing_found(diagnosis), dataset)))
    assert content["gap"]["closed"] is None and content["gap"]["closed_interval"] == [None, None]
    assert content["effects"] == {} and content["next_experiment"] is None and content["named"] == []
    assert content["gap"]["assumed"] == 14.2


@pytest.mark.parametrize("by_force", [False, True])
def test_the_run_that_would_tell_two_explanations_apart(diagnosis, dataset, by_force):
    assert diagnosis_content(diagnosis, dataset)["next_run"] is None
    open_one = dataclasses.replace(diagnosis, next_run=Proposal(Plan(1.5, 4e-3, by_force), 2, 3.6, 1.1))
    found = diagnosis_content(open_one, dataset)["next_run"]
    assert found.pop("force_amplitude_n" if by_force else "base_amplitude_m") == 4e-3
    assert found == {
        "frequency_hz": 1.5,
        "times_as_long": 2,
        "separation": 3.6,
        "separation_so_far": 1.1,
        "tells_apart": True,
    }


def test_the_share_that_one_of_several_closes(diagnosis):
    both = dataclasses.replace(diagnosis, effects={**diagnosis.effects, RIVAL: ()})
    assert closed_by(both, TRUTH) is None
    known = dataclasses.replace(both, closed_alone={TRUTH: 0.6, RIVAL: 0.3})
    assert (closed_by(known, TRUTH), closed_by(known, RIVAL)) == (0.6, 0.3)
    assert closed_by(diagnosis, TRUTH) == diagnosis.closure.closed


def test_the_number_of_threads_is_nobodys_business(content):
    assert content["settings"] == {"hold_out": ["run-03.csv", "run-06.csv"], "seed": 0}
