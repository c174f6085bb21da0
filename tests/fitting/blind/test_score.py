"""Scores of made-up diagnoses against sealed answers, checked by hand."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from fitting.blind.seal import SEALED, new_key, read_manifest
from fitting.blind.statement import with_statement
from fitting.blind_run.results import Results, default_results
from fitting.blind_score.baselines import by_bic, by_signature
from fitting.blind_score.by_rig import TRAITS, by_rig
from fitting.blind_score.calibration import calibration
from fitting.blind_score.coverage import coverage, holds
from fitting.blind_score.figures import answers, closure
from fitting.blind_score.intervals import area, mean, quantile, share
from fitting.blind_score.judged import Judged
from fitting.blind_score.limits import curve, limits, predicted_ratio
from fitting.blind_score.page import score_page
from fitting.blind_score.pictures import pictures
from fitting.blind_score.rows import (
    EFFECT_COLUMNS,
    answer_rows,
    effect_rows,
    figure,
    further_rows,
    percent,
    rig_rows,
    sentence,
)
from fitting.blind_score.score import scored
from fitting.cli import jaxstick as command
from tests.fitting.blind import stub
from tests.fitting.blind.small import tiny_rig
from tests.fitting.diagnosis.markup import Page

SPRING, PUSH, LAG = "cubic_stiffness", "constant_force", "frictional_memory"
GAIN, OTHER_GAIN, WRONG_RIG = "force_gain", "displacement_gain", "stiffness_error"


def single(key: str, verdict: str | None, *named: str, **options) -> Judged:
    """One effect, and what was answered; None: nothing."""
    known = ("p", "effects", "candidates", "detection_limits")
    made_up = {name: options.pop(name) for name in known if name in options}
    result = None if verdict is None else stub.content(verdict, *named, **made_up)
    return stub.judged(stub.answer("single", key, **options), result)


@pytest.mark.parametrize(
    ("key", "verdict", "named", "right"),
    [
        (SPRING, "effect", (SPRING,), True),
        (SPRING, "effect", (PUSH,), False),
        (SPRING, "ambiguous", (PUSH, SPRING), True),
        (SPRING, "ambiguous", (PUSH, SPRING, LAG), False),
        (SPRING, "ambiguous", (PUSH, LAG), False),
        (SPRING, "several", (SPRING, PUSH), False),
        (SPRING, "none", (), False),
        (SPRING, "unlisted", (), False),
        (SPRING, None, (), False),
        (GAIN, "ambiguous", (GAIN, OTHER_GAIN, WRONG_RIG), True),
        (GAIN, "ambiguous", (OTHER_GAIN, GAIN, WRONG_RIG, PUSH), True),
        (GAIN, "ambiguous", (GAIN, WRONG_RIG, PUSH, LAG), False),
        (GAIN, "effect", (OTHER_GAIN,), False),
        (GAIN, "effect", (GAIN,), True),
    ],
)
def test_one_effect_is_right_by_the_rule(key, verdict, named, right):
    assert single(key, verdict, *named).right() is right


@pytest.mark.parametrize(
    ("verdict", "named", "both", "third", "one"),
    [
        ("several", (SPRING, PUSH), True, False, True),
        ("several", (SPRING, PUSH, LAG), True, True, True),
        ("ambiguous", (SPRING, PUSH), False, False, True),
        ("effect", (PUSH,), False, False, True),
        ("effect", (LAG,), False, True, False),
        ("none", (), False, False, False),
    ],
)
def test_two_effects(verdict, named, both, third, one):
    case = stub.judged(stub.answer("pair", SPRING, PUSH), stub.content(verdict, *named))
    assert (case.both(), case.third(), case.one()) == (both, third, one)
    assert case.right() is (both and not third)


@pytest.mark.parametrize(
    ("verdict", "named", "right"),
    [
        ("effect", (WRONG_RIG,), True),
        ("ambiguous", ("base_gain", WRONG_RIG), True),
        ("ambiguous", (WRONG_RIG, LAG), False),
        ("several", (GAIN, "base_gain", WRONG_RIG), True),
        ("effect", ("base_gain",), False),
        ("effect", (OTHER_GAIN,), False),
    ],
)
def test_one_effect_that_has_the_traces_of_two_stands_for_both(verdict, named, right):
    case = stub.judged(stub.answer("pair", GAIN, "base_gain"), stub.content(verdict, *named))
    assert case.right() is right


def test_the_second_answer_and_exact_aliases():
    assert single(SPRING, "effect", PUSH, p={PUSH: 0.6, SPRING: 0.3}).second()
    assert not single(SPRING, "effect", PUSH, p={PUSH: 0.5, LAG: 0.3, SPRING: 0.1}).second()
    assert not single(SPRING, None).second()
    shared = {GAIN: 0.3, OTHER_GAIN: 0.31, WRONG_RIG: 0.32}
    case = single(GAIN, "ambiguous", WRONG_RIG, OTHER_GAIN, GAIN, p=shared)
    assert case.probability() == pytest.approx(0.93)
    assert case.probability_exact() == pytest.approx(0.3)
    assert case.likeliest_is_right() and case.as_class() and not case.alone() and case.family_right()
    named_alone = single(GAIN, "effect", GAIN)
    assert named_alone.alone() and not named_alone.as_class()


def test_shares_have_exact_binomial_intervals():
    for hits, n in ((0, 10), (3, 10), (9, 300), (270, 300), (10, 10)):
        found = share([True] * hits + [False] * (n - hits))
        assert found["value"] == hits / n and found["n"] == n
        low = 0.0 if hits == 0 else binom.sf(hits - 1, n, found["low"])
        high = 0.0 if hits == n else binom.cdf(hits, n, found["high"])
        assert low == pytest.approx(0.025 if hits else 0.0, abs=1e-9)
        assert high == pytest.approx(0.025 if hits < n else 0.0, abs=1e-9)
    assert share([True] * 270 + [False] * 30)["low"] == pytest.approx(0.8604, abs=1e-3)
    assert share([])["value"] is None


def test_other_intervals():
    whole = quantile(list(range(101)), 0.5)
    assert whole["value"] == 50 and 38 <= whole["low"] <= 41 and 59 <= whole["high"] <= 62
    random = np.random.default_rng(1)
    drawn = [quantile(random.standard_normal(25).tolist(), 0.5) for _ in range(400)]
    assert 0.93 < np.mean([one["low"] < 0 < one["high"] for one in drawn]) <= 1.0
    assert quantile([1.0, 2.0], 0.1)["low"] is None
    assert mean([0.2, 0.4])["value"] == pytest.approx(0.3)
    assert area([3.0, 2.0], [1.0, 2.0])["value"] == pytest.approx((2 + 1 + 0.5) / 4)


def tiny_set() -> list[Judged]:
    """Ten cases whose figures are counted on fingers."""
    none, strange = stub.answer("none", tier="B"), stub.answer("unlisted", "magnet")
    return [
        single(SPRING, "effect", SPRING),
        single(SPRING, "effect", PUSH, gap=2.0),
        single(GAIN, "ambiguous", GAIN, OTHER_GAIN, WRONG_RIG),
        single(LAG, None),
        stub.judged(none, stub.content("none")),
        stub.judged(none, stub.content("unlisted")),
        stub.judged(none, stub.content("effect", PUSH)),
        stub.judged(strange, stub.content("unlisted")),
        stub.judged(strange, stub.content("effect", LAG, p={LAG: 0.5, "unlisted": 0.4})),
        stub.judged(stub.answer("pair", SPRING, PUSH), stub.content("several", PUSH, SPRING)),
    ]


def test_figures_counted_by_hand():
    found = answers(tiny_set())
    counted = {key: (one["hits"], one["n"]) for key, one in found.items() if "hits" in one}
    assert counted == {
        "right": (5, 10),
        "top1": (2, 4),
        "top1_strong": (2, 3),
        "top2": (2, 4),
        "family": (3, 4),
        "none_called": (1, 3),
        "false_alarms": (1, 3),
        "unlisted_called": (1, 2),
        "unlisted_called_strong": (1, 2),
        "listed_called_unlisted": (1, 4),
        "pairs_right": (1, 1),
        "pairs_both": (1, 1),
        "pairs_one": (1, 1),
        "pairs_third": (0, 1),
        "aliases_as_class": (1, 1),
        "aliases_alone": (0, 1),
    }
    rest = 0.1 / (len(stub.ANSWERS) - 1)
    assert found["probability"]["value"] == pytest.approx((0.9 + rest + 0.9 + 0.0) / 4)
    assert found["auroc"]["value"] == pytest.approx((2 * 4) / (2 * 5))


def test_calibration_of_a_known_diagnoser():
    confident = [single(SPRING, "effect", SPRING, p={SPRING: 0.8})] * 80
    mistaken = [single(SPRING, "effect", PUSH, p={PUSH: 0.8})] * 20
    found = calibration([*confident, *mistaken])
    assert found["n"] == 100 and 0 < found["perfect"] < 0.4
    rest = 0.2 / (len(stub.ANSWERS) - 1)
    assert found["log_loss"]["value"] == pytest.approx(-0.8 * math.log(0.8) - 0.2 * math.log(rest))
    assert found["brier"]["value"] == pytest.approx(0.8 * 0.04 + 0.2 * 0.64)
    assert sum(one["right"]["n"] for one in found["bins"]) == 100
    boastful = [single(SPRING, "effect", PUSH, p={PUSH: 0.95})] * 60
    assert calibration(boastful)["ece"] == pytest.approx(0.95)
    assert calibration(boastful)["ece"] > calibration(boastful)["perfect"]
    assert calibration([single(SPRING, None)])["log_loss"]["value"] == pytest.approx(-math.log(1e-6))
    assert calibration([])["ece"] is None


def test_the_band_is_that_of_a_perfect_diagnoser():
    random = np.random.default_rng(5)
    inside = []
    for _ in range(60):
        stated = random.uniform(0.55, 1.0, 60)
        cases = [
            single(SPRING, "effect", SPRING, p={SPRING if right else PUSH: confidence})
            for confidence, right in zip(stated.tolist(), random.random(60) < stated, strict=True)
        ]
        found = calibration(cases)
        inside.append(found["ece"] <= found["perfect"])
    assert 51 <= sum(inside) <= 60
    assert found["perfect"] < 0.25


def interval(value, low, high, unit="N"):
    return {"value": value, "low": low, "high": high, "unit": unit}


def test_intervals_and_true_values():
    assert holds(interval(1.0, 0.9, 1.1), 1.05) is True
    assert holds(interval(1.0, 0.9, 1.1), 1.2) is False
    assert holds(interval(1.0, 0.9, None), 7.0) is True
    assert holds(interval(1.0, None, None), 1.0) is None
    assert holds(interval(0.1, -0.1, 0.3, "rad"), 0.2 + 4 * math.pi) is True
    found = {
        SPRING: {"parameters": {"strength": interval(2.0, 1.5, 2.5), "angle": interval(0.1, 0.0, 0.2, "rad")}}
    }
    held = single(SPRING, "effect", SPRING, effects=found, strength=(2.4, "N"), angle=(0.15, "rad"))
    turned = single(
        SPRING, "effect", SPRING, effects=found, strength=(-2.4, "N"), angle=(0.15 - math.pi, "rad")
    )
    missed = single(SPRING, "effect", SPRING, effects=found, strength=(2.6, "N"), other=(1.0, "s"))
    elsewhere = single(SPRING, "effect", SPRING, effects=found, tier="B", strength=(9.0, "N"))
    wrong = single(SPRING, "effect", PUSH, effects=found, strength=(9.0, "N"))
    counted = coverage([held, turned, missed, elsewhere, wrong])
    assert (counted["parameters"]["hits"], counted["parameters"]["n"]) == (4, 5)
    assert counted["not_compared"] == [f"{SPRING}.other"]


def test_constants_with_the_effect_and_without():
    after = {name: interval(value, 0.9 * value, 1.1 * value) for name, value in stub.CONSTANTS.items()}
    before = {**after, "C": interval(9.0, 8.9, 9.1), "D": interval(1.0, None, None)}
    result = stub.content("effect", SPRING, constants=after, constants_before=before)
    counted = coverage([stub.judged(stub.answer("single", SPRING), result)])
    assert counted["constants"]["all"]["hits"] == 5
    assert (counted["constants_before"]["all"]["hits"], counted["constants_before"]["all"]["n"]) == (3, 4)
    assert counted["constants_before"]["unbounded"] == 1
    assert counted["error_before"]["C"] == pytest.approx(0.5) and counted["error_after"]["C"] == 0.0


def test_closure_of_named_effects_alone():
    gap = {
        "before": 5.0,
        "floor": 1.0,
        "closed": 0.5,
        "closed_interval": [0.4, 0.99],
        "placebo_closed": 0.02,
        "best_wrong_closed": 0.4,
    }
    cases = [single(SPRING, "effect", SPRING), single(SPRING, "effect", SPRING, gap=12.0)]
    cases += [stub.judged(stub.answer("single", SPRING), stub.content("effect", SPRING, gap=gap))]
    cases += [single(SPRING, "effect", PUSH)]
    found = closure(cases)
    assert found["median"]["value"] == pytest.approx(0.99) and found["median"]["n"] == 3
    assert (found["margin"]["hits"], found["margin"]["n"]) == (2, 3)
    assert (found["covered"]["hits"], found["covered"]["n"]) == (2, 3)
    assert closure([dataclasses.replace(case, tier="B") for case in cases])["covered"]["n"] == 0


def test_nothing_closes_where_held_out_runs_show_no_gap():
    nothing = {
        "before": 1.02,
        "floor": 1.0,
        "closed": 0.0,
        "closed_interval": [0.0, 0.0],
        "best_wrong_closed": 0.0,
    }
    told_otherwise = stub.judged(stub.answer("single", SPRING), stub.content("effect", SPRING, gap=nothing))
    found = closure([single(SPRING, "effect", SPRING), told_otherwise])
    assert found["median"]["n"] == found["covered"]["n"] == 1
    assert (found["margin"]["hits"], found["margin"]["n"]) == (1, 1)


def test_the_curve_finds_the_limit_it_was_drawn_from():
    random = np.random.default_rng(3)
    ratios = np.exp(random.uniform(np.log(0.5), np.log(8.0), 3000))
    chances = 1 / (1 + np.exp(-(np.log(9.0) + 3.0 * np.log(ratios / 1.7))))
    found = curve(ratios.tolist(), (random.random(3000) < chances).tolist())
    assert found is not None
    assert found["a90"]["low"] < 1.7 < found["a90"]["high"]
    assert found["a90"]["value"] == pytest.approx(1.7, rel=0.08)
    always = curve(ratios[:30].tolist(), [True] * 30)
    assert always is not None and min(always["probability"]) > 0.8 and always["a90"] is None
    assert max(always["probability"]) < 0.9999
    assert curve([1.0, 2.0], [True, False]) is None
    assert curve([1.0] * 20, [True] * 20) is None


def foreseen(key: str, **strengths: tuple[float | None, str]) -> dict[str, dict]:
    """The limits that a diagnosis predicts for the strengths of one effect."""
    entries = {name: {"limit": limit, "unit": unit} for name, (limit, unit) in strengths.items()}
    return {key: {"strengths": entries, "likest": None, "cosine": None}}


def test_the_strength_over_the_predicted_limit():
    def ratio(strengths, verdict: str | None = "none", **true) -> float | None:
        made_up = {"detection_limits": foreseen(LAG, **strengths)}
        return predicted_ratio(single(LAG, verdict, **made_up, **true))

    both = {"cosine": (0.5, "N"), "sine": (2.0, "N")}
    assert ratio(both, cosine=(1.5, "N"), sine=(-8.0, "N"), length=(3.0, "m")) == pytest.approx(5.0)
    assert ratio(both, sine=(8.0, "N")) == pytest.approx(4.0)
    assert ratio({**both, "sine": (None, "N")}, cosine=(1.5, "N"), sine=(8.0, "N")) == pytest.approx(3.0)
    assert ratio(both, sine=(8.0, "1")) is None and ratio(both, force=(8.0, "N")) is None
    assert ratio(both, None, sine=(8.0, "N")) is None
    others = {"detection_limits": foreseen(PUSH, sine=(2.0, "N"))}
    assert predicted_ratio(single(LAG, "none", sine=(8.0, "N"), **others)) is None
    assert predicted_ratio(single(LAG, "none", sine=(8.0, "N"))) is None
    pair = stub.answer("pair", LAG, PUSH, sine=(8.0, "N"))
    result = stub.content("none", detection_limits=foreseen(LAG, **both))
    assert predicted_ratio(stub.judged(pair, result)) is None
    assert predicted_ratio(stub.judged(stub.answer("none"), result)) is None


def weak(key: str, ratio: float, named: bool) -> Judged:
    """An effect of so many predicted limits, the limits being the records' own."""
    made_up = {"detection_limits": foreseen(key, force=(2.0 / ratio, "N"))}
    answered = ("effect", key) if named else ("none",)
    return single(key, *answered, limit=2 * ratio, force=(2.0, "N"), **made_up)


