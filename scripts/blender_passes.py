"""Runs inside Blender: renders the passes of a scene that Scanmill hands over, or exports the geometry of a file.

    blender -b --factory-startup --disable-autoexec -noaudio --python-exit-code 3 --python blender_passes.py -- JOB ...

    render FOLDER        takes requests, each a line of JSON on standard input: {"scene": FOLDER} for the scene that
                         scene.json and scene.bin hold there, then one with "file" and a camera for each image
    export FOLDER FILE   writes what a .blend, or a file that Blender imports, shows to FOLDER/scene.glb, z up, in
                         metres; the answer is JSON: numbers of what it lacks, by the notes of kBlenderFormat

Every answer is a line of JSON on standard output: {"what": "ready" | "scene" | "image" | "exported" | "error",
"text": ..., "seconds": since the request}; an error says with "input" whether the user's file is at fault. What Blender
itself prints goes to standard error. When its standard input ends, its owner is gone: the process removes FOLDER, which
is a temporary one, and ends at once.
"""

import collections
import importlib
import json
import os
import queue
import re
import shutil
import struct
import sys
import threading
import time

import bpy
import numpy as np
from mathutils import Matrix

EXACT = 1 << 24  # float32 holds whole numbers up to here


class BadInput(Exception):
    """The user's file is at fault."""


class Owner:
    """The program at the other end of the pipes."""

    def __init__(self, folder):
        self.folder = folder
        sys.stdout.flush()
        self.answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
        os.dup2(2, 1)
        self.lines = queue.Queue()
        self.asked = time.perf_counter()
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        for line in sys.stdin:
            self.lines.put(line)
        shutil.rmtree(self.folder, ignore_errors=True)
        os._exit(0)

    def request(self):
        line = self.lines.get()
        self.asked = time.perf_counter()
        return json.loads(line)

    def answer(self, what, text, **more):
        seconds = time.perf_counter() - self.asked
        self.answers.write(json.dumps({"what": what, "text": text, "seconds": seconds, **more}) + "\n")
        self.answers.flush()


# Render: the scene


def arrays_of(folder):
    """scene.json, and a function that reads an array by {"at": byte in scene.bin, "type": ..., "shape": [...]}."""
    with open(os.path.join(folder, "scene.json"), encoding="utf-8") as file:
        index = json.load(file)
    data = np.memmap(os.path.join(folder, "scene.bin"), dtype=np.uint8, mode="r")

    def read(entry):
        kind = np.dtype(entry["type"]).newbyteorder("<")
        count = int(np.prod(entry["shape"]))
        return data[entry["at"] : entry["at"] + count * kind.itemsize].view(kind).reshape(entry["shape"])

    return index, read


def make_image(mask, read):
    """An alpha mask, one byte a texel, as an image of which Cycles takes the very texel."""
    texels = read(mask)
    height, width = texels.shape
    image = bpy.data.images.new("mask", width, height, alpha=False, float_buffer=False, is_data=True)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[:, :, :3] = (texels != 0)[:, :, None]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def make_material(index, mask, read):
    """Writes what is seen to the pass `ids`: the object's number (red, and green what is beyond 2^24) and the triangle
    of its mesh (blue). Cycles adds up what the surfaces along a line of sight write: those that let it pass write
    zeroes."""
    material = bpy.data.materials.new(f"material{index}")
    material.use_nodes = True
    material.cycles.sample_as_light = False
    tree = material.node_tree
    tree.nodes.clear()

    def node(kind, **settings):
        made = tree.nodes.new(kind)
        for name, value in settings.items():
            setattr(made, name, value)
        return made

    surface = node("ShaderNodeEmission")
    surface.inputs["Strength"].default_value = 1  # a surface without light is not shaded, its ids not written
    surface = surface.outputs["Emission"]
    color = node("ShaderNodeSeparateRGB")
    tree.links.new(node("ShaderNodeObjectInfo").outputs["Color"], color.inputs["Image"])
    triangle = node("ShaderNodeAttribute", attribute_type="GEOMETRY", attribute_name="triangle")
    ids = node("ShaderNodeCombineXYZ")
    tree.links.new(color.outputs["R"], ids.inputs["X"])
    tree.links.new(color.outputs["G"], ids.inputs["Y"])
    tree.links.new(triangle.outputs["Fac"], ids.inputs["Z"])
    ids = ids.outputs["Vector"]
    if mask is not None:
        texture = node("ShaderNodeTexImage", image=make_image(mask, read), interpolation="Closest", extension="REPEAT")
        uvs = node("ShaderNodeUVMap", uv_map="uv")
        tree.links.new(uvs.outputs["UV"], texture.inputs["Vector"])
        mix = node("ShaderNodeMixShader")
        opaque = node("ShaderNodeMath", operation="GREATER_THAN")  # 0 or 1: no share of the other is left
        tree.links.new(texture.outputs["Color"], opaque.inputs[0])
        tree.links.new(opaque.outputs["Value"], mix.inputs["Fac"])
        tree.links.new(node("ShaderNodeBsdfTransparent").outputs["BSDF"], mix.inputs[1])
        tree.links.new(surface, mix.inputs[2])
        surface = mix.outputs["Shader"]
        masked = node("ShaderNodeVectorMath", operation="SCALE")
        tree.links.new(ids, masked.inputs["Vector"])
        tree.links.new(opaque.outputs["Value"], masked.inputs["Scale"])
        ids = masked.outputs["Vector"]
    tree.links.new(surface, node("ShaderNodeOutputMaterial").inputs["Surface"])
    passed = node("ShaderNodeOutputAOV", name="ids")
    if hasattr(passed, "aov_name"):  # Blender 4.1 and later: the node's name no longer names the pass
        passed.aov_name = "ids"
    tree.links.new(ids, passed.inputs["Color"])
    return material


