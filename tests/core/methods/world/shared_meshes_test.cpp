#include "methods/world/shared_meshes.h"

#include <map>
#include <numeric>
#include <set>

#include "base/random.h"
#include "methods/ray_tracing/packet.h"
#include "methods/world/world.h"
#include "scene/primitives.h"
#include "tests/support/on_threads.h"
#include "tests/support/same_hits.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// A hilly ground with a coplanar patch of another class over its middle, and large turned, stretched and mirrored
// spheres: each mesh has several parts.
Scene largeMeshes() {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 300, 300, 200);
  for (Vec3f& p : ground.positions) p.z = std::sin(0.1f * p.x) * std::cos(0.07f * p.y);
  Mesh patch = meshOf(builder, "other", "dark");
  for (const Triangle& t : ground.triangles) {
    if (std::abs(ground.positions[t[0]].x) > 60) continue;
    patch.triangles.push_back(t);
    patch.surfaceOf.push_back(0);
  }
  patch.positions = ground.positions;
  builder.place(builder.addMesh(ground), at(0, 0, -2), "ground");
  builder.place(builder.addMesh(patch), at(0, 0, -2), "patch");
  Mesh sphere = meshOf(builder, "thing");
  appendSphere(sphere, 0, {}, 3, 180);
  const std::uint32_t mesh = builder.addMesh(sphere);
  for (std::uint32_t i = 0; i < 12; ++i) {
    const RandomBlock b = randomBlock({7, 0, 0, 0, i, 0, Purpose::Test});
    const double stretch = i % 2 == 0 ? 1 + uniform(b[3]) : -1;
    builder.place(mesh,
                  {toMatrix(fromYawPitchRoll(6 * uniform(b[0]), 0.3, 0.1)) * Mat3::scale({1, stretch, 1}),
                   {120 * uniform(b[1]) - 60, 120 * uniform(b[2]) - 60, 0}},
                  "sphere");
  }
  return builder.finish();
}

std::vector<std::size_t> allParts(const SharedMeshes& shared, const Scene& scene) {
  std::vector<std::size_t> parts(shared.firstPart(scene.meshes.size()));
  std::iota(parts.begin(), parts.end(), std::size_t{0});
  return parts;
}

class SharedParts : public testing::Test {
 protected:
  Scene scene_ = largeMeshes();
  std::vector<bool> all_ = std::vector<bool>(scene_.meshes.size(), true);
  DeviceHandle device_ = makeDevice();
  HierarchyOptions options_{tieFilter, alphaTieFilter, nullptr};

  Hits traced(bool divided, double reach, const Shot& shot) {
    const SharedMeshes shared(device_.get(), scene_, all_, options_, divided);
    const auto world = buildWorld(device_.get(), scene_, {}, all_, shared, options_, {0, 0, reach});
    return traced(*world, shot);
  }

  Hits traced(const World& world, const Shot& shot) {
    const std::vector<CompactMaterial> materials = compactMaterials(scene_);
    const ShotFrame frame = frameOf(shot, {});
    const BeamTable& beams = *shot.beams;
    Hits hits;
    hits.reset(beams.rings, beams.columns, Channels::all());
    std::vector<Tile> tiles;
    for (std::uint32_t ring = 0; ring < beams.rings; ++ring) {
      for (std::uint32_t column = 0; column < beams.columns; column += kPacket) {
        tiles.push_back({ring, column, 1, std::min<std::uint32_t>(kPacket, beams.columns - column)});
      }
    }
    tracePackets({world, materials, shot, frame, coplanarFloor(0)}, tiles, hits);
    return hits;
  }
};

TEST_F(SharedParts, EachTriangleIsInOnePartThatContainsIt) {
  const SharedMeshes shared(device_.get(), scene_, all_, options_, true);
  shared.build(allParts(shared, scene_));
  for (std::size_t m = 0; m < scene_.meshes.size(); ++m) {
    const Mesh& mesh = scene_.meshes[m];
    EXPECT_GT(shared.firstPart(m + 1) - shared.firstPart(m), 1u);
    std::vector<int> found(mesh.triangles.size());
    for (std::size_t p = shared.firstPart(m); p < shared.firstPart(m + 1); ++p) {
      const SharedMeshes::Part& part = shared.part(p);
      const TriangleBlock& block = *part.block;
      ASSERT_EQ(block.corners.size(), block.triangles.size());
      for (std::size_t t = 0; t < block.triangles.size(); ++t) {
        const std::uint32_t own = block.triangles[t].primitive;
        ++found[own];
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3f& corner = block.vertices[block.corners[t][k]];
          ASSERT_EQ(corner, mesh.positions[mesh.triangles[own][k]]);
          Box box = part.bounds;
          box.add(Vec3d(corner));
          ASSERT_EQ(box.low, part.bounds.low);
          ASSERT_EQ(box.high, part.bounds.high);
        }
      }
    }
    EXPECT_TRUE(std::ranges::all_of(found, [](int times) { return times == 1; }));
  }
}

// Hits do not depend on the division of meshes, at the seams and on coplanar surfaces either, nor on what is left out
// beyond the reach of the rays.
TEST_F(SharedParts, HitsDoNotDependOnPartsOrOnWhatIsOutOfReach) {
  for (const double range : {25.0, 90.0}) {
    // No ray runs exactly along the edges of a row of triangles, where boxes of hierarchies decide what it hits.
    const Shot shot = shotAt(spinning(48, 1500, -40, 8, range), {fromYawPitchRoll(0.1, 0.01, 0.02), {0.37, 0.21, 0}});
    const Hits whole = traced(false, INFINITY, shot);
    std::map<std::uint16_t, int> classes;
    for (std::size_t i = 0; i < whole.size(); ++i) classes[whole.semantic[i]] += whole.hit(i) ? 1 : 0;
    EXPECT_GE(classes.size(), 3u);
    expectSameHits(traced(true, INFINITY, shot), whole);
    expectSameHits(traced(true, farthestEnd(shot), shot), whole);
  }
}

