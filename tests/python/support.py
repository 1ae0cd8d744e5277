"""What the tests of the Python package share."""

import importlib.util
import json
import os
import shutil
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]

CLASSES = {
    "name": "small",
    "source": "",
    "classes": [
        {"id": 0, "name": "unlabeled", "color": [0, 0, 0], "thing": False},
        {"id": 7, "name": "road", "color": [128, 64, 128], "thing": False, "aliases": ["street"]},
        {"id": 3, "name": "car", "color": [0, 0, 255], "thing": True},
        {"id": 300, "name": "truck", "color": [0, 0, 200], "thing": True},
    ],
}


def dataset_path(test):
    """The path of a generated dataset; without one the test is skipped."""
    path = os.environ.get("SCANMILL_TEST_DATASET")
    if not path:
        test.skipTest("SCANMILL_TEST_DATASET names no dataset")
    return path


def without_first_scan(path, folder):
    """A copy of a dataset whose sample 1 has no scan of the first sensor, as if that one turned more slowly than frames
    follow each other."""
    copy = Path(shutil.copytree(path, Path(folder) / "copy"))
    manifest = json.loads((copy / "manifest.json").read_text())
    first, sample = manifest["sensors"][0]["name"], manifest["samples"][1]
    sample["scans"] = [scan for scan in sample["scans"] if scan["sensor"] != first]
    members = zip(sample["members"], sample["xxh3"])
    sample["members"], sample["xxh3"] = zip(*((name, xxh3) for name, xxh3 in members if f".{first}." not in name))
    (copy / "manifest.json").write_text(json.dumps(manifest))
    return copy


def box_of_points(rng, count=200):
    """A box, and points that lie in it."""
    box = np.array([*rng.uniform(-20, 20, 3), *rng.uniform(0.5, 5, 3), rng.uniform(-np.pi, np.pi)])
    own = rng.uniform(-0.5, 0.5, (count, 3)) * box[3:6] * 0.999
    c, s = np.cos(box[6]), np.sin(box[6])
    xyz = np.column_stack([own[:, 0] * c - own[:, 1] * s, own[:, 0] * s + own[:, 1] * c, own[:, 2]]) + box[:3]
    return box, xyz


def random_sample(rng, boxes=4, each=100):
    """A sample as loaders give it, whose points all lie in boxes: `own` is the number of the box that a point is in."""
    pairs = [box_of_points(rng, each) for _ in range(boxes)]
    xyz = np.concatenate([points for _, points in pairs]).astype(np.float32)
    count = len(xyz)
    pose = np.eye(4)
    pose[:3, 3] = rng.uniform(-100, 100, 3)
    velocity = rng.normal(size=(count, 3)).astype(np.float32)
    return {
        "key": "town-s1-drive-000001",
        "xyz": xyz,
        "own": np.repeat(np.arange(boxes), each),
        "ring": rng.integers(0, 16, count).astype(np.uint16),
        "intensity": rng.random(count).astype(np.float32),
        "azimuth": np.arctan2(xyz[:, 1], xyz[:, 0]),
        "range_true": np.linalg.norm(xyz, axis=1),
        **{f"velocity_{axis}": velocity[:, i].copy() for i, axis in enumerate("xyz")},
        "boxes": np.array([box for box, _ in pairs], np.float32),
        "box_class": np.arange(boxes).astype(np.uint16),
        "box_velocity": rng.normal(size=(boxes, 3)).astype(np.float32),
        "world_from_sensor": pose,
    }


class FakeShards:
    """Shards of so many samples each, without files: sample() gives the address itself."""

    def __init__(self, sizes):
        self.sizes = sizes

    def __len__(self):
        return len(self.sizes)

    def keys(self, shard):
        return [f"s{shard}-{i}" for i in range(self.sizes[shard])]

    def sample(self, shard, key):
        return key

    def all(self):
        return sorted(key for shard in range(len(self)) for key in self.keys(shard))


needs_torch = unittest.skipUnless(importlib.util.find_spec("torch"), "torch is not installed")
