"""The objects near a sensor, with their boxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .geometry import matrix_of
from .scan import chosen


def _matrices(poses: Sequence[Mapping[str, Any]]) -> NDArray[np.float64]:
    rotations = np.array([p["rotation"] for p in poses], np.float64).reshape(-1, 4)
    return matrix_of(rotations, np.array([p["translation"] for p in poses], np.float64).reshape(-1, 3))


def _yaws(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0])


class Objects:
    """The M objects within the range of one sensor, including objects without points.

    Boxes enclose the exact geometry, not only the points. Attributes, in the frame of the scan's points:
      sensor           name of the sensor
      ids              int64 (M,), as in the column `instance`; the same in all frames of a sequence
      class_ids        int32 (M,), ids in the ontology
      class_names      M strings
      names            M strings, names of the objects in the scene
      moves            bool (M,): the object moves at some time of the sequence
      heading_known    bool (M,); False: x is the longer side of the box, and its front may be on either end
      sensor_from_box  float64 (M, 4, 4): pose of the box when the beams pass over it, which matches the scan's points
      centers          float64 (M, 3), m
      sizes            float64 (M, 3): length along the box's x, width along y, height along z, m
      yaws             float64 (M,): direction of the box's x axis, rad from x towards y
      velocities       float64 (M, 3): over ground, along the sensor's axes at the start of the revolution, m/s
      points           int64 (M,): number of points in the scan, after all effects
      beams            int64 (M,): number of beams whose axis hits the object first
      beams_alone      int64 (M,): number of beams whose axis would hit the object if nothing occluded it
      visibility       float64 (M,): beams / beams_alone; NaN if beams_alone is 0
      truncation       float64 (M,): fraction of the box (solid angle) outside of the sensor's field of view or range
      nearest_range    float64 (M,): least noise-free range of the beams counted in `beams`, m; NaN if there are none
      world_from_box   float64 (M, 4, 4): pose of the box at the sample's time
      world_velocities float64 (M, 3): over ground, along the world's axes, m/s
    """

    def __init__(self, listed: Sequence[Mapping[str, Any]], sensor: str, world_from_sensor: ArrayLike) -> None:
        """`listed`: the list `objects` of KEY.objects.json. `world_from_sensor`: the sensor's pose (4, 4) at the start
        of the revolution."""
        seen = [(o, v) for o in listed for v in o["views"] if v["sensor"] == sensor]
        objects, views = [o for o, _ in seen], [v for _, v in seen]

        def figures(of: Sequence[Mapping[str, Any]], key: str, dtype: Any, columns: int = 0) -> NDArray[Any]:
            values = np.array([o[key] for o in of], dtype)
            return values.reshape(-1, columns) if columns else values

        self.sensor = sensor
        self.ids: NDArray[np.int64] = figures(objects, "id", np.int64)
        self.class_ids: NDArray[np.int32] = figures(objects, "class", np.int32)
        self.class_names: tuple[str, ...] = tuple(o["class_name"] for o in objects)
        self.names: tuple[str, ...] = tuple(o["name"] for o in objects)
        self.moves: NDArray[np.bool_] = figures(objects, "moves", bool)
        self.heading_known: NDArray[np.bool_] = figures(objects, "heading_known", bool)
        self.sensor_from_box = _matrices([v["sensor_from_box"] for v in views])
        self.centers: NDArray[np.float64] = self.sensor_from_box[:, :3, 3]
        self.sizes: NDArray[np.float64] = figures(objects, "size", np.float64, 3)
        self.yaws: NDArray[np.float64] = _yaws(self.sensor_from_box)
        self.points: NDArray[np.int64] = figures(views, "points", np.int64)
        self.beams: NDArray[np.int64] = figures(views, "beams", np.int64)
        self.beams_alone: NDArray[np.int64] = figures(views, "beams_alone", np.int64)
        self.visibility: NDArray[np.float64] = figures(views, "visibility", np.float64)
        self.truncation: NDArray[np.float64] = figures(views, "truncation", np.float64)
        self.nearest_range: NDArray[np.float64] = figures(views, "nearest_range", np.float64)
        self.world_from_box = _matrices([o["world_from_box"] for o in objects])
        self.world_velocities: NDArray[np.float64] = figures(objects, "velocity", np.float64, 3)
        # Velocities are row vectors: (sensor_from_world v)^T = v^T world_from_sensor.
        self.velocities: NDArray[np.float64] = self.world_velocities @ np.asarray(world_from_sensor)[:3, :3]

    def __len__(self) -> int:
        return len(self.ids)

    def __repr__(self) -> str:
        return f"<Objects of {self.sensor}: {len(self)}, {int((self.points > 0).sum())} with points>"

    def boxes(self) -> NDArray[np.float32]:
        """Returns boxes in the form that detectors use, in the frame of the points: x, y, z of the centre, length,
        width, height (m) and yaw (rad), float32 (M, 7). If the sensor is tilted, they ignore the tilt;
        `sensor_from_box` has it."""
        return np.column_stack([self.centers, self.sizes, self.yaws]).astype(np.float32)

    def world_boxes(self) -> NDArray[np.float64]:
        """Returns the boxes as boxes() does, but in the world's frame at the sample's time, and as float64 (M, 7)."""
        return np.column_stack([self.world_from_box[:, :3, 3], self.sizes, _yaws(self.world_from_box)])

    def select(self, which: ArrayLike) -> Objects:
        """Returns the objects that a mask (M,) or a list of indices selects."""
        rows = chosen(which, len(self))
        other = Objects.__new__(Objects)
        for name, values in self.__dict__.items():
            if isinstance(values, tuple):
                values = tuple(values[i] for i in rows)
            elif isinstance(values, np.ndarray):
                values = values[rows]
            other.__dict__[name] = values
        return other
