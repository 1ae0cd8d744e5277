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
from typing import Union

import numpy as np

from . import mix as mix
from ._core import InputError
from .sample_arrays import (
    Sample,
    dense_xyz,
    has_row_per_point,
    moved,
    require_arrays,
    require_fraction,
    require_interval,
    rotation_about_z,
)

Transform = Callable[[Sample, np.random.Generator], Sample]
Index = Union[int, str]


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
        self.probability = require_fraction("probability", probability)

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        if rng.random() >= self.probability:
            return dict(sample)
        mirror = np.diag([-1.0, 1, 1] if self.axis == "x" else [1.0, -1, 1])
        return moved(sample, mirror)


class Turn:
    """Rotates about the vertical axis of the sensor by a random angle (rad), uniform between two limits."""

    def __init__(self, low: float = -np.pi, high: float = np.pi) -> None:
        self.low, self.high = require_interval("Turn", low, high)

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        return moved(sample, rotation_about_z(rng.uniform(self.low, self.high)))


class Scale:
    """Scales points, boxes, velocities and ranges by a random factor, uniform between two limits."""

    def __init__(self, low: float = 0.95, high: float = 1.05) -> None:
        self.low, self.high = require_interval("Scale", low, high)
        if self.low <= 0:
            raise InputError("the factors of Scale must be above 0")

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        return moved(sample, np.eye(3), rng.uniform(self.low, self.high))


class Jitter:
    """Adds normal noise with the standard deviation `sigma` to each coordinate of each point, limited to `clip` (m).

    Boxes are not changed, so points may be outside of their box by up to `clip` along each axis.
    """

    def __init__(self, sigma: float = 0.01, clip: float = 0.05) -> None:
        if not (sigma >= 0 and clip >= 0):
            raise InputError("sigma and clip of Jitter must be at least 0")
        self.sigma, self.clip = sigma, clip

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        xyz = dense_xyz(sample)
        noise = np.clip(rng.normal(0, self.sigma, xyz.shape), -self.clip, self.clip)
        return {**sample, "xyz": (xyz + noise).astype(xyz.dtype)}


class DropPoints:
    """Removes a random fraction of the points, different for each sample: uniform between 0 and `most`."""

    def __init__(self, most: float = 0.2) -> None:
        self.most = require_fraction("most", most)

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        count = len(dense_xyz(sample))
        keep = rng.random(count) >= rng.uniform(0, self.most)
        return {name: values[keep] if has_row_per_point(name, values, count) else values for name, values in sample.items()}


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
        xyz = dense_xyz(sample)
        require_arrays(sample, "RingErrors", "ring")
        ring = np.asarray(sample["ring"], np.int64)
        # One row for each ring, so that a ring's errors do not depend on which rings have points.
        errors = rng.normal(size=(int(ring.max(initial=0)) + 1, 2)) * [self.range_sigma, self.elevation_sigma]
        range_error, elevation_error = errors[ring].T
        x, y, z = xyz.astype(np.float64).T
        horizontal = np.hypot(x, y)
        new_range = np.maximum(np.hypot(horizontal, z) + range_error, 0)
        elevation = np.arctan2(z, horizontal) + elevation_error
        # For a point on the axis, any azimuth is right.
        factor = new_range * np.cos(elevation) / np.where(horizontal > 0, horizontal, 1)
        with_errors = np.column_stack([x * factor, y * factor, new_range * np.sin(elevation)])
        return {**sample, "xyz": with_errors.astype(xyz.dtype)}


class HideIntensity:
    """Sets the intensities of all points of a sample to `value`, with the given probability. With probability 1 a
    network learns to do without intensity, with a lower one it learns to do with and without."""

    def __init__(self, probability: float = 0.5, value: float = 0) -> None:
        self.probability, self.value = require_fraction("probability", probability), value

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        require_arrays(sample, "HideIntensity", "intensity")
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
        self.gain, self.gamma = require_interval("gain", *gain), require_interval("gamma", *gamma)
        self.full_scale = full_scale
        if min(self.gain[0], self.gamma[0], 1 if full_scale is None else full_scale) <= 0:
            raise InputError("gain, gamma and full_scale of JitterIntensity must be above 0")

    def __call__(self, sample: Sample, rng: np.random.Generator) -> Sample:
        require_arrays(sample, "JitterIntensity", "intensity")
        intensity = sample["intensity"]
        largest = np.iinfo(intensity.dtype).max if intensity.dtype.kind in "iu" else None
        full_scale = float(self.full_scale or largest or 1)
        gain, gamma = np.exp([rng.uniform(*np.log(limits)) for limits in (self.gain, self.gamma)])
        changed = gain * full_scale * (np.maximum(intensity.astype(np.float64), 0) / full_scale) ** gamma
        if largest is not None:
            changed = np.rint(np.minimum(changed, largest))
        return {**sample, "intensity": changed.astype(intensity.dtype)}
