// A place that is known by points alone is met where its surfaces are.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/random.h"
#include "formats/cloud_file.h"
#include "pipeline/scenes/scene_probe.h"
#include "scenefile/scene_file.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

double draw(std::uint32_t i, std::size_t k) {
  return uniform(randomBlock({3, i, 0, 0, 0, 0, Purpose::Placement})[k]);
}

// Archimedes: evenly on a sphere.
Vec3d onSphere(std::uint32_t i, std::size_t k) {
  const double z = 2 * draw(i, k) - 1;
  const double around = 2 * kPi * draw(i, k + 1);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(around), r * std::sin(around), z};
}

// 40,000 points on a sphere of 5 m: a point's share has a radius of 5 cm, discs are of 10 cm, whose rims are 1 mm off
// the sphere. All but exp(-4) of it are covered; through the holes rays meet its far side.
TEST(CloudScenes, AreMetWhereTheSurfaceIs) {
  const TemporaryFolder folder;
  constexpr double kRadius = 5;
  const Vec3d center{691234, 5334567, 20};
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 40000\nproperty double x\nproperty double y\nproperty double "
      "z\nend_header\n";
  for (std::uint32_t i = 0; i < 40000; ++i) {
    const Vec3d p = center + onSphere(i, 0) * kRadius;
    text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
  }
  folder.write("ball.ply", text);
  const Scene scene =
      readScene(folder.write("s.yaml", fmt::format("ontology: {0}/labels/scanmill.yaml\nmaterials: "
                                                   "{0}/labels/materials.yaml\nobjects: [{{file: "
                                                   "ball.ply, class: vegetation, points: {{cover: 2}}}}]\n",
                                                   SCANMILL_SOURCE_DIR)),
                {});
  const SceneProbe probe(scene);
  std::vector<SceneProbe::Ray> rays;
  std::vector<double> exact;
  std::vector<Vec3d> normals;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const Vec3d from = center + onSphere(i, 2) * 20;
    const Vec3d to = center + onSphere(i + 10000, 0) * (0.8 * kRadius);
    const Vec3d direction = normalized(to - from);
    const double middle = dot(center - from, direction);
    const double beside = length(from + direction * middle - center);
    rays.push_back({from, direction});
    exact.push_back(middle - std::sqrt(kRadius * kRadius - beside * beside));
    normals.push_back((from + direction * exact.back() - center) * (1 / kRadius));
  }
  const auto met = probe.first(rays, 100);
  int close = 0;
  int covered = 0;
  double turned = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!met[i] || met[i]->distance > exact[i] + 1) continue;
    ++covered;
    const double slant = std::fabs(dot(normals[i], rays[i].direction));
    close += std::fabs(met[i]->distance - exact[i]) * slant < 5e-3 ? 1 : 0;
    turned += std::acos(std::min(std::fabs(dot(met[i]->normal, normals[i])), 1.0));
  }
  EXPECT_NEAR(covered / 4000.0, 1 - std::exp(-4), 0.015);
  EXPECT_GT(close, 0.98 * covered);
  EXPECT_LT(degrees(turned / covered), 2);
}

// A real revolution, looked at from where it was recorded: rays to its points meet surfaces at their ranges, but for
// those that a neighbour's square, nearer at an edge, stands in front of.
TEST(CloudScenes, OfARealRevolutionAreMetAtItsRanges) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128");
  ::setenv("SCANMILL_ASSETS", sharedData().c_str(), 1);
  const Scene scene = readScene(SCANMILL_SOURCE_DIR "/scenes/recorded_place.yaml", {});
  const Cloud cloud = readCloud(sharedData() / "lidar/ouster_os1_128/frame_1795.pcd");
  const SceneProbe probe(scene);
  std::vector<SceneProbe::Ray> rays;
  std::vector<double> exact;
  for (std::size_t i = 0; i < cloud.scan.size(); i += 7) {
    const Vec3d p(cloud.scan.position[i]);
    if (!isFinite(p) || length(p) < 0.5) continue;
    rays.push_back({{0, 0, 0}, normalized(p)});
    exact.push_back(length(p));
  }
  const auto met = probe.first(rays, 500);
  std::vector<double> off;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    off.push_back(met[i] ? std::fabs(met[i]->distance - exact[i]) : 500);
  }
  std::sort(off.begin(), off.end());
  EXPECT_LT(off[off.size() / 2], 0.025);
  EXPECT_LT(off[off.size() * 8 / 10], 0.13);
  EXPECT_LT(off.back(), 500) << "every one meets something";
}

}  // namespace
}  // namespace scanmill
