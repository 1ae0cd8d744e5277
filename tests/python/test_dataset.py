"""A generated dataset reads back as its manifest says."""

import json
import os
import pickle
import shutil
import tarfile
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from support import CLASSES, dataset_path, without_first_scan

import scanmill
from scanmill.geometry import transformed
from scanmill.shards import Reading, Shards

# Signed, since torch lacks the unsigned types that the files have.
DTYPES = {"label": np.int32, "instance": np.int64, "ring": np.int32, "column": np.int32, "intensity": np.float32}


class DatasetTest(unittest.TestCase):
    def setUp(self):
        self.path = dataset_path(self)
        self.dataset = scanmill.open(self.path)
        self.manifest = json.loads((Path(self.path) / "manifest.json").read_text())

    def first_shard(self):
        return os.path.join(self.path, self.manifest["shards"][0]["file"])

    def copied_shard(self, folder):
        """The first shard without the dataset that it is part of."""
        return shutil.copy(self.first_shard(), folder)


class Samples(DatasetTest):
    def test_are_those_of_the_manifest(self):
        keys = [sample["key"] for sample in self.manifest["samples"]]
        self.assertEqual(self.dataset.keys, keys)
        self.assertEqual([sample.key for sample in self.dataset], keys)
        self.assertEqual(len(self.dataset), len(keys))
        for recorded, sample in zip(self.manifest["samples"], self.dataset):
            self.assertEqual(sample.split, recorded["split"])
            self.assertEqual(f"{sample.sequence}-{sample.frame:06d}", sample.key)
            self.assertEqual(sample.time, recorded["scans"][0]["time"])
            self.assertEqual(sample.sensors, list(dict.fromkeys(scan["sensor"] for scan in recorded["scans"])))
            self.assertEqual(recorded["draws"], {"effects.1.range_noise.sigma_m": 0.02})
            self.assertEqual(sample.draws, {"effects.1.range_noise.sigma_m": 0.02})

    def test_have_voxels_about_each_sensor(self):
        voxels = self.dataset[1].voxels()
        self.assertEqual(set(voxels), {"label", "input", "invalid", "unseen", "low", "size"})
        self.assertEqual(voxels["label"].shape, (40, 20, 8))
        exact = self.dataset[1].scan()
        cells = np.floor((exact.xyz - voxels["low"]) / voxels["size"]).astype(int)
        inside = ((cells >= 0) & (cells < voxels["label"].shape)).all(axis=1)
        held = np.zeros(voxels["label"].shape, bool)
        held[tuple(cells[inside].T)] = True
        # Voxels lie a 2048th of their edge lower than floor() takes them to.
        self.assertLess((held != voxels["input"]).mean(), 0.002)
        self.assertGreater((voxels["label"] > 0).mean(), 0.01)
        self.assertNotEqual(self.dataset[1].voxels("rear")["input"].sum(), voxels["input"].sum())

    def test_splits_and_sequences_hold_each_sample_once(self):
        for parts in (self.dataset.splits, self.dataset.sequences):
            self.assertEqual(sorted(key for keys in parts.values() for key in keys), sorted(self.dataset.keys))
        for name, keys in self.dataset.splits.items():
            self.assertEqual(self.dataset.split(name).keys, keys)
            self.assertEqual(self.dataset.split(name).splits, {name: keys})
        for name, keys in self.dataset.sequences.items():
            times = [sample.time for sample in self.dataset.sequence(name)]
            self.assertEqual(times, sorted(times))

    def test_are_found_by_number_and_by_key(self):
        key = self.dataset.keys[-1]
        self.assertEqual(self.dataset[-1].key, key)
        self.assertEqual(self.dataset[key].index, len(self.dataset) - 1)
        self.assertIn(key, self.dataset)
        self.assertEqual(self.dataset[1:].keys, self.dataset.keys[1:])
        last = self.dataset[1:][::-1]
        self.assertEqual(last[0].key, key)
        np.testing.assert_array_equal(last[0].scan().xyz, self.dataset[key].scan().xyz)

    def test_that_are_not_there_are_named(self):
        with self.assertRaises(IndexError):
            self.dataset[len(self.dataset)]
        with self.assertRaisesRegex(scanmill.InputError, "no sample 'nothing'"):
            self.dataset["nothing"]
        for ask in (self.dataset.split, self.dataset.sequence):
            with self.assertRaises(scanmill.InputError):
                ask("nothing")

    def test_parts_pickle(self):
        part = self.dataset[1:3]
        other = pickle.loads(pickle.dumps(part))
        self.assertEqual(other.keys, part.keys)
        np.testing.assert_array_equal(other[0].scan().xyz, part[0].scan().xyz)

    def test_threads_can_share_a_dataset(self):
        with ThreadPoolExecutor(4) as pool:
            read = list(pool.map(lambda i: self.dataset[i].scan().xyz, range(len(self.dataset))))
        for sample, xyz in zip(self.dataset, read):
            np.testing.assert_array_equal(sample.scan().xyz, xyz)


