"""Converts samples to dictionaries of arrays, which transforms and loaders use."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .augment import Compose, Transform, generator
from .dataset import Sample
from .mix import Mix
from .ontology import LABELS, Ontology
from .words import names_in

MIXING = 2**32 - 1  # `position` of the mix in generator(); Compose numbers its transforms from 0


class SampleReader:
    """Reads a sample into a dictionary, with arrays of N points and M boxes:

    key, sensor        texts
    xyz                float32 (N, 3), m, without misses; and the columns, (N,)
    world_from_sensor  float64 (4, 4), the pose at the start of the revolution; absent if the file has no pose
    stagger            for range images, see Stagger; absent if unknown or if ring and column are not read
    target             int64 (N,), train ids of the labels; only if `train_ids` is given
    and, if `boxes` is given, the boxes of objects within the sensor's range:
    boxes              float32 (M, 7): x, y, z, length, width, height (m), yaw (rad) in the frame of the points
    box_class          int32 (M,), class ids in the ontology; box_instance int64 (M,), as in the column `instance`
    box_label          int64 (M,), indices in the list `boxes`; only if `boxes` is a list of class names
    box_velocity       float32 (M, 3), relative to the ground, along the sensor's axes, m/s
    box_points         int64 (M,), number of points in the scan
    box_visibility     float32 (M,), 0 to 1; NaN if no beam would hit the object even without occlusion
    """

    def __init__(
        self,
        *,
        sensor: str | None = None,
        columns: Sequence[str] | None = None,
        train_ids: NDArray[Any] | None = None,
        boxes: bool | Sequence[str] = False,
        min_points: int = 0,
        transform: Callable[[dict[str, Any], Any, int], dict[str, Any]] | Sequence[Transform] | None = None,
        mix: Mix | Sequence[Mix] | None = None,
        seed: int = 0,
    ) -> None:
        """`sensor` and `columns`: see Sample.scan(); the column `label` is also read if train ids need it. Of a sensor
        with several revolutions in a sample, the first is read. Of a JoinedDataset, only those columns, poses and
        staggers are returned that all of its sets have.

        `train_ids`: a table returned by Ontology.train_ids(). `boxes`: True for boxes of all classes, or a list of
        class names. Objects with fewer than `min_points` points are left out. `transform`: a list of
        transforms of scanmill.augment, which augment.Compose applies with the seed `seed`; or a function such as
        Compose: transform(sample, key, epoch) returns the changed sample.

        `mix`: a function such as augment.mix.LaserMix(), or a list of such functions, which are applied in order before
        the transform. mix(sample, other, rng) returns the sample mixed with another one of the same Dataset. The other
        sample and the random numbers depend only on the Dataset, `seed` (0 or more), the key and the epoch.
        """
        self.sensor = sensor
        self.columns = None if columns is None else names_in("columns", columns)
        if train_ids is not None and np.shape(train_ids) != (LABELS,):
            raise InputError("train_ids must be a table (65536,), such as dataset.ontology.train_ids(['road', 'car'])")
        self.train_ids = train_ids
        self.boxes = boxes if isinstance(boxes, bool) else names_in("boxes", boxes)
        self.min_points = min_points
        if isinstance(transform, Sequence):
            transform = Compose(transform, seed)
        elif type(transform).__module__ == "scanmill.augment" and not isinstance(transform, Compose):
            raise InputError(f"transform must be a list, [{type(transform).__name__}(...)], or a Compose of one")
        self.transform = transform
        self.mix = mix if isinstance(mix, Sequence) else [] if mix is None else [mix]
        self.seed = seed

    def __call__(self, sample: Sample, epoch: int = 0) -> dict[str, Any]:
        """Returns the dictionary of one sample. Raises InputError for the same reasons as Sample.scan(), and if `boxes`
        is given but the dataset has no object lists."""
        out = self._read(sample)
        if self.mix:
            rng = generator(self.seed, sample.key, epoch, MIXING)
            samples = sample.dataset
            other = (sample.index + int(rng.integers(1, max(len(samples), 2)))) % len(samples)
            mixed_in = self._read(samples[other])
            for mix in self.mix:
                out = mix(out, mixed_in, rng)
        return out if self.transform is None else self.transform(out, sample.key, epoch)

    def _read(self, sample: Sample) -> dict[str, Any]:
        columns = self.columns
        if columns is not None and self.train_ids is not None and "label" not in columns:
            columns = [*columns, "label"]
        scan = sample.scan(self.sensor, columns).dense()
        out: dict[str, Any] = {"key": sample.key, "sensor": scan.sensor, **scan.arrays()}
        if scan.world_from_sensor is not None:
            out["world_from_sensor"] = scan.world_from_sensor
        if scan.stagger is not None and "ring" in scan and "column" in scan:
            out["stagger"] = scan.stagger
        if self.train_ids is not None:
            out["target"] = self.train_ids[scan["label"]].astype(np.int64)
        if self.boxes is not False:
            out.update(self._boxes(sample))
        for name in sample.dataset.partial_names(self.sensor):
            out.pop(name, None)
        return out

    def _boxes(self, sample: Sample) -> dict[str, Any]:
        objects = sample.objects(self.sensor)
        if objects is None:
            raise InputError(f"{sample.dataset.path} lists no objects: generate it with `output: {{objects: true}}`")
        wanted = objects.points >= self.min_points
        labels = None
        if not isinstance(self.boxes, bool):
            ontology = sample.dataset.ontology
            labels = _indices_of(self.boxes, ontology)[objects.class_ids]
            listed = (sample.dataset.manifest or {}).get("scans", {}).get("object_classes")
            for name in self.boxes:
                if listed is not None and ontology is not None and ontology.id_of(name) not in listed:
                    raise InputError(
                        f"{sample.dataset.path} does not list objects of the class {name!r}: generate it with "
                        "`output: {objects: {classes: all}}`"
                    )
            wanted &= labels >= 0
        objects = objects.select(wanted)
        out = {
            "boxes": objects.boxes(),
            "box_class": objects.class_ids,
            "box_instance": objects.ids,
            "box_velocity": objects.velocities.astype(np.float32),
            "box_points": objects.points,
            "box_visibility": objects.visibility.astype(np.float32),
        }
        if labels is not None:
            out["box_label"] = labels[wanted]
        return out


def _indices_of(names: Sequence[str], ontology: Ontology | None) -> NDArray[np.int64]:
    """Returns a table (65536,) from class ids to indices in a list of class names; -1 for other classes."""
    if ontology is None:
        raise InputError("the classes are unknown, since there is no manifest")
    table = np.full(65536, -1, np.int64)
    for index, name in enumerate(names):
        table[ontology.id_of(name)] = index
    return table
