#pragma once

// Towns, drawn and on a map, for tests.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "config/fields.h"
#include "config/value.h"
#include "tests/support/labels.h"
#include "town/layout.h"
#include "town/town.h"

namespace scanmill {

inline Scene makeTown(const std::string& yaml, std::uint64_t seed) {
  SceneBuilder builder = labelledBuilder("town", seed);
  const Value value = parseYaml(yaml, "town.yaml");
  Fields fields(value, "town");
  builder.drawReflectances();
  addTown(builder, fields, seed, {});
  return builder.finish();
}

inline town::Layout layoutOf(const std::string& yaml, std::uint64_t seed) {
  const Value value = parseYaml(yaml, "town.yaml");
  Fields fields(value, "town");
  return {town::readParameters(fields), seed};
}

// All that stands on the ground of a town, by the corners of its meshes, in the world's frame.
template <class Visit>
void forPoints(const Scene& scene, const Visit& visit) {
  for (const Instance& i : scene.instances) {
    if (i.name == "ground" || i.name.starts_with("road ")) continue;
    for (const Vec3f& p : scene.meshes[i.mesh].positions) visit(i, i.worldFromMesh * Vec3d(p));
  }
}

inline std::vector<Vec3d> laneOf(const std::string& yaml, std::uint64_t seed) {
  const Value value = parseYaml(yaml, "town.yaml");
  Fields fields(value, "town");
  return townLanes(fields, seed).lane;
}

inline const Mesh& groundOf(const Scene& scene) {
  for (const Instance& i : scene.instances) {
    if (i.name == "ground") return scene.meshes[i.mesh];
  }
  throw Error("no ground");
}

// Whether a thing stands or drives on roads, by its name.
inline bool isOnRoad(const Instance& instance) {
  static constexpr std::array<std::string_view, 8> kStarts{"car",  "traffic", "waiting",   "delivering",
                                                           "cone", "barrier", "excavator", "cyclist"};
  return std::any_of(kStarts.begin(), kStarts.end(),
                     [&](std::string_view start) { return instance.name.starts_with(start); });
}

// Whoever stands at `foot` stands on the ground, as near as its nearest corner tells.
inline void expectOnGround(const Mesh& ground, const Vec3d& foot, const std::string& who) {
  double nearest = 1e9;
  double height = 0;
  for (const Vec3f& p : ground.positions) {
    const double d = std::hypot(p.x - foot.x, p.y - foot.y);
    if (d < nearest) std::tie(nearest, height) = std::pair(d, double{p.z});
  }
  EXPECT_NEAR(foot.z, height, 0.25) << who;
}

// A town on the map that comes with the program; `more` are further keys.
inline std::string onMap(const std::string& more) {
  return "{map: " SCANMILL_SOURCE_DIR "/scenes/village.osm, " + more + "}";
}

// What all towns must be, drawn and on a map.
struct Place {
  std::string yaml;
  std::uint64_t seed;
};
inline std::ostream& operator<<(std::ostream& out, const Place& place) {
  return out << place.yaml << ", seed " << place.seed;
}

}  // namespace scanmill
