#include <bit>
#include <functional>

#include "base/parallel.h"
#include "base/random.h"
#include "methods/field/distance_field.h"
#include "methods/particle/options.h"
#include "tests/core/methods/field/triangle_soup.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

double toSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const double length2 = dot(b - a, b - a);
  const double t = length2 > 0 ? std::clamp(dot(p - a, b - a) / length2, 0.0, 1.0) : 0.0;
  return length(p - (a + (b - a) * t));
}

// The lesser of the distances to the edges, or to the plane from where the triangle is right below.
double toTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double edges = std::min({toSegment(p, a, b), toSegment(p, b, c), toSegment(p, c, a)});
  const Vec3d n = cross(b - a, c - a);
  const double n2 = dot(n, n);
  if (!(n2 > 1e-18 * std::pow(std::max({dot(b - a, b - a), dot(c - a, c - a), dot(c - b, c - b)}), 2))) return edges;
  const double u = dot(cross(b - a, p - a), n);
  const double v = dot(cross(c - b, p - b), n);
  const double w = dot(cross(a - c, p - c), n);
  if (u < 0 || v < 0 || w < 0) return edges;
  return std::min(edges, std::fabs(dot(p - a, n)) / std::sqrt(n2));
}

double toTriangle(const World& world, std::uint32_t triangle, const Vec3d& p) {
  const auto corner = [&](int i) { return Vec3d(world.baked.vertices[world.baked.corners[triangle][i]]); };
  return toTriangle(p, corner(0), corner(1), corner(2));
}

// Whether a triangle meets the cube that reaches `half` around p: what is left of it between the cube's faces.
bool meetsCube(const World& world, std::uint32_t triangle, const Vec3d& p, double half) {
  std::vector<std::array<double, 3>> polygon;
  for (const std::uint32_t vertex : world.baked.corners[triangle]) {
    const Vec3d corner = Vec3d(world.baked.vertices[vertex]) - p;
    polygon.push_back({corner.x, corner.y, corner.z});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      std::vector<std::array<double, 3>> left;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto& a = polygon[i];
        const auto& b = polygon[(i + 1) % polygon.size()];
        const double inA = half - side * a[axis];
        const double inB = half - side * b[axis];
        if (inA >= 0) left.push_back(a);
        if ((inA < 0) == (inB < 0)) continue;
        const double t = inA / (inA - inB);
        left.push_back({a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t});
        left.back()[axis] = side * half;
      }
      polygon = std::move(left);
    }
  }
  return !polygon.empty();
}

// A corner, or a brick's centre: m, relative to the world's origin.
Vec3d placeOf(double voxel, const Corner& brick, double x, double y, double z) {
  return {(double(brick[0] * 8) + x) * voxel, (double(brick[1] * 8) + y) * voxel, (double(brick[2] * 8) + z) * voxel};
}

// Calls visit(level, brick, entry) for all bricks.
void eachBrick(const DistanceField& field,
               const std::function<void(std::size_t, const Corner&, std::uint32_t)>& visit) {
  for (std::size_t l = 0; l < field.levels.size(); ++l) {
    const LevelBox& box = field.shape.levels[l];
    std::uint32_t entry = field.levels[l].firstEntry;
    for (std::uint32_t z = 0; z < box.bricks[2]; ++z) {
      for (std::uint32_t y = 0; y < box.bricks[1]; ++y) {
        for (std::uint32_t x = 0; x < box.bricks[0]; ++x) {
          visit(l, {box.firstBrick[0] + x, box.firstBrick[1] + y, box.firstBrick[2] + z}, field.table[entry++]);
        }
      }
    }
  }
}

// Holds one corner, at p, against brute force; distances in voxels.
void checkCorner(const World& world, const DistanceField& field, const std::vector<double>& distances,
                 std::size_t corner, const Vec3d& p, double voxel) {
  constexpr double kNear = 1e-4;  // distances of facets come out of float32, and so do cubes
  const double truth = *std::min_element(distances.begin(), distances.end());
  const double stored = field.distance[corner] * kDistanceStep;
  EXPECT_LE(stored, truth);
  EXPECT_GE(stored, std::min<double>(truth, kExactLimit) - 1.1 * kDistanceStep);
  const std::uint32_t word = field.triangleOrList[corner];
  if (stored > (field.shape.lists ? kListLimit : kNearestLimit)) {
    EXPECT_EQ(word, kNoTriangle);
    return;
  }
  if (!field.shape.lists) {
    ASSERT_NE(word, kNoTriangle);
    EXPECT_LE(distances[word], truth + kNear);
    return;
  }
  const std::vector<std::uint32_t> list = word == kNoTriangle ? std::vector<std::uint32_t>{} : listAt(field, word);
  const auto order = [&](std::uint32_t t) { return std::pair(world.baked.surfaceOf(t).instance, t); };
  for (std::size_t i = 1; i < list.size(); ++i) EXPECT_LT(order(list[i - 1]), order(list[i]));
  for (const std::uint32_t t : list) EXPECT_TRUE(meetsCube(world, t, p, (kListHalfSide + kNear) * voxel)) << t;
  for (std::uint32_t t = 0; t < distances.size(); ++t) {
    if (distances[t] > 1 || !meetsCube(world, t, p, (kListHalfSide - kNear) * voxel)) continue;
    EXPECT_TRUE(std::find(list.begin(), list.end(), t) != list.end()) << t;
  }
}