def make_mesh(entry, read, materials):
    positions = read(entry["positions"])
    triangles = read(entry["triangles"])
    count = len(triangles)
    mesh = bpy.data.meshes.new("mesh")
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", positions.ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(count, 3, np.int32))
    slots, slot_of = np.unique(read(entry["materials"]), return_inverse=True)
    for slot in slots:
        mesh.materials.append(materials[slot])
    if len(slots) > 1:
        mesh.polygons.foreach_set("material_index", slot_of.astype(np.int32))
    if entry["uvs"] is not None:
        layer = mesh.uv_layers.new(name="uv", do_init=False)
        layer.data.foreach_set("uv", read(entry["uvs"])[triangles].ravel())
    attribute = mesh.attributes.new("triangle", "FLOAT", "FACE")
    attribute.data.foreach_set("value", np.arange(count, dtype=np.float32))
    mesh.update()
    return mesh


def make_objects(index, read, meshes):
    matrices = np.zeros((index["objects"], 4, 4))
    matrices[:, :3, :] = read(index["matrices"])
    matrices[:, 3, 3] = 1
    mesh_of = read(index["mesh_of"])
    scene = bpy.context.scene
    world = scene.camera.parent
    for i in range(index["objects"]):
        made = bpy.data.objects.new("object", meshes[mesh_of[i]])
        place(made, world, matrices[i])
        made.color = ((i + 1) % EXACT, (i + 1) // EXACT, 0, 1)
        scene.collection.objects.link(made)


def place(thing, world, matrix):
    """By the one matrix that Blender takes as it is: it keeps others as angles and scales, inexactly and unsheared."""
    if thing.parent is None:  # naming it again would have Blender look at all objects again
        thing.parent = world
    thing.matrix_parent_inverse = matrix.T.tolist()


def set_up(threads):
    """One sample at the centre of every pixel, no light, no filter, nothing that varies."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.world = None
    render = scene.render
    render.engine = "CYCLES"
    render.use_persistent_data = True
    render.use_compositing = False
    render.use_sequencer = False
    render.film_transparent = False
    render.threads_mode = "FIXED"
    render.threads = threads
    render.resolution_percentage = 100
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "NONE"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = 1
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.use_auto_tile = False
    cycles.pixel_filter_type = "GAUSSIAN"
    cycles.filter_width = 0.01
    cycles.max_bounces = 0
    cycles.transparent_max_bounces = 1024
    layer = bpy.context.view_layer
    layer.use_pass_combined = False
    layer.use_pass_z = True
    aov = layer.aovs.add()
    aov.name = "ids"
    aov.type = "COLOR"
    world = bpy.data.objects.new("world", None)
    scene.collection.objects.link(world)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    place(camera, world, np.eye(4))
    camera.data.type = "PERSP"
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


# Render: the images


def place_camera(scene, asked):
    """Of pinhole (fx, fy, cx, cy), pose (3 x 4, row by row; x right, y down, z forward) and limits."""
    width, height = asked["width"], asked["height"]
    render = scene.render
    render.resolution_x, render.resolution_y = width, height
    # A pixel is 1/fx wide and 1/fy high at depth 1; Blender wants both at least 1.
    stretch = asked["fx"] / asked["fy"]
    render.pixel_aspect_x, render.pixel_aspect_y = (1, stretch) if stretch >= 1 else (1 / stretch, 1)
    camera = scene.camera
    data = camera.data
    data.lens_unit = "MILLIMETERS"
    data.lens = 1024
    data.sensor_fit = "HORIZONTAL"
    data.sensor_width = 1024 * width / asked["fx"]
    data.shift_x = 0.5 - asked["cx"] / width
    # In units of the image's width, stretched as the pixels are.
    data.shift_y = (asked["cy"] - height / 2) * stretch / width
    data.clip_start, data.clip_end = asked["near"], asked["far"]
    pose = np.array(asked["pose"], np.float64).reshape(3, 4)
    matrix = np.eye(4)
    matrix[:3] = pose
    matrix[:3, 1:3] *= -1
    place(camera, camera.parent, matrix)


def draw(scene, asked):
    place_camera(scene, asked)
    scene.render.filepath = asked["file"]
    bpy.ops.render.render(write_still=True)
    if not os.path.exists(asked["file"]):
        raise RuntimeError(f"no image was written to {asked['file']}")


def load(folder):
    index, read = arrays_of(folder)
    scene = set_up(index["threads"])
    materials = [make_material(i, mask, read) for i, mask in enumerate(index["materials"])]
    meshes = [make_mesh(entry, read, materials) for entry in index["meshes"]]
    make_objects(index, read, meshes)
    return scene


def render(owner):
    owner.answer("ready", bpy.app.version_string)
    scene = None
    while True:
        asked = owner.request()
        if "scene" in asked:
            scene = load(asked["scene"])
            owner.answer("scene", asked["scene"])
        else:
            draw(scene, asked)
            owner.answer("image", asked["file"])


# Export


def version_text(version):
    return ".".join(str(part) for part in version[:2])


def open_blend(path):
    """No script, driver expression or handler of the file runs."""
    try:
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    except RuntimeError as failure:
        reason = str(failure).strip().removeprefix("Error: ").replace(f"Loading '{path}' failed: ", "")
        raise BadInput(f"Blender {bpy.app.version_string} cannot open it: {reason}") from failure
    if bpy.data.version[:2] > bpy.app.version[:2]:
        raise BadInput(
            f"was saved by Blender {version_text(bpy.data.version)}, but {bpy.app.version_string} is installed and"
            " would lose parts of it: install a newer Blender, set SCANMILL_BLENDER to one, or export it as GLB"
        )


# The importers by the endings of files, with options.
IMPORTERS = {
    ".fbx": ("import_scene", "fbx", {}),
    ".x3d": ("import_scene", "x3d", {"axis_forward": "-Z", "axis_up": "Y"}),
    ".abc": ("wm", "alembic_import", {"as_background_job": False}),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), ("wm", "usd_import", {"import_proxy": False})),
}


def import_file(path, kind):
    version = bpy.app.version_string
    module, name, options = IMPORTERS[kind]
    group = getattr(bpy.ops, module)
    if name not in dir(group):
        raise BadInput(
            f"Blender {version} as installed here has no importer of {kind}: set SCANMILL_BLENDER to one of blender.org"
            " that has it, or convert the file to glTF"
        )
    operator = getattr(group, name)
    if kind.startswith(".usd") and "apply_unit_conversion_scale" not in operator.get_rna_type().properties:
        raise BadInput(
            f"Blender {version} ignores the unit of USD files: set SCANMILL_BLENDER to a newer one of blender.org, or"
            " convert the file to glTF"
        )
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if kind == ".x3d" and bpy.app.version < (4, 2):
        # Blender 3.4 opens X3D in the mode "rU", which Python 3.11 no longer has.
        importlib.import_module("io_scene_x3d.import_x3d").open = lambda file, mode, **more: open(file, "r", **more)
    try:
        operator(filepath=path, **options)
    except RuntimeError as failure:
        reason = str(failure).strip().splitlines()[-1].removeprefix("Error: ")
        if "ASCII FBX" in reason:
            reason += "; save it as binary FBX, or convert it to glTF"
        raise BadInput(f"Blender {version} cannot import it: {reason}") from failure
    if kind == ".fbx":
        hide_coarser_levels(path)
    bpy.context.scene.frame_set(bpy.context.scene.frame_start)


def hide_coarser_levels(path):
    """Hides all levels of detail of an FBX but the first by name: the importer shows all of them."""
    with open(path, "rb") as file:
        data = file.read()
    ends = [found.start() for found in re.finditer(rb"\x00\x01ModelS\x08\x00\x00\x00LodGroup", data)]
    groups = [data[data.rfind(b"\0", 0, end) + 1 : end] for end in ends]
    for group in (bpy.data.objects.get(name.decode(errors="replace")) for name in groups):
        levels = sorted(group.children, key=lambda level: level.name) if group is not None else []
        for level in levels[1:]:
            for thing in (level, *level.children_recursive):
                thing.hide_render = True


SURFACES = {"MESH", "CURVE", "SURFACE", "FONT"}
OTHER_SHAPES = {
    "GPENCIL": "grease pencil objects",
    "GREASEPENCIL": "grease pencil objects",
    "CURVES": "hair curves",
    "VOLUME": "volumes",
    "POINTCLOUD": "point clouds",
}


# Names of the viewport's settings and of the renders' settings: of modifiers, metaballs, particles and scenes.
RENDER_SETTINGS = (
    ("show_viewport", "show_render"),
    ("levels", "render_levels"),
    ("steps", "render_steps"),
    ("viewport_resolution", "resolution"),
    ("resolution", "render_resolution"),
    ("child_nbr", "rendered_child_count"),
    ("child_percent", "rendered_child_count"),  # its name in later Blender
    ("simplify_subdivision", "simplify_subdivision_render"),
    ("simplify_child_particles", "simplify_child_particles_render"),
)


def show_as_renders_do():
    """Gives the viewport, whose evaluation is read, the settings of renders, and hides what renders do not show."""
    for collection in (*bpy.data.collections, bpy.context.scene.collection):
        collection.hide_viewport |= collection.hide_render
    for thing in bpy.data.objects:
        thing.hide_viewport |= thing.hide_render
        thing.show_instancer_for_viewport &= thing.show_instancer_for_render
    modifiers = (modifier for thing in bpy.data.objects for modifier in thing.modifiers)
    for owner in (*modifiers, *bpy.data.metaballs, *bpy.data.particles, bpy.context.scene.render):
        for viewport, render in RENDER_SETTINGS:
            if hasattr(owner, viewport) and hasattr(owner, render):
                setattr(owner, viewport, getattr(owner, render))
    for particles in bpy.data.particles:
        particles.display_percentage = 100
    for curve in bpy.data.curves:
        for axis in "uv":
            resolution = getattr(curve, f"render_resolution_{axis}")
            for part in (curve, *curve.splines) if resolution > 0 else ():
                setattr(part, f"resolution_{axis}", resolution)
    for group in bpy.data.node_groups:
        for node in [node for node in group.nodes if node.type == "IS_VIEWPORT"]:
            false = group.nodes.new("FunctionNodeInputBool").outputs[0]
            for link in list(node.outputs[0].links):
                group.links.new(false, link.to_socket)
    bpy.context.view_layer.update()


def count_left_out(shown, bare):
    """Counts by the notes of kBlenderFormat. `shown`: the objects that show faces or instances with faces; `bare`: those
    whose surface has none."""
    scene = bpy.context.scene
    hidden = "objects that the viewport or renders hide"
    hair = "particle systems of hair, lines or halos"
    elsewhere = {thing for other in bpy.data.scenes if other != scene for thing in other.objects}
    left_out = collections.Counter()
    left_out["objects without faces, such as edges and thin curves"] = len(bare - shown)
    left_out["objects of other scenes"] = sum(thing.type in SURFACES for thing in elsewhere - set(scene.objects))
    left_out["missing libraries, with all that is linked from them"] = sum(
        library.packed_file is None and not os.path.exists(bpy.path.abspath(library.filepath))
        for library in bpy.data.libraries
    )
    left_out["animations (the saved or first frame counts)"] = sum(
        action.users > action.use_fake_user for action in bpy.data.actions
    ) + sum(
        part.type in ("MESH_SEQUENCE_CACHE", "TRANSFORM_CACHE")
        for thing in scene.objects
        for part in (*thing.modifiers, *thing.constraints)
    )
    for thing in scene.objects:
        if not thing.visible_get():
            left_out[hidden] += thing.type in SURFACES or thing.is_instancer
            continue
        kinds = [system.settings.render_type for system in thing.particle_systems]
        left_out[hair] += sum(kind not in ("NONE", "OBJECT", "COLLECTION") for kind in kinds)
        instances = len(kinds) > 0 or thing.is_instancer
        left_out[hidden] += instances and thing.type in SURFACES and not thing.show_instancer_for_viewport
        left_out[OTHER_SHAPES.get(thing.type, "")] += 1
    del left_out[""]
    return left_out


# Export: materials


def source(socket):
    """Returns the output that feeds a socket; None if the socket is a constant."""
    # Links of a cycle are not valid; Blender ignores muted links.
    while socket.is_linked and socket.links[0].is_valid and not socket.links[0].is_muted:
        output = socket.links[0].from_socket
        if output.node.type == "REROUTE":
            socket = output.node.inputs[0]
        elif output.node.mute:
            inner = [link.from_socket for link in output.node.internal_links if link.to_socket == output]
            if not inner:
                return output
            socket = inner[0]
        else:
            return output
    return None


def surface_of(surface):
    """Returns the shader of a surface, the sockets of its colour and its alpha, each None if there is none, whether the
    alpha is 1 minus the latter, and whether the surface has no more than these."""
    alpha, inverse, known = None, False, True
    while (output := source(surface)) is not None and output.node.type in ("MIX_SHADER", "ADD_SHADER"):
        *share, first, second = output.node.inputs
        before = source(share[0]) if share else None
        is_clear, ends_clear = (
            source(side) is not None and source(side).node.type == "BSDF_TRANSPARENT" for side in (first, second)
        )
        if before is not None and before.node.type == "LIGHT_PATH":
            surface = second if before.name == "Is Camera Ray" else first
        elif is_clear != ends_clear and share and alpha is None:
            alpha, inverse, surface = share[0], ends_clear, first if ends_clear else second
        else:
            surface, known = second if is_clear or not first.is_linked else first, False
    if output is None or output.type != "SHADER":  # a colour without a shader shines
        return None, None if output is None else surface, alpha, inverse, known and output is not None
    shader = output.node
    if shader.type == "BSDF_PRINCIPLED":
        own = shader.inputs["Alpha"]
        known &= alpha is None or (not own.is_linked and own.default_value == 1)
        return shader, shader.inputs["Base Color"], alpha or own, inverse, known
    known &= shader.type.startswith(("BSDF_", "EMISSION", "SUBSURFACE")) and shader.type != "BSDF_TRANSPARENT"
    colors = [socket for socket in shader.inputs if socket.type == "RGBA" and socket.name in ("Base Color", "Color")]
    return shader, colors[0] if colors else None, alpha, inverse, known


def textures_before(output, seen=None):
    """Yields the nodes of the images on which an output depends, each once."""
    seen = set() if seen is None else seen
    if output is not None and output.node not in seen:
        seen.add(output.node)
        if output.node.type == "TEX_IMAGE" and output.node.image is not None:
            yield output.node
        for socket in output.node.inputs:
            yield from textures_before(source(socket), seen)


def is_placed_by_uvs(texture):
    """True if the exporter keeps how an image is placed."""
    place = source(texture.inputs["Vector"])
    if place is not None and place.node.type == "MAPPING":
        mapping = place.node
        x, y, z = mapping.inputs["Rotation"].default_value
        scale = mapping.inputs["Scale"].default_value
        shears = mapping.vector_type == "TEXTURE" and z != 0 and scale[0] != scale[1]
        if x != 0 or y != 0 or shears or mapping.vector_type == "NORMAL":
            return False
        if any(socket.is_linked for socket in mapping.inputs[1:]):
            return False
        place = source(mapping.inputs["Vector"])
    by_uvs = place is None or place.node.type == "UVMAP" or (place.node.type == "TEX_COORD" and place.name == "UV")
    return by_uvs and texture.projection == "FLAT" and texture.image.source in ("FILE", "GENERATED")


def read_socket(socket):
    """Returns a factor, the output of an image or None, and True, if the socket's value is their product. Else returns
    None, an output that depends on an image or None, and False."""
    output = source(socket)
    if output is None:
        return np.array(socket.default_value), None, True
    node = output.node
    if node.type in ("RGB", "VALUE"):
        return np.array(output.default_value), None, True
    if node.type == "TEX_IMAGE" and node.image is not None and is_placed_by_uvs(node):
        opaque = output.name == "Alpha" and node.image.alpha_mode == "NONE"
        return np.array(1.0), None if opaque else output, True
    is_color = node.type == "MIX_RGB" or (node.type == "MIX" and node.data_type == "RGBA")
    mixes = is_color and node.blend_type == "MULTIPLY" and not node.inputs[0].is_linked
    if mixes or (node.type == "MATH" and node.operation == "MULTIPLY"):
        weight = node.inputs[0].default_value if mixes else 1.0
        sides = [side for side in node.inputs if side.enabled][-2:]
        (one, texture, one_known), (two, other, two_known) = map(read_socket, sides)
        if one_known and two_known and other is None:
            return one * (1 - weight + weight * two), texture, True
        if one_known and two_known and texture is None and weight == 1:
            return one * two, other, True
    return None, output if any(textures_before(output)) else None, False


def compared(alpha, inverse):
    """Returns the socket on which an alpha depends, whether 1 minus its value counts, as `inverse` says of the alpha, and
    the cutoff with which nodes compare that to get 0 or 1; None if none do."""
    while (output := source(alpha)) is not None:
        node, cutoff = output.node, None
        if node.type == "INVERT" and not node.inputs[0].is_linked and node.inputs[0].default_value == 1:
            alpha, inverse = node.inputs[1], not inverse
            continue
        if node.type != "MATH":
            break
        one, two, *_ = node.inputs
        if node.operation == "SUBTRACT" and not one.is_linked and one.default_value == 1:
            alpha, inverse = two, not inverse
            continue
        if node.operation == "ROUND":
            cutoff = 0.5
        elif node.operation in ("GREATER_THAN", "LESS_THAN") and not two.is_linked:
            cutoff = two.default_value
            inverse ^= node.operation == "LESS_THAN"
        return (alpha, inverse, None) if cutoff is None else (one, inverse, 1 - cutoff if inverse else cutoff)
    return alpha, inverse, None


def add_principled(tree, like):
    """Adds a Principled BSDF with the gloss of another shader, which may be None."""
    kind = "" if like is None else like.type
    added = tree.nodes.new("ShaderNodeBsdfPrincipled")
    mirror = kind in ("BSDF_GLOSSY", "BSDF_ANISOTROPIC")
    added.inputs["Metallic"].default_value = float(mirror)
    added.inputs["Roughness"].default_value = like.inputs["Roughness"].default_value if mirror else 1.0
    if kind in ("BSDF_GLASS", "BSDF_REFRACTION"):
        next(socket for socket in added.inputs if socket.name.startswith("Transmission")).default_value = 1.0
    return added


class Materials:
    """Copies of the file's materials that the exporter understands. Adds to `left_out` what they lack."""

    def __init__(self, left_out):
        self.left_out = left_out
        self.copies = {None: None}  # by the file's material
        self.changes = {}  # of the exported materials, by the names of the copies
        self.missing = {}  # images without pixels -> those that are exported in their place
        self.paths = {}  # of the missing images, by the names of those in their place

    def copy(self, material):
        if material not in self.copies:
            copy = self.copies[material] = material.copy()
            copy.name = f"material{len(self.copies)}"
            self.changes[copy.name] = {"name": material.name, "color": None, "alpha": None, "cutoff": None}
            if material.use_nodes:
                self.simplify(copy)
        return self.copies[material]

    def simplify(self, material):
        """Makes the surface a Principled BSDF, and its colour and its alpha each a factor and an image."""
        tree = material.node_tree
        end = tree.get_output_node("ALL") or tree.nodes.new("ShaderNodeOutputMaterial")
        shader, color, alpha, inverse, known = surface_of(end.inputs["Surface"])
        factor, texture, color_known = read_socket(color) if color else (None, None, False)
        alpha, inverse, cutoff = compared(alpha, inverse) if alpha else (None, False, None)
        opacity, mask, alpha_known = read_socket(alpha) if alpha else (np.array(1.0), None, True)
        if texture is not None and mask is not None and color_known and alpha_known:
            known &= source(texture.node.inputs["Vector"]) == source(mask.node.inputs["Vector"])
        if inverse and mask is None and opacity is not None:
            opacity = 1 - opacity
        if mask is not None and (inverse or texture is None):
            known &= mask.node.image.size[0] > 0 and not (inverse and np.any(opacity != 1))
            mask = self.mask(mask, inverse, tree) if known else mask
        if factor is None and texture is None:
            factor = np.array(material.diffuse_color)  # which Blender shows in the viewport
        if opacity is None and mask is None:
            opacity = np.array(1.0)
        if shader is None or shader.type != "BSDF_PRINCIPLED":
            shader = add_principled(tree, shader)
            tree.links.new(shader.outputs[0], end.inputs["Surface"])
        for name, output in (("Base Color", texture), ("Alpha", mask)):
            for link in shader.inputs[name].links:
                tree.links.remove(link)
            for node in textures_before(output):
                node.image = self.readable(node.image)
            if output is not None:
                tree.links.new(output, shader.inputs[name])
        change = self.changes[material.name]
        change["cutoff"] = cutoff
        change["color"] = None if factor is None else np.clip(np.atleast_1d(factor)[:3], 0, 1)
        if opacity is not None:
            opacity = float(np.mean(np.atleast_1d(opacity)[:3]))
            change["alpha"] = shader.inputs["Alpha"].default_value = opacity
        self.left_out["materials with nodes that are not read (colour and alpha may differ)"] += not (
            known and color_known and alpha_known
        )
        if bpy.app.version < (4, 2):
            solid = mask is None and opacity >= 1
            self.left_out["opacities of materials whose blend mode is opaque"] += (
                not solid and material.blend_method == "OPAQUE"
            )
            if solid:
                material.blend_method = "OPAQUE"

    def mask(self, output, inverse, tree):
        """Returns the alpha of a new node with a white image whose alpha is a value of an image, or 1 minus it. The
        exporter would take the colours of an image that gives the alpha alone."""
        node = tree.nodes.new("ShaderNodeTexImage")
        node.extension = output.node.extension
        place = source(output.node.inputs["Vector"])
        if place is not None:
            tree.links.new(place, node.inputs["Vector"])
        pixels = np.empty(len(output.node.image.pixels), np.float32)
        output.node.image.pixels.foreach_get(pixels)
        values = pixels.reshape(-1, 4)
        values[:, 3] = values[:, 3 if output.name == "Alpha" else 0]
        values[:, 3] = 1 - values[:, 3] if inverse else values[:, 3]
        values[:, :3] = 1
        node.image = bpy.data.images.new(f"{output.node.image.name}.mask", *output.node.image.size, alpha=True)
        node.image.pixels.foreach_set(pixels)
        return node.outputs["Alpha"]

    def readable(self, image):
        if image.source != "FILE" or image.size[0] > 0:
            return image
        if image not in self.missing:
            path = image.filepath.removeprefix("//")
            in_place = self.missing[image] = bpy.data.images.new(f"scanmill{len(self.missing)}", 1, 1)
            exists = os.path.exists(bpy.path.abspath(image.filepath, library=image.library))
            self.paths[in_place.name] = os.path.basename(path) if exists else path
        return self.missing[image]

    def change(self, document):
        """Completes the exported materials in the JSON of a glTF. Names missing images, for its reader to find."""
        for material in document.get("materials", []):
            change = self.changes[material["name"]]
            material["name"] = change["name"]
            base = material.setdefault("pbrMetallicRoughness", {})
            factor = np.array(base.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)))
            factor[:3] = factor[:3] if change["color"] is None else change["color"]
            factor[3] = factor[3] if change["alpha"] is None else change["alpha"]
            base["baseColorFactor"] = factor.tolist()
            if change["cutoff"] is not None and "alphaMode" in material:
                material.update(alphaMode="MASK", alphaCutoff=change["cutoff"])
        for image in document.get("images", []):
            for name in image["name"].split("-"):
                if name in self.paths:
                    image.clear()
                    image.update(name=name, uri=self.paths[name])


