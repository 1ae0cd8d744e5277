"""Statistics of labelled street scans, drive by drive: shares of classes, intensities, distances, and what stands on what.

    PYTHONPATH=build/developer/python:tests/python /usr/bin/python3 tests/python/street_statistics.py out/quickstart

prints the median over the drives, the least and the greatest value of each. Classes are those of labels/scanmill.yaml, joined to
the coarser ones that recorded datasets have. Coordinates are those of the sensor, 1.73 m above the road.
"""

import sys

import numpy as np

import scanmill

COARSE = {
    "road": "road", "road_marking": "road", "sidewalk": "sidewalk", "curb": "sidewalk", "driveway": "sidewalk",
    "terrain": "terrain", "building": "building", "window": "building", "wall": "fence", "fence": "fence",
    "vegetation": "vegetation", "tree": "vegetation", "trunk": "trunk", "pole": "pole", "street_lamp": "pole",
    "traffic_sign": "sign", "car": "vehicle", "truck": "vehicle", "bus": "vehicle", "other_vehicle": "vehicle",
    "pedestrian": "person", "rider": "person", "motorcyclist": "person", "parking": "parking", "ground": "other", "water": "other",
}
GROUND = ["road", "sidewalk", "terrain", "parking", "other"]


def spread(values):
    """Half of the span from the 16th to the 84th percentile."""
    low, high = np.percentile(values, [16, 84])
    return (high - low) / 2


def feet_on(points, classes, of):
    """How many cells of 0.5 m with points of a class just above the ground have most of each kind of ground around them."""
    cell, half = 0.5, 70
    near = np.hypot(points[:, 0], points[:, 1]) < 30
    index = np.clip((points[:, :2] / cell).astype(int) + half, 1, 2 * half - 2)
    counts = np.zeros((len(GROUND), 2 * half, 2 * half))
    low = np.full((2 * half, 2 * half), np.inf)
    for k, ground in enumerate(GROUND):
        m = near & (classes == ground)
        np.add.at(counts[k], (index[m, 0], index[m, 1]), 1)
        np.minimum.at(low, (index[m, 0], index[m, 1]), points[m, 2])
    around = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    counts = sum(np.roll(counts, shift, axis=(1, 2)) for shift in around)
    low = np.min([np.roll(low, shift, axis=(0, 1)) for shift in around], axis=0)
    m = near & (classes == of) & (points[:, 2] < low[index[:, 0], index[:, 1]] + 0.3)
    cells = np.unique(index[m], axis=0)
    found = counts[:, cells[:, 0], cells[:, 1]]
    found = found[:, found.sum(axis=0) > 0]
    return np.bincount(found.argmax(axis=0), minlength=len(GROUND)) if found.size else np.zeros(len(GROUND))


def of_drive(samples):
    """The statistics of the scans of a drive, as a dictionary of numbers."""
    parts, feet, frames = [], {}, len(samples)
    ontology = samples[0].dataset.ontology
    coarse = np.full(int(max(ontology.ids)) + 1, "", dtype="U16")
    for name in ontology.names:
        coarse[ontology.id_of(name)] = COARSE.get(name, "")
    for number, sample in enumerate(samples):
        scan = sample.scan()
        points = scan.xyz.astype(float)
        keep = np.linalg.norm(points, axis=1) > 3.2
        classes = coarse[scan.label[keep]]
        points = points[keep]
        for of in ("building", "fence", "vegetation", "vehicle"):
            feet[of] = feet.get(of, 0) + feet_on(points, classes, of)
        scale = 255 if scan.intensity.max(initial=0) > 1 else 1  # bytes or parts of the full scale
        parts.append((points, scan.intensity[keep] / scale, classes, scan.instance[keep], scan.ring[keep], number))
    points = np.concatenate([p[0] for p in parts])
    intensity = np.concatenate([p[1] for p in parts])
    classes = np.concatenate([p[2] for p in parts])
    frame = np.concatenate([np.full(len(p[0]), p[5]) for p in parts])
    instance = np.concatenate([p[3] for p in parts]).astype(np.int64)
    ring = np.concatenate([p[4] for p in parts]).astype(int)
    distance = np.linalg.norm(points, axis=1)
    level = np.hypot(points[:, 0], points[:, 1])
    height = points[:, 2]
    of = {name: classes == name for name in set(COARSE.values())}
    out = {f"share of {n}": of[n].mean() for n in
           ("road", "sidewalk", "terrain", "building", "fence", "vegetation", "trunk", "pole", "vehicle")}
    for name in ("road", "sidewalk", "terrain", "building", "fence", "vegetation", "trunk", "pole", "vehicle"):
        if of[name].sum() < 50:
            continue
        values = intensity[of[name]]
        out[f"intensity of {name}"] = np.median(values)
        out[f"spread of {name}"] = spread(values)
        out[f"zeros of {name}"] = (values == 0).mean()
    for low, high in ((4, 8), (8, 12), (12, 20), (20, 35)):
        m = of["road"] & (distance > low) & (distance < high)
        if m.any():
            out[f"intensity of road at {low}-{high} m"] = np.median(intensity[m])
    m = of["road"] & (distance > 30) & (distance < 60)
    if m.any():
        out["zeros of road at 30-60 m"] = (intensity[m] == 0).mean()
    for name in ("sidewalk", "terrain"):
        if f"intensity of {name}" in out and "intensity of road" in out:
            out[f"{name} less road"] = out[f"intensity of {name}"] - out["intensity of road"]
    m = of["vehicle"] & (instance > 0)
    counts = np.unique(frame[m] << 32 | instance[m], return_counts=True)[1]
    out["vehicles of more than 20 points"] = (counts > 20).sum() / frames
    free = np.full((frames, 120), 1e3)
    m = (height > -1.3) & (height < 1)
    sector = ((np.degrees(np.arctan2(points[:, 1], points[:, 0])) + 180) / 3).astype(int) % 120
    np.minimum.at(free, (frame[m], sector[m]), level[m])
    out["free way"], out["free way, 10th percentile"] = np.percentile(free, [50, 10])
    out["sectors free beyond 40 m"] = (free > 40).mean()
    for low, high in ((0, 5), (5, 10), (10, 20), (20, 40), (40, 1e3)):
        out[f"points at {low}-{high:g} m"] = ((distance >= low) & (distance < high)).mean()
    for name in ("building", "fence", "vegetation", "vehicle"):
        if of[name].any():
            out[f"distance of {name}"] = np.median(level[of[name]])
        if np.sum(feet[name]) > 0:
            out[f"feet of {name} on sidewalk"] = feet[name][1] / feet[name].sum()
    slopes, rings = [], []
    for k in range(frames):
        m = (frame == k) & of["road"] & (distance < 20)
        if m.sum() < 300:
            continue
        x, y = points[m, 0], points[m, 1]
        design = np.c_[x, y, np.ones(len(x)), x * x, y * y, x * y]
        plane = np.linalg.lstsq(design[:, :3], height[m], rcond=None)[0]
        slopes.append(100 * np.hypot(plane[0], plane[1]))
        off = height[m] - design @ np.linalg.lstsq(design, height[m], rcond=None)[0]
        count = np.bincount(ring[m], minlength=ring.max() + 1)
        mean = np.bincount(ring[m], weights=off, minlength=ring.max() + 1) / np.maximum(count, 1)
        rings.append(np.where(count > 30, mean, np.nan))
    if rings:
        seen = np.array(rings)[:, np.isfinite(rings).any(axis=0)]
        out["slope of road"] = np.median(slopes)
        out["height error of rings, mm"] = 1000 * np.std(np.nanmedian(seen, axis=0))
    return out


