// readScene as a whole: objects, copies, labels, instance ids, bad input.

#include "scenefile/scene_file.h"

#include <map>
#include <set>

#include "base/memory.h"
#include "scene/scene.h"
#include "scenefile/object_placer.h"
#include "tests/core/assets/meshes/gltf/gltf_builder.h"
#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

const std::filesystem::path kSource = SCANMILL_SOURCE_DIR;

// Two objects with a material each; the second has two triangles.
constexpr const char* kPair =
    "mtllib pair.mtl\n"
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\nv 1 0 2\nv 0 1 2\nv 1 1 2\n"
    "o House1\nusemtl stone\nf 1 2 3\n"
    "o House2\nusemtl timber\nf 4 5 6\nf 5 7 6\n";
constexpr const char* kPairMaterials = "newmtl stone\nKd 0.5 0.5 0.5\nnewmtl timber\nKd 0.4 0.2 0.1\n";

class SceneReader : public testing::Test {
 protected:
  SceneReader() {
    folder_.write("pair.obj", kPair);
    folder_.write("pair.mtl", kPairMaterials);
    // A triangle with a picture of 2 x 1 texels: white and black.
    folder_.write("bw.ppm", std::string("P6 2 1 255\n\xff\xff\xff\0\0\0", 17));
    folder_.write("textured.mtl", "newmtl own\nKd 1 1 1\nmap_Kd bw.ppm\n");
    folder_.write(
        "textured.obj",
        "mtllib textured.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl own\nf 1/1 2/2 3/3\n");
  }

  // A scene with our labels; `objects` is the YAML of the list, `more` that of other top-level keys.
  std::filesystem::path write(const std::string& objects, const std::string& more = "") {
    return folder_.write("scene.yaml", sceneYaml(objects, more));
  }
  Scene read(const std::string& objects, const std::string& more = "", const SceneOptions& options = {}) {
    return readScene(write(objects, more), options);
  }
  void refuse(const std::string& objects, const std::vector<std::string>& words, const std::string& more = "") {
    SCOPED_TRACE(more + objects);
    const auto file = write(objects, more);
    expectInputError([&] { readScene(file, {}); }, words);
  }

  TemporaryFolder folder_;
};

// A world goes on without what it lacks if the scene says so.
TEST_F(SceneReader, missingModelsOfAWorldMayBeLeftOut) {
  folder_.write(
      "w.sdf",
      "<sdf version=\"1.6\"><world name=\"w\"><include><uri>model://gone</uri></include><model name=\"m\"><link "
      "name=\"l\"><visual name=\"v\"><geometry><box><size>1 1 1</size></box></geometry></visual></link></model>"
      "</world></sdf>");
  const std::string world = "  - {file: w.sdf, class: object, material: wood";
  refuse(world + "}\n", {"scene.yaml:", "model://gone", "missing: leave_out"});
  EXPECT_EQ(read(world + ", missing: leave_out}\n").instances.size(), 1u);
  refuse(world + ", missing: ignore}\n", {"refuse, leave_out"});
}

const std::string kBox = "  - {primitive: box, size: [1, 1, 1], class: car, material: car_paint";

