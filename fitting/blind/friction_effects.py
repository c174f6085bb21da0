"""Effects on the friction law and the contact, each by the catalogue's formula (A) and by another (B)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fitting.blind.formulation import Formulation, RunFacts, Shape, angle, between
from fitting.blind.physics import Elements, Physics
from fitting.blind.scales import Scales


def _asymmetry(p: Physics, e: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + e sign(w)), the viscous part too."""
    return replace(p, asymmetry_dry=e, asymmetry_viscous=e)


def _two_levels(p: Physics, e: float, shape: Shape, run: RunFacts) -> Physics:
    """C differs between the directions, A and D do not."""
    return replace(p, asymmetry_level=e * p.C)


def _lag(p: Physics, time: float, shape: Shape, run: RunFacts) -> Physics:
    """The dry law sees a sliding velocity that follows by a first-order lag."""
    return replace(p, memory=time, memory_stages=1.0)


def _delay(p: Physics, time: float, shape: Shape, run: RunFacts) -> Physics:
    """It sees a speed that follows by four lags in a row, nearly a pure delay."""
    return replace(p, memory=time, memory_stages=4.0, memory_of_speed=1.0)


def _renewal(scales: Scales, random: np.random.Generator) -> Shape:
    return {
        "cutoff": scales.period * between(random, 0.02, 0.3),
        "distance": scales.stroke * between(random, 0.01, 0.05),
    }


def _logarithmic_age(p: Physics, rate: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + rate ln(1 + age/cutoff)); age grows in stick and falls by 1/e over `distance` of slip."""
    return replace(p, dwell=rate, dwell_time=shape["cutoff"], dwell_slip=shape["distance"])


def _power_of_age(p: Physics, rate: float, shape: Shape, run: RunFacts) -> Physics:
    """+ rate C ((1 + age/cutoff)^0.3 - 1)/0.3, age' = 1 - |w| age/distance."""
    return replace(_logarithmic_age(p, rate, shape, run), dwell_power=0.3)


def _torn(scales: Scales, random: np.random.Generator) -> Shape:
    return {"length": scales.stroke * between(random, 0.005, 0.05)}


def _peak(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + share exp(-s/length)), s the distance slid in this slip."""
    return replace(p, peak=share, peak_length=shape["length"])


def _straight_peak(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """+ share C (1 - s/(2 length)), down to nothing."""
    return replace(p, peak=share, peak_length=2.0 * shape["length"], peak_linear=1.0)


def _gradient(p: Physics, slope: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + slope s), s the place on the track."""
    return replace(p, track=slope)


def _worn_track(p: Physics, slope: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + slope L tanh(s/L))."""
    return replace(p, track=slope, track_length=shape["length"])


def _waves(scales: Scales, random: np.random.Generator) -> Shape:
    return {"wavelength": scales.stroke * between(random, 0.1, 0.6), "phase": angle(random)}


def sine_track(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + share sin(2 pi s/wavelength + phase))."""
    number = 2.0 * np.pi / shape["wavelength"]
    return replace(p, waviness=share, waviness_number=number, waviness_phase=shape["phase"])


