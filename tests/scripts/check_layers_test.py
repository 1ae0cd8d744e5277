"""scripts/check_layers finds and names what includes against the layers, in small trees made for it."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CMAKE = """
scanmill_room(core base PRIVATE TBB::tbb)
scanmill_room(core scan)
if(SCANMILL_STUDIO)
  scanmill_room(studio charts)
  scanmill_room(studio viewer)
  scanmill_room(. commands)
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

    def test_a_room_after(self):
        self.expect_fault("src/core/base/error.cpp", '\n#include "scan/scan.h"\n', 2, "scan comes after base")

    def test_a_room_after_in_the_studio(self):
        self.expect_fault("src/studio/charts/chart.cpp", '#include "viewer/view.h"', 1, "viewer comes after charts")

    def test_the_studio_in_the_core(self):
        self.expect_fault("src/core/scan/draw.cpp", '#include "charts/chart.h"', 1, "the core never includes the studio")

    def test_the_commands_in_the_core(self):
        self.expect_fault("src/core/scan/draw.cpp", '#include "commands/view.h"', 1, "'commands' is no room")

    def test_a_path_that_starts_at_no_room(self):
        self.expect_fault("src/core/scan/draw.cpp", '#include "scan.h"', 1, "'scan.h' is no room")

    def test_a_folder_that_is_no_room(self):
        self.expect_fault("src/core/extra/extra.cpp", '#include "base/error.h"', 1, "scanmill_room(core extra)")

    def test_a_library_in_a_header(self):
        for header in ("vtkNew.h", "pcl/point_types.h", "embree3/rtcore.h", "X11/Xlib.h", "nlohmann/json.hpp"):
            self.expect_fault("src/core/base/error.h", f"#include <string>\n#include <{header}>\n", 2, header,
                              "in the .cpp alone")


if __name__ == "__main__":
    unittest.main()