// Holds every `stride`-th corner and every brick's centre against brute force. How many corners named triangles.
std::size_t checkAgainstBruteForce(const World& world, const DistanceField& field, std::size_t stride) {
  std::size_t named = 0;
  std::size_t next = 0;
  std::vector<double> distances(world.baked.triangles.size());
  const auto measure = [&](const Vec3d& p, double voxel) {
    for (std::uint32_t t = 0; t < distances.size(); ++t) distances[t] = toTriangle(world, t, p) / voxel;
  };
  eachBrick(field, [&](std::size_t level, const Corner& brick, std::uint32_t entry) {
    const double voxel = std::ldexp(field.shape.voxel, int(level));
    measure(placeOf(voxel, brick, 4, 4, 4), voxel);
    const double centre = *std::min_element(distances.begin(), distances.end());
    if (entry < kFullBrick) {
      const auto stored = std::bit_cast<float>(entry);
      EXPECT_GE(stored, kEmptyBrick);
      EXPECT_LE(stored, centre);
      EXPECT_GE(stored, centre * (1 - 2e-5));
      return;
    }
    EXPECT_LT(centre, kEmptyBrick * (1 + 1e-5));
    const std::size_t first = std::size_t{entry - kFullBrick} * kBrickStride;
    for (; next < kCornersPerBrick; next += stride) {
      const std::size_t x = next % 9;
      const std::size_t y = next / 9 % 9;
      const std::size_t z = next / 81;
      const Vec3d p = placeOf(voxel, brick, double(x), double(y), double(z));
      measure(p, voxel);
      checkCorner(world, field, distances, first + next, p, voxel);
      named += field.triangleOrList[first + next] != kNoTriangle;
    }
    next -= kCornersPerBrick;
  });
  return named;
}

TEST(Build, ScatteredTrianglesOfAllSizes) {
  const Scene scene = sceneOf(soup(60, 3, 0.003, 5));
  const auto world = worldOf(scene);
  for (const bool lists : {false, true}) {
    const auto field = buildField(*world, shapeAt({0.2, 0.1, -0.3}, 0.1, 32, 3, lists));
    EXPECT_GT(checkAgainstBruteForce(*world, *field, 11), 300u);
  }
}

// Many triangles near a brick: its corners, or its blocks of corners, search.
TEST(Build, ThousandsOfSmallTriangles) {
  const auto check = [](const std::vector<std::array<Vec3f, 3>>& triangles, std::size_t stride) {
    const Scene scene = sceneOf(triangles);
    const auto world = worldOf(scene);
    for (const bool lists : {false, true}) {
      const auto field = buildField(*world, shapeAt({0.5, 0, 0}, 0.1, 32, 2, lists));
      EXPECT_GT(checkAgainstBruteForce(*world, *field, stride), 50u);
    }
  };
  check(soup(12000, 0.6, 0.002, 0.05), 53);
  check(soup(700, 0.15, 0.002, 0.05), 3);
  check(soup(2500, 0.8, 0.01, 0.3), 19);
}

TEST(Build, HugeTrianglesUnderSmallVoxels) {
  auto triangles = soup(8, 0.05, 0.01, 0.1);
  triangles.push_back({Vec3f{-4000, -3000, 0.013f}, {5000, -2500, 0.017f}, {100, 6000, -0.004f}});
  triangles.push_back({Vec3f{0.02f, -3000, -2000}, {0.021f, 2500, -2500}, {0.019f, 100, 3000}});
  const Scene scene = sceneOf(triangles);
  const auto world = worldOf(scene);
  const auto field = buildField(*world, shapeAt({0.003, 0.001, 0}, 0.001, 32, 4, true));
  EXPECT_GT(checkAgainstBruteForce(*world, *field, 31), 300u);
}

TEST(Build, MillimetreVoxelsFarFromTheOrigin) {
  const Vec3d place{511.3, -498.7, 70.1};
  const Scene scene = sceneOf(soup(40, 0.02, 0.0005, 0.03), place);
  const auto world = worldOf(scene);
  for (const bool lists : {false, true}) {
    const auto field = buildField(*world, shapeAt(place, 0.001, 32, 2, lists));
    EXPECT_GT(checkAgainstBruteForce(*world, *field, 31), 100u);
  }
}

