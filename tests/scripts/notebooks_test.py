"""The notebooks of docs/notebooks: scripts/notebooks runs them without errors, and their stored outputs are those that
their sources give."""

import importlib.machinery
import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STORED = ROOT / "docs" / "notebooks"
PYTHON = "/usr/bin/python3"
# The texts of these follow from their pipelines alone. Figures of training depend on the version of torch.
REPEATABLE = ["first_scan", "own_mesh_and_sensor"]
ABSOLUTE_PATH = re.compile(r"(?<![\w.:/])/(?:\w[\w.-]*/)*\w[\w.-]*")


def imports(modules):
    return subprocess.run([PYTHON, "-c", f"import {modules}"], capture_output=True).returncode == 0


def load_script():
    sys.dont_write_bytecode = True
    loader = importlib.machinery.SourceFileLoader("notebooks", str(ROOT / "scripts" / "notebooks"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("notebooks", loader))
    loader.exec_module(module)
    return module


def sources(cells):
    return [(cell["cell_type"], cell["metadata"], "".join(cell["source"])) for cell in cells]


def main():
    script = load_script()
    if not imports(script.MODULES):
        print(f"skipped: one of {script.MODULES} is not installed")
        return 77
    names = sorted(file.stem for file in STORED.glob("*.py"))
    assert names == sorted([*REPEATABLE, script.NEEDS_TORCH]), names

    stored = {}
    for name in names:
        file = STORED / f"{name}.ipynb"
        stored[name] = json.loads(file.read_text())["cells"]
        cells = script.cells_of((STORED / f"{name}.py").read_text())
        assert sources(stored[name]) == sources(cells), f"{file} is not of its source: run scripts/notebooks {name}"
        for output in (output for cell in stored[name] for output in cell.get("outputs", [])):
            assert output["output_type"] != "error", f"{file} shows an error: {output}"
            assert output.get("name") != "stderr", f"{file} shows a warning: {output['text']}"
        for text in script.texts(stored[name]):
            found = ABSOLUTE_PATH.search(text)
            assert not found, f"{file}: an output has the absolute path {found[0]}"
        for kind, most in script.MOST_BYTES.items():
            assert file.with_suffix(kind).stat().st_size <= most, f"{file.with_suffix(kind)} is too large"

    run = names if imports("torch") else REPEATABLE
    if run is REPEATABLE:
        print(f"{script.NEEDS_TORCH} is not run: torch is not installed")
    with tempfile.TemporaryDirectory() as folder:
        made = subprocess.run(
            [ROOT / "scripts" / "notebooks", "--program", os.environ["SCANMILL"], "--out", folder, *run],
            capture_output=True,
            text=True,
        )
        assert made.returncode == 0, made.stdout + made.stderr
        for name in run:
            fresh = json.loads((Path(folder) / f"{name}.ipynb").read_text())["cells"]
            assert sources(fresh) == sources(stored[name]), name
            for number, (now, before) in enumerate(zip(script.texts(fresh), script.texts(stored[name])), start=1):
                assert bool(now) == bool(before), f"{name}, code cell {number}: stored {before!r}, now {now!r}"
                if name in REPEATABLE:
                    where = f"{name}, code cell {number}"
                    assert now == before, f"{where}: stored\n{before}\nnow\n{now}\nrun scripts/notebooks {name}"
    return 0


sys.exit(main())
