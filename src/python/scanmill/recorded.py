"""Recorded sets in the folders of SemanticKITTI, KITTI's odometry benchmark and nuScenes."""

from __future__ import annotations

import glob
import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .geometry import matrix_of, quaternion_of
from .npz import read_npz
from .words import require_known

Arrays = dict[str, NDArray[Any]]

# Splits of SemanticKITTI's sequences (Behley et al., ICCV 2019).
KITTI_SPLITS = {**{f"{n:02}": "train" for n in range(11)}, "08": "val", **{f"{n}": "test" for n in range(11, 22)}}

# Rotates x forward, y left to the axes of nuScenes' LIDAR_TOP, which are x right, y forward.
NUSCENES_FROM_FORWARD = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


@dataclass(frozen=True)
class Frame:
    """The files of one scan. An empty path stands for an absent file."""

    key: str  # SEQUENCE-FRAME
    split: str  # "" if the set has no splits, or if the sequence is in none of them
    time: float  # s, since the first frame of the sequence
    pose: NDArray[np.float64] | None  # world_from_sensor (4, 4)
    points: str
    labels: str
    panoptic: str = ""


class RecordedStore:
    """The scans of a recorded set, with the interface of _core.Store. Pickling stores the path."""

    manifest = None

    def __init__(
        self, path: str, classes: str, sensor: str, frames: Sequence[Frame], read: Callable[[Frame], Arrays]
    ) -> None:
        """`classes`: name of the ontology. `read`: returns the arrays of a frame, x forward, y left, z up."""
        self.path, self.classes, self.sensor = path, classes, sensor
        self._frames, self._read = frames, read

    @cached_property
    def keys(self) -> list[str]:
        return [frame.key for frame in self._frames]

    @property
    def splits(self) -> list[str]:
        return [frame.split for frame in self._frames]

    def record(self, sample: int) -> str:
        """Returns the split, the time and the pose in the form of the member KEY.json of datasets."""
        frame = self._frames[sample]
        poses = [] if frame.pose is None else [frame.pose]
        listed = [{"rotation": quaternion_of(p).tolist(), "translation": p[:3, 3].tolist()} for p in poses]
        scan = {"sensor": self.sensor, "method": "", "time": frame.time, "world_from_sensor": listed}
        return json.dumps({"split": frame.split, "time": frame.time, "scans": [scan]})

    def scans(self, sample: int) -> list[tuple[str, str, int]]:
        return [(self.sensor, "", 0)]

    def read(
        self, sample: int, sensor: str = "", columns: Sequence[str] | None = None, revolution: int = 0
    ) -> Arrays:
        frame = self._frames[sample]
        if revolution != 0:
            raise InputError(f"{self.path}: the sample {frame.key} has no revolution {revolution}")
        arrays = self._read(frame)
        for name in columns or ():
            require_known(f"column of the scan of {frame.key}", name, [n for n in arrays if n != "xyz"])
        return arrays if columns is None else {name: arrays[name] for name in ("xyz", *columns)}

    def objects(self, sample: int) -> None:
        return None

    def voxels(self, sample: int, sensor: str = "") -> None:
        return None

    def stagger(self, sensor: str) -> None:
        return None

    def beams(self, sensor: str, time: float = 0) -> NoReturn:
        raise InputError(f"{self.path}: the beams of the sensor are unknown, since there is no manifest")

    def __reduce__(self) -> tuple[Any, ...]:
        return recorded_store, (self.path,)


def recorded_store(path: str) -> RecordedStore | None:
    """Returns the scans of a recorded set; None if the folder has none. Raises InputError for damaged tables and files
    of poses, and for KITTI's object benchmark."""
    return _nuscenes(path) or _kitti(path)


def _kitti(path: str) -> RecordedStore | None:
    folder = os.path.dirname(path) if os.path.basename(path) == "velodyne" else path
    depths = ("", "*/", "*/*/", "*/*/*/")  # of sequences in the folder; links are followed
    found = [file for depth in depths for file in glob.glob(f"{glob.escape(folder)}/{depth}velodyne/")]
    sequences = sorted(os.path.dirname(os.path.dirname(file)) for file in found)
    names = [os.path.basename(sequence) for sequence in sequences]
    frames: list[Frame] = []
    for sequence, name in zip(sequences, names):
        if os.path.isdir(os.path.join(sequence, "label_2")):
            raise InputError(
                f"{sequence}: is KITTI's object benchmark, which Python does not read: `scanmill view` opens it. "
                "Recorded sets in Python are those of SemanticKITTI, KITTI's odometry and nuScenes"
            )
        unique = name if names.count(name) == 1 else os.path.relpath(sequence, folder)
        frames += _kitti_frames(sequence, unique, KITTI_SPLITS.get(name, ""))
    return RecordedStore(path, "semantic_kitti", "velodyne", frames, _read_kitti) if frames else None


