#include "scene/voxels.h"

#include <functional>

#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::ElementsAre;

const VoxelGrid kSmall{0.5, {-4, -5, -2}, {16, 20, 8}};

// Calls visit(index, low corner in m) for each voxel as it really lies.
void forEachVoxel(const VoxelGrid& grid, const std::function<void(std::size_t, const Vec3d&)>& visit) {
  for (std::uint32_t x = 0; x < grid.counts[0]; ++x) {
    for (std::uint32_t y = 0; y < grid.counts[1]; ++y) {
      for (std::uint32_t z = 0; z < grid.counts[2]; ++z) {
        const auto along = [&](double low, std::uint32_t i) { return low + (i - VoxelGrid::kLower) * grid.size; };
        visit(grid.index(x, y, z), {along(grid.low.x, x), along(grid.low.y, y), along(grid.low.z, z)});
      }
    }
  }
}

std::vector<std::uint16_t> labelsOf(const Scene& scene, const VoxelGrid& grid, const Pose& worldFromGrid = {},
                                    double time = 0) {
  return SceneVoxels(scene).labels(grid, worldFromGrid, time).label;
}

std::vector<std::size_t> occupied(const std::vector<std::uint16_t>& labels) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] != 0) indices.push_back(i);
  }
  return indices;
}

Scene boxScene(const Vec3d& low, const Vec3d& high) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  const Vec3d middle = (low + high) * 0.5;
  appendBox(mesh, 0, at(middle.x, middle.y, middle.z), high - low);
  return sceneWith(builder, mesh);
}

// The same scene, carried elsewhere.
Scene carried(Scene scene, const Pose& pose) {
  for (Instance& instance : scene.instances) {
    instance.worldFromMesh.linear = toMatrix(pose.rotation) * instance.worldFromMesh.linear;
    instance.worldFromMesh.translation = pose * instance.worldFromMesh.translation;
  }
  return scene;
}

// A plane is in a voxel where its height, over the voxel's ground, is neither wholly above nor wholly below it.
TEST(Voxels, OfAPlaneAreThoseThatItPassesThrough) {
  for (const auto& [slopeX, slopeY] : {std::pair{0.0, 0.0}, {0.31, 0.0}, {-0.23, 0.57}, {1.7, -2.9}}) {
    SceneBuilder builder = testBuilder();
    Mesh mesh = meshOf(builder, "ground");
    const auto height = [&](double x, double y) { return 0.13 + slopeX * x + slopeY * y; };
    const auto corner = [&](double x, double y) { return Vec3d{x, y, height(x, y)}; };
    appendQuad(mesh, 0, corner(-64, -64), corner(64, -64), corner(64, 64), corner(-64, 64));
    const std::vector<std::uint16_t> labels = labelsOf(sceneWith(builder, mesh), kSmall);
    std::size_t count = 0;
    forEachVoxel(kSmall, [&](std::size_t i, const Vec3d& low) {
      const double one = height(low.x, low.y);
      const double least = one + kSmall.size * (std::min(slopeX, 0.0) + std::min(slopeY, 0.0));
      const double most = one + kSmall.size * (std::max(slopeX, 0.0) + std::max(slopeY, 0.0));
      // Mesh corners are float32.
      const double clear = std::min(std::abs(least - low.z - kSmall.size), std::abs(most - low.z));
      if (clear < 1e-4) return;
      const bool inside = least < low.z + kSmall.size && most > low.z;
      EXPECT_EQ(labels[i], inside ? 1 : 0) << low.x << " " << low.y << " " << low.z;
      count += inside ? 1 : 0;
    });
    EXPECT_GT(count, 200u);
  }
}

TEST(Voxels, OfABoxAreThoseOfItsFacesAndItIsHollow) {
  const Vec3d least{-2.3, -3.1, -1.2};
  const Vec3d most{1.8, 2.2, 0.9};
  const std::vector<std::uint16_t> labels = labelsOf(boxScene(least, most), kSmall);
  forEachVoxel(kSmall, [&](std::size_t i, const Vec3d& low) {
    const auto overlaps = [&](auto axis) { return low.*axis < most.*axis && low.*axis + kSmall.size > least.*axis; };
    const auto within = [&](auto axis) { return low.*axis > least.*axis && low.*axis + kSmall.size < most.*axis; };
    const bool touches = overlaps(&Vec3d::x) && overlaps(&Vec3d::y) && overlaps(&Vec3d::z);
    const bool inside = within(&Vec3d::x) && within(&Vec3d::y) && within(&Vec3d::z);
    EXPECT_EQ(labels[i], touches && !inside ? 2 : 0) << low.x << " " << low.y << " " << low.z;
  });
}