def test_what_is_named_beyond_the_predicted_limit():
    cases = [weak(SPRING, ratio, ratio > 1) for ratio in np.geomspace(0.3, 9.0, 30).tolist()]
    cases += [weak(PUSH, ratio, ratio > 2) for ratio in (0.5, 1.4, 1.6, 3.0)]
    cases += [single(LAG, "effect", LAG), single(LAG, None)]
    found = limits(cases)
    assert found["not_predicted"] == 2
    assert found["predicted_ratio"]["n"] == 34 and 0.5 < found["predicted_ratio"]["a90"]["value"] < 3
    beyond = sum(ratio >= 1.5 for ratio in np.geomspace(0.3, 9.0, 30))
    named = found["named_beyond_predicted"]
    assert (named["hits"], named["n"]) == (beyond + 1, beyond + 2)
    assert (found["effects_beyond_predicted"]["hits"], found["effects_beyond_predicted"]["n"]) == (1, 2)
    assert limits(cases[-2:])["predicted_ratio"] is None

    whole = scored(cases, {}, {"seal": {"sha256": "ab"}, "cases": {}})
    push, lag = whole["effects"][PUSH], whole["effects"][LAG]
    assert (push["named_beyond_predicted"]["hits"], push["named_beyond_predicted"]["n"]) == (1, 2)
    assert lag["named_beyond_predicted"]["n"] == 0 and lag["a90_predicted"] is None
    assert whole["effects"][SPRING]["a90_predicted"]["value"] > 0.5
    rows = {row[0]: row for row in further_rows(whole)}
    titles = list(rows)
    first = titles.index("named beyond 1.5 predicted limits")
    assert first < titles.index("named beyond 1.5 limits of an ideal observer")
    assert rows[titles[first]][1] == figure(named) and rows[titles[first]][-1] == "≥ 90 %"
    assert rows["one effect, but no predicted limit to compare with: cases"][1] == "2"
    assert all(len(row) == len(EFFECT_COLUMNS) for row in effect_rows(whole))
    headings = [picture.title for picture in pictures(whole)]
    assert "diagnosis predicts" in headings[1] and "ideal observer" in headings[2]


