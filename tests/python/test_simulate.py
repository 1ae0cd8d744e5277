"""Scenes are scanned from anywhere: what is seen follows from pose, sensor and scene, and is the same each time."""

import pickle
import unittest
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import scanmill
from scanmill.simulate import MOST_SIMULATORS

LIDAR = scanmill.sensor("vlp_16", columns=180)
HERE = {"position": [0, 0, 1.5]}


class Simulation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = scanmill.load_scene("primitives")  # a floor at z = 0, and things on it

    def floor(self, scan):
        return scan.label == self.scene.ontology.id_of("ground")

    def test_the_floor_is_where_it_is_from_everywhere(self):
        for pose in (
            HERE,
            {"position": [3, -2, 1], "yaw_deg": 77},
            {"position": [-5, 4, 2], "pitch_deg": 5, "roll_deg": -3},
        ):
            scan = self.scene.scan(LIDAR, pose)
            floor = scan.world_xyz()[self.floor(scan)]
            self.assertGreater(len(floor), 100)
            np.testing.assert_allclose(floor[:, 2], 0, atol=1e-4)
            np.testing.assert_allclose(scan.world_from_sensor, scanmill.pose_matrix(pose), atol=1e-9)

    def test_maps_and_matrices_are_the_same_pose(self):
        pose = {"position": [1, 2, 1.5], "yaw_deg": 40, "pitch_deg": 3}
        one, other = self.scene.scan(LIDAR, pose), self.scene.scan(LIDAR, scanmill.pose_matrix(pose))
        np.testing.assert_array_equal(one.xyz, other.xyz)

    def test_mounts_are_relative_to_the_vehicle(self):
        mounted = scanmill.sensor("vlp_16", columns=180, mount={"position": [1, 0, 1.5], "yaw_deg": 90})
        scan = self.scene.scan(mounted, {"position": [0, 2, 0], "yaw_deg": 90})
        np.testing.assert_allclose(scan.world_from_sensor[:3, 3], [0, 3, 1.5], atol=1e-9)
        np.testing.assert_allclose(scan.world_from_sensor[:3, 0], [-1, 0, 0], atol=1e-9)

    def test_several_sensors_give_a_list(self):
        scans = self.scene.scan([scanmill.sensor("vlp_16", "left", columns=90), LIDAR], HERE)
        self.assertEqual([scan.sensor for scan in scans][0], "left")
        self.assertEqual(len(scans), 2)
        self.assertGreater(len(scans[1]), len(scans[0]))
        self.assertEqual(len(self.scene.scan(["vlp_16"], HERE)), 1)

    def test_the_same_each_time_and_in_every_thread(self):
        noise = [{"range_noise": {"sigma_m": 0.02}}]
        first = self.scene.scan(LIDAR, HERE, effects=noise, frame=3)
        with ThreadPoolExecutor(4) as pool:
            scans = list(pool.map(lambda _: self.scene.scan(LIDAR, HERE, effects=noise, frame=3), range(8)))
        drawn = [{"range_noise": {"sigma_m": {"choice": [0.02], "per": "frame"}}}]
        scans.append(self.scene.scan(LIDAR, HERE, effects=drawn, frame=3))
        for scan in [*scans, scanmill.load_scene("primitives").scan(LIDAR, HERE, effects=noise, frame=3)]:
            np.testing.assert_array_equal(scan.xyz, first.xyz)

    def test_noise_follows_from_seed_and_frame(self):
        noise = [{"range_noise": {"sigma_m": 0.02}}]
        scans = [
            self.scene.scan(LIDAR, HERE, effects=noise),
            self.scene.scan(LIDAR, HERE, effects=noise, frame=1),
            self.scene.scan(LIDAR, HERE, effects=noise, seed=2),
        ]
        clean = self.scene.scan(LIDAR, HERE)
        self.assertEqual(len({scan.xyz.tobytes() for scan in [*scans, clean]}), 4)
        for scan in scans:
            self.assertLess(np.abs(scan.range.mean() - clean.range.mean()), 0.01)

    def test_columns_are_those_asked_for(self):
        scan = self.scene.scan(LIDAR, HERE, columns=["label", "range_true"])
        self.assertEqual(set(scan.names), {"label", "range_true"})
        np.testing.assert_allclose(scan.range_true, scan.range, rtol=1e-4)
        with self.assertRaisesRegex(scanmill.InputError, "effects"):
            self.scene.scan(LIDAR, HERE, columns=["intensity"])
        self.assertIn("intensity", self.scene.scan(LIDAR, HERE, effects=["intensity"]))

    def test_normals_are_those_of_the_surfaces(self):
        pose = {"position": [-5, 4, 2], "yaw_deg": 30, "pitch_deg": 15, "roll_deg": -3}
        scan = self.scene.scan(LIDAR, pose, columns=["label", "incidence", "normal_oct"])
        along = (scan.normals * scan.xyz).sum(1) / scan.range
        np.testing.assert_allclose(along, -np.cos(scan.incidence), atol=2e-4)
        floor = scan.normals[self.floor(scan)] @ scan.world_from_sensor[:3, :3].T
        np.testing.assert_allclose(floor, np.broadcast_to([0, 0, 1], floor.shape), atol=7e-5)

    def test_organised_scans_are_the_dense_ones_as_images(self):
        image, dense = self.scene.scan(LIDAR, HERE, organised=True), self.scene.scan(LIDAR, HERE)
        self.assertEqual(image.xyz.shape, (16, 180, 3))
        self.assertEqual(len(image), len(dense))
        np.testing.assert_array_equal(scanmill.range_image(image), scanmill.range_image(dense))

    def test_frames_are_whole_numbers(self):
        for wrong in ({"frame": -1}, {"frame": 1.5}, {"frame": 2**32}, {"time": "now"}, {"time": np.inf}):
            with self.assertRaisesRegex(scanmill.InputError, next(iter(wrong))):
                self.scene.scan(LIDAR, HERE, **wrong)

    def test_what_was_set_up_stays_for_the_next_scan(self):
        scene = scanmill.load_scene("primitives")
        scene.scan(LIDAR, HERE)
        ready = list(scene._simulators.values())
        scene.scan(LIDAR, {"position": [1, 1, 1]}, time=2, frame=9)
        self.assertEqual(list(scene._simulators.values()), ready)
        for columns in range(10, 10 + 2 * MOST_SIMULATORS):
            scene.scan(scanmill.sensor("vlp_16", columns=columns), HERE)
        self.assertEqual(len(scene._simulators), MOST_SIMULATORS)

    def test_what_is_wrong_is_told_of_the_call_not_of_a_file_that_nobody_has(self):
        with self.assertRaisesRegex(scanmill.InputError, r"^scan\(\): there is no file .*primitive'.*did you mean"):
            scanmill.load_scene("primitive").scan(LIDAR, HERE)

    def test_scenes_and_scans_pickle(self):
        scene = pickle.loads(pickle.dumps(self.scene))
        scan = pickle.loads(pickle.dumps(self.scene.scan(LIDAR, HERE)))
        np.testing.assert_array_equal(scene.scan(LIDAR, HERE).xyz, scan.xyz)

    def test_the_limit_of_inputs_is_raised_not_lowered(self):
        with self.assertRaisesRegex(scanmill.InputError, "0.5"):
            scanmill.set_input_limit(0.5)
        scanmill.set_input_limit(1)

    def test_sensors_are_described_by_presets_and_keys(self):
        elevations = np.array([0.0, -5, -10])
        made = {"columns": np.int64(36), "rate_hz": 10, "elevation_deg": elevations, "range_m": [0.5, 100]}
        scan = self.scene.scan(made, HERE)
        self.assertLessEqual(scan["column"].max(), 35)
        self.assertEqual(
            scanmill.sensor("vlp_16", "top", {"position": [0, 0, 1]}, columns=90),
            {"preset": "vlp_16", "name": "top", "mount": {"position": [0, 0, 1]}, "columns": 90},
        )

    def test_ontology_needs_no_scan(self):
        self.assertIn("ground", scanmill.load_scene("primitives").ontology.names)

    def test_what_is_wrong_is_refused(self):
        nowhere = scanmill.load_scene("nothere")
        wrong = [
            lambda: nowhere.scan(LIDAR, HERE),
            lambda: self.scene.scan(scanmill.sensor("vlp_16", colums=3), HERE),
            lambda: self.scene.scan("no_such_preset", HERE),
            lambda: self.scene.scan([], HERE),
            lambda: self.scene.scan(LIDAR, np.eye(3)),
            lambda: self.scene.scan(LIDAR, HERE, columns="label"),
            lambda: self.scene.scan(scanmill.sensor("vlp_16", columns=float("nan")), HERE),
            lambda: self.scene.scan(scanmill.sensor("vlp_16", columns=object()), HERE),
        ]
        for scan in wrong:
            with self.assertRaises(scanmill.InputError):
                scan()


if __name__ == "__main__":
    unittest.main()
