#include <set>

#include "images/images.h"
#include "scene/scene.h"
#include "scenefile/file_objects.h"
#include "scenefile/scene_file.h"
#include "tests/core/assets/meshes/gltf/gltf_builder.h"
#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

// A post at the origin, and three panes along x that share a mesh.
std::string fence() {
  GltfBuilder b;
  const std::size_t positions = b.numbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  const std::size_t places = b.numbers<float>({1, 0, 0, 2, 0, 0, 3, 0, 0}, "VEC3", 3);
  b.json["scenes"] = {{{"nodes", {0, 1}}}};
  b.json["nodes"] = {{{"name", "post"}, {"mesh", 0}},
                     {{"name", "pane"},
                      {"mesh", 0},
                      {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}}};
  b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}}}}}};
  return b.text();
}

Scene sceneOf(const TemporaryFolder& folder, const std::string& keys) {
  folder.write("fence.gltf", fence());
  return readScene(folder.write("scene.yaml", sceneYaml("  - {file: fence.gltf, " + keys + "}\n")), {});
}

TEST(FileMeshes, CopiesThatTheFileMakesShareTheirMesh) {
  TemporaryFolder folder;
  const Scene scene = sceneOf(folder, "up: z, position: [0, 7, 0], yaw_deg: 90, class: car");
  EXPECT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.placedTriangles(), 4u);
  EXPECT_EQ(scene.things(), 4u) << "each copy is a thing";
  std::set<std::string> names;
  for (std::size_t i = 0; i < 4; ++i) {
    names.insert(scene.instances[i].name);
    const Vec3d at = scene.instances[i].worldFromMesh * Vec3d{0, 0, 0};
    EXPECT_LT(length(at - Vec3d{0, 7 + static_cast<double>(i), 0}), 1e-9) << i;
  }
  EXPECT_EQ(names, (std::set<std::string>{"fence", "fence/pane 1", "fence/pane 2", "fence/pane 3"}));
}

// The image lies in a folder that the object names, and beside one of two links to a file.
TEST(FileMeshes, TexturesAreFoundInNamedFoldersAndBesideLinks) {
  TemporaryFolder folder;
  const std::string image = encodePng(std::vector<std::uint8_t>(3, 9).data(), 1, 1);
  for (const char* const name : {"images/a.png", "links/a.png"}) folder.write(name, image);
  folder.write("a.mtl", "newmtl m\nmap_Kd a.png\n");
  folder.write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n");
  for (const char* const name : {"a.obj", "a.mtl"}) {
    std::filesystem::create_symlink(folder.path() / name, folder.path() / "links" / name);
  }
  const auto textured = [&](const std::string& objects) {
    const Scene scene = readScene(folder.write("scene.yaml", sceneYaml(objects)), {});
    std::vector<bool> found;
    for (const Mesh& mesh : scene.meshes) found.push_back(scene.materials[mesh.surfaces[0].material].textured);
    return found;
  };
  EXPECT_EQ(textured("  - {file: a.obj}\n  - {file: links/a.obj}\n"), (std::vector{false, true}));
  EXPECT_EQ(textured("  - {file: a.obj, textures: [images]}\n  - {file: a.obj}\n"), (std::vector{true, false}));
  expectInputError([&] { textured("  - {file: a.obj, textures: [none]}\n"); }, {"scene.yaml:", "none", "is no folder"});
}

TEST(FileMeshes, RulesReachThem) {
  TemporaryFolder folder;
  const Scene scene = sceneOf(
      folder, "copies: {grid: {count: [2, 1, 1], spacing: [50, 0, 0]}}, rules: [{match: {node: pane}, class: fence}]");
  EXPECT_EQ(scene.instances.size(), 8u);
  EXPECT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.unlabeled.size(), 1u);
  EXPECT_EQ(scene.unlabeled.begin()->second, 1u) << "the post, once for its mesh";
}

// A box is where things are in the file, copies too: the pane at x = 2 to 3 alone is in it.
TEST(FileMeshes, WhereCopiesAreCounts) {
  TemporaryFolder folder;
  const Scene scene =
      sceneOf(folder, "up: z, rules: [{match: {box: [[2, 0, 0], [3, 1, 0]]}, class: car}, {match: any, class: fence}]");
  EXPECT_EQ(trianglesByClass(scene), (std::map<std::string, std::uint64_t>{{"car", 1}, {"fence", 3}}));
}

// Boxes that differ beyond the sixth digit are other boxes.
TEST(FileMeshes, RulesThatDifferALittleAreNotShared) {
  TemporaryFolder folder;
  folder.write("far.obj", "o a\nv 400000 0 0\nv 400001 0 0\nv 400000 1 0\nf 1 2 3\n");
  const auto object = [](const std::string& x) {
    return "  - {file: far.obj, rules: [{match: {box: [[400000, -1, -1], [" + x + ", 9, 9]]}, class: car}]}\n";
  };
  const Scene scene = readScene(folder.write("scene.yaml", sceneYaml(object("400000.2") + object("400000.4"))), {});
  EXPECT_EQ(scene.things(), 1u);
}

}  // namespace
}  // namespace scanmill
