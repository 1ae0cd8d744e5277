"""Figures that pages quote from docs/performance.md, such as 12 s<!--quickstart_time-->, are those of that page."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FIGURE = re.search(r'^FIGURE = r"(.*)"$', (ROOT / "scripts/performance_page").read_text(), re.M)[1]


class Figures(unittest.TestCase):
    def test_are_those_of_the_page_of_measurements(self):
        measured = {name: figure for figure, name in re.findall(FIGURE, (ROOT / "docs/performance.md").read_text())}
        self.assertGreater(len(measured), 10)
        for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
            quoted = re.findall(FIGURE, page.read_text())
            self.assertEqual(len(quoted), len(re.findall(r"<!--\w+-->", page.read_text())), page.name)
            for figure, name in quoted:
                self.assertEqual(figure, measured.get(name), f"{page.name}: {name}")


if __name__ == "__main__":
    unittest.main()
