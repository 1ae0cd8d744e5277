// .blend files and files that Blender imports: made by Blender scripts of this test, third-party ones, and broken ones.

#include "assets/meshes/blender.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "assets/asset.h"
#include "base/file.h"
#include "base/process.h"
#include "tests/support/blender.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

constexpr const char* kFile = "it's a 'thing' \xC3\xA4.blend";

// The beginning of all scripts: an empty scene, and functions that fill it.
constexpr const char* kPrelude = R"py(
import math, os, sys
import bpy
import numpy as np

folder = sys.argv[sys.argv.index("--") + 1]
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
scene = bpy.context.scene


def mesh(name, corners, faces, edges=()):
    made = bpy.data.meshes.new(name)
    made.from_pydata(corners, edges, faces)
    return made


def box(name, low=0, high=1):
    corners = [(x, y, z) for x in (low, high) for y in (low, high) for z in (low, high)]
    return mesh(name, corners, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def square(name, material):
    made = mesh(name, [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
    made.uv_layers.new(name="map")
    made.materials.append(material)
    return made


def put(name, data=None, collection=scene.collection, **settings):
    made = bpy.data.objects.new(name, data)
    collection.objects.link(made)
    for key, value in settings.items():
        setattr(made, key, value)
    return made


def material(name, color=None):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    if color is not None:
        shader.inputs["Base Color"].default_value = (*color, 1)
    return made, made.node_tree, shader


def geometry_nodes(kinds):
    group = bpy.data.node_groups.new("group", "GeometryNodeTree")
    if bpy.app.version >= (4, 0):
        group.interface.new_socket("in", in_out="INPUT", socket_type="NodeSocketGeometry")
        group.interface.new_socket("out", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        group.inputs.new("NodeSocketGeometry", "in")
        group.outputs.new("NodeSocketGeometry", "out")
    return group, [group.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", *kinds)]


def save(name, **options):
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, name), **options)
)py";

// Makes one file with everything, one in centimetres, one with nothing. All carry a text that wants to run when the
// file is opened, and a driver whose expression writes a file.
constexpr const char* kScript = R"py(
unit = box("unit", -0.5, 0.5)
paint, _, shader = material("Red Paint", (0.8, 0.1, 0.1))
shader.inputs["Roughness"].default_value = 0.25
unit.materials.append(paint)
wall = put("Wall.a", unit, location=(0, 0, 1))
wall.modifiers.new("array", "ARRAY").count = 3
put("Hidden", unit, hide_viewport=True)
put("Helper", unit, hide_render=True)
put("Mirrored", unit, location=(0, 5, 1), scale=(-1, 1, 2))
parent = put("Frame", scale=(1, 3, 1))
put("Sheared", unit, parent=parent, rotation_euler=(0, 0, math.pi / 4), location=(-20, 0, 0))
tree = bpy.data.collections.new("tree")
put("Crown", box("crown", -0.25, 0.25), tree)
put("Stem", box("stem", -0.125, 0.125), tree, location=(0, 0, -1))
for i in range(3):
    put(f"Tree{i}", instance_type="COLLECTION", instance_collection=tree, location=(10, 3 * i, 2))
text = bpy.data.curves.new("sign", "FONT")
text.body = "Hi"
put("Sign", text, location=(0, -9, 0))
group, nodes = geometry_nodes(("GeometryNodeInstanceOnPoints", "GeometryNodeMeshCube"))
group.links.new(nodes[0].outputs[0], nodes[2].inputs["Points"])
group.links.new(nodes[3].outputs["Mesh"], nodes[2].inputs["Instance"])
group.links.new(nodes[2].outputs[0], nodes[1].inputs[0])
scatter = put("Scatter", box("points", -4, 4), location=(30, 0, 0))
scatter.modifiers.new("scatter", "NODES").node_group = group

pixels = np.ones((8, 8, 4), np.float32)
pixels[:4, :, 3] = 0
pixels[:, :, 0] = 0.2
image = bpy.data.images.new("leaf picture", 8, 8, alpha=True)
image.pixels.foreach_set(pixels.ravel())
image.update()
image.pack()
leaf, nodes, shader = material("Leaf", (1, 1, 1))
leaf.blend_method = "CLIP"
leaf.alpha_threshold = 0.4
picture = nodes.nodes.new("ShaderNodeTexImage")
picture.image = image
for output, name_in in (("Color", "Base Color"), ("Alpha", "Alpha")):
    nodes.links.new(picture.outputs[output], shader.inputs[name_in])
put("Card", square("card", leaf), location=(0, 0, 7))

marker = os.path.join(folder, "ran_")
evil = bpy.data.texts.new("evil.py")
evil.write(f"open({marker + 'text'!r}, 'w').write('x')")
evil.use_module = True
driver = wall.driver_add("location", 0).driver
driver.type = "SCRIPTED"
driver.expression = f"[open({marker + 'driver'!r}, 'w').write('x'), 0.0][1]"

save(sys.argv[-1], compress=False)
scene.unit_settings.scale_length = 0.01
save("cm.blend", compress=True)
for old in list(bpy.data.objects):
    bpy.data.objects.remove(old)
put("Only points", bpy.data.meshes.new("empty"))
save("empty.blend", compress=False)
)py";

std::string runBlender(const std::vector<std::string>& words) {
  std::vector<std::string> command{"blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "3"};
  command.insert(command.end(), words.begin(), words.end());
  Process blender(command);
  while (blender.readLine(120)) {
  }
  const std::string end = blender.wait(120);
  return end == "exit code 0" ? "" : end + "\n" + blender.lastLines();
}

struct Node {
  Box bounds;
  std::size_t triangles = 0;
  std::vector<std::string> materials;
};

// By name and place among those of the same name.
std::map<std::string, std::vector<Node>> nodesOf(const Asset& asset) {
  std::map<std::string, std::map<std::uint32_t, Node>> byIndex;
  for (const AssetPart& part : asset.parts) {
    Node& node = byIndex[part.node][part.nodeIndex];
    for (const Vec3f& p : part.positions) node.bounds.add(Vec3d(p));
    node.triangles += part.triangles.size();
    node.materials.push_back(part.material);
  }
  std::map<std::string, std::vector<Node>> nodes;
  for (const auto& [name, all] : byIndex) {
    for (const auto& [index, node] : all) nodes[name].push_back(node);
  }
  return nodes;
}

void expectBounds(const Node& node, const Vec3d& low, const Vec3d& high) {
  EXPECT_LT(length(node.bounds.low - low), 1e-5);
  EXPECT_LT(length(node.bounds.high - high), 1e-5);
}

class Blend : public testing::Test {
 protected:
  void run(const char* script) {
    const auto file = folder_.write("make.py", std::string(kPrelude) + script);
    ASSERT_EQ(runBlender({"--python", file.string(), "--", folder_.path().string(), kFile}), "");
  }
  void make() {
    run(kScript);
    made_ = folder_.path() / kFile;
    for (const char* marker : {"ran_text", "ran_driver"}) std::filesystem::remove(folder_.path() / marker);
  }

  bool ran(const char* marker) const { return std::filesystem::exists(folder_.path() / marker); }

  TemporaryFolder folder_;
  std::filesystem::path made_;
};

TEST_F(Blend, ShowsWhatBlenderShowsAndRunsNothing) {
  SKIP_WITHOUT_BLENDER();
  make();
  const Asset asset = readAsset(made_, {});
  EXPECT_FALSE(ran("ran_text"));
  EXPECT_FALSE(ran("ran_driver"));
  EXPECT_EQ(asset.file, made_);
  EXPECT_EQ(asset.up, 'z');

  const auto nodes = nodesOf(asset);
  EXPECT_FALSE(nodes.contains("Hidden"));
  EXPECT_FALSE(nodes.contains("Helper"));
  ASSERT_EQ(nodes.at("Wall.a").size(), 1u);
  EXPECT_EQ(nodes.at("Wall.a")[0].triangles, 36u) << "the modifier's copies";
  expectBounds(nodes.at("Wall.a")[0], {-0.5, -0.5, 0.5}, {2.5, 0.5, 1.5});
  expectBounds(nodes.at("Mirrored").at(0), {-0.5, 4.5, 0}, {0.5, 5.5, 2});
  const double half = std::sqrt(0.5);  // a unit square turned by 45 degrees, then stretched threefold along y
  expectBounds(nodes.at("Sheared").at(0), {-20 - half, -3 * half, -0.5}, {-20 + half, 3 * half, 0.5});
  ASSERT_EQ(nodes.at("Crown").size(), 3u);
  ASSERT_EQ(nodes.at("Stem").size(), 3u);
  expectBounds(nodes.at("Crown")[2], {9.75, 5.75, 1.75}, {10.25, 6.25, 2.25});
  EXPECT_EQ(nodes.at("Scatter").size(), 8u) << "instances by nodes";
  EXPECT_GT(nodes.at("Sign").at(0).triangles, 10u) << "a text has a surface";
  EXPECT_EQ(nodes.at("Mirrored")[0].materials, std::vector<std::string>{"Red Paint"});

  const auto materialOf = [&](const char* node) {
    return std::find_if(asset.parts.begin(), asset.parts.end(), [&](const AssetPart& p) { return p.node == node; })
        ->fileMaterial;
  };
  EXPECT_NEAR(materialOf("Wall.a").reflectance, 0.2126 * 0.8 + 0.7874 * 0.1, 1e-4);
  EXPECT_NEAR(materialOf("Wall.a").roughness, 0.25, 1e-6);
  EXPECT_THAT(materialOf("Wall.a").source, HasSubstr(kFile));
  const Material card = materialOf("Card");
  EXPECT_TRUE(card.alphaTested);
  // Blender 4.2 and later has no threshold of a material: its exporter of glTF says a half.
  EXPECT_THAT(card.alphaCutoff, testing::AnyOf(testing::FloatNear(0.4F, 1e-6F), testing::FloatEq(0.5F)));
  ASSERT_TRUE(card.texture);
  EXPECT_EQ(card.texture->width, 8u);
  EXPECT_EQ(card.texture->texel(0.5f, 0.25f)[3], 0) << "the lower half is transparent";
  EXPECT_EQ(card.texture->texel(0.5f, 0.75f)[3], 255);
  EXPECT_THAT(card.texture->file, testing::StartsWith(made_.string()));

  // Outward faces, mirrored or not: the volume of a closed surface is positive.
  for (const AssetPart& part : asset.parts) {
    if (part.node != "Mirrored" && part.node != "Sheared") continue;
    double volume = 0;
    for (const Triangle& t : part.triangles) {
      volume += dot(Vec3d(part.positions[t[0]]), cross(Vec3d(part.positions[t[1]]), Vec3d(part.positions[t[2]]))) / 6;
    }
    EXPECT_NEAR(volume, part.node == "Mirrored" ? 2 : 3, 1e-3) << part.node;
  }

  // The same file in centimetres.
  const auto small = nodesOf(readAsset(folder_.path() / "cm.blend", {.metresPerUnit = 10}));
  expectBounds(small.at("Wall.a").at(0), {-0.05, -0.05, 0.05}, {0.25, 0.05, 0.15});
  expectBounds(small.at("Stem").at(0), Vec3d{9.875, -0.125, 0.875} * 0.1, Vec3d{10.125, 0.125, 1.125} * 0.1);

  // The files that must not run are ones that would.
  runBlender({"--enable-autoexec", made_.string()});
  EXPECT_TRUE(ran("ran_text"));
  EXPECT_TRUE(ran("ran_driver"));
}

// Makes hidden.blend: "shown" and eight copies of "leaf" in instances, and what is left out.
constexpr const char* kHiding = R"py(
cube = box("cube")
glass, _, shader = material("glass")
shader.inputs["Alpha"].default_value = 0.2
shown = put("shown", cube.copy())
shown.data.materials.append(glass)
hidden = bpy.data.collections.new("hidden")
scene.collection.children.link(hidden)
hidden.hide_render = True
put("in hidden", cube, hidden)
library = bpy.data.collections.new("library")
put("of library", cube, library)
put("hidden instance", instance_type="COLLECTION", instance_collection=library, hide_render=True)
put("leaf", cube, parent=put("crown", cube, instance_type="VERTS", show_instancer_for_render=False))
put("eye", cube).hide_set(True)
put("edge", mesh("edge", [(0, 0, 0), (1, 0, 0)], [], [(0, 1)]))
put("cloud", bpy.data.volumes.new("cloud"))
settings = shown.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
settings.type = "HAIR"
bpy.data.scenes.new("other").collection.objects.link(bpy.data.objects.new("elsewhere", cube))
save("library.blend", copy=True)
with bpy.data.libraries.load(os.path.join(folder, "library.blend"), link=True) as (found, wanted):
    wanted.objects = ["in hidden"]
scene.collection.objects.link(wanted.objects[0])
save("hidden.blend")
os.remove(os.path.join(folder, "library.blend"))
)py";

TEST_F(Blend, WhatRendersHideAndOtherShapesAreLeftOutAndTold) {
  SKIP_WITHOUT_BLENDER();
  run(kHiding);
  testing::internal::CaptureStderr();
  const auto nodes = nodesOf(readAsset(folder_.path() / "hidden.blend", {}));
  std::string told = testing::internal::GetCapturedStderr();
  EXPECT_EQ(nodes.size(), 2u);
  EXPECT_EQ(nodes.at("shown").size(), 1u);
  EXPECT_EQ(nodes.at("leaf").size(), 8u);
  const std::map<std::string, int> expected{{"missing libraries, with all that is linked from them", 1},
                                            {"objects of other scenes", 1},
                                            {"objects that the viewport or renders hide", 4},
                                            {"objects without faces, such as edges and thin curves", 1},
                                            {"opacities of materials whose blend mode is opaque", 1},
                                            {"particle systems of hair, lines or halos", 1},
                                            {"volumes", 1}};
  for (const auto& [what, count] : expected) {
    EXPECT_THAT(told, HasSubstr(std::to_string(count) + " " + what));
  }
}

// Makes looks.blend: a square for each material, and objects that renders show otherwise than the viewport.
constexpr const char* kLooks = R"py(

def image(name):
    made = bpy.data.images.new(name, 2, 2, alpha=True)
    made.pixels = [0.5, 0.5, 0.5, 1] * 2 + [0.5, 0.5, 0.5, 0] * 2
    made.filepath_raw = os.path.join(folder, name + ".png")
    made.file_format = "PNG"
    made.save()
    return made


def on_square(name):
    made, tree, shader = material(name)
    made.diffuse_color = (0.1, 0.1, 0.1, 1)
    made.blend_method = "CLIP"
    put(name, square(name, made))
    return made, tree, shader


def node(tree, kind, into=None, **settings):
    made = tree.nodes.new("ShaderNode" + kind)
    for key, value in settings.items():
        setattr(made, key, value)
    if into is not None:
        tree.links.new(made.outputs[0], into)
    return made


def textured(name, picture):
    made, tree, shader = on_square(name)
    texture = node(tree, "TexImage", shader.inputs["Base Color"], image=picture)
    tree.links.new(texture.outputs["Alpha"], shader.inputs["Alpha"])
    return tree, shader, texture


half = image("half")
half.pack()
solid = half.copy()
solid.alpha_mode = "NONE"

green, _, _ = on_square("of the object")
put("slot", bpy.data.objects["of the object"].data.copy())
slot = bpy.data.objects["slot"].material_slots[0]
slot.link = "OBJECT"
slot.material = on_square("other")[0]
slot.material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.25, 0.25, 0.25, 1)

