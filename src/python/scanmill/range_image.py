"""Range images: points as images with the sensor's rings and columns, and back.

The columns `ring` and `column` state the beam of each point, whatever its noise and the offset of its origin. Each beam
has a pixel of its own: unlike a projection by angles, this causes no holes and no collisions. Row r is ring r;
`top_down` of the sensor in the manifest states whether row 0 is the top one. Points without ring and column, for
instance from other programs, are projected by their angles.

The lasers that fire as one column of the sensor look in directions that differ by the azimuth offsets of their rings.
Images are therefore destaggered: each row is shifted by whole columns (Stagger), so that each column of the image looks
in one direction. This is the direction of a laser without azimuth offset in the sensor's column of the same number;
`clockwise` and `first_azimuth` in the manifest determine it. With `destagger=False`, column c of the image is column c
of the sensor.

Functions take a Scan, or a dictionary of arrays such as a sample of ScanDataset.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .scan import Scan, Stagger, channel
from .words import names_in

Points = Union[Scan, Mapping[str, Any]]


def _dense_arrays(points: Points) -> dict[str, Any]:
    if isinstance(points, Scan):
        return points.dense().arrays()
    if points["xyz"].ndim != 2:
        raise InputError("a range image needs dense points (N, 3) or a Scan")
    return dict(points)


class Projection:
    """The assignment of points to pixels.

    Attributes, with H x W pixels and the N points of the scan without misses (scan.dense()):
      index  int64 (H, W): index of the point that the pixel shows; -1 if it shows none
      pixel  int64 (N,): pixel of each point, row * W + column, even if the pixel shows another point; -1 if the point
             is outside of the image
    """

    def __init__(self, pixel: NDArray[np.int64], shape: tuple[int, int], order: NDArray[np.int64]) -> None:
        """`order`: indices of points. If several points are in a pixel, the one that comes first in this order is
        shown."""
        self.pixel = pixel
        shown = order[pixel[order] >= 0]
        index = np.full(shape[0] * shape[1], -1, np.int64)
        index[pixel[shown]] = shown
        if np.count_nonzero(index >= 0) < len(shown):  # if points share a pixel, the assignment above keeps any of them
            pixels, first = np.unique(pixel[shown], return_index=True)
            index[pixels] = shown[first]
        self.index: NDArray[np.int64] = index.reshape(shape)

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Which pixels show a point, bool (H, W)."""
        return self.index >= 0

    def image(self, values: NDArray[Any], fill: float = 0) -> NDArray[Any]:
        """Returns an image (H, W, ...) of values of the points (N, ...), of the same type; `fill` for pixels without a
        point. Raises InputError if there is not one value for each point without misses (scan.dense())."""
        if len(values) != len(self.pixel):
            raise InputError(
                f"image() takes a value for each of the {len(self.pixel)} points without misses, not {len(values)}: "
                "take columns of scan.dense()"
            )
        if not len(values):
            return np.full((*self.index.shape, *values.shape[1:]), fill, values.dtype)
        out = values.take(self.index, axis=0)  # pixels without a point (index -1) get the value of the last point, for now
        out[~self.mask] = fill
        return out

    def points(self, image: NDArray[Any], fill: float = 0) -> NDArray[Any]:
        """The inverse of image(): returns for each point (N, ...) the value of an image (H, W, ...) in its pixel;
        `fill` for points outside of the image.

        Points that share a pixel with the shown point get the same value. Raises InputError for an image of another
        size.
        """
        if image.shape[:2] != self.index.shape:
            raise InputError(f"points() takes an image of {self.index.shape}, not {image.shape[:2]}")
        out = np.full((len(self.pixel), *image.shape[2:]), fill, image.dtype)
        inside = self.pixel >= 0
        out[inside] = image.reshape(-1, *image.shape[2:])[self.pixel[inside]]
        return out


