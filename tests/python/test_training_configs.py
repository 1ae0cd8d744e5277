"""Exports have the folders, names and numbers that the loaders of mmdetection3d, OpenPCDet and Pointcept read without
being told: what is tested here is what their code takes for granted, by line, count or formula. None of these programs
is needed."""

import json
import math
import os
import struct
import subprocess
import tempfile
import unittest
from collections import defaultdict
from pathlib import Path

import numpy as np
from support import dataset_path

# Class ids that the loaders' tables of SemanticKITTI know; another id is a KeyError in Pointcept.
SEMANTIC_KITTI = {0, 1, 10, 11, 13, 15, 16, 18, 20, 30, 31, 32, 40, 44, 48, 49, 50, 51, 52, 60, 70, 71, 72, 80, 81, 99}
SEMANTIC_KITTI |= set(range(252, 260))
KITTI = {"Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc", "DontCare"}
TABLES = (
    "attribute calibrated_sensor category ego_pose instance log map sample sample_annotation sample_data scene sensor "
    "visibility lidarseg panoptic"
).split()

EXPORTS = {}


def exported(test, layout):
    """The folder of the dataset in a layout, as `scanmill export` writes it once for all tests."""
    dataset = dataset_path(test)
    if not EXPORTS:
        EXPORTS["folder"] = tempfile.TemporaryDirectory()
        unittest.addModuleCleanup(EXPORTS["folder"].cleanup)
    if layout not in EXPORTS:
        out = Path(EXPORTS["folder"].name) / layout
        options = ["--to", layout, "-o", str(out), "--sensor", "top", "--quiet"]
        subprocess.run([os.environ["SCANMILL"], "export", dataset, *options], check=True, capture_output=True)
        EXPORTS[layout] = out
    return EXPORTS[layout]


def sequences(root):
    """The folders of sequences that have scans."""
    return sorted({path.parent.parent for path in root.glob("sequences/*/velodyne/*.bin")})


def floats(path, columns):
    values = np.fromfile(path, np.float32)
    assert values.size % columns == 0, f"{path} has no whole points"
    return values.reshape(-1, columns)


def turned(quaternion):
    """The rotation matrix of w, x, y, z."""
    w, x, y, z = np.array(quaternion) / np.linalg.norm(quaternion)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def inside(xyz, center, size, yaw, margin):
    """True for the points in a box with length, width and height along its own axes."""
    c, s = math.cos(yaw), math.sin(yaw)
    own = (xyz - center) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return (np.abs(own) <= np.array(size) / 2 + margin).all(1)


def angle(difference):
    return abs(math.remainder(difference, 2 * math.pi))