TEST_F(SceneReader, primitivesStandWhereTheyAreSaidTo) {
  const Scene scene = read(
      "  - {name: floor, primitive: plane, size: [10, 20], cells: 2, class: ground, material: soil}\n"
      "  - {primitive: sphere, radius: 2, class: object, material: wood, position: [1, 2, 3]}\n"
      "  - {primitive: cylinder, radius: 1, height: 4, class: pole, material: wood, pitch_deg: 90}\n"
      "  - {primitive: cone, radius: 1, height: 4, class: object, material: wood}\n"
      "  - {primitive: capsule, radius: 1, height: 4, class: pedestrian, material: cloth, scale: [1, 1, 2]}\n"
      "  - {primitive: box, size: [2, 4, 6], class: building, material: brick, yaw_deg: 90, scale: 2}\n");
  ASSERT_EQ(scene.instances.size(), 6u);
  EXPECT_EQ(scene.instances[0].name, "floor");
  EXPECT_EQ(scene.instances[1].name, "sphere");
  EXPECT_EQ(scene.meshes[0].triangles.size(), 8u);
  EXPECT_EQ(scene.things(), 5u);
  EXPECT_EQ(scene.dropped.total(), 0u);
  EXPECT_TRUE(scene.unlabeled.empty());
  const auto boundsOf = [&](std::size_t i) {
    Scene one;
    one.meshes = scene.meshes;
    one.instances = {scene.instances[i]};
    return one.bounds();
  };
  const auto expectBox = [](const Box& box, const Vec3d& low, const Vec3d& high) {
    EXPECT_NEAR(length(box.low - low), 0, 1e-6);
    EXPECT_NEAR(length(box.high - high), 0, 1e-6);
  };
  expectBox(boundsOf(0), {-5, -10, 0}, {5, 10, 0});
  expectBox(boundsOf(1), {-1, 0, 1}, {3, 4, 5});
  expectBox(boundsOf(2), {-2, -1, -1}, {2, 1, 1});
  expectBox(boundsOf(4), {-1, -1, -6}, {1, 1, 6});
  expectBox(boundsOf(5), {-4, -2, -6}, {4, 2, 6});
}

TEST_F(SceneReader, gridStartsAtTheObjectAndRunsXFirst) {
  const Scene scene = read(kBox +
                           ", position: [10, 0, 0], yaw_deg: 90, scale: 3, copies: {grid: {count: [2, 3, 1], "
                           "spacing: [5, 7, 0]}}}\n");
  ASSERT_EQ(scene.instances.size(), 6u);
  EXPECT_EQ(scene.meshes.size(), 1u);
  for (std::size_t k = 0; k < 6; ++k) {
    const double i = double(k % 2);
    const double j = double(k / 2);
    // The grid turns with the object (x becomes y, y becomes -x) but does not grow with it.
    EXPECT_NEAR(length(scene.instances[k].worldFromMesh.translation - Vec3d{10 - 7 * j, 5 * i, 0}), 0, 1e-12);
    EXPECT_NEAR(determinant(scene.instances[k].worldFromMesh.linear), 27, 1e-9);
    EXPECT_EQ(scene.instances[k].firstInstanceId, k + 1);
  }
  EXPECT_EQ(scene.instances[0].name, "box#1");
}

TEST_F(SceneReader, listedCopiesStandInTheFrameOfTheObject) {
  const Scene scene = read(kBox +
                           ", position: [0, 0, 1], scale: 2, copies: {at: [{position: [1, 2, 3]}, "
                           "{position: [4, 0, 0], yaw_deg: 90, scale: [1, 1, 5]}], grid: {count: [1, 1, 2], spacing: "
                           "[0, 0, 100]}}}\n");
  ASSERT_EQ(scene.instances.size(), 4u);
  const auto at = [&](std::size_t i) { return scene.instances[i].worldFromMesh; };
  EXPECT_NEAR(length(at(0).translation - Vec3d{1, 2, 4}), 0, 1e-12);
  EXPECT_NEAR(length(at(1).translation - Vec3d{4, 0, 1}), 0, 1e-12);
  EXPECT_NEAR(length(at(1).linear.x - Vec3d{0, 2, 0}), 0, 1e-12);
  EXPECT_NEAR(length(at(1).linear.z - Vec3d{0, 0, 10}), 0, 1e-12);
  EXPECT_NEAR(length(at(2).translation - Vec3d{1, 2, 104}), 0, 1e-12);
}