# Export: objects


def flatten():
    """Replaces the objects by what they show, modifiers applied, every instance an object of its own. Returns what
    their nodes are to have: the name, since Blender allows each but once, and the matrix, since an object's own cannot
    be sheared. Also returns the Materials and count_left_out()."""
    units = bpy.context.scene.unit_settings
    metres = units.scale_length if units.system != "NONE" else 1.0
    meshes = {}
    placed = []
    showing, bare = set(), set()
    show_as_renders_do()
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        shown = instance.object
        if not instance.is_instance and shown.type in SURFACES and not (shown.type == "MESH" and not shown.data.vertices):
            bare.add(shown.original)
        # What evaluates to a mesh, such as a text, comes as an instance of type MESH beside its own.
        if shown.type != "MESH" or not instance.show_self:
            continue
        # Renders hide an object that its parent repeats on vertices or faces.
        parent = shown.original.parent
        if not instance.is_instance and parent is not None and parent.instance_type in ("VERTS", "FACES"):
            continue
        key = (shown.data.as_pointer(), *(slot.material and slot.material.name_full for slot in shown.material_slots))
        if key not in meshes:
            meshes[key] = bpy.data.meshes.new_from_object(shown)
            for i, slot in enumerate(shown.material_slots[: len(meshes[key].materials)]):
                if slot.link == "OBJECT":
                    meshes[key].materials[i] = slot.material and slot.material.original
        if len(meshes[key].polygons) > 0:
            placed.append((shown.name, meshes[key], Matrix.Scale(metres, 4) @ instance.matrix_world))
            showing.add((instance.parent or shown).original)
            showing.add(shown.original)
    left_out = count_left_out(showing, bare)
    materials = Materials(left_out)
    for mesh in meshes.values():
        for i, material in enumerate(mesh.materials):
            mesh.materials[i] = materials.copy(material)
    for old in list(bpy.data.objects):
        bpy.data.objects.remove(old)
    nodes = {}
    for i, (name, mesh, matrix) in enumerate(placed):
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(f"object{i}", mesh))
        nodes[f"object{i}"] = {"name": name, "matrix": [value for column in matrix.transposed() for value in column]}
    return nodes, materials, left_out


