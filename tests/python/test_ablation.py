"""scripts/ablation.py makes datasets that lack one thing each, trains on them, and tells what was lost."""

import importlib.util
import json
import math
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "scripts" / "ablation.py"
sys.path.insert(0, str(SCRIPT.parent))  # it takes the sets of --judge as train_example.py does
MISSING = [name for name in ("torch", "matplotlib") if importlib.util.find_spec(name) is None]


def loaded():
    spec = importlib.util.spec_from_file_location("ablation", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run_of(miou):
    return {"sets": {"test": {"miou": miou, "iou": {"road": miou}}}}


@unittest.skipIf(MISSING, f"no {', '.join(MISSING)} here")
class Ablation(unittest.TestCase):
    def test_losses_and_their_errors(self):
        ablation = loaded()
        runs = {ablation.BASE: [run_of(m) for m in (0.4, 0.5, 0.6)], "glass": [run_of(m) for m in (0.3, 0.3, 0.3)]}
        found = ablation.judged(runs)["own"]
        self.assertAlmostEqual(found[ablation.BASE]["lost"], 0)
        self.assertAlmostEqual(found["glass"]["lost"], 20)
        # Squares of 100 + 0 + 100 and none over four degrees of freedom, for the difference of two means of three.
        self.assertAlmostEqual(found["glass"]["error"], math.sqrt(200 / 4 * 2 / 3))
        alone = ablation.judged({name: seeds[:1] for name, seeds in runs.items()})["own"]
        self.assertIsNone(alone["glass"]["error"])
        row = ablation.table({"own": found}).splitlines()[-1]
        self.assertEqual(row.split(), ["glass", "30.0", "+20.0", "±", "5.8"])

    def test_variants_leave_out_what_they_say(self):
        ablation = loaded()
        everything = "effects=[sensor, relief, reflectance_variation, light_paths]"
        pipeline = (SCRIPT.parents[1] / "pipelines/training.yaml").read_text()
        self.assertIn(everything.replace("=", ": "), pipeline)
        for name, word in [("glass", "light_paths"), ("relief", "relief"), ("variation of reflectance", "reflectance_variation")]:
            kept = [word_ for word_ in ("relief", "reflectance_variation", "light_paths") if word_ != word]
            self.assertEqual(ablation.VARIANTS[name][1], f"effects=[sensor, {', '.join(kept)}]")
        self.assertIn("{footprint: none}", ablation.VARIANTS["footprint"][1])
        self.assertIn("{ring_bias: none}", ablation.VARIANTS["ring errors"][1])

    def test_mistakes_are_told_before_anything_is_made(self):
        with tempfile.TemporaryDirectory() as folder:
            for more, expected in [(["--judge", f"real={folder}/absent"], "no folder"), (["--judge", folder], "NAME=FOLDER")]:
                done = subprocess.run([sys.executable, SCRIPT, "-o", f"{folder}/out", *more], capture_output=True, text=True)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(expected, done.stderr)
                self.assertFalse(Path(folder, "out").exists())
            Path(folder, "manifest.json").write_text("{}")
            done = subprocess.run([sys.executable, SCRIPT, "-o", folder], capture_output=True, text=True)
            self.assertIn("manifest.json", done.stderr)
            self.assertEqual([f.name for f in Path(folder).iterdir()], ["manifest.json"])

    def test_goes_on_where_it_was(self):
        with tempfile.TemporaryDirectory() as folder:
            small = ["sensors.0.columns=64", "trajectories.0.frames=2", "trajectories.1.frames=1", "scenes.0.seeds=[1, 2, 3]"]
            small.append("splits={by: seed, train: [1], val: [2], test: [3]}")
            command = [sys.executable, SCRIPT, "-o", folder, "--only", "glass", "--seeds", "1", "--steps", "2"]
            command += [word for assignment in small for word in ("--set", assignment)]
            first = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(first.returncode, 0, first.stderr)
            self.assertIn("network 2 of 2", first.stdout)
            report = json.loads((Path(folder) / "ablation.json").read_text())
            self.assertEqual(set(report["sets"]), {"own", "held_out"})
            self.assertGreater((Path(folder) / "ablation.png").stat().st_size, 5000)
            modelled = json.loads((Path(folder) / "sets/glass/manifest.json").read_text())["modelled"]
            self.assertFalse([item for item in modelled if item["topic"] == "effect light_paths"])
            # What is there is not made again.
            weights = Path(folder) / "runs/glass-0/weights.pt"
            made = weights.stat().st_mtime_ns
            again = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(again.returncode, 0, again.stderr)
            self.assertEqual(weights.stat().st_mtime_ns, made)
            self.assertEqual(again.stdout.splitlines()[-3:], first.stdout.splitlines()[-3:])


if __name__ == "__main__":
    unittest.main()
