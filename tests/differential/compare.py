#!/usr/bin/env python3
"""Holds what the program reads against what programs of others read, on corpora that Debian has.

    tests/differential/compare.py PROGRAM [FOLDER|FILE...]    # else all corpora that are installed

Compared are the box around the triangles, the number of triangles, and triangles by material. A difference is a defect,
or a line of reasons.tsv: FILE (a pattern), READER, WHAT (box, triangles, materials or unread), and the reason. The exit
code is 1 for a difference without a line, and for a line without a difference.
"""

import fnmatch
import json
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).parent
CORPORA = [
    "/usr/share/assimp/models",
    "/usr/share/games/torcs",
    "/usr/share/games/flightgear/Models",
    "/usr/share/morse/data",
]
READERS = {
    ".obj": ["vtk", "open3d", "blender"],
    ".ply": ["vtk", "open3d", "blender"],
    ".stl": ["vtk", "open3d", "blender"],
    ".gltf": ["vtk", "blender"],
    ".glb": ["vtk", "blender"],
    ".dae": ["blender"],
    ".ac": ["osg"],
    ".acc": ["osg"],
    ".blend": ["blender"],
}


def read_others(reader: str, files: list[str]) -> dict[str, dict]:
    """What a reader says of each file. A file that ends the reader's process counts as unread."""
    start = ["blender", "-b", "--factory-startup", "--python-exit-code", "3", "--python", HERE / "others.py", "--"]
    if reader != "blender":
        start = ["/usr/bin/python3", HERE / "others.py", reader]
    results: dict[str, dict] = {}
    while len(results) < len(files):
        left = files[len(results) :]
        try:
            run = subprocess.run([*start, *left], capture_output=True, timeout=60 + 20 * len(left))
            output = run.stdout
        except subprocess.TimeoutExpired as late:
            output = late.stdout or b""
        for line in output.decode(errors="replace").splitlines():
            if line.startswith("@{"):
                result = json.loads(line[1:])
                results[result["file"]] = result
        if len(results) < len(files):
            results.setdefault(files[len(results)], {"error": "the reader's process ended"})
    return results


def number(text: str) -> float:
    return float(text.replace(",", ""))


def read_ours(program: str, file: str) -> dict:
    run = subprocess.run([program, "info", file, "--allow-outside"], capture_output=True, text=True, errors="replace", timeout=300)
    if run.returncode:
        return {"error": run.stderr.strip().splitlines()[-1] if run.stderr.strip() else f"exit code {run.returncode}"}
    triangles = re.search(r": ([\d,]+) triangles", run.stdout)
    corners = re.search(r"^from \[(.*?)\] to \[(.*?)\]", run.stdout, re.M)
    up = re.search(r"up: ([xyz])", run.stdout)
    if not triangles or not corners or not up:
        return {"error": "no mesh: " + run.stdout[:200].replace("\n", " ")}
    low, high = ([number(c) for c in corners[k].split(", ")] for k in (1, 2))
    if up[1] == "y":  # back to the file's axes: x, z, -y
        in_file = {"low": [low[0], low[2], -high[1]], "high": [high[0], high[2], -low[1]]}
    elif up[1] == "x":
        in_file = {"low": [low[2], low[1], -high[0]], "high": [high[2], high[1], -low[0]]}
    else:
        in_file = {"low": low, "high": high}
    materials: dict[str, int] = {}
    table = re.search(r"^( +node +material .*?)\n\n", run.stdout, re.M | re.S)
    if table:
        head, *rows = table[1].splitlines()
        begin, end = head.index("material"), head.index("texture")
        for row in rows:
            name = row[begin:end].strip()
            materials[name] = materials.get(name, 0) + int(number(row.split()[-1]))
    return {"triangles": int(number(triangles[1])), "file": in_file, "z": {"low": low, "high": high}, "materials": materials}


def merged(materials: dict[str, int]) -> dict[str, int]:
    """Without the numbers by which Blender tells equal names apart."""
    result: dict[str, int] = {}
    for name, count in materials.items():
        name = re.sub(r"\.\d{3}$", "", name)
        result[name] = result.get(name, 0) + count
    return result


def differences(ours: dict, theirs: dict) -> dict[str, str]:
    """What differs, by its kind."""
    if "error" in ours:
        return {"unread": ours["error"]}
    found = {}
    box = ours[theirs["up"]]
    size = max(h - l for l, h in zip(theirs["low"], theirs["high"]))
    apart = max(abs(a - b) for k in ("low", "high") for a, b in zip(box[k], theirs[k]))
    if apart > 1e-4 * size + 1e-4 * max(map(abs, theirs["low"] + theirs["high"])):
        found["box"] = f"{box['low']} to {box['high']}, theirs {theirs['low']} to {theirs['high']}"
    if ours["triangles"] != theirs["triangles"]:
        found["triangles"] = f"{ours['triangles']}, theirs {theirs['triangles']}"
    elif "materials" in theirs:
        mine, other = (merged(each["materials"]) for each in (ours, theirs))
        if mine != other:
            found["materials"] = f"{mine}, theirs {other}"
    return found


def main() -> int:
    program = sys.argv[1]
    roots = [Path(p) for p in sys.argv[2:] or CORPORA]
    files = [str(f) for root in roots for f in ([root] if root.is_file() else sorted(root.rglob("*")))]
    files = [f for f in files if Path(f).suffix.lower() in READERS]
    with ThreadPoolExecutor(2) as pool:
        ours = dict(zip(files, pool.map(lambda f: read_ours(program, f), files)))
    reasons = [line.split("\t") for line in (HERE / "reasons.tsv").read_text().splitlines() if line and line[0] != "#"]
    used, compared, different, bad = set(), 0, 0, 0
    for reader in sorted({r for rs in READERS.values() for r in rs}):
        mine = [f for f in files if reader in READERS[Path(f).suffix.lower()]]
        theirs = read_others(reader, mine) if mine else {}
        for file in mine:
            if "error" in theirs[file] or not theirs[file]["triangles"]:
                continue
            compared += 1
            for what, text in differences(ours[file], theirs[file]).items():
                different += 1
                rows = [i for i, r in enumerate(reasons) if fnmatch.fnmatch(file, r[0]) and r[1] in ("*", reader) and r[2] in ("*", what)]
                used.update(rows)
                if not rows:
                    bad += 1
                    print(f"{file}\t{reader}\t{what}\t{text}")
    idle = [reasons[i] for i in range(len(reasons)) if i not in used and not sys.argv[2:]]
    for row in idle:
        print("reasons.tsv: a line that no difference needs:", *row[:3])
    print(f"{len(files)} files, {compared} comparisons, {different} differences, {bad} of them without a reason")
    return 1 if bad or idle else 0


sys.exit(main())
