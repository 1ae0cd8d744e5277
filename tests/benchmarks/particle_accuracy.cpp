// What the particle method's shortcuts cost: each setting against ray tracing, the same beams on the procedural
// street; by level of the field; and how thin things are seen. Prints the tables of docs/particle.md.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/random.h"
#include "evaluate/cloud_errors.h"
#include "tests/core/methods/trace.h"
#include "tests/support/hit_errors.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace {

using namespace scanmill;

struct ParticleSetting {
  std::string name;
  std::string options;
};

const std::vector<ParticleSetting> kParticleSettings{
    {"none, 10 cm", "refine: none"},
    {"normal, 10 cm", "refine: normal"},
    {"triangle, 10 cm", "refine: triangle"},
    {"none, 5 cm, 512 voxels", "refine: none, voxel_m: 0.05, voxels: 512"},
    {"none, 10 cm, 512 voxels", "refine: none, voxels: 512"},
    {"normal, 10 cm, 512 voxels", "refine: normal, voxels: 512"},
    {"none, 20 cm", "refine: none, voxel_m: 0.2"},
    {"none, 10 cm, whole scene", "refine: none, field: scene"},
    {"normal, 10 cm, whole scene", "refine: normal, field: scene"},
    {"none, 40 cm, whole scene", "refine: none, field: scene, voxel_m: 0.4"},
    {"none, 1 m, whole scene", "refine: none, field: scene, voxel_m: 1"},
    {"normal, 1 m, whole scene", "refine: normal, field: scene, voxel_m: 1"},
};

std::unique_ptr<Method> particleOf(const Scene& scene, const std::string& options) {
  return methodOf("particle", scene, "{backend: cpu, " + options + "}");
}

