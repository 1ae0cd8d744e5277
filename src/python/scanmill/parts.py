"""Parts of scenes, given as arrays: checks them and groups their triangles by class, material and thing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import InputError
from .geometry import Pose, pose_matrix
from .words import require_known

PART_KEYS = ("name", "mesh", "vertices", "triangles", "class", "material", "instance", "color", "reflectance", "pose")
STEPS_OF_REFLECTANCE = 1000  # reflectances are rounded to 1 / 1000, so that equal ones share a material
FAR = 1000.0  # m; meshes farther from their origin are moved to it, since vertices are stored as float32

Part = Union[Mapping[str, Any], Any]


def part_of(given: Part, name: str = "", pose: Optional[Pose] = None, **keys: Any) -> dict[str, Any]:
    """Returns a part as the simulator takes it. For `given` and `keys` see Scene.add(). Raises InputError, which names
    the part, the array and the row."""
    values: dict[str, Any] = dict(given) if isinstance(given, Mapping) else {"mesh": given}
    values.update({key: value for key, value in keys.items() if value is not None})
    if "label" in values:
        values["class"] = values.pop("label")
    for key in values:
        require_known("key of a part", "triangles" if key == "faces" else key, PART_KEYS)
    name = str(name or values.get("name", ""))
    if not name:
        raise InputError("a part needs a name: give it the key `name`")
    try:
        return _checked(name, values, pose if pose is not None else values.get("pose", np.eye(4)))
    except InputError as e:
        raise InputError(f"part '{name}': {e}") from None


def _checked(name: str, values: dict[str, Any], pose: Pose) -> dict[str, Any]:
    vertices, triangles, colours = _geometry(values)
    count = len(triangles)
    classes, class_of = _words("class", values.get("class"), count)
    materials, material_of = _words("material", values.get("material", "default"), count)
    reflectance_of = _reflectances(values, colours, triangles, len(vertices))
    things_of = _things(values.get("instance"), count)
    rows = np.stack([class_of, material_of, reflectance_of, things_of], axis=1)
    surfaces, surface_of = np.unique(rows, axis=0, return_inverse=True)
    if len(surfaces) > 65535:
        raise InputError("more than 65535 combinations of class, material, reflectance and instance: split the part")
    matrix = pose_matrix(pose)
    # Objects in map coordinates would lose millimetres as float32.
    if np.abs(vertices).max() > FAR:
        middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        vertices = vertices - middle
        matrix[:3, 3] += matrix[:3, :3] @ middle
    return {
        "name": name,
        "vertices": vertices.astype(np.float32),
        "triangles": triangles.astype(np.uint32),
        "surface_of": surface_of.reshape(-1).astype(np.uint16),
        "surfaces": [
            (classes[c], materials[m], None if r < 0 else r / STEPS_OF_REFLECTANCE, int(thing))
            for c, m, r, thing in surfaces
        ],
        "pose": matrix,
    }


def _geometry(values: dict[str, Any]) -> tuple[NDArray[Any], NDArray[Any], Optional[NDArray[Any]]]:
    for one, other in (("triangles", "faces"), ("mesh", "vertices"), ("mesh", "triangles"), ("mesh", "faces")):
        if one in values and other in values:
            raise InputError(f"give {one} or {other}, not both")
    mesh = values.get("mesh")
    vertices = values.get("vertices", getattr(mesh, "vertices", None))
    triangles = values.get("triangles", values.get("faces", getattr(mesh, "triangles", getattr(mesh, "faces", None))))
    if vertices is None or triangles is None:
        raise InputError("a part needs `vertices` and `triangles`, or a `mesh` that has them (Open3D, trimesh)")
    vertices = _numbers("vertices", vertices, np.float64)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) == 0:
        hint = ": transpose them" if vertices.ndim == 2 and vertices.shape[0] == 3 else ""
        hint = ": leave out the fourth column" if vertices.ndim == 2 and vertices.shape[1] == 4 else hint
        raise InputError(f"vertices must have the shape (n, 3), not {vertices.shape}{hint}")
    _require("vertices", np.isfinite(vertices).all(axis=1), vertices, "is not finite")
    if np.size(triangles) == 0:
        raise InputError("there is no triangle")
    triangles = _integers("triangles", triangles)
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        hint = ": divide each quad into two" if triangles.ndim == 2 and triangles.shape[1] == 4 else ""
        raise InputError(f"triangles must have the shape (m, 3), not {triangles.shape}{hint}")
    inside = ((triangles >= 0) & (triangles < len(vertices))).all(axis=1)
    _require("triangles", inside, triangles, f"has an index outside of 0 to {len(vertices) - 1}")
    return vertices, triangles, _colours_of(mesh)


def _colours_of(mesh: Any) -> Optional[NDArray[Any]]:
    """Returns the colours that an object of Open3D or trimesh has; None if it has none."""
    visual = getattr(mesh, "visual", None)
    for holder, names in ((mesh, ("vertex_colors",)), (visual, ("face_colors", "vertex_colors"))):
        kind = getattr(holder, "kind", None)
        for name in names:
            if holder is visual and (kind is None or not name.startswith(kind)):
                continue
            colours = getattr(holder, name, None)
            if colours is not None and len(colours) > 0:
                return np.asarray(colours)
    return None


def _words(key: str, given: Any, count: int) -> tuple[list[str], NDArray[np.int64]]:
    """Returns the distinct words of a key, and the index of each triangle's word."""
    if given is None:
        raise InputError(f"a part needs a {key}: one name, or an array with a name for each triangle")
    if isinstance(given, str):
        return [given], np.zeros(count, np.int64)
    words = np.asarray(given)
    if words.shape != (count,) or words.dtype.kind not in "UO":
        raise InputError(
            f"{key} must be one name, or an array of {count} names, one for each triangle; numbers of classes are no "
            "names"
        )
    distinct, index = np.unique(words.astype(str), return_inverse=True)
    return [str(word) for word in distinct], index.reshape(-1).astype(np.int64)


