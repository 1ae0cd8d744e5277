"""Augmentation changes points, boxes and poses alike, and follows from seed, sample and epoch alone."""

import copy
import unittest

import numpy as np
from support import random_sample

import scanmill
from scanmill.augment import Compose, DropPoints, Flip, Jitter, RingErrors, Scale, Turn, generator
from scanmill.geometry import transformed

RIGID = [Flip("x", 1), Flip("y", 1), Flip("y", 0), Turn(), Turn(0.3, 0.3), Scale(0.5, 2)]
NOISE = [Jitter(), DropPoints(0.5), RingErrors(0.05, 0.01)]


def apply(transform, sample, index=0):
    return transform(sample, generator(1, index))


def distances(xyz):
    return np.linalg.norm(xyz[:, None] - xyz[None], axis=-1)


class Laws(unittest.TestCase):
    def setUp(self):
        self.sample = random_sample(np.random.default_rng(1))

    def test_inputs_do_not_change(self):
        for transform in RIGID + NOISE:
            before = copy.deepcopy(self.sample)
            after = apply(transform, self.sample)
            self.assertIsNot(after, self.sample)
            self.assertEqual(set(after), set(before))
            for name, values in before.items():
                np.testing.assert_array_equal(self.sample[name], values)
                if isinstance(values, np.ndarray):
                    self.assertEqual(after[name].dtype, values.dtype, name)

    def test_points_stay_in_their_boxes(self):
        for transform in RIGID + [DropPoints(0.5), Compose(RIGID + [DropPoints(0.5)], seed=3)]:
            for index in range(10):
                after = transform(self.sample, index) if isinstance(transform, Compose) else None
                after = apply(transform, self.sample, index) if after is None else after
                for number, box in enumerate(after["boxes"]):
                    own = after["xyz"][after["own"] == number]
                    self.assertGreater(len(own), 0)
                    self.assertTrue(scanmill.points_in_box(own, box, 1e-4).all())

    def test_points_stay_where_they_are_in_the_world(self):
        before = transformed(self.sample["world_from_sensor"], self.sample["xyz"])
        for transform in RIGID:
            after = apply(transform, self.sample)
            np.testing.assert_allclose(transformed(after["world_from_sensor"], after["xyz"]), before, atol=1e-4)

    def test_columns_that_tell_of_positions_follow_them(self):
        for transform in RIGID:
            after = apply(transform, self.sample)
            np.testing.assert_allclose(after["range_true"], np.linalg.norm(after["xyz"], axis=1), rtol=1e-5)
            azimuth = np.arctan2(after["xyz"][:, 1], after["xyz"][:, 0])
            apart = np.remainder(after["azimuth"] - azimuth + np.pi, 2 * np.pi) - np.pi
            np.testing.assert_allclose(apart, 0, atol=1e-5)

    def test_velocities_lead_where_the_points_go(self):
        """Moving along the velocity and then turning is turning and then moving along the turned velocity."""
        velocity = np.stack([self.sample[f"velocity_{axis}"] for axis in "xyz"], axis=1)
        later = {
            **self.sample,
            "xyz": self.sample["xyz"] + velocity,
            "boxes": self.sample["boxes"] + np.pad(self.sample["box_velocity"], [(0, 0), (0, 4)]),
        }
        for transform in RIGID:
            after, moved = apply(transform, self.sample), apply(transform, later)
            own = np.stack([after[f"velocity_{axis}"] for axis in "xyz"], axis=1)
            np.testing.assert_allclose(after["xyz"] + own, moved["xyz"], atol=1e-4)
            np.testing.assert_allclose(
                after["boxes"][:, :3] + after["box_velocity"], moved["boxes"][:, :3], atol=1e-4
            )

    def test_distances_stay_but_for_their_scale(self):
        before = distances(self.sample["xyz"][::10].astype(np.float64))
        for transform in RIGID:
            after = apply(transform, self.sample)
            scale = after["boxes"][0, 3] / self.sample["boxes"][0, 3]
            np.testing.assert_allclose(distances(after["xyz"][::10].astype(np.float64)), before * scale, atol=1e-3)
            np.testing.assert_allclose(after["boxes"][:, 3:6], self.sample["boxes"][:, 3:6] * scale, rtol=1e-5)

    def test_mirroring_twice_changes_nothing(self):
        for axis in "xy":
            twice = apply(Flip(axis, 1), apply(Flip(axis, 1), self.sample))
            np.testing.assert_array_equal(twice["xyz"], self.sample["xyz"])
            turned = np.remainder(twice["boxes"][:, 6] - self.sample["boxes"][:, 6] + 1, 2 * np.pi) - 1
            np.testing.assert_allclose(turned, 0, atol=1e-5)

    def test_samples_without_boxes_and_without_points(self):
        bare = {"xyz": self.sample["xyz"][:0], "ring": self.sample["ring"][:0]}
        for transform in RIGID + NOISE:
            self.assertEqual(len(apply(transform, bare)["xyz"]), 0)


