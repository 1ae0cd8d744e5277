"""scripts/check_layers finds and names what includes against the layers, in small trees made for it."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CMAKE = """
scanmill_caps(src 30 tests 5)
scanmill_library(core base "errors and files" CAP 10 PRIVATE TBB::tbb)
scanmill_library(core scan "points" CAP 10)
if(SCANMILL_STUDIO)
  scanmill_library(studio charts "charts" CAP 10)
  scanmill_library(studio viewer "a window" CAP 10 OPTIMIZE 1)
  scanmill_library(. commands "subcommands" CAP 10)
endif()
"""
SOUND = {
    "src/core/base/error.h": "#include <string>\n#include <cstdint>\n",
    "src/core/scan/scan.h": '#include "base/error.h"\n#include <fmt/core.h>\n',
    "src/core/scan/scan.cpp": '#include "scan/scan.h"\n#include <vtkNew.h>\n#include <nlohmann/json.hpp>\n',
    "src/core/scan/gl_module/window.h": "#include <EGL/egl.h>\n",
    "src/studio/charts/chart.h": '#include "scan/scan.h"\n',
    "src/studio/viewer/view.cpp": '#include "charts/chart.h"\n',
    "src/commands/view.h": "#include <vector>\n",
    "src/main.cpp": '#include "commands/view.h"\n#include "charts/chart.h"\n#include "base/error.h"\n',
}


def check(changes):
    """Exit code and standard error of the check on a sound tree with `changes`, file -> text."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in {"CMakeLists.txt": CMAKE, **SOUND, **changes}.items():
            file = Path(folder) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        done = subprocess.run([sys.executable, ROOT / "scripts/check_layers", folder], capture_output=True, text=True)
    return done.returncode, done.stderr


class CheckLayers(unittest.TestCase):
    def expect_fault(self, file, text, line, *words):
        code, said = check({file: text})
        self.assertEqual(code, 1, said)
        self.assertIn(f"{file}:{line}: #include", said)
        self.assertIn("1 includes against the layers", said)
        for word in words:
            self.assertIn(word, said)

    def test_a_sound_tree_passes(self):
        self.assertEqual(check({}), (0, ""))

    def test_this_tree_passes(self):
        done = subprocess.run([sys.executable, ROOT / "scripts/check_layers"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_library_after(self):
        self.expect_fault("src/core/base/error.cpp", '\n#include "scan/scan.h"\n', 2, "scan comes after base")

    def test_a_library_after_in_the_studio(self):
        self.expect_fault("src/studio/charts/chart.cpp", '#include "viewer/view.h"', 1, "viewer comes after charts")

    def test_the_studio_in_the_core(self):
        self.expect_fault("src/core/scan/draw.cpp", '#include "charts/chart.h"', 1, "the core never includes the studio")

    def test_the_commands_in_the_core(self):
        self.expect_fault("src/core/scan/draw.cpp", '#include "commands/view.h"', 1, "'commands' is no library")

    def test_a_path_that_starts_at_no_library(self):
        self.expect_fault("src/core/scan/draw.cpp", '#include "scan.h"', 1, "'scan.h' is no library")

    def test_a_folder_that_is_no_library(self):
        self.expect_fault("src/core/extra/extra.cpp", '#include "base/error.h"', 1, 'scanmill_library(core extra "its subject")')

    def test_folders_in_a_circle(self):
        code, said = check({"src/core/scan/read/read.h": '#include "scan/write/write.h"\n',
                            "src/core/scan/write/write.h": "\n",
                            "src/core/scan/write/write.cpp": '#include "scan/read/read.h"\n'})
        self.assertEqual(code, 1, said)
        self.assertIn("2 includes against the layers", said)
        self.assertIn("src/core/scan/write/write.cpp:1: #include", said)
        self.assertIn("read and write of scan include one another", said)

    def test_headers_beside_folders_stand_below_and_sources_above(self):
        sound = {"src/core/scan/read/read.h": '#include "scan/scan.h"\n', "src/core/scan/all.cpp": '#include "scan/read/read.h"\n'}
        self.assertEqual(check(sound), (0, ""))
        code, said = check({**sound, "src/core/scan/scan.h": '#include "scan/read/read.h"\n'})
        self.assertEqual(code, 1, said)
        self.assertIn("its headers and read of scan include one another", said)

    def test_the_page_shows_the_libraries_that_there_are(self):
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "docs/architecture.md"
            files = {"CMakeLists.txt": CMAKE, **SOUND, "docs/architecture.md": "a\n<!-- libraries -->\nold\n<!-- /libraries -->\nb\n"}
            for name, text in files.items():
                (Path(folder) / name).parent.mkdir(parents=True, exist_ok=True)
                (Path(folder) / name).write_text(text)
            run = lambda *options: subprocess.run([sys.executable, ROOT / "scripts/check_layers", folder, *options],
                                                  capture_output=True, text=True)
            self.assertIn("docs/architecture.md shows other libraries", run().stderr)
            self.assertEqual(run("--write").returncode, 0)
            self.assertEqual(run().returncode, 0)
            self.assertIn("| `core/scan` | points | base |", page.read_text())
            self.assertIn("| `studio/charts` | charts | scan |", page.read_text())
            self.assertIn(">a window</text>", (page.parent / "architecture.svg").read_text())

    def test_paths_in_the_docs_that_lead_nowhere(self):
        code, said = check({"docs/contributing.md": "`scan/scan.h`, `src/main.cpp`, `NAME.cpp`, `scan/gone.cpp`\n"})
        self.assertEqual((code, said), (1, "docs/contributing.md names scan/gone.cpp, which does not exist\n"))

    def test_what_outgrows_its_cap(self):
        for file, lines, words in (("src/core/base/large.cpp", 9, "src/core/base has 11 lines, its cap in CMakeLists.txt is 10"),
                                   ("src/core/base/large.cpp", 8, ""),
                                   ("src/python/large.cpp", 20, "src has 34 lines"),
                                   ("tests/large.py", 6, "tests has 6 lines")):
            code, said = check({file: "\n" * lines})
            self.assertEqual(code, 1 if words else 0, said)
            self.assertIn(words, said)

    def test_a_library_in_a_header(self):
        for header in ("vtkNew.h", "pcl/point_types.h", "embree3/rtcore.h", "X11/Xlib.h", "nlohmann/json.hpp"):
            self.expect_fault("src/core/base/error.h", f"#include <string>\n#include <{header}>\n", 2, header,
                              "in the .cpp alone")


if __name__ == "__main__":
    unittest.main()