_, tree, shader = on_square("diffuse")
tree.nodes.remove(shader)
node(tree, "BsdfDiffuse", tree.nodes["Material Output"].inputs[0]).inputs[0].default_value = (0.5, 0.5, 0.5, 1)
_, tree, shader = on_square("mixed")
tree.nodes.remove(shader)
mix = node(tree, "MixShader", tree.nodes["Material Output"].inputs[0])
tree.links.new(node(tree, "TexImage", image=half).outputs["Alpha"], mix.inputs[0])
node(tree, "BsdfTransparent", mix.inputs[1])
node(tree, "Emission", mix.inputs[2])
_, tree, shader = on_square("clear behind")
mix = node(tree, "MixShader", tree.nodes["Material Output"].inputs[0])
tree.links.new(node(tree, "TexImage", image=half).outputs["Alpha"], mix.inputs[0])
tree.links.new(shader.outputs[0], mix.inputs[1])
node(tree, "BsdfTransparent", mix.inputs[2])
textured("solid", solid)
tree, shader, texture = textured("tinted", half)
mix = node(tree, "MixRGB", shader.inputs["Base Color"], blend_type="MULTIPLY")
mix.inputs[0].default_value = 0.5
mix.inputs[2].default_value = (0.2, 0.2, 0.2, 1)
tree.links.new(texture.outputs[0], mix.inputs[1])
tree, shader, texture = textured("compared", half)
more = node(tree, "Math", shader.inputs["Alpha"], operation="GREATER_THAN")
tree.links.new(texture.outputs["Alpha"], more.inputs[0])
more.inputs[1].default_value = 0.75
tree, shader, texture = textured("below", half)
more = node(tree, "Math", shader.inputs["Alpha"], operation="LESS_THAN")
tree.links.new(texture.outputs["Alpha"], more.inputs[0])
more.inputs[1].default_value = 0.75
_, tree, shader = on_square("checker")
node(tree, "TexChecker", shader.inputs["Base Color"])
tree, shader, texture = textured("inverted", half)
rest = node(tree, "Math", shader.inputs["Alpha"], operation="SUBTRACT")
rest.inputs[0].default_value = 1
tree.links.new(texture.outputs["Alpha"], rest.inputs[1])
tree, shader, texture = textured("sheared", half)
turned = node(tree, "Mapping", texture.inputs["Vector"], vector_type="TEXTURE")
turned.inputs["Rotation"].default_value[2] = 0.5
turned.inputs["Scale"].default_value[0] = 2
node(tree, "UVMap", turned.inputs["Vector"])
for name in ("moved", "lost"):
    textured(name, image(name))
