#include "scene/ontology.h"

#include <cstdlib>

#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

TEST(Ontology, idsOfOurClassesNeverChange) {
  const Ontology o = readOntology(kLabels / "scanmill.yaml");
  const std::vector<std::pair<std::uint16_t, std::string>> expected = {
      {0, "unlabeled"},      {1, "road"},          {2, "road_marking"},   {3, "sidewalk"},     {4, "curb"},
      {5, "terrain"},        {6, "building"},      {7, "window"},         {8, "wall"},         {9, "fence"},
      {10, "vegetation"},    {11, "tree"},         {12, "trunk"},         {13, "pole"},        {14, "traffic_sign"},
      {15, "traffic_light"}, {16, "street_lamp"},  {20, "car"},           {21, "truck"},       {22, "bus"},
      {23, "motorcycle"},    {24, "bicycle"},      {25, "other_vehicle"}, {30, "pedestrian"},  {31, "rider"},
      {32, "animal"},        {33, "motorcyclist"}, {40, "structure"},     {41, "ground"},      {42, "parking"},
      {43, "water"},         {44, "driveway"},     {50, "object"},        {60, "ego_vehicle"}, {61, "noise"}};
  ASSERT_EQ(o.classes.size(), expected.size());
  for (const auto& [id, name] : expected) {
    ASSERT_NE(o.find(id), nullptr) << id;
    EXPECT_EQ(o.find(id)->name, name);
  }
  EXPECT_EQ(o.find(17), nullptr);
}

TEST(Ontology, coloursCanBeToldApart) {
  const Ontology o = readOntology(kLabels / "scanmill.yaml");
  for (std::size_t i = 0; i < o.classes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      int distance = 0;
      for (std::size_t k = 0; k < 3; ++k) distance += std::abs(o.classes[i].color[k] - o.classes[j].color[k]);
      EXPECT_GE(distance, 60) << o.classes[i].name << " and " << o.classes[j].name;
    }
  }
}

TEST(Ontology, classesOfOursAreThoseOfSemanticKitti) {
  const Ontology kitti = readOntology(kLabels / "semantic_kitti.yaml");
  EXPECT_EQ(kitti.require("window", {}).name, "building");
  EXPECT_EQ(kitti.require("curb", {}).name, "sidewalk");
  EXPECT_EQ(kitti.require("pedestrian", {}).id, 30);
  EXPECT_EQ(kitti.require("tree", {}).id, 70);
  EXPECT_EQ(kitti.require("street_lamp", {}).id, 80);
}

// Scenes of ours, street and town among them, can be labelled as any of the outdoor ontologies has it.
TEST(Ontology, everyClassOfOursResolvesInAllOutdoorOntologies) {
  const Ontology ours = readOntology(kLabels / "scanmill.yaml");
  for (const char* name : {"semantic_kitti", "nuscenes", "cityscapes", "carla"}) {
    const Ontology other = readOntology(kLabels / (std::string(name) + ".yaml"));
    for (const SemanticClass& c : ours.classes) EXPECT_NO_THROW(other.require(c.name, {})) << name << ": " << c.name;
  }
}

// Ids and counts as their publishers have them.
TEST(Ontology, publishedOnesHaveTheirIds) {
  const auto id = [](const char* file, const char* name) { return readOntology(kLabels / file).require(name, {}).id; };
  EXPECT_EQ(readOntology(kLabels / "nuscenes.yaml").classes.size(), 32u);
  EXPECT_EQ(id("nuscenes.yaml", "vehicle.car"), 17);
  EXPECT_EQ(id("nuscenes.yaml", "flat.driveable_surface"), 24);
  EXPECT_EQ(id("nuscenes.yaml", "static.vegetation"), 30);
  EXPECT_EQ(id("cityscapes.yaml", "road"), 7);
  EXPECT_EQ(id("cityscapes.yaml", "car"), 26);
  EXPECT_EQ(id("cityscapes.yaml", "bicycle"), 33);
  EXPECT_EQ(readOntology(kLabels / "carla.yaml").classes.size(), 29u);
  EXPECT_EQ(id("carla.yaml", "Vegetation"), 9);
  EXPECT_EQ(id("carla.yaml", "Car"), 14);
  EXPECT_EQ(id("carla.yaml", "RoadLine"), 24);
  EXPECT_EQ(readOntology(kLabels / "nyu40.yaml").classes.size(), 41u);
  EXPECT_EQ(readOntology(kLabels / "scannet.yaml").classes.size(), 21u);
  EXPECT_EQ(id("asprs.yaml", "tree"), 5) << "high vegetation";
  EXPECT_EQ(id("nyu40.yaml", "otherprop"), 40);
  EXPECT_EQ(id("scannet.yaml", "otherfurniture"), 39);
  for (const SemanticClass& c : readOntology(kLabels / "scannet.yaml").classes) {
    EXPECT_EQ(readOntology(kLabels / "nyu40.yaml").find(c.id)->name, c.name);
  }
}

TEST(Ontology, whatIsLostBetweenTwoIsTold) {
  const auto lost = [](const char* from, const char* to) {
    return lostBetween(readOntology(kLabels / from), readOntology(kLabels / to));
  };
  EXPECT_TRUE(lost("scanmill.yaml", "scanmill.yaml").empty());
  EXPECT_THAT(lost("scanmill.yaml", "nuscenes.yaml"),
              testing::Contains("road, road_marking, parking, driveway become flat.driveable_surface"));
  EXPECT_THAT(lost("nyu40.yaml", "scannet.yaml"), testing::Contains("cabinet, dresser, night stand become cabinet"));
  EXPECT_THAT(lost("scanmill.yaml", "nyu40.yaml").back(), testing::StartsWith("no class for road, "));
}

