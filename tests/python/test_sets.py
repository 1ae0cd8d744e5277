"""Several sets are one, recorded sets are read like datasets, and what is counted of them is right."""

import itertools
import pickle
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np
from support import dataset_path, needs_torch

import scanmill


def ordered(scan):
    """Points and labels in an order that does not depend on the file."""
    order = np.lexsort(scan.xyz.T.round(4))
    return scan.xyz[order], scan.label[order]


class Sets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.dataset = scanmill.open(dataset_path(cls()))
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        for layout in ("semantic_kitti", "nuscenes"):
            scanmill.export(cls.dataset, layout, cls.folder / layout, sensors=["top"], splits=["train", "val"], quiet=True)
        cls.kitti, cls.nuscenes = (scanmill.open(cls.folder / layout) for layout in ("semantic_kitti", "nuscenes"))

    def test_recorded_scans_are_those_that_were_exported(self):
        for recorded in pickle.loads(pickle.dumps([self.kitti, self.nuscenes])):
            self.assertEqual({name: len(keys) for name, keys in recorded.splits.items()}, {"train": 4, "val": 4})
            classes = recorded.ontology
            still = {c["id"]: classes.id_of(c["name"].replace("moving-", "")) for c in classes.classes()}
            for sequence in recorded.sequences:
                moved = []
                for b in recorded.sequence(sequence):
                    a = self.dataset[recorded.keys.index(b.key)]
                    moved.append(a.scan().world_from_sensor @ np.linalg.inv(b.scan().world_from_sensor))
                    np.testing.assert_allclose(moved[-1], moved[0], atol=1e-6)  # the origin of the world may be another
                    self.assertEqual((a.split, a.time), (b.split, b.time))
                    (xyz, label), (own_xyz, own_label) = ordered(b.scan()), ordered(a.scan())
                    np.testing.assert_allclose(xyz, own_xyz, atol=1e-6)
                    names = [self.dataset.ontology.name_of(i) for i in own_label]
                    self.assertEqual([still[i] for i in label.tolist()], [classes.id_of(name) for name in names])

    def test_the_folders_of_kittis_odometry_are_read_too(self):
        drive = shutil.copytree(self.folder / "semantic_kitti", self.folder / "odometry") / "sequences" / "08"
        (self.folder / "odometry" / "poses").mkdir()
        shutil.move(drive / "poses.txt", self.folder / "odometry" / "poses" / "08.txt")
        shutil.rmtree(drive / "labels")
        own = self.kitti.split("val")
        for path in (drive, drive / "velodyne"):
            recorded = scanmill.open(path)
            self.assertEqual((recorded.keys, recorded[0].scan().names), (own.keys, ("intensity",)))
            np.testing.assert_array_equal(recorded[2].scan().world_xyz(), own[2].scan().world_xyz())

    def test_joined_labels_are_those_of_the_names(self):
        """In each order of the sets; two classes of one set stay two."""
        for sets in itertools.permutations([self.dataset, self.kitti, self.nuscenes]):
            joined = pickle.loads(pickle.dumps(scanmill.open(sets)))
            id_of = joined.ontology.id_of
            self.assertEqual(len(set(joined.keys)), sum(len(one) for one in sets))
            self.assertEqual(len(set(joined.ontology.ids.tolist())), len(set(joined.ontology.names)))
            for one, name in zip(sets, joined.store.names):
                table = np.zeros(65536, int)
                table[one.ontology.ids] = [id_of(own) for own in one.ontology.names]
                self.assertEqual(len(set(table[one.ontology.ids])), len(one.ontology))
                for sample in one[::3]:
                    other = joined[f"{name}/{sample.key}"]
                    np.testing.assert_array_equal(other.scan().label, table[sample.scan().label])
                    np.testing.assert_array_equal(other.scan().xyz, sample.scan().xyz)
                    self.assertEqual(other.split, sample.split)
                    if one is self.dataset:
                        np.testing.assert_array_equal(other.objects().class_ids, table[sample.objects().class_ids])
                        np.testing.assert_array_equal(other.voxels()["label"], table[sample.voxels()["label"]])
            for a, b in [("person", "pedestrian"), ("vehicle.car", "car"), ("lane-marking", "road_marking")]:
                self.assertEqual(id_of(a), id_of(b))
            for a, b in [("wall", "fence"), ("static.manmade", "building"), ("other-object", "object")]:
                self.assertNotEqual(id_of(a), id_of(b))

    @needs_torch
    def test_an_epoch_has_each_set_as_often_as_it_weighs(self):
        from scanmill.torch import ScanDataset

        def mixed(sample, other, rng):
            return {**sample, "other": other["key"], "drawn": rng.random()}

        joined = scanmill.open([self.dataset, self.folder / "semantic_kitti"], weights=[1, 4])
        scans = ScanDataset(joined, "train", train_ids=joined.ontology.train_ids(["road"]), mix=mixed)
        keys, samples = scans.dataset.keys, [scans[i] for i in range(len(scans))]
        scans.set_epoch(1)
        samples += [scans[i] for i in range(-len(scans), 0)]
        self.assertRaises(IndexError, lambda: scans[len(scans)])
        self.assertEqual(sorted(sample["key"] for sample in samples), sorted([*2 * keys[:4], *8 * keys[4:]]))
        self.assertEqual(len({sample["drawn"] for sample in samples}), len(samples))
        self.assertEqual({sample["other"].split("/")[0] for sample in samples}, set(joined.store.names))
        self.assertEqual({"ring" in sample for sample in samples}, {False})  # only what both sets have

    def test_wrong_lists_are_refused(self):
        joined = scanmill.open([self.dataset, self.dataset])
        shard = shutil.copy(next(Path(self.dataset.path).rglob("*.tar")), self.folder / "alone.tar")
        for sets, weights in [([], None), ([self.dataset], [0]), ([self.dataset], [1.5]), ([self.dataset], [1, 1]),
                              ([joined], None), ([shard], None), (self.dataset.path, [1])]:  # fmt: skip
            self.assertRaises(scanmill.InputError, scanmill.open, sets, weights)

    def test_damaged_files_are_named(self):
        drive, tables = "semantic_kitti/sequences/00", "nuscenes/v1.0-trainval"
        for path, content, message in [
            (f"{drive}/velodyne/000001.bin", b"123", "000001.bin: has 3 bytes"),
            (f"{drive}/labels/000001.label", bytes(8), "000001.label: has 2 labels"),
            (f"{drive}/poses.txt", b"1 0 0", "poses.txt: must have 12"),
            (f"{drive}/poses.txt", b"1 0 0 0 0 1 0 0 0 0 1 0\n", "poses.txt: has 1 lines"),
            (f"{drive}/calib.txt", b"P0: 1\n", "calib.txt: has no line 'Tr:'"),
            (f"{drive}/label_2/a", b"", "`scanmill view`"),
            *((f"{tables}/{name}.json", text, "unpack") for name in ("scene", "ego_pose") for text in (b"{", b"[]", b"[1]")),
        ]:
            with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(scanmill.InputError, message):
                file = Path(folder) / path
                root = shutil.copytree(self.folder / Path(path).parts[0], Path(folder) / Path(path).parts[0])
                file.parent.mkdir(exist_ok=True)
                file.write_bytes(content)
                scanmill.open(root)[1].scan()

    def test_points_of_classes_are_counted(self):
        for one in (self.dataset, self.kitti, scanmill.open([self.nuscenes, self.kitti, self.dataset])):
            labels = np.concatenate([sample.scan().label for sample in one.split("train")])
            counts = one.class_counts("train")
            self.assertEqual(sum(counts.values()), len(labels))
            for name, points in counts.items():
                self.assertEqual(points, np.count_nonzero(labels == one.ontology.id_of(name)))
            first, second = points = sorted(counts.values())[-2:]
            table = one.ontology.train_ids([name for n in points for name in counts if counts[name] == n])
            weights = one.class_weights(table, "train")
            np.testing.assert_allclose(weights, 1 / np.log(1.02 + np.array(points) / (first + second)), rtol=1e-6)

    def test_ontologies_are_read_by_name_and_path(self):
        path = f"{scanmill.resource_folder}/labels/nuscenes.yaml"
        self.assertEqual(scanmill.ontology(path).names, scanmill.ontology("nuscenes").names)
        self.assertRaisesRegex(scanmill.InputError, "nothing", scanmill.ontology, "nothing")

    def test_a_known_confusion(self):
        confusion = scanmill.ConfusionMatrix(["road", "car", "person"])
        confusion.add([0, 0, 0, 1, 1, 255, 1], [0, 0, 1, 1, 0, 2, 255])
        confusion.add(np.uint8([[1]]), np.int64([[1]]))
        np.testing.assert_array_equal(confusion.matrix, [[2, 1, 0], [1, 2, 0], [0, 0, 0]])
        np.testing.assert_array_equal(confusion.iou(), [0.5, 0.5, np.nan])
        self.assertEqual((confusion.miou, confusion.accuracy), (0.5, 4 / 6))
        self.assertRegex(str(confusion), r"car +3 +50.0 %")
        for target, predicted in (([0, 3], [0, 0]), ([0], [-1]), ([0], [0, 1])):
            self.assertRaises(scanmill.InputError, confusion.add, target, predicted)


if __name__ == "__main__":
    unittest.main()
