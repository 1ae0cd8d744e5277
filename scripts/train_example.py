#!/usr/bin/env python3
"""Trains a small network that labels LiDAR scans, and tells how well it does where it was not trained.

    scripts/train_example.py out/training -o out/trained --judge village=out/village --judge real=/data/SemanticKITTI/sequences/08

It learns on the split `train` of a dataset, keeps the weights that are best on `val`, and is judged on `test` and on each
set that --judge names: a dataset of Scanmill's, or a folder of scans that somebody recorded, in SemanticKITTI's layout
(velodyne/*.bin beside labels/*.label), or a folder of such sets (docs/vary.md, Corruption sets). OUT gets
figures.json (intersection over union by class and the confusion of classes, of each set), a picture of scans with truth
and answer, one of the confusion, and the weights.

    scripts/train_example.py out/training -o out/judged --weights out/trained/weights.pt --judge rain=out/rain

learns nothing, and judges by the weights that are there: on the sets of --judge, or on `test` where there are none.

    scripts/train_example.py /data/five_drives -o out/real --judge sixth=/data/sixth_drive

learns on recorded scans, to tell what simulated ones are worth: every tenth scan is the `val`, and there is no `test`.

    scripts/train_example.py out/training /data/mine:4 -o out/both --judge other=/data/other_drive

learns on several sets together. An epoch has each scan of /data/mine four times, each time augmented differently, and its
`val` counts four times.

The network is a U-Net over range images (as in RangeNet++, Milioto et al., IROS 2019), small enough for two cores. All
scans are projected by their angles, those of other programs and other sensors too. Wants Debian's python3-torch and
python3-matplotlib, and the package scanmill (docs/python.md).
"""

import argparse
import json
import os
import pickle
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path

try:
    import matplotlib
    import numpy as np
    import scanmill
    import torch
    from scanmill import ConfusionMatrix
    from scanmill.augment import Compose, DropPoints, Flip, Scale, Turn
    from scanmill.torch import ScanDataset
    from torch import nn
    from torch.nn import functional
    from torch.utils.data import DataLoader

    matplotlib.use("Agg")
    from matplotlib import pyplot
except ImportError as error:
    sys.exit(f"error: {error}: {sys.executable} lacks what this wants; docs/training.md makes an environment that has it, whose Python is "
             "~/.venvs/scanmill/bin/python")  # fmt: skip

# What is learned: names of classes in Scanmill's ontology and in SemanticKITTI's.
MOVING = ["moving-car", "moving-on-rails", "moving-bus", "moving-truck", "moving-other-vehicle"]
RIDING = ["bicyclist", "moving-bicyclist", "moving-motorcyclist", "person", "moving-person"]
CLASSES = {
    "road": ["road", "road_marking", "lane-marking", "parking", "ground", "other-ground"],
    "sidewalk": ["sidewalk", "curb", "driveway"],
    "terrain": ["terrain"],
    "building": ["building", "window", "structure", "other-structure"],
    "fence": ["fence", "wall"],
    "vegetation": ["vegetation", "tree", "trunk"],
    "pole": ["pole", "traffic_sign", "traffic-sign", "traffic_light", "street_lamp"],
    "vehicle": ["car", "truck", "bus", "on-rails", "other_vehicle", "other-vehicle", *MOVING],
    "person": ["pedestrian", "rider", "motorcyclist", "bicycle", "motorcycle", *RIDING],
}
NAMES = list(CLASSES)
PICTURED = 12  # sets
IMAGE = {"rings": 64, "columns": 512, "elevation": (-25.0, 3.0)}  # how scans are shown to the network
COLORS = np.array(
    [[128, 64, 128], [244, 35, 232], [152, 220, 110], [235, 180, 60], [215, 110, 60], [0, 130, 30], [250, 230, 0],
     [40, 90, 255], [230, 20, 60]],
    np.uint8,
)  # fmt: skip
IGNORE = 255


def open_set(path: Path) -> scanmill.Dataset:
    """A dataset of Scanmill's, or the labelled sequences of a recorded set."""
    dataset = scanmill.open(path)
    if dataset.manifest is None:
        sequences = dataset.sequences.values()
        dataset = dataset.select([k for keys in sequences if "label" in dataset[keys[0]].scan().names for k in keys])
        if not len(dataset):
            sys.exit(f"error: {path} has no manifest.json, and no velodyne/*.bin with labels/*.label beside it")
    return dataset