class Kitti(unittest.TestCase):
    def setUp(self):
        self.root = exported(self, "kitti")

    def frames(self):
        """(folder, number) of each frame, as the lists of ImageSets name them."""
        for split, folder in (("train", "training"), ("val", "training"), ("test", "testing")):
            for line in (self.root / "ImageSets" / f"{split}.txt").read_text().splitlines(keepends=True):
                # OpenPCDet takes the line as the name of files, mmdetection3d its int().
                self.assertRegex(line, r"^\d{6}\n$")
                yield folder, line.strip()

    def labels(self, folder, number):
        for line in (self.root / folder / "label_2" / f"{number}.txt").read_text().splitlines():
            fields = line.split(" ")  # loaders split at single spaces
            self.assertEqual(len(fields), 15, line)
            yield fields[0], [float(field) for field in fields[1:]]

    def calibration(self, folder, number):
        """The matrices by the number of their line, which is how loaders read them."""
        lines = (self.root / folder / "calib" / f"{number}.txt").read_text().splitlines()
        names = ["P0", "P1", "P2", "P3", "R0_rect", "Tr_velo_to_cam", "Tr_imu_to_velo"]
        self.assertEqual([line.split(":")[0] for line in lines], names)
        rows = [np.array([float(field) for field in line.split(" ")[1:]]) for line in lines]
        self.assertEqual([row.size for row in rows], [12, 12, 12, 12, 9, 12, 12])
        return rows[2].reshape(3, 4), rows[4].reshape(3, 3), rows[5].reshape(3, 4)

    def boxes(self, folder, number):
        """Type, centre, length, width and height, and heading of each object in the frame of the points, by OpenPCDet's
        formulas."""
        _, rect, velodyne = self.calibration(folder, number)
        for kind, (_, _, _, _, _, _, _, h, w, length, x, y, z, turn) in self.labels(folder, number):
            if kind != "DontCare":
                camera = np.linalg.inv(rect) @ np.array([x, y, z])
                center = np.linalg.inv(velodyne[:, :3]) @ (camera - velodyne[:, 3]) + [0, 0, h / 2]
                yield kind, center, np.array([length, w, h]), -(math.pi / 2 + turn)

    def test_each_frame_has_its_four_files(self):
        frames = list(self.frames())
        self.assertEqual(len({split for split, _ in frames}), 2)
        for folder, number in frames:
            for kind, suffix in (("velodyne", "bin"), ("label_2", "txt"), ("calib", "txt"), ("image_2", "png")):
                self.assertTrue((self.root / folder / kind / f"{number}.{suffix}").is_file(), f"{folder}/{kind}/{number}")
        listed = sorted(number for folder, number in frames if folder == "training")
        self.assertEqual(listed, sorted(path.stem for path in (self.root / "training" / "velodyne").iterdir()))
        both = [(self.root / "ImageSets" / f"{split}.txt").read_text() for split in ("train", "val", "trainval")]
        self.assertEqual(both[0] + both[1], both[2])

    def test_the_plane_of_the_road_is_below_the_sensor(self):
        """OpenPCDet and mmdetection3d read the fourth line: a x + b y + c z + d = 0 in the camera's frame, y down."""
        for folder, number in self.frames():
            lines = (self.root / folder / "planes" / f"{number}.txt").read_text().splitlines()
            a, b, c, d = map(float, lines[3].split())
            self.assertAlmostEqual(a * a + b * b + c * c, 1, places=6)
            self.assertLess(b, -0.99)
            self.assertGreater(d, 0.5)
            xyz = floats(self.root / folder / "velodyne" / f"{number}.bin", 4)[:, :3]
            near = xyz[np.hypot(xyz[:, 0], xyz[:, 1]) < 8]
            if len(near):  # in camera axes x right, y down, z ahead; nothing near lies far below the road
                self.assertGreater((near @ np.array([c, -a, -b]) + d).min(), -1)

    def test_points_are_four_numbers_with_reflectance_up_to_one(self):
        for folder, number in self.frames():
            points = floats(self.root / folder / "velodyne" / f"{number}.bin", 4)
            self.assertGreater(len(points), 0)
            self.assertTrue(np.isfinite(points).all())
            self.assertTrue(((points[:, 3] >= 0) & (points[:, 3] <= 1)).all())

    def test_labels_are_lines_that_loaders_take(self):
        for folder, number in self.frames():
            labels = list(self.labels(folder, number))
            self.assertTrue(labels, "OpenPCDet cannot read a file without a line")
            for kind, values in labels:
                self.assertIn(kind, KITTI)
                self.assertIn(values[1], (-1, 0, 1, 2, 3))
            cared = [kind != "DontCare" for kind, _ in labels]
            self.assertEqual(cared, sorted(cared, reverse=True), "loaders take the first lines for the objects")

    def test_boxes_in_the_image_enclose_the_image_of_their_box(self):
        for folder, number in self.frames():
            projection, rect, velodyne = self.calibration(folder, number)
            data = (self.root / folder / "image_2" / f"{number}.png").read_bytes()
            width, height = struct.unpack(">II", data[16:24])
            frame = zip(self.boxes(folder, number), self.labels(folder, number))
            for (kind, center, size, yaw), (_, values) in frame:
                c, s = math.cos(yaw), math.sin(yaw)
                signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
                corners = signs * size / 2 @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + center
                camera = rect @ (velodyne[:, :3] @ corners.T + velodyne[:, 3:])
                left, top, right, bottom = values[3:7]
                self.assertTrue(0 <= left < right <= width - 1, f"{number} {kind}")
                self.assertTrue(0 <= top < bottom <= height - 1, f"{number} {kind}")
                if (camera[2] < 1).any() or kind not in ("Car", "Pedestrian"):
                    continue  # a box beside the camera has no whole image; bicycles lean, but KITTI's boxes do not
                pixels = projection @ np.vstack([camera, np.ones(8)])
                pixels = pixels[:2] / pixels[2]
                off = 0.5 + projection[0, 0] * 0.03 / camera[2].min()  # labels are rounded to 1 cm and 0.01 rad
                for side, value, most in ((0, left, width - 1), (1, top, height - 1)):
                    self.assertAlmostEqual(value, np.clip(pixels[side].min(), 0, most), delta=off)
                for side, value, most in ((0, right, width - 1), (1, bottom, height - 1)):
                    self.assertAlmostEqual(value, np.clip(pixels[side].max(), 0, most), delta=off)

    def test_boxes_hold_points_and_are_those_of_the_other_layout(self):
        others = defaultdict(list)
        for name, boxes, _ in NuScenes.annotated(self, exported(self, "nuscenes")):
            others[name.split("__")[0]] = boxes
        scans = json.loads((exported(self, "nuscenes") / "v1.0-trainval" / "sample_data.json").read_text())
        names = [Path(scan["filename"]).name.split("__")[0] for scan in scans if scan["fileformat"] == "pcd"]
        count = 0
        for (folder, number), name in zip(self.frames(), names):
            xyz = floats(self.root / folder / "velodyne" / f"{number}.bin", 4)[:, :3]
            for kind, center, size, yaw in self.boxes(folder, number):
                self.assertTrue(inside(xyz, center, size, yaw, 0.1).any(), f"{folder} {number} {kind} is empty")
                near = [box for box in others[name] if np.linalg.norm(box[0] - center) < 0.05]
                if kind in ("Car", "Pedestrian"):
                    self.assertEqual(len(near), 1, f"{folder} {number} {kind}")
                    np.testing.assert_allclose(near[0][1], size, atol=0.02)
                    self.assertLess(angle(near[0][2] - yaw), 0.02)
                    count += 1
        self.assertGreater(count, 0)


