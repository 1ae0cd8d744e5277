"""Datasets and batches for PyTorch. This is the only module that needs torch.

    from scanmill.torch import ScanDataset, collate_padded
    loader = DataLoader(ScanDataset("out/town", "train"), batch_size=4, collate_fn=collate_padded, num_workers=4)

Both datasets return dictionaries of numpy arrays (see scanmill.samples.SampleReader), of types that torch has, which
are then collated to tensors.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import torch
import torch.utils.data
from numpy.typing import NDArray

from ._core import InputError
from .augment import generator
from .batch import pad_batch
from .dataset import Dataset, Path, open_dataset
from .range_image import beam_projection, range_image
from .samples import SampleReader
from .scan import Stagger
from .shards import Reading, Shards, Source
from .words import names_in

Batch = dict[str, Any]

_KINDS = {np.dtype(np.uint16): np.int32, np.dtype(np.uint32): np.int64, np.dtype(np.uint64): np.int64}


def tensor(values: NDArray[Any]) -> torch.Tensor:
    """Returns an array as a tensor. If torch lacks the array's type, uses the next larger type that torch has."""
    return torch.from_numpy(np.ascontiguousarray(values, _KINDS.get(values.dtype, values.dtype)))


class _Epoch:
    """An integer in shared memory, so that persistent workers see it change from epoch to epoch."""

    def __init__(self) -> None:
        self._shared = torch.zeros(1, dtype=torch.int64).share_memory_()

    def set(self, epoch: int) -> None:
        self._shared[0] = epoch

    def get(self) -> int:
        return int(self._shared[0])


class ScanDataset(torch.utils.data.Dataset):  # type: ignore[type-arg]
    """A map-style dataset: one scan of each sample of a dataset, by index: the first revolution of the sensor.

    Samples without a scan of the sensor are left out, and a warning states their number. There may be such samples if a
    revolution of the sensor takes longer than the time between frames.
    """

    def __init__(self, source: Dataset | Path, split: str | None = None, **reading: Any) -> None:
        """`source`: a dataset or its path; for several sets, scanmill.open([a, b], weights=[1, 4]). An epoch has each
        sample as often as the weight of its set, each time with other random numbers. `reading`: arguments of
        SampleReader (sensor, columns, train_ids, boxes, min_points, transform, mix, seed). Raises InputError for an
        unknown split."""
        dataset = source if isinstance(source, Dataset) else open_dataset(source)
        self.dataset = dataset if split is None else dataset.split(split)
        self.reader = SampleReader(**reading)
        with_scan = [i for i, sample in enumerate(self.dataset) if sample.has_scan(self.reader.sensor)]
        if len(with_scan) < len(self.dataset):
            _warn_of_skipped(len(self.dataset) - len(with_scan), self.dataset.path)
            self.dataset = self.dataset.select(with_scan)
        self._weights = self.dataset.weights
        repetitions = np.arange(self._weights.max(initial=0))[:, np.newaxis]
        self._order = np.argwhere(repetitions < self._weights)  # (len(self), 2): repetition, index of the sample
        self._epoch = _Epoch()

    def set_epoch(self, epoch: int) -> None:
        """Sets the epoch, which determines the random numbers of mix and transform together with the sample. Workers
        use it from their next sample on."""
        self._epoch.set(epoch)

    def __len__(self) -> int:
        return len(self._order)

    def __getitem__(self, index: int) -> dict[str, Any]:
        repetition, number = self._order[int(index)].tolist()
        return self.reader(self.dataset[number], self._epoch.get() * int(self._weights[number]) + repetition)


class ShardIterable(torch.utils.data.IterableDataset):  # type: ignore[type-arg]
    """An iterable dataset: reads the scans of shards sequentially, for disks and networks that are slow at random
    access.

    Shards are divided among the ranks of torch.distributed and the workers of the loader. If there are fewer shards
    than readers, samples are divided instead. Each sample is read once per epoch by one of all ranks and workers. Ranks
    may have different numbers of samples, so use torch.distributed.algorithms.join.Join to synchronise gradients. The
    sensor's first revolution in each sample is read; samples without a scan of the sensor are skipped, and each reader
    warns of their number at the end of its epoch.
    """

    def __init__(
        self,
        source: Source,
        split: str | None = None,
        *,
        shuffle: int = 0,
        seed: int = 0,
        rank: int | None = None,
        world_size: int | None = None,
        **reading: Any,
    ) -> None:
        """`source`: a dataset, the path of a dataset or of a shard, or a list of shards' paths.

        `shuffle`: 0 for the order of the shards. A larger number shuffles the shards, and takes samples at random from
        a buffer of this size (which needs little memory); the order depends on seed and epoch. `rank` and `world_size`:
        taken from torch.distributed by default, if it is running. `reading`: see ScanDataset, but without `mix`, since
        the other sample would be read out of order. Raises InputError for a `mix`, and if there are no shards.
        """
        if shuffle < 0 or seed < 0:
            raise InputError("shuffle and seed must be at least 0")
        if reading.get("mix") is not None:
            raise InputError("ShardIterable reads sequentially and cannot mix samples: use ScanDataset")
        self.shards = Shards(source, split)
        self.shuffle, self.seed = shuffle, seed
        self.rank, self.world_size = _place_among_ranks(rank, world_size)
        self.reader = SampleReader(**reading)
        self._epoch = _Epoch()

    def set_epoch(self, epoch: int) -> None:
        """Sets the epoch, which changes the order and the transform's random numbers from the next iteration on."""
        self._epoch.set(epoch)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        worker = torch.utils.data.get_worker_info()
        workers, number = (worker.num_workers, worker.id) if worker is not None else (1, 0)
        epoch = self._epoch.get()
        reading = Reading(
            self.shards,
            readers=self.world_size * workers,
            reader=number * self.world_size + self.rank,  # so that consecutive shards are read by different ranks
            shuffle=self.shuffle,
            rng=lambda position: generator(self.seed, 0, epoch, position),
        )
        skipped = 0
        for sample in reading:
            if sample.has_scan(self.reader.sensor):
                yield self.reader(sample, epoch)
            else:
                skipped += 1
        if skipped:
            _warn_of_skipped(skipped, sample.dataset.path)


