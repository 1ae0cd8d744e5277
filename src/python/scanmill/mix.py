"""Mixing: makes one sample of two, for instance of two scans of a dataset.

A mix takes a sample, another sample and a random generator, and returns a new sample; it does not modify the given
samples or their arrays. The argument `mix` of ScanDataset and SampleReader draws the other sample at random. Samples
are those of scanmill.augment; both must have the same columns, of the same types. For all mixes:

- The pose world_from_sensor and texts such as `key` are those of the first sample. Points keep their position relative
  to the sensor (or are rotated about it: PolarMix), so those of the other scan have another position in the world.
- Instance ids of the other sample that the first one uses too are replaced by unused ones, in `instance` and
  `box_instance`, so that ids stay unique but no longer identify objects of the other scan in a sequence.
- `box_points` is counted again if there are the columns `instance` and `box_instance`. `box_visibility` keeps the value
  that it has in the scan that the box comes from.
- The columns ring, column, time and return describe the beam in the scan that the point comes from, so two points may
  share a beam. Only PasteInstances computes which points hide others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .geometry import points_in_box
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

Mix = Callable[[Sample, Sample, np.random.Generator], Sample]
Rows = Any  # a mask, indices or a slice

IDS = ("instance", "box_instance")
ALL = slice(None)

# Points of a pasted instance are at most this far (m) outside of its box: noise moves them; mirror images are farther.
MARGIN = 0.2


class Choice:
    """Applies one of several mixes, chosen at random for each sample; with the probability 1 - `probability`, none."""

    def __init__(self, mixes: Sequence[Mix], probability: float = 1.0) -> None:
        if not mixes:
            raise InputError("Choice needs at least one mix")
        self.mixes, self.probability = list(mixes), require_fraction("probability", probability)

    def __call__(self, sample: Sample, other: Sample, rng: np.random.Generator) -> Sample:
        if rng.random() >= self.probability:
            return dict(sample)
        return self.mixes[rng.integers(len(self.mixes))](sample, other, rng)


class LaserMix:
    """Divides the elevations into equal intervals (areas), and takes the points of every other area from each scan.

    The number of areas is a random item of `areas`. The scan from which the lowest area is taken is random, too. Points
    beyond the limits of elevation belong to the nearest area, and boxes to the area of their centre.

    Source: Kong et al., LaserMix for Semi-Supervised LiDAR Semantic Segmentation, CVPR 2023, section 3 (partition and
    mixing); the numbers of areas are those of its implementation in MMDetection3D.
    """

    def __init__(self, areas: Sequence[int] = (3, 4, 5, 6), elevation: tuple[float, float] | None = None) -> None:
        """`elevation`: lowest and highest angle (rad) of the areas; by default those of the points of both scans."""
        if not areas or min(areas) < 1:
            raise InputError("areas of LaserMix must be a list of numbers of at least 1")
        self.areas = list(areas)
        self.elevation = None if elevation is None else require_interval("elevation", *elevation)

    def __call__(self, sample: Sample, other: Sample, rng: np.random.Generator) -> Sample:
        count, start = int(rng.choice(self.areas)), int(rng.integers(2))
        elevations = np.concatenate([_elevation(dense_xyz(sample)), _elevation(dense_xyz(other))])
        low, high = self.elevation or ((elevations.min(), elevations.max()) if len(elevations) else (0, 0))
        edges = np.linspace(low, high, count + 1)[1:-1]
        return _exchanged(sample, other, lambda xyz: (np.digitize(_elevation(xyz), edges) + start) % 2 == 1)


class PolarMix:
    """Exchanges a sector of azimuth, and pastes rotated copies of chosen classes of the other scan.

    With the probability `swap`, the other scan replaces a sector of the width `sector` (rad) in a random direction;
    boxes belong to the sector of their centre. Then, with the probability `paste`, all points and boxes of the
    `classes` of the other scan are pasted `copies` times, rotated about the sensor's z axis. The full turn is divided
    into equal intervals, one for each copy, and a copy's angle is random within its interval. Copies have separate
    instance ids. Neither collisions nor occlusion are tested. Copies keep the ring and the column of their original,
    which do not fit their new direction: for range images by ring and column, leave `classes` empty.

    Source: Xiao et al., PolarMix: A General Data Augmentation Technique for LiDAR Point Clouds, NeurIPS 2022, section 3
    (scene-level swapping, and instance-level rotation and paste).
    """

    def __init__(
        self,
        classes: Sequence[int] = (),
        *,
        sector: float = np.pi,
        copies: int = 3,
        swap: float = 0.5,
        paste: float = 1.0,
    ) -> None:
        """`classes`: class ids of the ontology, as in the columns `label` and `box_class`: [ontology.id_of("car")]."""
        if not 0 <= sector <= 2 * np.pi or copies < 1:
            raise InputError("PolarMix needs a sector from 0 to 2 pi and at least 1 copy")
        self.classes, self.sector, self.copies = _ids(classes), sector, copies
        self.swap, self.paste = require_fraction("swap", swap), require_fraction("paste", paste)

    def __call__(self, sample: Sample, other: Sample, rng: np.random.Generator) -> Sample:
        _require_alike(sample, other)
        out = dict(sample)
        if rng.random() < self.swap:
            start = rng.uniform(-np.pi, np.pi)
            out = _exchanged(sample, other, lambda xyz: np.remainder(_azimuth(xyz) - start, 2 * np.pi) < self.sector)
        if self.classes and rng.random() < self.paste:
            require_arrays(other, "PolarMix", "label", *(["box_class"] if "boxes" in other else []))
            boxes = np.isin(other.get("box_class", []), self.classes)
            original = _part(other, np.isin(other["label"], self.classes), boxes)
            for number in range(self.copies):
                angle = (number + rng.random()) * 2 * np.pi / self.copies
                out = _joined(out, moved(original, rotation_about_z(angle)))
        return out


class PasteInstances:
    """Pastes instances of the other scan, with their boxes, where they are relative to the sensor.

    Chooses at random up to `most` instances of the `classes` that have at least `min_points` points, and whose box,
    seen from above, overlaps no box of the first sample. The samples must therefore have the boxes of all classes with
    which instances may collide (`output: {objects: {classes: all}}`). Points of the first scan inside of pasted boxes
    are removed.

    If `hide` is true, and the samples have ring and column and the same `sensor`, only the nearest of the two scans
    remains in each beam: pasted points behind points of the first scan are removed, and so are points of the first scan
    behind pasted ones. Instances of which fewer than `min_points` points are left are not pasted. Where an object hid
    the instance in its own scan, a gap remains. Set `hide` to false for sensors whose pattern changes between
    revolutions.

    Source: Yan, Mao and Li, SECOND: Sparsely Embedded Convolutional Detection, Sensors 18 (2018) 3337, section "Sample
    Ground Truths from the Database", which tests collisions, but not occlusion.
    """

    def __init__(self, classes: Sequence[int], *, most: int = 10, min_points: int = 5, hide: bool = True) -> None:
        """`classes`: class ids of the ontology, as in `box_class`."""
        if most < 1 or min_points < 1:
            raise InputError("most and min_points of PasteInstances must be at least 1")
        self.classes, self.most, self.min_points, self.hide = _ids(classes), most, min_points, hide

    def __call__(self, sample: Sample, other: Sample, rng: np.random.Generator) -> Sample:
        require_arrays(sample, "PasteInstances", "boxes", "box_class", "instance", "box_instance")
        _require_alike(sample, other)
        boxes, ids = other["boxes"], other["box_instance"]
        free = np.isin(other["box_class"], self.classes) & ~_overlap(boxes, sample["boxes"]).any(axis=1)
        chosen = rng.permutation(np.flatnonzero(free & (_counts(other) >= self.min_points)))[: self.most]
        if not len(chosen):
            return dict(sample)
        pasted = _part(other, np.isin(other["instance"], ids[chosen]), chosen)
        in_own_box = [(pasted["instance"] == ids[i]) & points_in_box(pasted["xyz"], boxes[i], MARGIN) for i in chosen]
        pasted = _part(pasted, np.any(in_own_box, axis=0), ALL)
        inside = np.array([points_in_box(dense_xyz(sample), boxes[i]) for i in chosen])
        by_beam = self.hide and "ring" in sample and "column" in sample and sample.get("sensor") == other.get("sensor")
        if by_beam:
            pasted = _part(pasted, _visible(pasted, _part(sample, ~inside.any(axis=0), ALL)), ALL)
        visible = _counts(pasted) >= self.min_points  # by pasted box
        pasted = _part(pasted, np.isin(pasted["instance"], pasted["box_instance"][visible]), visible)
        remaining = ~inside[visible].any(axis=0)
        if by_beam:
            remaining &= ~np.isin(_beams(sample), _beams(pasted))
        return _joined(_part(sample, remaining, ALL), pasted)


def _ids(classes: Sequence[int]) -> list[int]:
    """Returns the list. Raises InputError unless it holds class ids."""
    if isinstance(classes, str) or not all(isinstance(c, (int, np.integer)) and 0 <= c < 65536 for c in classes):
        raise InputError(f"classes must be a list of ids, such as [ontology.id_of('car')], not {classes!r}")
    return list(classes)


def _elevation(xyz: NDArray[Any]) -> NDArray[Any]:
    return np.arctan2(xyz[:, 2], np.hypot(xyz[:, 0], xyz[:, 1]))


def _azimuth(xyz: NDArray[Any]) -> NDArray[Any]:
    return np.arctan2(xyz[:, 1], xyz[:, 0])


def _require_alike(sample: Sample, other: Sample) -> None:
    """Raises InputError, which names the columns, if the samples differ in their columns or the types of these."""
    types, other_types = (
        {name: (values.dtype, values.shape[1:]) for name, values in s.items() if isinstance(values, np.ndarray)}
        for s in (sample, other)
    )
    different = sorted(name for name in types.keys() | other_types.keys() if types.get(name) != other_types.get(name))
    if different:
        raise InputError(f"samples can be mixed only if they have the same columns; these differ: {', '.join(different)}")


def _part(sample: Sample, points: Rows, boxes: Rows) -> Sample:
    """Returns the sample with some of its points and boxes."""
    count = len(dense_xyz(sample))
    return {
        name: values[boxes] if name.startswith("box") else values[points] if has_row_per_point(name, values, count) else values
        for name, values in sample.items()
    }


def _exchanged(sample: Sample, other: Sample, in_other: Callable[[NDArray[Any]], NDArray[np.bool_]]) -> Sample:
    """Returns the points and boxes of the other sample for whose positions (n, 3) in_other() is true, and the points
    and boxes of the sample for whose positions it is false."""
    _require_alike(sample, other)
    parts = []
    for source, is_other in ((sample, False), (other, True)):
        boxes = in_other(source["boxes"]) == is_other if "boxes" in source else ALL
        parts.append(_part(source, in_other(dense_xyz(source)) == is_other, boxes))
    return _joined(*parts)


def _joined(sample: Sample, other: Sample) -> Sample:
    """Returns the points and boxes of both samples, with distinct instance ids."""
    count = len(dense_xyz(sample))
    other = _renumbered(other, sample)
    out = {
        name: np.concatenate([values, other[name]])
        if name.startswith("box") or has_row_per_point(name, values, count)
        else values
        for name, values in sample.items()
    }
    if "box_points" in out and all(name in out for name in IDS):
        out["box_points"] = _counts(out).astype(out["box_points"].dtype)
    return out


def _renumbered(other: Sample, sample: Sample) -> Sample:
    """Returns the other sample with unused ids in place of the instance ids that both samples use; 0 is no id."""
    used, ids = (  # ids of the sample and ids of the other sample, ascending
        np.unique(np.concatenate([np.empty(0, np.int64), *(s[name].astype(np.int64) for name in IDS if name in s)]))
        for s in (sample, other)
    )
    shared = np.isin(ids, used) & (ids > 0)
    unused = np.setdiff1d(np.arange(1, len(used) + len(ids) + 1), np.union1d(used, ids))
    new_ids = ids.copy()
    new_ids[shared] = unused[: np.count_nonzero(shared)]
    columns = {n: new_ids[np.searchsorted(ids, other[n])].astype(other[n].dtype) for n in IDS if n in other}
    return {**other, **columns}


def _counts(sample: Sample) -> NDArray[np.int64]:
    """Returns the number of points with the instance id of each box (M,)."""
    return np.count_nonzero(sample["instance"] == sample["box_instance"][:, np.newaxis], axis=1)


def _beams(sample: Sample) -> NDArray[np.int64]:
    """Returns a number for the beam of each point (N,)."""
    return sample["ring"].astype(np.int64) << 32 | sample["column"].astype(np.int64)


def _visible(sample: Sample, hiding: Sample) -> NDArray[np.bool_]:
    """Returns which points (N,) have no nearer or equally near point of the other sample in their beam."""
    beams, beam_of_point = np.unique(_beams(sample), return_inverse=True)
    in_same_beams = np.isin(_beams(hiding), beams)
    nearest = np.full(len(beams), np.inf)  # m, range of the nearest hiding point by beam
    ranges = np.linalg.norm(hiding["xyz"][in_same_beams], axis=1)
    np.minimum.at(nearest, np.searchsorted(beams, _beams(hiding)[in_same_beams]), ranges)
    return np.linalg.norm(sample["xyz"], axis=1) < nearest[beam_of_point]


def _overlap(boxes: NDArray[Any], others: NDArray[Any]) -> NDArray[np.bool_]:
    """Returns which boxes (n, 7) overlap which others (m, 7) as seen from above, (n, m). Two rectangles overlap unless
    they are apart along one of their four axes (separating axis theorem)."""
    a, b = boxes[:, np.newaxis].astype(np.float64), others[np.newaxis].astype(np.float64)
    x, y = (b - a)[..., 0], (b - a)[..., 1]
    c, s = np.abs(np.cos(b[..., 6] - a[..., 6])), np.abs(np.sin(b[..., 6] - a[..., 6]))
    apart = np.zeros(x.shape, bool)
    for p, q in ((a, b), (b, a)):  # tests the axes of p; columns 3, 4 and 6 are length, width and yaw
        along = np.abs(x * np.cos(p[..., 6]) + y * np.sin(p[..., 6]))
        across = np.abs(y * np.cos(p[..., 6]) - x * np.sin(p[..., 6]))
        apart |= along > (p[..., 3] + q[..., 3] * c + q[..., 4] * s) / 2
        apart |= across > (p[..., 4] + q[..., 3] * s + q[..., 4] * c) / 2
    return ~apart