TEST_F(SceneReader, equalImportsShareAMeshAndOthersDoNot) {
  const Scene scene = read(
      "  - {file: pair.obj, class: car}\n"
      "  - {file: ./pair.obj, class: car, position: [9, 0, 0]}\n"
      "  - {file: pair.obj, class: car, position: [5, 0, 0]}\n"
      "  - {file: pair.obj, class: bus}\n"
      "  - {file: pair.obj, class: car, unit: 2}\n"
      "  - {file: pair.obj, class: car, up: y}\n"
      "  - {file: pair.obj, class: car, instances: node}\n" +
      kBox + "}\n" + kBox + ", name: other}\n");
  std::vector<std::uint32_t> meshes;
  for (const Instance& i : scene.instances) meshes.push_back(i.mesh);
  // Two spellings of a file are two names to `file` patterns.
  EXPECT_EQ(meshes, (std::vector<std::uint32_t>{0, 1, 0, 2, 3, 4, 5, 6, 6}));
}

TEST_F(SceneReader, unitAndUpAxisApply) {
  const Scene scene = read("  - {file: pair.obj, class: car, unit: 0.5, up: y}\n");
  // (x, y, z) -> (x, -z, y), halved.
  EXPECT_EQ(scene.bounds().low, (Vec3d{0, -1, 0}));
  EXPECT_EQ(scene.bounds().high, (Vec3d{0.5, 0, 0.5}));
}

TEST_F(SceneReader, objectRulesGoBeforeShorthandBeforeSceneRules) {
  const std::string sceneRules =
      "rules:\n"
      "  - {match: {material: stone}, class: wall, material: concrete}\n"
      "  - {match: any, class: structure, material: plaster}\n";
  const auto names = [&](const std::string& object) {
    const Scene scene = read(object, sceneRules);
    std::map<std::string, std::string> result;
    for (const Surface& s : scene.meshes[0].surfaces) {
      result[s.node] = scene.ontology.find(s.semantic)->name + "/" + scene.materials[s.material].name;
    }
    return result;
  };
  using Expected = std::map<std::string, std::string>;
  EXPECT_EQ(names("  - {file: pair.obj}\n"), (Expected{{"House1", "wall/concrete"}, {"House2", "structure/plaster"}}));
  EXPECT_EQ(names("  - {file: pair.obj, class: fence}\n"),
            (Expected{{"House1", "fence/concrete"}, {"House2", "fence/plaster"}}));
  EXPECT_EQ(names("  - {file: pair.obj, class: fence, rules: [{match: {node: House2}, class: building}]}\n"),
            (Expected{{"House1", "fence/concrete"}, {"House2", "building/plaster"}}));
  EXPECT_EQ(names("  - {file: pair.obj, material: wood, rules: [{match: {file: pair.obj}, class: house}]}\n"),
            (Expected{{"House1", "building/wood"}, {"House2", "building/wood"}}));
}

TEST_F(SceneReader, whatNoRuleMatchesIsUnlabeledAndCounted) {
  const Scene scene = read("  - {file: pair.obj, rules: [{match: {node: House1}, class: building}]}\n");
  EXPECT_EQ(scene.unlabeled, (std::map<UnlabeledPart, std::uint64_t>{{{"pair.obj", "timber", "", "House2"}, 2}}));
  const Surface& left = scene.meshes[0].surfaces[scene.meshes[0].surfaceOf.back()];
  EXPECT_EQ(left.semantic, 0);
  EXPECT_EQ(left.object, 0u);
  EXPECT_EQ(scene.materials[left.material].name, "timber");  // its own material
}

