"""Datasets, shards and single scans as samples with numpy arrays."""

from __future__ import annotations

import io
import json
import operator
import os
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from ._core import InputError, Store, decode as decode_arrays
from .geometry import matrix_of
from .objects import Objects
from .ontology import Ontology
from .scan import Scan
from .words import advice

Path = Union[str, "os.PathLike[str]"]


def open_dataset(path: Path) -> Dataset:
    """Open a dataset's folder, a shard (.tar) or the file of one scan (.pcd, .drc, .csv).

    Nothing is decoded yet. Raises InputError where the path is none of these, or the manifest is damaged.
    """
    return Dataset(Store(os.fspath(path)))


def decode(name: str, data: bytes) -> Scan:
    """Decode a member of a shard, such as KEY.top.ray_tracing.pcd, by its name's suffix; what a WebDataset's map needs.

    Raises InputError for another suffix and for damaged bytes.
    """
    return Scan(decode_arrays(name, data))


class Dataset(Sequence["Sample"]):
    """Samples in the manifest's order, or some of them: dataset[0], dataset["town-s1-drive-000004"], a loop.

    It pickles by its path, so that workers of a loader open it themselves; threads can share one.
    """

    def __init__(self, store: Store, numbers: NDArray[np.int64] | None = None) -> None:
        """`numbers` are indices of the store's samples; all where it is None."""
        self.store = store
        self._numbers = numbers
        self._column_starts: dict[str, NDArray[Any] | None] = {}

    @cached_property
    def keys(self) -> list[str]:
        """The keys of the samples."""
        keys = self.store.keys
        return keys if self._numbers is None else [keys[i] for i in self._numbers]

    @cached_property
    def _places(self) -> dict[str, int]:
        return {key: i for i, key in enumerate(self.keys)}

    @property
    def path(self) -> str:
        return self.store.path

    @property
    def whole(self) -> bool:
        """Whether this has all samples that its path has."""
        return self._numbers is None

    @cached_property
    def manifest(self) -> dict[str, Any] | None:
        """The manifest without its samples (docs/manifest.schema.json); None where there is none."""
        text = self.store.manifest
        return None if text is None else json.loads(text)

    @cached_property
    def ontology(self) -> Ontology | None:
        """The classes of the labels; None where no manifest tells."""
        return None if self.manifest is None else Ontology(self.manifest["ontology"])

    @cached_property
    def sensors(self) -> dict[str, dict[str, Any]]:
        """What the manifest says of each sensor (lengths in m, angles in rad), by its name; without a manifest the
        names in the first sample alone."""
        if self.manifest is not None:
            return {sensor["name"]: sensor for sensor in self.manifest["sensors"]}
        return {name: {} for name in (self[0].sensors if len(self) else [])}

    @cached_property
    def sequences(self) -> dict[str, list[str]]:
        """The keys of the frames of each sequence, in their order; sequences are named by the keys."""
        sequences: dict[str, list[str]] = {}
        for key in self.keys:
            sequences.setdefault(_parts_of_key(key)[0], []).append(key)
        return sequences

    @cached_property
    def splits(self) -> dict[str, list[str]]:
        """The keys of each split (train, val, test); empty where no manifest tells."""
        splits: dict[str, list[str]] = {}
        if self.manifest is None:
            return splits
        own = self._numbers
        all_splits = self.store.splits
        for place, key in enumerate(self.keys):
            splits.setdefault(all_splits[place if own is None else own[place]], []).append(key)
        return splits

    def split(self, name: str) -> Dataset:
        """The samples of one split. Raises InputError where there is none of this name."""
        if name not in self.splits:
            raise InputError(f"{self.path} has no split '{name}'{advice(name, self.splits)}")
        selected = self.select(self.splits[name])
        selected.splits = {name: self.splits[name]}
        return selected

    def sequence(self, name: str) -> Dataset:
        """The frames of one sequence. Raises InputError where there is none of this name."""
        if name not in self.sequences:
            raise InputError(f"{self.path} has no sequence '{name}'{advice(name, self.sequences)}")
        return self.select(self.sequences[name])

    def select(self, which: Sequence[str | int]) -> Dataset:
        """The samples of these keys or indices, in their order."""
        own = self._numbers
        places = np.array([self._place(w) for w in which], np.int64)
        selected = Dataset(self.store, places if own is None else own[places])
        selected.keys = [self.keys[i] for i in places]
        for name in ("manifest", "ontology", "sensors"):  # what is of the whole dataset need not be parsed again
            if name in self.__dict__:
                selected.__dict__[name] = self.__dict__[name]
        selected._column_starts = self._column_starts
        return selected

    def beams(self, sensor: str, time: float = 0.0) -> dict[str, Any]:
        """The beams of a sensor in its frame: `rings`, `columns`, `direction` float64 (rings, columns, 3), unit
        vectors; `time` float32 (rings, columns), s since the start of the revolution; and where they do not start at
        the sensor's origin `origin` float32 (rings, columns, 3), m.

        `time` (s since the start of the sequence) matters to sensors whose pattern goes on from revolution to
        revolution. Raises InputError where no manifest tells.
        """
        return self.store.beams(sensor, time)

    def __len__(self) -> int:
        return len(self.keys)

    def __contains__(self, key: object) -> bool:
        return key in self._places

    def __getitem__(self, which: Any) -> Any:
        """The sample of a key or an index, from the end where negative; a Dataset of a slice.

        Raises InputError for an unknown key and IndexError for an index beyond the end.
        """
        if isinstance(which, slice):
            return self.select(range(*which.indices(len(self))))
        place = self._place(which)
        return Sample(self, place, place if self._numbers is None else int(self._numbers[place]))

    def __iter__(self) -> Iterator[Sample]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return f"<Dataset {self.path}: {len(self)} samples>"

    def __getstate__(self) -> dict[str, Any]:
        return {"store": self.store, "numbers": self._numbers}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        self.__init__(state["store"], state["numbers"])  # type: ignore[misc]

    def _place(self, which: str | int) -> int:
        if isinstance(which, str):
            if which not in self._places:
                raise InputError(f"{self.path} has no sample '{which}'{advice(which, self.keys[:100])}")
            return self._places[which]
        number = operator.index(which)
        place = number + len(self) if number < 0 else number
        if not 0 <= place < len(self):
            raise IndexError(f"{self.path} has {len(self)} samples, but no sample number {number}")
        return place

    def _starts_of_columns(self, sensor: str) -> NDArray[Any] | None:
        """When the columns of a sensor fire, in s since the start of the revolution, (columns,)."""
        if sensor not in self._column_starts:
            try:
                self._column_starts[sensor] = self.beams(sensor)["time"].min(axis=0)
            except InputError:  # the table is too large to be filled in; scans can be read all the same
                self._column_starts[sensor] = None
        return self._column_starts[sensor]


