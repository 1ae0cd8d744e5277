"""Datasets, shards and single scans as samples with numpy arrays."""

from __future__ import annotations

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
from .npz import read_npz
from .objects import Objects
from .ontology import LABELS, Ontology, load_ontology
from .recorded import RecordedStore, recorded_store
from .scan import Scan, Stagger
from .words import advice, names_in, require_known

Path = Union[str, "os.PathLike[str]"]


def open_dataset(path: Path | Sequence[Path | Dataset], weights: Sequence[int] | None = None) -> Dataset:
    """Opens the folder of a dataset, a shard (.tar), the file of one scan (.pcd, .drc, .csv), or a folder of scans that
    others recorded; or a list of sets, as one set.

    Recorded sets are those of SemanticKITTI and KITTI's odometry (the root, `sequences`, or one sequence), and of
    nuScenes (the root or v1.0-...: key frames of LIDAR_TOP). Their scans have the columns intensity, label and instance
    (nuScenes: ring, too) as far as there are files of them; x is forward, y left and z up. Splits are those of
    SemanticKITTI; nuScenes has them if splits.json is beside its tables. The world's origin is the first pose of
    KITTI's sequences, and that of nuScenes' maps. Misses, NaN or 0, 0, 0, are left out.

    A list of paths, datasets, or parts of them such as dataset.split("train") becomes a JoinedDataset. `weights`: how
    often an epoch of ScanDataset has each sample of each set, each time with other random numbers. Default: once.

    Decodes no scans yet. Later changes of the current folder do not matter. Raises InputError if the path is none of
    these, if the manifest or a table is damaged, and for weights that are not a whole number for each set of a list.
    """
    if not isinstance(path, (str, os.PathLike)):
        from .joined import JoinedDataset, JoinedStore  # imports this module

        return JoinedDataset(JoinedStore([p if isinstance(p, Dataset) else open_dataset(p) for p in path], weights))
    if weights is not None:
        raise InputError("weights are for a list of sets")
    path = os.path.abspath(path)
    without_manifest = os.path.isdir(path) and not os.path.exists(os.path.join(path, "manifest.json"))
    return Dataset((recorded_store(path) if without_manifest else None) or Store(path))


def decode(name: str, data: bytes | bytearray | memoryview) -> Scan:
    """Decodes a member of a shard, such as KEY.top.ray_tracing.pcd; the suffix of `name` determines the format.

    Can be used in the map() of a WebDataset. Raises InputError for an unknown suffix and for damaged bytes.
    """
    if not isinstance(name, str) or not isinstance(data, (bytes, bytearray, memoryview)):
        raise InputError(f"decode() needs a name and bytes, not {type(name).__name__} and {type(data).__name__}")
    return Scan(decode_arrays(name, data if isinstance(data, bytes) else bytes(data)))


