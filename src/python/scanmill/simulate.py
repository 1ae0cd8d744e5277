"""Scans scenes without writing files. Scenes come from files or from arrays; the caller gives the poses of the vehicle
and, if wanted, of objects."""

from __future__ import annotations

import json
import operator
import os
import re
import threading
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import InputError, Simulator
from .geometry import Pose, between, pose_matrix, quaternion_of, require_rigid
from .dataset import Path
from .objects import Objects
from .ontology import Ontology
from .parts import Part, part_of
from .scan import Scan, Stagger
from .words import advice, names_in

Sensor = Union[str, Mapping[str, Any]]
Method = Union[str, Mapping[str, Any]]
Effects = Union[str, Sequence[Union[str, Mapping[str, Any]]], None]

MOST_SIMULATORS = 4  # maximum number cached by a scene; each contains the geometry and the method's data


def load_scene(path: Path, seed: int = 1, labels: str | None = None, moving: bool = True) -> Scene:
    """Returns a scene by the path of its file, or by the name of a scene that comes with the program, such as "town".

    `seed` determines the procedural parts of the scene. `labels` replaces the scene's ontology (a file, or a name such
    as "semantic_kitti"). With moving=False, moving objects stay at their positions at time 0 s, so that all methods
    can trace the scene. Nothing is read before the first scan.
    """
    return Scene(path, seed, labels, moving)


def sensor(
    preset: Path | Mapping[str, Any],
    name: str | None = None,
    mount: Mapping[str, Any] | None = None,
    **overrides: Any,
) -> dict[str, Any]:
    """Returns the description of a sensor for Scene.scan() and pipelines (docs/keys.md, Sensor).

    `preset` is a sensor file, the name of a preset that comes with the program ("os1_128"), or a map with all keys of a
    sensor. `mount` is the pose on the vehicle: a map with position (m), yaw_deg and so on. `overrides` replace keys of
    the preset: sensor("vlp_16", columns=450). Wrong keys are reported by the first scan.
    """
    description: dict[str, Any] = dict(preset) if isinstance(preset, Mapping) else {"preset": os.fspath(preset)}
    if name is not None:
        description["name"] = name
    if mount is not None:
        description["mount"] = dict(mount)
    return {**description, **overrides}


@dataclass
class SceneObject:
    """An object of a scene: all instances that share a name."""

    pose: NDArray[np.float64]  # (4, 4), world from object, without scale
    instances: list[int]  # ids in the column `instance`; empty for a class without instances, such as a road
    moves: bool  # True if the scene itself moves the object

    def __repr__(self) -> str:
        x, y, z = self.pose[:3, 3]
        return f"<SceneObject at [{x:.2f}, {y:.2f}, {z:.2f}], instances {self.instances}{', moves' * self.moves}>"


