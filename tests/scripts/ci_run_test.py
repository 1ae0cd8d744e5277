"""What .ci/run had no time for is a failure. It runs here in a folder whose scripts do nothing but last some seconds."""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def last_line(limit, seconds_of_tests):
    """The exit code and the last line, where the tests last so long."""
    with tempfile.TemporaryDirectory() as folder:
        for name in ("lint", "test", "sanitize", "fuzz"):
            script = Path(folder) / "scripts" / name
            script.parent.mkdir(exist_ok=True)
            script.write_text(f"#!/bin/sh\nsleep {seconds_of_tests if name == 'test' else 0}\n")
            script.chmod(0o755)
        run = Path(folder) / ".ci" / "run"
        run.parent.mkdir()
        shutil.copy(ROOT / ".ci/run", run)
        done = subprocess.run([run], capture_output=True, text=True, env={**os.environ, "SCANMILL_CI_SECONDS": limit})
        return done.returncode, done.stdout.splitlines()[-1]


class CiRun(unittest.TestCase):
    def test_all_parts_count(self):
        self.assertEqual(last_line("4800", 0), (0, "6 passed, 0 failed"))

    def test_what_had_no_time_is_a_failure(self):
        self.assertEqual(last_line("3", 60), (1, "1 passed, 5 failed"))


if __name__ == "__main__":
    unittest.main()
