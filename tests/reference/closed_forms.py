"""Closed-form answers the models must reproduce. SI units.

Den Hartog, Trans. ASME 53 (1931) APM-107; Hundal, J. Sound Vib. 64 (1979) 371; Tou and Schultheiss, J. Appl.
Phys. 24 (1953) 1210.
"""

from math import cos, cosh, exp, hypot, pi, sin, sinh, sqrt

import numpy as np


def linear_amplitude(mass: float, stiffness: float, damping: float, frequency: float, force: float) -> float:
    """Steady amplitude [m] of m x'' + c x' + K x = P sin(2 pi f t), P = `force` [N]."""
    omega = 2.0 * pi * frequency
    return force / hypot(stiffness - mass * omega**2, damping * omega)


def base_load(stiffness: float, damping: float, frequency: float, base_amplitude: float) -> float:
    """Amplitude [N] of k_d y + c_d y' for a sine y of the given amplitude [m]: the base as a force."""
    return base_amplitude * hypot(stiffness, 2.0 * pi * frequency * damping)


def coulomb_decay(stiffness: float, friction: float, start: float) -> list[float]:
    """Turning points [m] of an undamped oscillator with Coulomb friction, let go at `start`.

    Each half cycle takes 2 F/K off the amplitude; it rests for good at the first turning point with K |x| <=
    F.
    """
    points = [start]
    while stiffness * abs(points[-1]) > friction:
        size = abs(points[-1]) - 2.0 * friction / stiffness
        points.append(-size if points[-1] > 0.0 else size)
    return points


def den_hartog_amplitude(
    mass: float, stiffness: float, damping: float, frequency: float, force: float, friction: float
) -> float:
    """Amplitude [m] without stops under P sin(2 pi f t) and Coulomb friction F (Den Hartog 1931).

        x_0 K/P = -G F/P + sqrt(1/q^2 - H^2 (F/P)^2)
        beta = omega/omega_n,   r^2 = 1 - zeta^2,   q^2 = (1 - beta^2)^2 + (2 zeta beta)^2
        G = [sinh(zeta pi/beta) - zeta/r sin(r pi/beta)] / [cosh(zeta pi/beta) + cos(r pi/beta)]
        H = sin(r pi/beta) / (r beta) / [cosh(zeta pi/beta) + cos(r pi/beta)]

    Valid where `den_hartog_moves` says so.
    """
    g, h, q = _den_hartog_functions(mass, stiffness, damping, frequency)
    ratio = friction / force
    return force / stiffness * (-g * ratio + sqrt(1.0 / q**2 - (h * ratio) ** 2))


def den_hartog_moves(
    mass: float, stiffness: float, damping: float, frequency: float, force: float, friction: float
) -> bool:
    """Whether the motion of `den_hartog_amplitude` has no stop: v keeps its sign over half a cycle.

    The half cycle from the upper turning point is F/K + a forced + a decaying free motion that arrives at
    -x_0 with zero velocity; the velocity is looked at on 4000 instants.
    """
    _, h, q = _den_hartog_functions(mass, stiffness, damping, frequency)
    if friction / force * abs(h) * q >= 1.0:
        return False
    x0 = den_hartog_amplitude(mass, stiffness, damping, frequency, force, friction)
    omega, omega_n = 2.0 * pi * frequency, sqrt(stiffness / mass)
    zeta = damping / (2.0 * mass * omega_n)
    omega_d = omega_n * sqrt(1.0 - zeta**2)
    half, level = pi / omega, friction / stiffness
    rows = [_free_motion(t, zeta * omega_n, omega_d) for t in (0.0, half)]
    # Unknown: forced motion a cos + b sin, free motion c, d. Position and velocity at both turning points.
    matrix = np.array(
        [
            [1.0, 0.0, *rows[0][0]],
            [0.0, omega, *rows[0][1]],
            [-1.0, 0.0, *rows[1][0]],
            [0.0, -omega, *rows[1][1]],
        ]
    )
    a, b, c, d = np.linalg.solve(matrix, [x0 - level, 0.0, -x0 - level, 0.0])
    t = np.linspace(0.0, half, 4002)[1:-1]
    decay = np.exp(-zeta * omega_n * t)
    cosine, sine = decay * np.cos(omega_d * t), decay * np.sin(omega_d * t)
    v = -a * omega * np.sin(omega * t) + b * omega * np.cos(omega * t)
    v += c * (-zeta * omega_n * cosine - omega_d * sine) + d * (-zeta * omega_n * sine + omega_d * cosine)
    return bool(np.all(v < 0.0))


def hundal_amplitude(
    mass: float, stiffness: float, damping: float, frequency: float, base_amplitude: float, friction: float
) -> float:
    """Amplitude [m] without stops where spring K and damper c are both held by the base (Hundal 1979).

    Coulomb friction against the ground: Den Hartog's motion under the force Y sqrt(K^2 + c^2 omega^2).
    """
    force = base_load(stiffness, damping, frequency, base_amplitude)
    return den_hartog_amplitude(mass, stiffness, damping, frequency, force, friction)


TOU_SCHULTHEISS_LIMIT = 1.0 / sqrt(1.0 + pi**2 / 4.0)
"""F/P = 0.537: below it a mass without spring under P sin(omega t) and Coulomb friction F never stops."""


def tou_schultheiss_amplitude(mass: float, frequency: float, force: float, friction: float) -> float:
    """Half the travel [m] of a mass without spring under P sin(omega t) and Coulomb friction F, no stops.

    Over the half cycle omega t = phi..phi + pi with v > 0: m v' = P sin - F, v = 0 at both ends, so
    cos(phi) = (pi/2) F/P, and half the travel is P sin(phi)/(m omega^2).
    """
    cosine = 0.5 * pi * friction / force
    return force * sqrt(1.0 - cosine**2) / (mass * (2.0 * pi * frequency) ** 2)


def _den_hartog_functions(
    mass: float, stiffness: float, damping: float, frequency: float
) -> tuple[float, float, float]:
    omega_n = sqrt(stiffness / mass)
    beta, zeta = 2.0 * pi * frequency / omega_n, damping / (2.0 * mass * omega_n)
    r = sqrt(1.0 - zeta**2)
    below = cosh(zeta * pi / beta) + cos(r * pi / beta)
    g = (sinh(zeta * pi / beta) - zeta / r * sin(r * pi / beta)) / below
    h = sin(r * pi / beta) / (r * beta) / below
    return g, h, hypot(1.0 - beta**2, 2.0 * zeta * beta)


def _free_motion(t: float, decay: float, omega_d: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Position and velocity of the damped free motions that are cosine and sine."""
    e, c, s = exp(-decay * t), cos(omega_d * t), sin(omega_d * t)
    return (e * c, e * s), (e * (-decay * c - omega_d * s), e * (-decay * s + omega_d * c))
