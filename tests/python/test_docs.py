"""The examples in Python of two pages run, those of a page one after the other, on a generated dataset."""

import contextlib
import io
import os
import re
import tempfile
import unittest

from support import ROOT, dataset_path

PAGES = {ROOT / "docs" / "python.md": 6, ROOT / "docs" / "architecture.md": 1}  # and how many examples they have at least


class Docs(unittest.TestCase):
    def test_examples_run(self):
        here = os.getcwd()
        folder = tempfile.TemporaryDirectory()  # for what examples write
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, here)
        os.chdir(folder.name)
        for page, least in PAGES.items():
            names = {"__name__": "docs", "dataset": dataset_path(self)}
            text = page.read_text(encoding="utf-8")
            blocks = list(re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
            self.assertGreaterEqual(len(blocks), least)
            for block in blocks:
                # Empty lines before it, so that tracebacks have the page's own line numbers.
                lines = text.count("\n", 0, block.start(1))
                with contextlib.redirect_stdout(io.StringIO()):
                    exec(compile("\n" * lines + block[1], str(page), "exec"), names)


if __name__ == "__main__":
    unittest.main()