os.mkdir(os.path.join(folder, "textures"))

cube = box("cube")
put("twice", cube).modifiers.new("array", "ARRAY").show_viewport = False
put("once", cube).modifiers.new("array", "ARRAY").show_render = False
scene.render.use_simplify = True
scene.render.simplify_subdivision = 0
scene.render.simplify_subdivision_render = 1
fine = put("fine", cube).modifiers.new("fine", "SUBSURF")
fine.levels, fine.render_levels = 0, 2
emitter = put("emitter", cube.copy())
particles = emitter.modifiers.new("particles", "PARTICLE_SYSTEM").particle_system.settings
particles.type, particles.render_type, particles.instance_object = "HAIR", "OBJECT", put("particle", cube)
particles.count, particles.display_percentage = 20, 10
group, (given, out, clear, viewport) = geometry_nodes(("GeometryNodeDeleteGeometry", "GeometryNodeIsViewport"))
group.links.new(given.outputs[0], clear.inputs["Geometry"])
group.links.new(viewport.outputs[0], clear.inputs["Selection"])
group.links.new(clear.outputs[0], out.inputs[0])
by_nodes = put("by nodes", cube)
by_nodes.modifiers.new("nodes", "NODES").node_group = group
by_nodes.keyframe_insert("location")
save("looks.blend")
os.remove(os.path.join(folder, "lost.png"))
os.rename(os.path.join(folder, "moved.png"), os.path.join(folder, "textures", "moved.png"))
)py";

