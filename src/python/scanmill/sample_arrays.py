"""Arrays of samples, for augmentation (augment.py) and mixing (mix.py): checks, and the motion of points and boxes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InputError

Sample = dict[str, Any]  # arrays and texts by name, as scanmill.augment describes

VECTORS = ("velocity", "flow")  # columns NAME_x, NAME_y, NAME_z


def require_fraction(name: str, value: float) -> float:
    """Returns the value. Raises InputError unless it is from 0 to 1."""
    if not 0 <= value <= 1:
        raise InputError(f"{name} must be from 0 to 1, not {value}")
    return value


def require_interval(name: str, low: float, high: float) -> tuple[float, float]:
    """Returns the limits. Raises InputError unless the lower one is first."""
    if not low <= high:
        raise InputError(f"{name} must have the lower value first, not {low} and {high}")
    return low, high


def require_arrays(sample: Sample, who: str, *names: str) -> None:
    """Raises InputError, which names the missing arrays, if the sample lacks any of these."""
    missing = [name for name in names if name not in sample]
    if missing:
        raise InputError(f"{who} needs the columns {', '.join(names)}; the sample has no {', '.join(missing)}")


def dense_xyz(sample: Sample) -> NDArray[Any]:
    """Returns the points (N, 3). Raises InputError for those of an organised scan."""
    xyz: NDArray[Any] = sample["xyz"]
    if xyz.ndim != 2:
        raise InputError("augmentation needs dense points (N, 3): use scan.dense() first")
    return xyz


def has_row_per_point(name: str, values: Any, count: int) -> bool:
    """True if an entry of a sample has one value for each of its `count` points."""
    if name.startswith("box") or name == "world_from_sensor" or not isinstance(values, np.ndarray) or values.ndim == 0:
        return False
    if len(values) != count:
        raise InputError(f"'{name}' has {len(values)} entries, but the number of points is {count}")
    return True


def rotation_about_z(angle: float) -> NDArray[np.float64]:
    """Returns the rotation (3, 3) about z by an angle (rad, from x towards y)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def _turned(angles: NDArray[Any], rotation: NDArray[np.float64]) -> NDArray[Any]:
    """Returns the angles (rad, from x towards y) after a rotation or reflection of their directions, in the type of
    `angles`."""
    radians = np.asarray(angles, np.float64)
    x, y = rotation[:2, :2] @ np.stack([np.cos(radians), np.sin(radians)])
    return np.arctan2(y, x).astype(angles.dtype)


def moved(sample: Sample, rotation: NDArray[np.float64], scale: float = 1.0) -> Sample:
    """Returns the sample with all points p replaced by scale * rotation * p. `rotation` (3, 3) rotates or reflects x
    and y."""
    xyz = dense_xyz(sample)
    matrix = scale * rotation
    out = {**sample, "xyz": (xyz.astype(np.float64) @ matrix.T).astype(xyz.dtype)}
    for name in VECTORS:
        axes = [f"{name}_{axis}" for axis in "xyz"]
        present = [axis in sample for axis in axes]
        if all(present):
            vectors = np.stack([sample[axis] for axis in axes], axis=-1).astype(np.float64) @ matrix.T
            out.update({axis: vectors[:, i].astype(sample[axis].dtype) for i, axis in enumerate(axes)})
        elif any(present):
            raise InputError(f"give the columns {', '.join(axes)} together")
    if "azimuth" in sample:
        out["azimuth"] = _turned(sample["azimuth"], rotation)
    if "range_true" in sample:
        out["range_true"] = (sample["range_true"] * scale).astype(sample["range_true"].dtype)
    if "boxes" in sample:
        boxes = np.array(sample["boxes"], np.float64)
        boxes[:, :3] = boxes[:, :3] @ matrix.T
        boxes[:, 3:6] *= scale
        boxes[:, 6] = _turned(boxes[:, 6], rotation)
        out["boxes"] = boxes.astype(sample["boxes"].dtype)
    if "box_velocity" in sample:
        velocity = sample["box_velocity"]
        out["box_velocity"] = (velocity.astype(np.float64) @ matrix.T).astype(velocity.dtype)
    if "world_from_sensor" in sample:
        inverse = np.eye(4)
        inverse[:3, :3] = rotation.T / scale
        out["world_from_sensor"] = sample["world_from_sensor"] @ inverse
    return out
