"""Recordings from another program's depth cameras, for `scanmill generate --from-passes`."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._core import InputError
from .dataset import Path
from .geometry import Pose, pose_matrix, quaternion_of
from .words import require_known

# For each camera of the cube the axes of its image (right, down) and its line of sight, in the sensor's axes (x
# forward, y left, z up): the front view, and the views after turning it to the side, up or down.
CAMERAS = {
    "front": ((0, -1, 0), (0, 0, -1), (1, 0, 0)),
    "left": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "back": ((0, 1, 0), (0, 0, -1), (-1, 0, 0)),
    "right": ((-1, 0, 0), (0, 0, -1), (0, -1, 0)),
    "up": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "down": ((0, -1, 0), (-1, 0, 0), (0, 0, -1)),
}


class PassWriter:
    """Writes the images of six depth cameras, the faces of a cube about a sensor, as a recording of passes.

        with scanmill.PassWriter("cubes", "os1_128") as writer:
            writer.add(pose, depth={"front": ..., "left": ..., "back": ..., "right": ..., "up": ..., "down": ...})

    The recording belongs to a pipeline with this sensor under the name `top`. Each image is square and spans 90
    degrees; cameras that see no beam may be left out. The images of a side are upright; `up` and `down` are what the
    front camera sees when it is tilted up or down by 90 degrees.
    """

    def __init__(
        self, folder: Path, sensor: Path | Mapping[str, Any], *, name: str = "top", scene: str = "cameras"
    ) -> None:
        """`folder`: absent or empty. `sensor`: a description by scanmill.sensor(), or the name of a preset. `scene`:
        a part of the names of samples. Raises InputError."""
        described = dict(sensor) if isinstance(sensor, Mapping) else {"preset": os.fspath(sensor)}
        self._recorder = _core.PassRecorder(os.path.abspath(folder), name, json.dumps(described), os.getcwd(), scene)
        self._frames = 0

    def add(
        self,
        pose: Pose,
        depth: Mapping[str, ArrayLike],
        *,
        semantic: Mapping[str, ArrayLike] | None = None,
        instance: Mapping[str, ArrayLike] | None = None,
        reflectance: Mapping[str, ArrayLike] | None = None,
        normal: Mapping[str, ArrayLike] | None = None,
        time: float | None = None,
        along_rays: bool = False,
        depth_unit: float | None = None,
    ) -> None:
        """Adds a frame: for each camera of `depth` an image (n, n), row 0 at the top.

        `pose`: of the sensor in the world. `depth`: m along the camera's axis, or with `along_rays` from the camera to
        the surface; infinite, NaN or 0 if the pixel shows no surface. Such pixels have no return; at least one pixel of
        a frame must show a surface. `depth_unit`: metres per unit of `depth`; by default 0.001 for images of integers,
        else 1. In images of integers, pixels with the greatest value of the type show no surface either, since depths
        saturate at it; nor do pixels with 65535 if no value is greater, since a wider type may store a 16-bit image.
        `semantic`: class ids; `instance`: ids of things, 0 for none; `reflectance`: 0 to 1 at the sensor's wavelength
        (0.3 if not given); `normal`: (n, n, 3) unit vectors in world axes, by default the normals of the surface
        through the depths of neighbouring pixels. `time`: s since the start of the drive, by default 0.1 s times the
        frame's number. Raises InputError, which names the camera and the array.
        """
        world_from_sensor = pose_matrix(pose)
        for camera in depth:
            require_known("camera", camera, CAMERAS)
        if not depth:
            raise InputError("depth needs the image of at least one camera")
        for camera, given in depth.items():
            z = _depths(given, depth_unit, f"depth of '{camera}'")
            if (z < 0).any():
                raise InputError(f"depth of '{camera}' has {np.count_nonzero(z < 0)} negative values: depths are m in front of it")
            n = len(z)
            world_from_camera = world_from_sensor.copy()
            world_from_camera[:3, :3] = world_from_sensor[:3, :3] @ np.array(CAMERAS[camera], float).T
            side = (np.arange(n) + 0.5) * (2 / n) - 1
            rays = np.stack([*np.meshgrid(side, side), np.ones((n, n))], axis=-1)
            z = np.where(np.isfinite(z) & (z > 0), z, np.inf)
            if along_rays:
                z = (z / np.linalg.norm(rays, axis=-1)).astype(np.float32)
            if normal is not None:
                normals = _values(normal, camera, "normal", np.float32, (n, n, 3), 0)
            else:
                normals = (_normals(rays * z[..., np.newaxis]) @ world_from_camera[:3, :3].T).astype(np.float32)
            self._recorder.image(
                camera,
                _row(world_from_camera),
                n,
                z,
                np.where(np.isfinite(z)[..., np.newaxis], normals, 0),
                _values(semantic, camera, "semantic", np.uint16, (n, n), 0),
                _values(instance, camera, "instance", np.uint32, (n, n), 0),
                _values(reflectance, camera, "reflectance", np.float32, (n, n), 0.3),
            )
        self._recorder.frame(_row(world_from_sensor), 0.1 * self._frames if time is None else float(time))
        self._frames += 1

    def close(self) -> None:
        """Completes the recording. Until this call the folder is not a valid recording."""
        if self._frames == 0:
            raise InputError("a recording needs at least one frame: add() one")
        self._recorder.finish()

    def __enter__(self) -> PassWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()


def _row(matrix: NDArray[np.float64]) -> list[float]:
    return [*quaternion_of(matrix).tolist(), *matrix[:3, 3].tolist()]


def _depths(values: ArrayLike, unit: float | None, what: str) -> NDArray[np.float32]:
    """Returns an image of depths in m; infinite where an image of integers is saturated."""
    image = np.asarray(values)
    if image.ndim != 2 or image.shape[0] != image.shape[1] or len(image) < 2 or image.dtype.kind not in "fui":
        raise InputError(f"{what} must be a square image of numbers (n, n), not {image.dtype} {image.shape}")
    is_integer = image.dtype.kind != "f"
    scale = (0.001 if is_integer else 1.0) if unit is None else unit
    if not (isinstance(scale, (int, float)) and scale > 0):
        raise InputError(f"depth_unit must be a number of m above 0, not {unit!r}")
    greatest = image.max(where=np.isfinite(image), initial=0)
    saturated = (image == greatest) & (is_integer and greatest in (np.iinfo(image.dtype).max, 65535))
    depths = np.where(saturated, np.inf, image * float(scale)).astype(np.float32)
    sky = np.count_nonzero(image == greatest)
    if not is_integer and sky > 1 and abs(float(greatest) * scale - 65.535) < 1e-5:
        raise InputError(
            f"{what} has {sky} pixels at 65.535 m, the greatest number of millimetres in 16 bits: give the image of "
            "integers itself, or set pixels without a surface to infinity"
        )
    return depths


def _values(
    given: Mapping[str, ArrayLike] | None, camera: str, what: str, kind: Any, shape: tuple[int, ...], otherwise: float
) -> NDArray[Any]:
    """Returns the camera's image in `given` as an array of the type `kind`, which must have this shape. If `given` is
    None, returns an array filled with `otherwise`."""
    if given is None:
        return np.full(shape, otherwise, kind)
    if camera not in given:
        raise InputError(f"{what} has no image of the camera '{camera}'")
    image = np.asarray(given[camera])
    if image.shape != shape:
        raise InputError(f"{what} of '{camera}' must have the shape {shape}, as its depth, not {image.shape}")
    is_integer = np.issubdtype(kind, np.integer)
    if is_integer and (image.dtype.kind not in "ui" or image.min() < 0 or image.max() > np.iinfo(kind).max):
        raise InputError(f"{what} of '{camera}' must be whole numbers from 0 to {np.iinfo(kind).max}")
    return image.astype(kind)


def _normals(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns unit normals (n, n, 3) in camera axes, towards the camera, of the surface through the points of
    neighbouring pixels. Uses the neighbour of more similar depth along each axis, so that steps between surfaces do not
    affect the normals."""

    points = np.where(np.isfinite(points), points, 1e9)

    def slope(axis: int) -> NDArray[np.float64]:
        ahead, behind = np.full_like(points, np.inf), np.full_like(points, np.inf)
        step = np.diff(points, axis=axis)
        cut = [slice(None)] * 3
        cut[axis] = slice(None, -1)
        ahead[tuple(cut)] = step
        cut[axis] = slice(1, None)
        behind[tuple(cut)] = step
        nearer = np.abs(ahead[..., 2:]) <= np.abs(behind[..., 2:])
        return np.where(nearer, ahead, behind)

    normal = np.cross(slope(0), slope(1))
    normal *= np.where(np.sum(normal * points, axis=-1, keepdims=True) > 0, -1, 1)
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    lost = ~(np.isfinite(size) & (size > 0))
    return np.where(lost, [0.0, 0.0, -1.0], normal / np.where(lost, 1, size))