def _things(given: Any, count: int) -> NDArray[np.int64]:
    """Returns for each triangle the number of its thing, from 1, or 0 for a triangle of no thing. -1: the class decides
    whether the part is a thing."""
    if given is None:
        return np.full(count, -1, np.int64)
    numbers = _integers("instance", given)
    if numbers.ndim == 0:
        numbers = np.full(count, int(numbers))
    if numbers.shape != (count,):
        raise InputError(f"instance must be one number, or an array of {count} numbers, one for each triangle")
    _require("instance", numbers >= 0, numbers, "is negative")
    distinct, index = np.unique(numbers, return_inverse=True)
    return index.reshape(-1).astype(np.int64) + (0 if distinct[0] == 0 else 1)


def _reflectances(
    values: dict[str, Any], colours: Optional[NDArray[Any]], triangles: NDArray[Any], vertices: int
) -> NDArray[np.int64]:
    """Returns the reflectance of each triangle times STEPS_OF_REFLECTANCE, rounded; -1: its material's reflectance."""
    count = len(triangles)
    given = values.get("reflectance")
    if given is not None and values.get("color") is not None:
        raise InputError("give reflectance or color, not both")
    if given is not None:
        reflectance = _numbers("reflectance", given, np.float64)
        if reflectance.shape not in ((), (count,)):
            raise InputError(f"reflectance must be one number, or an array of {count}, one for each triangle")
        reflectance = np.broadcast_to(reflectance, count)
        _require("reflectance", (reflectance >= 0) & (reflectance <= 1), reflectance, "is not between 0 and 1")
    else:
        colours_of_part = values.get("color", colours if "material" not in values else None)
        if colours_of_part is None:
            return np.full(count, -1, np.int64)
        reflectance = _brightness(_numbers("color", colours_of_part, None), triangles, vertices)
    return np.round(np.asarray(reflectance) * STEPS_OF_REFLECTANCE).astype(np.int64)


def _brightness(colour: NDArray[Any], triangles: NDArray[Any], vertices: int) -> NDArray[np.float64]:
    """Returns the linear luminance of sRGB colours, for each triangle. Integers are from 0 to 255, floating-point
    numbers from 0 to 1. The luminances of vertices are averaged over a triangle's corners."""
    if colour.shape[-1:] not in ((3,), (4,)) or colour.ndim > 2:
        raise InputError(f"color must have the shape (3,), (triangles, 3) or (vertices, 3), not {colour.shape}")
    if colour.dtype.kind in "iu" and colour.dtype != np.uint8 and 0 < colour.max() <= 1:
        raise InputError("color: integers are from 0 to 255: for white write 255 or 1.0")
    srgb = colour[..., :3] / 255.0 if colour.dtype.kind in "iu" else colour[..., :3].astype(np.float64)
    good = np.isfinite(srgb).all(axis=-1) & (srgb >= 0).all(axis=-1) & (srgb <= 1).all(axis=-1)
    _require("color", np.atleast_1d(good), np.atleast_2d(colour), "is not between 0 and 1 (integers: 0 and 255)")
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    if luminance.ndim == 0 or len(luminance) == len(triangles):
        return np.broadcast_to(luminance, len(triangles))
    if len(luminance) == vertices:
        mean: NDArray[np.float64] = luminance[triangles].mean(axis=1)
        return mean
    raise InputError(
        f"color has {len(luminance)} rows, but the part has {len(triangles)} triangles and {vertices} vertices"
    )


def _numbers(key: str, given: ArrayLike, kind: Any) -> NDArray[Any]:
    try:
        array = np.asarray(given)
    except (TypeError, ValueError):
        raise InputError(f"{key} must be an array of numbers, with rows of equal length") from None
    if array.dtype.kind not in "iuf":
        raise InputError(f"{key} must be an array of numbers, not of {array.dtype}")
    return array if kind is None else array.astype(kind)


def _integers(key: str, given: ArrayLike) -> NDArray[np.int64]:
    array = _numbers(key, given, None)
    if array.dtype.kind == "f":
        raise InputError(f"{key} must be integers, not {array.dtype}: use .astype(int)")
    return array.astype(np.int64)


def _require(key: str, good: NDArray[np.bool_], rows: NDArray[Any], why: str) -> None:
    bad = np.flatnonzero(~good)
    if len(bad) > 0:
        more = f" (and {len(bad) - 1} more rows)" if len(bad) > 1 else ""
        raise InputError(f"{key}[{bad[0]}] = {np.asarray(rows)[bad[0]].tolist()} {why}{more}")