class Scans(DatasetTest):
    def scans(self):
        for recorded, sample in zip(self.manifest["samples"], self.dataset):
            for scan in recorded["scans"]:
                yield scan, sample.scan(scan["sensor"], revolution=scan.get("revolution", 0))

    def test_of_a_faster_sensor_are_its_revolutions(self):
        sample = self.dataset[0]
        self.assertEqual((sample.revolutions(), sample.revolutions("rear")), (1, 2))
        first, second = (sample.scan("rear", revolution=r) for r in range(2))
        self.assertAlmostEqual(second.start_time - first.start_time, 0.05)
        np.testing.assert_array_equal(sample.scan("rear").xyz, first.xyz)
        self.assertFalse(np.array_equal(second.xyz, first.xyz))
        for wrong in (2, -1, "1"):
            with self.assertRaisesRegex(scanmill.InputError, "revolution"):
                sample.scan("rear", revolution=wrong)
        for read in (sample.scan, lambda revolution: self.dataset.store.read(0, revolution=revolution)):
            with self.assertRaisesRegex(scanmill.InputError, "no revolution 1 of the sensor 'top'"):
                read(revolution=1)

    def test_are_of_the_same_sensor_in_all_samples(self):
        with tempfile.TemporaryDirectory() as folder:
            dataset = scanmill.open(without_first_scan(self.path, folder))
            self.assertEqual([sample.has_scan() for sample in dataset[:3]], [True, False, True])
            sample = dataset[1]
            self.assertEqual((sample.sensors, sample.has_scan("REAR")), (["rear"], True))
            for ask in (sample.scan, sample.objects, sample.voxels, sample.revolutions):
                with self.assertRaisesRegex(scanmill.InputError, "no scan of the sensor 'top', which turns more slowly"):
                    ask()
            with self.assertRaisesRegex(scanmill.InputError, "no sensor 'nothing'"):
                sample.has_scan("nothing")

    def test_have_the_points_and_classes_that_the_manifest_counts(self):
        for recorded, scan in self.scans():
            self.assertEqual(len(scan), recorded["points"])
            self.assertEqual((scan.sensor, scan.method), (recorded["sensor"], recorded["method"]))
            if "label" in scan:
                labels, counts = np.unique(scan.dense().label, return_counts=True)
                expected = {c["id"]: c["points"] for c in recorded["points_per_class"]}
                self.assertEqual(dict(zip(labels.tolist(), counts.tolist())), expected)

    def test_have_the_columns_of_the_manifest(self):
        columns = [name for name in self.manifest["scans"]["columns"] if name not in "xyz"]
        for _, scan in self.scans():
            self.assertLessEqual(set(scan.names), set(columns))
            # Draco keeps times where it is asked to.
            self.assertLessEqual(set(columns) - set(scan.names), {"time"})
            self.assertEqual(scan.xyz.dtype, np.float32)
            for name in scan.names:
                self.assertEqual(scan[name].shape, scan.xyz.shape[:-1])
                self.assertEqual(scan[name].dtype, DTYPES.get(name, scan[name].dtype))
                self.assertTrue(scan[name].flags.writeable)

    def test_hold_the_columns_that_are_asked_for(self):
        whole = self.dataset[0].scan()
        name = whole.names[0]
        part = self.dataset[0].scan(columns=[name])
        self.assertEqual(part.names, (name,))
        np.testing.assert_array_equal(part[name], whole[name])
        self.assertEqual(self.dataset[0].scan(columns=[]).names, ())
        for wrong in (["nothing"], "label"):
            with self.assertRaises(scanmill.InputError):
                self.dataset[0].scan(columns=wrong)
        with self.assertRaises(scanmill.InputError):
            self.dataset[0].scan("nothing")

    def test_stand_where_the_manifest_says(self):
        for recorded, scan in self.scans():
            pose = recorded["world_from_sensor"][0]
            np.testing.assert_allclose(scan.world_from_sensor[:3, 3], pose["translation"])
            self.assertEqual(len(scan.poses), len(recorded["world_from_sensor"]))

    def test_beams_lead_to_their_points(self):
        """But for noise, a point lies on its beam."""
        for _, scan in self.scans():
            dense = scan.dense()
            if "ring" not in dense or "column" not in dense or self.dataset.manifest["scans"]["deskewed"]:
                self.skipTest("the dataset does not tell the beams of points")
            beams = self.dataset.beams(scan.sensor, scan.start_time)
            place = (dense["ring"], dense["column"])
            start = beams["origin"][place] if "origin" in beams else 0
            offset = dense.xyz - start
            along = (offset * beams["direction"][place]).sum(axis=1)
            self.assertGreater(np.median(along / np.linalg.norm(offset, axis=1)), 0.99999)

    def test_fill_range_images_without_loss(self):
        for _, scan in self.scans():
            dense = scan.dense()
            if "ring" not in dense or "column" not in dense:
                self.skipTest("the dataset does not tell the beams of points")
            pixels = scanmill.beam_projection(scan)
            own = pixels.pixel >= 0
            np.testing.assert_array_equal(pixels.points(pixels.image(dense.xyz))[own], dense.xyz[own])
            if "return" not in dense and pixels.mask.sum() == len(dense):
                self.assertTrue(own.all())

    def test_columns_of_range_images_look_in_one_direction(self):
        for sensor, staggered in (("top", True), ("rear", False)):
            scan = self.dataset[0].scan(sensor)
            step = 2 * np.pi / scan.columns
            azimuth = np.arctan2(scan.xyz[:, 1], scan.xyz[:, 0])
            for destagger in (False, True):
                pixels = scanmill.beam_projection(scan, destagger=destagger)
                nominal = step * (pixels.pixel % scan.columns)
                off = np.abs(np.angle(np.exp(1j * (azimuth - nominal)))).max() / step
                if staggered and not destagger:
                    self.assertGreater(off, 4)
                else:
                    self.assertLess(off, 0.51)
            stagger = self.dataset.stagger(sensor)
            self.assertEqual((len(stagger.shifts), stagger.columns), (scan.rings, scan.columns))

    def test_damaged_bytes_are_noticed(self):
        """Even where they can be decoded."""
        with tempfile.TemporaryDirectory() as folder:
            copy = shutil.copytree(self.path, os.path.join(folder, "copy"))
            shard = os.path.join(copy, self.manifest["shards"][0]["file"])
            with tarfile.open(shard) as members:
                member = next(m for m in members if m.name.endswith(".top.ray_tracing.pcd"))
                data = bytearray(members.extractfile(member).read())
            data[-1] ^= 1
            self.assertEqual(len(scanmill.decode(member.name, data)), len(scanmill.open(copy)[0].scan()))
            with open(shard, "r+b") as file:
                file.seek(member.offset_data)
                file.write(data)
            with self.assertRaisesRegex(scanmill.InputError, "changed since it was written"):
                scanmill.open(copy)[0].scan("top")
            self.assertGreater(len(scanmill.open(copy)[0].scan("rear")), 0)

    def test_are_read_from_any_current_folder(self):
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        os.chdir(os.path.dirname(self.path))
        dataset = scanmill.open(os.path.basename(self.path))
        shards = Shards([os.path.relpath(self.first_shard())])
        os.chdir("/")
        np.testing.assert_array_equal(dataset[0].scan().xyz, self.dataset[0].scan().xyz)
        self.assertEqual(shards.keys(0), [key for key in self.dataset.keys if key in shards.keys(0)])


