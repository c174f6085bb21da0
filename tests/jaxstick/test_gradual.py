"""Contacts that give way gradually, against closed forms and an integrator of another kind."""

from __future__ import annotations

import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from jaxstick.oscillator import Oscillator, Start
from jaxstick.parameter import replace as with_values
from jaxstick.parts.contact import AbstractContact, Approach, LoadedContact, Passage, Traction
from jaxstick.parts.drive import SineDrive
from jaxstick.parts.friction import ExponentialFriction
from jaxstick.parts.gradual import ElastoPlasticContact, IwanContact, LuGreContact
from jaxstick.parts.rig import Rig
from jaxstick.simulate import Grid, march, simulate

K1, LIMIT = 5e4, 4.0
FULL = LIMIT / K1
DRY = Traction(limit=lambda rate, sense: jnp.asarray(LIMIT), viscous=lambda rate, sense: jnp.asarray(0.0))
UNTOUCHED = Approach(0.0, 0.0, 0.0)
CONTACTS = (LuGreContact(K1), ElastoPlasticContact(K1, 0.6), IwanContact(K1, 0.2))
NAMES = ("lugre", "elasto-plastic", "iwan")


def pulled(contact: AbstractContact, way: np.ndarray, begin: Approach = UNTOUCHED) -> np.ndarray:
    """The friction force at places of the mass, pulled slowly through them from where it begins."""
    slides = np.diff(way)
    return np.asarray(_pulled(*jax.tree.map(jnp.asarray, (contact, slides, begin))))


@jax.jit
def _pulled(contact: AbstractContact, slides: jax.Array, begin: Approach) -> jax.Array:
    force, state = contact.initial(begin, DRY)

    def one(state: Any, slide: jax.Array) -> tuple[Any, jax.Array]:
        grip = contact.grip(state, Passage(1e-3, slide, jnp.asarray(1e-6), 0.0, 2.0), DRY)
        return grip.state, jnp.asarray(grip.friction)

    return jnp.append(force, jax.lax.scan(one, jax.tree.map(jnp.asarray, state), slides)[1])


def test_a_lugre_bristle_bends_as_an_exponential():
    way = np.linspace(0, 6 * FULL, 40)
    assert pulled(LuGreContact(K1), way) == pytest.approx(-LIMIT * -np.expm1(-way / FULL), rel=1e-9)


def test_an_elasto_plastic_bristle_is_elastic_up_to_breakaway_and_when_it_unloads():
    contact = ElastoPlasticContact(K1, 0.6)
    up = np.linspace(0, 0.599 * FULL, 20)
    assert pulled(contact, up) == pytest.approx(-K1 * up, rel=1e-9)
    there_and_back = np.concatenate([np.linspace(0, 12 * FULL, 400), np.linspace(12 * FULL, 11.2 * FULL, 20)])
    force = pulled(contact, there_and_back)
    assert force[399] == pytest.approx(-LIMIT, rel=1e-3)
    assert np.diff(force[400:]) == pytest.approx(K1 * 0.8 * FULL / 19 * np.ones(19), rel=1e-6)


def test_iwan_elements_yield_one_after_another_and_double_on_the_way_back():
    spread, elements = 0.2, (1 + 0.2 * np.linspace(-1, 1, 4)) * FULL
    up = np.linspace(0, 1.5 * FULL, 60)
    backbone = -K1 * np.mean(np.clip(up[:, None], -elements, elements), axis=1)
    assert pulled(IwanContact(K1, spread), up) == pytest.approx(backbone, rel=1e-9)
    assert backbone[-1] == pytest.approx(-LIMIT)
    back = up[-1] - 2 * up
    branch = pulled(IwanContact(K1, spread), np.concatenate([up, back]))[len(up) :]
    assert branch == pytest.approx(-LIMIT - 2 * backbone, rel=1e-6)


@pytest.mark.parametrize("contact", CONTACTS, ids=NAMES)
def test_the_first_force_is_the_one_that_is_given(contact):
    for wanted in (-0.9 * LIMIT, -1.0, 0.0, 2.5):
        force, _ = contact.initial(Approach(wanted, 0.0, 0.0), DRY)
        assert float(force) == pytest.approx(wanted, abs=1e-3 * LIMIT)
    force, _ = contact.initial(Approach(3 * LIMIT, 0.0, 0.0), DRY)
    assert float(force) == pytest.approx(LIMIT, rel=1e-6)


