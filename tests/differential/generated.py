#!/usr/bin/env python3
"""Holds what the program reads of maps and rasters against osmium and GDAL, and of point clouds against what was written.

    tests/differential/generated.py PROGRAM [FILES]    # of each kind; else 60

Debian has no collections of such files, so they are made at random here, in many of the ways in which a file can state
the same. The exit code is 1 if a file differs; such files are kept.
"""

import json
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from osgeo import gdal, osr

gdal.UseExceptions()
FOOT = 0.3048


def info(program: str, file: Path) -> str:
    run = subprocess.run([program, "info", file], capture_output=True, text=True, timeout=120)
    if run.returncode:
        raise ValueError(run.stderr.strip().splitlines()[-1])
    return run.stdout


def box_of(text: str) -> np.ndarray:
    corners = re.search(r"^from \[(.*?)\] to \[(.*?)\]", text, re.M)
    return np.array([[float(c.replace(",", "")) for c in corners[k].split(", ")] for k in (1, 2)])


def check(what: str, ours, theirs, error: float = 0) -> list[str]:
    return [] if np.all(np.abs(np.asarray(ours) - np.asarray(theirs)) <= error) else [f"{what}: {ours}, theirs {theirs}"]


# Maps: houses (also with courts), roads and meadows; a deleted house; four encodings.