def part_of(dataset: scanmill.Dataset, part: str) -> scanmill.Dataset:
    """The split "train" or "val". Recorded scans: nine of ten, and each tenth, whatever their sequence."""
    if dataset.manifest is not None:
        return dataset.split(part)
    return dataset.select([i for i in range(len(dataset)) if (i % 10 == 9) == (part == "val")])


def scans_of(dataset: scanmill.Dataset, augment: Sequence = (), seed: int = 0) -> ScanDataset:
    """The scans of a dataset, with the classes that are learned."""
    groups = [[name for name in names if name in dataset.ontology.names] for names in CLASSES.values()]
    if not all(groups):
        sys.exit(f"error: {dataset.path}: its ontology {dataset.ontology.name} lacks classes: name them in CLASSES")
    table = dataset.ontology.train_ids(groups, IGNORE)
    return ScanDataset(dataset, columns=["intensity"], train_ids=table, transform=Compose(augment, seed))


class Images:
    """Collates scans to range images: float32 (B, 5, rings, columns) of range, x, y, z and intensity, each about 1, and
    the classes int64 (B, rings, columns). Keeps the projection of each scan, which leads back from pixels to points."""

    def __init__(self, rings: int, columns: int, elevation_deg: tuple[float, float]) -> None:
        self.shape = rings, columns
        self.elevation = np.radians(elevation_deg)

    def __call__(self, samples: list[dict]) -> dict:
        images, targets, projections = [], [], []
        for sample in samples:
            projection = scanmill.spherical_projection(sample, *self.shape, tuple(self.elevation))
            xyz = sample["xyz"].astype(np.float32)
            distance = np.linalg.norm(xyz, axis=1)
            # Sensors have other units and other responses: the intensity is the share of the scan's points that are darker.
            strength = np.searchsorted(np.sort(sample["intensity"]), sample["intensity"]) / max(len(distance), 1)
            points = np.column_stack([np.log1p(distance) / 3, xyz / [20, 20, 2], strength]).astype(np.float32)
            images.append(filled(projection.image(points).transpose(2, 0, 1).copy()))
            targets.append(projection.image(sample["target"], IGNORE))
            projections.append(projection)
        return {
            "image": torch.from_numpy(np.stack(images)),
            "target": torch.from_numpy(np.stack(targets)),
            "projections": projections,
            "samples": samples,
        }


def filled(image: np.ndarray) -> np.ndarray:
    """An image (k, rings, columns), in which rows between the sensor's rings are empty, with the row below or above in
    such pixels: other sensors have other rings, and the network shall not learn those of one by heart."""
    for step in (1, -1):
        near = np.roll(image, step, axis=1)
        near[:, 0 if step == 1 else -1] = 0
        take = (image[0] == 0) & (near[0] > 0)
        image[:, take] = near[:, take]
    return image


def convolution(inputs: int, outputs: int) -> nn.Sequential:
    """3 x 3 pixels, which go on behind the left and the right edge: the image is a full turn."""
    return nn.Sequential(
        Turned(),
        nn.Conv2d(inputs, outputs, 3, padding=(1, 0), bias=False),
        nn.BatchNorm2d(outputs),
    )


