"""Shards of datasets, and how the readers of a distributed loader share them."""

from __future__ import annotations

import os
import tarfile
from collections.abc import Iterator, Sequence
from typing import Any, Union

import numpy as np

from ._core import InputError, Store
from .dataset import Dataset, Path, Sample
from .words import require_known

# Files of shards; or a dataset or some of its samples; or the folder of one.
Source = Union[Dataset, Path, Sequence[Path]]


def share(sizes: Sequence[int], readers: int, reader: int) -> list[tuple[int, int, int]]:
    """The part of one of several readers of lists with `sizes` samples, as (list, first, last + 1).

    All samples are shared out as evenly as they can be, each reader's one after the other; together the readers take
    every sample once. Raises InputError unless 0 <= reader < readers.
    """
    if not 0 <= reader < readers:
        raise InputError(f"reader {reader} is not one of {readers}")
    total = sum(sizes)
    low, high = total * reader // readers, total * (reader + 1) // readers
    parts = []
    start = 0
    for place, size in enumerate(sizes):
        first, last = max(low, start), min(high, start + size)
        if first < last:
            parts.append((place, first - start, last - start))
        start += size
    return parts


class Shards:
    """The shards of a dataset, or a list of files, and the samples in them.

    Of files that belong to a dataset the folder is opened, once, which tells poses and classes; others are read by
    themselves.
    """

    def __init__(self, source: Source, split: str | None = None) -> None:
        """`split` chooses shards of a dataset. Raises InputError where there are none."""
        self._datasets: dict[str, Dataset] = {}
        self._keys: dict[int, list[str]] = {}
        if isinstance(source, (str, os.PathLike)):
            path = os.fspath(source)
            source = [path] if path.endswith(".tar") else Dataset(Store(path))
        if isinstance(source, Dataset):
            self.files = _files_of(source, split)
            self._datasets = dict.fromkeys(self.files, source)
            return
        if split is not None:
            raise InputError("a split can be selected only from a dataset, not from a list of files")
        self.files = [os.fspath(file) for file in source]
        if not self.files:
            raise InputError("the list of shards is empty")

    def __len__(self) -> int:
        return len(self.files)

    def keys(self, shard: int) -> list[str]:
        """The keys of a shard's samples, in the shard's order. Raises InputError where it cannot be read."""
        if shard not in self._keys:
            own, file = self.dataset(shard), self.files[shard]
            self._keys[shard] = own.keys if own.path == file else [key for key in _keys_in(file) if key in own]
        return self._keys[shard]

    def sample(self, shard: int, key: str) -> Sample:
        return self.dataset(shard)[key]

    def dataset(self, shard: int) -> Dataset:
        """The dataset that the shard is part of, or the shard by itself."""
        file = self.files[shard]
        if file not in self._datasets:
            folder = os.path.dirname(os.path.dirname(os.path.abspath(file)))
            known = [other for other in self._datasets.values() if other.path == folder]
            if not known and os.path.exists(os.path.join(folder, "manifest.json")):
                known = [Dataset(Store(folder))]
            if known and os.path.abspath(file) in _files_of(known[0], None):
                self._datasets[file] = known[0]
            else:
                self._datasets[file] = Dataset(Store(file))
        return self._datasets[file]


class Reading:
    """The samples that one reader sees in one epoch, in its order."""

    def __init__(self, shards: Shards, *, readers: int = 1, reader: int = 0, shuffle: int = 0, rng: Any = None) -> None:
        """`shuffle` is the number of samples that wait to be drawn from, 0 for the shards' order; it costs no memory,
        since they are read when they are drawn. `rng` is a function of a number that gives generators: of the order of
        shards, the same for all readers (0), and of the order of this reader's samples (1 + reader)."""
        self.shards = shards
        self.readers, self.reader = readers, reader
        self.shuffle, self.rng = shuffle, rng

    def __iter__(self) -> Iterator[Sample]:
        addresses = self._addresses()
        if self.shuffle > 1:
            addresses = _shuffled(addresses, self.shuffle, self.rng(1 + self.reader))
        for shard, key in addresses:
            yield self.shards.sample(shard, key)

    def _addresses(self) -> Iterator[tuple[int, str]]:
        order = list(range(len(self.shards)))
        if self.shuffle:
            order = self.rng(0).permutation(order).tolist()
        if len(order) >= self.readers:
            for shard in order[self.reader :: self.readers]:
                yield from ((shard, key) for key in self.shards.keys(shard))
            return
        sizes = [len(self.shards.keys(shard)) for shard in order]
        for place, first, last in share(sizes, self.readers, self.reader):
            yield from ((order[place], key) for key in self.shards.keys(order[place])[first:last])


def _shuffled(items: Iterator[Any], size: int, rng: np.random.Generator) -> Iterator[Any]:
    """The items in another order: each is drawn at random from `size` that wait."""
    waiting: list[Any] = []
    for item in items:
        waiting.append(item)
        if len(waiting) < size:
            continue
        drawn = int(rng.integers(len(waiting)))
        waiting[drawn], waiting[-1] = waiting[-1], waiting[drawn]
        yield waiting.pop()
    for drawn in rng.permutation(len(waiting)):
        yield waiting[drawn]


def _keys_in(file: str) -> list[str]:
    try:
        with tarfile.open(file, "r:") as shard:
            return list(dict.fromkeys(member.name.partition(".")[0] for member in shard))
    except (OSError, tarfile.TarError) as e:
        raise InputError(f"{file}: cannot be read as a shard: {e}") from None


def _files_of(dataset: Dataset, split: str | None) -> list[str]:
    """The shards that a dataset's samples may lie in."""
    if dataset.manifest is None or not os.path.isdir(dataset.path):
        raise InputError(f"{dataset.path} is not the folder of a dataset: give the files of shards as a list")
    listed = dataset.manifest["shards"]
    splits = {shard["split"] for shard in listed} if dataset.whole else set(dataset.splits)
    if split is not None:
        require_known(f"split of {dataset.path}", split, sorted(splits))
        splits = {split}
    return [os.path.join(dataset.path, shard["file"]) for shard in listed if shard["split"] in splits]
