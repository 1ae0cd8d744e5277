"""Scans of a scene, without files: from a notebook, or wherever a program wants to look next."""

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

MOST_SIMULATORS = 4  # that a scene keeps; each holds the geometry and the method's structures


def load_scene(path: Path, seed: int = 1, labels: str | None = None, moving: bool = True) -> Scene:
    """A scene by its file, or by the name of one of the program's, such as "town".

    `seed` chooses what is procedural in it, `labels` an ontology in place of the scene's own (a file, or a name such as
    "semantic_kitti"). moving=False: things that move stand where they are at first, so that every method can trace the
    scene. Nothing is read before the first scan.
    """
    return Scene(path, seed, labels, moving)


def sensor(
    preset: Path | Mapping[str, Any],
    name: str | None = None,
    mount: Mapping[str, Any] | None = None,
    **overrides: Any,
) -> dict[str, Any]:
    """A sensor as pipelines describe it (docs/keys.md, Sensor).

    `preset` is a sensor's file, the name of one of the program's ("os1_128"), or a map of keys that needs no preset.
    `mount` is a pose on the vehicle: a map with position (m), yaw_deg and so on. `overrides` replace keys of the
    preset: sensor("vlp_16", columns=450). A wrong key is refused by the first scan.
    """
    described: dict[str, Any] = dict(preset) if isinstance(preset, Mapping) else {"preset": os.fspath(preset)}
    if name is not None:
        described["name"] = name
    if mount is not None:
        described["mount"] = dict(mount)
    return {**described, **overrides}


class Scene:
    """A scene that can be scanned from anywhere. Threads can share one; it pickles by what it was loaded from."""

    def __init__(self, path: Path, seed: int = 1, labels: str | None = None, moving: bool = True) -> None:
        """See load_scene(). Relative names of files start at the current folder."""
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
        """One revolution of a sensor: a Scan; a list of them where `sensor` is a list, in its order.

        pose       of the vehicle in the world, (4, 4) or a map as of a sensor's mount; it stands still meanwhile
        sensor     as sensor() describes it, or the name of a preset; its mount is relative to the vehicle
        method     a name, or {name: its keys}
        effects    None for what beams meet, exactly; "sensor" for what the sensor's file states; or a list as pipelines
                   have it
        columns    names; None for those that datasets have by default. There is an intensity where `effects` make one
        time       s since the start of the drive: where things that move are
        frame      which noise; the same scene, sensors, seed and frame give the same noise
        organised  True for an image of (planes * rings, columns) with NaN where beams have no return

        The first scan with another combination of sensors, method, effects, columns, seed and layout loads the scene
        and sets up the method, which takes seconds for large scenes; the four combinations that were used last stay
        ready. Raises InputError for what is wrong in any of these, the scene's file included.
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
        """The classes of the scene's labels. Loads the scene where no scan was made yet."""
        with self._lock:
            ready = next(reversed(self._simulators.values()), None)
        if ready is None:
            # Any sensor will do; one with few beams needs least.
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
        """The text of a pipeline, in JSON, which is YAML: a key of the simulator that it makes, too."""
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
        # Others wait while one is loaded, lest two load the same.
        with self._lock:
            if pipeline not in self._simulators:
                while len(self._simulators) >= MOST_SIMULATORS:
                    self._simulators.popitem(last=False)
                try:
                    self._simulators[pipeline] = Simulator(pipeline, self.folder)
                except InputError as e:
                    # Nobody has seen the pipeline's text: its name, lines and columns mean nothing.
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
    """Numbers and arrays of numpy as JSON has them, and paths as texts."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return os.fspath(value)


def _require_columns(scan: Scan, columns: Sequence[str] | None) -> None:
    for name in columns or []:
        if name in scan:
            continue
        why = ": give it effects, such as ['intensity']" if name == "intensity" else advice(name, scan.names)
        raise InputError(f"the scan has no column '{name}'{why}")
