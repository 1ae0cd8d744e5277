"""Augmentation: random changes of samples that keep points, boxes and poses consistent.

A sample is a dictionary, as returned by ScanDataset and Scan.arrays(). It may contain
  xyz                           float32 (N, 3), m; and columns of the points under their names, (N,)
  boxes                         (M, 7): x, y, z, length, width, height, yaw; and values of the boxes under names that
                                begin with `box_`, (M, ...); of these, `box_velocity` (M, 3) is a vector
  world_from_sensor             float64 (4, 4), which is changed such that points keep their position in the world
and texts, which are not changed. A transform takes a sample and a random generator, and returns a new sample; it does
not modify the given sample or its arrays. Points must be dense: call scan.dense() before.

The columns range_true and azimuth describe the noise-free point: flips, turns and scales change them, but noise that is
added here does not. The columns ring and column always describe the beam and are not changed.

The module scanmill.augment.mix makes one sample of two.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from ._core import InputError

Sample = dict[str, Any]
Transform = Callable[[Sample, np.random.Generator], Sample]
Index = Union[int, str]

VECTORS = ("velocity", "flow")  # columns NAME_x, NAME_y, NAME_z


def generator(seed: int, index: Index, epoch: int = 0, position: int = 0) -> np.random.Generator:
    """Returns a random generator that depends only on the four arguments, so that results can be reproduced.

    `index` is the index or the key of a sample; `position` distinguishes several uses for the same sample.
    """
    if isinstance(index, str):
        index = int.from_bytes(hashlib.blake2b(index.encode(), digest_size=8).digest(), "little")
    return np.random.default_rng([seed, epoch, index, position])


class Compose:
    """Applies several transforms one after the other.

    The result of compose(sample, index, epoch) depends only on the seed, index and epoch, whichever worker calls it.
    Each transform has separate random numbers, so that removing a transform does not change the earlier ones.
    """

    def __init__(self, transforms: Sequence[Transform], seed: int = 0) -> None:
        """`seed` must be 0 or more."""
        self.transforms = list(transforms)
        self.seed = seed

    def __call__(self, sample: Sample, index: Index, epoch: int = 0) -> Sample:
        for position, transform in enumerate(self.transforms):
            sample = transform(sample, generator(self.seed, index, epoch, position))
        return sample


class Flip:
    """Mirrors one horizontal axis, "x" or "y": flipping y swaps left and right."""

    def __init__(self, axis: str = "y", probability: float = 0.5) -> None:
        if axis not in ("x", "y"):
            raise InputError(f"Flip mirrors x or y, not '{axis}'")
        self.axis = axis
        self.probability = _share("probability", probability)

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        if rng.random() >= self.probability:
            return dict(sample)
        mirror = np.diag([-1.0, 1, 1] if self.axis == "x" else [1.0, -1, 1])
        return _moved(sample, mirror)


class Turn:
    """Rotates about the vertical axis of the sensor by a random angle (rad), uniform between two limits."""

    def __init__(self, low: float = -np.pi, high: float = np.pi) -> None:
        self.low, self.high = _interval("Turn", low, high)

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        return _moved(sample, _rotation(rng.uniform(self.low, self.high)))


class Scale:
    """Scales points, boxes, velocities and ranges by a random factor, uniform between two limits."""

    def __init__(self, low: float = 0.95, high: float = 1.05) -> None:
        self.low, self.high = _interval("Scale", low, high)
        if self.low <= 0:
            raise InputError("the factors of Scale must be above 0")

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        return _moved(sample, np.eye(3), rng.uniform(self.low, self.high))


class Jitter:
    """Adds normal noise with the standard deviation `sigma` to each coordinate of each point, limited to `clip` (m).

    Boxes are not changed, so points may be outside of their box by up to `clip` along each axis.
    """

    def __init__(self, sigma: float = 0.01, clip: float = 0.05) -> None:
        if not (sigma >= 0 and clip >= 0):
            raise InputError("sigma and clip of Jitter must be at least 0")
        self.sigma, self.clip = sigma, clip

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        xyz = _xyz(sample)
        noise = np.clip(rng.normal(0, self.sigma, xyz.shape), -self.clip, self.clip)
        return {**sample, "xyz": (xyz + noise).astype(xyz.dtype)}


class DropPoints:
    """Removes a random fraction of the points, different for each sample: uniform between 0 and `most`."""

    def __init__(self, most: float = 0.2) -> None:
        self.most = _share("most", most)

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        count = len(_xyz(sample))
        keep = rng.random(count) >= rng.uniform(0, self.most)
        return {name: values[keep] if _of_points(name, values, count) else values for name, values in sample.items()}


class RingErrors:
    """Adds constant errors to each laser, like those of a badly calibrated sensor. All points of a ring get the same
    additional range and the same additional elevation, which are normally distributed with the standard deviations
    `range_sigma` (m) and `elevation_sigma` (rad).

    Needs the column `ring`; the z axis must be the sensor's axis. Boxes are not changed.
    """

    def __init__(self, range_sigma: float = 0.02, elevation_sigma: float = 0.0) -> None:
        if not (range_sigma >= 0 and elevation_sigma >= 0):
            raise InputError("the standard deviations of RingErrors must be at least 0")
        self.range_sigma, self.elevation_sigma = range_sigma, elevation_sigma

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        xyz = _xyz(sample)
        _require(sample, "RingErrors", "ring")
        ring = np.asarray(sample["ring"], np.int64)
        # One row for each ring, so that a ring's errors do not depend on which rings have points.
        errors = rng.normal(size=(int(ring.max(initial=0)) + 1, 2)) * [self.range_sigma, self.elevation_sigma]
        farther, higher = errors[ring].T
        x, y, z = xyz.astype(np.float64).T
        flat = np.hypot(x, y)
        distance = np.hypot(flat, z)
        longer = np.maximum(distance + farther, 0)
        elevation = np.arctan2(z, flat) + higher
        # For a point on the axis, any azimuth is right.
        out = longer * np.cos(elevation) / np.where(flat > 0, flat, 1)
        moved = np.column_stack([x * out, y * out, longer * np.sin(elevation)])
        return {**sample, "xyz": moved.astype(xyz.dtype)}


class HideIntensity:
    """Sets the intensities of all points to `value`, with the given probability for each sample: always (1), so that a
    network learns without intensity, or sometimes, so that it learns with and without."""

    def __init__(self, probability: float = 0.5, value: float = 0) -> None:
        self.probability, self.value = _share("probability", probability), value

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        _require(sample, "HideIntensity", "intensity")
        if rng.random() >= self.probability:
            return dict(sample)
        return {**sample, "intensity": np.full_like(sample["intensity"], self.value)}


class JitterIntensity:
    """Changes intensities i as another receiver would: to gain * full_scale * (i / full_scale) ** gamma.

    Gain and gamma are random, the same for all points of a sample, with logarithms uniform between those of two limits.
    The type of the column is kept: integers are rounded and limited to the type's range, negative values become 0.
    """

    def __init__(
        self,
        gain: tuple[float, float] = (0.5, 2.0),
        gamma: tuple[float, float] = (0.6, 1.6),
        full_scale: float | None = None,
    ) -> None:
        """`full_scale`: the intensity that gamma does not change; by default the largest value of an integer type, and
        1 for floating-point types. Give 255 for bytes that are stored as floating-point numbers."""
        self.gain, self.gamma = _interval("gain", *gain), _interval("gamma", *gamma)
        self.full_scale = full_scale
        if min(self.gain[0], self.gamma[0], 1 if full_scale is None else full_scale) <= 0:
            raise InputError("gain, gamma and full_scale of JitterIntensity must be above 0")

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        _require(sample, "JitterIntensity", "intensity")
        intensity = sample["intensity"]
        most = np.iinfo(intensity.dtype).max if intensity.dtype.kind in "iu" else None
        full = float(self.full_scale or most or 1)
        gain, gamma = np.exp([rng.uniform(*np.log(limits)) for limits in (self.gain, self.gamma)])
        changed = gain * full * (np.maximum(intensity.astype(np.float64), 0) / full) ** gamma
        if most is not None:
            changed = np.rint(np.minimum(changed, most))
        return {**sample, "intensity": changed.astype(intensity.dtype)}


def _share(name: str, value: float) -> float:
    if not 0 <= value <= 1:
        raise InputError(f"{name} must be from 0 to 1, not {value}")
    return value


def _interval(name: str, low: float, high: float) -> tuple[float, float]:
    if not low <= high:
        raise InputError(f"{name} must have the lower value first, not {low} and {high}")
    return low, high


def _require(sample: Sample, who: str, *names: str) -> None:
    """Raises InputError, which names the missing arrays, if the sample lacks any of these."""
    missing = [name for name in names if name not in sample]
    if missing:
        raise InputError(f"{who} needs the columns {', '.join(names)}; the sample has no {', '.join(missing)}")


def _xyz(sample: Sample) -> NDArray[Any]:
    xyz: NDArray[Any] = sample["xyz"]
    if xyz.ndim != 2:
        raise InputError("augmentation needs dense points (N, 3): use scan.dense() first")
    return xyz


def _of_points(name: str, values: Any, count: int) -> bool:
    """True if an entry of a sample has one value for each of its `count` points."""
    if name.startswith("box") or name == "world_from_sensor" or not isinstance(values, np.ndarray) or values.ndim == 0:
        return False
    if len(values) != count:
        raise InputError(f"'{name}' has {len(values)} entries, but the number of points is {count}")
    return True


def _rotation(angle: float) -> NDArray[np.float64]:
    """Returns the rotation (3, 3) about z by an angle (rad, from x towards y)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def _turned(angles: NDArray[Any], rotation: NDArray[np.float64]) -> NDArray[Any]:
    """Returns the angles (rad, from x towards y) after a rotation or reflection of their directions, in the given
    type."""
    own = np.asarray(angles, np.float64)
    x, y = rotation[:2, :2] @ np.stack([np.cos(own), np.sin(own)])
    return np.arctan2(y, x).astype(angles.dtype)


def _moved(sample: Sample, rotation: NDArray[np.float64], scale: float = 1.0) -> Sample:
    """Returns the sample with all points p replaced by scale * rotation * p. `rotation` (3, 3) rotates or reflects x
    and y."""
    xyz = _xyz(sample)
    matrix = scale * rotation
    out = {**sample, "xyz": (xyz.astype(np.float64) @ matrix.T).astype(xyz.dtype)}
    for name in VECTORS:
        axes = [f"{name}_{axis}" for axis in "xyz"]
        there = [axis in sample for axis in axes]
        if all(there):
            vectors = np.stack([sample[axis] for axis in axes], axis=-1).astype(np.float64) @ matrix.T
            out.update({axis: vectors[:, i].astype(sample[axis].dtype) for i, axis in enumerate(axes)})
        elif any(there):
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


from . import mix as mix  # noqa: E402: at the end, since the module uses the functions above
