#include <fmt/format.h>

#include <map>
#include <set>

#include "tests/support/test_scene.h"
#include "tests/support/town.h"
#include "town/lanes.h"

namespace scanmill {
namespace {

constexpr const char* kShortTown = "{length: 120}";

// The kinds that seeds choose.
constexpr std::array<const char*, 8> kKinds{"rural",    "suburban", "dense",      "boulevard",
                                            "old_town", "arterial", "commercial", "motorway"};

// Sixteen successive seeds have each kind, wherever they begin.
TEST(Town, SuccessiveSeedsHaveEachKind) {
  for (const std::uint64_t first : {1, 6, 1000}) {
    std::set<std::string> kinds;
    for (std::uint64_t seed = first; seed < first + 16; ++seed) {
      const std::string about = layoutOf(kShortTown, seed).about;
      kinds.insert(about.substr(0, about.find(',')));
    }
    EXPECT_THAT(kinds, testing::UnorderedElementsAreArray(kKinds));
  }
}

// Terraced streets are paved from the carriageway to the walls; elsewhere there are lawns.
TEST(Town, TerracedStreetsArePavedToTheWalls) {
  for (const char* kind : {"dense", "boulevard", "old_town", "suburban"}) {
    const town::Layout layout = layoutOf(fmt::format("{{length: 200, district: {}}}", kind), 5);
    std::size_t soft = 0;
    std::size_t feet = 0;
    for (const models::House& house : layout.houses) {
      for (const double x : {0.2, 0.5, 0.8}) {
        const Vec3d foot = house.pose * Vec3d{x * house.width, -0.25, 0};
        const town::Point2 p{foot.x, foot.y};
        ++feet;
        soft += layout.kindAt(layout.besideAt(p), p) == town::GroundKind::Lawn ? 1 : 0;
      }
    }
    EXPECT_GT(feet, 20u) << kind;
    if (layout.character.terraced) {
      EXPECT_EQ(soft, 0u) << kind;
    } else {
      EXPECT_GT(soft, 0u) << kind;
    }
  }
}

// Motorways have rails along both edges and a barrier in the middle, no houses, and vehicles on each lane.
TEST(Town, MotorwaysHaveRailsAndSeveralLanes) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const std::string yaml = "{length: 300, district: motorway, traffic: 3, detail: 0.1}";
    const town::Layout layout = layoutOf(yaml, seed);
    const town::Road& road = layout.mainRoad();
    EXPECT_TRUE(layout.houses.empty());
    EXPECT_GE(road.section.lanes, 2);
    const Scene scene = makeTown(yaml, seed);
    std::map<std::string, int> panels;
    std::set<int> lanes;
    for (const Instance& i : scene.instances) {
      for (const char* row : {"median", "left rail", "right rail"}) panels[row] += i.name.starts_with(row) ? 1 : 0;
      if (!i.name.starts_with("traffic")) continue;
      for (const double time : {0.0, 10.0, 20.0, 40.0}) {
        const Vec3d at = i.worldFromMeshAt(time) * Vec3d{};
        const town::Beside b = layout.besideAt({at.x, at.y});
        // Vehicles are hidden below the ground before they arrive and after they have left.
        const bool hidden = !b.nearRoad || b.along < 15 || b.along > road.length() - 15;
        if (hidden || at.z < layout.heightAt({at.x, at.y}) - 0.5) continue;
        const double out = (std::abs(b.lateral) - road.section.median) / road.section.laneWidth();
        EXPECT_NEAR(out - std::floor(out), 0.5, 0.25) << i.name;
        lanes.insert(static_cast<int>(std::copysign(1 + std::floor(out), b.lateral)));
      }
    }
    for (const auto& [row, count] : panels) EXPECT_GT(count, 100) << row;
    // All lanes but that of the sensor's vehicle, which drives in the direction of the line, and those to its right.
    const int empty = 1 + town::egoLine(layout).lane;
    EXPECT_EQ(lanes.size(), static_cast<std::size_t>(2 * road.section.lanes - empty));
    for (int lane = 0; lane < empty; ++lane) EXPECT_FALSE(lanes.contains(lane - road.section.lanes));
  }
}