TEST(Voxels, AFaceBetweenTwoIsInTheUpperOneWhateverTheRounding) {
  for (const double error : {-1e-5, -1e-7, 0.0, 1e-7, 1e-5}) {
    const Vec3d shift{error, error, error};
    const VoxelGrid grid{0.2, {0, 0, 0}, {20, 20, 20}};
    const std::vector<std::uint16_t> labels = labelsOf(boxScene(Vec3d{1, 1, 1} + shift, Vec3d{2, 2, 2} + shift), grid);
    for (std::uint32_t x = 0; x < 20; ++x) {
      const bool wall = x == 5 || x == 10;
      EXPECT_EQ(labels[grid.index(x, 7, 7)], wall ? 2 : 0) << x;
      EXPECT_EQ(labels[grid.index(7, x, 7)], wall ? 2 : 0) << x;
      EXPECT_EQ(labels[grid.index(7, 7, x)], wall ? 2 : 0) << x;
    }
  }
}

// Ground and a thing share a voxel, a strip of it each.
TEST(Voxels, HaveTheClassOfTheLargestArea) {
  const auto label = [](double groundWidth, double thingWidth, bool groundFirst) {
    SceneBuilder builder = testBuilder();
    const auto place = [&](const char* name, double low, double high) {
      Mesh mesh = meshOf(builder, name);
      appendQuad(mesh, 0, {low, 0.125, 0.25}, {high, 0.125, 0.25}, {high, 0.375, 0.25}, {low, 0.375, 0.25});
      builder.place(builder.addMesh(mesh), {}, name);
    };
    if (groundFirst) place("ground", 0, groundWidth);
    place("thing", 0.5 - VoxelGrid::kLower - thingWidth, 0.5 - VoxelGrid::kLower);
    if (!groundFirst) place("ground", 0, groundWidth);
    return labelsOf(builder.finish(), {0.5, {0, 0, 0}, {1, 1, 1}}).front();
  };
  for (const bool groundFirst : {true, false}) {
    EXPECT_EQ(label(0.26, 0.24, groundFirst), 1);
    EXPECT_EQ(label(0.24, 0.26, groundFirst), 2);
    EXPECT_EQ(label(0.125, 0.125, groundFirst), 1) << "the smaller id where both are as large";
  }
}

TEST(Voxels, OfThreeClassesCountWhateverTheirOrder) {
  std::vector<std::string> names{"ground", "thing", "other"};
  do {
    SceneBuilder builder = testBuilder();
    for (const std::string& name : names) {
      Mesh mesh = meshOf(builder, name.c_str());
      const double width = name == "other" ? 0.3 : name == "thing" ? 0.2 : 0.1;
      for (int part = 0; part < 2; ++part) appendPlane(mesh, 0, at(0.25, 0.25, 0.1 + 0.1 * part), width, 0.1);
      builder.place(builder.addMesh(mesh), {}, name);
    }
    EXPECT_EQ(labelsOf(builder.finish(), {0.5, {0, 0, 0}, {1, 1, 1}}).front(), 3);
  } while (std::next_permutation(names.begin(), names.end()));
}

TEST(Voxels, OfNoClassAreNamed) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "unlabeled");
  appendBox(mesh, 0, at(0.3, 0.3, 0.3), {0.1, 0.1, 0.1});
  const VoxelGrid grid{0.5, {0, 0, 0}, {2, 2, 2}};
  const VoxelLabels labels = SceneVoxels(sceneWith(builder, mesh)).labels(grid, {}, 0);
  EXPECT_THAT(occupied(labels.label), testing::IsEmpty());
  EXPECT_THAT(labels.unlabeled, ElementsAre(0u));
}

// At UTM coordinates and beyond, and whichever way the sensor looks.
TEST(Voxels, MoveAndTurnWithTheScene) {
  const Scene street = proceduralStreet();
  const Pose sensor{fromYawPitchRoll(0.4, 0.02, -0.01), {20, -1.75, 1.9}};
  const std::vector<std::uint16_t> labels = labelsOf(street, {}, sensor);
  EXPECT_GT(occupied(labels).size(), 20000u);
  for (const Pose& pose : {Pose{{}, {1e7, -5e6, 4096}}, Pose{fromYawPitchRoll(1.3, 0.2, 2.9), {3, 4, 5}},
                           Pose{fromYawPitchRoll(-2.1, 1, 0.5), {4e5, 5.4e6, 300}}}) {
    const std::vector<std::uint16_t> elsewhere = labelsOf(carried(street, pose), {}, pose * sensor);
    std::size_t differ = 0;
    for (std::size_t i = 0; i < labels.size(); ++i) differ += labels[i] != elsewhere[i] ? 1 : 0;
    EXPECT_EQ(differ, 0u) << pose.translation.x;
  }
}

