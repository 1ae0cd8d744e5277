"""The examples of docs/python.md run, one after the other, on a generated dataset."""

import contextlib
import io
import re
import unittest

from support import ROOT, dataset_path

PAGE = ROOT / "docs" / "python.md"


class Docs(unittest.TestCase):
    def test_examples_run(self):
        names = {"__name__": "docs", "dataset": dataset_path(self)}
        text = PAGE.read_text(encoding="utf-8")
        blocks = list(re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
        self.assertGreater(len(blocks), 5)
        for block in blocks:
            # Empty lines before it, so that tracebacks have the page's own line numbers.
            lines = text.count("\n", 0, block.start(1))
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile("\n" * lines + block[1], str(PAGE), "exec"), names)


if __name__ == "__main__":
    unittest.main()