class ObjectsTest(DatasetTest):
    def setUp(self):
        super().setUp()
        if self.dataset[0].objects() is None:
            self.skipTest("the dataset lists no objects")

    def test_agree_with_the_points(self):
        for sample in self.dataset:
            for sensor in sample.sensors:
                objects, scan = sample.objects(sensor), sample.scan(sensor).dense()
                counts = dict(zip(*(v.tolist() for v in np.unique(scan.instance, return_counts=True))))
                listed = dict(zip(objects.ids.tolist(), objects.points.tolist()))
                for instance, points in counts.items():
                    if instance != 0:
                        self.assertEqual(listed[instance], points)

    def test_boxes_are_about_their_points(self):
        """Of things that stand upright before a sensor that does, without noise; half of them where that is not so."""
        inside = total = 0
        for sample in self.dataset:
            for sensor in sample.sensors:
                objects, scan = sample.objects(sensor), sample.scan(sensor).dense()
                for box, instance in zip(objects.boxes(), objects.ids):
                    own = scan.xyz[scan.instance == instance]
                    inside += np.count_nonzero(scanmill.points_in_box(own, box, 0.3))
                    total += len(own)
        self.assertGreater(inside, 0.9 * total)

    def test_both_frames_tell_of_the_same_boxes(self):
        for sample in self.dataset:
            objects = sample.objects()
            still = objects.select(~objects.moves)
            # The sensor moves between the sample's time and that of the view, by less than a length of a car.
            apart = transformed(sample.scan().world_from_sensor, still.centers) - still.world_boxes()[:, :3]
            self.assertLess(np.linalg.norm(apart, axis=1).max(initial=0), 5)
            speeds = np.linalg.norm(objects.velocities, axis=1)
            np.testing.assert_allclose(speeds, np.linalg.norm(objects.world_velocities, axis=1), atol=1e-9)
            self.assertEqual(objects.boxes().shape, (len(objects), 7))

    def test_are_chosen_like_arrays(self):
        objects = self.dataset[0].objects()
        seen = objects.select(objects.points > 0)
        self.assertEqual(len(seen), np.count_nonzero(objects.points))
        self.assertEqual(len(seen.names), len(seen))
        self.assertEqual(len(seen.world_from_box), len(seen))
        self.assertEqual(len(objects.select([]).boxes()), 0)

    def test_are_those_of_the_sample(self):
        sample = self.dataset[0]
        ids = {listed["id"] for listed in sample.object_list()}
        views = [set(sample.objects(sensor).ids.tolist()) for sensor in sample.sensors]
        self.assertEqual(set.union(*views), ids)
        with self.assertRaises(scanmill.InputError):
            sample.objects("nothing")

    def test_are_read_with_the_points(self):
        ids = [name for name in self.dataset.ontology.names if name in self.dataset[0].objects().class_names]
        read = scanmill.SampleReader(boxes=ids[:2], min_points=1)
        sample = read(self.dataset[0])
        for label, class_id in zip(sample["box_label"], sample["box_class"]):
            self.assertEqual(self.dataset.ontology.name_of(class_id), ids[label])
        self.assertTrue((sample["box_points"] >= 1).all())
        everything = scanmill.SampleReader(boxes=True)(self.dataset[0])
        self.assertEqual(len(everything["boxes"]), len(self.dataset[0].objects()))


