"""Rotations and covariances, against their definitions."""

import numpy as np
import pytest

from holdfast import geometry


@pytest.mark.parametrize("turn", [0.0, 1.0, 3.0, np.pi])
def test_quaternions(turn):
    axis = np.array([1.0, -2.0, 0.5]) / np.linalg.norm([1.0, -2.0, 0.5])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + np.sin(turn) * cross + (1 - np.cos(turn)) * cross @ cross
    found = np.array(geometry.quaternion(rotation))
    expected = np.append(np.sin(turn / 2) * axis, np.cos(turn / 2))
    assert min(np.abs(found - expected).max(), np.abs(found + expected).max()) < 1e-9
    matrix = geometry.matrix_of([1, 2, 3], found)
    np.testing.assert_allclose(matrix, np.vstack([np.column_stack([rotation, [1, 2, 3]]), [0, 0, 0, 1]]), atol=1e-9)


def test_covariance_in_the_cameras_frame(tracker, frames):
    """Against samples: T_true = T exp((v, w)) moves the origin and turns the object."""
    result = [tracker.track(frame) for frame in frames[:4]][-1]
    expected = geometry.camera_covariance(result)
    rng = np.random.default_rng(5)
    samples = rng.multivariate_normal(np.zeros(6), result.covariance, 20000)
    turn = result.T_camera_object[:3, :3]
    change = np.hstack([samples[:, :3] @ turn.T, samples[:, 3:] @ turn.T])  # exp() to first order: deviations are tiny
    measured = change.T @ change / len(change)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.max(np.abs(measured - expected) / scale) < 0.05
