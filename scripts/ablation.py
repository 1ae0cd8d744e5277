#!/usr/bin/env python3
"""What does each effect buy? Trains the network of train_example.py on datasets that lack one thing each.

    scripts/ablation.py -o out/ablation --judge village=out/village

Makes a dataset of pipelines/training.yaml with everything, one without each of VARIANTS below, and one without any; trains
on each with several seeds; and judges all of them on the same sets: `held_out`, towns with everything that none has seen,
and each set that --judge names (see train_example.py), such as another sensor's or recorded scans. OUT gets ablation.json
and ablation.png; what was interrupted goes on where it was when called again.

Columns of the table: the mean IoU in percent on `own`, towns made as those that were learned, and on each set; what was
lost by leaving out, with its standard error, which follows from the seeds (a loss below two of these may be chance). Wants what train_example.py wants, and the program scanmill, built or installed.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

try:
    import matplotlib
    import numpy as np

    matplotlib.use("Agg")
    from matplotlib import pyplot
except ImportError as error:
    sys.exit(f"error: {error}: {sys.executable} lacks what this wants; docs/training.md makes an environment that has it, whose Python is "
             "~/.venvs/scanmill/bin/python")  # fmt: skip

from train_example import opened

ROOT = Path(__file__).resolve().parent.parent
BUILT = ROOT / "build/release/scanmill"
PROGRAM = os.environ.get("SCANMILL") or (str(BUILT) if BUILT.exists() else "scanmill")
BASE = "everything"
SCENE = ["relief", "reflectance_variation", "light_paths"]
# Intensities as of a plain simulator: the cosine of the incidence over the square of the range.
PLAIN = "intensity: {model: power, diffuse: lambertian, output: float, gain: 1, gamma: 1}"


def effects(*items: str) -> list[str]:
    return ["--set", f"effects=[{', '.join(items)}]"]


def few_towns(first: int) -> list[str]:
    """Four towns to learn, each of them driven through with six times as many frames."""
    learned = ", ".join(str(first + i) for i in range(4))
    splits = f"{{by: seed, train: [{learned}], val: [25], test: [27]}}"
    options = ["--set", f"scenes.0.seeds=[{learned}, 25, 27]", "--set", f"splits={splits}"]
    for trajectory, every_m in enumerate((2.3, 5)):
        options += ["--set", f"trajectories.{trajectory}.frames=36", "--set", f"trajectories.{trajectory}.every_m={every_m}"]
    return options


# What is left out, and the options of `scanmill generate` that leave it out.
VARIANTS = {
    BASE: [],
    "footprint": effects("sensor", "{footprint: none}", *SCENE),
    "glass": effects("sensor", *SCENE[:2]),
    "ring errors": effects("sensor", "{ring_bias: none}", *SCENE),
    "gains of rings": effects("sensor", "{ring_bias: {gain_sigma: 0}}", *SCENE),
    "ranges and elevations of rings": effects("sensor", "{ring_bias: {range_sigma_m: 0, elevation_sigma_deg: 0}}", *SCENE),
    "relief": effects("sensor", *SCENE[1:]),
    "variation of reflectance": effects("sensor", SCENE[0], SCENE[2]),
    "calibrated reflectivity": effects("sensor", f"{{{PLAIN}}}", *SCENE),
    # As many scans, of a sixth of the towns.
    "20 of the 24 towns": few_towns(1),
    "20 others of them": few_towns(5),
    "all effects": effects(f"{{{PLAIN}}}"),
}
# Two columns of beams a pixel of the range image are enough; towns of the splits of training.yaml.
COMMON = ["--set", "sensors.0.columns=1024", "--set", "scenes.0.seeds=[1, ..., 28]"]
SPLITS = ["--set", "splits={by: seed, train: [1, ..., 24], val: [25, 26], test: [27, 28]}"]
HELD_OUT = ["--set", "scenes.0.seeds=[29, ..., 32]", "--set", "splits=null"]


def generate(folder: Path, options: list[str]) -> None:
    """Makes a dataset where there is none."""
    if (folder / "manifest.json").exists():
        return
    resume = ["--resume"] if folder.exists() else []
    command = [PROGRAM, "generate", ROOT / "pipelines/training.yaml", "-o", folder]
    subprocess.run([*command, *resume, *options], check=True, stdout=subprocess.DEVNULL)


def trained(folder: Path, dataset: Path, seed: int, options: argparse.Namespace, judge: list[str]) -> dict:
    """Trains where it has not been done, and gives the figures of train_example.py."""
    figures = folder / "figures.json"
    if not figures.exists():
        for left in folder.glob("*"):
            left.unlink()
        command = [sys.executable, ROOT / "scripts/train_example.py", dataset, "-o", folder, "--seed", str(seed)]
        command += ["--steps", str(options.steps), "--rings", "32", "--threads", "1"]
        command += [word for set_ in judge for word in ("--judge", set_)]
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if run.returncode:
            raise RuntimeError(run.stdout)
    return json.loads(figures.read_text())


def judged(runs: dict) -> dict:
    """Of the runs {variant: [figures of each seed]}: per set {variant: {"mean", "lost", "error", "seeds", "iou"}} in percent.
    The error is that of a difference of two means, from the scatter of the seeds within all variants together."""
    found: dict = {}
    for name in next(iter(runs.values()))[0]["sets"]:
        miou = {v: np.array([100 * r["sets"][name]["miou"] for r in seeds]) for v, seeds in runs.items()}
        freedom = sum(len(m) - 1 for m in miou.values())
        scatter = np.sqrt(sum(((m - m.mean()) ** 2).sum() for m in miou.values()) / freedom) if freedom else None
        error = scatter and scatter * np.sqrt(2 / len(miou[BASE]))
        found["own" if name == "test" else name] = {
            variant: {
                "mean": values.mean(),
                "lost": miou[BASE].mean() - values.mean(),
                "error": error,
                "seeds": values.tolist(),
                "iou": {c: 100 * float(np.mean([r["sets"][name]["iou"][c] for r in runs[variant]])) for c in runs[variant][0]["sets"][name]["iou"]},
            }
            for variant, values in miou.items()
        }
    return found


def table(sets: dict) -> str:
    rows = [["without", *(cell for name in sets for cell in (name, "lost"))]]
    for variant in sets["own"]:
        row = ["(nothing left out)" if variant == BASE else variant]
        for name in sets:
            of = sets[name][variant]
            error = f" ± {of['error']:.1f}" if of["error"] else ""
            row += [f"{of['mean']:.1f}", "" if variant == BASE else f"{of['lost']:+.1f}{error}"]
        rows.append(row)
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join("  ".join(c.ljust(w) if i == 0 else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths))) for row in rows)


def draw(sets: dict, path: Path) -> None:
    """What each set loses by what was left out of the training: a bar a variant with two standard errors."""
    shown = [name for name in sets if name != "own"]
    figure, axes = pyplot.subplots(1, len(shown), figsize=(1.8 + 4 * len(shown), 4), squeeze=False, sharey=True)
    for axis, name in zip(axes[0], shown):
        left_out = [v for v in sets[name] if v != BASE]
        lost = [sets[name][v]["lost"] for v in left_out]
        errors = [2 * (sets[name][v]["error"] or 0) for v in left_out]
        axis.barh(left_out, lost, xerr=errors, color="#4c78a8", ecolor="#555555", capsize=3)
        for row, v in enumerate(left_out):
            seeds = sets[name][BASE]["mean"] - np.array(sets[name][v]["seeds"])
            axis.plot(seeds, np.full(len(seeds), row), "o", color="black", markersize=3)
        axis.axvline(0, color="black", linewidth=0.8)
        axis.grid(axis="x", alpha=0.3)
        axis.set_axisbelow(True)
        axis.set_xlabel("mean IoU lost, percentage points")
        axis.set_title(f"{name} ({sets[name][BASE]['mean']:.1f} % with everything)", fontsize=10)
    axes[0, 0].invert_yaxis()
    axes[0, 0].set_ylabel("trained without")
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    pyplot.close(figure)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for datasets, runs, table and picture")
    parser.add_argument("--judge", action="append", default=[], metavar="NAME=FOLDER", help="another set to be judged on; can be repeated")
    parser.add_argument("--seeds", type=int, default=3, help="networks of each kind (3)")
    parser.add_argument("--steps", type=int, default=400, help="of two scans each (400)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of the pipeline, such as another sensor; can be repeated")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=list(VARIANTS)[1:], default=list(VARIANTS)[1:], help="what to leave out, each on its own: '" + "', '".join(list(VARIANTS)[1:]) + "' (all)")
    options = parser.parse_args()
    if options.seeds < 1:
        parser.error("--seeds is 1 or more")
    return options


def main() -> None:
    options = arguments()
    foreign = [f.name for f in options.out.glob("*") if f.name not in ("sets", "runs", "ablation.json", "ablation.png")]
    if foreign:
        sys.exit(f"error: {options.out} holds {foreign[0]}, which no ablation made: name another folder with -o")
    for text in options.judge:
        opened(text)  # says what is wrong before anything is made
    names = [BASE, *options.only]
    folders = {name: options.out / "sets" / name.replace(" ", "_") for name in names}
    own = [word for assignment in options.set for word in ("--set", assignment)]
    for name, folder in folders.items():
        print(f"scans: {name}", flush=True)
        generate(folder, [*COMMON, *SPLITS, *own, *VARIANTS[name]])
    held_out = options.out / "sets/held_out"
    generate(held_out, [*COMMON, *own, *HELD_OUT])
    judge = [f"held_out={held_out}", *options.judge]

    jobs = [(seed, name) for seed in range(options.seeds) for name in names]
    runs: dict = {name: [] for name in names}
    start = time.monotonic()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        # A network a core is faster than one network of all cores.
        waiting = [pool.submit(trained, options.out / "runs" / f"{folders[n].name}-{s}", folders[n], s, options, judge) for s, n in jobs]
        for done, ((seed, name), run) in enumerate(zip(jobs, waiting), 1):
            try:
                runs[name].append(run.result())
            except RuntimeError as error:
                pool.shutdown(cancel_futures=True)
                sys.exit(f"error: training without {name} failed:\n{error}")
            left = (time.monotonic() - start) / done * (len(jobs) - done) / 60
            print(f"network {done} of {len(jobs)}, about {left:.0f} min left: {name}, seed {seed}", flush=True)

    sets = judged(runs)
    report = {"steps": options.steps, "seeds": options.seeds, "sets": sets}
    (options.out / "ablation.json").write_text(json.dumps(report, indent=1) + "\n")
    draw(sets, options.out / "ablation.png")
    print(table(sets))
    if options.seeds == 1:
        print("one network of each kind: no error is known, and differences of a few points may be chance")


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(error.returncode)
