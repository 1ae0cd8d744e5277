"""scripts/train_example.py learns on a small dataset, and judges simulated and recorded scans alike."""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "scripts" / "train_example.py"
DATASET = os.environ["SCANMILL_TEST_DATASET"]
SMALL = ["--rings", "24", "--columns", "192", "--elevation", "-20", "5", "--threads", "1"]
MISSING = [name for name in ("torch", "matplotlib") if importlib.util.find_spec(name) is None]


def run(*arguments):
    return subprocess.run([sys.executable, str(SCRIPT), *arguments], capture_output=True, text=True)


@unittest.skipIf(MISSING, f"no {', '.join(MISSING)} here")
class TrainExample(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def train(self, out, *more, beside=()):
        done = run(DATASET, *beside, "-o", str(self.folder / out), *SMALL, *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout, json.loads((self.folder / out / "figures.json").read_text())

    def test_learns_and_judges(self):
        exported = self.folder / "kitti"
        export = [os.environ["SCANMILL"], "export", DATASET, "--to", "semantic_kitti", "--split", "test", "-o"]
        subprocess.run([*export, str(exported), "--quiet", "--sensor", "top"], check=True)
        printed, figures = self.train("out", "--steps", "60", "--judge", f"same={exported}")
        test, same = figures["sets"]["test"], figures["sets"]["same"]
        # A network that has learned nothing takes all for one class, which gives it a ninth of the mean.
        self.assertGreater(test["miou"], 0.2)
        self.assertGreater(test["accuracy"], 0.55)
        # The same scans as a folder of somebody else's: what differs is the rounding of Draco's positions, intensities
        # above 1, which are cut, and the classes that SemanticKITTI has none for.
        self.assertAlmostEqual(same["accuracy"], test["accuracy"], delta=0.02)
        self.assertAlmostEqual(same["iou"]["road"], test["iou"]["road"], delta=0.05)
        self.assertIn("mean", printed)
        names = figures["classes"]
        confusion = test["confusion"]
        road = names.index("road")
        union = sum(confusion[road]) + sum(row[road] for row in confusion) - confusion[road][road]
        self.assertAlmostEqual(test["iou"]["road"], confusion[road][road] / union)
        for name in ("scans.png", "confusion.png", "weights.pt"):
            self.assertGreater((self.folder / "out" / name).stat().st_size, 10000, name)

    def test_recorded_scans_teach_as_well(self):
        drives = self.folder / "drives"
        export = [os.environ["SCANMILL"], "export", DATASET, "--to", "semantic_kitti", "-o", str(drives), "--quiet", "--sensor", "top"]
        subprocess.run(export, check=True)
        small = [*SMALL, "--steps", "4"]
        fold = self.folder / "fold"
        fold.mkdir()
        (fold / "drives").symlink_to(drives)
        done = run(str(fold), "-o", str(self.folder / "real"), *small, "--judge", f"same={drives}")
        self.assertEqual(done.returncode, 0, done.stderr)
        figures = json.loads((self.folder / "real" / "figures.json").read_text())
        self.assertEqual(list(figures["sets"]), ["same"])  # there is no test set
        scans = len(list(drives.rglob("velodyne/*.bin")))
        self.assertEqual(figures["training"]["scans"], scans - scans // 10)
        printed, both = self.train("both", "--steps", "4", beside=[f"{drives}:2"])
        self.assertIn(f"2 x {scans - scans // 10} scans of {drives}", printed)
        self.assertEqual((list(both["sets"]), both["training"]["scans"]), (["test"], scans - scans // 10 + 4))
        _, once = self.train("once", "--steps", "4", beside=[str(drives)])
        self.assertNotEqual(once["sets"], both["sets"])
        for scan in sorted(drives.rglob("velodyne/*.bin"))[9:]:
            scan.unlink()
        done = run(str(drives), "-o", str(self.folder / "few"), *small, "--judge", f"same={drives}")
        self.assertIn("ten scans", done.stderr)
        self.assertIn("--judge", run(str(drives), "-o", str(self.folder / "none"), *small).stderr)

    def test_a_folder_of_sets_is_judged_set_by_set(self):
        for name in ("corruption=null", "corruption=fog-light", "corruption=fog-heavy", "corruption=lost_rings-light"):
            (self.folder / "sets").mkdir(exist_ok=True)
            (self.folder / "sets" / name).symlink_to(DATASET)
        printed, figures = self.train("out", "--steps", "8", "--judge", f"robust={self.folder / 'sets'}")
        rates = figures["resilience"]["robust"]
        self.assertEqual(set(rates), {"fog", "lost_rings", "mean"})
        for rate in rates.values():  # all are the same set
            self.assertAlmostEqual(rate, 1)
        self.assertIn("robust/corruption=fog-heavy", printed)

    def test_the_same_seed_learns_the_same(self):
        _, first = self.train("first", "--steps", "4")
        _, again = self.train("again", "--steps", "4")
        _, other = self.train("other", "--steps", "4", "--seed", "1")
        self.assertEqual(first["sets"], again["sets"])
        self.assertNotEqual(first["sets"], other["sets"])

    def test_weights_that_are_there_judge_as_they_did(self):
        _, learned = self.train("learned", "--steps", "8")
        weights = self.folder / "learned" / "weights.pt"
        done = run(DATASET, "-o", str(self.folder / "judged"), "--weights", str(weights), "--threads", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        judged = json.loads((self.folder / "judged" / "figures.json").read_text())
        self.assertEqual(judged["sets"]["test"], learned["sets"]["test"])
        done = run(DATASET, "-o", str(self.folder / "more"), "--weights", str(weights), "--threads", "1", "--judge", f"again={DATASET}")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(list(json.loads((self.folder / "more" / "figures.json").read_text())["sets"]), ["again"])
        self.assertEqual(judged["training"], {})
        self.assertFalse((self.folder / "judged" / "weights.pt").exists())

    def test_bad_requests_are_named(self):
        empty = self.folder / "empty"
        empty.mkdir()
        full = self.folder / "full"
        full.mkdir()
        (full / "mine.txt").write_text("mine")
        for arguments, expected in [
            ([str(empty), "-o", str(self.folder / "a")], "empty"),
            ([DATASET, "-o", str(self.folder / "b"), "--judge", "real"], "NAME=FOLDER"),
            ([DATASET, "-o", str(self.folder / "c"), "--judge", f"real={self.folder}/absent"], "no folder"),
            ([DATASET, "-o", str(self.folder / "d"), "--judge", f"real={empty}"], "velodyne"),
            ([DATASET, "-o", str(full)], "not empty"),
            ([DATASET, "-o", str(self.folder / "e"), "--columns", "180"], "multiple"),
            ([f"{DATASET}:0", "-o", str(self.folder / "i")], "once or more"),
            ([DATASET, "-o", str(self.folder / "h"), "--elevation", "3", "-25"], "LOW HIGH"),
            ([DATASET, "-o", str(self.folder / "f"), "--weights", str(self.folder / "absent.pt")], "absent.pt"),
            ([DATASET, "-o", str(self.folder / "g"), "--weights", str(full / "mine.txt")], "mine.txt"),
        ]:
            done = run(*arguments)
            self.assertNotEqual(done.returncode, 0, arguments)
            self.assertIn("error: ", done.stderr)
            self.assertIn(expected, done.stderr)
            self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main()
