#include "draft/draft.h"

#include <array>
#include <functional>
#include <map>
#include <set>

#include "config/value.h"
#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "tests/core/assets/meshes/gltf/gltf_builder.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill::draft {
namespace {

const std::filesystem::path kLabels = std::filesystem::path(SCANMILL_SOURCE_DIR) / "labels";

Draft drafted(const std::vector<std::filesystem::path>& files, const std::filesystem::path& folder,
              const std::string& ontology = "scanmill") {
  return draftScene(files, readConcepts(kLabels / "words.yaml"), readOntology(kLabels / (ontology + ".yaml")), ontology,
                    "draft", folder);
}

bool contains(const std::string& text, const char* word) {
  return text.find(word) != std::string::npos;
}

// Of each node and material: the class that the drafted scene gives it.
std::map<std::pair<std::string, std::string>, std::string> classesOf(const TemporaryFolder& folder,
                                                                     const Draft& draft) {
  const Scene scene = readScene(folder.write("draft.yaml", draft.yaml), {});
  std::map<std::pair<std::string, std::string>, std::string> classes;
  for (const Mesh& mesh : scene.meshes) {
    for (const Surface& s : mesh.surfaces) {
      classes[{s.node, scene.materials[s.material].name}] = scene.ontology.find(s.semantic)->name;
    }
  }
  return classes;
}

// Nodes of one triangle each, with a material of the second name.
std::string gltfOf(const std::vector<std::pair<std::string, std::string>>& nodes) {
  GltfBuilder b;
  const std::size_t positions = b.numbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  b.json["scenes"] = {{{"nodes", nlohmann::json::array()}}};
  for (const auto& [node, material] : nodes) {
    const std::size_t i = b.json["meshes"].size();
    b.json["scenes"][0]["nodes"].push_back(i);
    b.json["nodes"].push_back({{"name", node}, {"mesh", i}});
    b.json["materials"].push_back({{"name", material}});
    b.json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"material", i}}}}});
  }
  return b.text();
}

// What is drafted reads as what was guessed, whatever characters names have.
TEST(DraftScene, ReadsAsItWasGuessed) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("place.gltf", gltfOf({{"House_1", "brick"},
                                                                        {"House_2", "glass"},
                                                                        {"House_2", "brick"},
                                                                        {"car_17", "glass"},
                                                                        {"Road \"A\" {main}, [old]*?", "grey"},
                                                                        {"x", "Asphalt"},
                                                                        {"x", "Gras\\s"},
                                                                        {"SkyBox", "blue"},
                                                                        {"mystery", "thing"}}));
  const Draft draft = drafted({file}, folder.path());
  ASSERT_EQ(draft.files.size(), 1u);
  EXPECT_EQ(draft.files[0].triangles(), 9u);
  EXPECT_EQ(draft.files[0].guessed(), 8u);
  const Scene scene = readScene(folder.write("draft.yaml", draft.yaml), {});
  std::map<std::string, int> classes;
  for (const std::uint16_t s : scene.meshes.at(0).surfaceOf) {
    ++classes[scene.ontology.find(scene.meshes[0].surfaces[s].semantic)->name];
  }
  EXPECT_EQ(classes, (std::map<std::string, int>{
                         {"building", 2}, {"window", 1}, {"car", 1}, {"road", 2}, {"terrain", 1}, {"unlabeled", 1}}));
  for (const RuleUse& rule : scene.rules) EXPECT_GT(rule.decided, 0u) << rule.match;
  EXPECT_NE(draft.yaml.find("mystery"), std::string::npos) << "what no word tells is listed";
}

// Names that YAML, patterns or terminals might take for something else.
const std::vector<std::string> kHostileNames{
    "${x}",   "$$",      "$",   "a\nb", "\"",  "'",    "\\",     "\x1b[2J", "\u009b31m", "\u202egpj", "\u2028",
    "\ufeff", "- a",     ": a", "#",    "*",   "&a",   "!a",     "~",       "null",      "yes",       "12",
    "1e5",    " a ",     "?",   "[",    "[a]", "]",    "{a,b}",  "{a}",     "{",         "}",         ",",
    "[{]",    "a, b: c", "%a",  "@a",   "|",   "1..2", "[!a-z]", "\u00fc"};

