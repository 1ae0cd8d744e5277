"""PyTorch's loaders see every sample once, and the same augmentation whatever the number of workers."""

import itertools
import tempfile
import unittest

import numpy as np
from support import dataset_path, needs_torch, random_sample, without_first_scan

import scanmill
from scanmill.augment import Compose, Flip, Jitter, Turn, mix

try:
    import torch
    from torch.utils.data import DataLoader

    from scanmill.torch import CollateRangeImages, ScanDataset, ShardIterable, collate_padded, tensor
except ImportError:
    pass  # the tests are skipped

AUGMENT = Compose([Flip(), Turn(), Jitter()], seed=3)


def keys_of(batches):
    return sorted(key for batch in batches for key in batch["key"])


@needs_torch
class Batches(unittest.TestCase):
    def setUp(self):
        rng = np.random.default_rng(1)
        self.samples = [random_sample(rng, boxes=n, each=10 * n) for n in (1, 4, 2)]
        for sample in self.samples:
            sample["target"] = np.zeros(len(sample["xyz"]), np.int64)
            sample["column"] = np.arange(len(sample["xyz"])).astype(np.uint16)

    def test_types_that_torch_lacks_become_larger_ones(self):
        for kind, larger in [("uint16", "int32"), ("uint32", "int64"), ("uint8", "uint8"), ("float32", "float32")]:
            highest = np.array([np.iinfo(kind).max if kind.startswith("u") else 1.5], kind)
            self.assertEqual(str(tensor(highest).dtype), f"torch.{larger}")
            self.assertEqual(tensor(highest).item(), highest.item())

    def test_are_padded(self):
        batch = collate_padded(self.samples)
        self.assertEqual(tuple(batch["xyz"].shape), (3, 160, 3))
        self.assertEqual(tuple(batch["boxes"].shape), (3, 4, 7))
        self.assertEqual(batch["mask"].sum(1).tolist(), [10, 160, 40])
        self.assertEqual(batch["box_mask"].sum(1).tolist(), [1, 4, 2])
        self.assertEqual(batch["key"], [sample["key"] for sample in self.samples])
        self.assertTrue((batch["target"][~batch["mask"]] == 255).all())
        self.assertEqual(batch["world_from_sensor"].dtype, torch.float64)
        for row, sample in enumerate(self.samples):
            own = batch["mask"][row]
            np.testing.assert_array_equal(batch["xyz"][row][own].numpy(), sample["xyz"])
            np.testing.assert_array_equal(batch["ring"][row][own].numpy(), sample["ring"])

    def test_of_unlike_samples_are_refused(self):
        other = {name: values for name, values in self.samples[0].items() if name != "ring"}
        with self.assertRaises(scanmill.InputError):
            collate_padded([self.samples[0], other])

    def test_of_images(self):
        stagger = scanmill.Stagger(np.arange(16), 160)
        collate = CollateRangeImages(16, 160, channels=["range", "intensity"], ignore=9, destagger=stagger)
        batch = collate(self.samples)
        plain = CollateRangeImages(16, 160, channels=["range", "intensity"], destagger=False)(self.samples)
        for ring in range(16):
            self.assertTrue(torch.equal(batch["index"][:, ring], plain["index"][:, ring].roll(ring, 1)))
        self.assertEqual(tuple(batch["image"].shape), (3, 2, 16, 160))
        self.assertEqual(batch["mask"].sum((1, 2)).tolist(), [10, 160, 40])
        self.assertTrue((batch["target"][~batch["mask"]] == 9).all())
        self.assertTrue((batch["target"][batch["mask"]] == 0).all())
        self.assertEqual(tuple(batch["boxes"].shape), (3, 4, 7))
        for row, sample in enumerate(self.samples):
            hit = batch["mask"][row]
            points = batch["index"][row][hit].numpy()
            np.testing.assert_array_equal(batch["image"][row, 1][hit].numpy(), sample["intensity"][points])


