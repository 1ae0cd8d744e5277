#include <fmt/format.h>

#include "base/path.h"
#include "models/models.h"
#include "models/occupancy.h"
#include "tests/support/town.h"

namespace scanmill {
namespace {

// Returns a function of the distance (m) of a point from the box of an instance's mesh at a time, negative inside.
auto distanceFrom(const Scene& scene, const Instance& instance, double time) {
  const Affine there = instance.worldFromMeshAt(time);
  const Affine meshFromWorld{inverse(there.linear), inverse(there.linear) * there.translation * -1.0};
  return [meshFromWorld, box = scene.meshes[instance.mesh].bounds()](const Vec3d& p) {
    const Vec3d local = meshFromWorld * p;
    return std::max({box.low.x - local.x, local.x - box.high.x, box.low.y - local.y, local.y - box.high.y,
                     box.low.z - local.z, local.z - box.high.z});
  };
}

// Who turns stays on the road, meets nobody, and comes to side roads where there are some to the right.
TEST(Traffic, TurnsAreFreeToo) {
  std::size_t turning = 0;
  std::vector<Place> places;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    places.push_back({"{length: 200, vehicles: 3, greenery: 0.5}", seed});
  for (std::uint64_t seed = 1; seed <= 3; ++seed) places.push_back({onMap("vehicles: 3, greenery: 0.5"), seed});
  for (const Place& place : places) {
    const auto& [yaml, seed] = place;
    const Value value = parseYaml(yaml, "town.yaml");
    Fields fields(value, "town");
    const SceneLanes lanes = townLanes(fields, seed);
    const Path path(lanes.turns);
    turning += lanes.turns.size() != lanes.lane.size() ? 1 : 0;
    const Scene scene = makeTown(yaml, seed);
    const Mesh& ground = groundOf(scene);
    std::vector<Affine> driven;
    for (double d = 0; d < path.length(); d += 2) driven.push_back(toAffine(path.pose(d)));
    for (const Affine& pose : driven) {
      for (std::size_t k = 0; k < ground.triangles.size(); ++k) {
        const auto& corners = ground.triangles[k];
        const Vec3d a(ground.positions[corners[0]]), b(ground.positions[corners[1]]), c(ground.positions[corners[2]]);
        const Vec3d& p = pose.translation;
        const auto side = [&](const Vec3d& u, const Vec3d& v) {
          return (v.x - u.x) * (p.y - u.y) - (v.y - u.y) * (p.x - u.x);
        };
        if (side(a, b) < 0 || side(b, c) < 0 || side(c, a) < 0) continue;
        const std::string& name = scene.ontology.find(ground.surfaces[ground.surfaceOf[k]].semantic)->name;
        EXPECT_EQ(name, "road") << place << ": " << p.x << ", " << p.y;
      }
    }
    for (const Instance& i : scene.instances) {
      if (!isOnRoad(i)) continue;
      for (const double time : {0.0, 11.0, 47.0}) {
        const auto away = distanceFrom(scene, i, time);
        for (const Affine& pose : driven) {
          for (const double x : {-1.5, 0.0, 1.5}) {
            EXPECT_GT(away(pose * Vec3d{x, 0, 1}), 0.8) << i.name << " of " << place << " at " << time << " s";
          }
        }
      }
    }
  }
  EXPECT_GE(turning, 4u);
}

// Vehicles pass under the arms of lamps: without roadworks some vehicle on the lane moves in each town.
TEST(Traffic, LampsDoNotStopIt) {
  for (const char* kind : {"suburban", "arterial", "commercial", "dense"}) {
    const Scene scene = makeTown(fmt::format("{{district: {}, traffic: 2, detail: 0.1}}", kind), 2);
    const bool works = std::any_of(scene.instances.begin(), scene.instances.end(),
                                   [](const Instance& i) { return i.name.starts_with("cone"); });
    double most = 0;
    for (const Instance& i : scene.instances) {
      if (!i.name.starts_with("traffic")) continue;
      const Vec3d before = i.worldFromMeshAt(30) * Vec3d{};
      const bool inTown = std::abs(before.x) < 140 && before.z > groundOf(scene).bounds().low.z;
      if (inTown) most = std::max(most, length(i.worldFromMeshAt(50) * Vec3d{} - before));
    }
    EXPECT_TRUE(works || most > 50) << kind << ": " << most << " m";
  }
}

// Whoever drives or walks keeps clear of all others, and of what stands.
TEST(Traffic, NobodyRunsIntoAnother) {
  constexpr const char* kFull = "{length: 250, vehicles: 2, people: 2}";
  for (const Place& town : {Place{kFull, 1},
                            {kFull, 2},
                            {kFull, 4},
                            {kFull, 7},
                            {kFull, 9},
                            {kFull, 18},
                            {onMap("road: Mill Road, vehicles: 2, people: 2"), 1},
                            {onMap("vehicles: 2"), 2}}) {
    const Scene scene = makeTown(town.yaml, town.seed);
    const double lowest = groundOf(scene).bounds().low.z;
    std::size_t moving = 0;
    for (const double time : models::steps(0, 110, 1.5)) {
      models::Occupancy taken;
      for (const Instance& i : scene.instances) {
        if (i.name.starts_with("rider of")) continue;
        if (!isOnRoad(i) && !i.name.starts_with("pedestrian")) continue;
        const Affine place = i.worldFromMeshAt(time);
        const Box box = scene.meshes[i.mesh].bounds();
        const Vec3d middle = place * box.center();
        if (middle.z < lowest) continue;  // who is still to come, or has gone
        const double half = i.name.starts_with("pedestrian") ? 0.25 : (box.high.x - box.low.x) / 2;
        const models::Footprint f{{middle.x, middle.y},
                                  half - 0.05,
                                  std::min(half, (box.high.y - box.low.y) / 2) - 0.05,
                                  std::atan2(place.linear.x.y, place.linear.x.x)};
        EXPECT_TRUE(taken.isFree(f)) << i.name << " of " << town << " at " << time << " s, " << middle.x << ", "
                                     << middle.y;
        taken.add(f);
        moving += i.moves() ? 1 : 0;
      }
    }
    EXPECT_GT(moving, 100u) << town;
  }
}

TEST(Traffic, WhoWalksStaysOnTheGround) {
  const Scene scene = makeTown("{length: 120, people: 3, district: suburban}", 4);
  const Mesh& ground = groundOf(scene);
  std::size_t walk = 0;
  for (const Instance& i : scene.instances) {
    if (!i.name.starts_with("pedestrian") || !i.moves()) continue;
    ++walk;
    ASSERT_NE(i.animation, nullptr);
    EXPECT_NE(i.meshAt(0), i.meshAt(i.animation->period / 2)) << "the other foot is in front";
    EXPECT_EQ(i.meshAt(0), i.meshAt(i.animation->period * 1.01));
    for (const double time : {0.0, 5.0, 20.0, 100.0}) {
      expectOnGround(ground, i.worldFromMeshAt(time).translation, fmt::format("{} at {} s", i.name, time));
    }
  }
  EXPECT_GT(walk, 2u);
}

}  // namespace
}  // namespace scanmill