TEST(DraftScene, NamesFilesOfStrangers) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (const std::string& name : kHostileNames) {
    files.push_back(folder.write(name + ".obj", "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  }
  const Draft draft = drafted(files, folder.path());
  const Value yaml = parseYaml(draft.yaml, "draft.yaml");
  const std::vector<Value>& objects = yaml.valueOf("objects").items;
  ASSERT_EQ(objects.size(), files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    EXPECT_EQ(objects[i].valueOf("file").text, files[i].filename().string());
    EXPECT_EQ(objects[i].valueOf("name").text, files[i].stem().string());
  }
  EXPECT_EQ(readScene(folder.write("draft.yaml", draft.yaml), {}).instances.size(), files.size());
  const std::filesystem::path latin = folder.write("T\xFCr.obj", "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expectInputError([&] { drafted({latin}, folder.path()); }, {"T\xFCr.obj", "is not UTF-8"});
}

TEST(DraftScene, NamesNodesOfStrangers) {
  const TemporaryFolder folder;
  std::vector<std::pair<std::string, std::string>> nodes{{"oak", ""}, {std::string("car\0", 4), ""}};
  for (const std::string& name : kHostileNames) {
    if (name == "12") continue;  // "car *" would then match most of the others
    nodes.emplace_back("car " + name, "");
    nodes.emplace_back(name + " car", "");
  }
  nodes.emplace_back("/car/", "");
  const Draft draft = drafted({folder.write("place.gltf", gltfOf(nodes))}, folder.path());
  const auto classes = classesOf(folder, draft);
  EXPECT_EQ(classes.size(), nodes.size());
  for (const auto& [names, name] : classes) EXPECT_EQ(name, names.first == "oak" ? "tree" : "car") << names.first;
  const std::filesystem::path latin =
      folder.write("latin.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\no car_T\xFCr\nf 1 2 3\no oak\nf 1 2 3\n");
  for (const auto& [names, name] : classesOf(folder, drafted({latin}, folder.path()))) {
    EXPECT_EQ(name, names.first == "oak" ? "tree" : "car") << names.first;
  }
}

// `expected`: names of nodes, each with the class that the drafted scene gives it.
void expectClasses(const std::string& ontology, const std::map<std::string, std::string>& expected) {
  const TemporaryFolder folder;
  std::vector<std::pair<std::string, std::string>> nodes;
  for (const auto& [node, name] : expected) nodes.emplace_back(node, "");
  const std::filesystem::path file = folder.write("place.gltf", gltfOf(nodes));
  std::map<std::string, std::string> classes;
  for (const auto& [names, name] : classesOf(folder, drafted({file}, folder.path(), ontology))) {
    classes[names.first] = name;
  }
  EXPECT_EQ(classes, expected);
}

TEST(DraftScene, TakesTheClassesOfItsOntology) {
  expectClasses("scanmill", {{"transmission tower", "pole"}, {"water tower", "building"}});
  expectClasses("semantic_kitti", {{"Sidewalk", "sidewalk"}, {"Tree_2", "vegetation"}, {"Lamp", "pole"}});
  expectClasses("nyu40", {{"Floor", "floor"},
                          {"Ceiling_01", "ceiling"},
                          {"wall.N", "wall"},
                          {"Stuhl_3", "chair"},
                          {"desk lamp", "lamp"},
                          {"Bookcase", "bookshelf"},
                          {"Fenster", "window"},
                          {"OfficeDoor", "door"},
                          {"mug", "unlabeled"},
                          {"Box001", "unlabeled"},
                          {"dresser_0009", "dresser"},
                          {"Lamp.002", "lamp"},
                          {"Whiteboard_2", "whiteboard"},
                          {"Night_Stand", "night stand"},
                          {"Trash bin", "otherprop"}});
}

TEST(DraftScene, SeveralFilesStandBesideOneAnother) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (const char* const name : {"oak.obj", "pine.obj", "sedan.obj", "house.obj", "sign.obj"}) {
    files.push_back(folder.write(name, "o a\nv 5 0 -3\nv 9 1 0\nv 6 4 2\nf 1 2 3\n"));
  }
  const Scene scene = readScene(folder.write("draft.yaml", drafted(files, folder.path()).yaml), {});
  ASSERT_EQ(scene.instances.size(), 5u);
  std::vector<Box> boxes;
  for (const Instance& i : scene.instances) {
    Box box;
    for (const Vec3f& p : scene.meshes[i.mesh].positions) box.add(i.worldFromMesh * Vec3d(p));
    EXPECT_NEAR(box.low.z, 0, 1e-3) << i.name;
    for (const Box& other : boxes) {
      EXPECT_TRUE(box.low.x > other.high.x || other.low.x > box.high.x || box.low.y > other.high.y ||
                  other.low.y > box.high.y)
          << i.name;
    }
    boxes.push_back(box);
  }
}

// SDF, URDF, glTF and 3D Tiles are in metres by definition: crates of 1.4 m do not become 14 m.
TEST(DraftScene, FormatsWithAUnitKeepIt) {
  const TemporaryFolder folder;
  const std::string shape = "<geometry><box size=\"900 30 20\"><size>900 30 20</size></box></geometry>";
  const std::string visual = "<link name=\"l\"><visual name=\"v\">" + shape + "</visual></link>";
  std::vector<std::filesystem::path> files{
      folder.write("bus_1.sdf", "<sdf version=\"1.6\"><model name=\"bus\">" + visual + "</model></sdf>"),
      folder.write("bus_2.urdf", "<robot name=\"bus\">" + visual + "</robot>"),
      folder.write("bus_3.gltf", gltfOf({{"bus", ""}})),
      folder.write("bus_4.obj", "o bus\nv 0 0 0\nv 1000 0 0\nv 0 300 250\nf 1 2 3\n")};
  std::map<std::string, double> units;
  for (const auto& file : files) {
    const Draft draft = drafted({file}, folder.path());
    units[file.extension().string()] = draft.files.at(0).frame.unit;
    EXPECT_EQ(draft.yaml.find("\n    unit:") == std::string::npos, file.extension() != ".obj") << draft.yaml;
    const bool doubted =
        draft.yaml.find("doubtful, though the file or its format states the unit") != std::string::npos;
    EXPECT_EQ(doubted, file.extension() != ".obj") << draft.yaml;
  }
  EXPECT_EQ(units, (std::map<std::string, double>{{".sdf", 1}, {".urdf", 1}, {".gltf", 1}, {".obj", 0.01}}));
}

// The names of a folder's models share a word that says nothing of one of them.
TEST(DraftScene, WordsThatMostFilesShareSayNothing) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (const char* const name : {"Shelf", "Desk", "Widget", "GroundB"}) {
    files.push_back(
        folder.write(fmt::format("my_warehouse_{}/model.obj", name), "o a\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n"));
  }
  const Draft draft = drafted(files, folder.path());
  EXPECT_EQ(draft.files.at(0).byFolder(), 1u);
  EXPECT_EQ(draft.files.at(2).byFolder(), 0u);
  EXPECT_THAT(draft.yaml, testing::Not(testing::HasSubstr("building")));
}

// Files of a folder that cannot be read are left out with a warning; files that a user named are refused.
TEST(DraftScene, FilesOfFoldersMayFail) {
  const TemporaryFolder folder;
  const auto empty = folder.write("frames.urdf", "<robot name=\"r\"><link name=\"base\"/></robot>");
  const auto car = folder.write("car.obj", "o a\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n");
  const std::vector<Concept> concepts = readConcepts(kLabels / "words.yaml");
  const Ontology ontology = readOntology(kLabels / "scanmill.yaml");
  const auto draftOf = [&](const std::vector<std::filesystem::path>& files) {
    return draftScene(files, concepts, ontology, "scanmill", "a", folder.path(), {.mayFail = {empty}});
  };
  testing::internal::CaptureStderr();
  const Draft draft = draftOf({empty, car, empty});
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(testing::HasSubstr("left out: "), testing::HasSubstr("frames.urdf: has no triangle")));
  ASSERT_EQ(draft.files.size(), 1u);
  EXPECT_EQ(draft.files[0].file, car);
  expectInputError([&] { draftOf({empty}); }, {"frames.urdf: has no triangle"});
  expectInputError([&] { drafted({car, empty}, folder.path()); }, {"frames.urdf: has no triangle"});
}

