#include <set>

#include "pipeline/run/sample_maker.h"
#include "sense/sense.h"
#include "sensors/footprint.h"
#include "tests/core/methods/trace.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::IsEmpty;
using testing::UnorderedElementsAre;

const VoxelGrid kCube{0.5, {-4, -4, -4}, {16, 16, 16}};

VoxelLabels nothing(const VoxelGrid& grid = kCube) {
  return {std::vector<std::uint16_t>(grid.voxels()), {}};
}

VoxelLabels labelsOf(const Scene& scene, const VoxelGrid& grid, const Shot& shot) {
  return SceneVoxels(scene).labels(grid, shot.worldFromSensor.front(), shot.time);
}

// Hits at these ranges, one a beam.
Hits hitsAt(const std::vector<float>& ranges) {
  Hits hits;
  hits.reset(1, static_cast<std::uint32_t>(ranges.size()), {});
  hits.range = ranges;
  return hits;
}

std::vector<std::size_t> without(const std::vector<std::uint8_t>& flags) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] == 0) indices.push_back(i);
  }
  return indices;
}

// What is seen of a place where nothing stands.
std::vector<std::size_t> seenBy(const Shot& shot, const Hits& hits, std::uint32_t raysPerBeam = 1) {
  return without(viewVoxels(kCube, nothing(), shot, raysPerBeam, hits, {}).unseen);
}

// Noise-free, without effects.
Scan scanOf(const Hits& hits, const Shot& shot, const Scene& scene) {
  Returns returns;
  Scan scan;
  ScanLayout layout;
  layout.organised = true;
  sense({.materials = scene.materials, .layout = layout}, hits, shot, returns, scan);
  return scan;
}

Scene boxAbout(const Vec3d& middle, const Vec3d& size, bool open) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  appendBox(mesh, 0, at(middle.x, middle.y, middle.z), size);
  if (open) {  // a hole in the side towards x: its two triangles are gone
    std::vector<Triangle> kept;
    for (const Triangle& t : mesh.triangles) {
      const auto low = [&](std::uint32_t corner) {
        return mesh.positions[corner].x < static_cast<float>(middle.x - size.x / 2) + 1e-4f;
      };
      if (!std::all_of(t.begin(), t.end(), low)) kept.push_back(t);
    }
    mesh.triangles = kept;
    mesh.surfaceOf.resize(kept.size());
  }
  builder.place(builder.addMesh(mesh), {}, "box");
  return builder.finish();
}

TEST(VoxelView, ABeamSeesWhatItPassesAndWhereItEnds) {
  const Shot shot = shotAt(beamsOf({{1, 0, 0}}, 0, 100), {});
  std::vector<std::size_t> all;
  for (std::uint32_t x = 8; x < 16; ++x) all.push_back(kCube.index(x, 8, 8));
  EXPECT_THAT(seenBy(shot, hitsAt({kMiss})), testing::UnorderedElementsAreArray(all)) << "a miss goes on to the end";
  EXPECT_THAT(seenBy(shot, hitsAt({50})), testing::UnorderedElementsAreArray(all)) << "as does what ends beyond";
  EXPECT_THAT(seenBy(shot, hitsAt({1.2f})), UnorderedElementsAre(all[0], all[1], all[2]));
  EXPECT_THAT(seenBy(shotAt(beamsOf({{1, 0, 0}}, 0, 0.7)), hitsAt({kMiss})), UnorderedElementsAre(all[0], all[1]))
      << "nor does a miss go farther than the sensor's range";
}