TEST_F(SceneReader, instancesAreTheAssetOrItsNodes) {
  const auto objects = [&](const std::string& mode) {
    const Scene scene = read("  - {file: pair.obj, class: building, instances: " + mode + "}\n" +
                             "  - {file: pair.obj, class: building, instances: " + mode + "}\n");
    std::vector<std::uint32_t> ids;
    for (const Instance& i : scene.instances) {
      for (const Surface& s : scene.meshes[i.mesh].surfaces) ids.push_back(instanceId(i, s));
    }
    return ids;
  };
  EXPECT_EQ(objects("object"), (std::vector<std::uint32_t>{1, 1, 2, 2}));
  EXPECT_EQ(objects("node"), (std::vector<std::uint32_t>{1, 2, 3, 4}));
  const Scene mixed =
      read("  - {file: pair.obj, instances: node, class: car, rules: [{match: {node: House1}, class: road}]}\n");
  EXPECT_EQ(mixed.meshes[0].surfaces[0].object, 0u);
  EXPECT_EQ(mixed.meshes[0].surfaces[1].object, 1u);
  EXPECT_EQ(mixed.things(), 1u);
}

TEST_F(SceneReader, optionsOverrideOntologyAndWavelength) {
  SceneOptions options;
  options.ontology = kSource / "labels/semantic_kitti.yaml";
  options.wavelengthNm = 1064;
  options.seed = 42;
  const Scene scene =
      read("  - {primitive: box, size: [1, 1, 1], class: pedestrian, material: snow}\n", "name: other\n", options);
  EXPECT_EQ(scene.name, "other");
  EXPECT_EQ(scene.seed, 42u);
  EXPECT_EQ(scene.ontology.name, "semantic_kitti");
  EXPECT_EQ(scene.meshes[0].surfaces[0].semantic, 30);
  EXPECT_FLOAT_EQ(scene.materials[scene.meshes[0].surfaces[0].material].reflectance, 0.829f);
}

TEST_F(SceneReader, rulesDecideWhetherBaseColoursAreRead) {
  const auto materialOf = [](const Scene& scene) { return scene.materials[scene.meshes[0].surfaces[0].material]; };
  const Scene own = read("  - {file: textured.obj, class: car, rules: [{match: {node: absent}, material: wood}]}\n");
  EXPECT_NE(materialOf(own).texture, nullptr);
  EXPECT_EQ(own.meshes[0].uvs.size(), own.meshes[0].positions.size());
  const Scene ruled = read("  - {file: textured.obj, class: car, material: wood}\n");
  EXPECT_EQ(materialOf(ruled).texture, nullptr);
  EXPECT_TRUE(ruled.meshes[0].uvs.empty());
  EXPECT_EQ(materialOf(ruled).name, "wood");
  SceneOptions plain;
  plain.textures = false;
  EXPECT_EQ(materialOf(read("  - {file: textured.obj, class: car}\n", "", plain)).texture, nullptr);
  folder_.write("textured.mtl", "newmtl own\nKd 1 1 1\nmap_d bw.ppm\n");
  const Scene cut = read("  - {file: textured.obj, class: car, material: wood}\n");
  EXPECT_TRUE(materialOf(cut).alphaTested);
  ASSERT_NE(materialOf(cut).texture, nullptr) << "for what is cut out, whatever its reflectance";
  EXPECT_EQ(materialOf(cut).reflectance, materialOf(ruled).reflectance);
}

// In a table of its own, wood may be textured: then it takes the picture's pattern and keeps its own reflectance.
TEST_F(SceneReader, aTexturedMaterialTakesThePictureOfTheAsset) {
  folder_.write("table.yaml", "materials: [{name: wood, reflectance: 0.6, source: test, textured: true}]\n");
  const auto file = folder_.write("scene.yaml", "ontology: " + (kSource / "labels/scanmill.yaml").string() +
                                                    "\nmaterials: table.yaml\nobjects:\n"
                                                    "  - {file: textured.obj, class: car, material: wood}\n"
                                                    "  - {file: pair.obj, class: car, material: wood}\n");
  const Scene scene = readScene(file, {});
  const Material& wood = scene.materials[scene.meshes[0].surfaces[0].material];
  EXPECT_TRUE(wood.textured);
  EXPECT_NE(wood.texture, nullptr);
  EXPECT_FLOAT_EQ(wood.reflectance, 0.6f);
  EXPECT_NEAR(wood.textureMean, 0.5, 1e-6);
  EXPECT_FALSE(scene.materials[scene.meshes[1].surfaces[0].material].textured);  // has no picture
}