class Scene:
    """A scene that can be scanned from any pose. Threads can share it. Pickling stores the arguments of load_scene(),
    the added parts and the names of removed objects."""

    def __init__(self, path: Path, seed: int = 1, labels: str | None = None, moving: bool = True) -> None:
        """See load_scene(). Relative paths start at the current folder."""
        self.path = os.fspath(path)
        self.seed = seed
        self.labels = labels
        self.moving = moving
        self.folder = os.getcwd()
        self._lock = threading.Lock()
        self._simulators: OrderedDict[str, Simulator] = OrderedDict()
        self._parts: dict[str, dict[str, Any]] = {}
        self._removed: list[str] = []
        self._checked: tuple[set[str], list[str]] = (set(), [])  # added and removed names that the scene has taken

    @classmethod
    def from_arrays(cls, parts: Iterable[Part], labels: str | None = None) -> Scene:
        """Returns a scene of arrays. Each part is as for add(); a part without a name gets the name "part 1", "part 2"
        and so on. `labels` replaces the ontology labels/scanmill.yaml (see load_scene())."""
        if isinstance(parts, Mapping):
            raise InputError("from_arrays() needs a list of parts, not one part: [part]")
        scene = cls("empty", labels=labels)
        for number, part in enumerate(parts, start=1):
            named = isinstance(part, Mapping) and part.get("name")
            scene.add(part, **({} if named else {"name": f"part {number}"}))
        return scene

    def add(
        self,
        part: Part = None,
        name: str = "",
        pose: Pose | None = None,
        **keys: Any,
    ) -> None:
        """Adds an object to the scene. `part` is a map of these keys, which may also be arguments (`class` as `label`),
        or an object that has `vertices` and `triangles` or `faces`, such as meshes of Open3D and trimesh:

        name         of the object, for `poses` of scan(), objects() and remove(); no other object may have it
        vertices     (n, 3), m, in the object's frame: x forward, y left, z up
        triangles    (m, 3), indices of vertices; or `faces`
        mesh         an object that has both
        class        name or alias of a class of the ontology; or (m,) names, one for each triangle
        material     name of a material in labels/materials.yaml; or (m,) names. Default: "default"
        instance     (m,) integers: triangles with the same number are one thing, triangles with 0 belong to no thing;
                     the scene numbers the things anew. Default: the object is one thing if its class has instances
        reflectance  at the sensor's wavelength, 0 to 1, in place of the material's; or (m,). Rounded to 0.001
        color        sRGB (3,), (m, 3) or (n, 3), from 0 to 255 if integers, else from 0 to 1: their luminance is taken
                     as the reflectance, which is an estimate. Without `color`, `reflectance` and `material`, the
                     colours of the `mesh` are used
        pose         of the object in the world, a matrix (4, 4) or map. Default: the origin

        The scene is set up again at the next scan, which raises InputError for an unknown class or material and for a
        name that the scene has already; the part is then not added. Placing an object elsewhere does not need a new
        set-up (`poses` of scan()). Raises InputError, a ValueError, that names the part, the array and the row.
        """
        checked = part_of({} if part is None else part, name, pose, **keys)
        with self._lock:
            if checked["name"] in self._parts:
                raise InputError(f"part '{checked['name']}': the scene has an object of this name: take another name")
            self._parts[checked["name"]] = checked
            self._simulators.clear()

    def remove(self, name: str) -> None:
        """Takes the objects with a name out of the scene, or all triangles of a class. The scene is set up again at the
        next scan, which raises InputError for an unknown name; scans after that ignore the name. To leave an object out
        of one scan only, use `poses={name: None}` of scan()."""
        if not isinstance(name, str):
            raise InputError(f"remove() needs the name of an object or a class, not {name!r}")
        with self._lock:
            if self._parts.pop(name, None) is None:
                self._removed.append(name)
            self._simulators.clear()

    def objects(self, time: float = 0.0) -> dict[str, SceneObject]:
        """Returns the scene's objects by their names, at a time (s since the start of the drive)."""
        return {
            name: SceneObject(pose, things, moves)
            for name, (pose, things, moves) in sorted(self._any_simulator().objects(time).items())
        }

    @overload
    def scan(self, sensor: Sensor, pose: Pose | Sequence[Pose], *args: Any, **options: Any) -> Scan: ...
    @overload
    def scan(
        self, sensor: list[Sensor] | tuple[Sensor, ...], pose: Pose | Sequence[Pose], *args: Any, **options: Any
    ) -> list[Scan]: ...
    def scan(
        self,
        sensor: Sensor | Sequence[Sensor],
        pose: Pose | Sequence[Pose],
        method: Method = "ray_tracing",
        effects: Effects = None,
        columns: Sequence[str] | None = None,
        time: float = 0.0,
        frame: int = 0,
        seed: int = 1,
        organised: bool = False,
        poses: Mapping[str, Optional[Pose]] | None = None,
        velocities: Mapping[str, ArrayLike] | None = None,
        pose_times: ArrayLike | None = None,
        boxes: bool | str | Sequence[str] = False,
        vehicle: Path | Mapping[str, Any] | None = None,
    ) -> Scan | list[Scan]:
        """Scans one revolution of a sensor and returns a Scan. If `sensor` is a list, returns a list of Scans in its
        order.

        pose       of the vehicle in the world, a matrix (4, 4) or map (see sensor()): the vehicle stands still. Or
                   matrices (n, 4, 4): one for each column of the sensor, or those at the n `pose_times`
        sensor     a result of sensor(), or the name of a preset; its mount is relative to the vehicle
        method     a name, or {name: its keys}
        effects    None: exact hits of the beams; "sensor": the effects in the sensor's file; or a list as in pipelines
        columns    names; None: the default columns of datasets. There is an intensity only if `effects` set one
        time       s since the start of the drive; determines the places of moving objects
        frame      selects the noise: the same scene, sensors, seed and frame give the same noise
        organised  True: an image of (planes * rings, columns) with NaN for beams without a return
        poses      where objects are in this scan: {name: matrix or map}, world from object; None leaves an object out.
                   Objects that are not named are where the scene places them. A name that several copies share moves
                   all of them together; the pose is that of the first copy. Only for methods that trace moving objects
        velocities of objects in `poses` during the revolution: {name: (3,) or (6,)}: m/s and rad/s, world axes, about
                   the object's origin. An object in `poses` without a velocity stands still, even if the scene moves
                   it. The motion is interpolated linearly: if an object turns by the angle a (rad) during the
                   revolution, a point at the distance d from its origin is off its arc by up to d * a * a / 8. With
                   velocities or several poses of the vehicle, the scene's own objects move during the revolution too
        pose_times (n,) s after `time`, ascending, from 0 or less to the end of the revolution or more
        boxes      True: `scan.objects` has the boxes and visibility of the road users within the sensor's range
                   (Objects); "all": of all objects; a list: of the objects of these classes
        vehicle    the scene file of the vehicle that carries the sensors, "vehicle" for the program's own, or a map as
                   in pipelines: its surfaces block beams, and give returns with the cause 5 (column `cause`)

        The first scan with a new combination of sensors, method, effects, columns, seed, layout, boxes and vehicle
        loads the scene and sets up the method, which takes seconds for large scenes; so does the first one with
        `poses`, after which placing objects costs milliseconds. The four combinations that were used last are cached.
        Raises InputError for errors in the arguments and in the scene's file.
        """
        single = isinstance(sensor, (str, Mapping))
        pipeline = self._pipeline(sensor, method, effects, columns, seed, organised, _objects_key(boxes), vehicle)
        scans = self._run(pipeline, pose, time, frame, poses, velocities, pose_times)
        for scan in scans:
            _require_columns(scan, columns)
        return scans[0] if single else scans

    def _run(
        self,
        pipeline: str,
        pose: Pose | Sequence[Pose],
        time: float,
        frame: int,
        poses: Mapping[str, Optional[Pose]] | None,
        velocities: Mapping[str, ArrayLike] | None,
        pose_times: ArrayLike | None,
        *target: Any,
    ) -> list[Scan]:
        """Returns the scans of a pipeline's sensors; see scan(). `target`: the arguments `writer`, `drive` and `split`
        of Simulator.scan(). Returns an empty list if the writer has the sample already."""
        if not np.isscalar(time) or isinstance(time, str) or not np.isfinite(time):
            raise InputError(f"time must be a finite number, not {time!r}")
        if not hasattr(frame, "__index__") or not 0 <= operator.index(frame) < 2**32:
            raise InputError(f"frame must be a whole number of at least 0, not {frame!r}")
        placements = _placements(poses, velocities)
        simulator = self._simulator(pipeline, placeable=poses is not None)
        vehicle_poses = [  # by sensor
            _poses_of(pose, pose_times, sensor_columns, duration)
            for _, (_, sensor_columns), _, duration in simulator.sensors
        ]
        moving = any(len(rows) > 1 for rows in vehicle_poses) or bool(velocities)
        arrays_of_sensors, objects = simulator.scan(vehicle_poses, time, frame, *placements, moving, *target)
        listed = json.loads(objects)["objects"] if objects else None
        method = json.loads(pipeline)["method"]
        method_name = method if isinstance(method, str) else next(iter(method))
        return [
            self._scan_of(name, size, Stagger(*stagger), duration, arrays, method_name, time, listed)
            for (name, size, stagger, duration), arrays in zip(simulator.sensors, arrays_of_sensors)
        ]

    @property
    def ontology(self) -> Ontology:
        """The classes of the scene's labels. Loads the scene if no scan has been made yet."""
        return Ontology(json.loads(self._any_simulator().classes))

    def _any_simulator(self) -> Simulator:
        """Returns the simulator that was used last, or loads the scene."""
        with self._lock:
            latest = next(reversed(self._simulators.values()), None)
        if latest is not None:
            return latest
        # Loading needs a sensor; a single beam is the cheapest.
        beam = {"columns": 1, "rate_hz": 10, "elevation_deg": [0], "range_m": [1, 100]}
        return self._simulator(self._pipeline(beam, "ray_tracing", None, None, 1, False, {}, None))

    def __repr__(self) -> str:
        added = f", {len(self._parts)} added parts" if self._parts else ""
        return f"<Scene {self.path}, seed {self.seed}{added}>"

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k not in ("_lock", "_simulators")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = threading.Lock()
        self._simulators = OrderedDict()

    def _pipeline(
        self,
        sensor: Sensor | Sequence[Sensor],
        method: Method,
        effects: Effects,
        columns: Sequence[str] | None,
        seed: int,
        organised: bool,
        keys: Mapping[str, Any],
        vehicle: Path | Mapping[str, Any] | None,
        name: str = "simulation",
    ) -> str:
        """Returns the text of a pipeline in JSON, which is also YAML. The text is the key of its simulator in the
        cache. `keys`: further keys of `output`."""
        sensors = [sensor] if isinstance(sensor, (str, Mapping)) else list(sensor)
        if not sensors:
            raise InputError("the list of sensors is empty")
        output: dict[str, Any] = {"layout": "organised" if organised else "dense", "formats": ["pcd"], **keys}
        if columns is not None:
            output["columns"] = names_in("columns", columns)
        pipeline: dict[str, Any] = {
            "name": name,
            "seed": seed,
            "scenes": [{"scene": self.path, "seeds": [self.seed], "moving": self.moving, "without": self._removed}],
            "trajectories": [{"name": "here", "poses": [{"position": [0, 0, 0]}]}],
            "sensors": [{"preset": s} if isinstance(s, str) else dict(s) for s in sensors],
            "method": method if isinstance(method, str) else dict(method),
            "effects": effects if isinstance(effects, str) else list(effects or []),
            "output": output,
        }
        if self.labels is not None:
            pipeline["labels"] = os.fspath(self.labels)
        if vehicle is not None:
            pipeline["vehicle"] = dict(vehicle) if isinstance(vehicle, Mapping) else os.fspath(vehicle)
        try:
            return json.dumps(pipeline, ensure_ascii=False, allow_nan=False, default=_plain)
        except (TypeError, ValueError) as e:
            raise InputError(f"a description may contain only texts, finite numbers, lists and maps: {e}") from None

    def _simulator(self, pipeline: str, placeable: bool = False) -> Simulator:
        """Returns the simulator of a pipeline, which becomes the most recently used one; loads it if needed."""
        key = f"{pipeline} placeable" if placeable else pipeline
        # Other threads wait while a simulator is loaded, so that none is loaded twice.
        with self._lock:
            if key not in self._simulators:
                while len(self._simulators) >= MOST_SIMULATORS:
                    self._simulators.popitem(last=False)
                try:
                    parts = list(self._parts.values())
                    self._simulators[key] = Simulator(pipeline, self.folder, parts, placeable)
                    self._checked = ({*self._parts}, [*self._removed])
                except InputError as e:
                    self._forget(str(e))
                    # Users do not know the pipeline's text, so its name, lines and columns are removed from the message.
                    location = re.escape(os.path.join(self.folder, "simulation.yaml")) + r"(:\d+)*"
                    raise InputError(re.sub(location, "scan()", str(e))) from None
            self._simulators.move_to_end(key)
            return self._simulators[key]

    def _forget(self, message: str) -> None:
        """Undoes the add() or remove() that made the set-up of the scene fail with `message`. If the message is about
        text that the caller did not write, raises an InputError with another message."""
        added, removed = self._checked
        part = re.match(r"part '(.*?)': ", message)
        if part is not None and part[1] not in added:
            self._parts.pop(part[1], None)
        for name in self._removed[len(removed) :]:
            if "without" in message and f"'{name}'" in message:
                self._removed.remove(name)
                raise InputError(
                    f"remove(): '{name}' is neither an object of the scene (objects() lists them) nor a class"
                ) from None
        if self.path == "empty" and "objects must be a list of at least one object" in message:
            raise InputError("the scene is empty: add() an object") from None

    @staticmethod
    def _scan_of(
        name: str,
        size: tuple[int, int],
        stagger: Stagger,
        duration: float,
        arrays: dict[str, Any],
        method: str,
        time: float,
        listed: list[dict[str, Any]] | None,
    ) -> Scan:
        scan = Scan(
            {key: values for key, values in arrays.items() if key != "world_from_sensor"},
            sensor=name,
            method=method,
            start_time=time,
            poses=arrays["world_from_sensor"],
            column_starts=np.arange(size[1]) * (duration / size[1]),
            rings=size[0],
            columns=size[1],
            stagger=stagger,
        )
        if listed is not None:
            scan.objects = Objects(listed, name, arrays["world_from_sensor"][0])
        return scan