// Which classes are right for a part of a file; none: it does not count.
using Truth = std::function<std::vector<std::string>(const std::string& file, const AssetPart& part)>;

// The share of triangles whose drafted class is right.
double shareRight(const std::filesystem::path& root, const std::vector<std::string>& kinds, const Truth& truth) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    const std::string kind = entry.path().extension().string();
    if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  const TemporaryFolder folder;
  std::uint64_t right = 0;
  std::uint64_t all = 0;
  for (const std::filesystem::path& file : files) {
    const auto classes = classesOf(folder, drafted({file}, folder.path()));
    for (const AssetPart& part : readAsset(file, {.textures = false}).parts) {
      const std::vector<std::string> wanted = truth(std::filesystem::relative(file, root).string(), part);
      if (wanted.empty()) continue;
      all += part.triangles.size();
      // Materials of the library replace the file's own: the node alone tells, if it has one class.
      std::uint64_t fits = 0;
      std::uint64_t surfaces = 0;
      for (const auto& [names, c] : classes) {
        if (names.first != part.node) continue;
        ++surfaces;
        fits += std::find(wanted.begin(), wanted.end(), c) != wanted.end();
      }
      right += surfaces > 0 && fits == surfaces ? part.triangles.size() : 0;
    }
  }
  return all == 0 ? 0 : static_cast<double>(right) / static_cast<double>(all);
}