class Sample:
    """What the sensors see in one frame. Scans are decoded when they are asked for.

    Attributes:
      key              of the sample: SEQUENCE-FRAME
      index            in the dataset that it was taken from
      sequence, frame  of the key: a name, and a number from 0; "" and None of a file that is not part of a dataset
    """

    def __init__(self, dataset: Dataset, index: int, number: int) -> None:
        """`number` is the index in the dataset's store."""
        self.dataset = dataset
        self.index = index
        self._number = number
        self.key: str = dataset.keys[index]
        self.sequence, self.frame = _parts_of_key(self.key)

    @cached_property
    def record(self) -> dict[str, Any] | None:
        """Poses and counts of the scans, as the member KEY.json has them; None where there is no manifest."""
        text = self.dataset.store.record(self._number)
        return None if text is None else json.loads(text)

    @property
    def split(self) -> str:
        """The split; "" where no manifest tells."""
        return "" if self.record is None else self.record["split"]

    @property
    def time(self) -> float:
        """When the first scan starts, in s since the start of the sequence; 0 where no manifest tells."""
        return 0.0 if self.record is None else self.record["time"]

    @cached_property
    def draws(self) -> dict[str, Any]:
        """What was drawn at random for this sample, by the key in the pipeline or the scene's file, as
        "effects.1.weather.rate_mm_h": numbers as float, all else as YAML text. Empty where nothing was."""
        drawn = {} if self.record is None else self.record.get("draws", {})
        return {key: _number_or_text(value) for key, value in drawn.items()}

    @cached_property
    def sensors(self) -> list[str]:
        """The names of the sensors that have a scan."""
        return list(dict.fromkeys(sensor for sensor, _ in self.dataset.store.scans(self._number)))

    @property
    def poses(self) -> dict[str, NDArray[np.float64]]:
        """world_from_sensor by sensor, float64 (P, 4, 4): at the start of the revolution, and where the sensor moves at
        its end besides. Empty where no manifest tells."""
        scans = [] if self.record is None else self.record["scans"]
        return {scan["sensor"]: _poses_of(scan) for scan in reversed(scans)}

    def scan(self, sensor: str | None = None, columns: Sequence[str] | None = None) -> Scan:
        """Read the scan of a sensor (the first one where it is None), with all its columns or those named.

        Raises InputError for an unknown sensor or column, and where the scan's bytes are damaged.
        """
        if isinstance(columns, str):
            raise InputError(f"columns must be a list of names, not '{columns}'")
        arrays = self.dataset.store.read(self._number, sensor or "", None if columns is None else list(columns))
        scans = self.dataset.store.scans(self._number)
        name, method = next((s for s in scans if s[0].lower() == (sensor or scans[0][0]).lower()), scans[0])
        record = self._record_of(name, method)
        if record is None:
            return Scan(arrays, sensor=name, method=method)
        poses = _poses_of(record)
        manifest = self.dataset.manifest or {}
        deskewed = manifest["scans"]["deskewed"]
        moves = len(poses) > 1 and not deskewed
        return Scan(
            arrays,
            sensor=name,
            method=method,
            start_time=record["time"],
            poses=poses,
            deskewed=deskewed,
            column_starts=self.dataset._starts_of_columns(name) if moves else None,
            rings=self.dataset.sensors[name]["rings"],
            columns=self.dataset.sensors[name]["columns"],
        )

    def objects(self, sensor: str | None = None) -> Objects | None:
        """The things that the range of a sensor reaches (the first one's where it is None), with their boxes; None
        where the dataset lists no objects (`output.objects`). Raises InputError for an unknown sensor."""
        listed = self.object_list()
        if listed is None:
            return None
        name = sensor or self.sensors[0]
        if name not in self.poses:
            raise InputError(f"the sample '{self.key}' has no sensor '{name}'{advice(name, self.poses)}")
        return Objects(listed, name, self.poses[name][0])

    def voxels(self, sensor: str | None = None) -> dict[str, NDArray[Any]] | None:
        """What stands in the voxels about a sensor (the first one where it is None), in the frame of its points, and what
        its scan has of them: `label` uint16 (X, Y, Z), 0 where it is empty; `input`, `invalid` and `unseen` bool likewise;
        `low` float64 (3,) in m, the corner with the least coordinates; `size` float64 () in m. None where the dataset
        has no voxels (`output.voxels`). Raises InputError for an unknown sensor."""
        archive = self.dataset.store.voxels(self._number, sensor or "")
        if archive is None:
            return None
        with np.load(io.BytesIO(archive), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}

    def object_list(self) -> list[dict[str, Any]] | None:
        """All things near any of the sensors, as KEY.objects.json lists them (docs/objects.schema.json); None where the
        dataset lists no objects."""
        text = self.dataset.store.objects(self._number)
        return None if text is None else json.loads(text)["objects"]

    def __repr__(self) -> str:
        return f"<Sample {self.key}>"

    def _record_of(self, sensor: str, method: str) -> dict[str, Any] | None:
        scans = [] if self.record is None else self.record["scans"]
        return next((s for s in scans if s["sensor"] == sensor and s["method"] == method), None)


def _number_or_text(value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        return value


def _poses_of(scan: Mapping[str, Any]) -> NDArray[np.float64]:
    poses = scan["world_from_sensor"]
    return matrix_of([p["rotation"] for p in poses], [p["translation"] for p in poses])


def _parts_of_key(key: str) -> tuple[str, int | None]:
    sequence, dash, frame = key.rpartition("-")
    return (sequence, int(frame)) if dash and frame.isascii() and frame.isdigit() else ("", None)