class Reader(DatasetTest):
    def test_adds_targets(self):
        table = self.dataset.ontology.train_ids()
        sample = scanmill.SampleReader(columns=[], train_ids=table)(self.dataset[0])
        labels = self.dataset[0].scan().dense().label
        np.testing.assert_array_equal(sample["target"], table[labels])
        self.assertEqual(sample["key"], self.dataset.keys[0])

    def test_hands_the_key_and_the_epoch_to_the_transform(self):
        read = scanmill.SampleReader(columns=[], transform=lambda sample, key, epoch: {"seen": (key, epoch)})
        self.assertEqual(read(self.dataset[0], 7), {"seen": (self.dataset.keys[0], 7)})

    def test_arguments_of_wrong_types_are_refused(self):
        for wrong in ({"columns": "label"}, {"columns": [1]}, {"boxes": "car"}, {"train_ids": ["road", "car"]}):
            with self.assertRaisesRegex(scanmill.InputError, next(iter(wrong))):
                scanmill.SampleReader(**wrong)
        for ask in (self.dataset[0].scan, self.dataset[0].objects, self.dataset[0].voxels, self.dataset.beams):
            with self.assertRaisesRegex(scanmill.InputError, "sensor"):
                ask(0)
        with self.assertRaisesRegex(scanmill.InputError, "decode"):
            scanmill.decode("a.pcd", "text")