// Houses of a place, each in a file of its own, and the ground below them all.
TEST(DraftScene, PartsOfOnePlaceStayWhereTheyAre) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files{
      folder.write("terrain.obj", "o a\nv -90 -90 0\nv 90 -90 0\nv 0 90 0\nf 1 2 3\n")};
  for (int i = 0; i < 3; ++i) {
    const int x = 30 * i - 40;
    files.push_back(folder.write(fmt::format("house{}.obj", i), fmt::format("o a\nv {0} 5 0\nv {1} 5 0\nv {0} 15 9\n"
                                                                            "f 1 2 3\n",
                                                                            x, x + 10)));
  }
  const Draft draft = drafted(files, folder.path());
  EXPECT_TRUE(draft.onePlace);
  const Scene scene = readScene(folder.write("draft.yaml", draft.yaml), {});
  for (const Instance& i : scene.instances) EXPECT_EQ(i.worldFromMesh.translation, Vec3d()) << i.name;
  EXPECT_FALSE(drafted({files[0], files[0]}, folder.path()).onePlace);
  EXPECT_EQ(draft.files[1].byFile(), 1u) << "no name but the file's says that it is a house";
}

// Files that say nothing have their folder's name, and no two objects one name.
TEST(DraftScene, NamesTellObjectsApart) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (const char* const name : {"lamp/scene.obj", "tree/scene.obj", "tree/old/tree.obj", "car.obj", "b/car.obj"}) {
    files.push_back(folder.write(name, "o a\nv 0 0 0\nv 1 0 0\nv 0 1 3\nf 1 2 3\n"));
  }
  const Draft draft = drafted(files, folder.path());
  std::set<std::string> names;
  for (const GuessedFile& f : draft.files) names.insert(f.name);
  EXPECT_EQ(names.size(), files.size());
  EXPECT_EQ(draft.files[0].name, "lamp");
  EXPECT_EQ(draft.files[1].name, "tree");
  const Scene scene = readScene(folder.write("draft.yaml", draft.yaml), {});
  EXPECT_EQ(scene.ontology.find(scene.meshes[0].surfaces[0].semantic)->name, "street_lamp") << "by its folder";
  EXPECT_EQ(draft.files[0].guessed(), 0u);
  EXPECT_EQ(draft.files[0].byFolder(), 1u);
}

// Parts that have their class only from the folder are listed; with many nodes, by material and texture.
TEST(DraftScene, ListsPartsWithoutATellingName) {
  const TemporaryFolder folder;
  std::vector<std::pair<std::string, std::string>> nodes{{"leaves", "leaves"}};
  for (int i = 0; i < 30; ++i) nodes.emplace_back(fmt::format("n{}", i), "grey");
  folder.write("oak/a.gltf", gltfOf(nodes));
  const Draft draft = drafted({folder.path() / "oak/a.gltf"}, folder.path());
  EXPECT_EQ(draft.files[0].guessed(), 1u);
  EXPECT_EQ(draft.files[0].byFolder(), 30u);
  EXPECT_THAT(draft.yaml,
              testing::HasSubstr("class: tree   # for all triangles without a rule: by the name of the folder"));
  EXPECT_THAT(draft.yaml, testing::HasSubstr("#   material \"grey\": 30 triangles\n"));
}