TEST_F(SceneReader, assetsKeyIsWhereFilesStart) {
  folder_.write("models/deep/tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Scene scene = read("  - {file: deep/tri.obj, class: car}\n", "assets: models\n");
  EXPECT_EQ(scene.triangles(), 1u);
  EXPECT_EQ(scene.instances[0].name, "tri");
}

// A triangle that rises by 2 m within half a second.
std::string risingGltf() {
  GltfBuilder b;
  const std::size_t positions = b.numbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  const std::size_t times = b.numbers<float>({0, 0.5f}, "SCALAR", 1);
  const std::size_t places = b.numbers<float>({0, 0, 0, 0, 2, 0}, "VEC3", 3);
  b.json["scenes"] = {{{"nodes", {0}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}}}}}};
  b.json["animations"] = {{{"name", "rise"},
                           {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                           {"samplers", {{{"input", times}, {"output", places}}}}}};
  return b.text();
}

TEST_F(SceneReader, AnAnimationPlaysOverAndOverOrStands) {
  folder_.write("rise.gltf", risingGltf());
  const auto heightOf = [](const Scene& scene, std::uint32_t mesh) { return scene.meshes[mesh].bounds().low.z; };
  const Scene plays = read(
      "  - {file: rise.gltf, class: car, animation: {clip: rise}, copies: {grid: {count: [2, 1, 1], spacing: [3, 0, "
      "0]}}}\n");
  ASSERT_EQ(plays.instances.size(), 2u);
  EXPECT_TRUE(plays.moves());
  for (const Instance& i : plays.instances) {
    for (const double time : {0.0, 0.13, 0.26, 0.47, 1.13, 60.26}) {
      const double phase = std::fmod(time, 0.5);
      EXPECT_NEAR(heightOf(plays, i.meshAt(time)), 4 * phase, 0.101) << time;  // within half of a moment
    }
    // The middles of revolutions of 10 Hz are met exactly.
    for (int k = 0; k < 40; ++k) {
      EXPECT_NEAR(heightOf(plays, i.meshAt((k + 0.5) * 0.1)), 4 * (k % 5 + 0.5) * 0.1, 1e-5) << k;
    }
  }
  EXPECT_EQ(plays.meshes.size(), 10u) << "both copies share the moments";
  const Scene stands = read("  - {file: rise.gltf, class: car, animation: {clip: rise, time_s: 0.25}}\n");
  EXPECT_FALSE(stands.moves());
  EXPECT_NEAR(heightOf(stands, stands.instances[0].mesh), 1, 1e-6);
  refuse("  - {file: rise.gltf, class: car, animation: {clip: rice}}\n", {"scene.yaml", "rise.gltf", "mean 'rise'"});
  refuse("  - {file: rise.gltf, class: car, animation: {time_s: 1}}\n", {"scene.yaml:4", "clip"});
  refuse("  - {file: pair.obj, class: car, animation: {clip: rise}}\n", {"scene.yaml:4", "pair.obj", "convert"});
  refuse("  - {file: none.gltf, class: car, animation: {clip: rise}}\n",
         {"scene.yaml:4", "none.gltf", "does not exist"});
}

TEST_F(SceneReader, brokenTrianglesOfAnAssetAreCounted) {
  folder_.write("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n");
  const Scene scene = read("  - {file: broken.obj}\n");
  EXPECT_EQ(scene.triangles(), 1u);
  EXPECT_EQ(scene.dropped.total(), 1u);
  ASSERT_EQ(scene.unlabeled.size(), 1u);
  EXPECT_EQ(scene.unlabeled.begin()->second, 1u);  // only what is left
}

