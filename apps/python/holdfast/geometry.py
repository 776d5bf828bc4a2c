"""Rotations and covariances in the forms that other programs use. numpy only."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from . import _core


def quaternion(rotation: np.ndarray) -> tuple[float, float, float, float]:
    """x, y, z, w (w >= 0) of a rotation matrix, 3x3."""
    r = np.asarray(rotation, float)
    # The eigenvector of the largest eigenvalue of a symmetric matrix made of r is the quaternion, for any angle.
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [0, r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
            [0, 0, r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
            [0, 0, 0, r[0, 0] + r[1, 1] + r[2, 2]],
        ]
    )
    q = np.linalg.eigh(k, UPLO="U")[1][:, -1]
    q = q if q[3] >= 0 else -q
    return float(q[0]), float(q[1]), float(q[2]), float(q[3])


def matrix_of(translation: Sequence[float], quaternion_xyzw: Sequence[float]) -> np.ndarray:
    """Pose, 4x4, of a position (metres) and a unit quaternion."""
    x, y, z, w = quaternion_xyzw
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, 3] = translation
    return matrix


def standard_deviations(result: _core.FrameResult) -> tuple[float, float]:
    """Of the object's position (metres) and rotation (radians): roots of the summed variances of three axes."""
    covariance = camera_covariance(result)
    return float(np.sqrt(np.trace(covariance[:3, :3]))), float(np.sqrt(np.trace(covariance[3:, 3:])))


def camera_covariance(result: _core.FrameResult) -> np.ndarray:
    """Covariance (6x6: x, y, z, rotation about x, y, z) of where the object's origin is and how the object is turned,
    in the camera's axes: what geometry_msgs/PoseWithCovariance holds.

    Infinite where the frame does not tell the pose."""
    covariance = result.covariance
    if np.isinf(covariance).any():
        return covariance  # infinite in any axes; products with zeros would be no numbers
    # T_true = T exp((v, w)): in the object's axes its origin moves by v and it turns by w.
    change = np.kron(np.eye(2), result.T_camera_object[:3, :3])
    return change @ covariance @ change.T