// Textures may be beside a link, and not beside the file that it names.
TEST(DraftScene, NamesFilesByTheirLinks) {
  const TemporaryFolder folder;
  folder.write("store/a.obj", "o a\nv 0 0 0\nv 1 0 0\nv 0 1 3\nf 1 2 3\n");
  std::filesystem::create_directory(folder.path() / "links");
  std::filesystem::create_symlink("../store/a.obj", folder.path() / "links/b.obj");
  std::filesystem::create_directory_symlink("store", folder.path() / "shelf");
  const std::filesystem::path link = folder.path() / "links/b.obj";
  EXPECT_THAT(drafted({link}, folder.path()).yaml, testing::HasSubstr("file: \"links/b.obj\""));
  EXPECT_THAT(drafted({link}, folder.path() / "links").yaml, testing::HasSubstr("file: \"b.obj\""));
  // A scene file in a linked folder: ".." leads out of the folder that the link names.
  EXPECT_THAT(drafted({link}, folder.path() / "shelf").yaml, testing::HasSubstr("file: \"../links/b.obj\""));
}

// Tiles have one unit, and a doubt if the name states a ground and an object.
TEST(DraftScene, TilesHaveOneUnit) {
  const TemporaryFolder folder;
  const std::string plate = "v -0.5 -0.5 0.1\nv 0.5 -0.5 0.1\nv 0.5 0.5 0.1\nv -0.5 0.5 0.1\nf 1 2 3\nf 1 3 4\n";
  const std::string peak = "v -0.1 0 0.1\nv 0.1 0 0.1\nv 0 0 1.8\nf 5 6 7\n";
  const std::vector<std::filesystem::path> files{folder.write("road-straight.obj", "o a\n" + plate),
                                                 folder.write("building-a.obj", "o a\n" + plate + peak),
                                                 folder.write("grass-trees.obj", "o a\n" + plate + peak)};
  const Draft draft = drafted(files, folder.path());
  for (const GuessedFile& f : draft.files) EXPECT_EQ(f.frame.unit, 10) << f.file;
  EXPECT_THAT(draft.files[2].doubts(), testing::Contains("one class for two in its name"));
}

// The columns of a cloud go before the names of its file and folder.
TEST(DraftScene, LabelsAndColoursOfACloudGoBeforeItsName) {
  const TemporaryFolder folder;
  const auto cloud = [&](const std::string& file, const std::string& column, const std::array<int, 2>& values) {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex 32\nproperty float x\nproperty float y\nproperty float z\n"
        "property {}\nend_header\n",
        column);
    for (int i = 0; i < 32; ++i) text += fmt::format("{} {} 0 {}\n", i % 8, i / 8, values[i < 16 ? 0 : 1]);
    return drafted({folder.write(file, text)}, folder.path());
  };
  for (const char* const file : {"crate_wall.ply", "house/scan.ply"}) {
    const Draft labelled = cloud(file, "int label", {1, 2});
    EXPECT_EQ(labelled.files[0].guessed() + labelled.files[0].byFolder(), 0u) << file;
    EXPECT_THAT(labelled.yaml,
                testing::AllOf(testing::HasSubstr("material \"1\""), testing::HasSubstr("material \"2\""),
                               testing::Not(testing::HasSubstr("class:"))))
        << file;
  }
  EXPECT_THAT(cloud("b_wall.ply", "int label", {0, 0}).yaml,
              testing::AllOf(testing::HasSubstr("class: wall"), testing::HasSubstr("material: brick")))
      << "one number for all points is no label";
  EXPECT_THAT(cloud("c_wall.ply", "uint rgb", {0x404040, 0x808080}).yaml,
              testing::AllOf(testing::HasSubstr("class: wall"), testing::Not(testing::HasSubstr("material: brick"))));
}