// Cars on the sidewalk stand there half or whole, and leave a part of it free.
TEST(Town, CarsOnTheSidewalkLeaveAPath) {
  constexpr double kPath = 0.6;  // m
  std::size_t cars = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const std::string yaml =
        fmt::format("{{length: 250, district: {}, vehicles: 3, detail: 0.1}}", seed % 2 == 0 ? "suburban" : "dense");
    const town::Layout layout = layoutOf(yaml, seed);
    const Scene scene = makeTown(yaml, seed);
    for (const Instance& i : scene.instances) {
      if (!i.name.starts_with("car ") || i.name.starts_with("car on")) continue;
      const Vec3d& at = i.worldFromMesh.translation;
      const town::Beside b = layout.besideAt({at.x, at.y});
      if (b.edge < 0.05 || b.edge > 1.5 || layout.outsidePatches({at.x, at.y}) < 1) continue;
      const Box box = scene.meshes[i.mesh].bounds();
      EXPECT_LT(b.edge + (box.high.y - box.low.y) / 2, b.section.paved() - kPath) << i.name;
      ++cars;
    }
  }
  EXPECT_GT(cars, 10u);
}

// Every method can trace a street: nothing moves or is hidden below the ground, the road is straight, and the
// carriageway is exactly level. One drives along +x at y = -1.75.
TEST(Town, StreetsAreFlatStraightAndStill) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const std::string yaml = "{district: street, length: 200, detail: 0.1}";
    const Scene scene = makeTown(yaml, seed);
    const auto counted = [&](std::string_view start) {
      return std::ranges::count_if(scene.instances, [&](const Instance& i) { return i.name.starts_with(start); });
    };
    for (const Instance& i : scene.instances) {
      EXPECT_FALSE(i.moves()) << i.name;
      EXPECT_GT(i.worldFromMesh.translation.z, -1) << i.name << ", seed " << seed;
    }
    EXPECT_GE(counted("traffic"), 1) << seed;
    EXPECT_GE(counted("pedestrian"), 4) << seed;
    EXPECT_EQ(counted("wire") + counted("tuft"), 0) << seed;
    const Mesh& ground = groundOf(scene);
    std::size_t level = 0;
    for (std::size_t k = 0; k < ground.triangles.size(); ++k) {
      const std::string& name = scene.ontology.find(ground.surfaces[ground.surfaceOf[k]].semantic)->name;
      if (name != "road") continue;
      for (const std::uint32_t v : ground.triangles[k]) EXPECT_EQ(ground.positions[v].z, 0);
      ++level;
    }
    EXPECT_GT(level, 1000u);
    for (const Vec3d& p : laneOf(yaml, seed)) {
      EXPECT_NEAR(p.y, -1.75, 1e-9);
      EXPECT_EQ(p.z, 0);
    }
  }
}

// Three of four houses of old towns are attached. On the inner side of a bend as on its outer side such neighbours
// touch, and plots have houses.
TEST(Town, RowsOfHousesStandOnBothSidesOfBends) {
  struct Side {
    int plots = 0, built = 0, neighbours = 0, touching = 0;
  };
  Side inner;
  Side outer;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const town::Layout layout = layoutOf("{length: 300, district: old_town}", seed);
    std::map<std::uint32_t, const models::House*> houses;
    for (const models::House& house : layout.houses) houses[house.number] = &house;
    const models::House* before = nullptr;
    const town::Plot* previous = nullptr;
    for (const town::Plot& plot : layout.plots) {
      const town::Road& road = layout.roads()[plot.road];
      const town::Point2 a = road.heading(plot.from);
      const town::Point2 b = road.heading(plot.to);
      const double bend = plot.side * (a.x * b.y - a.y * b.x) / (plot.to - plot.from);  // 1/m
      const models::House* const house = plot.built ? houses.at(plot.number) : nullptr;
      const bool next = previous != nullptr && previous->road == plot.road && previous->side == plot.side &&
                        previous->to == plot.from;
      if (std::abs(bend) > 1.0 / 400 && road.main) {
        Side& side = bend > 0 ? inner : outer;
        ++side.plots;
        side.built += plot.built ? 1 : 0;
        if (next && before != nullptr && house != nullptr) {
          // The house on the left, as seen from the road, and the left front corner of the other.
          const models::House& left = plot.side > 0 ? *before : *house;
          const Vec3d corner = (plot.side > 0 ? *house : *before).pose.translation - left.pose.translation;
          const double gap = dot(corner, left.pose.linear.x) - left.width;
          ++side.neighbours;
          side.touching += std::abs(gap) < 0.1 ? 1 : 0;
        }
      }
      before = house;
      previous = &plot;
    }
  }
  for (const Side& side : {inner, outer}) {
    EXPECT_GT(side.neighbours, 100);
    EXPECT_NEAR(static_cast<double>(side.touching) / side.neighbours, 0.95 * 0.95, 0.12);
  }
  EXPECT_NEAR(static_cast<double>(inner.built) / inner.plots, static_cast<double>(outer.built) / outer.plots, 0.08);
}

}  // namespace
}  // namespace scanmill
