"""Points become images of rings and columns, and images points."""

import unittest

import numpy as np

import scanmill


def points(rng, rings=8, columns=32, count=150):
    """Points of some of the beams, in any order."""
    beams = rng.permutation(rings * columns)[:count]
    xyz = rng.normal(size=(count, 3)).astype(np.float32)
    return {
        "xyz": xyz,
        "ring": (beams // columns).astype(np.uint16),
        "column": (beams % columns).astype(np.uint16),
        "label": rng.integers(1, 50, count).astype(np.uint16),
    }


class ByBeam(unittest.TestCase):
    def setUp(self):
        self.arrays = points(np.random.default_rng(1))
        shifts = np.random.default_rng(7).integers(0, 32, 8)
        self.scan = scanmill.Scan(self.arrays, rings=8, columns=32, stagger=scanmill.Stagger(shifts, 32))

    def test_there_and_back(self):
        pixels = scanmill.beam_projection(self.scan)
        labels = pixels.image(self.arrays["label"], fill=7)
        self.assertEqual((labels.shape, labels.dtype), ((8, 32), np.uint16))
        self.assertEqual(pixels.mask.sum(), 150)
        np.testing.assert_array_equal(pixels.points(labels), self.arrays["label"])
        self.assertTrue((labels[~pixels.mask] == 7).all())

    def test_values_may_have_several_figures(self):
        pixels = scanmill.beam_projection(self.scan)
        image = pixels.image(self.arrays["xyz"])
        self.assertEqual(image.shape, (8, 32, 3))
        np.testing.assert_array_equal(pixels.points(image), self.arrays["xyz"])

    def test_channels_are_images(self):
        image = scanmill.range_image(self.scan, channels=["x", "y", "z", "range", "label"], fill=-1)
        self.assertEqual((image.shape, image.dtype), ((5, 8, 32), np.float32))
        self.assertTrue(image.flags.c_contiguous)
        hit = scanmill.beam_projection(self.scan).mask
        np.testing.assert_allclose(np.linalg.norm(image[:3], axis=0)[hit], image[3][hit], rtol=1e-6)
        self.assertTrue((image[:, ~hit] == -1).all())

    def test_dictionaries_are_as_good_as_scans(self):
        same = scanmill.range_image({**self.arrays, "stagger": self.scan.stagger}, 8, 32, ["range"])
        np.testing.assert_array_equal(same, scanmill.range_image(self.scan))
        np.testing.assert_array_equal(same, scanmill.range_image(self.arrays, 8, 32, destagger=self.scan.stagger))

    def test_organised_scans_without_shifts_give_the_image_that_they_are(self):
        pixels = scanmill.beam_projection(self.scan, destagger=False)
        xyz = pixels.image(self.arrays["xyz"], np.nan)
        arrays = {"xyz": xyz, "label": pixels.image(self.arrays["label"])}
        scan = scanmill.Scan(arrays, rings=8, columns=32, stagger=self.scan.stagger)
        image = scanmill.range_image(scan, channels=["x", "label"], fill=np.nan, destagger=False)
        np.testing.assert_array_equal(image[0], xyz[..., 0])
        for destagger in (False, True):
            image, dense = (
                scanmill.range_image(one, channels=["x", "label"], fill=np.nan, destagger=destagger)
                for one in (scan, self.scan)
            )
            np.testing.assert_array_equal(image, dense)

    def test_rows_are_shifted_by_whole_columns(self):
        shifted, plain = (scanmill.beam_projection(self.scan, destagger=destagger) for destagger in (True, False))
        for ring, shift in enumerate(self.scan.stagger.shifts):
            np.testing.assert_array_equal(shifted.index[ring], np.roll(plain.index[ring], shift))
        partial = scanmill.beam_projection(self.scan, destagger=scanmill.Stagger(np.arange(8), 39))
        self.assertEqual(partial.index.shape, (8, 39))
        np.testing.assert_array_equal(partial.pixel % 39, self.arrays["column"] + self.arrays["ring"])
        with self.assertRaisesRegex(scanmill.InputError, "destagger=False"):
            scanmill.beam_projection(self.arrays, 8, 32)
        with self.assertRaisesRegex(scanmill.InputError, "for 4 rings"):
            scanmill.beam_projection(self.scan, destagger=scanmill.Stagger(np.zeros(4), 32))

    def test_returns_have_images_of_their_own(self):
        arrays = points(np.random.default_rng(2), count=256)
        number = np.random.default_rng(3).integers(1, 3, 256).astype(np.uint8)
        first = scanmill.beam_projection({**arrays, "return": number}, 8, 32, destagger=False)
        second = scanmill.beam_projection({**arrays, "return": number}, 8, 32, return_=2, destagger=False)
        self.assertTrue((first.mask ^ second.mask).all())
        np.testing.assert_array_equal(first.pixel >= 0, number == 1)
        np.testing.assert_array_equal(first.points(first.image(number), 9), np.where(number == 1, 1, 9))

    def test_of_points_in_one_pixel_the_first_is_shown(self):
        arrays = {
            "xyz": np.arange(9, dtype=np.float32).reshape(3, 3),
            "ring": np.array([1, 0, 1], np.uint16),
            "column": np.array([2, 0, 2], np.uint16),
        }
        pixels = scanmill.beam_projection(arrays, 2, 3, destagger=False)
        np.testing.assert_array_equal(pixels.index, [[1, -1, -1], [-1, -1, 0]])
        np.testing.assert_array_equal(pixels.points(pixels.index), [0, 1, 0])

    def test_no_points_give_an_empty_image(self):
        none = {name: values[:0] for name, values in self.arrays.items()}
        self.assertFalse(scanmill.range_image(none, 8, 32, destagger=self.scan.stagger).any())
        self.assertFalse(scanmill.spherical_projection(none, 8, 32, (-1, 1)).mask.any())

    def test_what_does_not_fit_is_refused(self):
        wrong = [
            (self.arrays, {}),
            (self.arrays, {"rings": 4, "columns": 32}),
            (self.arrays, {"rings": 8, "columns": 32, "return_": 2}),
            ({"xyz": self.arrays["xyz"]}, {"rings": 8, "columns": 32}),
            ({"xyz": np.zeros((4, 4, 3))}, {"rings": 4, "columns": 4}),
        ]
        for arrays, how in wrong:
            with self.subTest(how=how), self.assertRaises(scanmill.InputError):
                scanmill.beam_projection(arrays, destagger=False, **how)

    def test_values_and_images_of_other_sizes_are_refused(self):
        pixels = scanmill.beam_projection(self.scan)
        for values in (self.arrays["label"][1:], np.zeros((8, 32)), []):
            with self.assertRaisesRegex(scanmill.InputError, "150 points"):
                pixels.image(values)
        with self.assertRaisesRegex(scanmill.InputError, r"\(8, 32\), not \(32, 8\)"):
            pixels.points(pixels.image(self.arrays["label"]).T)


class ByAngle(unittest.TestCase):
    def test_directions_have_their_places(self):
        # Ahead, to the left, to the right, straight up, and far below.
        xyz = np.array([[1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [1, 0, -9]], np.float32)
        pixels = scanmill.spherical_projection({"xyz": xyz}, 10, 8, (-0.5, 0.5))
        np.testing.assert_array_equal(pixels.pixel, [5 * 8 + 4, 5 * 8 + 2, 5 * 8 + 6, -1, -1])

    def test_the_nearest_point_is_shown(self):
        rng = np.random.default_rng(4)
        xyz = rng.normal(size=(2000, 3)).astype(np.float32)
        pixels = scanmill.spherical_projection({"xyz": xyz}, 8, 16, (-1, 1))
        distance = np.linalg.norm(xyz, axis=1)
        shown = pixels.points(pixels.image(distance, np.inf), 0)
        self.assertTrue((shown <= distance).all())
        self.assertEqual(len(np.unique(pixels.pixel[pixels.pixel >= 0])), pixels.mask.sum())

    def test_edges_belong_to_the_image(self):
        ends = np.array([-0.25, 0.25])
        xyz = np.column_stack([-np.cos(ends), [0.0, -0.0], np.sin(ends)])
        pixels = scanmill.spherical_projection({"xyz": xyz}, 4, 6, (np.arctan2(xyz[0, 2], -xyz[0, 0]), 0.25 + 1e-9))
        self.assertTrue((pixels.pixel >= 0).all())

    def test_a_field_without_height_is_refused(self):
        with self.assertRaises(scanmill.InputError):
            scanmill.spherical_projection({"xyz": np.zeros((1, 3))}, 8, 16, (1, 1))


class Padding(unittest.TestCase):
    def test_masks_tell_what_is_whose(self):
        rng = np.random.default_rng(5)
        arrays = [rng.normal(size=(n, 4)).astype(np.float32) for n in (3, 0, 7)]
        padded, mask = scanmill.pad_batch(arrays, fill=-1)
        self.assertEqual((padded.shape, mask.shape, padded.dtype), ((3, 7, 4), (3, 7), np.float32))
        for row, own, array in zip(padded, mask, arrays):
            np.testing.assert_array_equal(row[own], array)
            self.assertTrue((row[~own] == -1).all())

    def test_arrays_that_differ_are_refused(self):
        for arrays in ([], [np.zeros((2, 3)), np.zeros((2, 4))], [np.zeros(2), np.zeros(2, int)]):
            with self.assertRaises(scanmill.InputError):
                scanmill.pad_batch(arrays)


if __name__ == "__main__":
    unittest.main()