TEST(DraftScene, CoarserLevelsOfDetailAreDoubtful) {
  const TemporaryFolder folder;
  const auto doubtsOf = [&](const std::string& first, const std::string& second) {
    return drafted({folder.write("a.gltf", gltfOf({{first, ""}, {second, ""}}))}, folder.path()).files[0].doubts();
  };
  const char* const told = "several levels of detail: `drop` the coarser ones";
  EXPECT_THAT(doubtsOf("Oak_LOD0", "Oak_LOD1"), testing::Contains(told));
  EXPECT_THAT(doubtsOf("oak_lod0", "oak_lod9"), testing::Contains(told));
  EXPECT_THAT(doubtsOf("Oak_LOD0", "Oak_Billboard"), testing::Contains(told));
  EXPECT_THAT(doubtsOf("Oak_LOD0", "Elm_LOD1"), testing::Not(testing::Contains(told)));
  EXPECT_THAT(doubtsOf("Oak", "Oak_LOD1"), testing::Not(testing::Contains(told)));
}

// What a person should look at is told: a size that no unit makes usual, an axis that nothing tells.
TEST(DraftScene, DoubtsAreTold) {
  const TemporaryFolder folder;
  const auto doubtsOf = [&](const std::string& name, const std::string& obj) {
    return drafted({folder.write(name, obj)}, folder.path()).files[0].doubts();
  };
  const std::string cube = "o a\nv 0 0 0\nv 1 1 1\nv 1 0 1\nf 1 2 3\n";
  EXPECT_THAT(doubtsOf("thing.obj", cube), testing::ElementsAre("up axis"));
  EXPECT_THAT(doubtsOf("sedan.obj", "o a\nv -1 -1 0\nv 1 -1 0\nv 0 2000000000 1\nf 1 2 3\n"),
              testing::Contains("size"));
  const auto cloud = folder.write("room.csv", "x,y,z,label\n0,0,0,3\n1,0,0,3\n0,1,0,40\n");
  const Draft draft = drafted({cloud}, folder.path());
  EXPECT_THAT(draft.files[0].doubts(), testing::Contains("labels without names"));
  EXPECT_THAT(draft.yaml, testing::HasSubstr("# points: {labels: NAME}"));
}

TEST(DraftScene, LabelsMostOfRealSets) {
  SKIP_WITHOUT_SHARED_DATA("scenes/kenney_city");
  const std::filesystem::path scenes = sharedData() / "scenes";
  const double kenney = shareRight(scenes / "kenney_city", {".glb"}, [](const auto& file, const AssetPart&) {
    if (contains(file, "grass-trees")) return std::vector<std::string>{"tree", "terrain"};
    if (contains(file, "fountain")) return std::vector<std::string>{"structure", "sidewalk"};
    if (contains(file, "lightposts")) return std::vector<std::string>{"street_lamp", "road"};
    for (const auto& [word, c] : {std::pair{"building", "building"},
                                  {"grass", "terrain"},
                                  {"pavement", "sidewalk"},
                                  {"road", "road"},
                                  {"motorcycle", "motorcycle"},
                                  {"truck", "truck"}}) {
      if (contains(file, word)) return std::vector<std::string>{c};
    }
    return std::vector<std::string>{};
  });
  EXPECT_GT(kenney, 0.8);
  const double gazebo = shareRight(scenes / "gazebo", {".dae", ".obj"}, [](const auto& file, const AssetPart&) {
    for (const auto& [word, c] : {std::pair{"ambulance", "truck"},
                                  {"bus_stop", "structure"},
                                  {"bus", "bus"},
                                  {"hatchback", "car"},
                                  {"suv", "car"},
                                  {"pickup", "car"},
                                  {"house", "building"},
                                  {"jersey", "fence"},
                                  {"lamp", "street_lamp"},
                                  {"sign", "traffic_sign"},
                                  {"telephone", "pole"},
                                  {"dumpster", "object"},
                                  {"hydrant", "object"},
                                  {"mailbox", "object"}}) {
      if (contains(file, word)) return std::vector<std::string>{c};
    }
    return contains(file, "tree") ? std::vector<std::string>{"tree", "trunk"} : std::vector<std::string>{};
  });
  EXPECT_GT(gazebo, 0.8);
  RecordProperty("kenney", std::to_string(kenney));
  RecordProperty("gazebo", std::to_string(gazebo));
}

}  // namespace
}  // namespace scanmill::draft
