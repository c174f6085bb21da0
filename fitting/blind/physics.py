"""What the truth of one run consists of: every constant of rig, drive, friction and effects."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MOST_ELEMENTS = 8
"""The contact consists of at most so many elastic-plastic elements."""


@dataclass(frozen=True, kw_only=True)
class Physics:
    """The constants of one run in SI units; what is left at its default is absent.

    m x'' + c x' + K x = k_d y + c_d y' + F + (mechanical effects), F from the law
    g(|w|) = A exp(-B |w|) + C and a viscous part D |w| in slip, w the sliding velocity. All are floats, so
    that they travel to compiled code as one record; `against_base`, `bristle` and the like are 0 or 1.
    """

    mass: float
    stiffness: float
    drive_stiffness: float
    damping: float
    drive_damping: float = 0.0
    against_base: float = 0.0

    amplitude: float = 0.0
    omega: float = 1.0
    phase: float = 0.0

    A: float
    B: float
    C: float
    D: float
    k1: float

    # The law of friction.
    asymmetry_dry: float = 0.0
    asymmetry_viscous: float = 0.0
    asymmetry_level: float = 0.0  # N on either side of C
    memory: float = 0.0  # s
    memory_stages: float = 1.0
    memory_of_speed: float = 0.0  # 1: |w| lags, 0: w does
    memory_length: float = 0.0  # m, slid instead of waited; 0: a time
    dwell: float = 0.0
    dwell_time: float = 1.0  # s
    dwell_slip: float = 1.0  # m, sliding that renews the contact
    dwell_power: float = 0.0  # 0: logarithm of the age, on the whole limit; else on C, ageing in slip too
    dwell_end: float = 0.0  # s, in which it grows to its end; 0: without end
    peak: float = 0.0
    peak_length: float = 1.0  # m
    peak_linear: float = 0.0  # 0: exponential, on the whole limit; 1: a straight line, on C
    track: float = 0.0  # 1/m
    track_length: float = 0.0  # m, 0: a straight line
    track_middle: float = 0.0  # m, where a track that levels off changes most
    waviness: float = 0.0
    waviness_number: float = 0.0  # rad/m
    waviness_phase: float = 0.0
    waviness_triangular: float = 0.0
    waviness_second: float = 0.0  # its second harmonic, relative
    load: float = 0.0
    load_phase: float = 0.0
    load_triangular: float = 0.0
    load_second: float = 0.0  # its second harmonic, relative
    drift: float = 0.0  # 1/s
    drift_time: float = 0.0  # s, 0: without end
    drift_root: float = 0.0  # s, in which a drift with the root of time comes as far as a straight one
    exponent: float = 1.0
    gaussian: float = 0.0  # share of the weakening that goes as exp(-(B w)^2)
    lorentzian: float = 0.0  # and as 1/(1 + (B w)^2)
    log_rate: float = 0.0  # N
    log_rate_speed: float = 1.0  # m/s
    squeeze: float = 0.0  # N s^2/m^2
    rate_root: float = 0.0  # N/sqrt(m/s)

    # The contact.
    contact_damping: float = 0.0  # N s/m
    contact_damping_loaded: float = 0.0  # 1: in proportion to the load of the spring
    bristle: float = 0.0
    breakaway: float = 0.9  # share of the limit at which the bristle yields; 0: LuGre
    level: float = 1.0  # factor on the whole law in this run

    # The mechanics.
    cubic: float = 0.0  # N/m^3
    cubic_length: float = 0.0  # m, adds cubic x^5 / length^2
    cubic_arc: float = 0.0  # m, a hyperbolic sine of x over it instead
    square: float = 0.0  # N/m^2
    square_length: float = 0.0  # m, 0: a parabola
    stop: float = 0.0  # N/m
    stop_place: float = 1.0  # m
    stop_power: float = 1.0
    stop_one_sided: float = 0.0
    drag: float = 0.0  # N s^2/m^2
    drag_power: float = 1.0
    drag_speed: float = 1.0  # m/s at which all powers agree
    guide: float = 0.0  # N
    guide_stiffness: float = 1.0  # N/m
    guide_speed: float = 0.0  # m/s, tanh(v / speed) where it is not 0
    branch_1: float = 0.0  # N/m
    branch_2: float = 0.0
    branch_3: float = 0.0
    branch_time_1: float = 1.0  # s
    branch_time_2: float = 1.0
    branch_time_3: float = 1.0
    push: float = 0.0  # N
    base_damping: float = 0.0  # N s/m
    base_damping_relative: float = 0.0  # 1: acts on y' - x', 0: on y'
    backlash: float = 0.0  # m, total
    backlash_rounded: float = 0.0
    backlash_slack: float = 0.0  # 1: nothing holds the joint in its gap

    # What no catalogue lists.
    second_harmonic: float = 0.0  # of the base, relative
    second_phase: float = 0.0
    third_harmonic: float = 0.0
    third_phase: float = 0.0
    well: float = 0.0  # N
    well_place: float = 0.0  # m
    well_width: float = 1.0  # m
    pulsation: float = 0.0  # of the stiffness, relative
    pulsation_omega: float = 1.0
    pulsation_phase: float = 0.0
    rider_mass: float = 0.0  # kg
    rider_stiffness: float = 0.0  # N/m
    rider_damping: float = 0.0  # N s/m
    softening: float = 0.0
    softening_time: float = 1.0  # s
    wedging: float = 0.0
    mesh: float = 0.0  # N
    mesh_omega: float = 1.0
    mesh_phase: float = 0.0
    irreversible: float = 0.0
    irreversible_acceleration: float = 1.0  # m/s^2

    def record(self) -> NDArray[np.void]:
        """The constants as one record of compiled code, an array of length 1."""
        return np.array([tuple(vars(self).values())], dtype=RECORD)


RECORD = np.dtype([(field.name, np.float64) for field in dataclasses.fields(Physics)])


@dataclass(frozen=True)
class Elements:
    """The elastic-plastic elements of the contact: each one's share of k1 and of the limit, both sum to 1."""

    stiffness: tuple[float, ...] = (1.0,)
    limit: tuple[float, ...] = (1.0,)

    def array(self) -> NDArray[np.float64]:
        """(element, 2): share of the stiffness, share of the limit."""
        return np.array([self.stiffness, self.limit]).T.copy()
