"""Effects that a rig file states: what is refused, what they do to a simulation, a check and a sweep."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from jaxstick import cli
from jaxstick.catalogue import catalogue
from jaxstick.effects.cubic_stiffness import CubicStiffness
from jaxstick.effects.dwell_strengthening import DwellStrengthening
from jaxstick.effects.force_delay import ForceDelay
from jaxstick.hypothesis import Hypothesis, effects_as_stated
from jaxstick.nominal import effects_of, nominal
from jaxstick.oscillator import Start
from jaxstick.parts.drive import SineDrive
from jaxstick.record import RigSheet, load_dataset, load_rig, rig_document, save_dataset
from jaxstick.side_by_side import Journey, side_by_side
from jaxstick.simulations import simulations
from jaxstick.sweep import sweep
from jaxstick.sweeps.plan import plan_sweep
from tests.jaxstick import rig_text

RIG = 'name = "rig of 1987"\n' + rig_text.RIG
RUN = """\
[[run]]
frequency_hz = 1.5
base_amplitude_mm = 10.0
cycles = 2
sample_rate_hz = 250
"""
HARDENING = "[effects.cubic_stiffness]\ncoefficient = 1.2e6\n"
RATIOS = (0.35, 0.6)


def written(folder: Path, effects: str = "") -> Path:
    path = folder / "rig.toml"
    path.write_text(RIG + effects + RUN, encoding="utf-8")
    return path


def sheet(folder: Path, effects: str = "") -> RigSheet:
    return load_rig(written(folder, effects))


def friction(folder: Path, effects: str) -> np.ndarray:
    """The friction force that a simulated run would record."""
    (run,) = simulations(sheet(folder, effects)).runs
    assert run.friction is not None
    return run.friction


def jaxstick(*args: object) -> Result:
    return CliRunner().invoke(cli.jaxstick, [str(arg) for arg in args])


@pytest.mark.parametrize(
    ("effects", "words"),
    [
        ("[effects]\ncubic_stiffness = 3\n", ("[effects] cubic_stiffness is the number 3", "a section [eff")),
        ("[effects.cubic_stiffness]\ncoefficient = 'big'\n", ("line 13", "coefficient is the text 'big'")),
        ("[effects.cubic_stiffness]\ncoefficient = true\n", ("line 13", "coefficient is true")),
        ("[effects.cubic_stiffness]\ncoefficient = inf\n", ("line 13", "expected is a finite number")),
        ("[[effects]]\nkey = 'cubic_stiffness'\n", ("effects is a list", "a section [effects]")),
        ("[effects.cubic_stifness]\n", ("no effect called 'cubic_stifness'", "mean 'cubic_stiffness'?")),
        ("[effects.qqq]\n", ("no effect called 'qqq'", "there are ", "force_delay")),
        ("[effects.cubic_stiffness]\ncoeff = 1.0\n", ("[effects.cubic_stiffness]", "mean 'coefficient'?")),
        ("[effects.force_delay]\nx = 1.0\n", ("[effects.force_delay]", "'x'; there are delay.")),
        ("[effects.force_delay]\ndelay = -1e-3\n", ("delay is -0.001", "must lie between 0 and 0.05 s")),
        ("[effects.force_delay]\ndelay = 0.06\n", ("delay is 0.06", "must lie between 0 and 0.05 s")),
        ("[effects.dwell_strengthening]\ncutoff = 0.0\n", ("cutoff is 0", "must be at least 1e-06 s")),
    ],
)
@pytest.mark.parametrize("command", ["simulate", "sweep"])
def test_a_mistake_is_one_sentence_that_names_file_and_key(tmp_path, effects, words, command):
    path = written(tmp_path, effects)
    options = () if command == "simulate" else ("--ratios", "0.5")
    result = jaxstick(command, path, *options, "--out", tmp_path / "out")
    assert result.exit_code == 2 and result.stdout == ""
    assert result.stderr.count("\n") == 1 and result.stderr.rstrip()[-1] in ".?"
    for word in (str(path), *words):
        assert word in result.stderr
    assert not (tmp_path / "out").exists()


def test_what_is_not_given_is_at_null_or_in_its_usual_shape(tmp_path):
    stated = effects_of(
        sheet(tmp_path, "[effects.dwell_strengthening]\ngrowth = 0.02\n[effects.force_delay]\n")
    )
    assert list(stated) == ["dwell_strengthening", "force_delay"]
    assert stated["dwell_strengthening"] == dataclasses.replace(DwellStrengthening(), growth=0.02)
    assert stated["force_delay"] == ForceDelay(delay=0.0)


@pytest.mark.parametrize("key", catalogue())
def test_every_effect_can_be_stated_as_it_is(key):
    effect = catalogue()[key]()  # pyright: ignore[reportCallIssue]
    values = {field.name: float(getattr(effect, field.name)) for field in dataclasses.fields(effect)}
    assert effects_as_stated({key: values}, "rig.toml")[key] == effect


def test_a_simulation_with_stated_effects_is_the_librarys(tmp_path):
    stated = HARDENING + "[effects.force_delay]\ndelay = 0.004\n"
    (run,) = simulations(sheet(tmp_path, stated)).runs
    (plain,) = simulations(sheet(tmp_path)).runs
    given = sheet(tmp_path)
    effects = {"a": CubicStiffness(1.2e6), "b": ForceDelay(0.004)}
    oscillator = Hypothesis(nominal(given.rig, given.assumed, SineDrive(1.5, 0.01)), effects).oscillator()
    (motion,) = side_by_side([Journey(oscillator, Start(), 0.0, 1 / 250, len(run.time))])
    np.testing.assert_array_equal(run.displacement, motion.displacement)
    np.testing.assert_array_equal(run.friction, motion.friction)
    assert np.max(np.abs(run.displacement - plain.displacement)) > 1e-4


def test_the_order_in_the_file_is_that_of_the_measuring_chain(tmp_path):
    gain, offset = "[effects.force_gain]\ngain = 0.4\n", "[effects.force_offset]\noffset = 3.0\n"
    plain, one, other = (friction(tmp_path, text) for text in ("", gain + offset, offset + gain))
    np.testing.assert_allclose(one, 1.4 * plain + 3.0, rtol=1e-12)
    np.testing.assert_allclose(other, 1.4 * (plain + 3.0), rtol=1e-12)


def test_the_order_of_other_effects_means_nothing(tmp_path):
    uneven = "[effects.asymmetric_friction]\ndry = 0.2\n"
    one, other = (friction(tmp_path, text) for text in (HARDENING + uneven, uneven + HARDENING))
    np.testing.assert_array_equal(one, other)


def test_a_file_is_written_in_the_order_in_which_it_was_read(tmp_path):
    chain = "[effects.mains_hum]\n[effects.force_clipping]\n[effects.force_delay]\n"
    assert list(simulations(sheet(tmp_path, chain)).effects) == ["mains_hum", "force_clipping", "force_delay"]


def test_a_sweep_of_another_order_is_another_sweep(tmp_path):
    gain, offset = "[effects.force_gain]\ngain = 0.4\n", "[effects.force_offset]\noffset = 3.0\n"
    plans = [plan_sweep(sheet(tmp_path, text), {"ratios": RATIOS}) for text in (gain + offset, offset + gain)]
    assert plans[0].fingerprint != plans[1].fingerprint


def test_a_simulated_data_set_states_its_effects_again(tmp_path):
    out = tmp_path / "out"
    assert jaxstick("simulate", written(tmp_path, HARDENING), "--out", out, "--quiet").exit_code == 0
    again = load_dataset(out)
    assert again.effects == {"cubic_stiffness": {"coefficient": 1.2e6}}
    assert "Simulated with the assumed constants and effects" in (out / "rig.toml").read_text()
    shown = jaxstick("check", out)
    assert "effect cubic_stiffness" in shown.stdout and "coefficient = 1.2e+06" in shown.stdout
    (out / "rig.toml").write_text((out / "rig.toml").read_text().replace("coefficient", "coeff"))
    assert jaxstick("check", out).exit_code == 2


def test_a_file_without_effects_says_nothing_of_them(tmp_path):
    given = sheet(tmp_path)
    simulated = simulations(given)
    assert given.effects == {} and "effect" not in rig_document(simulated).as_string()
    plan = plan_sweep(given, {"ratios": RATIOS})
    assert "effects" not in plan.described() and plan.points().hypothesis.effects == {}


def test_the_base_is_written_as_its_channel_shows_it(tmp_path):
    (run,) = simulations(sheet(tmp_path, "[effects.base_gain]\ngain = 0.25\n")).runs
    assert run.base is not None
    assert np.max(run.base) == pytest.approx(0.01, rel=1e-3)


def test_a_record_is_followed_with_the_effects_of_another_rig_file(tmp_path):
    records = tmp_path / "records"
    save_dataset(simulations(sheet(tmp_path, HARDENING)), records)
    text = (records / "rig.toml").read_text()
    (records / "rig.toml").write_text(
        text.replace("[effects.cubic_stiffness]\ncoefficient = 1200000.0\n", "")
    )
    errors = {}
    for name, options in {"own": (), "other": ("--rig", written(tmp_path, HARDENING))}.items():
        out = tmp_path / name
        result = jaxstick("simulate", records, "--out", out, "--quiet", *options)
        assert result.exit_code == 0, result.stderr
        (run,), (record,) = load_dataset(out).runs, load_dataset(records).runs
        errors[name] = float(np.sqrt(np.mean((run.displacement - record.displacement) ** 2)))
    assert errors["other"] < 0.05 * errors["own"]


def test_another_rig_file_asks_for_records(tmp_path):
    path = written(tmp_path, HARDENING)
    result = jaxstick("simulate", path, "--rig", path, "--out", tmp_path / "out")
    assert result.exit_code == 2 and "no folder with a record" in result.stderr


def test_without_a_recorded_force_the_start_knows_the_true_mass(tmp_path):
    stated = "[effects.stiffness_error]\nmass = 0.5\nstiffness = 40.0\n"
    given = simulations(sheet(tmp_path, stated))
    (run,) = given.runs
    late = {name: getattr(run, name)[110:] for name in ("time", "displacement", "base")}
    silent = dataclasses.replace(run, friction=None, **late)
    (followed,) = simulations(dataclasses.replace(given, runs=(silent,))).runs
    assert run.friction is not None and followed.friction is not None
    assert followed.friction[0] == pytest.approx(run.friction[110], abs=0.4)


def test_a_sweep_of_stated_effects_is_the_librarys(tmp_path):
    path = written(tmp_path, HARDENING)
    result = jaxstick("sweep", path, "--ratios", "0.35,0.6", "--out", tmp_path / "out", "--json")
    assert result.exit_code == 0, result.stderr
    content = json.loads(result.stdout)
    given = sheet(tmp_path)
    found = sweep(
        given.rig,
        given.assumed,
        ratios=RATIOS,
        amplitudes=[0.01],
        effects={"any": CubicStiffness(1.2e6)},
    )
    assert [lane["amplitude_m"] for lane in content["lanes"]] == found["amplitude_m"].tolist()
    assert content["effects"] == {"cubic_stiffness": {"coefficient": 1.2e6}}
    plain = sweep(given.rig, given.assumed, ratios=RATIOS, amplitudes=[0.01])
    assert np.all(np.abs(plain["amplitude_m"] / found["amplitude_m"] - 1) > 1e-3)


def test_plans_differ_by_their_effects(tmp_path):
    fingerprints = {
        plan_sweep(sheet(tmp_path, effects), {"ratios": RATIOS}).fingerprint
        for effects in ("", HARDENING, HARDENING.replace("1.2", "1.3"))
    }
    assert len(fingerprints) == 3


def test_what_drifts_in_a_run_has_no_periodic_state(tmp_path):
    path = written(tmp_path, "[effects.friction_drift]\nrate = 0.01\n")
    result = jaxstick("sweep", path, "--ratios", "0.5", "--out", tmp_path / "out")
    assert result.exit_code == 2 and result.stderr.count("\n") == 1
    assert f"{path}: [effects.friction_drift] changes in the course of a run" in result.stderr


def test_a_sweep_says_which_effects_it_does_not_show(tmp_path):
    stated = sheet(tmp_path, HARDENING + "[effects.force_delay]\ndelay = 0.004\n[effects.base_gain]\n")
    (notice,) = plan_sweep(stated, {"ratios": RATIOS}).notices
    assert "[effects.force_delay] concerns what is recorded" in notice
