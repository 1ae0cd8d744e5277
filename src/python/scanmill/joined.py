"""Several sets as one, whose labels have common ids."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .dataset import Dataset, Sample
from .ontology import Ontology, common_ontology
from .scan import Scan, Stagger
from .words import require_known


class JoinedStore:
    """The sets of a JoinedDataset."""

    manifest = None

    def __init__(self, sets: Sequence[Dataset], weights: Sequence[int] | None) -> None:
        if not sets:
            raise InputError("the list of sets is empty")
        self.sets = list(sets)
        self.weights = [1] * len(sets) if weights is None else list(weights)
        if len(self.weights) != len(sets) or not all(isinstance(w, int) and w >= 1 for w in self.weights):
            raise InputError(f"weights must be {len(sets)} whole numbers from 1 on, one for each set, not {weights}")
        for joined in (one for one in sets if isinstance(one, JoinedDataset)):
            raise InputError(f"{joined.path}: is joined already: list all sets at once")
        unknown = [one.path for one in sets if one.ontology is None]
        if unknown:
            raise InputError(f"{unknown[0]}: has no manifest, so that its classes are unknown: open its folder instead")
        self.path = " + ".join(one.path for one in sets)
        self.ontology, self.tables = common_ontology([one.ontology for one in sets if one.ontology is not None])
        self.names = self._names()
        self.partial_names: dict[str | None, set[str]] = {}  # by sensor, see JoinedDataset.partial_names()
        lengths = [len(one) for one in sets]
        self.set_of = np.repeat(np.arange(len(sets)), lengths)  # by sample
        self.index_in_set = np.concatenate([np.arange(length) for length in lengths])  # by sample

    def _names(self) -> list[str]:
        """Returns a name for each set: its folder's, or "NAME~2" for the second set of this name."""
        names: list[str] = []
        for one in self.sets:
            name = os.path.basename(one.path)
            count = sum(os.path.basename(other.path) == name for other in self.sets[: len(names)])
            names.append(f"{name}~{count + 1}" if count else name)
        return names

    @property
    def keys(self) -> list[str]:
        return [f"{name}/{key}" for name, one in zip(self.names, self.sets) for key in one.keys]

    @property
    def splits(self) -> list[str]:
        return [split for one in self.sets for split in one.split_of_samples]


class JoinedDataset(Dataset):
    """The samples of several sets, one set after the other. The key of a sample is NAME/KEY: NAME is the name of the
    set's folder ("NAME~2" for the second folder of this name), KEY the sample's key in its set.

    The classes of all sets have common ids. Classes of the same name are one class. Two classes of which one has the
    other's name as an alias are one class, too, unless it has aliases that name several classes, since it is then wider
    than each of them: nuScenes' "static.manmade" beside "building" and "wall". Two classes of one set are never merged.
    The first set keeps its ids; a class whose id is taken gets a free one. Labels of points, voxels and objects have
    the common ids, 0 for ids without a class.
    """

    store: JoinedStore  # type: ignore[assignment]

    @property
    def sets(self) -> list[Dataset]:
        """The sets, complete, in the order in which they were given."""
        return self.store.sets

    @property
    def ontology(self) -> Ontology:  # type: ignore[override]
        """The common classes of all sets."""
        return self.store.ontology

    @cached_property
    def sensors(self) -> dict[str, dict[str, Any]]:
        """The sensors that all sets describe in the same way; see Dataset.sensors. Others are in `sets[i].sensors`."""
        first, *others = (one.sensors for one in self.sets)
        return {name: sensor for name, sensor in first.items() if all(other.get(name) == sensor for other in others)}

    @property
    def weights(self) -> NDArray[np.int64]:
        return np.array(self.store.weights, np.int64)[self.store.set_of[self._numbers]]

    def beams(self, sensor: str, time: float = 0.0) -> dict[str, Any]:
        require_known("sensor of all sets", sensor, self.sensors)
        return self.sets[0].beams(sensor, time)

    def stagger(self, sensor: str) -> Stagger | None:
        require_known("sensor of all sets", sensor, self.sensors)
        return self.sets[0].stagger(sensor)

    def partial_names(self, sensor: str | None) -> set[str]:
        known = self.store.partial_names
        if sensor not in known:
            scans = [next((s.scan(sensor).dense() for s in one if s.has_scan(sensor)), None) for one in self.sets]
            names = [{*scan.names, *_known_of(scan)} for scan in scans if scan is not None]
            known[sensor] = set().union(*names) - set.intersection(*names) if names else set()
        return known[sensor]

    def _sample(self, index: int) -> Sample:
        number = int(self._numbers[index])
        which = int(self.store.set_of[number])
        one, table = self.sets[which], self.store.tables[which]
        return Sample(self, index, one, int(one._numbers[self.store.index_in_set[number]]), table)


def _known_of(scan: Scan) -> list[str]:
    """Returns which of the values are known that a sample has besides its columns (see SampleReader)."""
    values = {"world_from_sensor": scan.poses, "stagger": scan.stagger if {"ring", "column"} <= {*scan.names} else None}
    return [name for name, value in values.items() if value is not None]
