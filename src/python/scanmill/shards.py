"""The shards of datasets, and their distribution over the readers of a loader."""

from __future__ import annotations

import io
import os
import tarfile
from collections.abc import Iterator, Sequence
from typing import Any, Union

import numpy as np

from ._core import InputError, Store
from .dataset import Dataset, Path, Sample
from .words import require_known

# A dataset or some of its samples, the folder of a dataset, a shard's file, or a list of shards' files.
Source = Union[Dataset, Path, Sequence[Path]]


def share(sizes: Sequence[int], readers: int, reader: int) -> list[tuple[int, int, int]]:
    """Returns the part of one reader as ranges (index of a list, first sample, last sample + 1). `sizes`: number of
    samples in each list.

    All samples are divided as evenly as possible into consecutive parts, one for each reader. Each sample is in exactly
    one part. Raises InputError unless 0 <= reader < readers.
    """
    if not 0 <= reader < readers:
        raise InputError(f"reader {reader} is not one of {readers}")
    total = sum(sizes)
    low, high = total * reader // readers, total * (reader + 1) // readers
    parts = []
    start = 0
    for index, size in enumerate(sizes):
        first, last = max(low, start), min(high, start + size)
        if first < last:
            parts.append((index, first - start, last - start))
        start += size
    return parts


class Shards:
    """The shards of a dataset or a list of shard files, with their samples.

    If a file belongs to a dataset, the dataset's folder is opened (once), since it has the poses and classes. Other
    files are opened as single shards.
    """

    def __init__(self, source: Source, split: str | None = None) -> None:
        """`split` selects shards of a dataset. Raises InputError if there are no shards."""
        self._datasets: dict[str, Dataset] = {}
        self._keys: dict[int, list[str]] = {}
        if isinstance(source, (str, os.PathLike)):
            path = os.path.abspath(source)
            source = [path] if path.endswith(".tar") else Dataset(Store(path))
        if isinstance(source, Dataset):
            self.files = _files_of(source, split)
            self._datasets = dict.fromkeys(self.files, source)
            return
        if split is not None:
            raise InputError("a split can be selected only from a dataset, not from a list of files")
        self.files = [os.path.abspath(file) for file in source]
        if not self.files:
            raise InputError("the list of shards is empty")

    def __len__(self) -> int:
        return len(self.files)

    def keys(self, shard: int) -> list[str]:
        """Returns the keys of a shard's samples, in the shard's order. Raises InputError if the shard cannot be
        read."""
        if shard not in self._keys:
            dataset, file = self.dataset(shard), self.files[shard]
            self._keys[shard] = dataset.keys if dataset.path == file else [k for k in _keys_in(file) if k in dataset]
        return self._keys[shard]

    def sample(self, shard: int, key: str) -> Sample:
        return self.dataset(shard)[key]

    def dataset(self, shard: int) -> Dataset:
        """Returns the dataset to which the shard belongs; if there is none, the shard as a dataset."""
        file = self.files[shard]
        if file not in self._datasets:
            folder = os.path.dirname(os.path.dirname(file))
            dataset = next((d for d in self._datasets.values() if d.path == folder), None)
            if dataset is None and os.path.exists(os.path.join(folder, "manifest.json")):
                dataset = Dataset(Store(folder))
            if dataset is None or file not in _files_of(dataset, None):
                dataset = Dataset(Store(file))
            self._datasets[file] = dataset
        return self._datasets[file]


class Reading:
    """The samples that one reader reads in one epoch, in the order in which it reads them."""

    def __init__(self, shards: Shards, *, readers: int = 1, reader: int = 0, shuffle: int = 0, rng: Any = None) -> None:
        """`shuffle`: number of samples in the buffer from which samples are taken at random; 0: the shards' order. The
        buffer needs little memory, since samples are read only when they are taken. `rng(k)` returns a random
        generator: k = 0 for the order of shards, the same for all readers; k = 1 + reader for the order of this
        reader's samples."""
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
        for index, first, last in share(sizes, self.readers, self.reader):
            yield from ((order[index], key) for key in self.shards.keys(order[index])[first:last])


def _shuffled(items: Iterator[Any], size: int, rng: np.random.Generator) -> Iterator[Any]:
    """Yields the items in random order: each is taken at random from a buffer of `size` items."""
    buffer: list[Any] = []
    for item in items:
        buffer.append(item)
        if len(buffer) < size:
            continue
        index = int(rng.integers(len(buffer)))
        buffer[index], buffer[-1] = buffer[-1], buffer[index]
        yield buffer.pop()
    for index in rng.permutation(len(buffer)):
        yield buffer[index]


class _Bytes(io.FileIO):
    """A file that allocates memory only for bytes that it has, whatever the headers in it state."""

    def read(self, size: int | None = -1) -> bytes:
        remaining = max(os.fstat(self.fileno()).st_size - self.tell(), 0)
        return super().read(remaining if size is None or size < 0 else min(size, remaining))


def _keys_in(file: str) -> list[str]:
    if not os.path.isfile(file):  # opening a pipe would wait for ever
        raise InputError(f"{file}: is not a file")
    try:
        with _Bytes(file) as content, tarfile.open(fileobj=content, mode="r:") as shard:
            return list(dict.fromkeys(member.name.partition(".")[0] for member in shard))
    except (OSError, ValueError, OverflowError, tarfile.TarError) as e:
        raise InputError(f"{file}: cannot be read as a shard: {e}") from None


def _files_of(dataset: Dataset, split: str | None) -> list[str]:
    """Returns the files of all shards that may contain samples of the dataset."""
    if dataset.manifest is None or not os.path.isdir(dataset.path):
        raise InputError(f"{dataset.path} is not the folder of a dataset: give the files of shards as a list")
    listed = dataset.manifest["shards"]
    splits = {shard["split"] for shard in listed} if dataset.whole else set(dataset.splits)
    if split is not None:
        require_known(f"split of {dataset.path}", split, sorted(splits))
        splits = {split}
    return [os.path.join(dataset.path, shard["file"]) for shard in listed if shard["split"] in splits]