def _ridged_track(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """The same with a triangular wave."""
    return replace(sine_track(p, share, shape, run), waviness_triangular=1.0)


def _damped_contact(p: Physics, damping: float, shape: Shape, run: RunFacts) -> Physics:
    """- damping w in stick."""
    return replace(p, contact_damping=damping)


def _loaded_damping(p: Physics, damping: float, shape: Shape, run: RunFacts) -> Physics:
    """- damping w (1/2 + load/limit) in stick."""
    return replace(p, contact_damping=damping, contact_damping_loaded=1.0)


def _early_share(elements: Elements, share: float, shape: Shape) -> Elements:
    """A share of k1 yields at a fraction of the limit."""
    return with_early(elements, (share,), (shape["earlier"],))


def _early_spectrum(elements: Elements, share: float, shape: Shape) -> Elements:
    """Iwan: the share that yields early is spread evenly over the fractions of the limit."""
    fractions = np.array([0.3, 0.8, 1.2, 1.7]) * shape["earlier"]
    return with_early(elements, (share / 4,) * 4, tuple(fractions.tolist()))


def with_early(elements: Elements, shares: tuple[float, ...], fractions: tuple[float, ...]) -> Elements:
    """Elements that yield early beside the others, which carry what is left of stiffness and limit."""
    stiffness, limit = sum(shares), sum(s * f for s, f in zip(shares, fractions, strict=True))
    return Elements(
        tuple(k * (1.0 - stiffness) for k in elements.stiffness) + shares,
        tuple(g * (1.0 - limit) for g in elements.limit)
        + tuple(s * f for s, f in zip(shares, fractions, strict=True)),
    )


def breathing(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + share sin(drive's phase + phase))."""
    return replace(p, load=share, load_phase=shape["phase"])


def _rocking_load(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """The same with a triangular wave."""
    return replace(breathing(p, share, shape, run), load_triangular=1.0)


def _steady_drift(p: Physics, rate: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + rate t)."""
    return replace(p, drift=rate)


def _running_in(p: Physics, rate: float, shape: Shape, run: RunFacts) -> Physics:
    """g (1 + rate T (1 - exp(-t/T))), T half of the run."""
    return replace(p, drift=rate, drift_time=0.5 * run.duration)


def _power_of_speed(p: Physics, excess: float, shape: Shape, run: RunFacts) -> Physics:
    """A exp(-(B |w|)^(1 + excess))."""
    return replace(p, exponent=1.0 + excess)


def _gaussian_part(p: Physics, share: float, shape: Shape, run: RunFacts) -> Physics:
    """A [(1 - share) exp(-B |w|) + share exp(-(B w)^2)]."""
    return replace(p, gaussian=share)


def _creep_rate(p: Physics, growth: float, shape: Shape, run: RunFacts) -> Physics:
    """+ growth (A + C) ln(1 + |w|/reference)."""
    return replace(p, log_rate=growth * (p.A + p.C), log_rate_speed=shape["reference"])


def _squeeze(p: Physics, slope: float, shape: Shape, run: RunFacts) -> Physics:
    """+ slope w^2: a film that is squeezed."""
    return replace(p, squeeze=slope)


FRICTION = (
    Formulation(
        key="asymmetric_friction", version="A", strength="dry", unit="1",
        typical=lambda s: 0.03, most=lambda s: 0.4, physics=_asymmetry,
        parameters=lambda e, shape: {"dry": e, "viscous": e},
    ),
    Formulation(
        key="asymmetric_friction", version="B", strength="dry", unit="1",
        typical=lambda s: 0.03, most=lambda s: 0.4, physics=_two_levels,
    ),
    Formulation(
        key="frictional_memory", version="A", strength="lag", unit="s", signed=False,
        typical=lambda s: 0.01 * s.period, most=lambda s: 0.2 * s.period, physics=_lag,
    ),
    Formulation(
        key="frictional_memory", version="B", strength="time", unit="s", signed=False,
        typical=lambda s: 0.01 * s.period, most=lambda s: 0.2 * s.period, physics=_delay,
    ),
    Formulation(
        key="dwell_strengthening", version="A", strength="growth", unit="1", signed=False,
        typical=lambda s: 0.03, most=lambda s: 0.3, shape=_renewal,
        shape_units={"cutoff": "s", "distance": "m"}, physics=_logarithmic_age,
    ),
    Formulation(
        key="dwell_strengthening", version="B", strength="growth", unit="1", signed=False,
        typical=lambda s: 0.02, most=lambda s: 0.2, shape=_renewal,
        shape_units={"cutoff": "s", "distance": "m"}, physics=_power_of_age,
    ),
    Formulation(
        key="slip_weakening", version="A", strength="peak", unit="1", signed=False,
        typical=lambda s: 0.05, most=lambda s: 0.4, shape=_torn,
        shape_units={"length": "m"}, physics=_peak,
    ),
    Formulation(
        key="slip_weakening", version="B", strength="peak", unit="1", signed=False,
        typical=lambda s: 0.05, most=lambda s: 0.4, shape=_torn,
        shape_units={"length": "m"}, physics=_straight_peak,
    ),
    Formulation(
        key="position_dependent_friction", version="A", strength="gradient", unit="1/m",
        typical=lambda s: 0.05 / s.reach, most=lambda s: 0.6 / s.reach, physics=_gradient,
    ),
    Formulation(
        key="position_dependent_friction", version="B", strength="gradient", unit="1/m",
        typical=lambda s: 0.05 / s.reach, most=lambda s: 0.6 / s.reach,
        shape=lambda s, random: {"length": 0.7 * s.reach}, shape_units={"length": "m"},
        physics=_worn_track,
    ),
    Formulation(
        key="periodic_track", version="A", strength="share", unit="1", signed=False,
        typical=lambda s: 0.03, most=lambda s: 0.4, shape=_waves,
        shape_units={"wavelength": "m"}, physics=sine_track,
        parameters=lambda share, shape: {
            "cosine": share * float(np.sin(shape["phase"])),
            "sine": share * float(np.cos(shape["phase"])),
            "wavelength": shape["wavelength"],
        },
    ),
    Formulation(
        key="periodic_track", version="B", strength="share", unit="1", signed=False,
        typical=lambda s: 0.03, most=lambda s: 0.4, shape=_waves,
        shape_units={"wavelength": "m", "phase": "rad"}, physics=_ridged_track,
    ),
    Formulation(
        key="contact_damping", version="A", strength="damping", unit="N s/m", signed=False,
        typical=lambda s: 0.1 * s.ring_damping, most=lambda s: 1.4 * s.ring_damping,
        physics=_damped_contact,
    ),
    Formulation(
        key="contact_damping", version="B", strength="damping", unit="N s/m", signed=False,
        typical=lambda s: 0.1 * s.ring_damping, most=lambda s: 1.4 * s.ring_damping,
        physics=_loaded_damping,
    ),
    Formulation(
        key="microslip", version="A", strength="share", unit="1", signed=False,
        typical=lambda s: 0.1, most=lambda s: 0.7,
        shape=lambda s, random: {"earlier": float(random.uniform(0.1, 0.5))}, elements=_early_share,
    ),
    Formulation(
        key="microslip", version="B", strength="share", unit="1", signed=False,
        typical=lambda s: 0.1, most=lambda s: 0.7,
        shape=lambda s, random: {"earlier": float(random.uniform(0.1, 0.5))}, elements=_early_spectrum,
    ),
    Formulation(
        key="load_variation", version="A", strength="share", unit="1", signed=False,
        typical=lambda s: 0.03, most=lambda s: 0.4,
        shape=lambda s, random: {"phase": angle(random)}, shape_units={"phase": "rad"},
        physics=breathing,
        parameters=lambda share, shape: {
            "in_phase": share * float(np.cos(shape["phase"])),
            "quadrature": share * float(np.sin(shape["phase"])),
        },
    ),
    Formulation(
        key="load_variation", version="B", strength="share", unit="1", signed=False,
        typical=lambda s: 0.03, most=lambda s: 0.4,
        shape=lambda s, random: {"phase": angle(random)}, shape_units={"phase": "rad"},
        physics=_rocking_load,
    ),
    Formulation(
        key="friction_drift", version="A", strength="rate", unit="1/s",
        typical=lambda s: 0.05 / s.duration, most=lambda s: 0.6 / s.duration, physics=_steady_drift,
    ),
    Formulation(
        key="friction_drift", version="B", strength="rate", unit="1/s",
        typical=lambda s: 0.05 / s.duration, most=lambda s: 0.8 / s.duration, physics=_running_in,
    ),
    Formulation(
        key="stribeck_shape", version="A", strength="excess", unit="1",
        typical=lambda s: 0.2, most=lambda s: 0.6, physics=_power_of_speed,
        shape=lambda s, random: {"reference": s.weakening}, shape_units={"reference": "m/s"},
    ),
    Formulation(
        key="stribeck_shape", version="B", strength="share", unit="1", signed=False,
        typical=lambda s: 0.3, most=lambda s: 1.0, physics=_gaussian_part,
    ),
    Formulation(
        key="velocity_strengthening", version="A", strength="growth", unit="1",
        typical=lambda s: 0.02, most=lambda s: 0.15,
        shape=lambda s, random: {"reference": s.speed * between(random, 0.003, 0.03)},
        shape_units={"reference": "m/s"}, physics=_creep_rate,
    ),
    Formulation(
        key="velocity_strengthening", version="B", strength="slope", unit="N s^2/m^2", signed=False,
        typical=lambda s: 0.1 * s.force / s.haste**2, most=lambda s: 1.5 * s.force / s.haste**2,
        physics=_squeeze,
    ),
)  # fmt: skip
"""Both forms of every effect on the friction law and the contact."""