@needs_torch
class Loaders(unittest.TestCase):
    def setUp(self):
        self.path = dataset_path(self)
        self.dataset = scanmill.open(self.path)

    def load(self, dataset, workers=0, batch_size=2, **options):
        return list(
            DataLoader(dataset, batch_size=batch_size, num_workers=workers, collate_fn=collate_padded, **options)
        )

    def test_by_number(self):
        for workers in (0, 2):
            batches = self.load(ScanDataset(self.path, columns=[]), workers, shuffle=True)
            self.assertEqual(keys_of(batches), sorted(self.dataset.keys))

    def test_a_split(self):
        for name, keys in self.dataset.splits.items():
            self.assertEqual(keys_of(self.load(ScanDataset(self.dataset, name, columns=[]))), sorted(keys))
            self.assertEqual(keys_of(self.load(ShardIterable(self.path, name, columns=[]))), sorted(keys))

    def test_samples_without_a_scan_of_the_sensor_are_left_out(self):
        with tempfile.TemporaryDirectory() as folder:
            dataset = scanmill.open(without_first_scan(self.path, folder))
            held = sorted(key for key in dataset.keys if key != dataset.keys[1])
            with self.assertWarnsRegex(UserWarning, "1 samples are left out"):
                self.assertEqual(keys_of(self.load(ScanDataset(dataset, columns=[]))), held)
            with self.assertWarnsRegex(UserWarning, "1 samples are left out"):
                self.assertEqual(keys_of(self.load(ShardIterable(dataset, columns=[]))), held)
            self.assertEqual(len(ScanDataset(dataset, sensor="rear")), len(dataset))
            with self.assertRaisesRegex(scanmill.InputError, "no sensor 'nothing'"):
                ScanDataset(dataset, sensor="nothing")

    def test_shards_are_seen_once_over_ranks_and_workers(self):
        for ranks, workers, shuffle in itertools.product((1, 2, 5), (0, 2), (0, 10)):
            with self.subTest(ranks=ranks, workers=workers, shuffle=shuffle):
                seen = []
                for rank in range(ranks):
                    shards = ShardIterable(self.path, shuffle=shuffle, rank=rank, world_size=ranks, columns=[])
                    seen += keys_of(self.load(shards, workers))
                self.assertEqual(sorted(seen), sorted(self.dataset.keys))

    def test_workers_do_not_change_the_augmentation(self):
        def points(dataset, workers):
            dataset.set_epoch(4)
            return {b["key"][0]: b["xyz"][0].numpy() for b in self.load(dataset, workers, batch_size=1)}

        reading = {"columns": ["ring"], "transform": AUGMENT}
        alone = points(ScanDataset(self.path, **reading), 0)
        for other in (
            points(ScanDataset(self.path, **reading), 2),
            points(ShardIterable(self.path, **reading), 0),
            points(ShardIterable(self.path, shuffle=10, **reading), 2),
        ):
            self.assertEqual(set(other), set(alone))
            for key, xyz in alone.items():
                np.testing.assert_array_equal(other[key], xyz)

    def test_workers_do_not_change_the_mix(self):
        def points(workers, epoch=1, seed=2, **order):
            mixes = mix.Choice([mix.LaserMix(), mix.PolarMix(swap=1)])
            dataset = ScanDataset(self.path, "train", columns=["ring"], mix=mixes, seed=seed, transform=AUGMENT)
            dataset.set_epoch(epoch)
            return {b["key"][0]: b["xyz"][0].numpy() for b in self.load(dataset, workers, batch_size=1, **order)}

        alone = points(0)
        for other in (points(2), points(1, shuffle=True)):
            self.assertEqual(set(other), set(alone))
            for key, xyz in alone.items():
                np.testing.assert_array_equal(other[key], xyz)
        for unlike in (points(0, seed=3), points(0, epoch=2)):
            self.assertFalse(all(np.array_equal(unlike[key], xyz) for key, xyz in alone.items()))
        with self.assertRaises(scanmill.InputError):
            ShardIterable(self.path, mix=mix.LaserMix())

    def test_workers_that_live_on_see_the_next_epoch(self):
        for dataset in (
            ScanDataset(self.path, columns=[], transform=AUGMENT),
            ShardIterable(self.path, shuffle=10, columns=[], transform=AUGMENT),
        ):
            loader = DataLoader(dataset, None, num_workers=1, persistent_workers=True, collate_fn=lambda sample: sample)
            epochs = []
            for epoch in (0, 1, 0):
                dataset.set_epoch(epoch)
                epochs.append({sample["key"]: sample["xyz"] for sample in loader})
            for key in self.dataset.keys:
                np.testing.assert_array_equal(epochs[0][key], epochs[2][key])
                self.assertFalse(np.array_equal(epochs[0][key], epochs[1][key]))

    def test_workers_may_be_spawned(self):
        for kind in (ScanDataset, ShardIterable):
            batches = self.load(kind(self.path, columns=[]), 1, batch_size=4, multiprocessing_context="spawn")
            self.assertEqual(keys_of(batches), sorted(self.dataset.keys))

    def test_range_images(self):
        if not {"ring", "column"} <= set(self.dataset[0].scan().names):
            self.skipTest("the dataset does not tell the beams of points")
        sensor = self.dataset.sensors[self.dataset[0].sensors[0]]
        table = self.dataset.ontology.train_ids()
        dataset = ScanDataset(self.path, columns=["ring", "column"], train_ids=table)
        collate = CollateRangeImages(sensor["rings"], sensor["columns"], channels=["range"])
        batch = next(iter(DataLoader(dataset, 2, collate_fn=collate)))
        self.assertEqual(tuple(batch["image"].shape), (2, 1, sensor["rings"], sensor["columns"]))
        self.assertEqual(batch["target"].shape, batch["mask"].shape)
        pixels = [scanmill.beam_projection(self.dataset[i].scan()) for i in range(2)]
        np.testing.assert_array_equal(batch["index"].numpy(), [p.index for p in pixels])

    def test_arrays_need_no_collation(self):
        samples = list(DataLoader(ScanDataset(self.path, boxes=True), batch_size=None))
        self.assertEqual([sample["key"] for sample in samples], self.dataset.keys)
        voxels = self.dataset[0].voxels()
        scans = [self.dataset[0].scan(), scanmill.load_scene("primitives").scan("vlp_16", np.eye(4))]
        arrays = [array for scan in scans for array in scan.dense().arrays().values()]
        for array in (*arrays, *voxels.values(), self.dataset.ontology.ids, self.dataset.ontology.train_ids(ignore=300)):
            np.testing.assert_array_equal(torch.as_tensor(array).numpy(), array)

    def test_wrong_ranks_are_refused(self):
        for wrong in ({"rank": 0}, {"world_size": 2}, {"rank": 2, "world_size": 2}, {"shuffle": -1}, {"seed": -1}):
            with self.assertRaises(scanmill.InputError):
                ShardIterable(self.path, **wrong)


if __name__ == "__main__":
    unittest.main()