def _kitti_frames(sequence: str, name: str, split: str) -> Iterator[Frame]:
    """Yields the frames of one sequence. Frames are rows of times.txt and of poses.txt, which is in the folder or,
    in KITTI's odometry, outside of it."""
    files = sorted(glob.glob(f"{glob.escape(sequence)}/velodyne/*.bin"))
    root, number = os.path.dirname(os.path.dirname(sequence)), os.path.basename(sequence)
    candidates = [os.path.join(sequence, "poses.txt"), os.path.join(root, "poses", f"{number}.txt")]
    poses_file = next((file for file in candidates if os.path.isfile(file)), "")
    times_file = os.path.join(sequence, "times.txt")
    times = _table(times_file, 1)[:, 0] if os.path.isfile(times_file) else None
    poses = None
    if poses_file:
        camera_from_sensor = _camera_from_sensor(os.path.join(sequence, "calib.txt"))
        poses = np.linalg.inv(camera_from_sensor) @ _matrices(_table(poses_file, 12)) @ camera_from_sensor
    for index, points in enumerate(files):
        stem = os.path.splitext(os.path.basename(points))[0]
        row = int(stem) if stem.isdigit() else index
        for file, rows in ((poses_file, poses), (times_file, times)):
            if rows is not None and row >= len(rows):
                raise InputError(f"{file}: has {len(rows)} lines, none for the scan {stem}: add it, or remove the file")
        labels = os.path.join(sequence, "labels", f"{stem}.label")
        yield Frame(
            key=f"{name}-{stem}",
            split=split,
            time=0.0 if times is None else float(times[row] - times[0]),
            pose=None if poses is None else poses[row],
            points=points,
            labels=labels if os.path.isfile(labels) else "",
        )


def _read_kitti(frame: Frame) -> Arrays:
    points = _numbers(frame.points, np.float32, 4)
    arrays = {"xyz": points[:, :3], "intensity": points[:, 3]}
    if frame.labels:
        values = _labels(frame.labels, _numbers(frame.labels, np.uint32), points)
        arrays["label"] = (values & 0xFFFF).astype(np.int32)
        arrays["instance"] = (values >> 16).astype(np.int64)
    return _hits(arrays)


def _nuscenes(path: str) -> RecordedStore | None:
    versions = [path, *sorted(glob.glob(f"{glob.escape(path)}/v1.0-*"))]
    tables = next((folder for folder in versions if os.path.isfile(os.path.join(folder, "sample_data.json"))), None)
    if tables is None:
        return None
    root = os.path.dirname(tables)

    def rows(name: str, optional: bool = False) -> list[dict[str, Any]]:
        file = os.path.join(tables, f"{name}.json")
        return [] if optional and not os.path.isfile(file) else _json_rows(file)

    def file_of(names: dict[str, str], scan: dict[str, Any]) -> str:
        return os.path.join(root, names[scan["token"]]) if scan["token"] in names else ""

    try:
        scenes = {row["token"]: row["name"] for row in rows("scene")}
        scene_of = {row["token"]: scenes[row["scene_token"]] for row in rows("sample")}
        mounts = {row["token"]: matrix_of(row["rotation"], row["translation"]) for row in rows("calibrated_sensor")}
        lidarseg = {row["sample_data_token"]: row["filename"] for row in rows("lidarseg", optional=True)}
        panoptic = {row["sample_data_token"]: row["filename"] for row in rows("panoptic", optional=True)}
        scans = [row for row in rows("sample_data") if row["is_key_frame"] and "/LIDAR_TOP/" in row["filename"]]
        used = {row["ego_pose_token"] for row in scans}
        vehicles = {
            row["token"]: matrix_of(row["rotation"], row["translation"])
            for row in rows("ego_pose")
            if row["token"] in used
        }
        split_of = _nuscenes_splits(os.path.join(tables, "splits.json"))
        starts: dict[str, int] = {}
        for row in scans:
            scene = scene_of[row["sample_token"]]
            starts[scene] = min(starts.get(scene, row["timestamp"]), row["timestamp"])
        frames = [
            Frame(
                key=f"{scene}-{row['timestamp']}",
                split=split_of.get(scene, ""),
                time=(row["timestamp"] - starts[scene]) * 1e-6,
                pose=vehicles[row["ego_pose_token"]] @ mounts[row["calibrated_sensor_token"]] @ NUSCENES_FROM_FORWARD,
                points=os.path.join(root, row["filename"]),
                labels=file_of(lidarseg, row),
                panoptic=file_of(panoptic, row),
            )
            for row in scans
            for scene in [scene_of[row["sample_token"]]]
        ]
    except (KeyError, TypeError, ValueError) as e:
        raise InputError(f"{tables}: the tables do not fit together ({e!r}): unpack them again") from None
    frames = sorted((frame for frame in frames if os.path.isfile(frame.points)), key=lambda frame: frame.key)
    if not frames:
        raise InputError(f"{root}: has tables of nuScenes, but no scans of LIDAR_TOP: unpack samples/LIDAR_TOP")
    return RecordedStore(path, "nuscenes", "LIDAR_TOP", frames, _read_nuscenes)


