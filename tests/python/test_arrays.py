"""Scenes of arrays, and objects that the caller places: what is scanned is where the arrays and the poses say."""

import pickle
import unittest
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np

import scanmill

FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    + [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)
LIDAR = scanmill.sensor("vlp_16", columns=720)
LEVEL = {"columns": 3600, "rate_hz": 10, "elevation_deg": [0], "range_m": [0.1, 200]}  # one horizontal ring
ORIGIN = {"position": [0, 0, 0]}


def box(size, middle=(0, 0, 0)):
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return {"vertices": corners * size + middle, "triangles": FACES}


def scene_of(*parts):
    return scanmill.Scene.from_arrays(parts)


def at(x, y=0.0, z=0.0, yaw=0.0):
    return scanmill.pose_matrix({"position": [x, y, z], "yaw_deg": yaw})


class Arrays(unittest.TestCase):
    def test_a_box_is_where_its_arrays_are(self):
        scene = scene_of({"name": "box", "class": "car", **box(2)})
        for distance in (3, 10, 40):
            scan = scene.scan(LEVEL, {"position": [-distance, 0, 0.3]})
            front = np.abs(scan.world_xyz()[:, 0] + 1) < 1e-3
            self.assertAlmostEqual(scan.range[front].min(), distance - 1, places=4)
            # The beams that hit the front are those within its angle.
            self.assertAlmostEqual(front.sum(), 3600 / np.pi * np.arctan(1 / (distance - 1)), delta=1.5)
            self.assertEqual(set(scan.label), {scene.ontology.id_of("car")})
            self.assertEqual(set(scan.instance), {1})

    def test_an_array_is_the_same_as_the_primitive_of_a_file(self):
        arrays = scanmill.load_scene("primitives")
        arrays.remove("crate")
        arrays.add({"class": "object", "material": "wood", **box([1, 1.5, 1])}, name="mine", pose=at(6, 2, 0.5, 30))
        one = arrays.scan(LIDAR, {"position": [0, 0, 1.5]}, effects=["intensity"])
        other = scanmill.load_scene("primitives").scan(LIDAR, {"position": [0, 0, 1.5]}, effects=["intensity"])
        np.testing.assert_array_equal(one.label, other.label)
        np.testing.assert_allclose(one.range, other.range, atol=1e-5)
        np.testing.assert_allclose(one.intensity, other.intensity, rtol=1e-4)

    def test_classes_things_and_materials_of_triangles(self):
        first, second = box(1, (5, 2, 0)), box(1, (5, -2, 0))
        both = np.concatenate([FACES, FACES + 8])
        half = np.arange(24) < 12
        scene = scene_of(
            {
                "vertices": np.concatenate([first["vertices"], second["vertices"]]),
                "faces": both,
                "class": np.where(half, "car", "truck"),
                "material": np.where(half, "concrete", "rubber"),
                "instance": np.where(half, 17, 4),
            }
        )
        scan = scene.scan(LIDAR, ORIGIN)
        left = scan.xyz[:, 1] > 0
        self.assertEqual({*scan.label[left]}, {scene.ontology.id_of("car")})
        self.assertEqual({*scan.label[~left]}, {scene.ontology.id_of("truck")})
        self.assertEqual(({*scan.instance[left]}, {*scan.instance[~left]}), ({2}, {1}))
        self.assertEqual(scene.objects()["part 1"].instances, [1, 2])

    def test_power_follows_from_reflectance_and_colour(self):
        def power(**keys):
            scene = scene_of({"class": "building", **box(2, (6, 0, 0)), **keys})
            return scene.scan(LIDAR, ORIGIN, effects=["intensity"]).intensity.mean()

        self.assertAlmostEqual(power(reflectance=0.4) / power(reflectance=0.2), 2, places=3)
        self.assertAlmostEqual(power(reflectance=np.full(12, 0.4)), power(reflectance=0.4), places=6)
        grey = ((0.5 + 0.055) / 1.055) ** 2.4
        self.assertAlmostEqual(power(color=[0.5, 0.5, 0.5]) / power(reflectance=1.0), grey, delta=0.001)
        for colours in (np.full((12, 3), 128, np.uint8), np.full((8, 4), 128, np.uint8)):
            self.assertAlmostEqual(power(color=colours) / power(reflectance=1.0), grey, delta=0.004)

    def test_meshes_of_other_libraries(self):
        own = box(2, (6, 0, 0))
        expected = scene_of({"class": "car", **own}).scan(LIDAR, ORIGIN)
        open3d = SimpleNamespace(vertices=own["vertices"], triangles=own["triangles"], vertex_colors=[])
        trimesh = SimpleNamespace(vertices=own["vertices"], faces=FACES, visual=SimpleNamespace(kind=None))
        for mesh in (open3d, trimesh):
            scan = scene_of({"mesh": mesh, "class": "car"}).scan(LIDAR, ORIGIN)
            np.testing.assert_array_equal(scan.xyz, expected.xyz)
        trimesh.visual = SimpleNamespace(kind="face", face_colors=np.full((12, 4), 255, np.uint8))
        white = scene_of({"mesh": trimesh, "class": "car"}).scan(LIDAR, ORIGIN, effects=["intensity"])
        given = scene_of({"class": "car", "reflectance": 1.0, **own}).scan(LIDAR, ORIGIN, effects=["intensity"])
        np.testing.assert_allclose(white.intensity, given.intensity)

    def test_map_coordinates_lose_nothing(self):
        far = np.array([691_000.0, 5_334_000.0, 500.0])
        near = scene_of({"class": "car", **box(2, (6, 1, 0))}).scan(LIDAR, ORIGIN)
        scan = scene_of({"class": "car", **box(2, far + [6, 1, 0])}).scan(LIDAR, {"position": far})
        np.testing.assert_allclose(scan.xyz, near.xyz, atol=1e-4)

    def test_arrays_do_not_follow_later_changes_and_pickle(self):
        part = {"class": "car", **box(2, (6, 0, 0))}
        scene = scene_of(part)
        before = scene.scan(LIDAR, ORIGIN)
        part["vertices"] += 1
        again = pickle.loads(pickle.dumps(scene)).scan(LIDAR, ORIGIN)
        np.testing.assert_array_equal(before.xyz, again.xyz)

    def test_results_are_handed_on_without_copies(self):
        scan = scene_of({"class": "car", **box(2, (6, 0, 0))}).scan(LIDAR, ORIGIN)
        self.assertTrue(np.shares_memory(np.from_dlpack(scan.xyz), scan.xyz))
        self.assertTrue(np.shares_memory(np.from_dlpack(scan.label), scan.label))

    def test_what_is_wrong_is_told_with_array_and_row(self):
        good = {"name": "box", "class": "car", **box(1)}
        nan = good["vertices"].copy()
        nan[3, 1] = np.nan
        for keys, message in (
            ({"vertices": nan}, r"^part 'box': vertices\[3\] = \[-0.5, nan, 0.5\] is not finite$"),
            ({"vertices": np.zeros((4, 2))}, r"vertices must have the shape \(n, 3\), not \(4, 2\)"),
            ({"triangles": [[0, 1, 8]]}, r"triangles\[0\] = \[0, 1, 8\] has an index outside of 0 to 7"),
            ({"triangles": [[0.0, 1.0, 2.0]]}, r"triangles must be integers, not float64: use .astype\(int\)"),
            ({"triangles": []}, "there is no triangle"),
            ({"triangles": [[0, 0, 0], [1, 1, 2]]}, "part 'box': none of its triangles has an area"),
            ({"faces": FACES}, "give triangles or faces, not both"),
            ({"vertices": [[1, 2, 3j]]}, "not of complex128"),
            ({"class": 8}, "numbers of classes are no names"),
            ({"color": [1, 1, 1]}, "integers are from 0 to 255"),
            ({"class": "carr"}, "part 'box': .*carr.*did you mean 'car'"),
            ({"class": ["car"] * 5}, "array of 12 names"),
            ({"material": "stel"}, "part 'box': .*stel"),
            ({"reflectance": 1.5}, "reflectance.* = 1.5 is not between 0 and 1"),
            ({"reflectance": 0.5, "color": [1, 1, 1]}, "not both"),
            ({"color": np.ones((5, 3))}, "color has 5 rows, but the part has 12 triangles and 8 vertices"),
            ({"instance": np.full(12, -1)}, r"instance\[0\] = -1 is negative \(and 11 more rows\)"),
            ({"pose": np.eye(3)}, "a pose must be a matrix of 4 x 4"),
            ({"clas": "car"}, "unknown key of a part 'clas'.*did you mean 'class'"),
            ({"vertices": None}, "needs `vertices` and `triangles`"),
        ):
            with self.subTest(message=message), self.assertRaisesRegex(ValueError, message):
                scene_of({**good, **keys}).scan(LIDAR, ORIGIN)
        with self.assertRaisesRegex(scanmill.InputError, "has an object of this name"):
            scene_of(good, good)
        primitives = scanmill.load_scene("primitives")
        primitives.add(good, name="crate")
        with self.assertRaisesRegex(scanmill.InputError, "part 'crate': the scene has an object of this name"):
            primitives.scan(LIDAR, ORIGIN)
        primitives.scan(LIDAR, ORIGIN)  # the part was not added
        primitives.remove("nix")
        with self.assertRaisesRegex(scanmill.InputError, r"remove\(\): 'nix' is neither an object"):
            primitives.scan(LIDAR, ORIGIN)
        primitives.remove("crate")
        self.assertNotIn("crate", primitives.objects())
        with self.assertRaisesRegex(scanmill.InputError, "the scene is empty"):
            scene_of().scan(LIDAR, ORIGIN)
        with self.assertRaisesRegex(scanmill.InputError, "needs a list of parts"):
            scanmill.Scene.from_arrays(good)