TEST(Voxels, OfWhatMovesAreWhereItIsAndHaveTheClassForThat) {
  Ontology ontology = testOntology();
  ontology.classes.push_back({7, "moving thing", {1, 1, 1}, true, {}, 2});
  SceneBuilder builder("test", 1, ontology, testMaterials());
  Mesh mesh = meshOf(builder, "thing");
  appendBox(mesh, 0, {}, {0.2, 0.2, 0.2});
  const std::uint32_t box = builder.addMesh(mesh);
  builder.place(box, at(0.25, 0.25, 0.25), "standing");
  builder.place(box, at(0.25, 1.25, 0.25), "moving", {}, std::make_shared<const Movement>(Vec3d{0.5, 0, 0}));
  const Scene scene = builder.finish();
  const SceneVoxels voxels(scene);
  const VoxelGrid grid{0.5, {0, 0, 0}, {8, 4, 1}};
  for (std::uint32_t seconds = 0; seconds < 6; ++seconds) {
    const std::vector<std::uint16_t> labels = voxels.labels(grid, {}, seconds).label;
    EXPECT_THAT(occupied(labels), testing::UnorderedElementsAre(grid.index(0, 0, 0), grid.index(seconds, 2, 0)));
    EXPECT_EQ(labels[grid.index(0, 0, 0)], 2);
    EXPECT_EQ(labels[grid.index(seconds, 2, 0)], 7);
  }
}

TEST(Voxels, OfWhatChangesItsShapeAreThoseOfTheMoment) {
  SceneBuilder builder = testBuilder();
  Mesh low = meshOf(builder, "thing");
  appendBox(low, 0, at(0.25, 0.25, 0.25), {0.2, 0.2, 0.2});
  Mesh high = meshOf(builder, "thing");
  appendBox(high, 0, at(0.25, 0.25, 1.25), {0.2, 0.2, 0.2});
  const std::uint32_t first = builder.addMesh(low);
  const std::uint32_t second = builder.addMesh(high);
  builder.place(first, {}, "walker", {}, nullptr, std::make_shared<const Animation>(Animation{{first, second}, 1, 10}));
  const Scene scene = builder.finish();
  const SceneVoxels voxels(scene);
  const VoxelGrid grid{0.5, {0, 0, 0}, {1, 1, 4}};
  EXPECT_THAT(voxels.labels(grid, {}, 1).label, ElementsAre(2, 0, 0, 0));
  EXPECT_THAT(voxels.labels(grid, {}, 1.5).label, ElementsAre(0, 0, 2, 0));
}

// Whatever the instances of a mesh are placed by.
TEST(Voxels, OfPlacedMeshesAreThoseOfTheirTriangles) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  appendBox(mesh, 0, {}, {1, 1, 1});
  const Scene flatAndMirrored = sceneWith(builder, mesh, {Mat3::scale({2, -1, 0.5}), {0.3, 0.3, 0.4}});
  const Scene box = boxScene({-0.7, -0.2, 0.15}, {1.3, 0.8, 0.65});
  EXPECT_EQ(labelsOf(flatAndMirrored, kSmall), labelsOf(box, kSmall));
}

TEST(VoxelGrid, IsSemanticKittisByDefault) {
  const VoxelGrid grid;
  EXPECT_EQ(grid.voxels(), 256u * 256 * 32);
  EXPECT_EQ(grid.index(0, 0, 1), 1u);
  EXPECT_EQ(grid.index(0, 1, 0), 32u);
  EXPECT_EQ(grid.index(1, 0, 0), 256u * 32);
  EXPECT_EQ(grid.at({0.1, -25.5, -1.9}), 0u);
  EXPECT_EQ(grid.at({51.1, 25.5, 4.3}), grid.voxels() - 1);
  EXPECT_EQ(grid.at({0.1, 0.1, 0.1}), grid.index(0, 128, 10));
  for (const Vec3d& outside : {Vec3d{-0.1, 0, 0},
                               {51.3, 0, 0},
                               {1, -25.7, 0},
                               {1, 25.7, 0},
                               {1, 0, -2.1},
                               {1, 0, 4.5},
                               {NAN, 0, 0},
                               {1, INFINITY, 0}}) {
    EXPECT_EQ(grid.at(outside), std::nullopt) << outside.x;
  }
}

TEST(VoxelGrid, WhatLiesBetweenTwoVoxelsIsInTheUpperWhateverTheRounding) {
  const VoxelGrid grid;
  for (int i = 0; i < 32; ++i) {
    for (const double error : {-1e-5, -1e-9, 0.0, 1e-9, 1e-5}) {
      EXPECT_EQ(grid.at({1.1, 0.1, -2 + 0.2 * i + error}), grid.index(5, 128, static_cast<std::uint32_t>(i)));
    }
  }
}

}  // namespace
}  // namespace scanmill
