"""corrected_rig.toml: what a fit found, kept as a rig file that every command takes."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from fitting import cli
from fitting.compare import compare
from fitting.corrected_rig import CORRECTED_FILE, corrected_rig
from fitting.correction import Correction, correction_of
from fitting.fit import fit
from fitting.problem import beginnings, pose
from fitting.result import Fit
from fitting.save import fit_content, save_fit
from fitting.saved import read_fit
from fitting.settings import Settings
from fitting.verbs import fit as fit_verb
from jaxstick.effects.cubic_stiffness import CubicStiffness
from jaxstick.hypothesis import Hypothesis
from jaxstick.nominal import nominal
from jaxstick.oscillator import Start
from jaxstick.output import OutputFolder, to_json
from jaxstick.parts.drive import SineDrive
from jaxstick.record import DataSet, load_dataset, load_rig, save_dataset
from jaxstick.side_by_side import Journey, side_by_side
from jaxstick.simulations import simulations
from tests.fitting.tiny import NOISE, TRUE, recorded, tiny_dataset

STATED = {"cubic_stiffness": {"coefficient": 1.2e6}, "force_gain": {"gain": 0.1}}


def jaxstick(*args: object) -> Result:
    return CliRunner().invoke(cli.jaxstick, [str(arg) for arg in args])


@pytest.fixture(scope="module")
def bent() -> DataSet:
    """The small data set with a spring that hardens and a force that reads too high, both stated."""
    data = tiny_dataset()
    true = dataclasses.replace(
        data, effects=STATED, runs=tuple(dataclasses.replace(run, assumed=TRUE) for run in data.runs)
    )
    runs = recorded(simulations(true).runs, np.random.default_rng(5))
    return dataclasses.replace(data, effects=STATED, runs=runs)


@pytest.fixture(scope="module")
def bent_folder(bent, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("bent") / "data"
    save_dataset(bent, folder)
    return folder


@pytest.fixture(scope="module")
def held(bent_folder) -> Fit:
    """A fit with one of the stated effects free and the other as stated, and the damping free."""
    settings = Settings(
        starts=1, descent_iterations=15, workers=1, effects=("cubic_stiffness",), free=("damping",)
    )
    return fit(load_dataset(bent_folder), settings)


@pytest.fixture(scope="module")
def kept(held, bent_folder, tmp_path_factory) -> Path:
    """The folder that this fit leaves."""
    out = tmp_path_factory.mktemp("kept") / "out"
    with OutputFolder(out) as output:
        save_fit(held, load_dataset(bent_folder), output)
    return out


def test_effects_are_held_as_stated_but_for_those_that_are_freed(bent):
    problem = pose(bent, Settings(effects=("force_gain", "force_delay"), free=("mass",)))
    assert list(problem.hypothesis.effects) == ["cubic_stiffness", "force_gain", "force_delay"]
    gain, bend, *others = problem.unknowns.names[5:]
    assert (gain, bend, others) == ("force_gain.gain", "force_gain.bend", ["force_delay.delay", "rig.mass"])
    assert problem.hypothesis.effects["cubic_stiffness"] == CubicStiffness(1.2e6)
    first = problem.unknowns.values(beginnings(problem, Settings(starts=1))[0])
    assert first["force_gain.gain"] == pytest.approx(0.1) and first["force_delay.delay"] == 0.0
    assert pose(bent, Settings()).unknowns.names == ("A", "B", "C", "D", "k1")


def test_the_search_reaches_what_is_stated(bent):
    far = {"cubic_stiffness": {"coefficient": 1e9}, "dwell_strengthening": {"growth": 0.1, "cutoff": 3e-6}}
    problem = pose(dataclasses.replace(bent, effects=far), Settings(effects=tuple(far)))
    (first,) = beginnings(problem, Settings(starts=1))
    values = problem.unknowns.values(first)
    assert values["cubic_stiffness.coefficient"] == pytest.approx(1e9)
    assert values["dwell_strengthening.cutoff"] == pytest.approx(3e-6)


def test_a_fit_with_stated_effects_finds_the_truth(held, bent):
    assert held.outcome == "converged"
    assert held.hypothesis.effects["force_gain"].gain == 0.1
    assert {constant.name for constant in held.others} == {"cubic_stiffness.coefficient", "rig.damping"}
    found = {constant.name: constant for constant in (*held.constants, *held.others)}
    assert found["C"].value == pytest.approx(TRUE.C, abs=0.05)
    coefficient = found["cubic_stiffness.coefficient"]
    assert coefficient.assumed == 1.2e6
    assert coefficient.low is not None and coefficient.high is not None
    assert coefficient.low < 1.2e6 < coefficient.high
    content = fit_content(held, bent)
    assert content["effects"] == STATED and content["hypothesis"]["effects"] == list(STATED)


def test_the_corrected_rig_moves_exactly_like_the_fitted_model(held, kept):
    sheet = load_rig(kept / CORRECTED_FILE)
    simulated = simulations(sheet).runs
    fitted = held.hypothesis
    for run in simulated:
        drive = SineDrive(run.frequency or 0.0, run.base_amplitude or 0.0)
        oscillator = Hypothesis(dataclasses.replace(fitted.nominal, drive=drive), fitted.effects).oscillator()
        (motion,) = side_by_side([Journey(oscillator, Start(), 0.0, 1 / 250, len(run.time))])
        np.testing.assert_array_equal(run.displacement, motion.displacement)
        np.testing.assert_array_equal(run.friction, motion.friction)


def test_it_holds_what_was_found_and_says_what_was_stated(held, kept, bent):
    sheet = load_rig(kept / CORRECTED_FILE)
    correction = correction_of(held.hypothesis, bent.rig)
    assert (sheet.rig, sheet.assumed, sheet.effects) == (
        correction.rig,
        correction.constants,
        correction.effects,
    )
    assert sheet.rig.damping != bent.rig.damping and sheet.rig.mass == bent.rig.mass
    assert sheet.effects["force_gain"] == {"gain": 0.1, "bend": 0.0} and sheet.noise == NOISE
    assert [run.file for run in sheet.runs] == [run.file for run in bent.runs]
    text = (kept / CORRECTED_FILE).read_text(encoding="utf-8")
    lines = {line.split(" = ")[0]: line for line in text.splitlines() if " = " in line}
    assert "# 95 %: " in lines["C_n"] and lines["C_n"].endswith("assumed: 5.6")
    assert "# 95 %: " in lines["damping_n_s_per_m"] and lines["damping_n_s_per_m"].endswith("stated: 4.53")
    assert "#" not in lines["mass_kg"]
    assert lines["coefficient"].endswith("stated: 1200000") and "95 %: " in lines["coefficient"]
    assert lines["gain"].endswith("stated: 0.1") and "95 %" not in lines["gain"]
    assert "# Spring hardens" in text or "[effects.cubic_stiffness] # " in text
    assert all(len(line) <= 110 for line in text.splitlines() if line.startswith("#"))
    assert "fit.json (converged)" in text


def test_every_command_takes_it(held, kept, bent_folder, tmp_path, monkeypatch):
    rig = kept / CORRECTED_FILE
    alone = jaxstick("simulate", rig, "--out", tmp_path / "alone", "--quiet")
    assert alone.exit_code == 0, alone.stderr
    assert [len(run.time) for run in load_dataset(tmp_path / "alone").runs] == [
        len(run.time) for run in load_dataset(bent_folder).runs
    ]
    with_records = jaxstick("simulate", bent_folder, "--rig", rig, "--out", tmp_path / "records", "--json")
    (first, _) = json.loads(with_records.stdout)["runs"]
    assert first["measured"]["amplitude_m"] == pytest.approx(first["amplitude_m"], rel=5e-3)
    swept = jaxstick("sweep", rig, "--ratios", "0.5", "--out", tmp_path / "sweep", "--json")
    assert swept.exit_code == 0, swept.stderr
    assert list(json.loads(swept.stdout)["effects"]) == list(STATED)

    asked = []

    def run_fit(data, settings, progress):
        asked.append(data)
        return held

    monkeypatch.setattr(fit_verb, "run_fit", run_fit)
    again = jaxstick("fit", bent_folder, "--rig", rig, "--out", tmp_path / "fit", "--quiet")
    assert again.exit_code == 0, again.stderr
    said = jaxstick("fit", bent_folder, "--out", tmp_path / "said")
    assert "force_gain acts as the rig file states." in said.stdout and CORRECTED_FILE in said.stdout
    sheet = load_rig(rig)
    assert (asked[0].effects, asked[0].rig, asked[0].assumed) == (sheet.effects, sheet.rig, sheet.assumed)
    assert (tmp_path / "fit" / CORRECTED_FILE).exists()

    compared = jaxstick("compare", kept / "fit.json", rig, "--json")
    for run in json.loads(compared.stdout)["runs"]:
        assert run["assumed"] == pytest.approx(run["identified"], rel=1e-6)


def test_a_comparison_counts_stated_effects_among_what_is_assumed(held, bent, kept):
    saved = read_fit(kept / "fit.json")
    assert saved.effects == STATED
    (run, _) = compare(saved).runs
    (plain, _) = compare(saved, dataclasses.replace(bent, effects={})).runs
    assert run.assumed is not None and plain.assumed is not None
    assert run.identified.amplitude == pytest.approx(plain.identified.amplitude, rel=1e-6)
    free = {name: entry for name, entry in saved.others.items() if name.startswith("rig.")}
    (as_stated, _) = compare(dataclasses.replace(saved, others=free)).runs
    assert as_stated.identified.amplitude == pytest.approx(run.identified.amplitude, rel=1e-5)
    assert abs(run.assumed.amplitude / plain.assumed.amplitude - 1) > 1e-3
    broken = {**fit_content(held, bent), "effects": {"nothing": {}}}
    (kept.parent / "broken.json").write_text(to_json(broken), encoding="utf-8")
    assert "no effect called 'nothing'" in jaxstick("compare", kept.parent / "broken.json").stderr


def test_a_rig_file_with_a_mistake_is_refused_before_anything_is_fitted(bent_folder, tmp_path, monkeypatch):
    monkeypatch.setattr(fit_verb, "run_fit", lambda *_: pytest.fail("a fit was begun"))
    rig = tmp_path / "rig.toml"
    rig.write_text((bent_folder / "rig.toml").read_text().replace("gain = 0.1", "gain = 7.0"))
    result = jaxstick("fit", bent_folder, "--rig", rig, "--out", tmp_path / "out")
    assert result.exit_code == 2 and f"{rig}: [effects.force_gain] gain is 7" in result.stderr
    rig.write_text((bent_folder / "rig.toml").read_text())
    over = jaxstick("fit", bent_folder, "--rig", rig, "--out", tmp_path)
    assert over.exit_code == 2 and "results may not replace" in over.stderr


def test_a_recorded_sine_is_written_down_and_own_rigs_stay_apart(tmp_path):
    data = tiny_dataset()
    heavier = dataclasses.replace(data.rig, mass=data.rig.mass + 0.25)
    first, second = data.runs
    runs = (
        dataclasses.replace(first, frequency=None, base_amplitude=None, rig=heavier),
        dataclasses.replace(second, frequency=None, base_amplitude=None, base=None, force=second.friction),
    )
    data = dataclasses.replace(data, runs=runs)
    correction = Correction(dataclasses.replace(data.rig, mass=2.5), TRUE, {})
    path = tmp_path / "rig.toml"
    path.write_text(corrected_rig(correction, data, [], {}), encoding="utf-8")
    sheet = load_rig(path)
    assert [run.rig.mass for run in sheet.runs] == [pytest.approx(2.75), 2.5]
    assert [run.assumed for run in sheet.runs] == [TRUE, TRUE] and sheet.effects == {}
    found, silent = sheet.runs
    assert found.frequency == pytest.approx(1.5, rel=1e-6) and found.base_amplitude == pytest.approx(
        10.325e-3
    )
    assert silent.frequency is None and "needs the record" in path.read_text()
    assert "as the record shows" in path.read_text()


def test_a_value_a_rounding_error_beyond_its_bound_is_on_it(bent):
    oscillator = nominal(bent.rig, TRUE, SineDrive(1.0))
    beyond = CubicStiffness(1.0)
    gain = pose(bent, Settings()).hypothesis.effects["force_gain"]
    over = dataclasses.replace(gain, gain=np.nextafter(0.5, 1.0))
    correction = correction_of(
        Hypothesis(oscillator, {"cubic_stiffness": beyond, "force_gain": over}), bent.rig
    )
    assert correction.effects["cubic_stiffness"] == {"coefficient": 1.0}
    assert correction.effects["force_gain"]["gain"] == 0.5