class SemanticKitti(unittest.TestCase):
    def setUp(self):
        self.root = exported(self, "semantic_kitti")

    def test_there_is_a_folder_for_every_number(self):
        """Pointcept lists the folders of all numbers of a split, even those without a drive."""
        for number in range(22):
            self.assertTrue((self.root / "sequences" / f"{number:02}" / "velodyne").is_dir())

    def test_lists_of_frames_name_every_scan(self):
        """What mmdetection3d's `ann_file` lists."""
        listed = set()
        for split in ("train", "val", "test"):
            infos = json.loads((self.root / f"semantickitti_infos_{split}.json").read_text())
            self.assertIsInstance(infos["metainfo"], dict)
            for info in infos["data_list"]:
                self.assertEqual(info["lidar_points"]["num_pts_feats"], 4)
                for path in (info["lidar_points"]["lidar_path"], info["pts_semantic_mask_path"]):
                    self.assertTrue((self.root / path).is_file(), path)
                listed.add(info["lidar_points"]["lidar_path"])
        written = {str(path.relative_to(self.root)) for path in self.root.glob("sequences/*/velodyne/*.bin")}
        self.assertEqual(listed, written)

    def test_each_scan_has_as_many_labels_that_loaders_know(self):
        for sequence in sequences(self.root):
            frames = sorted(path.stem for path in (sequence / "velodyne").iterdir())
            self.assertEqual(frames, [f"{frame:06}" for frame in range(len(frames))])
            self.assertEqual(frames, sorted(path.stem for path in (sequence / "labels").iterdir()))
            for frame in frames:
                points = floats(sequence / "velodyne" / f"{frame}.bin", 4)
                # Pointcept and mmdetection3d read them signed.
                labels = np.fromfile(sequence / "labels" / f"{frame}.label", np.int32)
                self.assertEqual(len(labels), len(points))
                self.assertLessEqual(set(np.unique(labels & 0xFFFF).tolist()), SEMANTIC_KITTI)
                self.assertGreaterEqual(labels.min(), 0)
                self.assertTrue(((points[:, 3] >= 0) & (points[:, 3] <= 1)).all())
                cars = labels[np.isin(labels & 0xFFFF, (10, 252))]
                self.assertTrue((cars >> 16).all(), "a car without an instance")