class Dataset(Sequence["Sample"]):
    """The samples of a dataset, or some of them, in the manifest's order: dataset[0], dataset["town-s1-drive-000004"].

    Pickling stores only the path, so that workers of a loader open the dataset themselves. Threads can share a Dataset.
    """

    def __init__(self, store: Store | RecordedStore, numbers: NDArray[np.int64] | None = None) -> None:
        """`numbers`: indices of samples in the store; None: all samples."""
        self.store = store
        self._stored_indices = numbers
        self._numbers = np.arange(len(store.keys)) if numbers is None else numbers
        self._column_starts: dict[str, NDArray[Any] | None] = {}

    @cached_property
    def keys(self) -> list[str]:
        """The keys of the samples, in their order."""
        keys = self.store.keys
        return keys if self.whole else [keys[i] for i in self._numbers]

    @cached_property
    def _index_of_key(self) -> dict[str, int]:
        return {key: i for i, key in enumerate(self.keys)}

    @property
    def path(self) -> str:
        return self.store.path

    @property
    def whole(self) -> bool:
        """True if this object contains all samples of its path."""
        return self._stored_indices is None

    @cached_property
    def manifest(self) -> dict[str, Any] | None:
        """The manifest without its samples (docs/manifest.schema.json); None if there is no manifest."""
        text = self.store.manifest
        return None if text is None else json.loads(text)

    @cached_property
    def ontology(self) -> Ontology | None:
        """The classes of the labels; None if there is no manifest, unless the set is a recorded one."""
        if isinstance(self.store, RecordedStore):
            return load_ontology(self.store.classes)
        return None if self.manifest is None else Ontology(self.manifest["ontology"])

    @cached_property
    def sensors(self) -> dict[str, dict[str, Any]]:
        """The manifest's description of each sensor (lengths in m, angles in rad), by name. If its mount
        `vehicle_from_sensor` is random, it is in each of `sample.record["scans"]` instead. Of sensors with the same
        `choice`, each sequence has one; where the first sensor is one of them, the sample's counts as the first.
        Without a manifest: the names of the sensors in the first sample, with empty descriptions."""
        if self.manifest is not None:
            return {sensor["name"]: sensor for sensor in self.manifest["sensors"]}
        return {name: {} for name in (self[0].sensors if len(self) else [])}

    @cached_property
    def sequences(self) -> dict[str, list[str]]:
        """The keys of the frames of each sequence, in the order of frames, by the name of the sequence."""
        sequences: dict[str, list[str]] = {}
        for key in self.keys:
            sequences.setdefault(_parts_of_key(key)[0], []).append(key)
        return sequences

    @property
    def split_of_samples(self) -> list[str]:
        """The name of each sample's split; "" if it is unknown."""
        splits = self.store.splits
        return [splits[i] for i in self._numbers]

    @cached_property
    def splits(self) -> dict[str, list[str]]:
        """The keys of the samples in each split (train, val, test); empty if splits are unknown."""
        splits: dict[str, list[str]] = {}
        for key, split in zip(self.keys, self.split_of_samples):
            if split:
                splits.setdefault(split, []).append(key)
        return splits

    @property
    def weights(self) -> NDArray[np.int64]:
        """How often an epoch of ScanDataset has each sample, (len(self),): 1 except in joined sets."""
        return np.ones(len(self), np.int64)

    def class_counts(self, split: str | None = None, sensor: str | None = None) -> dict[str, int]:
        """Returns the number of points of each class of the ontology in the first revolutions of a sensor (None: the
        first sensor), of all samples or of a split.

        Takes them from the manifest; in recorded sets, reads all labels. Labels without a class count as "unlabeled".
        Raises InputError if the classes are unknown, if there are no labels, and for an unknown split or sensor.
        """
        if self.ontology is None:
            raise InputError(f"{self.path} has no manifest, so that its classes are unknown: open its folder instead")
        counts = self._label_counts(split, sensor)
        known = dict(zip(self.ontology.names, counts[self.ontology.ids].tolist()))
        return {**known, "unlabeled": int(counts.sum()) - sum(known.values()) + known["unlabeled"]}

    def class_weights(
        self, table: NDArray[Any], split: str | None = None, sensor: str | None = None, ignore: int = 255
    ) -> NDArray[np.float32]:
        """Returns weights of a loss for the train ids of a table, as Ontology.train_ids() returns it, float32 (K,):
        1 / ln(1.02 + p), where p is the share of the train id among all points of an epoch that are not ignored (Paszke
        et al., ENet, 2016). They are from 1.42 to 50.5. Raises InputError like class_counts()."""
        labels = np.flatnonzero(table != ignore)
        counts = np.bincount(table[labels], self._label_counts(split, sensor, weighted=True)[labels])
        return (1 / np.log(1.02 + counts / max(counts.sum(), 1))).astype(np.float32)

    def _label_counts(self, split: str | None, sensor: str | None, weighted: bool = False) -> NDArray[np.int64]:
        """Returns the number of points with each label, (65536,); see class_counts(). `weighted`: in an epoch."""
        samples = self if split is None else self.split(split)
        counts = np.zeros(LABELS, np.int64)
        for sample, weight in zip(samples, samples.weights if weighted else np.ones(len(samples), np.int64)):
            if sample.has_scan(sensor):
                counts += weight * sample.label_counts(sensor)
        return counts

    def split(self, name: str) -> Dataset:
        """Returns the samples of one split. Raises InputError if there is no split of this name."""
        if name not in self.splits:
            raise InputError(f"{self.path} has no split '{name}'{advice(name, self.splits)}")
        selected = self.select(self.splits[name])
        selected.splits = {name: self.splits[name]}
        return selected

    def sequence(self, name: str) -> Dataset:
        """Returns the frames of one sequence. Raises InputError if there is no sequence of this name."""
        if name not in self.sequences:
            raise InputError(f"{self.path} has no sequence '{name}'{advice(name, self.sequences)}")
        return self.select(self.sequences[name])

    def select(self, which: Sequence[str | int]) -> Dataset:
        """Returns the samples with these keys or indices, in the given order."""
        indices = np.array([self._index_of(w) for w in which], np.int64)
        selected = type(self)(self.store, self._numbers[indices])
        selected.keys = [self.keys[i] for i in indices]
        for name in ("manifest", "ontology", "sensors"):  # equal in the selection, so they need not be parsed again
            if name in self.__dict__:
                selected.__dict__[name] = self.__dict__[name]
        selected._column_starts = self._column_starts
        return selected

    def beams(self, sensor: str, time: float = 0.0) -> dict[str, Any]:
        """Returns the beams of a sensor in its frame: `rings` and `columns` (their numbers), `direction` float64
        (rings, columns, 3), unit vectors, and `time` float32 (rings, columns), s since the start of the revolution. If
        beams do not start at the sensor's origin, also returns their `origin` float32 (rings, columns, 3), m.

        `time` (s since the start of the sequence) matters only for sensors whose scan pattern differs from revolution
        to revolution. Raises InputError if there is no manifest.
        """
        return self.store.beams(_sensor_name(sensor), time)

    def stagger(self, sensor: str) -> Stagger | None:
        """Returns where the points of a sensor belong in a range image; None if there is no manifest. Raises InputError
        for an unknown sensor."""
        require_known("sensor", sensor, self.sensors)
        stagger = self.store.stagger(sensor)
        return None if stagger is None else Stagger(*stagger)

    def partial_names(self, sensor: str | None) -> set[str]:
        """Returns the names in the dictionaries of SampleReader that only some of several joined sets have."""
        return set()

    def __len__(self) -> int:
        return len(self.keys)

    def __contains__(self, key: object) -> bool:
        return key in self._index_of_key

    def __getitem__(self, which: Any) -> Any:
        """Returns the sample with this key or index (negative: counted from the end); a Dataset for a slice.

        Raises InputError for an unknown key, and IndexError for an index that is out of range.
        """
        if isinstance(which, slice):
            return self.select(range(*which.indices(len(self))))
        return self._sample(self._index_of(which))

    def __iter__(self) -> Iterator[Sample]:
        return (self._sample(i) for i in range(len(self)))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.path}: {len(self)} samples>"

    def __getstate__(self) -> dict[str, Any]:
        return {"store": self.store, "numbers": self._stored_indices}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        self.__init__(state["store"], state["numbers"])  # type: ignore[misc]

    def _sample(self, index: int) -> Sample:
        return Sample(self, index, self, int(self._numbers[index]))

    def _index_of(self, which: str | int) -> int:
        if isinstance(which, str):
            if which not in self._index_of_key:
                raise InputError(f"{self.path} has no sample '{which}'{advice(which, self.keys[:100])}")
            return self._index_of_key[which]
        number = operator.index(which)
        index = number + len(self) if number < 0 else number
        if not 0 <= index < len(self):
            raise IndexError(f"{self.path} has {len(self)} samples, but no sample number {number}")
        return index

    def _starts_of_columns(self, sensor: str) -> NDArray[Any] | None:
        """Returns when each column of a sensor fires, in s since the start of the revolution, (columns,); None if
        unknown."""
        if sensor not in self._column_starts:
            try:
                self._column_starts[sensor] = self.beams(sensor)["time"].min(axis=0)
            except InputError:  # the beam table is too large; scans can be read without it
                self._column_starts[sensor] = None
        return self._column_starts[sensor]


