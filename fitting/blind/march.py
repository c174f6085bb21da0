"""The equations of motion, step by step: compiled, with a step far below the ring of the contact.

One step from t to t + h: half a drift to the middle, there a force with the velocity of the middle (by
iteration), a whole kick, and the other half of the drift. The contact's elements are elastic-plastic: each
follows the sliding, and is clipped at its share of the limit while it is loaded, never while it unloads.
A step in which an element begins or ends to slip is repeated in SUBDIVISIONS smaller ones.
"""

from __future__ import annotations

from math import asin, cos, exp, expm1, log, pi, sin, sinh, sqrt, tanh

import numpy as np
from numba import njit
from numpy.typing import NDArray

SUBDIVISIONS = 16

X, V, ACCELERATION, FRICTION, BASE, SHARE, DIRECTION = 0, 1, 2, 3, 4, 5, 6
AGE, SLIPPED, LAG = 7, 8, 9  # LAG to LAG + 3: the stages of the memory
BRANCH, PLAY, GUIDE, RIDER, RIDER_RATE = 13, 16, 17, 18, 19
ELEMENT = 20
STATE = ELEMENT + 8
"""Places in the state; SHARE is the share of the limit that slips, BASE the base's displacement."""


@njit(cache=True)
def _base(p, t):
    """y [m] and y' [m/s]."""
    angle = p.omega * t + p.phase
    y = sin(angle)
    rate = cos(angle)
    if p.second_harmonic != 0.0:
        y += p.second_harmonic * sin(2.0 * angle + p.second_phase)
        rate += 2.0 * p.second_harmonic * cos(2.0 * angle + p.second_phase)
    if p.third_harmonic != 0.0:
        y += p.third_harmonic * sin(3.0 * angle + p.third_phase)
        rate += 3.0 * p.third_harmonic * cos(3.0 * angle + p.third_phase)
    return p.amplitude * y, p.amplitude * p.omega * rate


@njit(cache=True)
def _wave(angle, triangular, second):
    """A sine with a second harmonic, or the triangular wave in phase with it."""
    if triangular > 0.0:
        return 2.0 / pi * asin(sin(angle))
    return sin(angle) + second * cos(2.0 * angle)


@njit(cache=True)
def _scatter(series, start, interval, t):
    """The factor on friction at time t, linear between its samples."""
    if len(series) < 2:
        return 1.0
    place = (t - start) / interval
    whole = min(max(int(place), 0), len(series) - 2)
    rest = min(max(place - whole, 0.0), 1.0)
    return series[whole] * (1.0 - rest) + series[whole + 1] * rest


@njit(cache=True)
def _factor(p, t, x, y, direction, acceleration):
    """The factor on the whole law at this place, time and load, but for the asymmetry."""
    factor = p.level
    place = x - p.against_base * y
    if p.track != 0.0:
        if p.track_length > 0.0:
            factor *= 1.0 + p.track * p.track_length * tanh((place - p.track_middle) / p.track_length)
        else:
            factor *= 1.0 + p.track * place
    if p.waviness != 0.0:
        angle = p.waviness_number * place + p.waviness_phase
        factor *= 1.0 + p.waviness * _wave(angle, p.waviness_triangular, p.waviness_second)
    if p.load != 0.0:
        angle = p.omega * t + p.phase + p.load_phase
        factor *= 1.0 + p.load * _wave(angle, p.load_triangular, p.load_second)
    if p.drift != 0.0 and t > 0.0:
        if p.drift_root > 0.0:
            factor *= 1.0 + p.drift * sqrt(p.drift_root * t)
        elif p.drift_time > 0.0:
            factor *= 1.0 - p.drift * p.drift_time * expm1(-t / p.drift_time)
        else:
            factor *= 1.0 + p.drift * t
    if p.wedging != 0.0:
        factor *= 1.0 + p.wedging * abs(p.drive_stiffness * y - p.stiffness * x) / (p.A + p.C)
    if p.irreversible != 0.0:
        factor *= 1.0 - p.irreversible * tanh(acceleration * direction / p.irreversible_acceleration)
    return factor