// 330 bytes of a scene must not take gigabytes where a hundred megabytes are allowed.
TEST_F(SceneReader, CopiesMustFitIntoTheMemory) {
  const MemoryLimit limit(100 << 20);
  const std::string text = "at most 52,428 are possible with 100.0 MiB of memory (--memory-limit";
  refuse(kBox + ", copies: {grid: {count: [1500, 1500, 1], spacing: [1, 1, 1]}}}\n", {"scene.yaml:4:", text});
  refuse(kBox + ", copies: {grid: {count: [200, 200, 1], spacing: [1, 1, 1]}}}\n" + kBox +
             ", copies: {grid: {count: [200, 200, 1], spacing: [1, 1, 1]}}}\n",
         {"scene.yaml:5:", "80000 placed objects", text});
}

TEST_F(SceneReader, MistakesAreNamedWithTheirPlace) {
  folder_.write("garbage.obj", std::string("\0\1\2garbage", 10));
  folder_.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  const auto refusal = [&](const std::string& object, const std::string& more = "") {
    const auto file = write("  - {" + object + "}\n", more);
    return messageOf([&] { readScene(file, {}); });
  };
  const auto ofABox = [&](const std::string& keys) { return refusal(kBox.substr(5) + ", " + keys); };
  expectRefusals(ofABox, {{"scale: 0", "scene.yaml:4: | scale | not 0"},
                          {"scale: [1, 0, 1]", "scene.yaml:4: | scale"},
                          {"scale: .inf", "scene.yaml:4: | scale"},
                          {"scale: 1e-40", "scene.yaml:4: | scale"},
                          {"position: [0, .nan, 0]", "scene.yaml:4: | position"},
                          {"position: [0, 1e300, 0]", "scene.yaml:4: | position"},
                          {"rotation: [0, 0, 0, 0]", "scene.yaml:4: | rotation"},
                          {"copies: {at: [{scale: 0}]}", "scene.yaml:4: | scale"},
                          {"copies: {at: [{}, {}], grid: {count: [1000, 1000, 1000], spacing: [1, 1, 1]}}",
                           "scene.yaml:4: | 1000 x 1000 x 1000 | x 2 | 2e+09 | at most"},
                          {"copies: {grid: {count: [0, 1, 1], spacing: [1, 1, 1]}}", "scene.yaml:4: | count"},
                          {"copies: {grid: {count: [2, 1, 1]}}", "scene.yaml:4: | spacing"},
                          {"copies: {at: []}", "scene.yaml:4: | at"},
                          {"copies: {at: [{posiion: [0, 0, 0]}]}", "scene.yaml:4: | posiion | position"},
                          {"radius: 3", "scene.yaml:4: | radius"},
                          {"unit: 3", "scene.yaml:4: | unit"},
                          {"facing: north", "scene.yaml:4: | -x"}});
  const auto ofAnObject = [&](const std::string& keys) { return refusal(keys); };
  const std::string labels = "class: car, material: wood";
  expectRefusals(
      ofAnObject,
      {{"primitive: box, size: [1, 1, 1], class: caar, material: wood", "scene.yaml:4: | 'caar' | car"},
       {"primitive: box, size: [1, 1, 1], class: car, material: wod", "scene.yaml:4: | 'wod' | wood"},
       {"primitive: bx, size: [1, 1, 1], " + labels, "scene.yaml:4: | bx | box"},
       {"primitive: box, size: [1, 1, -1], " + labels, "scene.yaml:4: | size"},
       {"primitive: sphere, radius: 0, " + labels, "scene.yaml:4: | radius"},
       {"primitive: sphere, radius: 1, segments: 2, " + labels, "scene.yaml:4: | segments"},
       {"primitive: sphere, radius: 1, material: wood", "scene.yaml:4: | class"},
       {"primitive: sphere, radius: 1, class: car", "scene.yaml:4: | material"},
       {"file: pair.obj, rules: [{match: {node: absent}, class: terain}]", "scene.yaml:4: | 'terain' | terrain"},
       {"file: pair.obj, rules: [{match: {node: '/(/'}, class: car}]", "scene.yaml:4: | /(/"},
       {"file: pair.obj, instances: both", "scene.yaml:4: | both"},
       {"file: pair.obj, up: w", "scene.yaml:4: | up"},
       {"file: pair.obj, unit: 0", "scene.yaml:4: | unit"},
       {"file: pair.obj, primitive: box", "scene.yaml:4: | exactly one"},
       {"file: absent.obj, class: car", "scene.yaml:4: | absent.obj"},
       {"file: garbage.obj, class: car", "scene.yaml:4: | garbage.obj"},
       {"file: flat.obj", "scene.yaml:4: | flat.obj"},
       {"file: '', class: car", "scene.yaml:4: | file"},
       {"file: [pair.obj, flat.obj]", "scene.yaml:4: | {one_of: [...]}"},
       {"position: [0, 0, 0]", "scene.yaml:4: | exactly one"},
       {"fil: pair.obj, " + labels, "scene.yaml:4: | by 'fil', did you mean 'file'?"},
       {"town: {}, scale: 2", "scene.yaml:4: | town | scale"},
       {"town: {length: 100}}\n  - {town: {length: 100}", "only one town"},
       {"street: {length: 100}", "scene.yaml:4: | town: {district: street}"}});
  EXPECT_THAT(refusal(kBox.substr(5), "rules: [{match: any, material: glas}]\n"),
              testing::AllOf(testing::HasSubstr("scene.yaml:3:"), testing::HasSubstr("mean 'glass'")));
  expectInputError([&] { read("  []\n"); }, {"scene.yaml", "objects"});
  expectInputError([&] { readScene(folder_.path() / "absent.yaml", {}); }, {"absent.yaml"});
  const auto noLabels =
      folder_.write("labels.yaml", "ontology: none.yaml\nmaterials: none.yaml\nobjects: [{file: pair.obj}]\n");
  expectInputError([&] { readScene(noLabels, {}); }, {"none.yaml"});
}