// By the definition: a voxel is seen where the beam's line has a part in it.
TEST(VoxelView, VoxelsOfBeamsAreThoseThatTheirLinesCross) {
  std::vector<Vec3d> directions;
  std::vector<float> ranges;
  for (int i = 0; i < 300; ++i) {
    directions.push_back({std::sin(i * 1.1), std::cos(i * 2.3), std::sin(i * 0.7 + 1)});
    ranges.push_back(i % 3 == 0 ? kMiss : static_cast<float>(0.3 + 0.02 * i));
  }
  for (const int axis : {0, 1, 2, 3, 4, 5}) {  // and straight along the axes, where divisions are by zero
    const double way = axis % 2 == 0 ? 1 : -1;
    directions.push_back({axis / 2 == 0 ? way : 0, axis / 2 == 1 ? way : 0, axis / 2 == 2 ? way : 0});
    ranges.push_back(kMiss);
  }
  auto beams = beamsOf(directions, 0, 30);
  for (std::size_t i = 0; i < directions.size(); ++i) {  // some begin outside of the grid
    const double k = static_cast<double>(i);
    beams->origin.push_back(Vec3f(Vec3d{5 * std::sin(k * 3.1), 5 * std::cos(k * 1.7), 3 * std::sin(k)}));
  }
  for (std::size_t beam = 0; beam < directions.size(); ++beam) {
    auto alone = std::make_shared<BeamTable>(*beamsOf({directions[beam]}, 0, 30));
    alone->origin = {beams->origin[beam]};
    const std::vector<std::size_t> seen = seenBy(shotAt(alone), hitsAt({ranges[beam]}));
    const Vec3d from = kCube.inVoxels(Vec3d(beams->origin[beam]));
    const double end = std::min(double{ranges[beam]}, 30.0);
    const Vec3d step = beams->direction[beam] * (1 / kCube.size);
    std::set<std::size_t> found(seen.begin(), seen.end());
    for (std::uint32_t x = 0; x < 16; ++x) {
      for (std::uint32_t y = 0; y < 16; ++y) {
        for (std::uint32_t z = 0; z < 16; ++z) {
          double enters = 0;
          double leaves = end;
          const auto cut = [&](double origin, double slope, std::uint32_t low) {
            if (slope == 0) {
              if (origin < low || origin >= low + 1) leaves = -1;
              return;
            }
            enters = std::max(enters, std::min((low - origin) / slope, (low + 1 - origin) / slope));
            leaves = std::min(leaves, std::max((low - origin) / slope, (low + 1 - origin) / slope));
          };
          cut(from.x, step.x, x);
          cut(from.y, step.y, y);
          cut(from.z, step.z, z);
          const bool crossed = leaves > enters + 1e-9;
          if (std::abs(leaves - enters) < 1e-9) continue;  // a corner, where rounding decides
          EXPECT_EQ(found.contains(kCube.index(x, y, z)), crossed) << beam << ": " << x << " " << y << " " << z;
        }
      }
    }
  }
}

TEST(VoxelView, EveryHitIsSeenAndInAnOccupiedVoxel) {
  const Scene street = proceduralStreet();
  Shot shot = streetShot(presetBeams("vlp_16"), 20);
  shot.worldFromSensor.front().rotation = fromYawPitchRoll(0.3, 0.01, 0.02);
  const Hits hits = traced(street, shot);
  const Scan scan = scanOf(hits, shot, street);
  const VoxelGrid grid;
  const ScanVoxels voxels = viewVoxels(grid, labelsOf(street, grid, shot), shot, 1, hits, scan);
  std::size_t inside = 0;
  std::size_t beside = 0;
  for (const Vec3f& point : scan.position) {
    const auto voxel = grid.at(Vec3d(point));
    if (!voxel) continue;
    ++inside;
    EXPECT_EQ(voxels.input[*voxel], 1);
    beside += voxels.unseen[*voxel] != 0 || voxels.label[*voxel] == 0 ? 1 : 0;
  }
  EXPECT_GT(inside, 3000u);
  EXPECT_LE(beside, inside / 5000) << "but for rounding at the faces of voxels";
  for (std::size_t i = 0; i < voxels.label.size(); ++i) {
    EXPECT_TRUE(voxels.unseen[i] != 0 || voxels.invalid[i] == 0) << "what is seen is known";
  }
  EXPECT_GT(std::count(voxels.unseen.begin(), voxels.unseen.end(), 1), 100000);
  EXPECT_GT(std::count(voxels.invalid.begin(), voxels.invalid.end(), 1), 100000) << "under ground";
}

