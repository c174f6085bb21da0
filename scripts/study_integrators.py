"""Which integrator? The 1987 paper's own question, answered by error against cost.

The paper compared a Runge-Kutta method of the fourth order with two predictor-correctors and took the first.
Here the two-stop motion of its rig (frequency ratio 0.326, two cycles from rest) is integrated by

- the return mapping on the loaded contact,
- the classical Runge-Kutta method on the loaded contact, whose vector field jumps at every event,
- the classical Runge-Kutta method and diffrax's adaptive Tsit5 and Dopri8 on the smooth contact.

The error is the largest difference in displacement from the event-driven reference with the loaded contact,
over the stroke; for the smooth contact the difference from its own limit stands beside it, since the contact
itself differs from the loaded one. The cost is time a lane and simulated cycle with 64 lanes side by side on
one thread of control, compilation excluded, as a ratio to the first row.

    python -m scripts.study_integrators
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import ClassVar

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array
from rich.console import Console
from rich.table import Table

from jaxstick.oscillator import Flow, Oscillator, Start
from jaxstick.parameter import replace
from jaxstick.parts.contact import LoadedContact, SmoothContact
from jaxstick.parts.drive import SineDrive
from jaxstick.parts.friction import ExponentialFriction
from jaxstick.parts.rig import Rig
from jaxstick.precision import float64
from jaxstick.simulate import Grid, march
from tests.reference import loaded, rig1987

LANES = 64
SAMPLES = 200
CYCLES = 2
DRIVE = rig1987.drive(0.326)
INTERVAL = CYCLES * DRIVE.period / (SAMPLES - 1)


class _Linear(diffrax.LocalLinearInterpolation):
    """Linear between the ends of a step; the stages of the method are not looked at."""

    def __init__(self, *, t0: Array, t1: Array, y0: Flow, y1: Flow, k: Flow) -> None:
        del k
        super().__init__(t0=t0, t1=t1, y0=y0, y1=y1)


class ClassicalRungeKutta(diffrax.AbstractERK):
    """The Runge-Kutta method of the fourth order that the paper used; no error estimate."""

    tableau: ClassVar[diffrax.ButcherTableau] = diffrax.ButcherTableau(
        a_lower=(np.array([0.5]), np.array([0.0, 0.5]), np.array([0.0, 0.0, 1.0])),
        b_sol=np.array([1 / 6, 1 / 3, 1 / 3, 1 / 6]),
        b_error=np.array([0.0, 0.0, 0.0, 0.0]),
        c=np.array([0.5, 0.5, 1.0]),
    )
    interpolation_cls: ClassVar[Callable[..., _Linear]] = _Linear

    def order(self, terms: object) -> int:
        del terms
        return 4


def oscillator(contact: type[LoadedContact] | type[SmoothContact]) -> Oscillator:
    """The paper's rig with this contact."""
    rig = rig1987.rig()
    return Oscillator(
        Rig(rig.mass, rig.stiffness, rig.stiffness, rig.damping),
        SineDrive(DRIVE.frequency, DRIVE.base_amplitude),
        ExponentialFriction(rig.A, rig.B, rig.C, rig.D),
        contact(rig.k1),
    )


def return_mapping(steps: int) -> Callable[[Array], Array]:
    """The march with so many steps a sample, as a function of the contact's stiffness."""
    base = oscillator(LoadedContact)
    grid = Grid(0.0, INTERVAL, SAMPLES, steps)
    return lambda k1: march(replace(base, {"k1": k1}), Start(), grid, unroll=8).x


def by_diffrax(
    contact: type[LoadedContact] | type[SmoothContact],
    solver: diffrax.AbstractSolver,
    control: diffrax.AbstractStepSizeController,
    step: float,
) -> Callable[[Array], Array]:
    """A diffrax solve of the contact's vector field, as a function of the contact's stiffness."""
    base = oscillator(contact)
    times = INTERVAL * jnp.arange(SAMPLES)

    def solve(k1: Array) -> Array:
        field = replace(base, {"k1": k1}).vector_field
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(field),
            solver,
            0.0,
            INTERVAL * (SAMPLES - 1),
            step,
            Flow(jnp.asarray(0.0), jnp.asarray(0.0), jnp.asarray(0.0)),
            saveat=diffrax.SaveAt(ts=times),
            stepsize_controller=control,
            max_steps=2_000_000,
            adjoint=diffrax.ForwardMode(),
        )
        assert solution.ys is not None
        return solution.ys.x

    return solve


def measure(solve: Callable[[Array], Array]) -> tuple[np.ndarray, float]:
    """The displacement of the paper's rig, and the seconds that a lane and cycle take."""
    stiffness = rig1987.rig().k1 * jnp.linspace(1.0, 1.2, LANES)
    lanes = eqx.filter_jit(jax.vmap(solve)).lower(stiffness).compile()
    result = jax.block_until_ready(lanes(stiffness))
    spent = []
    for _ in range(3):
        begun = time.perf_counter()
        jax.block_until_ready(lanes(stiffness))
        spent.append(time.perf_counter() - begun)
    return np.asarray(result[0]), min(spent) / LANES / CYCLES


@float64
def main() -> None:
    """Prints the table."""
    rig = rig1987.rig()
    exact = loaded.simulate(rig, DRIVE, INTERVAL * np.arange(SAMPLES)).x
    stroke = float(np.ptp(exact))
    tight = diffrax.PIDController(rtol=1e-10, atol=1e-13)
    own = measure(by_diffrax(SmoothContact, diffrax.Dopri8(), tight, 1e-5))[0]
    fixed = diffrax.ConstantStepSize()
    rows: list[tuple[str, str, Callable[[Array], Array], bool]] = []
    for steps in (4, 8, 16, 32, 64, 128):
        rows.append(("return mapping", f"{1e3 * INTERVAL / steps:.3f} ms", return_mapping(steps), False))
    for steps in (16, 64):
        h = INTERVAL / steps
        classical = ClassicalRungeKutta()
        rows.append(
            ("Runge-Kutta 4", f"{1e3 * h:.3f} ms", by_diffrax(LoadedContact, classical, fixed, h), False)
        )
        rows.append(
            (
                "Runge-Kutta 4, smooth",
                f"{1e3 * h:.3f} ms",
                by_diffrax(SmoothContact, classical, fixed, h),
                True,
            )
        )
    for name, solver in (("Tsit5", diffrax.Tsit5()), ("Dopri8", diffrax.Dopri8())):
        for tolerance in (1e-4, 1e-6, 1e-8):
            control = diffrax.PIDController(rtol=tolerance, atol=1e-3 * tolerance)
            solve = by_diffrax(SmoothContact, solver, control, 1e-5)
            rows.append((f"{name}, smooth", f"rtol {tolerance:.0e}", solve, True))
    table = Table(title="two cycles of the paper's rig, two stops a cycle")
    for head in ("method", "step", "error / stroke", "from its own limit", "cost"):
        table.add_column(head, justify="right")
    first = None
    for name, step, solve, smooth in rows:
        x, seconds = measure(solve)
        first = first or seconds
        error = np.abs(x - exact).max() / stroke
        own_error = f"{np.abs(x - own).max() / stroke:.1e}" if smooth else ""
        table.add_row(name, step, f"{error:.1e}", own_error, f"{seconds / first:.3g}")
    Console().print(table)


if __name__ == "__main__":
    main()
