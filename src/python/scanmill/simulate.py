"""Scans scenes without writing files, for notebooks and for programs that choose the next pose themselves."""

from __future__ import annotations

import json
import os
import re
import threading
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Union

from ._core import InputError, Simulator
from .geometry import Pose, pose_matrix, quaternion_of
from .dataset import Path
from .ontology import Ontology
from .scan import Scan
from .words import advice

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
    described: dict[str, Any] = dict(preset) if isinstance(preset, Mapping) else {"preset": os.fspath(preset)}
    if name is not None:
        described["name"] = name
    if mount is not None:
        described["mount"] = dict(mount)
    return {**described, **overrides}


class Scene:
    """A scene that can be scanned from any pose. Threads can share it. Pickling stores only the arguments of
    load_scene()."""

    def __init__(self, path: Path, seed: int = 1, labels: str | None = None, moving: bool = True) -> None:
        """See load_scene(). Relative paths start at the current folder."""
        self.path = os.fspath(path)
        self.seed = seed
        self.labels = labels
        self.moving = moving
        self.folder = os.getcwd()
        self._lock = threading.Lock()
        self._simulators: OrderedDict[str, Simulator] = OrderedDict()

    def scan(
        self,
        sensor: Sensor | Sequence[Sensor],
        pose: Pose,
        method: Method = "ray_tracing",
        effects: Effects = None,
        columns: Sequence[str] | None = None,
        time: float = 0.0,
        frame: int = 0,
        seed: int = 1,
        organised: bool = False,
    ) -> Any:
        """Scans one revolution of a sensor and returns a Scan. If `sensor` is a list, returns a list of Scans in its
        order.

        pose       of the vehicle in the world, a matrix (4, 4) or map (see sensor()); the vehicle stands still
        sensor     a result of sensor(), or the name of a preset; its mount is relative to the vehicle
        method     a name, or {name: its keys}
        effects    None: exact hits of the beams; "sensor": the effects in the sensor's file; or a list as in pipelines
        columns    names; None: the default columns of datasets. There is an intensity only if `effects` set one
        time       s since the start of the drive; determines the places of moving objects
        frame      selects the noise: the same scene, sensors, seed and frame give the same noise
        organised  True: an image of (planes * rings, columns) with NaN for beams without a return

        The first scan with a new combination of sensors, method, effects, columns, seed and layout loads the scene and
        sets up the method, which takes seconds for large scenes. The four combinations that were used last are cached.
        Raises InputError for errors in the arguments and in the scene's file.
        """
        single = isinstance(sensor, (str, Mapping))
        sensors = [sensor] if single else list(sensor)  # type: ignore[list-item,arg-type]
        matrix = pose_matrix(pose)
        simulator = self._simulator(self._pipeline(sensors, method, effects, columns, seed, organised))
        given = simulator.scan(quaternion_of(matrix).tolist(), matrix[:3, 3].tolist(), time, frame)
        scans = [
            self._scan_of(name, size, arrays, method, time)
            for name, size, arrays in zip(simulator.sensors, simulator.sizes, given)
        ]
        for scan in scans:
            _require_columns(scan, columns)
        return scans[0] if single else scans

    @cached_property
    def ontology(self) -> Ontology:
        """The classes of the scene's labels. Loads the scene if no scan has been made yet."""
        with self._lock:
            ready = next(reversed(self._simulators.values()), None)
        if ready is None:
            # Loading needs a sensor; one with a single beam is the cheapest.
            few = {"columns": 1, "rate_hz": 10, "elevation_deg": [0], "range_m": [1, 100]}
            ready = self._simulator(self._pipeline([few], "ray_tracing", None, None, 1, False))
        return Ontology(json.loads(ready.classes))

    def __repr__(self) -> str:
        return f"<Scene {self.path}, seed {self.seed}>"

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k not in ("_lock", "_simulators")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = threading.Lock()
        self._simulators = OrderedDict()

    def _pipeline(
        self,
        sensors: Sequence[Sensor],
        method: Method,
        effects: Effects,
        columns: Sequence[str] | None,
        seed: int,
        organised: bool,
    ) -> str:
        """Returns the text of a pipeline in JSON, which is also YAML. The text is the key of its simulator in the
        cache."""
        if not sensors:
            raise InputError("the list of sensors is empty")
        if isinstance(columns, str):
            raise InputError(f"columns must be a list of names, not '{columns}'")
        output: dict[str, Any] = {"layout": "organised" if organised else "dense", "formats": ["pcd"]}
        if columns is not None:
            output["columns"] = list(columns)
        pipeline: dict[str, Any] = {
            "name": "simulation",
            "seed": seed,
            "scenes": [{"scene": self.path, "seeds": [self.seed], "moving": self.moving}],
            "trajectories": [{"name": "here", "poses": [{"position": [0, 0, 0]}]}],
            "sensors": [{"preset": s} if isinstance(s, str) else dict(s) for s in sensors],
            "method": method if isinstance(method, str) else dict(method),
            "effects": effects if isinstance(effects, str) else list(effects or []),
            "output": output,
        }
        if self.labels is not None:
            pipeline["labels"] = os.fspath(self.labels)
        try:
            return json.dumps(pipeline, ensure_ascii=False, allow_nan=False, default=_plain)
        except (TypeError, ValueError) as e:
            raise InputError(f"a description may contain only texts, finite numbers, lists and maps: {e}") from None

    def _simulator(self, pipeline: str) -> Simulator:
        # Other threads wait while a simulator is loaded, so that none is loaded twice.
        with self._lock:
            if pipeline not in self._simulators:
                while len(self._simulators) >= MOST_SIMULATORS:
                    self._simulators.popitem(last=False)
                try:
                    self._simulators[pipeline] = Simulator(pipeline, self.folder)
                except InputError as e:
                    # Users do not know the pipeline's text, so its name, lines and columns are removed from the message.
                    ours = re.escape(os.path.join(self.folder, "simulation.yaml")) + r"(:\d+)*"
                    raise InputError(re.sub(ours, "scan()", str(e))) from None
            self._simulators.move_to_end(pipeline)
            return self._simulators[pipeline]

    @staticmethod
    def _scan_of(name: str, size: tuple[int, int], arrays: dict[str, Any], method: Method, time: float) -> Scan:
        return Scan(
            {key: values for key, values in arrays.items() if key != "world_from_sensor"},
            sensor=name,
            method=method if isinstance(method, str) else next(iter(method)),
            start_time=time,
            poses=arrays["world_from_sensor"],
            rings=size[0],
            columns=size[1],
        )


def _plain(value: Any) -> Any:
    """Converts numbers and arrays of numpy to values that JSON allows, and paths to texts."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return os.fspath(value)


def _require_columns(scan: Scan, columns: Sequence[str] | None) -> None:
    for name in columns or []:
        if name in scan:
            continue
        why = ": give it effects, such as ['intensity']" if name == "intensity" else advice(name, scan.names)
        raise InputError(f"the scan has no column '{name}'{why}")