class NuScenes(unittest.TestCase):
    def setUp(self):
        self.root = exported(self, "nuscenes")
        self.tables = self.read(self.root)

    @staticmethod
    def read(root):
        rows = {name: json.loads((root / "v1.0-trainval" / f"{name}.json").read_text()) for name in TABLES}
        return {name: {row["token"]: row for row in table} for name, table in rows.items()}

    @staticmethod
    def annotated(test, root):
        """For each scan its file's name, its boxes (centre, length, width and height, heading, number of points) turned
        into the sensor's frame as the devkit turns them, then into x ahead, y left; and its points in that frame."""
        tables = NuScenes.read(root)
        by_sample = defaultdict(list)
        for row in tables["sample_annotation"].values():
            by_sample[row["sample_token"]].append(row)
        to_front = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])  # LIDAR_TOP: x right, y ahead
        for scan in tables["sample_data"].values():
            mount = tables["calibrated_sensor"][scan["calibrated_sensor_token"]]
            if tables["sensor"][mount["sensor_token"]]["channel"] != "LIDAR_TOP":
                continue
            pose = tables["ego_pose"][scan["ego_pose_token"]]
            boxes = []
            for row in by_sample[scan["sample_token"]]:
                center, rotation = np.array(row["translation"]), turned(row["rotation"])
                for frame in (pose, mount):
                    inverse = turned(frame["rotation"]).T
                    center, rotation = inverse @ (center - frame["translation"]), inverse @ rotation
                center, rotation = to_front @ center, to_front @ rotation
                width, length, height = row["size"]
                heading = math.atan2(rotation[1, 0], rotation[0, 0])
                boxes.append((center, np.array([length, width, height]), heading, row["num_lidar_pts"]))
            xyz = floats(root / scan["filename"], 5)[:, :3] @ to_front.T
            yield scan["filename"].split("/")[-1], boxes, xyz

    def test_scans_are_where_the_converters_look(self):
        scans = self.tables["sample_data"].values()
        names = [scan["filename"].split("/")[-1] for scan in scans if scan["fileformat"] == "pcd"]
        self.assertEqual(len(set(names)), len(names), "mmdetection3d knows a scan by the name of its file alone")
        tops = set()
        for scan in self.tables["sample_data"].values():
            mount = self.tables["calibrated_sensor"][scan["calibrated_sensor_token"]]
            if self.tables["sensor"][mount["sensor_token"]]["channel"] != "LIDAR_TOP":
                continue
            tops.add(scan["sample_token"])
            self.assertTrue(scan["is_key_frame"])
            self.assertTrue(scan["filename"].startswith("samples/LIDAR_TOP/"))
            points = floats(self.root / scan["filename"], 5)
            self.assertTrue(((points[:, 3] >= 0) & (points[:, 3] <= 255)).all())
            self.assertGreater(points[:, 3].max(), 1, "Pointcept divides intensities by 255")
            labels = self.root / self.tables["lidarseg"][scan["token"]]["filename"]
            self.assertEqual(labels.stat().st_size, len(points))
            self.assertLess(np.fromfile(labels, np.uint8).max(), 32)
        self.assertEqual(tops, set(self.tables["sample"]), "each sample needs a LIDAR_TOP")

    def test_each_sample_has_the_six_cameras(self):
        channels = {token: row["channel"] for token, row in self.tables["sensor"].items()}
        cameras = defaultdict(set)
        for scan in self.tables["sample_data"].values():
            mount = self.tables["calibrated_sensor"][scan["calibrated_sensor_token"]]
            if channels[mount["sensor_token"]].startswith("CAM"):
                cameras[scan["sample_token"]].add(channels[mount["sensor_token"]])
                self.assertEqual(np.shape(mount["camera_intrinsic"]), (3, 3))
                self.assertTrue((self.root / scan["filename"]).is_file())
        six = {f"CAM_{side}" for side in ("FRONT", "FRONT_LEFT", "FRONT_RIGHT", "BACK", "BACK_LEFT", "BACK_RIGHT")}
        self.assertEqual([cameras[sample] for sample in self.tables["sample"]], [six] * len(self.tables["sample"]))


if __name__ == "__main__":
    unittest.main()