TEST(Build, TrianglesThatAreLinesOrPoints) {
  const Vec3f a{0.13f, 0.21f, 0.11f};
  const Vec3f b{0.73f, 0.25f, 0.51f};
  const Vec3f middle{0.43f, 0.23f, 0.31f};
  const Vec3f c{-0.3f, 0.2f, 0.4f};
  const Vec3f nearB{0.73f, 0.25001f, 0.51f};
  const Scene scene = sceneOf({{a, a, a}, {a, b, a}, {a, middle, b}, {c, b, nearB}, {c, c, b}, {b, c, nearB}});
  const auto world = worldOf(scene);
  for (const bool lists : {false, true}) {
    const auto field = buildField(*world, shapeAt({}, 0.1, 32, 2, lists));
    EXPECT_GT(checkAgainstBruteForce(*world, *field, 1), 30u);
  }
}

// Of triangles in the same place, the one of the lowest instance is named: here, of the last copy.
TEST(Build, EquallyNearTrianglesHaveAnOrder) {
  for (const auto& once : {soup(40, 1, 0.1, 1), soup(500, 0.15, 0.002, 0.05)}) {
    std::vector<std::array<Vec3f, 3>> thrice;
    for (int copy = 0; copy < 3; ++copy) thrice.insert(thrice.end(), once.begin(), once.end());
    const Scene scene = sceneOf(thrice);
    const auto world = worldOf(scene);
    const auto count = static_cast<std::uint32_t>(once.size());
    const auto nearest = buildField(*world, shapeAt({}, 0.1, 32, 2, false));
    for (const std::uint32_t word : nearest->triangleOrList) EXPECT_GE(word, 2 * count);
    const auto listed = buildField(*world, shapeAt({}, 0.1, 32, 2, true));
    for (const std::uint32_t word : listed->triangleOrList) {
      if (word == kNoTriangle) continue;
      const std::vector<std::uint32_t> list = listAt(*listed, word);
      const std::size_t copies = list.size() / 3;
      EXPECT_EQ(list.size(), 3 * copies);
      for (std::size_t i = 0; i < list.size(); ++i) EXPECT_EQ(list[i], list[i % copies] - i / copies * count);
      EXPECT_GE(list[0], 2 * count);
    }
  }
}

TEST(Build, AlphaTestedTrianglesAreThereToo) {
  Scene scene = sceneOf(soup(60, 1, 0.05, 1));
  auto texture = std::make_shared<Texture>();
  texture->width = texture->height = 1;
  texture->rgba = {255, 255, 255, 255};
  scene.materials.resize(2);
  scene.materials[1].texture = texture;
  scene.materials[1].alphaTested = true;
  scene.meshes[0].surfaces[0].material = 1;
  const auto world = worldOf(scene);
  EXPECT_EQ(world->baked.firstAlpha, 40u);
  for (const bool lists : {false, true}) {
    const auto field = buildField(*world, shapeAt({}, 0.1, 32, 2, lists));
    EXPECT_GT(checkAgainstBruteForce(*world, *field, 23), 100u);
  }
}

