"""Poses as matrices, and boxes.

A matrix a_from_b (4, 4), float64, transforms points from the frame b to the frame a. Frames are right-handed with x
forward, y left, z up. Lengths are in metres, angles in radians; quaternions are w, x, y, z.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import InputError
from .words import require_known

Pose = Union[ArrayLike, Mapping[str, Any]]

# Angles, in the order in which they are applied. A positive angle rotates the first axis towards the second.
TURNS = {"yaw_deg": (0, 1), "pitch_deg": (2, 0), "roll_deg": (1, 2)}
POSE_KEYS = ("position", *TURNS, "rotation")

# Tolerance for matrices of users: rotations in single precision are accepted, a scale of 1.001 is not.
ROTATION_TOLERANCE = 1e-5


def matrix_of(rotation: ArrayLike, translation: ArrayLike) -> NDArray[np.float64]:
    """Returns matrices (..., 4, 4) for quaternions (..., 4), which need not be normalised, and translations (..., 3) in
    m."""
    q = np.asarray(rotation, np.float64)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    w, x, y, z = np.moveaxis(q, -1, 0)
    matrix = np.zeros((*q.shape[:-1], 4, 4))
    matrix[..., 0, 0] = 1 - 2 * (y * y + z * z)
    matrix[..., 0, 1] = 2 * (x * y - w * z)
    matrix[..., 0, 2] = 2 * (x * z + w * y)
    matrix[..., 1, 0] = 2 * (x * y + w * z)
    matrix[..., 1, 1] = 1 - 2 * (x * x + z * z)
    matrix[..., 1, 2] = 2 * (y * z - w * x)
    matrix[..., 2, 0] = 2 * (x * z - w * y)
    matrix[..., 2, 1] = 2 * (y * z + w * x)
    matrix[..., 2, 2] = 1 - 2 * (x * x + y * y)
    matrix[..., :3, 3] = translation
    matrix[..., 3, 3] = 1
    return matrix


def quaternion_of(matrix: ArrayLike) -> NDArray[np.float64]:
    """Returns the unit quaternions (..., 4) of the rotations in matrices, (..., 3, 3) or (..., 4, 4)."""
    m = np.moveaxis(np.asarray(matrix, np.float64), (-2, -1), (0, 1))
    # Row k is 4 q[k] q. The row with the largest q[k] has the smallest rounding errors.
    rows = np.array(
        [
            [1 + m[0, 0] + m[1, 1] + m[2, 2], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 1 - m[0, 0] + m[1, 1] - m[2, 2], m[1, 2] + m[2, 1]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1 - m[0, 0] - m[1, 1] + m[2, 2]],
        ]
    )
    rows = np.moveaxis(rows, (0, 1), (-2, -1))
    largest = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), axis=-1)[..., np.newaxis, np.newaxis]
    q: NDArray[np.float64] = np.take_along_axis(rows, largest, axis=-2)[..., 0, :]
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def pose_matrix(pose: Pose) -> NDArray[np.float64]:
    """Returns the matrix (4, 4) of a pose, which is either a matrix or a map as in pipelines.

    The map may have `position` [x, y, z] (m), and either `yaw_deg`, `pitch_deg` and `roll_deg` or `rotation` [w, x, y,
    z]. With a positive pitch, x points down. Raises InputError if `pose` is not a pose.
    """
    if isinstance(pose, Mapping):
        return _matrix_of_map(pose)
    try:
        matrix = np.array(pose, np.float64)
    except (TypeError, ValueError):
        raise InputError("a pose must be a matrix of 4 x 4 numbers or a map with position, yaw_deg and so on") from None
    if matrix.shape != (4, 4):
        raise InputError(f"a pose must be a matrix of 4 x 4 finite numbers, not an array of {matrix.shape}")
    require_rigid(matrix[np.newaxis])
    return matrix


def require_rigid(matrices: NDArray[np.float64]) -> None:
    """Raises InputError if one of the matrices (n, 4, 4) is not a pose. Its attribute `row` is the number of the first
    such matrix."""
    rotations = matrices[:, :3, :3]
    finite = np.isfinite(matrices).all(axis=(1, 2))
    skew = np.abs(rotations @ rotations.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    for is_pose, message in (
        (finite, "a pose must be a matrix of 4 x 4 finite numbers"),
        (
            (skew <= ROTATION_TOLERANCE) & (np.linalg.det(np.where(finite[:, None, None], rotations, 0)) > 0),
            "the upper left 3 x 3 numbers of a pose must be a rotation, without scale and mirroring",
        ),
        (
            np.abs(matrices[:, 3] - [0, 0, 0, 1]).max(axis=1) <= ROTATION_TOLERANCE,
            "the last row of a pose must be 0, 0, 0, 1: translations are the last column",
        ),
    ):
        if not is_pose.all():
            error = InputError(message)
            error.row = int(np.argmin(is_pose))  # type: ignore[attr-defined]
            raise error


def _numbers(pose: Mapping[str, Any], key: str, default: list[float]) -> NDArray[np.float64]:
    """Returns the numbers under a key of the map, which must be finite and as many as in `default`."""
    try:
        values = np.asarray(pose.get(key, default), np.float64)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != (len(default),) or not np.isfinite(values).all():
        raise InputError(f"pose: {key} must be {len(default)} finite numbers, not {pose[key]!r}")
    return values


def _matrix_of_map(pose: Mapping[str, Any]) -> NDArray[np.float64]:
    for key in pose:
        require_known("key of a pose", key, POSE_KEYS)
    position = _numbers(pose, "position", [0.0, 0.0, 0.0])
    if "rotation" in pose:
        if any(key in pose for key in TURNS):
            raise InputError("pose: rotation and yaw_deg, pitch_deg or roll_deg cannot be given together")
        rotation = _numbers(pose, "rotation", [1.0, 0.0, 0.0, 0.0])
        if not np.linalg.norm(rotation) > 0:
            raise InputError("pose: rotation must be a quaternion w, x, y, z of non-zero length")
        return matrix_of(rotation, position)
    matrix = np.eye(4)
    for key, (i, j) in TURNS.items():
        (angle,) = np.deg2rad(_numbers({key: [pose[key]]} if key in pose else {}, key, [0.0]))
        rotation = np.eye(4)
        rotation[i, i] = rotation[j, j] = np.cos(angle)
        rotation[j, i] = np.sin(angle)
        rotation[i, j] = -rotation[j, i]
        matrix = matrix @ rotation
    matrix[:3, 3] = position
    return matrix


def between(first: ArrayLike, last: ArrayLike, share: ArrayLike) -> NDArray[np.float64]:
    """Returns poses (..., 4, 4) between two poses (4, 4), at the fractions `share` (...) from 0 to 1: rotations are
    interpolated at constant speed by the shorter way, translations along a straight line."""
    first, last = np.asarray(first, np.float64), np.asarray(last, np.float64)
    t = np.asarray(share, np.float64)[..., np.newaxis]
    a, b = quaternion_of(first), quaternion_of(last)
    cosine = float(a @ b)
    if cosine < 0:
        b, cosine = -b, -cosine
    rotation = (1 - t) * a + t * b
    if cosine < 1 - 1e-8:  # for smaller angles, linear interpolation is exact enough
        angle = np.arccos(cosine)
        rotation = (np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)
    return matrix_of(rotation, first[:3, 3] + (last[:3, 3] - first[:3, 3]) * t)


def transformed(matrix: ArrayLike, xyz: NDArray[Any]) -> NDArray[np.float64]:
    """Returns points (..., 3), transformed by one matrix (4, 4) or by one matrix for each point (..., 4, 4), as
    float64."""
    m = np.asarray(matrix, np.float64)
    return np.einsum("...ij,...j->...i", m[..., :3, :3], np.asarray(xyz, np.float64)) + m[..., :3, 3]


def points_in_box(xyz: NDArray[Any], box: ArrayLike, margin: float = 0.0) -> NDArray[np.bool_]:
    """Returns which of the points (..., 3) are in a box [x, y, z, length, width, height, yaw] of the same frame, bool
    (...).

    `margin` (m) extends the box on all sides. Misses, which are NaN, are in no box.
    """
    x, y, z, length, width, height, yaw = np.asarray(box, np.float64)
    ahead, left, up = np.moveaxis(np.asarray(xyz, np.float64) - [x, y, z], -1, 0)
    along = ahead * np.cos(yaw) + left * np.sin(yaw)
    across = left * np.cos(yaw) - ahead * np.sin(yaw)
    inside = (np.abs(along) <= length / 2 + margin) & (np.abs(across) <= width / 2 + margin)
    return inside & (np.abs(up) <= height / 2 + margin)
