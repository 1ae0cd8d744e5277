"""The quickstart's drives beside labelled scans of eleven real ones: shares of classes, intensities, distances, what stands where.

Two aggregates are compared for each row: the median over the drives, which is to be within a third of the real one, and the span
from the least to the greatest drive, which is to overlap the real one. The real figures are those of
lidar/real_statistics.md; what stands on what was measured on the same scans.
"""

import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
import street_statistics

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data" / "lidar" / "real_statistics.md"
QUICKSTART = Path(__file__).resolve().parents[2] / "pipelines" / "quickstart.yaml"

# Our names of the rows of the page's last table.
ROWS = {
    "share of road": "share of road",
    "share of sidewalk": "share of sidewalk",
    "share of terrain": "share of terrain",
    "share of building": "share of building",
    "share of fence": "share of fence",
    "share of vegetation": "share of vegetation (without trunks)",
    "share of trunk": "share of trunks",
    "share of pole": "share of poles",
    "intensity of road": "remission of road, median",
    "spread of road": "remission of road, median: its spread within a place (half of the 16-84 % span)",
    "zeros of road": "remission of road, median: share of exact zeros",
    "intensity of road at 4-8 m": "remission of road, median: at 4-8 m",
    "intensity of road at 8-12 m": "remission of road, median: at 8-12 m",
    "intensity of road at 12-20 m": "remission of road, median: at 12-20 m",
    "intensity of road at 20-35 m": "remission of road, median: at 20-35 m",
    "intensity of sidewalk": "remission of sidewalk",
    "spread of sidewalk": "remission of sidewalk: spread",
    "sidewalk less road": "remission of sidewalk: sidewalk less road",
    "intensity of terrain": "remission of terrain",
    "spread of terrain": "remission of terrain: spread",
    "terrain less road": "remission of terrain: terrain less road",
    "intensity of building": "remission of building",
    "intensity of fence": "remission of fence",
    "intensity of vegetation": "remission of vegetation",
    "spread of vegetation": "remission of vegetation: spread",
    "intensity of trunk": "remission of trunks",
    "intensity of pole": "remission of poles",
    "spread of pole": "remission of poles: spread",
    "spread of vehicle": "remission of vehicles, median: spread",
    "zeros of vehicle": "remission of vehicles, median: exact zeros",
    "vehicles of more than 20 points": "vehicles with more than 20 points, a scan",
    "free way": "free way between -1.3 and 1 m about the sensor, median over 3 degree sectors (m)",
    "free way, 10th percentile": "free way between -1.3 and 1 m about the sensor, median over 3 degree sectors (m): its 10th percentile",
    "height error of rings, mm": "fixed height error of the rings on road, standard deviation (mm)",
    "points at 0-5 m": "share of points within 5 m",
    "points at 5-10 m": "share of points within 5 m: 5-10 m",
    "points at 10-20 m": "share of points within 5 m: 10-20 m",
    "points at 20-40 m": "share of points within 5 m: 20-40 m",
    "points at 40-1000 m": "share of points within 5 m: beyond 40 m",
    "distance of building": "distance of building points, median (m)",
    "distance of vegetation": "distance of vegetation points (m)",
}
LEAST_ALIKE = 100  # figures of small surfaces within a factor of 1.5 of the real ones
FEET = {"building": 0.83}  # the share of a class's feet that stands on sidewalk


def real_figures():
    """(median, least, greatest) by the name of a row; rows within a group have the group's name before a colon."""
    figures, group = {}, ""
    for line in SHARED.read_text().split("## Eleven streets", 1)[1].splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if len(cells) != 5 or " to " not in cells[2] or cells[1] == "real":
            continue
        name = cells[0].replace("&nbsp;", "").strip()
        if not cells[0].startswith("&nbsp;"):
            group = name
        else:
            name = f"{group}: {name}"
        low, high = cells[2].split(" to ")
        figures[name] = (float(cells[1]), float(low), float(high))
    return figures


@unittest.skipUnless(SHARED.exists(), "no ../shared/data/lidar/real_statistics.md here")
class Realism(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "out"
            command = [os.environ["SCANMILL"], "generate", str(QUICKSTART), "-o", str(out), "--quiet"]
            subprocess.run(command, check=True, capture_output=True)
            cls.drives = street_statistics.of_dataset(out)
            cls.small = street_statistics.small_surfaces(out)

    def test_drives_are_like_real_ones(self):
        self.assertEqual(len(self.drives), 12)
        simulated, real = street_statistics.summary(self.drives), real_figures()
        for row, name in ROWS.items():
            median, least, greatest = simulated[row]
            with self.subTest(row=row, simulated=simulated[row], real=real[name]):
                self.assertLessEqual(abs(median - real[name][0]), abs(real[name][0]) / 3 + 1e-3)
                self.assertLessEqual(least, real[name][2])
                self.assertGreaterEqual(greatest, real[name][1])

    def test_surfaces_in_the_small(self):
        figures = []  # (real, simulated)
        for line in SHARED.read_text().split("## Surfaces in the small", 1)[1].splitlines():
            row = re.match(r"\| (\w+), (\d+)-(\d+) \|(.*)\|$", line)
            if row:
                real = [float(cell.split("/")[0]) for cell in row[4].split("|")]
                figures += zip(real, self.small.get((row[1], int(row[2]), int(row[3])), [np.nan] * len(real)))
        compared = [(real, simulated) for real, simulated in figures if real > 0.05]
        alike = sum(real / 1.5 <= simulated <= real * 1.5 for real, simulated in compared)
        self.assertEqual(len(compared), 208)
        self.assertGreaterEqual(alike, LEAST_ALIKE)

    def test_what_stands_on_sidewalks(self):
        simulated = street_statistics.summary(self.drives)
        for name, real in FEET.items():
            with self.subTest(name=name):
                self.assertLessEqual(abs(simulated[f"feet of {name} on sidewalk"][0] - real), real / 3)


if __name__ == "__main__":
    unittest.main()