class ShardFiles(DatasetTest):
    def test_a_shard_of_a_dataset_knows_the_manifest(self):
        shard = scanmill.open(self.first_shard())
        for sample in shard:
            np.testing.assert_array_equal(sample.scan().xyz, self.dataset[sample.key].scan().xyz)
            np.testing.assert_array_equal(sample.scan().world_from_sensor, self.dataset[sample.key].poses[
                sample.sensors[0]][0])

    def test_a_shard_by_itself(self):
        with tempfile.TemporaryDirectory() as folder:
            shard = scanmill.open(self.copied_shard(folder))
            self.assertIsNone(shard.manifest)
            self.assertIsNone(shard.ontology)
            self.assertEqual((shard.splits, shard[0].split, shard[0].poses), ({}, "", {}))
            scan = shard[0].scan()
            np.testing.assert_array_equal(scan.xyz, self.dataset[shard[0].key].scan(scan.sensor).xyz)
            self.assertIsNone(scan.world_from_sensor)

    def test_members_decode_by_their_names(self):
        with tarfile.open(self.first_shard()) as shard, tempfile.TemporaryDirectory() as folder:
            name = next(n for n in shard.getnames() if n.endswith((".pcd", ".drc", ".csv")))
            data = shard.extractfile(name).read()
            scan = scanmill.decode(name, data)
            key, sensor = name.split(".")[:2]
            np.testing.assert_allclose(scan.xyz, self.dataset[key].scan(sensor).xyz, atol=0.02)
            file = Path(folder) / name
            file.write_bytes(data)
            np.testing.assert_array_equal(scanmill.open(file)[0].scan().xyz, scan.xyz)
        for name, data in [("x.txt", b""), ("x.pcd", b"nothing")]:
            with self.assertRaises(scanmill.InputError):
                scanmill.decode(name, data)

    def test_all_ways_to_name_shards_give_all_samples(self):
        files = [os.path.join(self.path, shard["file"]) for shard in self.manifest["shards"]]
        for source in (self.path, self.dataset, files):
            seen = [sample.key for sample in Reading(Shards(source))]
            self.assertEqual(sorted(seen), sorted(self.dataset.keys))
        for name, keys in self.dataset.splits.items():
            for source in (Shards(self.path, name), Shards(self.dataset.split(name))):
                self.assertEqual(sorted(sample.key for sample in Reading(source)), sorted(keys))
        with tempfile.TemporaryDirectory() as folder:
            seen = [sample.key for sample in Reading(Shards(self.copied_shard(folder)))]
            self.assertEqual(seen, scanmill.open(self.first_shard()).keys)

    def test_wrong_shards_are_refused(self):
        for source, split in [([], None), (self.path, "nothing"), ([self.first_shard()], "train")]:
            with self.assertRaises(scanmill.InputError):
                Shards(source, split)
        with tempfile.TemporaryDirectory() as folder:
            broken = Path(folder) / "broken.tar"
            broken.write_bytes(b"nothing" * 200)
            with self.assertRaises(scanmill.InputError):
                list(Reading(Shards([broken])))


class Wrong(unittest.TestCase):
    def test_paths_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            for path in (folder, os.path.join(folder, "nothing")):
                with self.assertRaises(scanmill.InputError):
                    scanmill.open(path)

    def test_errors_are_pythons_too(self):
        self.assertTrue(issubclass(scanmill.InputError, ValueError))
        self.assertTrue(issubclass(scanmill.Error, RuntimeError))

    def test_an_ontology_needs_no_dataset(self):
        self.assertEqual(scanmill.Ontology(CLASSES).name, "small")


if __name__ == "__main__":
    unittest.main()