TEST_F(Blend, MaterialsAndTheEvaluationAreThoseOfRenders) {
  SKIP_WITHOUT_BLENDER();
  run(kLooks);
  testing::internal::CaptureStderr();
  const Asset asset = readAsset(folder_.path() / "looks.blend", {});
  const std::string told = testing::internal::GetCapturedStderr();
  const auto partOf = [&](const char* node) {
    return *std::find_if(asset.parts.begin(), asset.parts.end(), [&](const AssetPart& p) { return p.node == node; });
  };
  EXPECT_EQ(partOf("slot").material, "other");
  EXPECT_NEAR(partOf("slot").fileMaterial.reflectance, 0.25, 1e-4);
  EXPECT_NEAR(partOf("diffuse").fileMaterial.reflectance, 0.5, 1e-4);
  EXPECT_EQ(partOf("diffuse").fileMaterial.metallic, 0);
  EXPECT_EQ(partOf("diffuse").fileMaterial.roughness, 1);
  EXPECT_NEAR(partOf("checker").fileMaterial.reflectance, 0.1, 1e-4) << "the colour of the viewport";
  EXPECT_TRUE(partOf("mixed").fileMaterial.alphaTested);
  EXPECT_FALSE(partOf("solid").fileMaterial.alphaTested);
  EXPECT_NEAR(partOf("tinted").color[0], 0.5 + 0.5 * 0.2, 1e-4);
  EXPECT_TRUE(partOf("tinted").fileMaterial.texture);
  EXPECT_TRUE(partOf("compared").fileMaterial.alphaTested);
  EXPECT_NEAR(partOf("compared").fileMaterial.alphaCutoff, 0.75, 1e-6);
  // Their lower half is transparent where the image's is not.
  for (const char* node : {"mixed", "inverted", "clear behind", "below"}) {
    const Material made = partOf(node).fileMaterial;
    ASSERT_TRUE(made.alphaTested && made.texture) << node;
    const bool above = std::string_view(node) == "mixed";
    EXPECT_EQ(made.texture->texel(0.5f, 0.25f)[3], above ? 255 : 0) << node;
    EXPECT_EQ(made.texture->texel(0.5f, 0.75f)[3], above ? 0 : 255) << node;
    EXPECT_NEAR(made.alphaCutoff, std::string_view(node) == "below" ? 0.25 : 0.5, 1e-6) << node;
  }
  EXPECT_EQ(partOf("inverted").fileMaterial.texture->texel(0.5f, 0.25f)[0], 128) << "the colour is not inverted";
  for (const char* node : {"mixed", "clear behind"}) {
    EXPECT_EQ(partOf(node).fileMaterial.texture->texel(0.5f, 0.25f)[0], 255)
        << node << ": the image gives the alpha alone";
  }
  EXPECT_TRUE(partOf("moved").fileMaterial.alphaTested) << "found in the folder textures";
  EXPECT_FALSE(partOf("lost").fileMaterial.texture);

  const auto nodes = nodesOf(asset);
  EXPECT_EQ(nodes.at("twice").at(0).triangles, 24u);
  EXPECT_EQ(nodes.at("once").at(0).triangles, 12u);
  EXPECT_EQ(nodes.at("fine").at(0).triangles, 48u) << "one level, as Simplify has for renders";
  EXPECT_EQ(nodes.at("particle").size(), 21u);
  EXPECT_EQ(nodes.at("by nodes").at(0).triangles, 12u) << "not deleted, as in the viewport";

  for (const char* what : {"1 animations (the saved or first frame counts)",
                           "2 materials with nodes that are not read (colour and alpha may differ)",
                           "missing textures: 'lost.png'; plain colours replace them"}) {
    EXPECT_THAT(told, HasSubstr(what));
  }
}