def beam_projection(
    points: Points, rings: int = 0, columns: int = 0, return_: int = 1, destagger: bool | Stagger = True
) -> Projection:
    """Assigns points to pixels by the columns `ring` and `column`: each beam has a pixel of its own.

    `rings` and `columns` are the sensor's numbers; they can be omitted for a Scan of a dataset. `return_` is the number
    of the return that is shown for each beam: 1 is the nearest. `destagger`: True shifts the rows by the sensor's
    azimuth offsets, which are known for scans of datasets and scenes, and samples of ScanDataset; for other points give
    Dataset.stagger(sensor), or False. A sensor with azimuth offsets and less than a full turn has an image of more than
    `columns` columns. Raises InputError if points have no ring and column, if these are outside of the image, if the
    offsets are unknown, or if `return_` is not 1 and points have no column `return`.
    """
    if isinstance(points, Scan):
        rings, columns = rings or points.rings, columns or points.columns
    stagger = _stagger_of(points, destagger)
    arrays = _dense_arrays(points)
    if rings < 1 or columns < 1:
        raise InputError("the numbers of rings and columns of the sensor are unknown: give rings and columns")
    if "ring" not in arrays or "column" not in arrays:
        raise InputError("the points have no columns ring and column: use spherical_projection() without them")
    ring, column = arrays["ring"].astype(np.int64), arrays["column"].astype(np.int64)
    if ring.size and (ring.max() >= rings or column.max() >= columns):
        raise InputError(f"ring {ring.max()} or column {column.max()} is not in an image of {rings} x {columns}")
    if stagger is not None:
        rings_with_shift = len(stagger.shifts)
        if ring.size and ring.max() >= rings_with_shift:
            raise InputError(
                f"the points have a ring {ring.max()}, but azimuth offsets are known for {rings_with_shift} rings"
            )
        column = (column + stagger.shifts[ring]) % stagger.columns
        columns = max(columns, stagger.columns)
    pixel = ring * columns + column
    if "return" in arrays:
        pixel[arrays["return"] != return_] = -1
    elif return_ != 1:
        raise InputError(f"return number {return_} cannot be selected: the points have no column `return`")
    return Projection(pixel, (rings, columns), np.arange(len(pixel)))


def _stagger_of(points: Points, destagger: bool | Stagger) -> Stagger | None:
    """Returns the shifts of an image's rows; None if they are not to be shifted."""
    if not isinstance(destagger, (bool, np.bool_)):
        return Stagger(np.asarray(destagger[0], np.int64), int(destagger[1]))
    if not destagger:
        return None
    stagger = points.stagger if isinstance(points, Scan) else points.get("stagger")
    if stagger is None:
        raise InputError(
            "the azimuth offsets of the sensor are unknown (no manifest, or ring and column were not read): give destagger=False for columns as the "
            "sensor fires them, or destagger=dataset.stagger(sensor)"
        )
    return stagger


def spherical_projection(points: Points, rings: int, columns: int, elevation: tuple[float, float]) -> Projection:
    """Assigns points to pixels by their angles as seen from the sensor's origin, with `rings` rows and `columns`
    columns.

    `elevation` is the lowest and the highest angle (rad), which are the lower and upper edge of the image; points
    beyond are in no pixel. Columns go from the azimuth pi on the left to -pi on the right, so that the middle column is
    the direction of x. If several points are in a pixel, the nearest is shown.
    """
    low, high = elevation
    if not (low < high and rings > 0 and columns > 0):
        raise InputError("spherical_projection() needs rows, columns, and a lowest elevation below the highest")
    xyz = _dense_arrays(points)["xyz"].astype(np.float64)
    distance = np.linalg.norm(xyz, axis=1)
    point_elevation = np.arctan2(xyz[:, 2], np.hypot(xyz[:, 0], xyz[:, 1]))
    row = np.floor((high - point_elevation) / (high - low) * rings)
    row[point_elevation == low] = rings - 1
    column = np.floor((0.5 - np.arctan2(xyz[:, 1], xyz[:, 0]) / (2 * np.pi)) * columns) % columns
    inside = (row >= 0) & (row < rings) & (distance > 0)
    pixel = np.where(inside, row * columns + column, -1).astype(np.int64)
    return Projection(pixel, (rings, columns), np.argsort(distance, kind="stable"))


def range_image(
    points: Points,
    rings: int = 0,
    columns: int = 0,
    channels: Sequence[str] = ("range",),
    return_: int = 1,
    fill: float = 0,
    destagger: bool | Stagger = True,
) -> NDArray[np.float32]:
    """Returns an image float32 (k, rings, columns) of k channels: "x", "y", "z", "range" (m) or names of columns.

    Pixels without a return get the value `fill`. The other arguments are those of beam_projection(). For labels, use
    the image() of a beam_projection() instead, which keeps their type.
    """
    names = names_in("channels", channels)
    if isinstance(points, Scan):
        points = points.dense()
    projection = beam_projection(points, rings, columns, return_, destagger)
    arrays = _dense_arrays(points)
    image = np.empty((len(names), *projection.index.shape), np.float32)
    for out, name in zip(image, names):
        out[:] = projection.image(channel(arrays, name).astype(np.float32), fill)
    return image