def _warn_of_skipped(number: int, path: str) -> None:
    warnings.warn(f"{path}: {number} samples are left out, since they have no scan of the sensor", stacklevel=3)


def _place_among_ranks(rank: int | None, world_size: int | None) -> tuple[int, int]:
    if (rank is None) != (world_size is None):
        raise InputError("give rank and world_size together")
    if rank is None or world_size is None:
        distributed = torch.distributed
        if distributed.is_available() and distributed.is_initialized():
            return distributed.get_rank(), distributed.get_world_size()
        return 0, 1
    if not 0 <= rank < world_size:
        raise InputError(f"rank {rank} is not one of {world_size}")
    return rank, world_size


def _shared_names(samples: Sequence[dict[str, Any]]) -> list[str]:
    names = list(samples[0])
    if any(set(sample) != set(names) for sample in samples):
        raise InputError("the samples of a batch must have the same columns")
    return names


def collate_padded(samples: Sequence[dict[str, Any]], ignore: int = 255) -> Batch:
    """Returns a batch of B scans, padded to the length of the longest.

    Points: `xyz` float32 (B, N, 3), columns (B, N), `mask` bool (B, N), which is False for padding. Boxes, if samples
    have boxes: `boxes` (B, M, 7), `box_...` (B, M, ...), `box_mask` bool (B, M). `world_from_sensor` is float64 (B, 4,
    4). Texts are lists, `stagger` is left out. `target` is padded with `ignore`, the train id of labels that are not
    learned; other arrays with 0.
    """
    batch: Batch = {}
    for name in _shared_names(samples):
        values = [sample[name] for sample in samples]
        if name == "stagger":
            continue
        if isinstance(values[0], str):
            batch[name] = values
        elif name == "world_from_sensor":
            batch[name] = torch.stack([tensor(v) for v in values])
        else:
            padded, mask = pad_batch(values, ignore if name == "target" else 0)
            batch[name] = tensor(padded)
            if name in ("xyz", "boxes"):
                batch["mask" if name == "xyz" else "box_mask"] = tensor(mask)
    return batch


class CollateRangeImages:
    """Makes batches of B range images with rings x columns pixels, using the columns `ring` and `column`.

    `rings`, `columns` and `destagger` are as for beam_projection(), whose description also states for which sensors the
    images have more columns. `image` float32 (B, k, rings, columns) has one channel for each of
    `channels`; pixels without a return are 0. `mask` bool (B, rings, columns) is True for pixels with a return.
    `target` int64 (B, rings, columns), if samples have it, is `ignore` for pixels without a return. `index` int64 (B,
    rings, columns) is the index of the pixel's point in its sample; -1 if there is none. Boxes, poses and texts are the
    same as in collate_padded().
    """

    def __init__(
        self,
        rings: int,
        columns: int,
        channels: Sequence[str] = ("range", "x", "y", "z", "intensity"),
        ignore: int = 255,
        destagger: bool | Stagger = True,
    ) -> None:
        self.rings, self.columns = rings, columns
        self.channels = names_in("channels", channels)
        self.ignore = ignore
        self.destagger = destagger

    def __call__(self, samples: Sequence[dict[str, Any]]) -> Batch:
        kept = ("key", "sensor", "world_from_sensor")
        without_points = [{k: v for k, v in sample.items() if k in kept or k.startswith("box")} for sample in samples]
        batch = collate_padded(without_points)
        layout: dict[str, Any] = {"rings": self.rings, "columns": self.columns, "destagger": self.destagger}
        projections = [beam_projection(sample, **layout) for sample in samples]
        images = [range_image(sample, channels=self.channels, **layout) for sample in samples]
        batch["image"] = tensor(np.stack(images))
        batch["index"] = tensor(np.stack([p.index for p in projections]))
        batch["mask"] = batch["index"] >= 0
        if "target" in _shared_names(samples):
            targets = [p.image(sample["target"], self.ignore) for p, sample in zip(projections, samples)]
            batch["target"] = tensor(np.stack(targets))
        return batch
