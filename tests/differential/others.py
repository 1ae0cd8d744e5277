"""Reads 3D files with programs and libraries of others, for compare.py.

    python3 others.py READER FILE...      # one JSON object a line and file; READER: vtk, open3d, osg
    blender -b --python others.py -- FILE...

An object holds `low` and `high` (corners of the box around the triangles), `triangles`, `up` ("z" if the reader turned
the file's axes so, "file" if it left them), and as far as the reader knows them `materials` (triangles by material).
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path


def box(points) -> dict:
    columns = list(zip(*points))
    return {"low": [min(c) for c in columns], "high": [max(c) for c in columns]}


def of_vtk_polydata(data) -> tuple[list, int]:
    """The points that polygons use, and the number of their triangles."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    triangles, used = 0, set()
    polygons = data.GetPolys()
    if polygons.GetNumberOfCells():
        ids = vtk_to_numpy(polygons.GetConnectivityArray())
        used.update(ids.tolist())
        triangles += len(ids) - 2 * polygons.GetNumberOfCells()
    strips = data.GetStrips()
    if strips.GetNumberOfCells():
        ids = vtk_to_numpy(strips.GetConnectivityArray())
        used.update(ids.tolist())
        triangles += len(ids) - 2 * strips.GetNumberOfCells()
    points = vtk_to_numpy(data.GetPoints().GetData())[sorted(used)].tolist() if used else []
    return points, triangles


def read_vtk(file: str) -> dict:
    import vtk

    suffix = Path(file).suffix.lower()
    readers = {".obj": vtk.vtkOBJReader, ".ply": vtk.vtkPLYReader, ".stl": vtk.vtkSTLReader}
    if suffix in readers:
        reader = readers[suffix]()
        reader.SetFileName(file)
        reader.Update()
        points, triangles = of_vtk_polydata(reader.GetOutput())
    elif suffix in (".gltf", ".glb"):
        reader = vtk.vtkGLTFReader()
        reader.SetFileName(file)
        reader.SetApplyDeformationsToGeometry(True)
        reader.Update()
        points, triangles = [], 0
        leaves = reader.GetOutput().NewIterator()
        while not leaves.IsDoneWithTraversal():
            more, count = of_vtk_polydata(leaves.GetCurrentDataObject())
            points += more
            triangles += count
            leaves.GoToNextItem()
    else:
        raise ValueError("VTK has no reader")
    return box(points) | {"triangles": triangles, "up": "file"}


def read_open3d(file: str) -> dict:
    import open3d

    mesh = open3d.io.read_triangle_mesh(file)
    low, high = mesh.get_min_bound(), mesh.get_max_bound()
    return {"low": low.tolist(), "high": high.tolist(), "triangles": len(mesh.triangles), "up": "file"}


def read_osg(file: str) -> dict:
    """By osgconv to OBJ, whose writer undoes what OpenSceneGraph's reader does to the axes."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "a.obj"
        subprocess.run(["osgconv", file, out], check=True, capture_output=True, timeout=60)
        vertices, used, triangles = [], set(), 0
        for line in out.read_text(errors="replace").splitlines():
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(w) for w in words[1:4]])
            elif words[:1] == ["f"]:
                corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
                used.update(corners)
                triangles += len(corners) - 2
        return box([vertices[i] for i in used]) | {"triangles": triangles, "up": "file"}


def read_blender(file: str) -> dict:
    import bpy
    import numpy

    numpy.bool = bool  # the glTF importer of Blender 3.4 uses the name that numpy 1.24 took out
    bpy.ops.wm.read_factory_settings(use_empty=True)
    suffix = Path(file).suffix.lower()
    if suffix == ".obj":
        bpy.ops.wm.obj_import(filepath=file, forward_axis="Y", up_axis="Z")
    elif suffix in (".gltf", ".glb"):
        bpy.ops.import_scene.gltf(filepath=file)
    elif suffix == ".dae":
        bpy.ops.wm.collada_import(filepath=file, import_units=False)
    elif suffix == ".stl":
        bpy.ops.import_mesh.stl(filepath=file)
    elif suffix == ".ply":
        bpy.ops.import_mesh.ply(filepath=file)
    elif suffix == ".blend":
        bpy.ops.wm.open_mainfile(filepath=file, load_ui=False, use_scripts=False)
    else:
        raise ValueError("Blender has no importer")
    units = bpy.context.scene.unit_settings
    metres = units.scale_length if suffix == ".blend" and units.system != "NONE" else 1
    graph = bpy.context.evaluated_depsgraph_get()
    points, materials, triangles = [], {}, 0
    for instance in graph.object_instances:
        thing = instance.object
        if thing.type != "MESH" or (thing.original.hide_render if suffix == ".blend" else thing.original.hide_get()):
            continue
        mesh = thing.to_mesh()
        mesh.calc_loop_triangles()
        for t in mesh.loop_triangles:
            slot = thing.material_slots[t.material_index] if t.material_index < len(thing.material_slots) else None
            name = slot.material.name if slot and slot.material else ""
            materials[name] = materials.get(name, 0) + 1
            triangles += 1
        used = {v for t in mesh.loop_triangles for v in t.vertices}
        points += [tuple(metres * (instance.matrix_world @ mesh.vertices[v].co)) for v in used]
        thing.to_mesh_clear()
    up = "file" if suffix in (".obj", ".stl", ".ply") else "z"
    return box(points) | {"triangles": triangles, "materials": materials, "up": up}


def main() -> None:
    if "bpy" in sys.modules or Path(sys.argv[0]).name.startswith("blender"):
        reader, files = read_blender, sys.argv[sys.argv.index("--") + 1 :]
    else:
        reader, files = {"vtk": read_vtk, "open3d": read_open3d, "osg": read_osg}[sys.argv[1]], sys.argv[2:]
    for file in files:
        try:
            result = reader(file)
        except Exception as error:  # whatever a library of others throws is a file that it cannot read
            result = {"error": f"{type(error).__name__}: {error}"[:200]}
        print("\n@" + json.dumps({"file": file} | result), flush=True)


main()
