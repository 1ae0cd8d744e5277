"""Scans give columns by name, and place points in the world."""

import copy
import pickle
import unittest

import numpy as np

import scanmill
from scanmill.geometry import pose_matrix


def organised(planes=2, rings=3, columns=4):
    """An image of two returns, whose second misses often; x tells ring and column."""
    shape = (planes * rings, columns)
    row, column = np.indices(shape)
    xyz = np.stack([row % rings * 10 + column, row // rings, np.ones(shape)], axis=-1).astype(np.float32)
    xyz[rings + 1 :] = np.nan
    xyz[0, 2] = np.nan
    return scanmill.Scan({"xyz": xyz, "label": (row * 100).astype(np.uint16)}, rings=rings, columns=columns)


class Columns(unittest.TestCase):
    scan = scanmill.Scan(
        {
            "xyz": np.array([[3, 4, 0], [0, 0, 2]], np.float32),
            "label": np.array([5, 6], np.uint16),
            "return": np.array([1, 2], np.uint8),
        },
        sensor="top",
    )

    def test_are_attributes_and_items(self):
        self.assertIs(self.scan.label, self.scan["label"])
        self.assertEqual(self.scan.names, ("label", "return"))
        self.assertIn("label", self.scan)
        self.assertIn("label", dir(self.scan))
        self.assertNotIn("ring", self.scan)
        with self.assertRaisesRegex(AttributeError, "did you mean 'label'"):
            self.scan.labl
        with self.assertRaisesRegex(scanmill.InputError, "did you mean 'label'"):
            self.scan["labl"]
        self.assertFalse(hasattr(self.scan, "ring"))

    def test_side_by_side(self):
        points = self.scan.points(["x", "range", "label"])
        self.assertEqual(points.dtype, np.float32)
        np.testing.assert_array_equal(points, [[3, 5, 5], [0, 2, 6]])
        with self.assertRaises(scanmill.InputError):
            self.scan.points(["x", "intensity"])
        with self.assertRaises(scanmill.InputError):
            self.scan.points("xyz")

    def test_are_copied_with_the_scan(self):
        for other in (pickle.loads(pickle.dumps(self.scan)), copy.deepcopy(self.scan)):
            np.testing.assert_array_equal(other.label, self.scan.label)
            self.assertEqual(other.sensor, "top")

    def test_of_chosen_points(self):
        chosen = self.scan.select(self.scan.label == 6)
        self.assertEqual((len(chosen), chosen["return"].tolist(), chosen.sensor), (1, [2], "top"))
        with self.assertRaises(scanmill.InputError):
            organised().select([0])


class Organised(unittest.TestCase):
    def test_misses_do_not_count(self):
        image = organised()
        dense = image.dense()
        self.assertEqual(len(image), 3 * 4 - 1 + 4)
        self.assertEqual(len(dense), len(image))
        self.assertEqual(len(image.points(["x", "label"])), len(image))
        self.assertIs(dense.dense(), dense)

    def test_places_become_ring_column_and_return(self):
        dense = organised().dense()
        np.testing.assert_array_equal(dense.xyz[:, 0], dense["ring"] * 10.0 + dense["column"])
        np.testing.assert_array_equal(dense.xyz[:, 1], dense["return"] - 1.0)
        self.assertNotIn("return", organised(planes=1).dense())


class World(unittest.TestCase):
    def test_of_a_sensor_that_stands(self):
        pose = pose_matrix({"position": [10, 0, 0], "yaw_deg": 90})
        scan = scanmill.Scan({"xyz": np.array([[1, 0, 0]], np.float32)}, poses=pose[None])
        np.testing.assert_allclose(scan.world_xyz(), [[10, 1, 0]], atol=1e-12)

    def test_of_a_sensor_that_moves(self):
        """A wall that stands still does so in the world, although each column sees it from somewhere else."""
        columns = 11
        place = np.linspace(0, 5, columns)
        poses = np.stack([pose_matrix({"position": [x, 0, 0]}) for x in (0, 5)])
        xyz = np.stack([20 - place, np.zeros(columns), np.zeros(columns)], axis=1).astype(np.float32)
        starts = np.linspace(0.01, 0.11, columns)
        column = {"column": np.arange(columns, dtype=np.uint16)}
        time = {"time": starts.astype(np.float32)}
        for known in (column, time, {**column, **time}):
            scan = scanmill.Scan({"xyz": xyz, **known}, poses=poses, column_starts=starts)
            np.testing.assert_allclose(scan.world_xyz()[:, 0], 20, atol=1e-5)
        image = scanmill.Scan({"xyz": xyz[None]}, poses=poses, column_starts=starts)
        np.testing.assert_allclose(image.world_xyz()[..., 0], 20, atol=1e-5)
        deskewed = scanmill.Scan({"xyz": xyz, **column}, poses=poses, column_starts=starts, deskewed=True)
        np.testing.assert_allclose(deskewed.world_xyz(), xyz)
        flash = scanmill.Scan({"xyz": xyz}, poses=poses, column_starts=np.zeros(columns))
        np.testing.assert_allclose(flash.world_xyz(), xyz)
        with self.assertRaisesRegex(scanmill.InputError, "column"):
            scanmill.Scan({"xyz": xyz}, poses=poses, column_starts=starts).world_xyz()

    def test_of_an_unknown_pose(self):
        with self.assertRaises(scanmill.InputError):
            scanmill.Scan({"xyz": np.zeros((2, 3), np.float32)}).world_xyz()


if __name__ == "__main__":
    unittest.main()