// Rays at the seams between parts, where boxes of instances end and are rounded, hit what they hit without parts.
TEST_F(SharedParts, NoRayPassesBetweenParts) {
  Instance& ground = scene_.instances.front();
  scene_.instances.resize(1);
  const SharedMeshes shared(device_.get(), scene_, all_, options_, true);
  const SharedMeshes undivided(device_.get(), scene_, all_, options_);
  shared.build(allParts(shared, scene_));
  const Mesh& mesh = scene_.meshes[ground.mesh];
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<std::size_t>> partsOfEdge;
  for (std::size_t p = shared.firstPart(ground.mesh); p < shared.firstPart(ground.mesh + 1); ++p) {
    for (const BlockTriangle& t : shared.part(p).block->triangles) {
      const Triangle& corners = mesh.triangles[t.primitive];
      for (std::size_t k = 0; k < 3; ++k) {
        partsOfEdge[std::minmax(corners[k], corners[(k + 1) % 3])].insert(p);
      }
    }
  }
  std::vector<std::pair<Vec3d, Vec3d>> seams;
  for (const auto& [edge, parts] : partsOfEdge) {
    if (parts.size() > 1) seams.emplace_back(mesh.positions[edge.first], mesh.positions[edge.second]);
  }
  ASSERT_GT(seams.size(), 500u);
  for (std::uint32_t place = 0; place < 20; ++place) {
    const RandomBlock b = randomBlock({7, 1, 0, 0, place, 0, Purpose::Test});
    const double far = place % 2 == 0 ? 30 : 300;
    const Vec3d where{far * (2 * uniform(b[0]) - 1), far * (2 * uniform(b[1]) - 1), -2.1};
    // Every other one is turned and stretched as well.
    ground.worldFromMesh = place % 4 < 2 ? Affine{{}, where}
                                         : Affine{toMatrix(fromYawPitchRoll(6 * uniform(b[2]), 0.02, 0.01)) *
                                                      Mat3::scale({1 + uniform(b[3]), place % 8 < 4 ? 1.0 : -1.0, 1}),
                                                  where};
    std::vector<Vec3d> directions;
    for (std::uint32_t i = 0; i < 40 * seams.size(); ++i) {
      const RandomBlock r = randomBlock({7, 2, 0, 0, i, place, Purpose::Test});
      const auto& [from, to] = seams[i % seams.size()];
      directions.push_back(normalized(ground.worldFromMesh * (from + (to - from) * (0.05 + 0.9 * uniform(r[0])))));
    }
    const Shot shot = shotAt(beamsOf(directions, 0, 2000));
    const Hits parts = traced(*buildWorld(device_.get(), scene_, {}, all_, shared, options_), shot);
    const Hits whole = traced(*buildWorld(device_.get(), scene_, {}, all_, undivided, options_), shot);
    for (std::size_t i = 0; i < whole.rays(); ++i) ASSERT_EQ(parts.hit(i), whole.hit(i)) << place << ' ' << i;
    EXPECT_GT(std::ranges::count_if(whole.range, [](float range) { return range < kMiss; }),
              0.9 * static_cast<double>(whole.rays()));
  }
}

TEST_F(SharedParts, WorldsHaveThePartsWithinReachAndNoFarOnes) {
  const SharedMeshes shared(device_.get(), scene_, all_, options_, true);
  const double reach = 40;
  const auto world = buildWorld(device_.get(), scene_, {}, all_, shared, options_, {0, 0, reach});
  std::set<std::pair<std::uint32_t, const TriangleBlock*>> placed;
  for (const PlacedBlock& p : world->placed) placed.insert({p.instance, p.block});
  EXPECT_EQ(placed.size(), world->placed.size());
  shared.build(allParts(shared, scene_));
  std::size_t far = 0;
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
    const Instance& instance = scene_.instances[i];
    for (std::size_t p = shared.firstPart(instance.mesh); p < shared.firstPart(instance.mesh + 1); ++p) {
      double nearest = INFINITY;
      const TriangleBlock& block = *shared.part(p).block;
      for (const Triangle& t : block.corners) {
        for (const std::uint32_t corner : t) {
          nearest = std::min(nearest, length(instance.worldFromMesh * Vec3d(block.vertices[corner])));
        }
      }
      const bool left = !placed.contains({i, &block});
      EXPECT_FALSE(left && nearest <= reach) << instance.name;
      far += left ? 1 : 0;
    }
  }
  EXPECT_GT(far, 10u);
}

TEST_F(SharedParts, ThreadsThatWantTheSamePartsBuildEachOnce) {
  const SharedMeshes shared(device_.get(), scene_, all_, options_, true);
  const std::vector<std::size_t> parts = allParts(shared, scene_);
  std::vector<std::vector<const TriangleBlock*>> seen(4);
  onThreads(seen.size(), [&](std::size_t thread) {
    shared.build(parts);
    for (const std::size_t p : parts) seen[thread].push_back(shared.part(p).block.get());
  });
  for (const auto& own : seen) {
    EXPECT_EQ(own, seen.front());
    EXPECT_EQ(std::ranges::count(own, nullptr), 0);
  }
}

}  // namespace
}  // namespace scanmill
