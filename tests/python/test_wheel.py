"""The wheel that `pip install .` installs works away from the source tree and from the build."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "src" / "python"))
import build_backend  # noqa: E402

GLIBC = re.compile(r"lib(c|m|mvec|dl|rt|pthread|resolv|util|anl)\.so|ld-linux")

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
            (Path(folder) / "site" / "scanmill" / "bin" / "scanmill").chmod(0o755)
            said = subprocess.run([sys.executable, "-m", "scanmill.program", "list", "scenes"], cwd="/", env=environment,
                                  capture_output=True, text=True, check=True).stdout
            self.assertIn(folder, said, "the program, with its own scenes")

    @unittest.skipUnless(shutil.which("patchelf"), "patchelf is missing: scripts/setup --bundle")
    def test_a_bundled_one_brings_the_program_and_its_libraries(self):
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(os.environ, SCANMILL_BUNDLE="1"):
            name = build_backend.build_wheel(folder)
            self.assertIn("manylinux", name)
            self.assertLess((Path(folder) / name).stat().st_size, 70e6)
            with zipfile.ZipFile(Path(folder) / name) as archive:
                modes = {entry.filename: entry.external_attr >> 16 for entry in archive.infolist()}
                archive.extractall(Path(folder) / "site")
            self.assertTrue(modes["scanmill/bin/scanmill"] & 0o100, "pip makes it a program")
            package = Path(folder) / "site" / "scanmill"
            (package / "bin" / "scanmill").chmod(0o755)
            # Nothing but glibc and what graphics drivers link comes from elsewhere.
            own = {p.name for p in (package / "lib").glob("*.so*")}
            system = {p.name for p in (package / "lib" / "fallback").iterdir()}
            for file in [package / "bin" / "scanmill", *package.glob("_core*.so"), *(package / "lib").glob("libscanmill*")]:
                linked = subprocess.run(["ldd", file], capture_output=True, text=True, check=True).stdout
                for library, path in re.findall(r"(\S+) => (/\S+)", linked):
                    within = Path(path).resolve().is_relative_to(package.resolve())
                    self.assertTrue(within if library in own else library in system or GLIBC.match(library), (file, library, path))
            environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(Path(folder) / "site")}
            subprocess.run([sys.executable, "-c", USE, folder], cwd="/", env=environment, check=True)
            said = subprocess.run([sys.executable, "-m", "scanmill.program", "list", "scenes"], cwd="/", env=environment,
                                  capture_output=True, text=True, check=True).stdout
            self.assertIn(folder, said, "its own scenes")

    def test_a_build_of_another_source_tree_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/moved/from/here\n")
            with unittest.mock.patch.dict(os.environ, SCANMILL_BUILD=folder):
                with self.assertRaisesRegex(SystemExit, "build of /moved/from/here.*SCANMILL_BUILD"):
                    build_backend.built()

    def test_a_build_folder_that_was_moved_with_the_sources_is_configured_anew(self):
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.object(build_backend, "ROOT", Path(folder)):
            cache = Path(folder) / "build" / "python" / "CMakeCache.txt"
            cache.parent.mkdir(parents=True)
            cache.write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/moved/from/here\n")
            with unittest.mock.patch.dict(os.environ), unittest.mock.patch("subprocess.run", side_effect=SystemExit) as run:
                os.environ.pop("SCANMILL_BUILD")
                self.assertRaises(SystemExit, build_backend.built)
            self.assertEqual(run.call_args.args[0][:4], ["cmake", "--fresh", "-S", Path(folder)])

    def test_a_build_for_another_python_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            for cache, expected in [("PYTHON_MODULE_EXTENSION:INTERNAL=.cpython-27-none.so", "another Python"),
                                    ("CMAKE_BUILD_TYPE:STRING=Release", "without the Python package")]:
                (Path(folder) / "CMakeCache.txt").write_text(cache + "\n")
                with self.assertRaisesRegex(SystemExit, expected):
                    build_backend.check_interpreter(Path(folder))


if __name__ == "__main__":
    unittest.main()