// Makes files of other programs: the triangle of tests as "wing", beside others, and levels of detail.
constexpr const char* kImports = R"py(
from io_scene_fbx import encode_bin

wing = mesh("wing", [(1, 0, 0), (0, 2, 0), (0, 0, 3)], [(0, 1, 2)])
wing.materials.append(material("paint", (0.5, 0.5, 0.5))[0])
for name in ("wing", "moving", "levels", "levels_1", "levels_0"):
    put(name, None if name == "levels" else wing, parent=bpy.data.objects["levels"] if "_" in name else None)
bpy.data.objects["moving"].keyframe_insert("location", frame=1)
write = encode_bin.FBXElem.add_string
encode_bin.FBXElem.add_string = lambda element, text: write(
    element, b"LodGroup" if element.id == b"Model" and text == b"Null" else text)
bpy.ops.export_scene.fbx(filepath=os.path.join(folder, "y.fbx"), axis_forward="-Z", axis_up="Y")
bpy.ops.export_scene.fbx(filepath=os.path.join(folder, "z.fbx"), axis_forward="Y", axis_up="Z")
)py";

// The triangle in X3D, which is y up and in metres.
constexpr const char* kX3d = R"(<?xml version="1.0"?><X3D version="3.0"><Scene><Transform translation="0 0 5"><Shape>
<Appearance><Material diffuseColor="0.5 0.5 0.5"/></Appearance><IndexedFaceSet coordIndex="0 1 2 -1">
<Coordinate point="1 0 0 0 2 0 0 0 3"/></IndexedFaceSet></Shape></Transform><Inline url="other.x3d"/></Scene></X3D>)";