def test_a_score_from_before_limits_were_predicted_is_shown():
    whole = scored(tiny_set(), {}, {"seal": {"sha256": "ab"}, "cases": {}})
    assert whole["tiers"]["all"]["limits"]["not_predicted"] == 4
    new = ("predicted_ratio", "named_beyond_predicted", "effects_beyond_predicted", "not_predicted")
    for tier in whole["tiers"].values():
        tier["limits"] = {key: value for key, value in tier["limits"].items() if key not in new}
    for effect in whole["effects"].values():
        del effect["named_beyond_predicted"], effect["a90_predicted"]
    assert all("predicted" not in row[0] for row in further_rows(whole))
    assert all(row[5] == row[6] == "-" for row in effect_rows(whole))
    assert len(Page(score_page(whole)).all("svg")) == 2


def candidate(score: float, chi2: float, *effects: str, parameters: int = 1):
    return {
        "effects": list(effects),
        "score": score,
        "chi2_per_sample": chi2,
        "parameters": {str(number): {} for number in range(parameters)},
    }


def test_baselines_read_the_candidates():
    tried = [
        candidate(900.0, 3.0, PUSH),
        candidate(500.0, 1.0, SPRING),
        candidate(999.0, 0.999, SPRING, LAG, parameters=2),
    ]
    case = single(SPRING, "effect", PUSH, candidates=tried)
    assert by_bic(case).named == (SPRING,) and by_bic(case).right()
    assert by_signature(case).named == (PUSH,) and not by_signature(case).right()
    assert sum(by_bic(case).probabilities.values()) == pytest.approx(1.0)
    dear = [candidate(900.0, 9.99, SPRING, parameters=3)]
    assert by_bic(single(SPRING, "effect", SPRING, candidates=dear)).verdict == "none"
    quiet = stub.content("effect", SPRING, where={"excess": 0.01, "significance": 1.0}, candidates=tried)
    assert by_signature(stub.judged(stub.answer("none"), quiet)).verdict == "none"
    assert by_bic(single(SPRING, None)).verdict == "no answer"