TEST(Ontology, semanticKittiColoursAreRgb) {
  const Ontology kitti = readOntology(kLabels / "semantic_kitti.yaml");
  EXPECT_EQ(kitti.classes.size(), 34u);
  EXPECT_EQ(kitti.find(10)->color, (std::array<std::uint8_t, 3>{100, 150, 245}));  // cars are blue
  EXPECT_EQ(kitti.find(30)->color, (std::array<std::uint8_t, 3>{255, 30, 30}));    // persons are red
  EXPECT_EQ(kitti.find(259)->name, "moving-other-vehicle");
}

TEST(Ontology, namesGoBeforeAliases) {
  const TemporaryFolder folder;
  const Ontology o = readOntology(folder.write("o.yaml",
                                               "classes:\n"
                                               "  - {id: 0, name: unlabeled, color: [0, 0, 0]}\n"
                                               "  - {id: 7, name: a, color: [1, 2, 3], thing: true, aliases: [c]}\n"
                                               "  - {id: 65535, name: b, color: [255, 0, 9]}\n"));
  EXPECT_EQ(o.name, "o");
  EXPECT_EQ(o.require("c", {}).id, 7);
  EXPECT_EQ(o.require("b", {}).id, 65535);
}

TEST(Ontology, unknownClassIsRefusedWithSuggestion) {
  const Ontology o = readOntology(kLabels / "scanmill.yaml");
  expectInputError([&] { o.require("bilding", {"s.yaml", 3, 9}); }, {"s.yaml:3:9", "'bilding'", "building"});
}

TEST(Ontology, badFilesAreRefusedWithTheirPlace) {
  const TemporaryFolder folder;
  const std::string zero = "classes:\n  - {id: 0, name: unlabeled, color: [0, 0, 0]}\n";
  const auto refuse = [&](const std::string& text, const std::vector<std::string>& words) {
    const auto file = folder.write("bad.yaml", text);
    SCOPED_TRACE(text);
    expectInputError([&] { readOntology(file); }, words);
  };
  expectInputError([&] { readOntology(folder.path() / "absent.yaml"); }, {"absent.yaml"});
  refuse("", {"bad.yaml"});
  refuse("classes: 3\n", {"bad.yaml:1"});
  refuse("classes: []\n", {"bad.yaml:1"});
  refuse("classes:\n  - {id: 0, name: road, color: [0, 0, 0]}\n", {"unlabeled"});
  refuse(zero + "  - {id: 0, name: a, color: [0, 0, 0]}\n", {"bad.yaml:3", "id 0"});
  refuse(zero + "  - {id: 1, name: unlabeled, color: [0, 0, 0]}\n", {"bad.yaml:3", "'unlabeled'"});
  refuse(zero + "  - {id: 1, name: a, color: [0, 0, 0], aliases: [unlabeled]}\n", {"bad.yaml:3", "'unlabeled'"});
  refuse(zero + "  - {id: 65536, name: a, color: [0, 0, 0]}\n", {"bad.yaml:3", "65535"});
  refuse(zero + "  - {id: -1, name: a, color: [0, 0, 0]}\n", {"bad.yaml:3"});
  refuse(zero + "  - {id: 1, name: a, color: [0, 0]}\n", {"bad.yaml:3", "color"});
  refuse(zero + "  - {id: 1, name: a, color: [0, 0, 256]}\n", {"bad.yaml:3", "255"});
  refuse(zero + "  - {id: 1, name: a, color: [0, 0, 1.5]}\n", {"bad.yaml:3", "whole"});
  refuse(zero + "  - {id: 1, name: '', color: [0, 0, 1]}\n", {"bad.yaml:3", "empty"});
  refuse(zero + "  - {id: 1, name: a, colour: [0, 0, 1], color: [0, 0, 1]}\n", {"bad.yaml:3", "colour"});
  const std::string car = zero + "  - {id: 1, name: car, color: [0, 0, 1], thing: true}\n";
  refuse(car + "  - {id: 2, name: b, color: [0, 0, 1], thing: true, moving_of: cra}\n", {"bad.yaml:4", "'car'"});
  refuse(car + "  - {id: 2, name: b, color: [0, 0, 1], moving_of: car}\n", {"bad.yaml:4", "thing: true"});
  refuse(zero + "  - {id: 2, name: b, color: [0, 0, 1], thing: true, moving_of: b}\n", {"bad.yaml:3", "stand still"});
  refuse(car + "  - {id: 2, name: b, color: [0, 0, 1], thing: true, moving_of: car}\n" +
             "  - {id: 3, name: c, color: [0, 0, 1], thing: true, moving_of: car}\n",
         {"bad.yaml:5", "already"});
}

TEST(Ontology, ClassesOfWhatMoves) {
  const Ontology o = readOntology(kLabels / "semantic_kitti.yaml");
  std::size_t moving = 0;
  for (const SemanticClass& c : o.classes) {
    if (!c.movingOf) continue;
    ++moving;
    EXPECT_GE(c.id, 252);
    EXPECT_EQ(c.name, "moving-" + o.find(*c.movingOf)->name);
  }
  EXPECT_EQ(moving, 8u);
  EXPECT_FALSE(o.require("car", {}).movingOf);
}

}  // namespace
}  // namespace scanmill
