"""The wheel that `pip install .` installs works away from the source tree and from the build."""

import os
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "src" / "python"))
import build_backend  # noqa: E402

USE = """
import sys, scanmill
assert scanmill.__file__.startswith(sys.argv[1]), scanmill.__file__
assert scanmill._core.resource_folder.startswith(sys.argv[1]), scanmill._core.resource_folder
scene = scanmill.load_scene("street")
scan = scene.scan(scanmill.sensor("vlp_16"), pose={"position": [0, -1.75, 1.9]})
assert len(scan) > 10000, len(scan)
if len(sys.argv) > 2:
    assert len(scanmill.open(sys.argv[2])[0].scan().xyz) > 0
"""


@unittest.skipUnless("SCANMILL_BUILD" in os.environ, "SCANMILL_BUILD does not name a build with the extension")
class Wheel(unittest.TestCase):
    def test_holds_all_that_it_needs(self):
        with tempfile.TemporaryDirectory() as folder:
            name = build_backend.build_wheel(folder)
            wheel = Path(folder) / name
            with zipfile.ZipFile(wheel) as archive:
                names = archive.namelist()
                archive.extractall(Path(folder) / "site")
            record = [line.split(",")[0] for line in
                      (Path(folder) / "site" / [n for n in names if n.endswith("/RECORD")][0]).read_text().splitlines()]
            self.assertEqual(sorted(record), sorted(names))
            self.assertIn("scanmill/py.typed", names)
            dataset = os.environ.get("SCANMILL_TEST_DATASET")
            environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "SCANMILL_RESOURCES")}
            environment["PYTHONPATH"] = str(Path(folder) / "site")
            subprocess.run([sys.executable, "-c", USE, folder] + ([dataset] if dataset else []), cwd="/",
                           env=environment, check=True)

    def test_a_build_for_another_python_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            for cache, expected in [("PYTHON_MODULE_EXTENSION:INTERNAL=.cpython-27-none.so", "another Python"),
                                    ("CMAKE_BUILD_TYPE:STRING=Release", "without the Python package")]:
                (Path(folder) / "CMakeCache.txt").write_text(cache + "\n")
                with self.assertRaisesRegex(SystemExit, expected):
                    build_backend.check_interpreter(Path(folder))


if __name__ == "__main__":
    unittest.main()