@pytest.fixture
def sealed(tmp_path) -> tuple[Path, str]:
    """A set of four cases, three of them diagnosed."""
    key, folder = new_key(), tmp_path / "set"
    truths = [stub.answer("single", SPRING), stub.answer("none", tier="B")] * 2
    names = stub.made_set(folder, key, truths)
    results = Results(default_results(folder))
    results.begin(read_manifest(folder), 0, False)
    stub.keep(results, folder, names[0], stub.content("effect", SPRING))
    stub.keep(results, folder, names[1], stub.content("none"))
    stub.keep(results, folder, names[2], stub.content("effect", PUSH))
    results.keep_failure(names[3], "The motion was <lost>.")
    return folder, key


def run_command(capsys, *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as ended:
        command(list(words), prog_name="jaxstick")
    out, err = capsys.readouterr()
    return int(ended.value.code or 0), out, err


def test_the_command_scores(sealed, capsys, tmp_path):
    folder, key = sealed
    out = tmp_path / "score"
    code, said, err = run_command(
        capsys, "blind", "score", str(folder), "--key", key, "--json", "--out", str(out)
    )
    assert code == 0
    found = json.loads(said)
    assert found == json.loads((out / "score.json").read_text())
    assert found["missing"] == {"case-0004": "The motion was <lost>."}
    assert list(found["tiers"]) == ["all", "A", "B"]
    assert found["tiers"]["all"]["top1"]["hits"] == 1 and found["tiers"]["all"]["none_called"]["n"] == 2
    assert found["tiers"]["B"]["none_called"]["value"] == 0.5
    assert found["confusion"] == {"none": {"none": 1, "no answer": 1}, SPRING: {SPRING: 1, PUSH: 1}}
    assert [one["case"] for one in found["mistakes"]] == ["case-0003", "case-0004"]
    assert found["baselines"]["chance"]["top1"] == pytest.approx(1 / len(stub.ANSWERS))
    assert "case-0004: The motion was <lost>." in err and "named first" in err
    page = Page((out / "score.html").read_text())
    assert page.loads() == []
    assert "The motion was <lost>." in page.text and sentence(found) in page.text
    assert len(page.all("figure")) == 2 and len(page.all("svg")) == 2
    identifiers = [one.attributes["id"] for one in page.elements if "id" in one.attributes]
    assert len(identifiers) == len(set(identifiers))


def test_a_part_of_the_cases_is_scored(sealed, capsys):
    folder, key = sealed
    words = ("blind", "score", str(folder), "--key", key, "--cases")
    code, said, err = run_command(capsys, *words, "1-3", "--json")
    found = json.loads(said)
    assert code == 0 and found["missing"] == {} and found["cases"] == 3 and found["set"]["cases"] == 4
    assert found["tiers"]["all"]["none_called"]["n"] == 1 and "(3 of 4 cases)" in err
    code, said, err = run_command(capsys, *words, "3-5")
    assert code == 2 and said == "" and "there is no case 5" in err


def test_a_full_score_has_every_picture():
    cases = [
        single(SPRING, "effect", SPRING if ratio > 1 else PUSH, limit=ratio, gap=3 * ratio)
        for ratio in np.geomspace(0.5, 8, 20).tolist()
    ]
    found = scored(cases + tiny_set(), {}, {"seal": {"sha256": "ab"}, "cases": {}})
    page = Page(score_page(json.loads(json.dumps(found))))
    assert len(page.all("svg")) == 4
    assert found["effects"][SPRING]["a90"]["value"] > 0.5
    assert any(row[0].startswith("exact aliases") for row in answer_rows(found))


def test_what_cannot_be_opened_is_one_sentence(sealed, capsys, tmp_path):
    folder, key = sealed

    def refused(*words: str, expected: str) -> None:
        code, out, err = run_command(capsys, "blind", "score", str(folder), *words)
        assert code == 2 and out == "" and expected in err and err.count("\n") == 1

    refused("--key", new_key(), expected="this key does not open it")
    refused("--key", "abc", expected="not one of ours")
    refused(expected="by --key or by --key-file")
    refused("--key", key, "--results", str(tmp_path / "none"), expected="there are no results here")
    key_file = tmp_path / "key"
    refused("--key-file", str(key_file), expected="cannot be read")
    key_file.write_text(key + "\n")
    stub.made_set(tmp_path / "other", key, [stub.answer("none")])
    other = Results(tmp_path / "other-results")
    other.begin(read_manifest(tmp_path / "other"), 0, False)
    refused("--key-file", str(key_file), "--results", str(other.folder), expected="another set of cases")
    record = folder / "case-0001" / "run-01.csv"
    whole = record.read_bytes()
    record.write_bytes(whole + b"3,3,3\n")
    refused("--key", key, expected="the file was changed")
    record.unlink()
    refused("--key", key, expected="the file is missing")
    record.write_bytes(whole)
    (folder / SEALED).write_bytes((folder / SEALED).read_bytes() + b"x")
    refused("--key", key, expected="the sealed answers were changed")


def test_verdicts_are_parted_by_what_a_rig_is_like():
    def case(on_base: bool, right: bool) -> Judged:
        made = single(SPRING, "effect", SPRING if right else PUSH)
        physics = {**stub.RECIPE["physics"], "against_base": float(on_base)}
        recipe = {**stub.RECIPE, "physics": physics}
        return dataclasses.replace(made, answer={**made.answer, "recipe": recipe})

    cases = [case(*one) for one in [(True, False)] * 3 + [(True, True)] + [(False, True)] * 4]
    found = by_rig(cases)
    assert list(found) == ["the base carries the guide"], "every case is alike in all else"
    one = found["the base carries the guide"]
    assert (one["with"]["hits"], one["with"]["n"]) == (1, 4)
    assert (one["without"]["hits"], one["without"]["n"]) == (4, 4)
    assert one["p"] == pytest.approx(2 * 4 / 56), "of 56 ways to place three misses 4 lie on each end"
    rows = rig_rows({"rigs": found})
    assert rows[0][:3] == (
        "the base carries the guide", "1 of 4, 25 % (0.6 to 81)", "4 of 4, 100 % (40 to 100)",
    )  # fmt: skip
    assert rig_rows({}) == [], "as records of early scores"


def test_every_trait_of_a_rig_is_found_in_the_recipes_of_cases():
    rigs = [tiny_rig(number, tier)[0] for number in range(1, 13) for tier in "AC"]
    random = np.random.default_rng(1)
    plans = [with_statement(rig, random).plain() for rig in rigs]
    for trait, so in TRAITS.items():
        assert len({so(plan) for plan in plans}) == 2, trait


def test_a_diagnosis_of_other_data_counts_as_none(sealed, capsys):
    folder, key = sealed
    place = default_results(folder) / "case-0001" / "diagnosis.json"
    place.write_text((default_results(folder) / "case-0002" / "diagnosis.json").read_text())
    _, said, _ = run_command(capsys, "blind", "score", str(folder), "--key", key, "--json")
    assert json.loads(said)["missing"]["case-0001"] == "it was not diagnosed"


def test_numbers_as_people_read_them():
    assert [percent(value) for value in (None, 0.0, 0.0312, 0.5, 0.985, 1.0)] == [
        "-",
        "0.0 %",
        "3.1 %",
        "50 %",
        "98.5 %",
        "100 %",
    ]