TEST(Build, OneTriangle) {
  const Scene scene = sceneOf({{Vec3f{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
  const auto world = worldOf(scene);
  for (const Vec3d& sensor : {Vec3d{0.1, 0.1, 0.1}, Vec3d{5000, 0, 0}}) {
    const auto field = buildField(*world, shapeAt(sensor, 0.1, 32, 3, true));
    checkAgainstBruteForce(*world, *field, 1);
    EXPECT_EQ(field->distance.empty(), sensor.x > 1000);
  }
}

// A floor 0.7 voxels over one layer of corners and 0.3 under the next: only the voxels around these hold a part of it.
TEST(Build, OnlyVoxelsThatHoldTrianglesHaveLists) {
  static_assert(kListHalfSide > 0.5f && kListHalfSide < 0.58f);
  const Scene scene = sceneOf({{Vec3f{-50, -50, 0.07f}, {50, -50, 0.07f}, {0, 50, 0.07f}}});
  const auto world = worldOf(scene);
  const auto field = buildField(*world, shapeAt({}, 0.1, 32, 1, true));
  std::size_t listed = 0;
  eachBrick(*field, [&](std::size_t, const Corner& brick, std::uint32_t entry) {
    if (entry < kFullBrick) return;
    for (std::uint32_t c = 0; c < kCornersPerBrick; ++c) {
      const std::uint32_t word = field->triangleOrList[std::size_t{entry - kFullBrick} * kBrickStride + c];
      if (brick[2] * kBrickVoxels + c / 81 == 1) {
        ASSERT_NE(word, kNoTriangle);
        EXPECT_EQ(listAt(*field, word), std::vector<std::uint32_t>{0});
        ++listed;
      } else {
        EXPECT_EQ(word, kNoTriangle);
      }
    }
  });
  EXPECT_GT(listed, 1000u);
}

TEST(Build, EmptyWorldIsEmpty) {
  const Scene scene = sceneOf({});
  const auto world = worldOf(scene);
  const auto field = buildField(*world, shapeAt({}, 0.1, 32, 2, true));
  EXPECT_TRUE(field->distance.empty());
  for (const std::uint32_t entry : field->table) EXPECT_GT(std::bit_cast<float>(entry), 1e20f);
}

TEST(Build, MillionTriangles) {
  const Scene scene = oneMeshScene("thing", [](Mesh& mesh) { appendSphere(mesh, 0, {}, 1.0, 1000); });
  EXPECT_GT(scene.placedTriangles(), 900'000u);
  const auto world = worldOf(scene);
  const auto field = buildField(*world, shapeAt({1, 0, 0}, 0.05, 32, 2, false));
  EXPECT_GT(fullBricks(*field), 10u);
  eachBrick(*field, [&](std::size_t level, const Corner& brick, std::uint32_t entry) {
    if (entry < kFullBrick) return;
    const double voxel = std::ldexp(0.05, int(level));
    for (int c = 0; c < kCornersPerBrick; ++c) {
      const double truth = std::fabs(length(placeOf(voxel, brick, c % 9, c / 9 % 9, c / 81)) - 1) / voxel;
      const double stored = field->distance[(entry - kFullBrick) * std::size_t{kBrickStride} + c] * kDistanceStep;
      // The ball's facets lie up to 1e-5 m inside of it.
      ASSERT_LE(stored, truth + 1e-3);
      ASSERT_GE(stored, std::min(truth, 4.0) - 2e-3);
    }
  });
}

TEST(Build, SameBytesWithAnyNumberOfThreads) {
  auto triangles = soup(30, 3, 0.05, 6);
  for (const auto& leaf : soup(5000, 0.5, 0.01, 0.1)) triangles.push_back(leaf);
  const Scene scene = sceneOf(triangles);
  const auto world = worldOf(scene);
  for (const bool lists : {false, true}) {
    const FieldShape shape = shapeAt({}, 0.1, 48, 3, lists);
    std::shared_ptr<const DistanceField> one;
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      const auto field = buildField(*world, shape);
      if (one == nullptr) one = field;
      EXPECT_TRUE(sameField(*field, *one)) << threads;
    }
  }
}

TEST(Build, MovesWithSceneAndOrigin) {
  const auto triangles = soup(100, 2, 0.05, 3);
  const Scene here = sceneOf(triangles);
  const Vec3d shift{1e7, -2e7, 512};
  const Scene there = sceneOf(triangles, shift);
  const FieldShape shape = shapeAt({0.3, 0, 0}, 0.1, 32, 3, true);
  EXPECT_TRUE(sameField(*buildField(*worldOf(here), shape), *buildField(*worldOf(there, shift), shape)));
}

// A scene that moves by whole bricks of the coarsest level takes its field along.
TEST(Build, MovesWithTheSceneByWholeBricks) {
  auto triangles = soup(100, 2, 0.05, 3);
  for (auto& triangle : triangles) {
    for (Vec3f& corner : triangle) {
      const auto snap = [](float x) { return std::round(x * 256) / 256; };  // exact wherever it is moved
      corner = {snap(corner.x), snap(corner.y), snap(corner.z)};
    }
  }
  const Vec3d shift{64, -24, 8};
  const auto here = buildField(*worldOf(sceneOf(triangles)), shapeAt({0.3, 0, 0}, 0.125, 32, 3, true));
  const auto there =
      buildField(*worldOf(sceneOf(triangles, shift)), shapeAt(Vec3d{0.3, 0, 0} + shift, 0.125, 32, 3, true));
  EXPECT_TRUE(std::ranges::equal(there->distance, here->distance));
  EXPECT_TRUE(std::ranges::equal(there->triangleOrList, here->triangleOrList));
  EXPECT_TRUE(std::ranges::equal(there->lists, here->lists));
  EXPECT_EQ(there->table, here->table);
}

TEST(Build, RefusesInstancedMeshes) {
  const Scene scene = sceneOf(soup(4, 1, 0.1, 1));
  const DeviceHandle device = makeDevice();
  const std::vector<bool> instanced(1, true);
  const SharedMeshes shared(device.get(), scene, instanced, {});
  const auto world = buildWorld(device.get(), scene, {}, instanced, shared, {});
  const auto build = [&] { buildField(*world, shapeAt({}, 0.1, 32, 1, false)); };
  EXPECT_THAT(messageOf<Error>(build), testing::HasSubstr("cannot be built of instanced meshes"));
}

}  // namespace
}  // namespace scanmill