def _nuscenes_splits(file: str) -> dict[str, str]:
    """Returns the split of each scene, by the splits.json that our export writes; nuScenes has its own in programs."""
    if not os.path.isfile(file):
        return {}
    with open(file, encoding="utf-8") as text:
        return {scene: split for split, scenes in json.load(text).items() if "_" not in split for scene in scenes}


def _read_nuscenes(frame: Frame) -> Arrays:
    points = _numbers(frame.points, np.float32, 5)
    xyz = np.column_stack([points[:, 1], -points[:, 0], points[:, 2]])
    arrays = {"xyz": xyz, "intensity": points[:, 3], "ring": points[:, 4]}
    if frame.panoptic:
        archive = read_npz(_bytes(frame.panoptic), frame.panoptic)
        values = _labels(frame.panoptic, archive.get("data", np.empty(0, np.uint16)), points)
        arrays["label"] = (values // 1000).astype(np.int32)
        arrays["instance"] = np.where(values % 1000 == 0, 0, values).astype(np.int64)
    if frame.labels:
        arrays["label"] = _labels(frame.labels, _numbers(frame.labels, np.uint8), points).astype(np.int32)
    arrays = _hits(arrays)
    return {**arrays, "ring": arrays["ring"].astype(np.int32)}


def _hits(arrays: Arrays) -> Arrays:
    """Returns the points without misses, which files have as NaN or as 0, 0, 0."""
    hit = np.isfinite(arrays["xyz"]).all(axis=1) & (arrays["xyz"] != 0).any(axis=1)
    return {name: np.ascontiguousarray(values[hit]) for name, values in arrays.items()}


def _bytes(file: str) -> bytes:
    try:
        with open(file, "rb") as content:
            return content.read()
    except OSError as e:
        raise InputError(f"{file}: cannot be read: {e.strerror}") from None


def _numbers(file: str, dtype: type[np.generic], columns: int = 0) -> NDArray[Any]:
    """Returns the numbers of a file, (N,) or (N, columns). Raises InputError unless they are whole records."""
    content = _bytes(file)
    size = np.dtype(dtype).itemsize * max(columns, 1)
    if len(content) % size:
        raise InputError(f"{file}: has {len(content)} bytes, which are no whole records of {size}: copy it again")
    values = np.frombuffer(content, np.dtype(dtype).newbyteorder("<"))
    return values.reshape(-1, columns) if columns else values


def _labels(file: str, values: NDArray[Any], points: NDArray[Any]) -> NDArray[Any]:
    if len(values) != len(points):
        raise InputError(f"{file}: has {len(values)} labels, but its scan has {len(points)} points: copy both again")
    return values


def _table(file: str, columns: int) -> NDArray[np.float64]:
    """Returns the lines of numbers in a file, (lines, columns)."""
    try:
        values = np.array(_bytes(file).split(), np.float64).reshape(-1, columns)
    except ValueError:
        raise InputError(f"{file}: must have {columns} numbers in each line: copy it again, or remove it") from None
    if not np.isfinite(values).all():
        raise InputError(f"{file}: has numbers that are not finite: copy it again, or remove it")
    return values


def _matrices(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns matrices (n, 4, 4) whose first three rows are the 12 numbers of each row."""
    matrices = np.tile(np.eye(4), (len(rows), 1, 1))
    matrices[:, :3] = rows.reshape(-1, 3, 4)
    return matrices


def _camera_from_sensor(file: str) -> NDArray[np.float64]:
    """Returns the matrix (4, 4) of the line Tr of calib.txt."""
    lines = _bytes(file).decode("utf-8", "replace").splitlines()
    numbers = next((line[3:].split() for line in lines if line.startswith("Tr:")), [])
    try:
        matrix = _matrices(np.array(numbers, np.float64).reshape(1, 12))[0]
        np.linalg.inv(matrix)
    except (ValueError, np.linalg.LinAlgError):
        raise InputError(f"{file}: has no line 'Tr:' with 12 numbers, which poses need: copy it again") from None
    return matrix


def _json_rows(file: str) -> list[dict[str, Any]]:
    try:
        rows = json.loads(_bytes(file))
    except ValueError as e:
        raise InputError(f"{file}: is no table of nuScenes: {e}: unpack it again") from None
    if not isinstance(rows, list):
        raise InputError(f"{file}: is no table of nuScenes, which is a list of rows: unpack it again")
    return rows
