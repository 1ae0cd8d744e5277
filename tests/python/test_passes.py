"""Recordings from depth cameras of another program."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
from support import dataset_path

import scanmill
from scanmill.passes import CAMERAS

HALF = np.array([9.0, 6.0, 4.0])  # m, half of the edges of a room about the world's origin
POSE = scanmill.pose_matrix({"position": [2, -1, 0.5], "yaw_deg": 30, "pitch_deg": 7})
PIPELINE = """labels: scanmill
sensors: [{name: top, preset: vlp_16, columns: 360}]
method: {depth_camera: {sampling: SAMPLING}}
effects: [intensity]
output: {columns: [intensity, label, instance, ring, column, range_true, incidence], formats: [pcd: {encoding: binary}]}
"""


def room(directions):
    """Distance to the room's walls along unit vectors from the sensor's place (..., 3), and the index of the wall."""
    place = POSE[:3, 3]
    with np.errstate(divide="ignore"):
        far = (np.sign(directions) * HALF - place) / directions
    return far.min(axis=-1), 2 * far.argmin(axis=-1) + (np.take_along_axis(
        directions, far.argmin(axis=-1)[..., np.newaxis], -1)[..., 0] > 0)


def images(n, along_rays):
    """The images that an engine renders of the room: depths and walls."""
    side = (np.arange(n) + 0.5) * (2 / n) - 1
    depth, wall = {}, {}
    for camera, axes in CAMERAS.items():
        rays = np.stack([*np.meshgrid(side, side), np.ones((n, n))], axis=-1) @ np.array(axes, float)
        length = np.linalg.norm(rays, axis=-1)
        distance, wall[camera] = room(rays / length[..., np.newaxis] @ POSE[:3, :3].T)
        depth[camera] = distance if along_rays else distance / length
    return depth, wall


class Passes(unittest.TestCase):
    def setUp(self):
        dataset_path(self)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def scans(self, sampling, along_rays, count=1, **images_too):
        """The scans of a recording of the room, which the program makes."""
        depth, wall = images(256, along_rays)
        recording = self.folder / f"{sampling}{along_rays}"
        with scanmill.PassWriter(recording, scanmill.sensor("vlp_16", columns=360)) as writer:
            for _ in range(count):
                writer.add(POSE, depth, semantic={c: (w + 1).astype(np.uint8) for c, w in wall.items()},
                           instance={c: w + 100 for c, w in wall.items()}, along_rays=along_rays, **images_too)
        pipeline = self.folder / "room.yaml"
        pipeline.write_text(PIPELINE.replace("SAMPLING", sampling))
        out = self.folder / f"out{sampling}{along_rays}"
        command = [os.environ["SCANMILL"], "generate", pipeline, "-q", "-o", out, "--from-passes", recording]
        subprocess.run(command, check=True, capture_output=True)
        return [sample.scan() for sample in scanmill.open(out)]

    def test_scans_are_those_of_the_room(self):
        for along_rays in (False, True):
            first, second = self.scans("plane", along_rays, count=2)
            self.assertEqual(len(first), 16 * 360)
            self.assertTrue(np.array_equal(first.xyz, second.xyz))
            directions = first.xyz / np.linalg.norm(first.xyz, axis=1)[:, np.newaxis]
            expected, wall = room(directions.astype(float) @ POSE[:3, :3].T)
            inner = np.abs(first.range_true - expected) < 0.02    # at edges a pixel may show the other wall
            self.assertGreater(inner.mean(), 0.97)
            self.assertLess(np.median(np.abs(first.range_true - expected)), 1e-4)
            self.assertTrue((first.label[inner] == wall[inner] + 1).mean() > 0.999)
            self.assertTrue((first.instance[inner] == wall[inner] + 100).mean() > 0.999)
            walls = np.abs((directions.astype(float) @ POSE[:3, :3].T)[np.arange(len(wall)), wall // 2])
            self.assertLess(np.median(np.abs(np.cos(first.incidence) - walls)), 1e-4)
            self.assertGreater(first.intensity.min(), 0)
            np.testing.assert_allclose(first.world_from_sensor, POSE, atol=1e-9)

    def test_nearest_pixels_are_off_by_pixels(self):
        (nearest,) = self.scans("nearest", False)
        directions = nearest.xyz / np.linalg.norm(nearest.xyz, axis=1)[:, np.newaxis]
        expected, _ = room(directions.astype(float) @ POSE[:3, :3].T)
        error = np.abs(nearest.range_true - expected)
        self.assertGreater(np.median(error), 1e-4)
        self.assertLess(np.median(error), 0.1)

    def test_pixels_without_a_surface_are_misses(self):
        depth, _ = images(64, False)
        for nothing in (np.inf, np.nan, 0.0):
            with scanmill.PassWriter(self.folder / f"sky{nothing}", scanmill.sensor("vlp_16", columns=360)) as writer:
                writer.add(POSE, {**depth, "back": np.full((64, 64), nothing)})
            (self.folder / "sky.yaml").write_text(PIPELINE.replace("SAMPLING", "plane"))
            out = self.folder / f"out{nothing}"
            command = [os.environ["SCANMILL"], "generate", self.folder / "sky.yaml", "-q", "-o", out, "--from-passes",
                       self.folder / f"sky{nothing}"]
            subprocess.run(command, check=True, capture_output=True)
            scan = scanmill.open(out)[0].scan()
            behind = np.abs(np.arctan2(scan.xyz[:, 1], -scan.xyz[:, 0])) < np.pi / 4 - 0.05
            self.assertFalse(behind.any())
            self.assertGreater(len(scan), 0.7 * 16 * 360)

    def test_whole_numbers_are_millimetres_and_their_greatest_is_no_depth(self):
        depth, _ = images(16, False)
        whole = {camera: np.round(z * 1000).astype(np.uint16) for camera, z in depth.items()}
        whole["back"][3:5] = 65535
        metres = {camera: np.where(z == 65535, np.inf, z * 0.001) for camera, z in whole.items()}
        same = {
            "metres": (metres, {}),
            "uint16": (whole, {}),
            "int32": ({camera: z.astype(np.int32) for camera, z in whole.items()}, {}),  # as some readers of PNG give it
            "halves": ({camera: z * 2 for camera, z in metres.items()}, {"depth_unit": 0.5}),
        }
        files = []
        for name, (images_of, how) in same.items():
            with scanmill.PassWriter(self.folder / name, "vlp_16") as writer:
                writer.add(POSE, images_of, **how)
            files.append({file.name: file.read_bytes() for file in (self.folder / name).rglob("*.exr")})
        self.assertEqual(len(files[0]), 6)
        for other in files[1:]:
            self.assertEqual(other, files[0])

    def test_depths_in_other_units_are_refused(self):
        depth, _ = images(8, False)
        sky = np.where(np.arange(64).reshape(8, 8) < 9, np.uint16(65535) / 1000, depth["front"])
        writer = scanmill.PassWriter(self.folder / "units", "vlp_16")
        for wrong, why in ((sky, "9 pixels at 65.535 m"), (-depth["front"], "64 negative")):
            with self.assertRaisesRegex(scanmill.InputError, f"depth of 'front'.*{why}"):
                writer.add(POSE, {**depth, "front": wrong})

    def test_mistakes_name_the_camera_and_the_array(self):
        depth, _ = images(8, False)
        writer = scanmill.PassWriter(self.folder / "wrong", "vlp_16")
        wrong = [
            (dict(depth={"frnt": depth["front"]}), "did you mean 'front'"),
            (dict(depth={}), "at least one camera"),
            (dict(depth={"left": np.zeros((3, 4))}), r"depth of 'left' must be a square image"),
            (dict(depth=depth, semantic={"front": np.zeros((8, 8), np.uint8)}), "semantic has no image of .* 'left'"),
            (dict(depth={"up": depth["up"]}, instance={"up": np.full((8, 8), -1)}), "instance of 'up' must be whole"),
            (dict(depth={"up": depth["up"]}, reflectance={"up": np.zeros((4, 4))}), "reflectance of 'up' must have"),
        ]
        for arguments, message in wrong:
            with self.assertRaisesRegex(scanmill.InputError, message):
                writer.add(POSE, **arguments)
        with self.assertRaisesRegex(scanmill.InputError, "at least one frame"):
            writer.close()
        with self.assertRaisesRegex(scanmill.InputError, "vlp_17"):
            scanmill.PassWriter(self.folder / "unknown", "vlp_17")


if __name__ == "__main__":
    unittest.main()