def of_dataset(folder):
    """The statistics of each drive of a dataset, by its name."""
    drives = {}
    for sample in scanmill.open(folder):
        drives.setdefault(sample.key.rsplit("-", 1)[0], []).append(sample)
    return {name: of_drive(samples) for name, samples in drives.items()}


def small_surfaces(folder, rings=64, columns=1024):
    """How rough surfaces are, by class and range (m): distances of a range from the mean of its neighbours in the ring (median,
    75th and 90th percentile, mm; above .5 and 2 m, %), neighbours without return (%), difference to the ring above (median, m)."""
    names = list(dict.fromkeys(COARSE.values()))
    parts = {}
    for sample in scanmill.open(folder):
        scan, ontology = sample.scan(), sample.dataset.ontology
        coarse = np.full(int(max(ontology.ids)) + 1, -1)
        for name in ontology.names:
            coarse[ontology.id_of(name)] = names.index(COARSE[name]) if name in COARSE else -1
        distance = np.linalg.norm(scan.xyz, axis=1)
        column = np.floor((np.pi - np.arctan2(scan.xyz[:, 1], scan.xyz[:, 0])) / (2 * np.pi) * columns).astype(int) % columns
        order = np.argsort(-distance)  # so that the nearest of several points in a pixel stays
        pixels = scan.ring[order], column[order]
        image, classes = np.zeros((rings, columns)), np.full((rings, columns), -1)
        image[pixels], classes[pixels] = distance[order], coarse[scan.label[order]]
        left, right, above = np.roll(image, 1, 1), np.roll(image, -1, 1), np.roll(image, 1, 0)
        alike = (np.roll(classes, 1, 1) == classes) & (np.roll(classes, -1, 1) == classes)
        alike_above = np.roll(classes, 1, 0) == classes
        alike_above[0] = False
        for k, name in enumerate(names):
            for low, high in ((3, 8), (8, 15), (15, 30), (30, 60)):
                m = (classes == k) & (image >= low) & (image < high)
                part = parts.setdefault((name, low, high), ([], [], []))
                part[0].append(np.abs(image - (left + right) / 2)[m & alike])
                part[1].append(right[m] == 0)
                part[2].append(np.abs(image - above)[m & alike_above])
    figures = {}
    for key, columns_of in parts.items():
        along, lost, over = map(np.concatenate, columns_of)
        if len(along) and len(over):
            shares = [100 * (along > limit).mean() for limit in (0.5, 2)]
            figures[key] = [*(1000 * np.percentile(along, [50, 75, 90])), *shares, 100 * lost.mean(), np.median(over)]
    return figures


def summary(drives):
    """(median, least, greatest) over the drives that have a statistic, by its name."""
    names = dict.fromkeys(name for drive in drives.values() for name in drive)
    values = {name: [d[name] for d in drives.values() if name in d] for name in names}
    return {name: (np.median(v), min(v), max(v)) for name, v in values.items()}


if __name__ == "__main__":
    for row, (median, least, greatest) in summary(of_dataset(sys.argv[1])).items():
        print(f"{row:32} {median:8.3g}   {least:.3g} to {greatest:.3g}")