@njit(cache=True)
def _limit(p, s, speed, seen, age, direction):
    """g [N] at a sliding speed, before the factor; `seen` is the speed that the weakening sees."""
    if p.gaussian != 0.0:
        weak = p.A * ((1.0 - p.gaussian) * exp(-p.B * seen) + p.gaussian * exp(-((p.B * seen) ** 2)))
    elif p.lorentzian != 0.0:
        weak = p.A * ((1.0 - p.lorentzian) * exp(-p.B * seen) + p.lorentzian / (1.0 + (p.B * seen) ** 2))
    elif p.exponent != 1.0:
        weak = p.A * exp(-((p.B * seen) ** p.exponent))
    else:
        weak = p.A * exp(-p.B * seen)
    limit = (weak + p.C) * (1.0 + p.asymmetry_dry * direction) + p.asymmetry_level * direction
    if p.dwell != 0.0:
        if p.dwell_power > 0.0:
            grown = ((1.0 + age / p.dwell_time) ** p.dwell_power - 1.0) / p.dwell_power
            limit += p.dwell * p.C * grown
        elif p.dwell_end > 0.0:
            limit *= 1.0 - p.dwell * expm1(-age / p.dwell_end)
        else:
            limit *= 1.0 + p.dwell * log(1.0 + age / p.dwell_time)
    if p.log_rate != 0.0:
        limit += p.log_rate * log(1.0 + speed / p.log_rate_speed)
    if p.squeeze != 0.0:
        limit += p.squeeze * speed * speed
    if p.rate_root != 0.0:
        limit += p.rate_root * sqrt(speed)
    if p.peak != 0.0:
        if p.peak_linear > 0.0:
            limit += p.peak * p.C * max(1.0 - s[SLIPPED] / p.peak_length, 0.0)
        else:
            limit *= 1.0 + p.peak * exp(-s[SLIPPED] / p.peak_length)
    return max(limit, 1e-3 * p.C)


@njit(cache=True)
def _held(p, elements, s, slide, limit):
    """The force of the contact's springs after sliding by `slide` [N]; the share of the limit that slips."""
    if p.bristle > 0.0:
        deflection, plastic = _bristle(p, s[ELEMENT], slide, limit)
        return p.k1 * deflection, plastic
    force, share = 0.0, 0.0
    for i in range(len(elements)):
        stiffness, most = elements[i, 0] * p.k1, elements[i, 1] * limit
        load = stiffness * (s[ELEMENT + i] + slide)
        if load * slide > 0.0 and abs(load) > most:
            load = most if load > 0.0 else -most
            share += elements[i, 1]
        force += load
    return force, share


@njit(cache=True)
def _settle(p, elements, s, slide, limit):
    """As `_held`, and the elements stay so."""
    force, share = _held(p, elements, s, slide, limit)
    if p.bristle > 0.0:
        s[ELEMENT] = force / p.k1
        return force, share
    for i in range(len(elements)):
        stiffness, most = elements[i, 0] * p.k1, elements[i, 1] * limit
        deflection = s[ELEMENT + i] + slide
        if deflection * slide > 0.0 and stiffness * abs(deflection) > most:
            deflection = (most if deflection > 0.0 else -most) / stiffness
        s[ELEMENT + i] = deflection
    return force, share


@njit(cache=True)
def _bristle(p, z, slide, limit):
    """z' = w (1 - alpha |z|/z_ss) over `slide`, alpha from 0 at `breakaway` to 1 at the limit; LuGre at 0."""
    full = limit / p.k1
    alpha = 1.0
    if p.breakaway > 0.0:
        if z * slide <= 0.0:
            alpha = 0.0
        else:
            middle = min(abs(z + 0.5 * slide), full)
            rise = min(max((middle / full - p.breakaway) / (1.0 - p.breakaway), 0.0), 1.0)
            alpha = 0.5 - 0.5 * cos(pi * rise)
    exponent = alpha * abs(slide) / full
    mean = -expm1(-exponent) / exponent if exponent > 1e-9 else 1.0 - 0.5 * exponent
    sense = 1.0 if slide >= 0.0 else -1.0
    return z + slide * (1.0 - alpha * sense * z / full) * mean, alpha * abs(z) / full


