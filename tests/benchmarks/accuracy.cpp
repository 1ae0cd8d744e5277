// What the depth camera's shortcuts cost: each setting against ray tracing, the same beams on the procedural street.
// Prints the table of docs/depth_camera.md.

#include <fmt/core.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "evaluate/cloud_errors.h"
#include "tests/core/methods/trace.h"
#include "tests/support/hit_errors.h"
#include "tests/support/street.h"

namespace {

using namespace scanmill;

struct Setting {
  std::string name;
  std::string options;
};

const std::vector<Setting> kSettings{
    {"plane, 2048", "{layout: three_120}"},
    {"plane, 1024", "{layout: three_120, resolution: 1024}"},
    {"plane, 512", "{layout: three_120, resolution: 512}"},
    {"plane, 4096", "{layout: three_120, resolution: 4096}"},
    {"plane, 2048, auto", "{layout: auto}"},
    {"plane, 2048, four_90", "{layout: four_90}"},
    {"plane, 2048, cube_6", "{layout: cube_6}"},
    {"bilinear, 2048", "{layout: three_120, sampling: bilinear}"},
    {"nearest, 2048", "{layout: three_120, sampling: nearest}"},
    {"nearest, 4096", "{layout: three_120, sampling: nearest, resolution: 4096}"},
    {"nearest, 512", "{layout: three_120, sampling: nearest, resolution: 512}"},
    {"plane, uint24", "{layout: three_120, depth: uint24}"},
    {"plane, uint16", "{layout: three_120, depth: uint16}"},
    {"nearest, half_500", "{layout: three_120, sampling: nearest, depth: half_500}"},
    {"plane, antialiased 2 x 2", "{layout: three_120, antialiasing: 2}"},
};

int run() {
  const Scene scene = proceduralStreet();
  const auto tracing = rayTracing(scene);
  const Shot shot = streetShot(presetBeams("paper_64"), -20);
  const Hits truth = traced(*tracing, shot);
  const std::vector<Vec3f> there = hitPoints(shot, truth);
  const double pixel = 2 * std::tan(radians(60)) / 2048;  // rad, at the centre of an image of 120 degrees
  const std::vector<std::uint8_t> edges = edgeBeams(*tracing, shot, pixel);
  fmt::print(
      "| setting | median mm | p95 mm | p99 mm | p99.9 m | max m | labels | interior labels | false negatives | false "
      "positives | "
      "to mm | from mm | Hausdorff m |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Setting& s : kSettings) {
    const auto method = methodOf("depth_camera", scene, s.options);
    const Hits tested = traced(*method, shot);
    const HitErrors e = compareHits(truth, tested, edges);
    const std::vector<Vec3f> here = hitPoints(shot, tested);
    const CloudErrors cloud = cloudErrors(there, here);
    const auto share = [](std::uint64_t part, std::uint64_t whole) {
      return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
    };
    const Spread& r = e.rangeSameSurface;
    fmt::print(
        "| {} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.2f} % | {:.3f} % | {:.2f} % | {:.2f} % | {:.2f} "
        "| {:.2f} | {:.2f} |\n",
        s.name, r.median * 1e3, r.p95 * 1e3, r.p99 * 1e3, r.p999, r.max, share(e.sameLabel, e.bothHit),
        share(e.interiorAgree, e.interior), share(e.falseNegatives, e.beams), share(e.falsePositives, e.beams),
        cloud.to.mean * 1e3, cloud.from.mean * 1e3, cloud.hausdorff);
    std::fflush(stdout);
  }
  return 0;
}

// The same layouts elsewhere in the street: what stands near the sensor decides.
int runAlongTheStreet() {
  const Scene scene = proceduralStreet();
  const auto tracing = rayTracing(scene);
  fmt::print("\n| plane, 2048: p99 mm, interior labels |");
  const std::vector<double> places{-50, -20, 0, 3, 25, 50};
  for (const double x : places) fmt::print(" x = {} m |", x);
  fmt::print("\n|---|");
  for (std::size_t i = 0; i < places.size(); ++i) fmt::print("---|");
  for (const char* layout : {"three_120", "auto", "four_90"}) {
    fmt::print("\n| {} |", layout);
    const auto method = methodOf("depth_camera", scene, fmt::format("{{layout: {}}}", layout));
    for (const double x : places) {
      const Shot shot = streetShot(presetBeams("paper_64"), x);
      const Hits truth = traced(*tracing, shot);
      const double pixel = 2 * std::tan(radians(60)) / 2048;
      const HitErrors e = compareHits(truth, traced(*method, shot), edgeBeams(*tracing, shot, pixel));
      fmt::print(" {:.3g}, {:.2f} % |", e.rangeSameSurface.p99 * 1e3,
                 100.0 * static_cast<double>(e.interiorAgree) / static_cast<double>(e.interior));
    }
  }
  fmt::print("\n");
  return 0;
}

}  // namespace

int main() {
  try {
    return run() + runAlongTheStreet();
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 1;
  }
}