class Noise(unittest.TestCase):
    def setUp(self):
        self.sample = random_sample(np.random.default_rng(2), boxes=20, each=500)

    def test_jitter_has_its_size(self):
        moved = apply(Jitter(0.01, 0.02), self.sample)["xyz"] - self.sample["xyz"].astype(np.float64)
        self.assertLessEqual(np.abs(moved).max(), 0.02 + 1e-5)
        # A normal distribution that is cut at two standard deviations has 0.96 of the spread.
        self.assertAlmostEqual(moved.std(), 0.0096, delta=0.0003)

    def test_points_are_dropped_with_their_columns(self):
        shares = []
        for index in range(200):
            after = apply(DropPoints(0.6), self.sample, index)
            shares.append(1 - len(after["xyz"]) / len(self.sample["xyz"]))
            self.assertEqual(len(after["intensity"]), len(after["xyz"]))
        np.testing.assert_array_equal(after["range_true"], np.linalg.norm(after["xyz"], axis=1))
        self.assertEqual(len(after["boxes"]), 20)
        self.assertLessEqual(max(shares), 0.62)
        self.assertAlmostEqual(np.mean(shares), 0.3, delta=0.04)
        self.assertEqual(len(apply(DropPoints(0), self.sample)["xyz"]), len(self.sample["xyz"]))

    def test_errors_are_those_of_the_ring(self):
        after = apply(RingErrors(0.05, 0.01), self.sample)
        before, moved = (s["xyz"].astype(np.float64) for s in (self.sample, after))

        def angles(xyz):
            flat = np.hypot(xyz[:, 0], xyz[:, 1])
            return np.hypot(flat, xyz[:, 2]), np.arctan2(xyz[:, 2], flat), np.arctan2(xyz[:, 1], xyz[:, 0])

        farther, higher, aside = (a - b for a, b in zip(angles(moved), angles(before)))
        np.testing.assert_allclose(aside, 0, atol=1e-5)
        for ring in range(16):
            own = self.sample["ring"] == ring
            self.assertLess(np.ptp(farther[own]), 1e-4)
            self.assertLess(np.ptp(higher[own]), 1e-4)
        self.assertGreater(farther.std(), 0.01)
        self.assertGreater(higher.std(), 0.002)

    def test_a_rings_errors_do_not_depend_on_other_rings(self):
        low = {name: v[self.sample["ring"] < 5] for name, v in self.sample.items() if name in ("xyz", "ring")}
        all_rings = apply(RingErrors(), self.sample)["xyz"][self.sample["ring"] < 5]
        np.testing.assert_array_equal(apply(RingErrors(), low)["xyz"], all_rings)

    def test_wrong_figures_are_refused(self):
        for make in (
            lambda: Flip("z"),
            lambda: Flip("x", 2),
            lambda: Turn(1, 0),
            lambda: Scale(0, 1),
            lambda: Jitter(-1),
            lambda: DropPoints(1.5),
            lambda: RingErrors(-1),
        ):
            with self.assertRaises(scanmill.InputError):
                make()

    def test_wrong_samples_are_refused(self):
        image = {"xyz": np.zeros((2, 2, 3), np.float32)}
        short = {"xyz": np.zeros((3, 3), np.float32), "label": np.zeros(2)}
        lone = {"xyz": np.zeros((3, 3), np.float32), "velocity_x": np.zeros(3)}
        for transform, sample in [(Turn(), image), (DropPoints(), short), (RingErrors(), short), (Turn(), lone)]:
            with self.assertRaises(scanmill.InputError):
                apply(transform, sample)


class Addresses(unittest.TestCase):
    """Random numbers follow from where they are used, not from what was drawn before."""

    def setUp(self):
        self.sample = random_sample(np.random.default_rng(3))
        self.compose = Compose(RIGID + NOISE, seed=5)

    def test_the_same_again_in_any_order(self):
        forward = [self.compose(self.sample, i, e)["xyz"] for i in range(4) for e in range(3)]
        backward = [self.compose(self.sample, i, e)["xyz"] for i in (3, 2, 1, 0) for e in (2, 1, 0)][::-1]
        for a, b in zip(forward, backward):
            np.testing.assert_array_equal(a, b)

    def test_another_seed_sample_or_epoch_is_another_result(self):
        results = [
            self.compose(self.sample, 1, 0),
            self.compose(self.sample, 2, 0),
            self.compose(self.sample, 1, 1),
            self.compose(self.sample, "town-s1-drive-000001", 0),
            Compose(RIGID + NOISE, seed=6)(self.sample, 1, 0),
        ]
        firsts = {result["xyz"][:3].tobytes() for result in results}
        self.assertEqual(len(firsts), len(results))

    def test_a_transform_does_not_change_what_others_draw(self):
        with_jitter = Compose([Turn(), Jitter(0, 0)], seed=5)(self.sample, 1)
        without = Compose([Turn()], seed=5)(self.sample, 1)
        np.testing.assert_array_equal(with_jitter["xyz"], without["xyz"])


if __name__ == "__main__":
    unittest.main()