@pytest.mark.parametrize("slid", [-1.0, 1.0])
@pytest.mark.parametrize("back", [0.3, 1.0, 1.7])
def test_elements_that_begin_in_stick_remember_the_sliding_before(slid, back):
    """From slip back by a share of 2 g/k1 and on in either sense: the same whether it is all seen, or picked
    up on the way with the force there and the sense of the slip."""
    contact = IwanContact(K1, 0.2)
    come = slid * np.concatenate([np.linspace(0, 1.5 * FULL, 100), np.linspace(1.5, 1.5 - back, 100) * FULL])
    for onward in (-1.0, 1.0):
        go_on = come[-1] + onward * np.linspace(0, 1.8 * FULL, 100)
        whole = pulled(contact, np.concatenate([come, go_on]))[len(come) :]
        picked_up = pulled(contact, go_on, Approach(whole[0], 0.0, 0.0, slid))
        assert picked_up == pytest.approx(whole, abs=1e-6 * LIMIT)


@pytest.mark.parametrize("way", [-1.0, 1.0])
@pytest.mark.parametrize("contact", [*CONTACTS, LoadedContact(K1)], ids=[*NAMES, "loaded"])
def test_a_record_that_begins_in_slip_begins_with_the_force_of_slip(contact, way):
    """Limit and viscous force, as at every later node: each element that slips has its part of the latter."""
    rate, viscous = 0.3 * way, 2.0
    wet = DRY._replace(viscous=lambda rate, sense: jnp.asarray(viscous))
    whole = -way * LIMIT - viscous * rate
    for given in (whole, 1.2 * whole):
        force, state = contact.initial(Approach(given, jnp.asarray(rate), 0.0), wet)
        assert float(force) == pytest.approx(whole, rel=1e-6)
        passage = Passage(1e-3, jnp.asarray(1e-3 * rate), jnp.asarray(rate), 0.0, 2.0)
        assert float(contact.grip(state, passage, wet).friction) == pytest.approx(whole, rel=1e-3)


def oscillator(contact: AbstractContact) -> Oscillator:
    return Oscillator(
        Rig(mass=2.38, stiffness=1986.0, drive_stiffness=1986.0, damping=4.53),
        SineDrive(1.2, base_amplitude=0.006),
        ExponentialFriction(A=1.0, B=60.0, C=5.0, D=1.5),
        contact,
    )


@pytest.mark.parametrize(
    ("contact", "yields"),
    [
        (LuGreContact(K1), lambda load: 1.0),
        (
            ElastoPlasticContact(K1, 0.5),
            lambda load: 0.5 - 0.5 * math.cos(math.pi * min(max((load - 0.5) / 0.5, 0.0), 1.0)),
        ),
    ],
    ids=NAMES[:2],
)
def test_bristles_follow_their_differential_equation(contact, yields):
    """Against an implicit integrator of the equations as published, with its error going down with the square
    of the step."""

    def rates(t: float, s: np.ndarray) -> list[float]:
        x, v, z = s
        limit = math.exp(-60 * abs(v)) + 5
        sense = 1.0 if v >= 0 else -1.0
        load = sense * K1 * z / limit
        friction = -K1 * z - 1.5 * v
        drive = 1986 * 0.006 * math.sin(2 * math.pi * 1.2 * t)
        return [v, (drive - 1986 * x - 4.53 * v + friction) / 2.38, v * (1 - yields(load) * load)]

    samples, interval = 301, 4e-3
    times = interval * np.arange(samples)
    true = solve_ivp(rates, (0, times[-1]), [0, 0, 0], "Radau", times, rtol=1e-9, atol=1e-12, max_step=2e-3)
    errors = []
    for steps in (8, 16, 32):
        run = simulate(
            oscillator(contact), samples=samples, interval=interval, start=Start(), steps_per_sample=steps
        )
        errors.append(np.abs(np.asarray(run.x) - true.y[0]).max() / np.ptp(true.y[0]))
    assert np.ptp(true.y[0]) > 5e-3
    assert errors[-1] < 2e-5
    assert errors[0] / errors[-1] > 6


@pytest.mark.parametrize("contact", CONTACTS, ids=NAMES)
def test_forward_derivatives_are_central_differences(contact):
    names = [name for name in ("k1", "breakaway", "spread", "C") if name in "k1 C" or hasattr(contact, name)]
    whole = oscillator(contact)

    @jax.jit
    def last(values: jax.Array) -> jax.Array:
        changed = with_values(whole, {name: values[i] for i, name in enumerate(names)})
        run = march(changed, Start(), Grid(0.0, 4e-3, 120, 16))
        return 1e3 * run.x[60::20]

    known = {"k1": K1, "C": 5.0, "breakaway": 0.6, "spread": 0.2}
    point = np.array([known[name] for name in names])
    slope = np.asarray(jax.jit(jax.jacfwd(last))(jnp.asarray(point)))
    for i in range(len(names)):
        step = np.zeros(len(names))
        step[i] = 1e-5 * point[i]
        ahead, behind = (np.asarray(last(jnp.asarray(point + s * step))) for s in (1, -1))
        difference = (ahead - behind) / (2 * step[i])
        assert np.abs(slope[:, i]).max() > 0
        assert slope[:, i] == pytest.approx(difference, abs=2e-3 * np.abs(slope[:, i]).max())
