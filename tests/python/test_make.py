"""Datasets that Python makes are those of the command: the same bytes, the same refusals, the same ways to go on."""

import os
import signal
import tempfile
import threading
import unittest
import warnings
from pathlib import Path

import scanmill

from support import ROOT, dataset_path

FILE = ROOT / "tests/python/dataset.yaml"
SMALL = {
    "scenes": [{"scene": "primitives"}],
    "trajectories": [{"name": "drive", "waypoints": [[-6, -4, 0], [6, -4, 0]], "speed": 5, "frames": 4}],
    "sensors": [{"name": "top", "preset": "vlp_16", "columns": 180, "mount": {"position": [0, 0, 1.5]}}],
    "method": "ray_tracing",
    "output": {"formats": ["pcd"], "shard_samples": 1},
}


def digests(dataset):
    return {shard["file"]: shard["sha256"] for shard in dataset.manifest["shards"]}


class Make(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        warnings.simplefilter("ignore")

    def test_bytes_are_those_of_the_command(self):
        commands = scanmill.open(dataset_path(self))
        made = scanmill.generate(FILE, self.folder / "made", quiet=True)
        self.assertEqual(digests(made), digests(commands))
        self.assertEqual(scanmill.verify(made, quiet=True), [])
        scanmill.export(made, "ply", self.folder / "ply", splits=["val"], quiet=True)
        self.assertEqual(len(list((self.folder / "ply").rglob("*.ply"))), 12)  # 4 of one sensor, 8 of one twice as fast

    def test_a_map_is_a_pipeline_and_keys_change_it(self):
        planned = scanmill.plan(SMALL, set={"trajectories.0.frames": 6})
        self.assertEqual((planned["samples"], planned["shards"]), (6, {"train": 6}))
        made = scanmill.generate(SMALL, self.folder / "six", set={"trajectories.0.frames": 6}, quiet=True)
        other = {**SMALL, "trajectories": [{**SMALL["trajectories"][0], "frames": 6}]}
        self.assertEqual(digests(made), digests(scanmill.generate(other, self.folder / "other", quiet=True)))
        self.assertNotEqual(digests(made), digests(scanmill.generate(other, self.folder / "noisy", quiet=True, seed=3,
                                                                     set={"effects": [{"range_noise": {"sigma_m": 0.02}}]})))  # fmt: skip

    def test_maps_are_read(self):  # by a module that lies beside the extension, not beside Python's own program
        self.assertGreater(len(scanmill.load_scene("village").scan("vlp_16", {"position": [0, 0, 2]})), 10000)

    def test_what_is_wrong_is_an_input_error(self):
        for wrong in ({**SMALL, "sensors": [{"name": "top", "preset": "vlp_61"}]}, {**SMALL, "method": object()}, "quikstart"):
            with self.assertRaises(scanmill.InputError):
                scanmill.generate(wrong, self.folder / "wrong", quiet=True)
        scanmill.generate(SMALL, self.folder / "once", quiet=True)
        with self.assertRaisesRegex(scanmill.InputError, "not empty"):
            scanmill.generate(SMALL, self.folder / "once", quiet=True)

    def test_an_interrupted_dataset_goes_on(self):
        long = {**SMALL, "trajectories": [{**SMALL["trajectories"][0], "speed": 0.002, "frames": 40000}]}
        threading.Timer(1, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            scanmill.generate(long, self.folder / "long", set={"output.shard_samples": 10}, quiet=True)
        self.assertFalse((self.folder / "long/manifest.json").exists())
        short = {"set": {"trajectories.0.frames": 50}, "quiet": True}
        whole = scanmill.generate(long, self.folder / "long", overwrite=True, **short)
        kept = scanmill.generate(long, self.folder / "long", resume=True, **short)
        self.assertEqual((len(whole), digests(kept)), (50, digests(whole)))


if __name__ == "__main__":
    unittest.main()