TEST_F(Blend, FilesThatBlenderImportsStandUprightInMetres) {
  SKIP_WITHOUT_BLENDER();
  run(kImports);
  for (const char* name : {"y.fbx", "z.fbx"}) {
    testing::internal::CaptureStderr();
    const Asset asset = readAsset(folder_.path() / name, {.metresPerUnit = 2});
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("left out: 1 animations (the saved or first frame"));
    const auto nodes = nodesOf(asset);
    EXPECT_EQ(nodes.size(), 3u) << name;
    EXPECT_FALSE(nodes.contains("levels_1")) << "a coarser level of detail";
    expectBounds(nodes.at("wing").at(0), {0, 0, 0}, {2, 4, 6});
    EXPECT_EQ(nodes.at("wing")[0].materials, std::vector<std::string>{"paint"});
    EXPECT_NEAR(asset.parts[0].fileMaterial.reflectance, 0.5, 1e-4) << name;
  }
  testing::internal::CaptureStderr();
  const Asset asset = readAsset(folder_.write("a.x3d", kX3d), {});
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("a.x3d: left out: 1 files that Inline names"));
  ASSERT_EQ(asset.parts.size(), 1u);
  expectBounds(nodesOf(asset).begin()->second.at(0), {0, -8, 0}, {1, -5, 2});
}