class Placed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = scanmill.load_scene("primitives")
        cls.here = {"position": [0, 0, 1.5]}

    def scan(self, **keys):
        return self.scene.scan(LIDAR, self.here, **keys)

    def test_objects_where_they_are_change_nothing(self):
        still, objects = self.scan(), self.scene.objects()
        self.assertIn("crate", objects)
        np.testing.assert_allclose(objects["crate"].pose, at(6, 2, 0.5, 30), atol=1e-12)
        placed = self.scan(poses={name: own.pose for name, own in objects.items()})
        np.testing.assert_array_equal(placed.label, still.label)
        np.testing.assert_allclose(placed.xyz, still.xyz, atol=1e-5)
        np.testing.assert_array_equal(self.scan(poses={}).xyz, placed.xyz)

    def test_what_is_left_out_is_as_if_removed(self):
        hidden = self.scan(poses={"ball": None, "bollard": None})
        other = scanmill.load_scene("primitives")
        other.remove("ball")
        other.remove("bollard")
        removed = other.scan(LIDAR, self.here)
        np.testing.assert_array_equal(hidden.label, removed.label)
        np.testing.assert_allclose(hidden.xyz, removed.xyz, atol=1e-5)
        self.assertGreater(len(hidden), 0)

    def test_moving_all_is_moving_the_sensor_back(self):
        scene = scene_of({"name": "a", "class": "car", **box(2)}, {"name": "b", "class": "tree", **box(1)})
        poses = {"a": at(6, 1, 0, 20), "b": at(5, -3, 0, 70)}
        frame = scanmill.pose_matrix({"position": [300, -20, 4], "yaw_deg": 35, "roll_deg": 5})
        one = scene.scan(LIDAR, np.eye(4), poses=poses)
        other = scene.scan(LIDAR, frame, poses={name: frame @ pose for name, pose in poses.items()})
        np.testing.assert_allclose(one.xyz, other.xyz, atol=2e-4)
        np.testing.assert_array_equal(one.label, other.label)

    def test_beams_meet_what_moves_where_it_is_then(self):
        wall = scene_of({"name": "wall", "class": "car", **box([0.2, 400, 4])})
        speed = 20.0
        scan = wall.scan(
            LEVEL, ORIGIN, poses={"wall": at(30.1)}, velocities={"wall": [-speed, 0, 0]}, columns=["time", "velocity_x"]
        )
        ahead = np.abs(scan.xyz[:, 1]) < 10
        self.assertGreater(ahead.sum(), 300)
        np.testing.assert_allclose(scan.xyz[ahead, 0], 30 - speed * scan.time[ahead], atol=1e-4)
        self.assertGreater(np.ptp(scan.xyz[ahead, 0]), 0.1)
        np.testing.assert_allclose(scan.velocity_x, -speed, atol=1e-3)

    def test_what_turns_turns_about_its_origin(self):
        plate = scene_of({"name": "plate", "class": "car", **box([0.02, 8, 4])})
        rate = 2.0
        scan = plate.scan(
            LEVEL, ORIGIN, poses={"plate": at(20)}, velocities={"plate": [0, 0, 0, 0, 0, rate]}, columns=["time"]
        )
        angle = rate * scan.time
        # The distance from the plate's middle plane is half of its thickness. A chord replaces the arc of a revolution.
        off = np.cos(angle) * (scan.xyz[:, 0] - 20) + np.sin(angle) * scan.xyz[:, 1]
        self.assertLess(np.abs(np.abs(off) - 0.01).max(), 4 * rate**2 * 0.1**2 / 8 + 0.01)

    def test_a_vehicle_that_moves_sees_the_world_stand_still(self):
        times = np.linspace(0, 0.1, 6)
        poses = np.array([at(2 * t / 0.1, 0, 1.5, 30 * t / 0.1) for t in times])
        scan = self.scene.scan(LIDAR, poses, pose_times=times)
        floor = scan.label == self.scene.ontology.id_of("ground")
        world = scan.world_xyz()
        np.testing.assert_allclose(world[floor, 2], 0, atol=1e-4)
        sign = scan.label == self.scene.ontology.id_of("traffic_sign")
        np.testing.assert_allclose(world[sign, 0], 15, atol=1e-3)
        self.assertEqual(scan.poses.shape, (720, 4, 4))
        np.testing.assert_allclose(scan.poses[360], at(1, 0, 1.5, 15), atol=1e-6)
        each = self.scene.scan(LIDAR, scan.poses)
        np.testing.assert_allclose(each.xyz, scan.xyz, atol=1e-5)

    def test_things_of_towns_are_moved_from_outside(self):
        town = scanmill.load_scene("town", seed=6)
        cars = {name: own for name, own in town.objects().items() if name.startswith("car ")}
        name, car = next(iter(cars.items()))
        lidar = scanmill.sensor("vlp_16", columns=360)
        scan = town.scan(lidar, {"position": [0, 0, 80]}, poses={name: at(6, 0, 80 - 1)}, time=3.0)
        mine = scan.instance == car.instances[0]
        self.assertGreater(mine.sum(), 50)
        self.assertLess(np.abs(scan.world_xyz()[mine] - [6, 0, 80]).max(), 4)

    def test_the_same_in_every_thread(self):
        def scan(k):
            return self.scan(poses={"crate": at(4 + 0.1 * (k % 4), 1, 0.5)}).xyz

        with ThreadPoolExecutor(4) as pool:
            scans = list(pool.map(scan, range(16)))
        for k in range(16):
            np.testing.assert_array_equal(scans[k], scan(k))

    def test_what_is_wrong_is_told(self):
        for keys, message in (
            ({"poses": {"crat": np.eye(4)}}, "poses: the scene has no object 'crat' .*did you mean 'crate'"),
            ({"poses": {"crate": 2 * np.eye(4)}}, "poses: 'crate': .*must be a rotation"),
            ({"poses": {"ball": at(1), "crate": {"positon": [1, 2, 3]}}}, "poses: 'crate': .*position"),
            ({"velocities": {"crate": [1, 0, 0]}}, "velocities: 'crate' is not in `poses`"),
            ({"poses": {"crate": None}, "velocities": {"crate": [1, 0, 0]}}, "'crate' is left out"),
            ({"poses": {"crate": at(1)}, "velocities": {"crate": "fast"}}, "velocities: 'crate' must have 3 or 6"),
            ({"poses": [at(1)]}, "poses must be a map from names"),
            ({"poses": {1: at(1)}}, "must be a text, not 1"),
            ({"time": float("nan")}, "time must be a finite number"),
            ({"poses": {"crate": at(1)}, "velocities": {"crate": [1, 0]}}, "velocities: 'crate' must have 3 or 6"),
            ({"poses": {"crate": at(1)}, "method": "particle"}, "poses: the method particle cannot trace moving"),
            ({"pose_times": [0, 1]}, "there is only one pose"),
        ):
            with self.subTest(message=message), self.assertRaisesRegex(scanmill.InputError, message):
                self.scan(**keys)
        for pose in (None, [], 3, [[1, 2], [3]], "here"):
            with self.subTest(pose=pose), self.assertRaisesRegex(scanmill.InputError, "a pose must be a matrix"):
                self.scene.scan(LIDAR, pose)
        with self.assertRaisesRegex(scanmill.InputError, "5 poses, but the sensor has 720 columns"):
            self.scene.scan(LIDAR, np.tile(np.eye(4), (5, 1, 1)))
        with self.assertRaisesRegex(scanmill.InputError, "must cover the revolution, 0 to 0.1 s after `time`, not 0 to 0.05 s"):
            self.scene.scan(LIDAR, np.tile(np.eye(4), (2, 1, 1)), pose_times=[0, 0.05])


if __name__ == "__main__":
    unittest.main()