def change_glb(path, nodes, materials):
    """A GLB is a header of 12 bytes, then chunks of length, kind and bytes, the first of which is JSON."""
    with open(path, "rb") as file:
        glb = file.read()
    length = struct.unpack_from("<I", glb, 12)[0]
    document = json.loads(glb[20 : 20 + length])
    for node in document.get("nodes", []):
        node.update(nodes[node["name"]])
    materials.change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + length :]
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest)


def export(owner, path):
    glb = os.path.join(owner.folder, "scene.glb")
    kind = os.path.splitext(path)[1].lower()
    if kind == ".blend":
        open_blend(path)
    else:
        import_file(path, kind)
    nodes, materials, left_out = flatten()
    if kind == ".x3d":
        with open(path, "rb") as file:
            left_out["files that Inline names"] = file.read().count(b"<Inline")
    if not nodes:
        raise BadInput("shows no surface: nothing with faces is visible in its active scene, in viewport and renders")
    # Blender 4.2 and later has one choice of colours for what 3.4 has a switch.
    colors = {"export_vertex_color": "NONE"} if bpy.app.version >= (4, 2) else {"export_colors": False}
    bpy.ops.export_scene.gltf(
        filepath=glb,
        export_format="GLB",
        export_yup=False,
        export_normals=False,
        export_animations=False,
        export_skins=False,
        export_morph=False,
        export_cameras=False,
        export_lights=False,
        **colors,
    )
    change_glb(glb, nodes, materials)
    owner.answer("exported", json.dumps(left_out))


def main():
    job, folder, *arguments = sys.argv[sys.argv.index("--") + 1 :]
    owner = Owner(folder)
    try:
        {"render": render, "export": export}[job](owner, *arguments)
    except BadInput as failure:
        owner.answer("error", str(failure), input=True)
        sys.exit(3)


main()