// Debian's Blender has no importers of Alembic and USD.
TEST_F(Blend, ImportersThatBlenderLacksAreNamed) {
  SKIP_WITHOUT_BLENDER();
  for (const char* kind : {".abc", ".usda"}) {
    const std::string message =
        messageOf<InputError>([&] { readAsset(folder_.write(std::string("a") + kind, "no scene"), {}); });
    EXPECT_THAT(message, testing::AllOf(HasSubstr(std::string("a") + kind + ": Blender"),
                                        testing::AnyOf(HasSubstr("set SCANMILL_BLENDER"), HasSubstr("cannot import"))));
  }
  const auto ascii = folder_.write("a.fbx", "; FBX 7.4.0 project file\nFBXHeaderExtension: {\n}\n");
  EXPECT_THAT(messageOf<InputError>([&] { readAsset(ascii, {}); }), HasSubstr("; save it as binary FBX"));
}

TEST_F(Blend, BadFilesAreNamed) {
  SKIP_WITHOUT_BLENDER();
  make();
  const auto refuse = [&](const std::filesystem::path& file, std::vector<std::string> words) {
    words.push_back(file.string());
    expectInputError([&] { readAsset(file, {}); }, words);
  };
  refuse(folder_.path() / "empty.blend", {"shows no surface"});
  const std::string bytes = readFile(made_);
  refuse(folder_.write("cut.blend", bytes.substr(0, bytes.size() / 2)), {"cannot open it"});
  std::string newer = bytes;
  ASSERT_EQ(newer.substr(0, 7), "BLENDER");
  newer.replace(9, 3, "799");
  refuse(folder_.write("newer.blend", newer), {"saved by Blender 7.99", "SCANMILL_BLENDER", "GLB"});
  refuse(folder_.write("noise.blend", "BLENDER-v304" + std::string(5000, '\x07')), {"cannot open it"});
  refuse(folder_.write("text.blend", "import os"), {"cannot open it"});
  EXPECT_FALSE(ran("ran_text"));
  EXPECT_FALSE(ran("ran_driver"));
}