TEST(VoxelView, TheInsideOfClosedThingsIsInvalid) {
  // Looks along x at a box with walls in the voxels 10 and 13 along x, 6 and 9 along y and z.
  const Vec3d middle{2.24, 0.24, 0.24};
  const Shot shot = shotAt(beamsOf({{1, 0.02, 0.02}}, 0, 100), {{}, {-3.76, 0.24, 0.24}});
  const VoxelGrid grid{0.5, {0, -4, -4}, {16, 16, 16}};  // in the sensor's frame
  const std::size_t inside = *grid.at(middle - shot.worldFromSensor.front().translation);
  const auto invalidOf = [&](const Scene& scene) {
    const Hits hits = traced(scene, shot);
    return viewVoxels(grid, labelsOf(scene, grid, shot), shot, 1, hits, {}).invalid;
  };
  const std::vector<std::uint8_t> closed = invalidOf(boxAbout(middle, {1.9, 1.9, 1.9}, false));
  EXPECT_EQ(closed[inside], 1);
  EXPECT_EQ(std::count(closed.begin(), closed.end(), 1), 8) << "2 x 2 x 2 voxels within the walls, and no others";
  EXPECT_THAT(invalidOf(boxAbout(middle, {1.9, 1.9, 1.9}, true)), testing::Each(0)) << "the way in is open";
}

TEST(VoxelView, WithinMatterIsInvalid) {
  // Everything is solid but one voxel that a beam ends before: it sees that, and what shares a face with it is known.
  VoxelLabels labels{std::vector<std::uint16_t>(kCube.voxels(), 1), {}};
  const std::size_t hollow = kCube.index(8, 8, 8);
  labels.label[hollow] = 0;
  const Shot shot = shotAt(beamsOf({{1, 0, 0}}));
  const ScanVoxels voxels = viewVoxels(kCube, labels, shot, 1, hitsAt({0.6f}), {});
  EXPECT_THAT(without(voxels.invalid),
              UnorderedElementsAre(hollow, kCube.index(7, 8, 8), kCube.index(9, 8, 8), kCube.index(8, 7, 8),
                                   kCube.index(8, 9, 8), kCube.index(8, 8, 7), kCube.index(8, 8, 9)));
  EXPECT_THAT(without(voxels.unseen), UnorderedElementsAre(hollow, kCube.index(9, 8, 8)));
}

// No way leads on from where a beam ends: that may be a wall that lies in the voxel before.
TEST(VoxelView, WhereABeamEndsIsNoWayOn) {
  VoxelLabels labels = nothing();
  for (std::uint32_t y = 0; y < 16; ++y) {
    for (std::uint32_t z = 0; z < 16; ++z) labels.label[kCube.index(10, y, z)] = 1;
  }
  const Shot shot = shotAt(beamsOf({{1, 0, 0}}));
  const ScanVoxels behind = viewVoxels(kCube, labels, shot, 1, hitsAt({1.6f}), {});
  EXPECT_EQ(behind.unseen[kCube.index(11, 8, 8)], 0);
  EXPECT_EQ(behind.invalid[kCube.index(11, 8, 8)], 0);
  EXPECT_EQ(behind.invalid[kCube.index(11, 9, 8)], 1);
  const ScanVoxels through = viewVoxels(kCube, labels, shot, 1, hitsAt({2.2f}), {});
  EXPECT_THAT(through.invalid, testing::Each(0));
}

TEST(VoxelView, SurfacesOfNoClassAreSolidAndInvalid) {
  VoxelLabels labels = nothing();
  for (std::uint32_t y = 0; y < 16; ++y) {
    for (std::uint32_t z = 0; z < 16; ++z) {
      labels.unlabeled.push_back(static_cast<std::uint32_t>(kCube.index(10, y, z)));
    }
  }
  const ScanVoxels voxels = viewVoxels(kCube, labels, shotAt(beamsOf({{1, 0, 0}})), 1, hitsAt({1.2f}), {});
  for (std::uint32_t x = 0; x < 16; ++x) EXPECT_EQ(voxels.invalid[kCube.index(x, 8, 8)], x < 10 ? 0 : 1) << x;
}

