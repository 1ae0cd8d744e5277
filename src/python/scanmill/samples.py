"""Samples as the dictionaries of arrays that transforms and loaders work on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .dataset import Sample
from .ontology import Ontology


class SampleReader:
    """Reads a sample into a dictionary, with arrays of N points and M boxes:

    key, sensor        texts
    xyz                float32 (N, 3), m, without misses; and the columns, (N,)
    world_from_sensor  float64 (4, 4), the pose at the start of the revolution; not of files without one
    target             int64 (N,), labels by the table of train ids, where that is given
    and where boxes are asked for, those that the sensor's range reaches:
    boxes              float32 (M, 7): x, y, z, length, width, height (m), yaw (rad) in the frame of the points
    box_class          uint16 (M,), class ids of the ontology; box_instance uint32 (M,), as in the column `instance`
    box_label          int64 (M,), indices into the list of classes, where boxes are asked for by such a list
    box_velocity       float32 (M, 3), over ground, along the sensor's axes, m/s
    box_points         int64 (M,), of the scan; box_visibility float32 (M,), 0 to 1, NaN where no beam would meet it
    """

    def __init__(
        self,
        *,
        sensor: str | None = None,
        columns: Sequence[str] | None = None,
        train_ids: NDArray[Any] | None = None,
        boxes: bool | Sequence[str] = False,
        min_points: int = 0,
        transform: Callable[[dict[str, Any], Any, int], dict[str, Any]] | None = None,
    ) -> None:
        """`sensor` and `columns` are as of Sample.scan(); the column `label` is read besides where train ids need it.

        `train_ids` is a table as Ontology.train_ids() makes it. `boxes` is True for all, or names of classes. Boxes of
        things with fewer than `min_points` points are left out. `transform(sample, key, epoch)` makes another sample,
        as augment.Compose does.
        """
        if isinstance(columns, str) or isinstance(boxes, str):
            raise InputError("columns and boxes must be lists of names")
        self.sensor = sensor
        self.columns = None if columns is None else list(columns)
        self.train_ids = train_ids
        self.boxes = boxes
        self.min_points = min_points
        self.transform = transform

    def __call__(self, sample: Sample, epoch: int = 0) -> dict[str, Any]:
        """The dictionary of one sample. Raises InputError as Sample.scan() does, and where boxes are asked for and the
        dataset lists no objects."""
        columns = self.columns
        if columns is not None and self.train_ids is not None and "label" not in columns:
            columns = [*columns, "label"]
        scan = sample.scan(self.sensor, columns).dense()
        out: dict[str, Any] = {"key": sample.key, "sensor": scan.sensor, **scan.arrays()}
        if scan.world_from_sensor is not None:
            out["world_from_sensor"] = scan.world_from_sensor
        if self.train_ids is not None:
            out["target"] = self.train_ids[scan["label"]].astype(np.int64)
        if self.boxes is not False:
            out.update(self._boxes(sample))
        return out if self.transform is None else self.transform(out, sample.key, epoch)

    def _boxes(self, sample: Sample) -> dict[str, Any]:
        objects = sample.objects(self.sensor)
        if objects is None:
            raise InputError(f"{sample.dataset.path} lists no objects: generate it with `output: {{objects: true}}`")
        wanted = objects.points >= self.min_points
        labels = None
        if not isinstance(self.boxes, bool):
            labels = _indices_of(self.boxes, sample.dataset.ontology)[objects.class_ids]
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
    """A table (65536,) from class ids to indices into a list of names; -1 for others."""
    if ontology is None:
        raise InputError("the classes are unknown, since there is no manifest")
    table = np.full(65536, -1, np.int64)
    for index, name in enumerate(names):
        table[ontology.id_of(name)] = index
    return table