def _plain(value: Any) -> Any:
    """Converts numbers and arrays of numpy to values that JSON allows, and paths to texts."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return os.fspath(value)


def _require_columns(scan: Scan, columns: Sequence[str] | None) -> None:
    for name in columns or []:
        if name in scan:
            continue
        hint = ": give it effects, such as ['intensity']" if name == "intensity" else advice(name, scan.names)
        raise InputError(f"the scan has no column '{name}'{hint}")


def _objects_key(boxes: bool | str | Sequence[str]) -> dict[str, Any]:
    """Returns the key `objects` of a pipeline's `output`."""
    return {"objects": boxes if isinstance(boxes, bool) else {"classes": boxes}}


def _placements(
    poses: Mapping[str, Optional[Pose]] | None, velocities: Mapping[str, ArrayLike] | None
) -> tuple[list[str], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Returns the names of the objects that are placed, their poses (n, 4, 4), their velocities (n, 6), and whether
    they are left out (n,)."""
    for key, argument in (("poses", poses), ("velocities", velocities)):
        if argument is not None and not isinstance(argument, Mapping):
            raise InputError(f"{key} must be a map from names of objects, not {type(argument).__name__}")
        for name in argument or {}:
            if not isinstance(name, str):
                raise InputError(f"{key}: the name of an object must be a text, not {name!r}")
    names = list(poses or {})
    object_poses = list((poses or {}).values())
    hidden = np.array([pose is None for pose in object_poses], bool)
    matrices = np.broadcast_to(np.eye(4), (len(names), 4, 4)).copy()
    for row, pose in enumerate(object_poses):
        if isinstance(pose, np.ndarray) and pose.shape == (4, 4):
            matrices[row] = pose  # is checked with all others below, which is faster
        elif pose is not None:
            try:
                matrices[row] = pose_matrix(pose)
            except InputError as e:
                raise InputError(f"poses: '{names[row]}': {e}") from None
    try:
        require_rigid(matrices)
    except InputError as e:
        raise InputError(f"poses: '{names[e.row]}': {e}") from None  # type: ignore[attr-defined]
    speeds = np.zeros((len(names), 6))
    rows = {name: row for row, name in enumerate(names)}
    for name, velocity in (velocities or {}).items():
        if name not in rows:
            raise InputError(f"velocities: '{name}' is not in `poses`{advice(name, names)}")
        if hidden[rows[name]]:
            raise InputError(f"velocities: '{name}' is left out of the scan: its pose is None")
        try:
            speed = np.asarray(velocity, np.float64)
        except (TypeError, ValueError):
            speed = np.empty(0)
        if speed.shape not in ((3,), (6,)) or not np.isfinite(speed).all():
            raise InputError(f"velocities: '{name}' must have 3 or 6 finite numbers (m/s, rad/s)")
        speeds[rows[name], : len(speed)] = speed
    return names, matrices, speeds, hidden


def _poses_of(
    pose: Pose | Sequence[Pose], times: ArrayLike | None, columns: int, duration: float
) -> NDArray[np.float64]:
    """Returns the vehicle's poses at the columns of a sensor, or its only pose, as rows of a quaternion and a
    translation."""
    if not _are_several(pose):
        if times is not None:
            raise InputError("pose_times: there is only one pose")
        return _rows(pose_matrix(pose)[np.newaxis])  # type: ignore[arg-type]
    matrices = np.array(pose if isinstance(pose, np.ndarray) else [pose_matrix(p) for p in pose], np.float64)
    if matrices.shape[1:] != (4, 4):
        raise InputError(f"pose must be (4, 4) or (n, 4, 4), not {matrices.shape}")
    require_rigid(matrices)
    if times is None:
        if len(matrices) != columns:
            raise InputError(
                f"pose: {len(matrices)} poses, but the sensor has {columns} columns: give the times of the poses as "
                "`pose_times`"
            )
        return _rows(matrices)
    seconds = np.asarray(times, np.float64)
    if seconds.shape != (len(matrices),) or not (np.diff(seconds) > 0).all():
        raise InputError(f"pose_times must be {len(matrices)} ascending numbers, one for each pose")
    if seconds[0] > 0 or seconds[-1] < duration * (1 - 1 / columns) - 1e-9:
        raise InputError(
            f"pose_times must cover the revolution, 0 to {duration:.6g} s after `time`, not {seconds[0]:.6g} to "
            f"{seconds[-1]:.6g} s"
        )
    column_times = np.arange(columns) * (duration / columns)
    earlier = np.clip(np.searchsorted(seconds, column_times, side="right") - 1, 0, len(seconds) - 2)
    rows = np.empty((columns, 7))
    for k in np.unique(earlier):  # interpolates between the poses k and k + 1
        between_them = earlier == k
        fraction = (column_times[between_them] - seconds[k]) / (seconds[k + 1] - seconds[k])
        rows[between_them] = _rows(between(matrices[k], matrices[k + 1], fraction))
    return rows


def _are_several(pose: Any) -> bool:
    """Returns true if `pose` is a sequence of poses, false if it is one pose or none."""
    if isinstance(pose, np.ndarray):
        return pose.ndim == 3
    return isinstance(pose, (list, tuple)) and len(pose) > 0 and (isinstance(pose[0], Mapping) or np.ndim(pose[0]) == 2)


def _rows(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns the poses (n, 4, 4) as rows (n, 7) of a quaternion w, x, y, z and a translation."""
    return np.concatenate([quaternion_of(matrices), matrices[:, :3, 3]], axis=1)