@njit(cache=True)
def _drag_of_contact(p, w, share, spring, limit, factor, direction):
    """The part of the friction force that goes with velocity [N]: viscous in slip, damping in stick."""
    viscous = p.D * factor * (1.0 + p.asymmetry_viscous * direction)
    force = viscous * w * (1.0 if p.bristle > 0.0 else share)
    if p.contact_damping != 0.0:
        damping = p.contact_damping * (1.0 - share)
        if p.contact_damping_loaded > 0.0:
            damping *= 0.5 + abs(spring) / limit
        force += damping * w
    return force


@njit(cache=True)
def _restoring(p, t, x, y, rate):
    """The forces of springs and drive on the mass [N]; `y` as the drive's joint passes it on."""
    stiffness = p.stiffness
    if p.softening != 0.0 and t > 0.0:
        stiffness *= 1.0 + p.softening * expm1(-t / p.softening_time)
    if p.pulsation != 0.0:
        stiffness *= 1.0 + p.pulsation * sin(p.pulsation_omega * t + p.pulsation_phase)
    force = p.drive_stiffness * y + p.drive_damping * rate - stiffness * x + p.push
    if p.cubic != 0.0:
        if p.cubic_arc > 0.0:
            force -= 6.0 * p.cubic * p.cubic_arc**3 * (sinh(x / p.cubic_arc) - x / p.cubic_arc)
        else:
            more = (x / p.cubic_length) ** 2 if p.cubic_length > 0.0 else 0.0
            force -= p.cubic * x * x * x * (1.0 + more)
    if p.square != 0.0:
        if p.square_length > 0.0:
            root = sqrt(x * x + p.square_length * p.square_length)
            force -= 2.0 * p.square * p.square_length * (root - p.square_length)
        else:
            force -= p.square * x * x
    if p.stop != 0.0:
        over = abs(x) - p.stop_place
        if over > 0.0 and (x > 0.0 or p.stop_one_sided == 0.0):
            size = p.stop * over * (over / p.stop_place) ** (p.stop_power - 1.0)
            force -= size if x > 0.0 else -size
    if p.well != 0.0:
        place = (x - p.well_place) / p.well_width
        force -= p.well * place * exp(0.5 - 0.5 * place * place)
    if p.mesh != 0.0:
        force += p.mesh * sin(p.mesh_omega * t + p.mesh_phase)
    return force


@njit(cache=True)
def _resisting(p, v, rate):
    """The forces on the mass that go with its velocity [N]."""
    force = -p.damping * v
    if p.drag != 0.0:
        force -= p.drag * v * p.drag_speed * (abs(v) / p.drag_speed) ** p.drag_power
    if p.base_damping != 0.0:
        force += p.base_damping * (rate - v if p.base_damping_relative > 0.0 else rate)
    if p.guide != 0.0 and p.guide_speed > 0.0:
        force -= p.guide * tanh(v / p.guide_speed)
    return force


@njit(cache=True)
def _toward(value, target, step, time):
    """A first-order lag over one step, second order in the step."""
    return value + step * (target - value) / (time + 0.5 * step)


@njit(cache=True)
def _joint(p, play, change, apart):
    """How far the drive's joint hangs behind the base after it moved by `change` [m], and is ahead of the
    mass by `apart` [m]."""
    half = 0.5 * p.backlash
    if p.backlash_slack > 0.0:
        return min(max(apart, -half), half)
    if p.backlash_rounded > 0.0:
        sense = 1.0 if change >= 0.0 else -1.0
        return sense * half + (play - sense * half) * exp(-abs(change) / half)
    return min(max(play + change, -half), half)


