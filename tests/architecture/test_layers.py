"""The source keeps to its layers, and the checker finds the line that does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.architecture import layers

ROOT = Path(__file__).resolve().parents[2]
OURS = layers.read_sources(ROOT, "jaxstick", "fitting")


@pytest.mark.parametrize("rule", layers.RULES, ids=lambda rule: rule.__name__)
def test_the_source_keeps_the_rule(rule):
    assert "jaxstick/__init__.py" in OURS and "fitting/__init__.py" in OURS
    findings = list(rule(OURS))
    assert not findings, "\n".join(findings)


def test_the_reference_models_stand_alone():
    findings = list(layers.reference_sees(layers.read_sources(ROOT, "tests/reference")))
    assert not findings, "\n".join(findings)


def tree(**files: str) -> dict[str, str]:
    """A made-up source tree: `jaxstick__parts__rig` is jaxstick/parts/rig.py; packages come by themselves."""
    packages = ("jaxstick", "jaxstick/parts", "jaxstick/effects", "fitting", "fitting/blind")
    sources = {f"{package}/__init__.py": "" for package in packages}
    return sources | {name.replace("__", "/") + ".py": text for name, text in files.items()}


OFFENCES = [
    (
        "unplaced_modules",
        tree(jaxstick__gadget=""),
        "jaxstick/gadget.py:1: jaxstick.gadget has no layer; add its name",
    ),
    (
        "upward_imports",
        tree(
            jaxstick__solver="import numpy\nfrom jaxstick.simulate import simulate\n", jaxstick__simulate=""
        ),
        "jaxstick/solver.py:2: imports jaxstick.simulate, which lies above it",
    ),
    (
        "upward_imports",
        tree(jaxstick__cli="from fitting.fit import fit\n", fitting__fit=""),
        "jaxstick/cli.py:1: imports fitting.fit, which lies above it",
    ),
    (
        "upward_imports",
        tree(jaxstick__parts__rig="import jaxstick.oscillator as joined\n", jaxstick__oscillator=""),
        "jaxstick/parts/rig.py:1: imports jaxstick.oscillator, which lies above it",
    ),
    (
        "upward_imports",
        tree(jaxstick__simulate="from jaxstick import sweep\n", jaxstick__sweep=""),
        "jaxstick/simulate.py:1: imports jaxstick.sweep, which lies above it",
    ),
    (
        "relative_imports",
        tree(jaxstick__parts__rig="from .motion import Motion\n", jaxstick__parts__motion=""),
        "jaxstick/parts/rig.py:1: relative import of .motion",
    ),
    (
        "imports_through_packages",
        tree(fitting__fit="from jaxstick import simulate\n"),
        "fitting/fit.py:1: takes simulate from the package jaxstick",
    ),
    (
        "imports_through_packages",
        tree(jaxstick__oscillator="from jaxstick.parts import rig, Rig\n", jaxstick__parts__rig=""),
        "jaxstick/oscillator.py:1: takes Rig from the package jaxstick.parts",
    ),
    (
        "imports_through_packages",
        tree(fitting__fit="import jaxstick\n"),
        "fitting/fit.py:1: imports the whole package jaxstick",
    ),
    (
        "hidden_imports",
        tree(jaxstick__solver="def solve():\n    from jaxstick.simulate import simulate\n"),
        "jaxstick/solver.py:2: import inside solve",
    ),
    (
        "hidden_imports",
        tree(jaxstick__solver="import importlib\nx = importlib.import_module('jaxstick.simulate')\n"),
        "jaxstick/solver.py:2: import_module imports what is not written out here",
    ),
    (
        "hidden_imports",
        tree(jaxstick__verbs__check="def check():\n    return deferred('jaxstick.check', 'check')()\n"),
        "jaxstick/verbs/check.py:2: import inside check",
    ),
    (
        "hidden_imports",
        tree(jaxstick__verbs__check="module = 'jaxstick.check'\ncheck = deferred(module, 'check')\n"),
        "jaxstick/verbs/check.py:2: deferred imports what is not written out here",
    ),
    (
        "upward_imports",
        tree(jaxstick__simulate="fit = deferred('fitting.fit', 'fit')\n", fitting__fit="def fit(): ...\n"),
        "jaxstick/simulate.py:1: imports fitting.fit, which lies above it",
    ),
    (
        "dangling_deferrals",
        tree(fitting__verbs__fit="fit = deferred('fitting.fit', 'fit')\n", fitting__fit="def fti(): ...\n"),
        "fitting/verbs/fit.py:1: fitting.fit defines no fit",
    ),
    (
        "circles",
        tree(
            jaxstick__parts__a="from jaxstick.parts.b import B\n",
            jaxstick__parts__b="from jaxstick.parts.c import C\n",
            jaxstick__parts__c="import math\nfrom jaxstick.parts.a import A\n",
        ),
        "jaxstick/parts/c.py:2: imports jaxstick.parts.a, which closes the circle"
        " jaxstick.parts.a -> jaxstick.parts.b -> jaxstick.parts.c -> jaxstick.parts.a",
    ),
    (
        "sibling_effects",
        tree(jaxstick__effects__hum="from jaxstick.effects.lag import Lag\n", jaxstick__effects__lag=""),
        "jaxstick/effects/hum.py:1: imports jaxstick.effects.lag, a sibling effect",
    ),
    (
        "named_effects",
        tree(fitting__fit="import jaxstick.effects.lag\n", jaxstick__effects__lag=""),
        "fitting/fit.py:1: imports jaxstick.effects.lag; only the catalogue",
    ),
    (
        "named_effects",
        tree(fitting__fit='"""About a lag."""\nnames = ["lag"]\n', jaxstick__effects__lag='key = "lag"'),
        "fitting/fit.py:2: names the effect lag; only its own file may",
    ),
    (
        "named_effects",
        tree(jaxstick__catalogue='module = "jaxstick.effects.lag"\n', jaxstick__effects__lag=""),
        "jaxstick/catalogue.py:1: names the effect lag; only its own file may",
    ),
    (
        "blind_sees",
        tree(fitting__blind__make="from jaxstick.simulate import simulate\n", jaxstick__simulate=""),
        "fitting/blind/make.py:1: imports jaxstick.simulate, which sealed cases must not rest on",
    ),
    (
        "reference_sees",
        {"tests/reference/rigid.py": "import numpy as np\nimport jax.numpy as jnp\n"},
        "tests/reference/rigid.py:2: imports jax.numpy; reference models use numpy and scipy alone",
    ),
    (
        "missing_docstrings",
        tree(jaxstick__solver="def solve():\n    return 1\n\n\ndef _inner():\n    return 2\n"),
        "jaxstick/solver.py:1: solve has no docstring",
    ),
]


@pytest.mark.parametrize(("rule", "sources", "finding"), OFFENCES)
def test_an_offence_is_found_at_its_line(rule, sources, finding):
    findings = list(getattr(layers, rule)(sources))
    assert len(findings) == 1
    assert findings[0].startswith(finding)


LAWFUL = tree(
    jaxstick__parts__brake="from jaxstick.parts.motion import Motion\n",
    jaxstick__parts__motion="from jaxstick.parameter import parameter\n",
    jaxstick__parameter="",
    jaxstick__effects__lag="from jaxstick.effect import AbstractEffect\nkey = 'lag'\n",
    jaxstick__effect="",
    jaxstick__catalogue="import importlib\nfrom jaxstick import effects\nx = importlib.import_module(name)\n",
    fitting__plots__waterfall="from jaxstick.parts.motion import Motion\n",
    fitting__blind__seal="from jaxstick.parts.motion import Motion\n",
)


@pytest.mark.parametrize("rule", layers.RULES, ids=lambda rule: rule.__name__)
def test_lawful_source_is_left_alone(rule):
    assert list(rule(LAWFUL)) == []


def test_a_new_file_in_a_known_folder_needs_no_entry():
    for module in ("jaxstick.effects.squeal", "jaxstick.formats.tdms", "fitting.plots.waterfall"):
        assert layers.layer(module) is not None