TEST(Scenes, primitivesExampleIsWhole) {
  const Scene scene = readScene(kSource / "scenes/primitives.yaml", {});
  EXPECT_TRUE(scene.unlabeled.empty());
  EXPECT_EQ(scene.dropped.total(), 0u);
  EXPECT_NEAR(scene.bounds().low.z, 0, 1e-6);  // everything stands on the floor
  std::set<std::uint16_t> classes;
  for (const Mesh& mesh : scene.meshes) classes.insert(mesh.surfaces[0].semantic);
  EXPECT_GE(classes.size(), 7u);
}

TEST_F(SceneReader, objectsMoveWithTheirCopies) {
  const Scene scene =
      read(kBox + ", moving: {velocity: [0, 3, 0]}, copies: {grid: {count: [2, 1, 1], spacing: [4, 0, 0]}}}\n" + kBox +
           ", position: [0, 9, 0]}\n");
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_TRUE(scene.moves());
  EXPECT_EQ(scene.instances[1].worldFromMeshAt(2).translation, (Vec3d{4, 6, 0}));
  EXPECT_EQ(scene.instances[2].worldFromMeshAt(2).translation, (Vec3d{0, 9, 0}));
  EXPECT_EQ(scene.meshes.size(), 1u);
}

TEST_F(SceneReader, objectsFaceAWay) {
  const Scene scene =
      read(kBox + ", facing: -y, copies: {grid: {count: [2, 1, 1], spacing: [4, 0, 0]}}}\n" + kBox + "}\n");
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_EQ(scene.instances[1].facing, -kPi / 2);
  EXPECT_FALSE(scene.instances[2].facing.has_value());
}

}  // namespace
}  // namespace scanmill
