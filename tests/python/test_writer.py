"""Datasets that a loop makes: the bytes of scanmill.generate, boxes of what is moved, and interruptions."""

import hashlib
import tempfile
import unittest
from pathlib import Path

import numpy as np
import scanmill

LIDAR = {
    "name": "top",
    "columns": 90,
    "rate_hz": 10,
    "elevation_deg": [4, 0, -2, -4, -8, -12],
    "range_m": [0.5, 60],
    "mount": {"position": [0, 0, 1.5]},
}
NOISE = ["intensity", {"range_noise": {"sigma_m": 0.02}}]
PLACES = [{"position": [0.5 * i, -6, 0], "yaw_deg": 30 * (i % 2)} for i in range(5)]
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-0.5, 0.5) for z in (0, 1)], float)
FACES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4]]


def digests(folder):
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in Path(folder).rglob("*.tar")}


class Writer(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = Path(folder.name) / "loop"
        self.scene = scanmill.load_scene("primitives")

    def write(self, places=PLACES, stop=99, **options):
        self.made = []  # whether add() has scanned each sample
        with scanmill.DatasetWriter(self.out, LIDAR, effects=NOISE, shard_samples=2, **options) as writer:
            for i, place in enumerate(places):
                if i == stop:
                    raise KeyboardInterrupt
                self.made.append(writer.add(self.scene, place, time=0.1 * i) is not None)
        return writer.dataset

    def test_the_bytes_are_those_of_generate(self):
        dataset = self.write(boxes=True)
        pipeline = {
            "scenes": [{"scene": "primitives"}],
            "trajectories": [{"name": "drive", "poses": PLACES, "every_s": 0.1}],
            "sensors": [LIDAR],
            "effects": NOISE,
            "method": "ray_tracing",
            "motion": "none",
            "output": {"formats": ["pcd"], "objects": True, "shard_samples": 2},
        }
        other = scanmill.generate(pipeline, self.out.with_name("generated"), quiet=True)
        self.assertEqual(dataset.keys, other.keys)
        with self.assertRaisesRegex(scanmill.InputError, "does not list objects of the class 'tree'"):
            scanmill.SampleReader(boxes=["tree"])(dataset[0])
        self.assertEqual(digests(self.out), digests(other.path))
        self.assertEqual(scanmill.verify(dataset, quiet=True), [])

    def test_an_interrupted_loop_goes_on_with_the_same_bytes(self):
        whole = digests(self.write().path)
        self.assertRaisesRegex(scanmill.InputError, "overwrite", self.write)
        with self.assertRaises(KeyboardInterrupt):
            self.write(stop=3, overwrite=True)
        self.assertEqual(digests(self.out), whole, "what is replaced stays until then")
        with self.assertRaisesRegex(scanmill.InputError, "at another pose"):
            self.write([PLACES[1], *PLACES[1:]], resume=True)
        self.scene.add({"class": "car", "vertices": CORNERS, "triangles": FACES}, name="cart", pose={"position": [3, -6, 0]})
        with self.assertRaisesRegex(scanmill.InputError, "other bytes than in the interrupted run"):
            self.write(resume=True)
        self.scene = scanmill.load_scene("primitives")
        self.assertEqual(digests(self.write(resume=True).path), whole)
        self.assertEqual(self.made, [True, False, True, True, True], "the first of each shard is compared")
        self.write(resume=True)
        self.assertEqual(self.made, [True, False, False, False, False])
        self.assertRaisesRegex(scanmill.Error, "complete with 5 samples", self.write, PLACES[:3], resume=True)

    def test_an_interrupted_loop_must_move_objects_alike(self):
        self.scene.add({"class": "car", "vertices": CORNERS, "triangles": FACES}, name="cart", pose={"position": [3, -6, 0]})

        def loop(speed, stop=9, resume=True):
            with scanmill.DatasetWriter(self.out, LIDAR, effects=NOISE, shard_samples=2, resume=resume) as writer:
                for i in range(3):
                    if i == stop:
                        raise KeyboardInterrupt
                    moved = {"poses": {"cart": {"position": [3, -6, 0]}}, "velocities": {"cart": [speed * (i == 1), 0, 0]}}
                    writer.add(self.scene, PLACES[0], time=0.1 * i, **moved)

        self.assertRaises(KeyboardInterrupt, loop, 1, 2, False)
        self.assertRaisesRegex(scanmill.InputError, "other poses or velocities of objects", loop, 2)
        loop(1)

    def test_one_writer_at_a_time(self):
        with scanmill.DatasetWriter(self.out, LIDAR, effects=None) as writer:
            writer.add(self.scene, PLACES[0], split="val")
            with self.assertRaisesRegex(scanmill.InputError, "being written by process"):
                scanmill.DatasetWriter(self.out, LIDAR, resume=True)
            with self.assertRaisesRegex(scanmill.InputError, "name of a split"):
                writer.add(self.scene, PLACES[1], drive="other", split="../val")
            with self.assertRaisesRegex(scanmill.InputError, "belong in one split, but it is 'val' and 'train'"):
                writer.add(self.scene, PLACES[1], split="train")
        self.assertEqual(list(writer.dataset.splits), ["val"])
        self.assertRaisesRegex(scanmill.InputError, "complete", writer.add, self.scene, PLACES[1])

    def test_boxes_follow_what_is_moved(self):
        self.scene.add({"class": "car", "vertices": CORNERS, "triangles": FACES}, name="cart", pose={"position": [0, -20, 0]})
        with scanmill.DatasetWriter(self.out, LIDAR, effects=NOISE, boxes=True) as writer:
            for i in range(3):
                pose = {"position": [6 - i, -6, 0], "yaw_deg": 20 * i}
                moved = {"pose": PLACES[0], "time": 0.1 * i, "poses": {"cart": pose}, "velocities": {"cart": [-10, 0, 0]}}
                scan = writer.add(self.scene, **moved)
                alone = self.scene.scan(LIDAR, effects=NOISE, boxes=True, frame=i, **moved)
                for objects in (scan.objects, alone.objects):
                    own = objects.select([objects.names.index("cart")])
                    np.testing.assert_allclose(own.world_boxes()[0], [6 - i, -6, 0.5, 2, 1, 1, np.radians(20 * i)], atol=1e-6)
                    np.testing.assert_allclose(own.world_velocities[0], [-10, 0, 0], atol=1e-6)
                    self.assertEqual(own.beams[0], own.beams_alone[0])
                    self.assertGreater(own.beams[0], 0)
                    inside = scanmill.points_in_box(scan.xyz, own.boxes()[0], margin=0.15)
                    self.assertTrue((scan.instance[inside] == own.ids[0]).all())
                self.assertNotIn("cart", self.scene.scan(LIDAR, PLACES[0], boxes=True, poses={"cart": None}).objects.names)
        sample = writer.dataset[2].objects()
        np.testing.assert_array_equal(sample.world_boxes(), scan.objects.world_boxes())
        np.testing.assert_array_equal(sample.points, scan.objects.points)


if __name__ == "__main__":
    unittest.main()