class Turned(nn.Module):
    """The last column again before the first, and the first behind the last."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return functional.pad(image, (1, 1, 0, 0), mode="circular")


class Residual(nn.Module):
    def __init__(self, width: int) -> None:
        super().__init__()
        self.first, self.second = convolution(width, width), convolution(width, width)

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return functional.relu(image + self.second(functional.relu(self.first(image))))


class Network(nn.Module):
    """A U-Net of four levels: half the columns from each to the next, and half the rings from the second on. What comes
    up is added to what went down."""

    WIDTHS = [16, 32, 48, 64]
    HALVES = [(1, 2), (2, 2), (2, 2)]

    def __init__(self) -> None:
        super().__init__()
        self.stem = convolution(6, self.WIDTHS[0])
        pairs = list(zip(self.WIDTHS, self.WIDTHS[1:]))
        self.widen = nn.ModuleList([convolution(i, o) for i, o in pairs])
        self.down = nn.ModuleList([Residual(o) for _, o in pairs])
        self.narrow = nn.ModuleList([nn.Conv2d(o, i, 1) for i, o in pairs])
        self.up = nn.ModuleList([Residual(i) for i, _ in pairs])
        self.classify = nn.Conv2d(self.WIDTHS[0], len(CLASSES), 1)

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        seen = (image[:, :1] > 0).float()
        image = functional.relu(self.stem(torch.cat([image, seen], 1)))
        levels = []
        for widen, down, halves in zip(self.widen, self.down, self.HALVES):
            levels.append(image)
            image = down(functional.relu(widen(functional.max_pool2d(image, halves))))
        for narrow, up, halves in zip(self.narrow[::-1], self.up[::-1], self.HALVES[::-1]):
            image = up(levels.pop() + functional.interpolate(narrow(image), scale_factor=halves))
        return self.classify(image)


def shift_height(sample: dict, rng: np.random.Generator) -> dict:
    """Another vehicle: the sensor is up to 0.3 m higher or lower."""
    return {**sample, "xyz": sample["xyz"] + np.float32([0, 0, rng.uniform(-0.3, 0.3)])}


def confusion_of(network: nn.Module, scans: ScanDataset, images: Images) -> ConfusionMatrix:
    """Which class points were taken for, over all points of all scans. Points that no pixel shows, behind others or
    outside of the window, have their pixel's answer or count as wrong for nobody."""
    confusion = ConfusionMatrix(NAMES, IGNORE)
    network.eval()
    with torch.no_grad():
        for batch in DataLoader(scans, collate_fn=images):
            answer = network(batch["image"]).argmax(1).numpy()
            for pixels, projection, sample in zip(answer, batch["projections"], batch["samples"]):
                confusion.add(sample["target"], projection.points(pixels, IGNORE))
    return confusion


def figures_of(confusion: ConfusionMatrix) -> dict:
    """Intersection over union of each class that the set has, their mean, and the share of points that are right."""
    present = confusion.matrix.sum(1) > 0
    return {
        "miou": confusion.miou if present.any() else 0.0,
        "accuracy": confusion.accuracy if present.any() else 0.0,
        "iou": {name: iou for name, iou, shown in zip(NAMES, confusion.iou().tolist(), present) if shown},
        "confusion": confusion.matrix.tolist(),
    }