def make_map(draw: random.Random, folder: Path) -> Path:
    nodes, ways, relations = [], [], []

    def point(x: float, y: float) -> int:
        nodes.append((51 + y / 111200, 0.5 + x / 70000))
        return len(nodes)

    def rectangle(x: float, y: float, w: float, h: float) -> list[int]:
        ring = [point(x, y), point(x + w, y), point(x + w, y + h), point(x, y + h)]
        return ring + ring[:1]

    def way(refs: list[int], tags: dict) -> int:
        ways.append((refs, tags))
        return len(ways)

    for k in range(draw.randint(2, 5)):
        way([point(-200, 60 * k), point(draw.uniform(-50, 50), 60 * k + 5), point(250, 60 * k)], {"highway": "residential", "name": f"R{k}"})
    for k in range(draw.randint(3, 25)):
        x, y = 20.0 * (k % 9), 60 * (k // 9) + 10
        if draw.random() < 0.2:
            parts = [way(rectangle(x, y, 14, 14), {}), way(rectangle(x + 4, y + 4, 5, 5), {})]
            relations.append((parts, {"type": "multipolygon", "building": "yes"}))
        else:
            height = draw.choice(["7", "7 m", "23'", "7,5", "23 ft"])
            way(rectangle(x, y, draw.uniform(6, 14), draw.uniform(6, 14)), {"building": "house", "height": height})
    for k in range(draw.randint(0, 4)):
        way(rectangle(-190 + 15 * k, 20, 12, 12), {"landuse": "meadow"})

    def element(kind: str, i: int, inside: str, tags: dict, more: str = "") -> str:
        text = "".join(f'<tag k="{k}" v="{v.replace(chr(39), "&apos;")}"/>' for k, v in tags.items())
        return f'<{kind} id="{i}" version="2" {more}>{inside}{text}</{kind}>'

    elements = [element("node", i + 1, "", {}, f'lat="{a:.9f}" lon="{b:.9f}"') for i, (a, b) in enumerate(nodes)]
    elements += [element("way", i + 1, "".join(f'<nd ref="{r}"/>' for r in refs), tags) for i, (refs, tags) in enumerate(ways)]
    deleted = "".join(f'<nd ref="{r}"/>' for r in ways[0][0][:1] + ways[1][0][:2] + ways[0][0][:1])
    elements.append(f'<way id="900" version="3" visible="false">{deleted}<tag k="building" v="house"/></way>')
    for i, (parts, tags) in enumerate(relations):
        members = "".join(f'<member type="way" ref="{w}" role="{r}"/>' for w, r in zip(parts, ["outer", "inner"]))
        elements.append(element("relation", i + 1, members, tags))
    file = folder / "map.osm"
    file.write_text('<?xml version="1.0"?>\n<osm version="0.6">\n' + "\n".join(elements) + "\n</osm>\n")
    ending = draw.choice([".osm", ".osm.pbf", ".osm.bz2", ".opl"])
    if ending != ".osm":
        other = file.with_suffix("").with_suffix(ending)
        subprocess.run(["osmium", "cat", file, "-o", other], check=True, capture_output=True)
        file = other
    return file


def compare_map(program: str, file: Path) -> list[str]:
    text = info(program, file)
    sorted_file = file.with_name("sorted.osh.pbf")
    subprocess.run(["osmium", "sort", file, "-o", sorted_file, "--overwrite"], check=True, capture_output=True)
    subprocess.run(["osmium", "time-filter", sorted_file, "-o", sorted_file.with_name("now.osm.pbf"), "--overwrite"], check=True, capture_output=True)
    sorted_file = sorted_file.with_name("now.osm.pbf")
    run = subprocess.run(["osmium", "export", "-f", "geojsonseq", "-x", "print_record_separator=false", sorted_file], check=True, capture_output=True, text=True)
    theirs = {"buildings": 0, "areas of land": 0}
    metres = 0.0
    for line in run.stdout.splitlines():
        feature = json.loads(line)
        tags, shape = feature["properties"], feature["geometry"]
        theirs["buildings"] += shape["type"] == "MultiPolygon" and "building" in tags
        theirs["areas of land"] += shape["type"] == "MultiPolygon" and "landuse" in tags
        if "highway" in tags:
            places = np.array(shape["coordinates"]) * [111320 * np.cos(np.radians(51.0005)), 111250]
            metres += np.sum(np.hypot(*np.diff(places, axis=0).T))
    found = []
    for what, count in theirs.items():
        number = re.search(rf"([\d,]+) {what}", text)
        found += check(what, int(number[1].replace(",", "")) if number else 0, count)
    return found + check("metres of roads", float(re.search(r"roads \(([\d.]+) m\)", text)[1]), metres, 0.003 * metres + 1)


# Rasters: types of samples, holes (nodata, a mask, an alpha band), scale and offset, units of heights and of places.


def make_raster(draw: random.Random, folder: Path) -> Path:
    numbers = np.random.default_rng(draw.randrange(2**32))
    width, height = draw.randint(5, 60), draw.randint(5, 60)
    kind = draw.choice([gdal.GDT_Float32, gdal.GDT_Float64, gdal.GDT_Int16, gdal.GDT_UInt16, gdal.GDT_Int32])
    samples = np.round(numbers.uniform(50, 250, (height, width)))
    ending = draw.choice([".tif", ".tif", ".img", ".asc"])
    hole = draw.choice(["none", "nodata", "nan", "mask", "alpha"])
    if ending != ".tif" and hole not in ("none", "nodata") or hole == "nan" and kind not in (gdal.GDT_Float32, gdal.GDT_Float64):
        hole = "nodata"
    if hole == "alpha" and kind != gdal.GDT_UInt16:  # GDAL itself masks by an alpha band of this type alone
        hole = "nodata"
    missing = numbers.random((height, width)) < (0.1 if hole != "none" else 0)
    driver = gdal.GetDriverByName("MEM" if ending == ".asc" else "HFA" if ending == ".img" else "GTiff")
    file = folder / f"heights{ending}"
    gdal.SetConfigOption("GDAL_TIFF_INTERNAL_MASK", draw.choice(["YES", "NO"]))
    image = driver.Create("" if ending == ".asc" else str(file), width, height, 2 if hole == "alpha" else 1, kind)
    step = draw.choice([0.5, 1.0, 2.0])
    image.SetGeoTransform([500000, step, 0, 5600000, 0, -step])
    reference = osr.SpatialReference()
    reference.ImportFromEPSG(draw.choice([32632, 2263] if ending == ".tif" else [32632]))  # 2263: US survey feet
    image.SetProjection(reference.ExportToWkt())
    band = image.GetRasterBand(1)
    if hole == "nodata":
        band.SetNoDataValue(0)
        samples[missing] = 0
    if hole == "nan":
        samples[missing] = np.nan
    band.WriteArray(samples)
    if hole == "mask":
        image.CreateMaskBand(gdal.GMF_PER_DATASET)
        band.GetMaskBand().WriteArray(np.where(missing, 0, 255).astype(np.uint8))
    if hole == "alpha":
        image.GetRasterBand(2).SetColorInterpretation(gdal.GCI_AlphaBand)
        image.GetRasterBand(2).WriteArray(np.where(missing, 0, 255))
    if ending == ".tif" and draw.random() < 0.5:
        band.SetScale(0.5)
        band.SetOffset(-10)
    if ending == ".tif" and draw.random() < 0.3:
        band.SetUnitType("ft")
    if ending == ".asc":
        gdal.GetDriverByName("AAIGrid").CreateCopy(str(file), image)
    return file


def compare_raster(program: str, file: Path) -> list[str]:
    text = info(program, file)
    image = gdal.Open(str(file))
    band = image.GetRasterBand(1)
    x0, step, _, y0, _, _ = image.GetGeoTransform()
    metres = osr.SpatialReference(image.GetProjection()).GetLinearUnits() if image.GetProjection() else 1
    known = band.GetMaskBand().ReadAsArray() > 0
    heights = band.ReadAsArray().astype(float)
    known &= np.isfinite(heights)
    heights = heights * (band.GetScale() or 1) + (band.GetOffset() or 0)
    heights *= FOOT if band.GetUnitType() == "ft" else 1  # where nothing states their unit, metres count, which is told
    # A square of four known samples has two triangles, one of three known samples has one or none.
    corners = known[:-1, :-1].astype(int) + known[1:, :-1] + known[:-1, 1:] + known[1:, 1:]
    triangles = int(re.search(r": ([\d,]+) triangles", text)[1].replace(",", ""))
    least, most = 2 * np.sum(corners == 4), 2 * np.sum(corners == 4) + np.sum(corners == 3)
    found = [] if least <= triangles <= most else [f"triangles: {triangles}, theirs {least} to {most}"]
    used = np.zeros_like(known)
    for dy in (0, 1):
        for dx in (0, 1):
            used[dy : dy + corners.shape[0], dx : dx + corners.shape[1]] |= corners == 4
    if not used.any():
        return found
    rows, columns = np.nonzero(used)
    box = box_of(text)
    low = [x0 + (columns.min() + 0.5) * step, y0 - (rows.max() + 0.5) * step, 0]
    high = [x0 + (columns.max() + 0.5) * step, y0 - (rows.min() + 0.5) * step, 0]
    theirs = np.array([low, high]) * metres
    theirs[:, 2] = heights[used].min(), heights[used].max()
    # Triangles of three samples may reach one step further.
    error = np.array([step * metres, step * metres, 0.02]) + 1e-4 if triangles > least else np.array([1e-3, 1e-3, 0.02])
    return found + check("box", box[:, :2].tolist(), theirs[:, :2].tolist(), error[0] + 0.06) + (
        check("heights", box[:, 2].tolist(), theirs[:, 2].tolist(), error[2]) if triangles == least else [])


# Clouds: encodings (by PCL's tool, too), types of coordinates, order of fields and further fields.


def make_cloud(draw: random.Random, folder: Path) -> Path:
    numbers = np.random.default_rng(draw.randrange(2**32))
    count = draw.randint(20, 400)
    places = numbers.uniform(-20, 20, (count, 3))
    names = ["x", "y", "z"] + draw.sample(["intensity", "nx", "curvature", "label"], draw.randint(0, 3))
    draw.shuffle(names)
    real = draw.choice(["<f4", "<f8"])
    kinds = {n: real if n in "xyz" else "<u4" if n == "label" else "<f4" for n in names}
    table = np.zeros(count, [(n, kinds[n]) for n in names])
    for n in names:
        table[n] = places[:, "xyz".index(n)] if n in "xyz" else numbers.integers(0, 50, count)
    ascii_rows = "\n".join(" ".join(repr(float(v)) if k[1] == "f" else str(int(v)) for v, k in zip(row, kinds.values())) for row in table)
    if draw.random() < 0.5:
        text = draw.random() < 0.4
        head = "# .PCD v0.7\nVERSION 0.7\nFIELDS " + " ".join(names) + "\nSIZE " + " ".join(kinds[n][2] for n in names)
        head += "\nTYPE " + " ".join(kinds[n][1].upper() for n in names) + "\nCOUNT" + " 1" * len(names)
        head += f"\nWIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {'ascii' if text else 'binary'}\n"
        file, body = folder / "cloud.pcd", ascii_rows.encode() if text else table.tobytes()
    else:
        order = draw.choice(["ascii", "binary_little_endian", "binary_big_endian"])
        words = {"<f4": "float", "<f8": "double", "<u4": "uint"}
        head = f"ply\nformat {order} 1.0\ncomment random\nelement vertex {count}\n"
        head += "".join(f"property {words[kinds[n]]} {n}\n" for n in names) + "end_header\n"
        big = table.astype([(n, kinds[n].replace("<", ">")) for n in names])
        body = {"ascii": ascii_rows.encode() + b"\n", "binary_little_endian": table.tobytes(), "binary_big_endian": big.tobytes()}[order]
        file = folder / "cloud.ply"
    file.write_bytes(head.encode() + body)
    if file.suffix == ".pcd" and draw.random() < 0.5:
        subprocess.run(["pcl_convert_pcd_ascii_binary", file, file, draw.choice("012")], check=True, capture_output=True)
    np.save(folder / "places.npy", places)
    return file


def compare_cloud(program: str, file: Path) -> list[str]:
    places = np.load(file.with_name("places.npy"))
    text = info(program, file)
    if "distance (m)" in text:  # a scan: the columns' ranges
        rows = [re.search(rf"^  {axis} \(m\) +(\S+) +(\S+)", text, re.M) for axis in "xyz"]
        box = np.array([[float(r[k].replace(",", "")) for r in rows] for k in (1, 2)])
        return check("points", int(re.search(r"([\d,]+) points", text)[1].replace(",", "")), len(places)) + check(
            "box", box.tolist(), [places.min(0).tolist(), places.max(0).tolist()], 1e-4)
    triangles = int(re.search(r": ([\d,]+) triangles", text)[1].replace(",", ""))  # two per disc of at most 0.2 m
    return check("points", triangles / 2, len(places)) + check(
        "box", box_of(text).tolist(), [places.min(0).tolist(), places.max(0).tolist()], 0.3)


KINDS = {"maps": (make_map, compare_map), "rasters": (make_raster, compare_raster), "clouds": (make_cloud, compare_cloud)}


def main() -> int:
    program = str(Path(sys.argv[1]).resolve())
    files = int(sys.argv[2]) if len(sys.argv) > 2 else 60
    bad = 0
    for kind, (make, compare) in KINDS.items():
        different = 0
        for seed in range(files):
            folder = Path(tempfile.mkdtemp(prefix=f"{kind}_{seed}_"))
            file = make(random.Random(seed), folder)
            try:
                found = compare(program, file)
            except Exception as e:  # a crash of the program, or a text that it does not print, is a finding
                found = [f"unread: {e!r}"]
            for text in found:
                print(f"{file}\t{text}")
            different += bool(found)
            if not found:
                shutil.rmtree(folder)
        print(f"{kind}: {files} files, {different} differ")
        bad += different
    return 1 if bad else 0


sys.exit(main())
