#include "draft/guess.h"

namespace scanmill::draft {
namespace {

const std::vector<Concept>& concepts() {
  static const std::vector<Concept> all =
      readConcepts(std::filesystem::path(SCANMILL_SOURCE_DIR) / "labels/words.yaml");
  return all;
}

AssetPart part(const std::string& node, const std::string& material = {}, const std::string& texture = {}) {
  AssetPart p;
  p.node = node;
  p.material = material;
  p.texture = texture;
  return p;
}

std::vector<const Concept*> guesses(const Asset& asset) {
  Vocabulary words(concepts());
  words.ignoreShared(asset);
  return guessParts(words, asset, conceptOfFile(words, asset).shown);
}

std::string guessed(const std::string& file, const AssetPart& p) {
  Asset asset;
  asset.file = file;
  asset.parts = {p};
  const Concept* const c = guesses(asset).at(0);
  return c == nullptr ? std::string() : c->name;
}

TEST(Guess, DetailsBelongToTheirWhole) {
  EXPECT_EQ(guessed("/x/city.glb", part("House_3", "glass")), "window");
  EXPECT_EQ(guessed("/x/city.glb", part("House_3", "plaster")), "building");
  EXPECT_EQ(guessed("/x/city.glb", part("car_3", "glass")), "car");
  EXPECT_EQ(guessed("/x/oak.obj", part("Mesh.001", "bark")), "trunk");
  EXPECT_EQ(guessed("/x/oak.obj", part("Mesh.001", "Material")), "tree");
  EXPECT_EQ(guessed("/x/leaves.obj", part("", "")), "leaf");
  EXPECT_EQ(guessed("/x/city.glb", part("bus_3", "Wheels_01")), "bus wheel") << "of the bus's class, of rubber";
  EXPECT_EQ(guessed("/x/suv/model.obj", part("Wheel_Front_Left")), "car wheel");
}

TEST(Guess, TheMoreTellingNameWins) {
  EXPECT_EQ(guessed("/x/suv.obj", part("Box001", "grass")), "car") << "all of a car is the car";
  EXPECT_EQ(guessed("/x/map.obj", part("Terrain", "asphalt")), "road") << "a ground of several materials";
  EXPECT_EQ(guessed("/x/map.ac", part("tkMn0", "", "textures\\tr-grass.rgb")), "terrain");
  EXPECT_EQ(guessed("/models/hatchback/meshes/a.dae", part("Box001", "")), "car") << "by the folder";
  EXPECT_EQ(guessed("/x/city.glb", part("SkyBox", "plaster")), "nothing");
  EXPECT_EQ(guessed("/x/lamp/scene.gltf", part("Object_4")), "street lamp") << "a file that says nothing";
  EXPECT_EQ(guessed("/x/truck_town/a.glb", part("node_7")), "world") << "a town is no truck";
  EXPECT_EQ(guessed("/x/y/z.glb", part("node_7")), "");
}

// A folder above counts only if the folder between says what kind of files it has. The folder of a place with objects
// of several kinds says nothing about the parts that have no telling name.
TEST(Guess, OnlyAModelsOwnFolderStatesItsConcept) {
  EXPECT_EQ(guessed("/tracks/road/forza/forza.ac", part("OBJECT03702")), "");
  EXPECT_EQ(guessed("/models/bus/Meshes/base.dae", part("Box001")), "bus");
  Asset track;
  track.file = "/tracks/road/forza.ac";
  track.parts = {part("OBJECT1", "", "wall.png"), part("OBJECT2", "", "sand.png"), part("OBJECT3")};
  EXPECT_EQ(guesses(track).at(2)->name, "road");
  track.parts.push_back(part("OBJECT4", "", "oak.png"));
  EXPECT_EQ(guesses(track).at(2), nullptr);
}

// The name of a file states what the file shows, unless its parts are objects of several kinds.
TEST(Guess, AFileNamedAfterOneOfItsObjectsIsAPlace) {
  Asset yard;
  yard.file = "/x/house.obj";
  yard.parts = {part("Walls", "brick"), part("Box001", "paint"), part("Tree_1", "bark"), part("Lawn")};
  EXPECT_EQ(guesses(yard).at(1)->name, "building");
  yard.parts.push_back(part("Car", "paint"));
  EXPECT_EQ(guesses(yard).at(1), nullptr);
  EXPECT_EQ(guesses(yard).at(2)->name, "trunk");
  EXPECT_EQ(guesses(yard).at(4)->name, "car");
  yard.parts = {part("Walls", "brick"), part("Door"), part("Ceiling"), part("Box001")};
  EXPECT_EQ(guesses(yard).at(3)->name, "building") << "walls and doors are the house's";
}

// A word of most names says nothing of one of them if these name several kinds of objects. That of a single object's
// parts does, as does a name that consists of it.
TEST(Guess, WordsThatMostNamesShareSayNothing) {
  const auto guessedAs = [](const std::vector<std::string>& nodes) {
    Asset asset;
    asset.file = "/x/a.sdf";
    for (const std::string& node : nodes) asset.parts.push_back(part(node));
    std::vector<std::string> found;
    for (const Concept* c : guesses(asset)) found.push_back(c == nullptr ? "" : c->name);
    return found;
  };
  using testing::ElementsAre;
  EXPECT_THAT(guessedAs({"my_warehouse_Shelf_01/l/v", "my_warehouse_Desk/l/v", "my_warehouse_Widget_01/l/v",
                         "my_warehouse_GroundB/l/v", "warehouse", "sun/l/v"}),
              ElementsAre("bookshelf", "desk", "", "ground", "building", ""));
  EXPECT_THAT(guessedAs({"car_body", "car_wheel_1", "car_x_01", "car_bumper"}),
              ElementsAre("car", "car wheel", "car", "car"));
  EXPECT_THAT(guessedAs({"dead_tree", "oak_tree", "old_tree", "lamp", "house"}),
              ElementsAre("tree", "tree", "tree", "street lamp", "building"));
  EXPECT_THAT(guessedAs({"house_wall", "house_door_2", "house_trim", "house_roof"}),
              ElementsAre("wall", "door", "building", "building"));
}

// A box of this size in the file's units, its corner there.
Asset box(const Vec3d& low, const Vec3d& size, const std::string& name) {
  Asset asset;
  asset.file = "/x/" + name + ".obj";
  AssetPart p = part(name);
  for (int i = 0; i < 8; ++i) {
    p.positions.push_back(Vec3f(low + Vec3d{i & 1 ? size.x : 0, i & 2 ? size.y : 0, i & 4 ? size.z : 0}));
  }
  p.triangles = {{0, 1, 2}, {5, 6, 7}};
  asset.parts = {p};
  return asset;
}

FrameGuess frameOf(const Asset& asset) {
  FrameGuess guess = guessFrame(asset, guesses(asset));
  guessUnitsTogether({&guess});
  return guess;
}

TEST(Guess, UnitsByTheUsualSizeOfThings) {
  EXPECT_EQ(frameOf(box({-90, -35, 0}, {180, 70, 60}, "sedan")).unit, 0.0254);
  EXPECT_EQ(frameOf(box({-225, -90, 0}, {450, 180, 150}, "sedan")).unit, 0.01);
  EXPECT_EQ(frameOf(box({-2250, -900, 0}, {4500, 1800, 1500}, "sedan")).unit, 0.001);
  const FrameGuess metres = frameOf(box({-2.2, -0.9, 0}, {4.5, 1.8, 1.5}, "sedan"));
  EXPECT_EQ(metres.unit, 1);
  EXPECT_TRUE(metres.whyUnit.empty());
  EXPECT_NE(frameOf(box({-90, -35, 0}, {180, 70, 60}, "sedan")).whyUnit.find("4.57 m"), std::string::npos);
  EXPECT_EQ(frameOf(box({-90, -35, 0}, {180, 70, 60}, "thing")).unit, 1) << "no word says what it is";
}

// A unit that the file or its format states is never replaced by a guess; an unusual size is a doubt.
TEST(Guess, AStatedUnitCounts) {
  Asset asset = box({-90, -35, 0}, {180, 70, 60}, "sedan");
  asset.statedUnit = 1;
  const FrameGuess frame = frameOf(asset);
  EXPECT_EQ(frame.unit, 1);
  EXPECT_TRUE(frame.doubtfulUnit);
  EXPECT_EQ(frame.whyUnit, "a car of 180 m is unusual; `unit: 0.0254` would make it 4.57 m");
  asset = box({-2.2, -0.9, 0}, {4.5, 1.8, 1.5}, "sedan");
  asset.statedUnit = 1;
  EXPECT_FALSE(frameOf(asset).doubtfulUnit);
}

// A place has any size, but its objects have not.
TEST(Guess, UnitsOfPlacesByTheirObjects) {
  const auto place = [](double scale) {
    Asset asset;
    asset.file = "/x/yard.obj";
    const std::pair<const char*, double> objects[] = {{"Ground", 60}, {"sedan", 4.4}, {"person", 1.8}, {"Terrain", 9}};
    for (const auto& [name, size] : objects) {
      AssetPart p = box({}, Vec3d{size, size / 3, size / 3} * scale, name).parts.front();
      p.nodeIndex = static_cast<std::uint32_t>(asset.parts.size());
      asset.parts.push_back(p);
    }
    return asset;
  };
  EXPECT_EQ(frameOf(place(1)).unit, 1);
  EXPECT_EQ(frameOf(place(1000)).unit, 0.001);
  EXPECT_EQ(frameOf(place(100)).unit, 0.01);
  EXPECT_THAT(frameOf(place(1000)).whyUnit, testing::HasSubstr("units is"));
}

// One unit for the files of a folder, where most fit their names with it; each its own where they do not.
TEST(Guess, FilesOfAFolderHaveOneUnit) {
  const auto units = [](const std::vector<Asset>& assets) {
    std::vector<FrameGuess> frames;
    frames.reserve(assets.size());
    for (const Asset& a : assets) frames.push_back(guessFrame(a, guesses(a)));
    std::vector<FrameGuess*> all;
    for (FrameGuess& f : frames) all.push_back(&f);
    guessUnitsTogether(all);
    std::vector<std::pair<double, bool>> found;
    for (const FrameGuess& f : frames) found.emplace_back(f.unit, f.doubtfulUnit);
    return found;
  };
  using Found = std::vector<std::pair<double, bool>>;
  const auto car = [](double unit) {
    return box({-2 / unit, -1 / unit, 0}, {4.5 / unit, 2 / unit, 1.5 / unit}, "sedan");
  };
  const auto thing = [](double m) { return box({0, 0, 0}, {m, m / 2, m / 3}, "thing"); };
  EXPECT_EQ(units({car(0.01), car(0.01), thing(300)}), (Found{{0.01, false}, {0.01, false}, {0.01, false}}))
      << "what has no name that tells is as the others";
  EXPECT_EQ(units({car(0.01), car(1), car(1), car(1), car(1)}),
            (Found{{0.01, false}, {1, false}, {1, false}, {1, false}, {1, false}}));
  EXPECT_EQ(units({car(0.01), car(1)}), (Found{{0.01, false}, {1, false}})) << "no one unit for most";
  // A car of 12 m, among four that fit: more likely long than in another unit.
  const Asset limousine = box({-6, -1, 0}, {12, 2, 1.5}, "sedan");
  EXPECT_EQ(units({limousine, car(1), car(1), car(1), car(1)}).front(), std::pair(1.0, true));
}

// However many triangles wheels have.
TEST(Guess, ACarIsAsLargeAsItsBody) {
  Asset car = box({-225, -90, 0}, {450, 180, 150}, "sedan");
  AssetPart wheel = box({-150, -95, 0}, {60, 20, 60}, "wheel_1").parts.front();
  for (int i = 0; i < 50; ++i) wheel.triangles.push_back({0, 1, 2});
  car.parts.push_back(wheel);
  EXPECT_EQ(frameOf(car).unit, 0.01);
}

// Tiles say a ground and what stands on it; other names hold words of grounds too.
TEST(Guess, TilesByTheirNames) {
  Vocabulary words(concepts());
  const auto ground = [&](const char* file) {
    const Concept* const c = groundIn(words, file);
    return c == nullptr ? std::string() : c->name;
  };
  EXPECT_EQ(ground("/x/grass-trees.glb"), "terrain");
  EXPECT_EQ(ground("/x/road-straight-lightposts.glb"), "road");
  EXPECT_EQ(ground("/x/pavement-fountain.glb"), "sidewalk");
  for (const char* const other :
       {"street_lamp", "road-sign", "stone-wall", "floor_lamp", "water_tower", "house", "road"}) {
    EXPECT_EQ(ground((std::string("/x/") + other + ".obj").c_str()), "") << other;
  }
  EXPECT_EQ(ground("/x/street_kit_house.obj"), "road");
  words.ignoreShared({"street_kit_house", "street_kit_tree", "street_kit_car", "street_kit_grass_trees"});
  EXPECT_EQ(ground("/x/street_kit_house.obj"), "") << "a word that all names share";
  EXPECT_EQ(ground("/x/street_kit_grass_trees.obj"), "terrain");
}

// Most of its triangles are chairs, and yet it is no chair.
TEST(Guess, ARoomIsAsLargeAsItIs) {
  Asset room;
  room.file = "/x/mesh.obj";
  for (const char* name : {"chair_1", "chair_2", "table", "wall"}) {
    room.parts.push_back(box({0, 0, -0.1}, {6.2, 5.2, 2.9}, name).parts.front());
  }
  const FrameGuess frame = frameOf(room);
  EXPECT_EQ(frame.unit, 1);
  EXPECT_TRUE(frame.whyUnit.empty());
  EXPECT_EQ(frame.up, 'z');
  for (AssetPart& p : room.parts) {
    for (Vec3f& v : p.positions) v = {v.x, v.z, -v.y};
  }
  EXPECT_EQ(frameOf(room).up, 'y');
}

TEST(Guess, TheAxisByWhatIsTallOrLow) {
  EXPECT_EQ(frameOf(box({-1, 0, -1}, {2, 9, 2}, "oak")).up, 'y');
  EXPECT_EQ(frameOf(box({-1, -1, 0}, {2, 2, 9}, "oak")).up, 'z');
  EXPECT_EQ(frameOf(box({-2, 0, -1}, {4.5, 1.5, 1.8}, "sedan")).up, 'y');
  EXPECT_EQ(frameOf(box({-2, -1, 0}, {4.5, 1.8, 1.5}, "sedan")).up, 'z');
  EXPECT_EQ(frameOf(box({-100, -3, -100}, {200, 6, 200}, "terrain")).up, 'y');
  Asset declared = box({-1, 0, -1}, {2, 9, 2}, "oak");
  declared.upDeclared = true;
  EXPECT_EQ(frameOf(declared).up, 'z');
  EXPECT_TRUE(frameOf(declared).whyUp.empty()) << "the file says it";
}

}  // namespace
}  // namespace scanmill::draft