TEST(VoxelView, OfSeveralRaysTheAxisCounts) {
  auto wide = beamsOf({{1, 0, 0}, {0, 1, 0}}, 0, 100);
  wide->divergence = {0.1, 0.1};
  const Footprint footprint = makeFootprint(*wide, 7);
  Hits hits;
  hits.reset(1, 14, {});
  std::fill(hits.range.begin(), hits.range.end(), kMiss);
  hits.range[0] = 0.7f;
  hits.range[7] = 1.2f;
  joinRays(footprint, hits);
  EXPECT_THAT(seenBy(shotAt(wide), hits, 7), UnorderedElementsAre(kCube.index(8, 8, 8), kCube.index(9, 8, 8),
                                                                  kCube.index(8, 9, 8), kCube.index(8, 10, 8)));
}

TEST(VoxelView, BehindGlassABeamGoesOnAndOffMirrorsNot) {
  const Shot shot = shotAt(beamsOf({{1, 0, 0}, {0, 1, 0}}, 0, 100));
  Hits hits = hitsAt({0.2f, 0.2f, 1.2f, 1.2f});
  hits.columns = 2;
  hits.beamOfRay = {0, 1, 0, 1};
  hits.weightOfRay = {1, 1, 0.5f, 0.5f};
  hits.pathOfRay = {RayPath::Direct, RayPath::Direct, RayPath::ThroughGlass, RayPath::Mirrored};
  EXPECT_THAT(seenBy(shot, hits),
              UnorderedElementsAre(kCube.index(8, 8, 8), kCube.index(9, 8, 8), kCube.index(10, 8, 8)));
}

TEST(VoxelView, WhatTheEgoVehicleBlocksAndWhatIsNotKnownIsNotSeen) {
  const Shot shot = shotAt(beamsOf({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 0.5, 100));
  Hits hits = hitsAt({kMiss, kMiss, 0.6f});
  hits.pathOfRay = {RayPath::EgoVehicle, RayPath::Direct, RayPath::EgoVehicle};
  hits.unresolved = {1};
  EXPECT_THAT(seenBy(shot, hits), UnorderedElementsAre(kCube.index(8, 8, 8), kCube.index(8, 8, 9)));
}

// The grid stands where the revolution begins; a beam goes out from where the sensor is when it fires.
TEST(VoxelView, OfAMovingSensorBeamsStartWhereTheyAreFired) {
  for (const Vec3d& place : {Vec3d{}, Vec3d{1e7, -5e6, 4096}}) {
    Shot shot = shotAt(beamsOf({{1, 0, 0}, {1, 0, 0}}, 0, 100), {{}, place});
    shot.worldFromSensor.push_back({fromYawPitchRoll(kPi / 2, 0, 0), place + Vec3d{1.1, 0, 0}});
    EXPECT_THAT(seenBy(shot, hitsAt({0.2f, 0.7f})),
                UnorderedElementsAre(kCube.index(8, 8, 8), kCube.index(10, 8, 8), kCube.index(10, 9, 8)));
  }
}

TEST(VoxelView, InputIsWhereThePointsAre) {
  Scan scan;
  scan.position = {{0.1f, 0.1f, 0.1f}, {0.2f, 0.2f, 0.2f}, {-3.9f, 3.9f, 0.6f}, {NAN, NAN, NAN}, {9, 0, 0}};
  const ScanVoxels voxels = viewVoxels(kCube, nothing(), shotAt(beamsOf({{1, 0, 0}})), 1, hitsAt({0.1f}), scan);
  EXPECT_EQ(voxels.input[kCube.index(8, 8, 8)], 1);
  EXPECT_EQ(voxels.input[kCube.index(0, 15, 9)], 1);
  EXPECT_EQ(std::count(voxels.input.begin(), voxels.input.end(), 1), 2);
}

}  // namespace
}  // namespace scanmill