double percent(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

void printSettings(const Scene& scene, const Method& tracing) {
  const Shot shot = streetShot(presetBeams("paper_64"), -20);
  const Hits truth = traced(tracing, shot);
  const std::vector<Vec3f> there = hitPoints(shot, truth);
  const std::vector<std::uint8_t> edges = edgeBeams(tracing, shot, 0.0016915);  // rad, as in docs/depth_camera.md
  fmt::print(
      "| setting | median mm | p95 mm | p99 m | p99.9 m | max m | labels | interior labels | false negatives | false "
      "positives | to mm | "
      "from mm | Hausdorff m |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const ParticleSetting& s : kParticleSettings) {
    const Hits tested = traced(*particleOf(scene, s.options), shot);
    const HitErrors e = compareHits(truth, tested, edges);
    const std::vector<Vec3f> here = hitPoints(shot, tested);
    const CloudErrors cloud = cloudErrors(there, here);
    const Spread& r = e.rangeSameSurface;
    fmt::print(
        "| {} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.2f} % | {:.3f} % | {:.2f} % | {:.2f} % | {:.2f} | "
        "{:.2f} | {:.2f} |\n",
        s.name, r.median * 1e3, r.p95 * 1e3, r.p99, r.p999, r.max, percent(e.sameLabel, e.bothHit),
        percent(e.interiorAgree, e.interior), percent(e.falseNegatives, e.beams), percent(e.falsePositives, e.beams),
        cloud.to.mean * 1e3, cloud.from.mean * 1e3, cloud.hausdorff);
    std::fflush(stdout);
  }
}

// Beams by the level in which ray tracing meets something.
void printLevels(const Scene& scene, const Method& tracing) {
  fmt::print(
      "\n| level | voxel m | beams | refine | median mm | p95 mm | p99 m | labels | false negatives | false positives "
      "|\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  const Shot shot = streetShot(presetBeams("paper_64"), -20);
  const Hits truth = traced(tracing, shot);
  for (const char* refine : {"none", "normal", "triangle"}) {
    const Hits tested = traced(*particleOf(scene, std::string("refine: ") + refine), shot);
    for (int level = 0; level < 4; ++level) {
      const double reach = (128 - 9) * 0.1 * std::pow(2, level);
      const double inner = level == 0 ? 0 : reach / 2;
      std::vector<double> errors;
      std::uint64_t beams = 0, falseNegatives = 0, falsePositives = 0, same = 0;
      for (std::size_t i = 0; i < truth.size(); ++i) {
        const bool hit = truth.hit(i) || tested.hit(i);
        if (!hit) continue;
        const Vec3d p = shot.beams->direction[i] * double{truth.hit(i) ? truth.range[i] : tested.range[i]};
        const double most = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        if (most <= inner || most > reach) continue;
        ++beams;
        falseNegatives += truth.hit(i) && !tested.hit(i) ? 1 : 0;
        falsePositives += !truth.hit(i) && tested.hit(i) ? 1 : 0;
        if (!truth.hit(i) || !tested.hit(i)) continue;
        const bool label = truth.semantic[i] == tested.semantic[i] && truth.instance[i] == tested.instance[i];
        same += label ? 1 : 0;
        if (label) errors.push_back(std::abs(double{truth.range[i]} - double{tested.range[i]}));
      }
      const std::uint64_t both = beams - falseNegatives - falsePositives;
      const Spread s = spreadOf(errors);
      fmt::print("| {} | {:g} | {} | {} | {:.3g} | {:.3g} | {:.3g} | {:.2f} % | {:.2f} % | {:.2f} % |\n", level,
                 0.1 * std::pow(2, level), beams, refine, s.median * 1e3, s.p95 * 1e3, s.p99, percent(same, both),
                 percent(falseNegatives, beams), percent(falsePositives, beams));
    }
  }
}

// Things of thickness t in one, two or three directions, at 200 random places and turns within the finest level.
void printThinThings() {
  fmt::print(
      "\n| t / voxel | plates: none | normal | triangle | rods: none | normal | triangle | cubes: none | normal | "
      "triangle |\n|---|---|---|---|---|---|---|---|---|---|\n");
  const double voxel = 0.1;
  const Shot shot = shotAt(spinning(512, 8192, -40, 40, 12));
  for (const double share : {0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.4, 2.0, 4.0}) {
    fmt::print("| {:g} |", share);
    for (int thin = 1; thin <= 3; ++thin) {
      SceneBuilder builder = testBuilder();
      const double t = share * voxel;
      Mesh mesh = meshOf(builder, "thing");
      appendBox(mesh, 0, {}, {t, thin >= 2 ? t : 1.0, thin >= 3 ? t : 1.0});
      const std::uint32_t id = builder.addMesh(mesh);
      for (std::uint32_t i = 0; i < 200; ++i) {
        const RandomBlock a = randomBlock({17, 0, 0, 0, i, 0, Purpose::Test});
        const RandomBlock b = randomBlock({17, 0, 0, 0, i, 1, Purpose::Test});
        const double azimuth = 2 * kPi * uniform(a[0]);
        const double r = 4 + 5 * uniform(a[1]);
        builder.place(id,
                      {toMatrix(fromYawPitchRoll(2 * kPi * uniform(b[0]), 3 * uniform(b[1]), 3 * uniform(b[2]))),
                       {r * std::cos(azimuth), r * std::sin(azimuth), 4 * uniform(a[2]) - 2}},
                      "thing");
      }
      const Scene scene = builder.finish();
      const Hits truth = traced(*rayTracing(scene), shot);
      for (const char* refine : {"none", "normal", "triangle"}) {
        const Hits tested = traced(*particleOf(scene, std::string("refine: ") + refine), shot);
        std::uint64_t there = 0, seen = 0;
        for (std::size_t i = 0; i < truth.size(); ++i) {
          there += truth.hit(i) ? 1 : 0;
          seen += truth.hit(i) && tested.hit(i) ? 1 : 0;
        }
        fmt::print(" {:.1f} % |", percent(seen, there));
      }
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

}  // namespace

int main() {
  try {
    const Scene scene = proceduralStreet();
    const auto tracing = rayTracing(scene);
    printSettings(scene, *tracing);
    printLevels(scene, *tracing);
    printThinThings();
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 1;
  }
}
