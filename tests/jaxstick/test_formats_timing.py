"""Time axes: rounded ones are straightened, irregular ones resampled, broken ones refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxstick.errors import UserError
from jaxstick.formats.timing import local_cubic, uniform_axis

NUMBERS = np.arange(2, 5000)


def axis(times: np.ndarray, unit: float = 1.0):
    return uniform_axis(times, NUMBERS[: len(times)], "a.csv", unit)


@settings(max_examples=100, deadline=None)
@given(
    start=st.floats(-1e3, 1e3),
    interval=st.floats(1e-6, 10.0),
    count=st.integers(2, 400),
)
def test_a_uniform_axis_stays(start, interval, count):
    times = start + interval * np.arange(count)
    found = axis(times)
    assert found.recorded is None and found.notice is None
    np.testing.assert_allclose(found.time, times, atol=1e-6 * interval + 1e-12)
    samples = np.arange(count, dtype=float)
    assert found.resampled(samples) is samples


@pytest.mark.parametrize("rate", [256.0, 300.0, 700.0, 999.0])
@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_times_written_with_three_digits_are_uniform(rate, unit):
    """Single intervals are off by up to a half; over the record the grid is off by less than the last
    digit."""
    written = np.round(np.arange(600) / rate / unit, 3 if unit == 1.0 else 0) * unit
    found = axis(written, unit)
    assert found.recorded is None and found.notice is None
    assert abs(found.interval - 1 / rate) * 600 < 3e-4
    np.testing.assert_allclose(found.time, np.arange(600) / rate, atol=3e-4)


def test_a_missing_sample_is_not_taken_for_rounding():
    times = np.round(np.delete(np.arange(600) / 256, 300), 3)
    with pytest.raises(
        UserError, match=r"a.csv, line 302: .* 0\.008 s where 0\.004 s is usual: samples are missing"
    ):
        axis(times)


def test_jitter_is_resampled_and_said():
    rng = np.random.default_rng(0)
    times = 0.01 * np.arange(400) + rng.uniform(-0.002, 0.002, 400)
    found = axis(times)
    assert found.recorded is not None and found.notice is not None
    assert "a.csv" in found.notice and "resampled every 0.00999" in found.notice
    np.testing.assert_allclose(np.diff(found.time), found.interval, rtol=1e-9)
    samples = np.sin(2 * np.pi * times)
    np.testing.assert_allclose(found.resampled(samples), np.sin(2 * np.pi * found.time), atol=3e-6)


def test_a_slowly_drifting_clock_is_resampled():
    index = np.arange(1000)
    times = 1e-3 * (index + 1e-4 * index**2)
    found = axis(times)
    assert found.recorded is not None
    samples = np.cos(20 * times)
    np.testing.assert_allclose(found.resampled(samples), np.cos(20 * found.time), atol=1e-7)


def test_the_local_cubic_is_exact_for_cubics():
    rng = np.random.default_rng(1)
    times = np.cumsum(rng.uniform(0.5, 1.5, 40))
    wanted = np.linspace(times[0], times[-1], 101)

    def cubic(t: np.ndarray) -> np.ndarray:
        return 1 + t - 0.3 * t**2 + 0.01 * t**3

    np.testing.assert_allclose(local_cubic(times, cubic(times), wanted), cubic(wanted), atol=1e-9)


def test_a_corner_does_not_ring():
    times = np.arange(60.0)
    corner = np.maximum(times - 30, 0)
    wanted = np.linspace(0, 59, 700)
    error = np.abs(local_cubic(times, corner, wanted) - np.maximum(wanted - 30, 0))
    assert error.max() < 0.2
    assert error[np.abs(wanted - 30) > 2].max() < 1e-12


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: np.where(t == t[50], t[49], t), r"line 52: time stands still at 0\.49 s"),
        (lambda t: np.where(t >= t[50], t - 0.2, t), r"line 52: time goes back from 0\.49 s to 0\.3 s"),
        (
            lambda t: np.where(t >= t[50], t + 0.0062, t),
            r"line 52: the interval before .* is 0\.0162 s where 0\.01 s",
        ),
        (
            lambda t: np.where(t == t[50], t[50] - 0.0062, t),
            r"line 52: .* 0\.0038 s where 0\.01 s is usual; sampling",
        ),
    ],
)
def test_a_broken_axis_is_refused_at_its_line(change, sentence):
    with pytest.raises(UserError, match=sentence):
        axis(change(0.01 * np.arange(200)))
