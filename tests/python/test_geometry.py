"""Poses are rotations and translations, whatever way they are written; boxes hold what lies in them."""

import unittest

import numpy as np
from support import box_of_points

import scanmill
from scanmill.geometry import between, matrix_of, pose_matrix, quaternion_of, transformed


def rotations(count):
    q = np.random.default_rng(1).normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


class Poses(unittest.TestCase):
    def test_quaternions_and_matrices_tell_the_same(self):
        half_turns = np.eye(4)
        for q in [*rotations(200), *half_turns]:
            back = quaternion_of(matrix_of(q, [1, 2, 3]))
            self.assertAlmostEqual(abs(back @ q), 1, places=12)

    def test_matrices_turn_and_do_not_stretch(self):
        matrices = matrix_of(rotations(50), np.zeros((50, 3)))[:, :3, :3]
        products = matrices @ matrices.transpose(0, 2, 1)
        np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), atol=1e-12)
        np.testing.assert_allclose(np.linalg.det(matrices), 1)

    def test_yaw_turns_forward_to_the_left_and_a_positive_pitch_looks_down(self):
        forward = [[1.0, 0, 0]]
        np.testing.assert_allclose(transformed(pose_matrix({"yaw_deg": 90}), forward), [[0, 1, 0]], atol=1e-12)
        self.assertLess(transformed(pose_matrix({"pitch_deg": 10}), forward)[0, 2], 0)
        left_up = transformed(pose_matrix({"roll_deg": 90}), [[0, 1.0, 0]])
        np.testing.assert_allclose(left_up, [[0, 0, 1]], atol=1e-12)

    def test_angles_are_applied_roll_first_and_yaw_last(self):
        both = pose_matrix({"position": [1, 2, 3], "yaw_deg": 30, "pitch_deg": 20, "roll_deg": 10})
        parts = [pose_matrix({"yaw_deg": 30}), pose_matrix({"pitch_deg": 20}), pose_matrix({"roll_deg": 10})]
        np.testing.assert_allclose(both[:3, :3], (parts[0] @ parts[1] @ parts[2])[:3, :3], atol=1e-12)
        np.testing.assert_array_equal(both[:3, 3], [1, 2, 3])

    def test_a_rotation_of_another_length_is_the_same_rotation(self):
        same = pose_matrix({"rotation": [2, 0, 0, 2]})
        np.testing.assert_allclose(same, pose_matrix({"yaw_deg": 90}), atol=1e-12)

    def test_single_precision_is_precise_enough(self):
        pose = matrix_of(rotations(1)[0], [100, 200, 3])
        np.testing.assert_allclose(pose_matrix(pose.astype(np.float32)), pose, rtol=1e-6)

    def test_what_is_no_pose_is_refused(self):
        mirrored = np.diag([1.0, -1, 1, 1])
        transposed = matrix_of([1, 0, 0, 0], [1, 2, 3]).T
        wrong = [np.eye(3), 2 * np.eye(4), mirrored, transposed, np.full((4, 4), np.nan), "pose", None, 3.0]
        wrong += [{"yaw": 3}, {"position": [1, 2]}, {"position": "x"}, {"yaw_deg": "x"}, {"yaw_deg": float("inf")}]
        wrong += [{"rotation": [0, 0, 0, 0]}, {"rotation": [1, 0, 0, 0], "yaw_deg": 3}]
        for pose in wrong:
            with self.subTest(pose=pose), self.assertRaises(scanmill.InputError):
                pose_matrix(pose)
        with self.assertRaisesRegex(scanmill.InputError, "yaw_deg"):
            pose_matrix({"yaw_dge": 3})

    def test_between_two_poses(self):
        q = rotations(40)
        for a, b in zip(q[::2], q[1::2]):
            first, last = matrix_of(a, [0, 0, 0]), matrix_of(b, [4, 8, 0])
            ends = between(first, last, [0, 1])
            np.testing.assert_allclose(ends, [first, last], atol=1e-12)
            # Two halves make the whole, and a half is never more than a quarter turn.
            middle = between(first, last, 0.5)
            half = np.linalg.inv(first) @ middle
            np.testing.assert_allclose((half @ half)[:3, :3], (np.linalg.inv(first) @ last)[:3, :3], atol=1e-7)
            self.assertGreaterEqual(np.trace(half[:3, :3]), 1 - 1e-9)
            np.testing.assert_allclose(middle[:3, 3], [2, 4, 0])

    def test_between_equal_poses(self):
        pose = matrix_of(rotations(1)[0], [1, 2, 3])
        np.testing.assert_allclose(between(pose, pose, [0.1, 0.9]), [pose, pose], atol=1e-12)

    def test_a_matrix_for_all_points_or_for_each(self):
        matrices = matrix_of(rotations(5), np.arange(15.0).reshape(5, 3))
        xyz = np.random.default_rng(2).normal(size=(5, 3))
        each = transformed(matrices, xyz)
        for matrix, point, result in zip(matrices, xyz, each):
            np.testing.assert_allclose(transformed(matrix, point), result)
            np.testing.assert_allclose(matrix[:3, :3] @ point + matrix[:3, 3], result)


class Boxes(unittest.TestCase):
    def test_hold_their_points(self):
        rng = np.random.default_rng(3)
        for _ in range(20):
            box, xyz = box_of_points(rng)
            self.assertTrue(scanmill.points_in_box(xyz, box).all())
            turned = [*box[:6], box[6] + np.pi]
            self.assertTrue(scanmill.points_in_box(xyz, turned).all())
            beyond = xyz + 2 * box[5] * np.array([0, 0, 1])
            self.assertFalse(scanmill.points_in_box(beyond, box).any())

    def test_a_margin_adds_on_all_sides(self):
        points = np.array([[1.05, 0, 0], [0, 0.55, 0], [0, 0, -0.3], [np.nan] * 3])
        box = [0, 0, 0, 2, 1, 0.5, 0]
        self.assertFalse(scanmill.points_in_box(points, box).any())
        np.testing.assert_array_equal(scanmill.points_in_box(points, box, 0.06), [True, True, True, False])


if __name__ == "__main__":
    unittest.main()
