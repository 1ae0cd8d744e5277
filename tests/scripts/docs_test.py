"""The site that scripts/docs makes: a page for each part, and words that a reader would search for lead to the right one."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def main():
    if subprocess.run(["/usr/bin/python3", "-c", "import sphinx, myst_parser, furo"], capture_output=True).returncode:
        print("skipped: Sphinx, MyST or Furo is not installed")
        return 77
    program = os.environ["SCANMILL"]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "site"
        made = subprocess.run([ROOT / "scripts" / "docs", "--program", program, "--out", out], capture_output=True, text=True)
        assert made.returncode == 0, made.stdout + made.stderr
        for kind in ("effects", "sensors", "methods", "formats"):
            listed = subprocess.run([program, "list", kind], check=True, capture_output=True, text=True).stdout
            rows = listed.split("\n\n")[0].splitlines()[2 if kind == "sensors" else 1:]
            assert rows, listed
            for name in (row.split()[0] for row in rows):
                assert (out / kind / f"{name}.html").exists(), f"{kind}/{name}"
                pictured = kind in ("effects", "sensors")
                assert not pictured or (out / "_images" / f"{name}.png").exists() or list(
                    (out / "_images").glob(f"{name}*.png")), name
        assert "mixed pixels" in (out / "effects" / "footprint.html").read_text()
        assert "Scene.from_arrays" in (out / "reference" / "scanmill.html").read_text()
        assert "effects/footprint" in (out / "searchindex.js").read_text()
        assert 'href="effects/blooming.html"' in (out / "index_of_keys.html").read_text()
        for page in out.rglob("*.html"):
            assert "http" not in "".join(part for part in page.read_text().split("<") if part.startswith(("script", "link"))
                                         ), f"{page} loads something"
    return 0


sys.exit(main())