def train(network: Network, training: ScanDataset, held_out: list, images: Images, options: argparse.Namespace) -> dict:
    """Trains for a number of steps of two scans each, and leaves the weights in the network that are best on the sets of
    held_out, pairs of a set and how often it counts."""
    weights = np.sqrt(1 / np.maximum(class_shares(training), 1e-4))
    loss_of = nn.CrossEntropyLoss(torch.from_numpy(weights / weights.mean()).float(), ignore_index=IGNORE)
    adam = torch.optim.AdamW(network.parameters(), weight_decay=1e-3)
    # Rises over the first tenth of the steps and falls to nothing, as a cosine.
    rate = torch.optim.lr_scheduler.OneCycleLR(adam, 4e-3, options.steps, pct_start=0.1)
    order = torch.Generator().manual_seed(options.seed)
    loader = DataLoader(training, batch_size=2, shuffle=True, drop_last=True, collate_fn=images, generator=order)
    looks = {max(1, round(options.steps * share)) for share in (0.25, 0.5, 0.7, 0.85, 1)}
    start, step, epoch, best, losses = time.monotonic(), 0, 0, -1.0, []
    while step < options.steps:
        training.set_epoch(epoch)
        for batch in loader:
            network.train()
            adam.zero_grad()
            loss = loss_of(network(batch["image"]), batch["target"])
            loss.backward()
            adam.step()
            rate.step()
            losses.append(loss.item())
            step += 1
            minutes = (time.monotonic() - start) / 60
            if step not in looks and step % max(1, options.steps // 24) == 0:
                print(f"step {step}: loss {np.mean(losses[-50:]):.3f}, {minutes * (options.steps / step - 1):.1f} min left", flush=True)
            if step in looks:
                confusion = ConfusionMatrix(NAMES, IGNORE)
                for scans, times in held_out:
                    confusion.matrix += times * confusion_of(network, scans, images).matrix
                now = figures_of(confusion)["miou"]
                if now > best:
                    best, kept = now, {name: value.clone() for name, value in network.state_dict().items()}
                left = minutes * (options.steps / step - 1)
                loss_now = np.mean(losses[-50:])
                print(f"step {step}, epoch {epoch}: loss {loss_now:.3f}, mean IoU of val {now:.1%}, {left:.1f} min left", flush=True)
            if step == options.steps:
                break
        epoch += 1
    network.load_state_dict(kept)
    return {"scans": len(training.dataset), "epochs": epoch, "minutes": round((time.monotonic() - start) / 60, 1)}


def class_shares(scans: ScanDataset) -> np.ndarray:
    """The share of points of each class, of up to 40 scans."""
    chosen = np.linspace(0, len(scans) - 1, min(len(scans), 40)).astype(int)
    counts = np.zeros(len(CLASSES))
    for index in chosen:
        target = scans[index]["target"]
        counts += np.bincount(target[target != IGNORE], minlength=len(CLASSES))
    return counts / max(counts.sum(), 1)


def draw_scans(network: nn.Module, sets: dict, images: Images, path: Path) -> None:
    """The middle scan of each set: its range, the truth, the answer."""
    figure, axes = pyplot.subplots(3 * len(sets), 1, figsize=(14, 2.2 * len(sets) * 1.5), squeeze=False)
    palette = np.vstack([COLORS, np.zeros((IGNORE + 1 - len(COLORS), 3), np.uint8)])
    network.eval()
    for number, (name, scans) in enumerate(sets.items()):
        batch = images([scans[len(scans) // 2]])
        with torch.no_grad():
            answer = network(batch["image"])[0].argmax(0).numpy()
        depth = batch["image"][0, 0].numpy()
        answer[depth == 0] = IGNORE
        rows = [("range", depth), ("truth", palette[batch["target"][0].numpy()]), ("prediction", palette[answer])]
        for axis, (title, picture) in zip(axes[3 * number : 3 * number + 3, 0], rows):
            axis.imshow(picture, cmap="viridis", aspect="auto", interpolation="nearest")
            axis.set_title(f"{name}: {title}", loc="left", fontsize=9)
            axis.set_axis_off()
    handles = [pyplot.Rectangle((0, 0), 1, 1, color=color / 255) for color in [*COLORS, np.zeros(3)]]
    figure.legend(handles, [*NAMES, "not evaluated"], loc="lower center", ncol=len(handles), fontsize=9, frameon=False)
    figure.tight_layout(rect=(0, 0.04, 1, 1))
    figure.savefig(path, dpi=90)
    pyplot.close(figure)


def draw_confusion(results: dict, path: Path) -> None:
    """For each set, which share of the points of a class (row) was taken for which (column)."""
    columns = min(len(results), 3)
    rows = -(-len(results) // columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(5.2 * columns, 4.8 * rows), squeeze=False)
    for axis in axes.flat[len(results) :]:
        axis.set_axis_off()
    for axis, (name, result) in zip(axes.flat, results.items()):
        counts = np.array(result["confusion"], float)
        shares = counts / np.maximum(counts.sum(1, keepdims=True), 1)
        axis.imshow(shares, cmap="Blues", vmin=0, vmax=1)
        for row, column in np.argwhere(shares >= 0.01):
            axis.text(column, row, f"{shares[row, column]:.0%}", ha="center", va="center", fontsize=7,
                      color="white" if shares[row, column] > 0.5 else "black")  # fmt: skip
        axis.set_xticks(range(len(NAMES)), NAMES, rotation=60, ha="right", fontsize=8)
        axis.set_yticks(range(len(NAMES)), NAMES, fontsize=8)
        axis.set_title(f"{name}: mean IoU {result['miou']:.1%}", fontsize=10)
        axis.set_xlabel("taken for")
    for axis in axes[:, 0]:
        axis.set_ylabel("is")
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    pyplot.close(figure)


def table(results: dict) -> str:
    """Mean and classes' IoU in percent, a line a set; a dash where a set has no such class."""
    rows = [["", "mean", *NAMES]]
    for name, result in results.items():
        ious = [result["iou"].get(n) for n in NAMES]
        rows.append([name, *("-" if v is None else f"{100 * v:.1f}" for v in [result["miou"], *ious])])
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join(
        "  ".join(cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths))) for row in rows
    )


def resilience(results: dict, name: str) -> dict:
    """Of a folder of corruption sets: for each corruption, the mean over its severities of the mean IoU, as
    a part of that without corruption (the resilience rate of Robo3D, Kong et al., ICCV 2023), and the mean of these."""
    prefix = f"{name}/corruption="
    clean = results.get(prefix + "null", {}).get("miou")
    if not clean:
        return {}
    kinds: dict = {}
    for key, result in results.items():
        if key.startswith(prefix) and key != prefix + "null":
            kinds.setdefault(key[len(prefix) :].rpartition("-")[0], []).append(result["miou"] / clean)
    rates = {kind: float(np.mean(values)) for kind, values in kinds.items()}
    return {**rates, "mean": float(np.mean(list(rates.values())))} if rates else {}


def severity(name: str) -> tuple:
    """What sets of corruptions are ordered by: that without any first, then by name, and from light to heavy."""
    kind, separator, degree = name.rpartition("-")
    known = ["light", "moderate", "heavy"]
    return (not name.endswith("=null"), *((kind, known.index(degree)) if separator and degree in known else (name, 0)))


def pictured(names: list[str]) -> list[str]:
    """At most PICTURED sets; of each corruption the heaviest."""
    chosen = [n for n in names if not n.endswith(("-light", "-moderate"))]
    return chosen[:PICTURED]


def source(text: str) -> tuple[Path, int, scanmill.Dataset]:
    """What FOLDER or FOLDER:TIMES names: the folder, how often an epoch has each of its scans, and the set."""
    folder, times = Path(text), 1
    found = re.fullmatch(r"(.+):(\d+)", text)
    if found and not folder.exists():
        folder, times = Path(found[1]), int(found[2])
    if times < 1:
        sys.exit(f"error: {text}: an epoch has each scan once or more often")
    return folder, times, open_set(folder)


def opened(text: str) -> dict[str, ScanDataset]:
    """The set that an option --judge names, or all of those in the folder that it names, as NAME/FOLDER."""
    name, separator, path = text.partition("=")
    if not separator:
        sys.exit(f"error: --judge wants NAME=FOLDER, not '{text}'")
    if not Path(path).exists():
        sys.exit(f"error: --judge {name}: no folder {path}")
    folders = sorted((m.parent for m in Path(path).glob("*/manifest.json")), key=lambda folder: severity(folder.name))
    within = {f"{name}/{folder.name}": scans_of(open_set(folder)) for folder in folders}
    return within or {name: scans_of(open_set(Path(path)))}


def read_weights(path: Path) -> dict:
    """A file weights.pt: "network", the weights by name, and "image", the values of IMAGE that they learned by, as JSON."""
    if not path.exists():
        sys.exit(f"error: --weights {path}: there is no such file")
    try:
        learned = torch.load(path, weights_only=True)  # runs no code that somebody put into the file
        Network().load_state_dict(learned["network"])
        return {"network": learned["network"], "image": json.loads(learned["image"])}
    except (OSError, RuntimeError, KeyError, TypeError, ValueError, EOFError, pickle.UnpicklingError):
        sys.exit(f"error: --weights {path}: is not the weights.pt of a run of this script")


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("folders", nargs="+", metavar="FOLDER[:TIMES]", help="a dataset of Scanmill's with the splits train, val and test, or "
                        "recorded scans; TIMES: how often an epoch has each of its scans (1)")  # fmt: skip
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for figures, pictures and weights")
    parser.add_argument("--judge", action="append", default=[], metavar="NAME=FOLDER", help="another set to be judged on; can be repeated")
    parser.add_argument("--weights", type=Path, metavar="FILE", help="judge by the weights.pt of an earlier run, and learn nothing")
    parser.add_argument("--steps", type=int, default=600, help="of two scans each (600)")
    parser.add_argument("--rings", type=int, help="rows of the range image (64, or as the weights learned)")
    parser.add_argument("--columns", type=int, help="its columns (512, or as the weights learned)")
    parser.add_argument("--elevation", type=float, nargs=2, metavar=("LOW", "HIGH"), help="its window, degrees (-25 3, or as the weights learned)")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="that the network uses (all)")
    parser.add_argument("--seed", type=int, default=0, help="of weights, order and augmentation (0)")
    options = parser.parse_args()
    options.learned = read_weights(options.weights) if options.weights else {"image": IMAGE}
    for name, value in options.learned["image"].items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    if options.rings % 4 or options.columns % 8 or min(options.rings, options.columns, options.steps) < 1:
        parser.error("--rings is a multiple of 4, --columns one of 8, and --steps 1 or more: the network halves the image")
    if options.elevation[0] >= options.elevation[1]:
        parser.error("--elevation is LOW HIGH, such as -25 3")
    return options


def main() -> None:
    options = arguments()
    torch.manual_seed(options.seed)
    torch.set_num_threads(options.threads)
    augment = [Flip("y"), Turn(), Scale(0.95, 1.05), shift_height, DropPoints(0.2)]
    sources = [source(text) for text in options.folders]
    simulated = [(folder, dataset) for folder, _, dataset in sources if dataset.manifest is not None]
    if not simulated and not options.judge:
        sys.exit(f"error: {options.folders[0]} has recorded scans, which have no test set: name others with --judge")
    sets, training = {}, None
    if not options.weights:
        weights = [times for _, times, _ in sources]
        parts = [part_of(dataset, "train") for _, _, dataset in sources]
        training = scans_of(parts[0] if weights == [1] else scanmill.open(parts, weights), augment, options.seed)
        if len(training) < 2:
            sys.exit(f"error: {options.folders[0]} has {len(training)} scan to learn from; a step takes two")
        held_out = [(scans_of(part_of(dataset, "val")), times) for _, times, dataset in sources]
        if not any(len(scans) for scans, _ in held_out):
            sys.exit(f"error: {options.folders[0]} has {len(training)} scans; ten scans at least are needed, every tenth is val")
    if training is not None or not options.judge:
        sets = {"test" if len(simulated) == 1 else f"test of {folder}": scans_of(d.split("test")) for folder, d in simulated}
    for text in options.judge:
        sets.update(opened(text))
    images = Images(options.rings, options.columns, tuple(options.elevation))
    options.out.mkdir(parents=True, exist_ok=True)
    if any(options.out.iterdir()):
        sys.exit(f"error: {options.out} is not empty: name another folder with -o")

    network = Network()
    trained = {}
    if training is None:
        network.load_state_dict(options.learned["network"])
    else:
        size = sum(p.numel() for p in network.parameters())
        learned = ", ".join(f"{times} x {len(part)} scans of {folder}" for part, (folder, times, _) in zip(parts, sources))
        print(f"{size} weights, to learn {learned}; {torch.get_num_threads()} threads", flush=True)
        trained = train(network, training, held_out, images, options)
        image = {name: getattr(options, name) for name in IMAGE}
        torch.save({"network": network.state_dict(), "image": json.dumps(image)}, options.out / "weights.pt")

    results = {}
    for number, (name, scans) in enumerate(sets.items(), 1):
        print(f"judging set {number} of {len(sets)}, {name}: {len(scans)} scans", flush=True)
        results[name] = figures_of(confusion_of(network, scans, images))
    judged = [text.partition("=")[0] for text in options.judge]
    rates = {name: found for name in judged if (found := resilience(results, name))}
    settings = {k: str(v) if isinstance(v, Path) else v for k, v in vars(options).items() if k != "learned"}
    (options.out / "figures.json").write_text(
        json.dumps({"settings": settings, "training": trained, "classes": NAMES, "sets": results, "resilience": rates}, indent=1) + "\n"
    )
    shown = pictured(list(sets))
    if len(shown) < len(sets):
        print(f"the pictures show {len(shown)} of {len(sets)} sets: {', '.join(shown)}")
    draw_scans(network, {name: sets[name] for name in shown}, images, options.out / "scans.png")
    draw_confusion({name: results[name] for name in shown}, options.out / "confusion.png")
    print("intersection over union, in percent")
    print(table(results))
    for name, kinds in rates.items():
        print(f"{name}: what is left of the mean IoU, in percent")
        for kind, rate in kinds.items():
            print(f"  {kind:16} {100 * rate:5.1f}")


if __name__ == "__main__":
    try:
        main()
    except scanmill.InputError as error:
        sys.exit(f"error: {error}")
