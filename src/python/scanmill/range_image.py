"""Range images: points as images of the sensor's rings and columns, and back.

The sensor's own ring and column say exactly where a point belongs, whatever the noise and the offsets of the beams: no
projection is needed, and none of the holes and collisions that one makes. Row r is ring r and column c the one that
fires as number c; see `top_down` and `clockwise` of the manifest's sensor for which way is up and left. Points without
ring and column, as of other programs, are projected by their angles.

Functions take a Scan, or a dictionary of arrays such as a sample of ScanDataset.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .scan import Scan, channel

Points = Union[Scan, Mapping[str, Any]]


def _dense_arrays(points: Points) -> dict[str, Any]:
    if isinstance(points, Scan):
        return points.dense().arrays()
    if points["xyz"].ndim != 2:
        raise InputError("a range image needs dense points (N, 3) or a Scan")
    return dict(points)


class Projection:
    """Which point lies in which pixel.

    Attributes, of H x W pixels and N points of the scan without its misses (scan.dense()):
      index  int64 (H, W): the point that the pixel shows, -1 where there is none
      pixel  int64 (N,): row * W + column of the pixel that the point lies in, whether or not that shows it; -1 where it
             lies in none
    """

    def __init__(self, pixel: NDArray[np.int64], shape: tuple[int, int], order: NDArray[np.int64]) -> None:
        """`order` holds indices of points; of those in one pixel the first in this order is shown."""
        self.pixel = pixel
        shown = order[pixel[order] >= 0]
        index = np.full(shape[0] * shape[1], -1, np.int64)
        index[pixel[shown]] = shown
        if np.count_nonzero(index >= 0) < len(shown):  # some share a pixel: numpy may keep any
            pixels, first = np.unique(pixel[shown], return_index=True)
            index[pixels] = shown[first]
        self.index: NDArray[np.int64] = index.reshape(shape)

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Which pixels show a point, bool (H, W)."""
        return self.index >= 0

    def image(self, values: NDArray[Any], fill: float = 0) -> NDArray[Any]:
        """An image (H, W, ...) of values of the points (N, ...), in their type; `fill` where there is no point."""
        if not len(values):
            return np.full((*self.index.shape, *values.shape[1:]), fill, values.dtype)
        out = values.take(self.index, axis=0)  # where there is no point, the last one's for now
        out[~self.mask] = fill
        return out

    def points(self, image: NDArray[Any], fill: float = 0) -> NDArray[Any]:
        """The inverse: for each point (N, ...) what an image (H, W, ...) has in its pixel; `fill` for points in none.

        Points that share a pixel with a shown one get its value too.
        """
        out = np.full((len(self.pixel), *image.shape[2:]), fill, image.dtype)
        inside = self.pixel >= 0
        out[inside] = image.reshape(-1, *image.shape[2:])[self.pixel[inside]]
        return out


def beam_projection(points: Points, rings: int = 0, columns: int = 0, return_: int = 1) -> Projection:
    """Pixels by the columns `ring` and `column`: exact.

    `rings` x `columns` are the sensor's; a Scan of a dataset knows them. `return_` chooses which return of a beam is
    shown: 1 the nearest. Raises InputError where points have no ring and column, where these do not fit into the image,
    and for another return of points without the column `return`.
    """
    if isinstance(points, Scan):
        rings, columns = rings or points.rings, columns or points.columns
    arrays = _dense_arrays(points)
    if rings < 1 or columns < 1:
        raise InputError("the numbers of rings and columns of the sensor are unknown: give rings and columns")
    if "ring" not in arrays or "column" not in arrays:
        raise InputError("the points have no columns ring and column: use spherical_projection() without them")
    ring, column = arrays["ring"].astype(np.int64), arrays["column"].astype(np.int64)
    if ring.size and (ring.max() >= rings or column.max() >= columns):
        raise InputError(f"ring {ring.max()} or column {column.max()} is not in an image of {rings} x {columns}")
    pixel = ring * columns + column
    if "return" in arrays:
        pixel[arrays["return"] != return_] = -1
    elif return_ != 1:
        raise InputError(f"return number {return_} cannot be selected: the points have no column `return`")
    return Projection(pixel, (rings, columns), np.arange(len(pixel)))


def spherical_projection(points: Points, rings: int, columns: int, elevation: tuple[float, float]) -> Projection:
    """Pixels by the angles of the points as seen from the sensor's origin, `rings` rows and `columns` columns.

    `elevation` are the lowest and the highest angle (rad), of the image's lower and upper edge; points beyond lie in no
    pixel. Columns go from the azimuth pi at the left to -pi at the right, so that the middle looks along x and left is
    left. Of several points in a pixel the nearest is shown.
    """
    low, high = elevation
    if not (low < high and rings > 0 and columns > 0):
        raise InputError("spherical_projection() needs rows, columns, and a lowest elevation below the highest")
    xyz = _dense_arrays(points)["xyz"].astype(np.float64)
    distance = np.linalg.norm(xyz, axis=1)
    up = np.arctan2(xyz[:, 2], np.hypot(xyz[:, 0], xyz[:, 1]))
    row = np.floor((high - up) / (high - low) * rings)
    row[up == low] = rings - 1
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
) -> NDArray[np.float32]:
    """An image float32 (k, rings, columns) of k channels: "x", "y", "z", "range" (m) and names of columns.

    `fill` stands where a beam has no return. See beam_projection() for the rest, and use it for labels: its image()
    keeps their type.
    """
    if isinstance(channels, str):
        raise InputError(f"channels must be a list of names, not '{channels}'")
    if isinstance(points, Scan):
        rings, columns, points = rings or points.rings, columns or points.columns, points.dense()
    arrays = _dense_arrays(points)
    projection = beam_projection(arrays, rings, columns, return_)
    image = np.empty((len(channels), *projection.index.shape), np.float32)
    for out, name in zip(image, channels):
        out[:] = projection.image(channel(arrays, name).astype(np.float32), fill)
    return image
