// Assets made by others.

#include <set>
#include <string>

#include "assets/asset.h"
#include "assets/meshes/asset_parts.h"
#include "base/error.h"
#include "config/text.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/shared_data.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

TEST(SharedAssets, EveryFileLoadsOrIsRefused) {
  SKIP_WITHOUT_SHARED_DATA("scenes");
  const std::set<std::string> kKinds{".gltf", ".glb", ".obj", ".dae", ".stl", ".ac"};
  int loaded = 0;
  int trees = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(sharedData() / "scenes")) {
    const std::filesystem::path& file = entry.path();
    if (!kKinds.contains(lowerExtension(file))) continue;
    if (file.parent_path().filename() == "tree1" && ++trees > 5) continue;  // hundreds of leaves of one tree
    try {
      const Asset asset = readAsset(file, {.textures = false});
      ++loaded;
      for (const AssetPart& part : asset.parts) {
        EXPECT_FALSE(part.triangles.empty());
        EXPECT_TRUE(part.uvs.empty() || part.uvs.size() == part.positions.size()) << file;
        for (const Triangle& t : part.triangles) {
          ASSERT_LT(std::max({t[0], t[1], t[2]}), part.positions.size()) << file;
        }
      }
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr(file.filename().string()));
    }
  }
  EXPECT_GT(loaded, 60);
}

TEST(SharedAssets, TheTownHasItsTrianglesNodesAndTextures) {
  SKIP_WITHOUT_SHARED_DATA("scenes/truck_town");
  const Asset town = readAsset(sharedData() / "scenes/truck_town/model/town_model.gltf", {});
  EXPECT_EQ(trianglesOf(town), 30477u);  // the sum over the nodes; collision shapes have no node with a mesh
  const Box box = boundsOf(town);
  EXPECT_NEAR(box.high.x - box.low.x, 2048, 16);
  EXPECT_NEAR(box.high.y - box.low.y, 2048, 16);
  EXPECT_LT(box.high.z - box.low.z, 60);
  int found = 0;
  for (const AssetPart& part : town.parts) {
    if (part.node == "RoadMesh") {
      ++found;
      EXPECT_EQ(part.texture, "textures/cement_lossy.webp");
      EXPECT_TRUE(part.fileMaterial.textured);
    }
    if (part.node == "GrassMesh") {
      ++found;
      EXPECT_EQ(part.texture, "textures/grass_lossy.webp");
      EXPECT_TRUE(part.fileMaterial.texture);
      EXPECT_FALSE(part.fileMaterial.alphaTested);
    }
  }
  EXPECT_EQ(found, 2);
}

TEST(SharedAssets, GazeboModelsHaveTheirRealSizes) {
  SKIP_WITHOUT_SHARED_DATA("scenes/gazebo");
  struct Case {
    const char* file;
    double scale;      // of the model's SDF
    double low, high;  // what the height may be, m
  };
  for (const Case& each : {Case{"suv/meshes/suv.obj", 0.06, 1.5, 2.5},
                           {"bus/meshes/bus.obj", 0.01, 2.5, 4.5},
                           {"ambulance/meshes/ambulance.obj", 0.0254, 2, 3.5},
                           {"pickup/meshes/pickup.dae", 1, 1.5, 2.2},
                           {"hatchback/meshes/hatchback.obj", 0.0254, 1.2, 1.8},
                           {"stop_sign/meshes/stop_sign.dae", 1, 1.5, 3},
                           {"dumpster/meshes/dumpster.dae", 1.5, 1, 2.5},
                           {"fire_hydrant/meshes/fire_hydrant.dae", 1, 0.5, 1.2},
                           {"telephone_pole/meshes/telephone_pole.dae", 1, 6, 12},
                           {"lamp_post/meshes/lamp_post.dae", 3, 6, 12},
                           {"oak_tree/meshes/oak_tree.dae", 1, 6, 7},
                           {"pine_tree/meshes/pine_tree.dae", 1, 5, 5.2},
                           {"mailbox/meshes/mailbox.dae", 1, 1, 1.1},
                           {"jersey_barrier/meshes/jersey_barrier.dae", 1, 1.1, 1.2},
                           {"house_2/meshes/house_2.dae", 1, 4.5, 5},
                           {"house_1/meshes/house_1.dae", 1, 5, 5.25}}) {
    const Box box = boundsOf(
        readAsset(sharedData() / "scenes/gazebo" / each.file, {.metresPerUnit = each.scale, .textures = false}));
    EXPECT_GT(box.high.z - box.low.z, each.low) << each.file;
    EXPECT_LT(box.high.z - box.low.z, each.high) << each.file;
    EXPECT_NEAR(box.low.z, 0, 0.15) << each.file;  // upright, standing on the ground
  }
}

// Their bodies are 42 to 64 % without alpha, where the paint goes; the post's alpha is all outside its surface.
TEST(SharedAssets, BodiesOfGazeboCarsAreSolid) {
  SKIP_WITHOUT_SHARED_DATA("scenes/gazebo");
  for (const char* file : {"bus/meshes/bus.obj", "suv/meshes/suv.obj", "hatchback/meshes/hatchback.obj",
                           "hatchback_blue/meshes/hatchback.obj", "ambulance/meshes/ambulance.obj",
                           "pickup/meshes/pickup.dae", "lamp_post/meshes/lamp_post.dae"}) {
    const std::filesystem::path path = sharedData() / "scenes/gazebo" / file;
    int textured = 0;
    for (const AssetPart& part : readAsset(path, {}).parts) {
      EXPECT_FALSE(part.fileMaterial.alphaTested) << file << ' ' << part.material;
      textured += part.fileMaterial.textured ? 1 : 0;
    }
    EXPECT_GT(textured, 0) << file;
  }
  bool tested = false;
  for (const AssetPart& part :
       readAsset(sharedData() / "scenes/gazebo/suv/meshes/suv.obj", {.alpha = AlphaUse::Test}).parts) {
    tested = tested || part.fileMaterial.alphaTested;
  }
  EXPECT_TRUE(tested);
}

}  // namespace
}  // namespace scanmill
