"""The report: well-formed, complete, self-contained, escaped."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re

import numpy as np
import pytest

from fitting.diagnosis.findings import Closure
from fitting.progress import Silent
from fitting.report.report import report
from fitting.report.sections.traces import MOST_RUNS
from fitting.report.words import VERDICTS, estimate, in_parts, interval, number, percent, seconds, with_unit
from tests.fitting.diagnosis.fabricated import FAR, HELD_OUT, RIVAL, TRUTH, nothing_found, silent
from tests.fitting.diagnosis.markup import Page

LARGEST_FIGURE = 150_000
LARGEST_PAGE = 3_000_000
HOSTILE = '<script>alert("1")</script>&amp;.csv'


@pytest.fixture(scope="module")
def taken_apart(page) -> Page:
    return Page(page)


def figures(page: str) -> list[str]:
    return re.findall(r"<svg.*?</svg>", page, re.DOTALL)


def test_it_is_small_and_every_figure_is_there(page, diagnosis):
    drawn = figures(page)
    assert len(drawn) == 4 * len(diagnosis.traces) + 4
    assert max(map(len, drawn)) < LARGEST_FIGURE and len(page.encode()) < LARGEST_PAGE


def test_it_says_where_the_corrected_rig_is(page, diagnosis, dataset):
    assert "<code>corrected_rig.toml</code>" in page
    assert "corrected_rig" not in report(dataclasses.replace(diagnosis, correction=None), dataset, Silent())


def test_it_loads_nothing(taken_apart, page):
    assert taken_apart.loads() == []
    assert not taken_apart.all("script") and not taken_apart.all("link") and not taken_apart.all("iframe")
    for address in re.findall(r"url\(([^)]*)\)|@import\s+(\S+)", page):
        assert "".join(address).startswith("#"), address


def test_ids_are_unique_and_every_reference_arrives(taken_apart, page):
    ids = [element.attributes["id"] for element in taken_apart.elements if "id" in element.attributes]
    assert len(ids) == len(set(ids))
    targets = {
        element.attributes[name]
        for element in taken_apart.elements
        for name in ("href", "aria-labelledby")
        if name in element.attributes and not element.attributes[name].startswith("data:")
    }
    clips = re.findall(r"url\(#([^)]*)\)", page)
    assert clips and {target.removeprefix("#") for target in targets} | set(clips) <= set(ids)


def test_headings_are_in_order_and_figures_have_words(taken_apart):
    levels = [int(e.name[1]) for e in taken_apart.elements if re.fullmatch(r"h[1-6]", e.name)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))
    for element in taken_apart.all("svg"):
        assert element.attributes["role"] == "img" and element.attributes["aria-labelledby"]
    assert len(taken_apart.all("figcaption")) == len(taken_apart.all("figure")) == len(taken_apart.all("svg"))


def test_it_says_everything(taken_apart, diagnosis):
    text = taken_apart.text
    card = diagnosis.cards[TRUTH]
    sentences = (
        diagnosis.sentence,
        diagnosis.next_experiment,
        *diagnosis.steps,
        *diagnosis.notes,
        diagnosis.sha256,
        *(getattr(card, part) for part in ("title", "symptom", "explanation", "remedy", "source")),
        VERDICTS["effect"],
        "93 %",
        "95 % interval 97.1 to 99.4 %",
        "0.1162 to 0.1203",
        "run-03.csv and run-06.csv",
        "41.7 s",
        "6.4122 to 6.4278",
        "sign(v)",
        "-8100 N/m²",
        f"Best that was not named: {diagnosis.cards[FAR].title}",
    )
    for sentence in sentences:
        assert sentence in text, sentence
    assert "object at 0x" not in text and "nan" not in re.findall(r"\w+", text)


def test_effects_go_by_the_titles_of_their_cards(taken_apart, diagnosis):
    titles = {key: card.title for key, card in diagnosis.cards.items()}
    words = {key.replace("_", " ").capitalize() for key in titles}
    made_up = [name for name in words if not any(title.startswith(name) for title in titles.values())]
    assert not [name for name in made_up if re.search(rf"\b{name}\b", taken_apart.text)]
    likely = {key for candidate in diagnosis.candidates for key in candidate.keys}
    assert {titles[key] for key in likely} <= {t for t in titles.values() if t in taken_apart.text}


def test_only_what_was_considered_has_its_card_shown(taken_apart, diagnosis):
    shown = [card for card in diagnosis.cards.values() if card.symptom in taken_apart.text]
    assert 0 < len(shown) < len(diagnosis.cards) / 2


def test_the_worst_run_comes_first_and_the_others_are_folded(taken_apart):
    pictures = [e for e in taken_apart.all("svg") if e.attributes["id"].startswith("run-")]
    assert all(("details" in e.around) is not e.attributes["id"].startswith("run-1-") for e in pictures)
    assert not any("open" in e.attributes for e in taken_apart.all("details"))
    assert re.search(r"drawn as the range .*? run-04.csv", taken_apart.text)


def test_figures_take_their_colours_from_the_page(page):
    defined = set(re.findall(r"(--[\w-]+):", page))
    for figure in figures(page):
        used = set(re.findall(r"var\((--[\w-]+)\)", figure))
        assert "--fig-ink" in used and used <= defined
        assert not re.findall(r"(?:fill|stroke): ?#[0-9a-f]{3,6}", figure)


def test_names_from_the_data_are_escaped(diagnosis, dataset):
    first, *others = diagnosis.traces
    share = diagnosis.where.run
    hostile = dataclasses.replace(
        diagnosis,
        sentence=f"{HOSTILE} is to blame.",
        notes=(HOSTILE,),
        traces=(dataclasses.replace(first, file=HOSTILE), others[0]),
        where=dataclasses.replace(diagnosis.where, run={**share, HOSTILE: 5.0}),
        closure=dataclasses.replace(diagnosis.closure, held_out=(HOSTILE,)),
    )
    named = dataclasses.replace(dataset, name=HOSTILE)
    text = report(hostile, named, Silent())
    assert "<script" not in text and "&amp;amp;.csv" in text
    taken_apart = Page(text)
    assert not taken_apart.all("script") and taken_apart.text.count(HOSTILE) >= 6


def test_without_a_gap_there_is_a_report(diagnosis, dataset):
    clear = dataclasses.replace(nothing_found(diagnosis), traces=diagnosis.traces[:1])
    text = Page(report(clear, dataset, Silent())).text
    for words in (VERDICTS["none"], "No effect was added", "agree to within the noise", "Effects considered"):
        assert words in text
    for words in ("Next experiment", "What could look the same"):
        assert words not in text
    bare = Page(report(dataclasses.replace(clear, candidates=()), dataset, Silent())).text
    for words in ("Candidates that were refitted", "Effects considered"):
        assert words in text and words not in bare
    assert "nan" not in re.findall(r"\w+", text)


def test_what_the_records_could_have_shown(diagnosis, dataset):
    """Every strength of every effect; open where nothing was found, folded elsewhere."""
    few = dataclasses.replace(diagnosis, traces=diagnosis.traces[:1])
    for verdict in (few, nothing_found(few)):
        taken_apart = Page(report(verdict, dataset, Silent()))
        (table,) = [e for e in taken_apart.all("div") if e.attributes.get("aria-label") == "Detection limits"]
        assert table.around[-1] == "details" and table.attributes["class"] == "scroll"
        opened = [e for e in taken_apart.all("details") if "open" in e.attributes]
        assert len(opened) == (verdict.verdict == "none")
        said = taken_apart.text.split("What these records could have shown")[1].split("How far")[0]
        for limit in diagnosis.limits:
            assert limit.effect in said and limit.strength in said
            assert math.isinf(limit.value) or with_unit(number(limit.value, 2), limit.unit) in said
            assert f"cosine {limit.cosine:.2f}" in said
        assert "nine of ten such records" in said and "inf" not in re.findall(r"\w+", said)
    older = report(dataclasses.replace(few, limits=()), dataset, Silent())
    assert "could have shown" not in older


def test_runs_without_friction_force(diagnosis, dataset):
    mute = silent(dataclasses.replace(diagnosis, traces=diagnosis.traces[:2]))
    page = report(mute, dataset, Silent())
    assert len(figures(page)) == 3 * len(mute.traces) + 4
    assert "not recorded: models only" in Page(page).text


def test_other_verdicts(diagnosis, dataset):
    pair = dataclasses.replace(
        diagnosis,
        verdict="several",
        named=(TRUTH, RIVAL),
        effects={**diagnosis.effects, RIVAL: diagnosis.candidates[1].parameters},
        closed_alone={TRUTH: 0.71, RIVAL: 0.26},
        traces=diagnosis.traces[:1],
    )
    text = Page(report(pair, dataset, Silent())).text
    assert "The named effects" in text and "71 %" in text and "26 %" in text
    ambiguous = dataclasses.replace(pair, verdict="ambiguous", next_experiment=None)
    assert "What it may be" in Page(report(ambiguous, dataset, Silent())).text
    unlisted = dataclasses.replace(pair, verdict="unlisted", named=(), effects={}, candidates=())
    assert VERDICTS["unlisted"] in Page(report(unlisted, dataset, Silent())).text


def test_many_runs_and_segments(diagnosis, dataset):
    traces = tuple(
        dataclasses.replace(diagnosis.traces[-1], file=f"many-{number}.csv")
        for number in range(MOST_RUNS + 2)
    )
    judged = dataclasses.replace(diagnosis.closure, by_segments=True)
    many = dataclasses.replace(diagnosis, traces=traces, closure=judged)
    page = report(many, dataset, Silent())
    text = Page(page).text
    assert "in the folder of plots: many-8.csv, many-9.csv" in text and "in segments" in text
    assert len(page.encode()) < LARGEST_PAGE


def test_a_diagnosis_without_residual_force_or_cards(diagnosis, dataset):
    nothing = np.empty(0)
    bare = dataclasses.replace(
        diagnosis,
        residual_force=dataclasses.replace(
            diagnosis.residual_force,
            **dict.fromkeys(("force", "displacement", "slide_rate", "time", "run", "at_rest"), nothing),
        ),
        cards={},
        closure=Closure(6.8, 1.1, 1.0, None, 0.98, (0.97, 0.99), None, None, (), True),
        traces=diagnosis.traces[:1],
    )
    text = Page(report(bare, dataset, Silent())).text
    assert "The force on the mass" not in text and "Symptom" not in text
    assert "Judged on segments of the records" in text and HELD_OUT[0] not in text.split("Provenance")[0]


def test_what_the_gap_follows_is_shown_by_side(diagnosis, dataset):
    """What foretells next to nothing is not."""
    text = Page(report(diagnosis, dataset, Silent())).text
    shown = text.split("What it follows")[1].split("Residual force")[0]
    assert "9.40, 12.1 standard deviations above zero, without 1 segment far worse than the rest." in shown
    assert "beat at 41.3 Hz" in shown and "71 %" in shown and "speed" not in shown
    none = dataclasses.replace(diagnosis, follows={})
    assert "What it follows" not in Page(report(none, dataset, Silent())).text


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.934, "93 %"),
        (0.0004, "< 0.1 %"),
        (0.9996, "> 99.9 %"),
        (0.995, "99.5 %"),
        (1.0, "100 %"),
        (0.0, "0 %"),
        (0.052, "5.2 %"),
        (-0.01, "-1.0 %"),
        (1.04, "104 %"),
        (None, "-"),
        (float("nan"), "-"),
    ],
)
def test_shares_in_words(share, text):
    assert percent(share) == text


def test_numbers_in_words():
    assert [number(value) for value in (1.0, 14.23, 182400.4, 0.00612, 999.6, None, float("inf"))] == [
        "1.00",
        "14.2",
        "182400",
        "0.00612",
        "1.00e+03",
        "-",
        "-",
    ]
    assert estimate(0.09, None, None) == "0.090" and estimate(6.42, 6.41, 6.43) == "6.4200"
    assert interval(1.0, None, 2.0) == "up to 2.0" and interval(1.0, 0.5, None) == "from 0.50"
    assert interval(1.0, None, None) == "not bounded" and with_unit("not bounded", "N") == "not bounded"
    assert with_unit("3", "N/m^2") == "3 N/m²" and with_unit("3", "1") == "3"
    assert seconds(41.66) == "41.7 s" and seconds(185.2) == "3 min 5 s"


def test_names_may_break_behind_an_underscore():
    assert in_parts("force_delay + a<b") == "force_<wbr>delay + a&lt;b"