@njit(cache=True)
def _step(p, elements, series, start, interval, s, t, h):
    """One step from t to t + h [s]; returns whether an element began or ended to slip in it."""
    x, v, y, before = s[X], s[V], s[BASE], s[SHARE]
    half = 0.5 * h
    on_base = p.against_base
    y_middle, rate_middle = _base(p, t + half)
    y_end, rate_end = _base(p, t + h)
    x_middle = x + half * v
    slide = x_middle - x - on_base * (y_middle - y)
    factor = _factor(p, t + half, x_middle, y_middle, s[DIRECTION], s[ACCELERATION])
    factor *= _scatter(series, start, interval, t + half)

    hanging, taken = 0.0, rate_middle
    if p.backlash > 0.0:
        hanging = _joint(p, s[PLAY], y_middle - y, y_middle - x_middle)
        taken = (y_middle - hanging - y + s[PLAY]) / half
    steady = _restoring(p, t + half, x_middle, y_middle - hanging, taken)
    if p.guide != 0.0 and p.guide_speed == 0.0:
        most = p.guide / p.guide_stiffness
        steady -= p.guide_stiffness * min(max(s[GUIDE] + x_middle - x, -most), most)
    if p.branch_1 != 0.0:
        way = 0.5 * (x + x_middle)
        steady -= p.branch_1 * (x_middle - _toward(s[BRANCH], way, half, p.branch_time_1))
        if p.branch_2 != 0.0:
            steady -= p.branch_2 * (x_middle - _toward(s[BRANCH + 1], way, half, p.branch_time_2))
            steady -= p.branch_3 * (x_middle - _toward(s[BRANCH + 2], way, half, p.branch_time_3))
    rider_force = 0.0
    if p.rider_mass != 0.0:
        stretch = s[RIDER] + half * s[RIDER_RATE] - x_middle
        rider_force = p.rider_stiffness * stretch + p.rider_damping * (s[RIDER_RATE] - v)
        steady += rider_force

    v_middle = v + half * s[ACCELERATION]
    age = _aged(p, s[AGE], abs(slide), before, half) if p.dwell != 0.0 else 0.0
    share = before
    direction = 1.0 if slide >= 0.0 else -1.0
    for _ in range(3):
        w = v_middle - on_base * rate_middle
        seen = abs(w)
        if p.memory > 0.0:
            seen = _lagged(p, s, w, half, False)
        limit = factor * _limit(p, s, abs(w), seen, age, direction)
        spring, share = _held(p, elements, s, slide, limit)
        friction = -spring - _drag_of_contact(p, w, share, spring, limit, factor, direction)
        acceleration = (steady + _resisting(p, v_middle, rate_middle) + friction) / p.mass
        v_middle = v + half * acceleration
    middle = share

    v_end = 2.0 * v_middle - v
    x_end = x_middle + half * v_end
    w = v_end - on_base * rate_end
    way = x_end - x - on_base * (y_end - y)
    direction = 1.0 if way >= 0.0 else -1.0
    seen = abs(w)
    if p.memory > 0.0:
        seen = _lagged(p, s, v_middle - on_base * rate_middle, h, True)
    if p.dwell != 0.0:
        s[AGE] = _aged(p, s[AGE], abs(way), middle, h)
    if p.backlash > 0.0:
        s[PLAY] = _joint(p, s[PLAY], y_end - y, y_end - x_end)
    if p.guide != 0.0 and p.guide_speed == 0.0:
        most = p.guide / p.guide_stiffness
        s[GUIDE] = min(max(s[GUIDE] + x_end - x, -most), most)
    if p.branch_1 != 0.0:
        s[BRANCH] = _toward(s[BRANCH], x_middle, h, p.branch_time_1)
        s[BRANCH + 1] = _toward(s[BRANCH + 1], x_middle, h, p.branch_time_2)
        s[BRANCH + 2] = _toward(s[BRANCH + 2], x_middle, h, p.branch_time_3)
    if p.rider_mass != 0.0:
        faster = s[RIDER_RATE] - h * rider_force / p.rider_mass
        s[RIDER] += half * (s[RIDER_RATE] + faster)
        s[RIDER_RATE] = faster
    factor = _factor(p, t + h, x_end, y_end, direction, acceleration)
    factor *= _scatter(series, start, interval, t + h)
    limit = factor * _limit(p, s, abs(w), seen, s[AGE], direction)
    spring, share = _settle(p, elements, s, way, limit)
    if p.peak != 0.0:
        s[SLIPPED] = s[SLIPPED] + abs(way) * share if share > 0.0 and direction == s[DIRECTION] else 0.0
    s[X], s[V], s[ACCELERATION], s[BASE] = x_end, v_end, acceleration, y_end
    s[FRICTION] = -spring - _drag_of_contact(p, w, share, spring, limit, factor, direction)
    s[SHARE], s[DIRECTION] = share, direction
    return p.bristle == 0.0 and (before != middle or middle != share)


