"""Datasets and exports of somebody else, which have links where the program keeps files: no command that writes into such a folder
changes anything outside of it, whatever the link is and wherever it stands. A dataset that it then calls complete is.

    SCANMILL=/path/to/scanmill python3 links_test.py     the program in place of build/release/scanmill
    LINKS_CASES=all ...                                  all cases, in place of 40 that are chosen at random
"""

import itertools
import os
import random
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from support import PROGRAM, ROOT, tree

CASES = os.environ.get("LINKS_CASES", "40")
SEED = 20261127
PATIENCE_S = 60

PIPELINE = """
name: small
scenes: [{{scene: "{root}/scenes/primitives.yaml"}}]
trajectories: [{{name: past, waypoints: [[-4, 0, 0], [4, 0, 0]], speed: 5, every_m: 0.5, frames: 4}}]
sensors:
  - {{name: top, columns: 32, rate_hz: 10, range_m: [0.5, 90], mount: {{position: [0, 0, 1.9]}},
     elevation_deg: {{top: 10, bottom: -20, rings: 4}}}}
method: ray_tracing
effects: []
output: {{shard_samples: 2, formats: [pcd]}}
"""

# Every name below a dataset's folder and an export's that the program may open to write, move or remove.
NAMES = (".scanmill", ".scanmill/lock", ".scanmill/begin.lock", ".scanmill/plan", ".scanmill/replaced.json",
         ".scanmill/again", ".scanmill/train", ".scanmill/train/train-000000.tar",
         ".scanmill/train/train-000000.tar.lock", ".scanmill/train/train-000000.tar.json", "manifest.json", "train",
         "train/train-000000.tar", "train/train-000001.tar")
EXPORT_NAMES = (".scanmill_export.lock", ".scanmill_export.json", "scanmill_export.json", "train",
                "train/primitives-s1-past-000000.top.ply")
LINKS = ("file", "folder", "nowhere", "hard")
STATES = ("complete", "unfinished", "damaged")
EXPORT_STATES = ("exported", "half_exported")
COMMANDS = {
    "merge": ("merge", "{ds}"),
    "overwrite": ("generate", "{pipeline}", "-o", "{ds}", "--overwrite", "--quiet"),
    "resume": ("generate", "{pipeline}", "-o", "{ds}", "--resume", "--quiet"),
    "worker": ("generate", "{pipeline}", "-o", "{ds}", "--worker", "0", "--workers", "2", "--quiet"),
    "share": ("generate", "{pipeline}", "-o", "{ds}", "--workers", "auto", "--quiet"),
}
EXPORT = {"export": ("export", "{other}", "--to", "ply", "-o", "{ds}", "--overwrite", "--quiet")}


class Links(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None)
        cls.folder = Path(cls.temporary.name)
        cls.pipeline = cls.folder / "small.yaml"
        cls.pipeline.write_text(PIPELINE.format(root=ROOT))
        cls.complete = cls.folder / "complete"
        cls.run_program("generate", str(cls.pipeline), "-o", str(cls.complete), "--quiet", code=0)
        cls.run_program("generate", str(cls.pipeline), "-o", str(cls.folder / "unfinished"), "--shards", "0", "--quiet",
                        code=0)
        shutil.copytree(cls.complete, cls.folder / "damaged")
        (cls.folder / "damaged/train/train-000000.tar").unlink()
        cls.run_program("export", str(cls.complete), "--to", "ply", "-o", str(cls.folder / "exported"), "--quiet",
                        code=0)
        half = shutil.copytree(cls.folder / "exported", cls.folder / "half_exported")
        (half / "scanmill_export.json").rename(half / ".scanmill_export.json")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @staticmethod
    def run_program(*words, code=None):
        done = subprocess.run([PROGRAM, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=PATIENCE_S)
        if code is not None and done.returncode != code:
            raise AssertionError(f"{words}: {done.returncode}\n{done.stdout}")
        return done

    def stranger(self, state, name, link):
        """A dataset or an export with a link at a name, and a folder outside of it to which the link leads."""
        shutil.rmtree(self.folder / "ds", ignore_errors=True)
        shutil.rmtree(self.folder / "outside", ignore_errors=True)
        ds, outside = self.folder / "ds", self.folder / "outside"
        shutil.copytree(self.folder / state, ds)
        outside.mkdir()
        (outside / "precious").write_text("precious")
        # Names that the program would look for behind a link to a folder.
        for inner in ("lock", "train-000000.tar", "train/train-000000.tar"):
            (outside / "folder" / inner).parent.mkdir(parents=True, exist_ok=True)
            (outside / "folder" / inner).write_text("precious")
        at = ds / name
        if at.is_dir() and not at.is_symlink():
            shutil.rmtree(at)
        at.parent.mkdir(parents=True, exist_ok=True)
        at.unlink(missing_ok=True)
        if link == "hard":
            os.link(outside / "precious", at)
        else:
            at.symlink_to(outside / {"file": "precious", "folder": "folder", "nowhere": "new"}[link])
        return ds, outside

    def test_nothing_outside_of_a_strangers_folder_changes(self):
        cases = [*itertools.product(STATES, NAMES, LINKS, COMMANDS),
                 *itertools.product(EXPORT_STATES, EXPORT_NAMES, LINKS, EXPORT)]
        if CASES != "all":
            cases = random.Random(SEED).sample(cases, int(CASES))
        for state, name, link, command in cases:
            with self.subTest(state=state, name=name, link=link, command=command):
                ds, outside = self.stranger(state, name, link)
                before = tree(outside)
                words = [w.format(ds=ds, pipeline=self.pipeline, other=self.complete) for w in (COMMANDS | EXPORT)[command]]
                done = self.run_program(*words)
                self.assertEqual(tree(outside), before, done.stdout)
                self.assertIn(done.returncode, (0, 1, 2), done.stdout)
                if done.returncode == 0 and command in ("overwrite", "resume"):
                    self.run_program("verify", str(ds), code=0)
        print(f"{len(cases)} cases of links: nothing outside of the folders changed", file=sys.stderr)


if __name__ == "__main__":
    unittest.main()
