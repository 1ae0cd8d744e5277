"""One scan: the points that a sensor reports in one revolution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import InputError
from .geometry import between, transformed
from .words import advice, names_in

AXES = ("x", "y", "z")


def channel(arrays: Mapping[str, Any], name: str) -> NDArray[Any]:
    """Returns one value for each point: "x", "y", "z" or "range" (m, from the sensor's origin) of `xyz`, or a column.

    Raises InputError, which suggests a similar name, if there is no such value.
    """
    if name in AXES:
        return arrays["xyz"][..., AXES.index(name)]
    if name == "range":
        return np.linalg.norm(arrays["xyz"], axis=-1)
    if name in arrays and name != "xyz":
        return np.asarray(arrays[name])
    columns = [key for key, values in arrays.items() if isinstance(values, np.ndarray) and key != "xyz"]
    raise InputError(f"the points have no '{name}'{advice(name, [*AXES, 'range', *columns])}")


def stacked(arrays: Mapping[str, Any], channels: Sequence[str]) -> NDArray[np.float32]:
    """Returns the values of several channels of each point, float32 (..., k); see channel()."""
    shape = arrays["xyz"].shape[:-1]
    names = names_in("channels", channels)
    out = np.empty((*shape, len(names)), np.float32)
    for i, name in enumerate(names):
        out[..., i] = channel(arrays, name)
    return out


def chosen(which: ArrayLike, count: int) -> NDArray[np.int64]:
    """Returns the indices, of `count` entries, that a mask (count,) or a list of indices selects; both may be empty."""
    wanted = np.asarray(which)
    return np.arange(count)[wanted if wanted.size else wanted.astype(np.int64)]


class Stagger(NamedTuple):
    """Gives the column of a range image for each beam, such that every column looks in one direction. The lasers of one
    column of the sensor look in directions that differ by the azimuth offsets of the rings.

    shifts   int64 (rings,): a point of ring r and column c is in the image's column (c + shifts[r]) % columns
    columns  number of the image's columns: as many as the sensor has or, if its field is less than a full turn, more
    """

    shifts: NDArray[np.int64]
    columns: int


class Scan:
    """The points of one revolution.

    A dense scan has N points in the order of firing; each column has the shape (N,). An organised scan is an image of
    the shape (planes * rings, columns), with NaN positions for beams without a return; plane n has the (n + 1)th return
    of each beam.

    Columns are available as attributes and items: scan.label, scan["label"]; `return` only as an item, since it is a
    Python keyword. docs/keys.md lists the columns with their units.

    Further attributes:
      xyz                float32 (..., 3) in m, in the sensor's frame: x forward, y left, z up
      names              names of the columns
      sensor, method     empty if unknown
      start_time         s since the start of the sequence, when column 0 fires
      world_from_sensor  float64 (4, 4), the pose at the start of the revolution; None if unknown
      poses              float64 (P, 4, 4): this pose and, if the sensor moves, the pose at the end of the revolution,
                         or the pose of each column; None if unknown
      rings, columns     numbers of the sensor's rings and columns; 0 if unknown
      stagger            a Stagger, for range images; None if unknown
      objects            the Objects of Scene.scan(boxes=True); absent otherwise (datasets: Sample.objects())
    """

    def __init__(
        self,
        arrays: Mapping[str, NDArray[Any]],
        *,
        sensor: str = "",
        method: str = "",
        start_time: float = 0.0,
        poses: NDArray[np.float64] | None = None,
        deskewed: bool = False,
        column_starts: NDArray[Any] | None = None,
        rings: int = 0,
        columns: int = 0,
        stagger: Stagger | None = None,
    ) -> None:
        """`arrays`: `xyz` and the columns. `column_starts` (C,): the time at which each column fires (s since the start
        of the revolution)."""
        self._arrays: dict[str, NDArray[Any]] = dict(arrays)
        self.sensor = sensor
        self.method = method
        self.start_time = start_time
        self.poses = poses
        self.deskewed = deskewed
        self.column_starts = column_starts
        self.rings = rings
        self.columns = columns
        self.stagger = stagger

    @property
    def xyz(self) -> NDArray[np.float32]:
        return self._arrays["xyz"]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(name for name in self._arrays if name != "xyz")

    @property
    def organised(self) -> bool:
        return self.xyz.ndim == 3

    @property
    def range(self) -> NDArray[np.float32]:
        """Distances (...) of the points from the sensor's origin, m."""
        return channel(self._arrays, "range")

    @property
    def normals(self) -> NDArray[np.float32]:
        """Unit normals of the surfaces, turned towards the sensor, float32 (..., 3) along the axes of `xyz`, decoded from
        the column `normal_oct`; NaN where the column is 0."""
        coded = self["normal_oct"]
        u, v = ((coded >> shift & 0xFFFF) / 32767.0 - (1 + 1 / 32767) for shift in (0, 16))
        z = 1 - abs(u) - abs(v)
        fold = np.maximum(-z, 0)
        vectors = np.stack([u - np.copysign(fold, u), v - np.copysign(fold, v), z], axis=-1)
        vectors[coded == 0] = np.nan
        return (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).astype(np.float32)

    @property
    def world_from_sensor(self) -> NDArray[np.float64] | None:
        return None if self.poses is None else self.poses[0]

    def __len__(self) -> int:
        """Returns the number of points, without the misses of an organised scan."""
        return int(np.isfinite(self.xyz[..., 0]).sum()) if self.organised else len(self.xyz)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._arrays:
            raise InputError(f"the scan has no column '{name}'{advice(name, self._arrays)}")
        return self._arrays[name]

    def __contains__(self, name: object) -> bool:
        return name in self._arrays

    def __getattr__(self, name: str) -> NDArray[Any]:
        arrays = self.__dict__.get("_arrays", {})
        if name not in arrays:
            raise AttributeError(f"the scan has no column '{name}'{advice(name, arrays)}")
        return arrays[name]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.names]

    def __repr__(self) -> str:
        shape = " x ".join(str(n) for n in self.xyz.shape[:-1])
        return f"<Scan {self.sensor}: {shape}, {', '.join(self.names)}>"

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Returns `xyz` and the columns in a new dictionary; the arrays are not copied."""
        return dict(self._arrays)

    def points(self, channels: Sequence[str] = ("x", "y", "z", "intensity")) -> NDArray[np.float32]:
        """Returns the values of several channels of each point, float32 (N, k) with N = len(scan), without misses.

        Channels are "x", "y", "z", "range" and names of columns. Instance ids above 2^24 are rounded by float32.
        """
        return stacked(self.dense().arrays(), channels)

    def dense(self) -> Scan:
        """Returns the scan without misses, with points in the order of the image. Returns a dense scan unchanged.

        The columns `ring`, `column` and, if there are several planes, `return` are computed from the position in the
        image.
        """
        if not self.organised:
            return self
        height, width = self.xyz.shape[:2]
        rings = self.rings or height
        row, column = np.indices((height, width))
        beams = {"ring": (row % rings).astype(np.int32), "column": column.astype(np.int32)}
        if height > rings:
            beams["return"] = (row // rings + 1).astype(np.uint8)
        is_hit = np.isfinite(self.xyz[..., 0])
        return self._with({name: values[is_hit] for name, values in {**self._arrays, **beams}.items()})

    def select(self, which: ArrayLike) -> Scan:
        """Returns the points of a dense scan that a mask (N,) or indices select. Raises InputError for an organised
        scan."""
        if self.organised:
            raise InputError("points of an organised scan cannot be selected: use scan.dense().select(...)")
        points = chosen(which, len(self.xyz))
        return self._with({name: values[points] for name, values in self._arrays.items()})

    def world_xyz(self) -> NDArray[np.float64]:
        """Returns the points in the world's frame, float64 (..., 3) in m.

        If the sensor moves during the revolution and the dataset is not deskewed, each point is in the sensor's frame
        at the time of its column. The scan must then have the column `column` or `time`. If only the first and the last
        pose are known, the motion between them is assumed to be uniform. Raises InputError if the pose is unknown, or
        if a column that is needed is missing.
        """
        if self.poses is None:
            raise InputError("the pose of the sensor is unknown: a single file has no pose")
        if len(self.poses) == 1 or self.deskewed or self.xyz.size == 0:
            return transformed(self.poses[0], self.xyz)
        if self.column_starts is None:
            raise InputError("a moving sensor's points cannot be placed: the columns' firing times are unknown")
        starts = np.asarray(self.column_starts, np.float64)
        duration = starts[-1] - starts[0]  # s, from the first to the last column
        if not duration > 0:
            return transformed(self.poses[0], self.xyz)
        fractions = (starts - starts[0]) / duration  # by column: fraction of the motion at its firing time
        if len(self.poses) == len(starts) > 2 and (self.organised or "column" in self):
            column = np.arange(self.xyz.shape[1]) if self.organised else self["column"]
            return transformed(self.poses[column], self.xyz)
        if self.organised or "column" in self:
            matrices = between(self.poses[0], self.poses[-1], fractions)
            column = np.arange(self.xyz.shape[1]) if self.organised else np.minimum(self["column"], len(starts) - 1)
            return transformed(matrices[column], self.xyz)
        if "time" not in self:
            raise InputError("the sensor moves: placing its points in the world needs the column `column` or `time`")
        fractions = (self["time"].astype(np.float64) - starts[0]) / duration
        return transformed(between(self.poses[0], self.poses[-1], fractions), self.xyz)

    def _with(self, arrays: Mapping[str, NDArray[Any]]) -> Scan:
        other = Scan.__new__(Scan)
        other.__dict__.update(self.__dict__)
        other._arrays = dict(arrays)
        return other