@njit(cache=True)
def _lagged(p, s, w, step, keep):
    """The speed seen through the memory's stages after `step`; they stay so if `keep`."""
    stages = int(p.memory_stages)
    time = p.memory / stages
    if p.memory_length > 0.0:
        time = p.memory_length / max(abs(w), 1e-9)
    target = abs(w) if p.memory_of_speed > 0.0 else w
    for i in range(stages):
        reached = _toward(s[LAG + i], target, step, time)
        target = 0.5 * (s[LAG + i] + reached) if keep and i + 1 < stages else reached
        if keep:
            s[LAG + i] = reached
    return abs(target)


@njit(cache=True)
def _aged(p, age, slide, share, step):
    """The age of the contact after sliding by `slide` in `step`.

    Logarithm: it grows in stick, and slip takes it down exponentially. Power: age' = 1 - |w| age/distance in
    stick and slip alike.
    """
    if p.dwell_power == 0.0:
        return (age + step * (1.0 - share)) * exp(-slide * share / p.dwell_slip)
    decay = slide / p.dwell_slip
    if decay < 1e-9:
        return age + step
    return age * exp(-decay) - step / decay * expm1(-decay)


@njit(cache=True)
def _advance(p, elements, series, start, interval, s, kept, t, h, refine):
    """One step, in smaller ones where an event falls into it and `refine` is set."""
    if not refine:
        _step(p, elements, series, start, interval, s, t, h)
        return
    kept[:] = s
    if _step(p, elements, series, start, interval, s, t, h):
        s[:] = kept
        small = h / SUBDIVISIONS
        for i in range(SUBDIVISIONS):
            _step(p, elements, series, start, interval, s, t + i * small, small)


@njit(cache=True)
def march(physics, elements, series, start, interval, s, t, h, steps, rows, out, refine):
    """`rows` readings, `steps` steps of h [s] apart, from the state `s` at t [s] on; `s` ends at the last.

    out: (rows, 5), x, v, F, y and the share that slips; the first row is one reading after t. refine: repeat
    steps with an event in smaller ones; without it the motion is a continuous function of the constants.
    """
    p = physics[0]
    kept = np.empty_like(s)
    for row in range(rows):
        for i in range(steps):
            _advance(p, elements, series, start, interval, s, kept, t + (row * steps + i) * h, h, refine)
        out[row, 0], out[row, 1], out[row, 2], out[row, 3] = s[X], s[V], s[FRICTION], s[BASE]
        out[row, 4] = s[SHARE]


@njit(cache=True)
def march_windows(physics, elements, series, start, interval, states, times, h, steps, rows, out):
    """Each window from a state of its own.

    states: (windows, STATE), overwritten; times [s]; out: (windows, rows, 2), x and F. Steps are not refined.
    """
    p = physics[0]
    kept = np.empty(states.shape[1])
    for window in range(len(states)):
        s = states[window]
        for row in range(rows):
            for i in range(steps):
                t = times[window] + (row * steps + i) * h
                _advance(p, elements, series, start, interval, s, kept, t, h, False)
            out[window, row, 0], out[window, row, 1] = s[X], s[FRICTION]


def start_state(physics: NDArray[np.void], x: float, v: float, t: float) -> NDArray[np.float64]:
    """A state at t [s] with unloaded contact."""
    p = physics[0]
    state = np.zeros(STATE)
    angle = p["omega"] * t + p["phase"]
    state[X], state[V], state[DIRECTION] = x, v, 1.0
    state[BASE] = p["amplitude"] * (
        np.sin(angle)
        + p["second_harmonic"] * np.sin(2 * angle + p["second_phase"])
        + p["third_harmonic"] * np.sin(3 * angle + p["third_phase"])
    )
    state[BRANCH : BRANCH + 3] = x
    state[RIDER], state[RIDER_RATE] = x, v
    state[LAG : LAG + 4] = v
    return state
