"""The chord method on linear maps, where every step can be reckoned by hand."""

from __future__ import annotations

import numpy as np

from jaxstick.chord import Chase, corrected

MAP = np.array([[0.5, -0.3, 0.0], [0.2, -0.7, 0.0], [1.0, 2.0, 0.0]])
"""The third component is no memory: nothing depends on it."""

SHIFT = np.array([0.3, -0.1, 0.7])


def chase(jacobian: np.ndarray) -> Chase:
    return Chase.begin(np.array([0]), np.zeros((1, 3)), np.ones((1, 3)), jacobian[None], np.ones(1))


def laps(lane: Chase, count: int) -> list[float]:
    """Residuals of so many laps, corrected after each."""
    which, residuals = np.array([0]), []
    for _ in range(count):
        change = lane.state @ MAP.T + SHIFT - lane.state
        lane.learn(which, change, lane.memory())
        residuals.append(float(lane.residual[0]))
        lane.move(which, change, lane.memory())
    return residuals


def test_with_the_exact_jacobian_one_step_leads_to_the_fixed_point() -> None:
    lane = chase(MAP)
    first, second = laps(lane, 2)
    assert first == 0.3
    assert second < 1e-15
    np.testing.assert_allclose(lane.state[0], np.linalg.solve(np.eye(3) - MAP, SHIFT), atol=1e-14)


def test_two_independent_strides_teach_the_jacobian() -> None:
    """Broyden's plain correction unlearns the first of them and is left with a thousandth of the residual."""
    wrong = MAP + np.array([[0.0, 0.2, 0.0], [-0.2, 0.0, 0.0], [0.0, 0.0, 0.0]])
    lane = chase(wrong)
    residuals = laps(lane, 4)
    np.testing.assert_allclose(lane.jacobian[0, :2, :2], MAP[:2, :2], atol=1e-12)
    assert residuals[3] < 1e-13 < residuals[2]


def test_what_is_no_memory_is_not_solved_for() -> None:
    lane = chase(MAP)
    assert lane.memory().tolist() == [[True, True, False]]
    step = corrected(lane.jacobian, SHIFT[None], lane.memory())
    assert step[0, 2] == 0
    np.testing.assert_allclose(step[0, :2], np.linalg.solve(np.eye(2) - MAP[:2, :2], SHIFT[:2]))


def test_steps_are_no_longer_than_what_is_known_reaches() -> None:
    lane = chase(np.diag([1 - 1e-6, 0.0, 0.0]))
    lane.move(np.array([0]), np.array([[1.0, 0.0, 0.0]]), lane.memory())
    assert lane.state[0].tolist() == [20.0, 0.0, 0.0]