class Sample:
    """The scans of all sensors in one frame. A scan is decoded when it is requested.

    Attributes:
      key              SEQUENCE-FRAME
      index            index in the dataset from which this sample was taken
      sequence, frame  parts of the key: a name, and a number starting at 0; "" and None for a file outside of datasets
    """

    def __init__(
        self, dataset: Dataset, index: int, origin: Dataset, number: int, labels: NDArray[np.int32] | None = None
    ) -> None:
        """`number`: index of the sample in the store of `origin`, which is the dataset itself or the one of joined sets
        that has the sample. `labels`: table (65536,) from labels of `origin` to those of the dataset; None: equal."""
        self.dataset = dataset
        self.index = index
        self._origin = origin
        self._number = number
        self._labels = labels
        self.key: str = dataset.keys[index]
        self.sequence, self.frame = _parts_of_key(self.key)

    @cached_property
    def record(self) -> dict[str, Any] | None:
        """Poses and counts of the scans, as in the member KEY.json; None if there is no manifest."""
        text = self._origin.store.record(self._number)
        return None if text is None else json.loads(text)

    @property
    def split(self) -> str:
        """The name of the split; "" if there is no manifest."""
        return "" if self.record is None else self.record["split"]

    @property
    def time(self) -> float:
        """The time of the frame, in s since the start of the sequence; 0 if there is no manifest."""
        return 0.0 if self.record is None else self.record["time"]

    @cached_property
    def draws(self) -> dict[str, Any]:
        """The random values of this sample, by their key in the pipeline or the scene file, such as
        "effects.1.weather.rate_mm_h": numbers as float, other values as YAML text. Empty if nothing is random."""
        drawn = {} if self.record is None else self.record.get("draws", {})
        return {key: _number_or_text(value) for key, value in drawn.items()}

    @cached_property
    def sensors(self) -> list[str]:
        """The names of the sensors that have a scan in this sample."""
        return list(dict.fromkeys(sensor for sensor, _, _ in self._origin.store.scans(self._number)))

    def has_scan(self, sensor: str | None = None) -> bool:
        """Returns whether the sample has a scan of a sensor (None: the dataset's first sensor). It may have none if a
        revolution of the sensor takes longer than the time between frames. Raises InputError for an unknown sensor."""
        name = self._sensor_or_first(sensor).lower()
        if any(s.lower() in (name, "") for s in self.sensors):  # "": a file outside of datasets
            return True
        if any(s.lower() == name for s in self._origin.sensors):
            return False
        raise InputError(f"the sample '{self.key}' has no sensor '{name}'{advice(name, self.sensors)}")

    def revolutions(self, sensor: str | None = None) -> int:
        """Returns how many revolutions of a sensor (None: the dataset's first sensor) the sample has: several if the
        sensor turns faster than others. Raises InputError if it has none."""
        name = self._required_sensor(sensor)
        return 1 + max(r for s, _, r in self._origin.store.scans(self._number) if s.lower() == name.lower())

    @property
    def poses(self) -> dict[str, NDArray[np.float64]]:
        """The poses world_from_sensor of each sensor, float64 (P, 4, 4): at the start of the revolution and, if the
        sensor moves, also at its end. Empty if there is no manifest."""
        scans = [] if self.record is None else self.record["scans"]
        return {scan["sensor"]: _poses_of(scan) for scan in reversed(scans) if scan["world_from_sensor"]}

    def scan(self, sensor: str | None = None, columns: Sequence[str] | None = None, revolution: int = 0) -> Scan:
        """Reads the scan of a sensor (None: the dataset's first sensor or, without a manifest, the sample's). `columns`:
        names of the columns to read; None: all columns. `revolution`: index of the sensor's revolution in the sample,
        from 0 to revolutions() - 1.

        Raises InputError if there is no such scan (see has_scan()) or no such column, and if the scan's bytes are
        damaged: if they do not match the digest in the manifest or, without a manifest, cannot be decoded.
        """
        column_names = None if columns is None else names_in("columns", columns)
        if not isinstance(revolution, int) or not 0 <= revolution < 256:
            raise InputError(f"revolution must be a whole number from 0 to 255, not {revolution!r}")
        sensor = self._required_sensor(sensor)
        arrays = self._origin.store.read(self._number, sensor, column_names, revolution)
        if self._labels is not None and "label" in arrays:
            arrays["label"] = self._labels[arrays["label"]]
        scans = self._origin.store.scans(self._number)
        name, method, _ = next((s for s in scans if s[0] == sensor), scans[0])
        record = self._record_of(name, method, revolution)
        if record is None:
            return Scan(arrays, sensor=name, method=method)
        poses = _poses_of(record) if record["world_from_sensor"] else None
        manifest = self._origin.manifest
        deskewed = manifest is not None and manifest["scans"]["deskewed"]
        moves = poses is not None and len(poses) > 1 and not deskewed
        return Scan(
            arrays,
            sensor=name,
            method=method,
            start_time=record["time"],
            poses=poses,
            deskewed=deskewed,
            column_starts=self._origin._starts_of_columns(name) if moves else None,
            rings=self._origin.sensors[name].get("rings", 0),
            columns=self._origin.sensors[name].get("columns", 0),
            stagger=self._origin.stagger(name),
        )

    def objects(self, sensor: str | None = None) -> Objects | None:
        """Returns the objects within the range of a sensor (None: the dataset's first sensor), with their boxes at its
        first revolution. Returns None if the dataset has no object lists (`output.objects`). Raises InputError if the
        sample has no scan of the sensor."""
        objects = self.object_list()
        if objects is None:
            return None
        name = self._required_sensor(sensor)
        return Objects(objects, name, self.poses[name][0])

    def voxels(self, sensor: str | None = None) -> dict[str, NDArray[Any]] | None:
        """Returns the labelled voxels around a sensor (None: the dataset's first sensor), in the frame of its points:
        `label` int32 (X, Y, Z), 0 for empty voxels; `input`, `invalid` and `unseen`, bool (X, Y, Z); `low` float64
        (3,), the corner with the least coordinates (m); `size` float64 (), the edge of a voxel (m). Returns None if the
        dataset has no voxels (`output.voxels`). Raises InputError if the sample has no scan of the sensor, and for
        damaged voxels."""
        archive = self._origin.store.voxels(self._number, self._required_sensor(sensor))
        if archive is None:
            return None
        voxels = read_npz(archive, f"{self._origin.path}: the voxels of {self.key}")
        labels = np.arange(LABELS, dtype=np.int32) if self._labels is None else self._labels
        return {name: labels[values] if name == "label" else values for name, values in voxels.items()}

    def object_list(self) -> list[dict[str, Any]] | None:
        """Returns all objects near any of the sensors, as listed in KEY.objects.json (docs/objects.schema.json); None
        if the dataset has no object lists."""
        text = self._origin.store.objects(self._number)
        objects: list[dict[str, Any]] | None = None if text is None else json.loads(text)["objects"]
        if objects is not None and self._labels is not None and self.dataset.ontology is not None:
            for listed in objects:
                listed["class"] = int(self._labels[listed["class"]])
                listed["class_name"] = self.dataset.ontology.name_of(listed["class"])
        return objects

    def label_counts(self, sensor: str | None = None) -> NDArray[np.int64]:
        """Returns the number of points with each label in the first revolution of a sensor (None: the dataset's first
        sensor), (65536,), from the manifest or, without one, from the labels. Raises InputError like scan()."""
        name = self._required_sensor(sensor)
        scans = [] if self.record is None else self.record["scans"]
        listed = next((s for s in scans if s["sensor"] == name and "revolution" not in s), {}).get("points_per_class")
        if listed is None:
            return np.bincount(self.scan(sensor, ["label"]).dense().label, minlength=LABELS)
        labels = np.array([c["id"] for c in listed], np.int64)
        counts = np.zeros(LABELS, np.int64)
        np.add.at(counts, labels if self._labels is None else self._labels[labels], [c["points"] for c in listed])
        return counts

    def __repr__(self) -> str:
        return f"<Sample {self.key}>"

    def _sensor_or_first(self, sensor: str | None) -> str:
        described = self._origin.sensors
        first = self.sensors[0] if self._origin.manifest is None else next(iter(described))
        choice = described.get(first, {}).get("choice")
        if choice is not None:  # each sequence has another one of several sensors
            first = next((name for name in self.sensors if described[name].get("choice") == choice), first)
        return _sensor_name(sensor) or first

    def _required_sensor(self, sensor: str | None) -> str:
        """Returns the name of a sensor as the sample's scans have it. Raises InputError if there is no scan of it."""
        name = self._sensor_or_first(sensor)
        if not self.has_scan(sensor):
            raise InputError(
                f"the sample '{self.key}' has no scan of the sensor '{name}', which turns more slowly than frames follow "
                f"each other, or of whose random choice the sequence has another: skip the sample (see Sample.has_scan()) or name another sensor ({', '.join(self.sensors)})"
            )
        return next((sensor for sensor in self.sensors if sensor.lower() == name.lower()), name)

    def _record_of(self, sensor: str, method: str, revolution: int) -> dict[str, Any] | None:
        scans = [] if self.record is None else self.record["scans"]
        key = (sensor, method, revolution)
        return next((s for s in scans if (s["sensor"], s["method"], s.get("revolution", 0)) == key), None)


def _sensor_name(sensor: str | None) -> str:
    """Returns the name, "" for None. Raises InputError for anything but a text."""
    if sensor is not None and not isinstance(sensor, str):
        raise InputError(f"sensor must be the name of a sensor, not {sensor!r}")
    return sensor or ""


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
