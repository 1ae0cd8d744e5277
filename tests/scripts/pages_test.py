"""Every command on a page of the documentation works, in the order in which it stands there.

    SCANMILL=/path/to/scanmill python3 pages_test.py docs/vary.md

The commands run in an empty folder with what their reader has: models, recorded frames, another dataset. The program's own
pipelines are smaller there: fewer frames, towns and columns. Windows become pictures. A YAML block whose first line names
its file, `name: x   # x.yaml`, is written to that file.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("SCANMILL", ROOT / "build" / "release" / "scanmill")).resolve()

# What the commands of a reader begin with that other tests run, or that install something.
OTHERS = ("scripts/", "apt-get ", "pip ", "tar ", "python3 -m venv", "/usr/bin/python3 -m venv", "SCANMILL_BUILD=", "cmake ",
          "~/.venvs/", "for seed", "for drive", "export SCANMILL_ASSETS")
OURS = ("scanmill ", "seq ")

# Pipelines of the program, and what is smaller in them: text and what stands in its place.
SMALLER = {
    "quickstart": [("seeds: [1, 2, 3, 4, 5, 6]", "seeds: [1, 2, 3]"), ("train: [1, 2, 3, 4], val: [5], test: [6]",
                   "train: [1], val: [2], test: [3]"), ("frames: 5,", "frames: 2,"), ("frames: 8,", "frames: 5,"),
                   ("hdl_64e.yaml", "hdl_64e.yaml\n    columns: 256")],
    "training": [("seeds: [1, ..., 32]", "seeds: [1, ..., 4]"), ("frames: 6", "frames: 2"), ("shard_samples: 24", "shard_samples: 1"),
                 ("train: [1, ..., 24], val: [25, ..., 28], test: [29, ..., 32]", "train: [1, 2], val: [3], test: [4]"),
                 ("hdl_64e.yaml", "hdl_64e.yaml\n    columns: 256")],
    "street": [("frames: 20", "frames: 3"), ("paper_64.yaml", "paper_64.yaml\n    columns: 256"),
               ("method: ray_tracing", "method: ray_tracing\ntradeoff: {shots: 1, repeats: 1, settings: [ray_tracing, depth_camera, particle]}")],
}

# `scanmill` as the pages mean it.
SCANMILL = """#!/bin/bash
case $1 in
  view) [[ " $* " == *" --screenshot "* || " $* " == *" --pick "* ]] || set -- "$@" --screenshot window.png ;;
  tradeoff|repeatability) [[ $2 != *paper/* ]] || exec "$PROGRAM" plan "$2" ;;  # hours: scripts/reproduce runs these
esac
exec "$PROGRAM" "$@"
"""

STREET = """
name: frames
scenes: [{scene: street}]
trajectories: [{waypoints: [[-20, -1.75, 0], [20, -1.75, 0]], speed: 5.5, every_m: 6, frames: 3}]
sensors: [{name: top, preset: os1_128, mount: {position: [0, 0, 1.9]}}]
method: ray_tracing
effects: [intensity, range_noise: {sigma_m: 0.01}]
output: {columns: [intensity, ring, column, label, instance], formats: [pcd]}
"""

# A road and a house, as OBJ.
TOWN = """
o Road
v -40 -6 0
v 70 -6 0
v 70 50 0
v -40 50 0
f 1 2 3 4
o House
v 20 12 0
v 30 12 0
v 30 12 6
v 20 12 6
f 5 6 7 8
"""


def run(command, here, environment):
    done = subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=here, env=environment, capture_output=True, text=True,
                          stdin=subprocess.DEVNULL)
    assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"


def smaller_resources(folder):
    """The program's own files, with smaller pipelines."""
    (folder / "pipelines").mkdir(parents=True)
    for name in ("scenes", "labels"):
        (folder / name).symlink_to(ROOT / name)
    for entry in (ROOT / "pipelines").iterdir():
        (folder / "pipelines" / entry.name).symlink_to(entry)
    for name, changes in SMALLER.items():
        text = (ROOT / "pipelines" / f"{name}.yaml").read_text()
        for old, new in changes:
            assert old in text, f"{name}.yaml: {old}"
            text = text.replace(old, new)
        file = folder / "pipelines" / f"{name}.yaml"
        file.unlink()
        file.write_text(text)


def fixtures(here, text, do):
    """What a reader has, where the page names it."""
    if re.search("out/quickstart|SemanticKITTI/|nuscenes/|surveys/", text):
        do("scanmill generate quickstart -o quickstart -q")
    if "out/quickstart" in text and "-o out/quickstart\n" not in text:
        do("mkdir out && cp -r quickstart out/quickstart")
    if "SemanticKITTI/" in text:
        do("scanmill export quickstart --to semantic_kitti -o SemanticKITTI -q")
    if "nuscenes/" in text:
        do("scanmill export quickstart --to nuscenes -o nuscenes -q && mv nuscenes/v1.0-* nuscenes/v1.0-mini")
    if "models/" in text:
        (here / "models").mkdir()
        (here / "models" / "town.obj").write_text(TOWN)
    if "frames/" in text or "frame_" in text:
        (here / "frames.yaml").write_text(STREET)
        do("scanmill generate frames.yaml -o own_frames -q && mkdir frames && cat own_frames/train/*.tar |"
           " tar -xiC frames --wildcards '*.pcd' && rm -r frames.yaml own_frames")
        for number, frame in enumerate(sorted((here / "frames").iterdir()), 1795):
            (here / f"frame_{number}.pcd").symlink_to(frame)
    if "-passes studio" in text:
        do("scanmill render street -o studio --set method=depth_camera --set trajectories.0.frames=1 --set sensors.0.columns=2048 -q")
    if "my.yaml" in text:
        shutil.copy(ROOT / "pipelines" / "sensors" / "vlp_16.yaml", here / "my.yaml")
    if "surveys/" in text:
        do("scanmill export quickstart --to las -o surveys -q && mv $(find surveys -name '*.las' | head -n 1) surveys/town.las")


def jobs(text):
    """Commands, and (name, content) of files, in the order of the page."""
    found = []
    lines = iter(text.splitlines())
    for line in lines:
        if line.startswith("```"):
            block = []
            for line in lines:
                if line.startswith("```"):
                    break
                block.append(line)
            named = re.search(r"# (\S+\.yaml)$", block[0]) if block else None
            if named:
                found.append((named[1], "\n".join(block) + "\n"))
        elif line.startswith("    "):
            command = line.strip()
            while command.endswith("\\"):
                command = command[:-1] + next(lines).strip()
            if command.startswith(OURS):
                found.append(command)
    return found


def main():
    page = ROOT / sys.argv[1]
    text = page.read_text()
    for line in re.findall(r"^    .*\bscanmill .*", text, re.MULTILINE):
        assert line.strip().startswith(OURS + OTHERS) or not re.match(r"\s*\S*scanmill ", line), f"{page}: {line}"
    with tempfile.TemporaryDirectory() as folder:
        smaller_resources(Path(folder) / "resources")
        tools = Path(folder) / "bin"
        tools.mkdir()
        (tools / "scanmill").write_text(SCANMILL)
        (tools / "scanmill").chmod(0o755)
        here = Path(folder) / "here"
        here.mkdir()
        (here / "pipelines").symlink_to(Path(folder) / "resources" / "pipelines")
        (here / "tests").symlink_to(ROOT / "tests")
        environment = os.environ | {"PATH": f"{tools}:{os.environ['PATH']}", "PROGRAM": str(PROGRAM),
                                    "SCANMILL_RESOURCES": str(Path(folder) / "resources")}
        assets = ROOT.parent / "shared" / "data"
        environment.setdefault("SCANMILL_ASSETS", str(assets))
        for models in ("aws_warehouse", "husky"):
            (here / models).symlink_to(assets / "scenes" / models)
        environment |= {"GAZEBO_MODEL_PATH": "aws_warehouse/models", "ROS_PACKAGE_PATH": "husky"}
        found = jobs(text)
        commands = [job for job in found if isinstance(job, str)]
        fixtures(here, "\n".join(commands) + "\n", lambda command: run(command, here, environment))
        shutil.rmtree(here / "quickstart", ignore_errors=True)
        for job in found:
            if not isinstance(job, str):
                (here / job[0]).write_text(job[1])
                continue
            if re.search("kenney_city|recorded_place|warehouse|husky|out/robot|robot.yaml", job) and not (Path(environment["SCANMILL_ASSETS"]) / "scenes").is_dir():
                print(f"left out, its files are absent: {job}")
                continue
            run(job.replace("/shared/", "shared/"), here, environment)
    print(f"{len(commands)} commands")
    return 0


sys.exit(main())
