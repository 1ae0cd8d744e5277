"""Writes datasets sample by sample, from a loop that decides itself where to scan and what moves."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Optional

from numpy.typing import ArrayLike

from . import _core
from ._core import InputError
from .dataset import Dataset, Path, open_dataset
from .geometry import Pose
from .scan import Scan
from .simulate import Effects, Method, Scene, Sensor, _objects_key


class DatasetWriter:
    """A dataset that a loop makes, scan by scan.

        scene = scanmill.load_scene("town", seed=3)
        with scanmill.DatasetWriter("out/loop", scanmill.sensor("os1_128"), boxes=True) as writer:
            for frame in range(200):
                writer.add(scene, {"position": [0.8 * frame, 0, 0]}, time=0.1 * frame)
        dataset = writer.dataset

    The dataset is complete, and has a manifest, at the end of the `with` block; not if the block raises an error. A
    sample has the bytes that `scanmill.generate` gives it, if the keys of the pipeline, the name of the sequence, the
    number of the frame, its time and its poses are the same. Threads may share a writer.
    """

    def __init__(
        self,
        out: Path,
        sensor: Sensor | Sequence[Sensor],
        *,
        method: Method = "ray_tracing",
        effects: Effects = "sensor",
        columns: Sequence[str] | None = None,
        seed: int = 1,
        organised: bool = False,
        boxes: bool | str | Sequence[str] = False,
        vehicle: Path | Mapping[str, Any] | None = None,
        output: Mapping[str, Any] | None = None,
        shard_samples: int = 100,
        name: str = "loop",
        overwrite: bool = False,
        resume: bool = False,
    ) -> None:
        """`out`: the folder of the dataset. `sensor` to `vehicle` are as for Scene.scan(), but the effects are those of
        the sensor's file by default. `output`: further keys of a pipeline's `output`, such as {"formats": ["draco"]}.
        `shard_samples`: number of samples in a shard. `name`: name of the dataset.

        `overwrite` replaces a dataset in the folder; `resume` begins a new one or continues an interrupted one: complete
        shards stay, and add() only makes the first sample of each again, to see that nothing has changed. The loop must
        then give the same frames in the same order, with the same poses and velocities of objects. Outside of a `with`
        block, finish() completes the dataset. Raises InputError for wrong arguments and for a folder with other contents.
        """
        if shard_samples < 1:
            raise InputError("shard_samples must be at least 1")
        self.out = os.path.abspath(out)
        self._single = isinstance(sensor, (str, Mapping))
        keys = {**(output or {}), **_objects_key(boxes)}
        self._settings = (sensor, method, effects, columns, seed, organised, keys, vehicle, name)
        self._lock = threading.Lock()
        self._writer: _core.DatasetWriter | None = _core.DatasetWriter(self.out, overwrite, resume, shard_samples)

    def add(
        self,
        scene: Scene,
        pose: Pose | Sequence[Pose],
        *,
        time: float = 0.0,
        poses: Mapping[str, Optional[Pose]] | None = None,
        velocities: Mapping[str, ArrayLike] | None = None,
        pose_times: ArrayLike | None = None,
        drive: str = "drive",
        split: str = "train",
    ) -> Scan | list[Scan] | None:
        """Scans a scene and adds the scans as the next sample of a sequence. Returns the Scan, or a list of Scans if
        the writer has a list of sensors; None if `resume` has found the sample complete.

        `pose` to `pose_times` are as for Scene.scan(). `drive` names the sequence: scene, seed and drive are the key of
        its samples. All samples of a sequence belong in one `split`. Raises InputError as Scene.scan() does, if the
        scene has other classes than those before, and if a sample differs from that of the interrupted run.
        """
        with self._lock:
            if self._writer is None:
                raise InputError(f"{self.out}: the dataset is complete, or its loop has failed: make a new writer")
            pipeline = scene._pipeline(*self._settings)
            scans: list[Scan] = scene._run(
                pipeline, pose, time, 0, poses, velocities, pose_times, self._writer, drive, split
            )
        if not scans:
            return None
        return scans[0] if self._single else scans

    def finish(self) -> None:
        """Completes the dataset, as the end of a `with` block does."""
        with self._lock:
            writer, self._writer = self._writer, None
            if writer is not None:
                writer.finish()

    @property
    def dataset(self) -> Dataset:
        """The complete dataset, opened."""
        return open_dataset(self.out)

    def __enter__(self) -> DatasetWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.finish()
        self._writer = None  # releases the folder; complete shards stay for `resume`