// Without starting Blender.
TEST_F(Blend, OtherFilesAreNotGivenToBlender) {
  const ScopedVariable named("SCANMILL_BLENDER", "/no/such/blender");
  expectInputError([&] { readAsset(folder_.write("none.blend", ""), {}); }, {"none.blend", "empty"});
  expectInputError([&] { readAsset(folder_.write("old.blend1", "BLENDER-v304"), {}); }, {"rename it to .blend"});
  expectInputError([&] { readAsset(folder_.path() / "absent.blend", {}); }, {"absent.blend"});
  expectInputError([&] { readAsset(folder_.write("a.usdc", "x"), {.up = 'z'}); }, {"a.usdc", "leave out `up`"});
  const auto whole = folder_.write("whole.blend", "BLENDER-v304");
  EXPECT_THAT(messageOf<Error>([&] { readAsset(whole, {}); }),
              testing::AllOf(HasSubstr("whole.blend"), HasSubstr("/no/such/blender")));
  const ScopedVariable unset("SCANMILL_BLENDER", "");
  const ScopedVariable path("PATH", "/no/such/folder");
  EXPECT_THAT(messageOf<Error>([&] { readAsset(whole, {}); }), HasSubstr("apt-get install blender"));
}

TEST_F(Blend, TimeOutAndCrashNameTheFile) {
  const auto whole = folder_.write("whole.blend", "BLENDER-v304");
  const auto program = folder_.write("blender.sh", "#!/bin/sh\necho working >&2\nsleep 1000\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const ScopedVariable named("SCANMILL_BLENDER", program.string());
  const ScopedVariable patience("SCANMILL_BLENDER_SECONDS", "0.3");
  expectInputError([&] { readAsset(whole, {}); }, {"whole.blend", "0.3 s", "working"});
  folder_.write("blender.sh", "#!/bin/sh\necho 'Segmentation of things' >&2\nkill -SEGV $$\n");
  expectInputError([&] { readAsset(whole, {}); }, {"whole.blend", "signal 11", "Segmentation of things"});
}

TEST(BlendReal, ThirdPartyFilesHaveTriangles) {
  SKIP_WITHOUT_BLENDER();
  SKIP_WITHOUT_SHARED_DATA("scenes/blender");
  const auto folder = sharedData() / "scenes" / "blender";
  const auto glass = nodesOf(readAsset(folder / "glass.blend", {}));
  EXPECT_EQ(glass.size(), 2u) << "the bare edges of the file show no surface";
  EXPECT_EQ(glass.at("glass").at(0).triangles, 12u);
  EXPECT_EQ(glass.at("target").at(0).materials, std::vector<std::string>{"Material.005"});
  const auto mirror = nodesOf(readAsset(folder / "mirror.blend", {}));
  EXPECT_EQ(mirror.size(), 4u);
  EXPECT_TRUE(mirror.contains("Plane2"));
  const auto textured = nodesOf(readAsset(folder / "texture_usage.blend", {}));
  EXPECT_EQ(textured.at("Plane").at(0).triangles, 8u);
  EXPECT_EQ(textured.at("Plane").at(0).materials.size(), 2u);
}

}  // namespace
}  // namespace scanmill
