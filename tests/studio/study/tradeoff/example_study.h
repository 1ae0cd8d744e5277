#pragma once

// A study with figures such as a street gives, though none was measured.

#include <string>
#include <vector>

#include "study/tradeoff/study.h"

namespace scanmill {

// What the figures of a setting follow from.
struct ExampleSetting {
  std::string method;
  std::string options;  // "resolution=512 sampling=nearest"
  double milliseconds;  // a scan
  double p99;           // m
  double labels;        // share that agrees
  double missed;        // share of the beams
  double edges = 8;     // by how much errors are larger at edges
};

inline Spread exampleSpread(std::size_t count, double p99) {
  if (p99 <= 0) return {count, 0, 0, 0, 0, 0, 0, 9.5e-7};
  return {count, p99 / 12, p99 / 5, p99 / 400, p99 / 8, p99, p99 * 7, p99 * 60};
}

inline GroupErrors exampleErrors(std::uint64_t beams, double p99, double labels, double missed) {
  GroupErrors e;
  e.beams = beams;
  const auto part = [](double share, std::uint64_t whole) {
    return static_cast<std::uint64_t>(std::llround(share * static_cast<double>(whole)));
  };
  e.falseNegatives = part(missed * 0.4, beams);
  e.falsePositives = part(missed * 0.6, beams);
  e.bothMiss = part(0.1, beams);
  e.bothHit = beams - e.bothMiss - e.falseNegatives - e.falsePositives;
  e.sameLabel = part(labels, e.bothHit);
  e.sameClass = part(1 - (1 - labels) * 0.7, e.bothHit);
  e.sameInstance = part(1 - (1 - labels) * 0.8, e.bothHit);
  e.range = exampleSpread(e.bothHit, p99);
  e.intensity = exampleSpread(e.bothHit, p99 / 10);
  e.nearestTo = exampleSpread(e.bothHit + e.falseNegatives, p99 / 3);
  e.nearestFrom = exampleSpread(e.bothHit + e.falsePositives, p99 / 2);
  return e;
}

inline SettingResult exampleResult(const ExampleSetting& given) {
  SettingResult result;
  result.setting.method = given.method;
  result.setting.name = given.options.empty() ? given.method : given.method + " " + given.options;
  std::string flow;
  for (const char c : given.options)
    flow += c == '=' ? std::string(": ") : c == ' ' ? std::string(", ") : std::string(1, c);
  result.setting.options = "{" + flow + "}";
  Cost& cost = result.measured.cost;
  const double seconds = given.milliseconds * 1e-3;
  cost = {given.method == "particle" ? 1.4 : 0.31, seconds, seconds * 0.93, seconds * 1.2, {}, 96'000'000, 130'000'000};
  if (given.method == "depth_camera") {
    cost.stages = {{"read_back", seconds * 0.06}, {"render", seconds * 0.85}, {"sample", seconds * 0.05}};
  } else if (given.method == "particle") {
    cost.stages = {{"launch", seconds * 0.05}, {"march", seconds * 1.6}, {"resolve", seconds * 0.2}};
  }

  BeamErrors& errors = result.measured.errors;
  const double p99 = given.p99, wrong = 1 - given.labels, missed = given.missed;
  errors.all = exampleErrors(393'216, p99, given.labels, missed);
  const auto band = [&](std::vector<ErrorGroup>& groups, const std::string& name, std::uint64_t beams, double factor) {
    const double labels = std::max(0.0, 1 - wrong * factor);
    groups.push_back({name, 0, 0, exampleErrors(beams, p99 * factor, labels, std::min(0.5, missed * factor))});
  };
  const std::vector<std::string> ranges{"0 to 5 m",   "5 to 10 m",  "10 to 20 m",
                                        "20 to 40 m", "40 to 80 m", "80 m and more"};
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    band(errors.byRange, ranges[i], 120'000 >> i, std::pow(2.2, static_cast<double>(i) - 2));
  }
  const std::vector<std::string> angles{"0 to 30 deg",  "30 to 45 deg", "45 to 60 deg",
                                        "60 to 75 deg", "75 to 85 deg", "85 to 90 deg"};
  for (std::size_t i = 0; i < angles.size(); ++i) {
    band(errors.byIncidence, angles[i], 60'000, std::pow(1.9, static_cast<double>(i) - 3));
  }
  band(errors.byEdge, "interior", 350'000, 1 / given.edges);
  band(errors.byEdge, "edges", 43'216, given.edges);
  const std::vector<std::string> classes{"road",         "car",     "building",    "sidewalk",   "curb",
                                         "road_marking", "tree",    "pole",        "vegetation", "pedestrian",
                                         "street_lamp",  "bicycle", "traffic_sign"};
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const bool thin = i >= 6;
    band(errors.byClass, classes[i], 130'000 >> i,
         thin ? 5 + static_cast<double>(i) : 0.3 + 0.1 * static_cast<double>(i));
  }
  const std::vector<std::string> thickness{"0 to 0.05 m", "0.05 to 0.2 m", "0.2 to 0.5 m", "0.5 to 1 m",
                                           "1 m and more"};
  const std::vector<std::string> lengths{"0 to 0.3 m", "0.3 to 1 m", "1 to 2 m", "2 to 5 m", "5 m and more"};
  for (std::size_t i = 0; i < thickness.size(); ++i) {
    const std::uint64_t things = 9 + 7 * i;
    const auto found = static_cast<std::uint64_t>(
        std::llround(static_cast<double>(things) * std::pow(given.labels, 6.0 / static_cast<double>(i + 1))));
    errors.byThickness.push_back({thickness[i], 0, 0, things, found, things * 100, found * 90});
    errors.byLength.push_back({lengths[i], 0, 0, things + 3, found + 3, things * 100, found * 90});
  }
  return result;
}

inline Study exampleStudy() {
  Study study;
  study.programVersion = "0.1.0";
  study.date = "2026-11-20";
  study.machine = {"AMD EPYC 9B14", 2, "llvmpipe (LLVM 15.0.6, 256 bits)"};
  study.pipelineName = "quickstart";
  study.pipelineText = "name: quickstart\nscenes: [{street: {seeds: [1, 2, 3]}}]\n# --set seed=7\n";
  study.budgetSeconds = 300;
  study.repeats = 3;
  study.seconds = 214;
  study.scene = {"street-s1-lane", 1'283'402, {3, 10, 17}};
  study.sensors = {"top: paper_64, 64 x 2048 beams"};
  study.shots = 3;
  study.beamsPerShot = 131'072;
  const std::vector<ExampleSetting> settings{
      {"ray_tracing", "", 5.4, 0, 1, 0},
      {"depth_camera", "", 115, 0.0118, 0.9889, 7e-4},
      {"particle", "", 20.2, 0, 0.999996, 4e-6},
      {"ray_tracing", "simplify=0.5", 5.0, 0.021, 0.9951, 1.4e-3},
      {"ray_tracing", "simplify=0.25", 4.6, 0.064, 0.987, 4e-3},
      {"ray_tracing", "simplify=0.1", 4.1, 0.31, 0.961, 0.011},
      {"depth_camera", "resolution=512", 31, 0.252, 0.9525, 1.7e-3},
      {"depth_camera", "resolution=1024", 52, 0.142, 0.972, 1.3e-3},
      {"depth_camera", "sampling=nearest", 113, 0.421, 0.9845, 8e-4},
      {"particle", "voxels=128", 13.5, 0.65, 0.8917, 6.4e-3},
      {"particle", "refine=none", 10.3, 2.66, 0.8867, 6.6e-3},
      {"ray_tracing", "instancing=always", 15.9, 0, 1, 0},
      {"ray_tracing", "simplify=0.9", 4.9, 0, 0.99998, 3e-6},
      {"ray_tracing", "instancing=never", 6.3, 0, 1, 0},
      {"ray_tracing", "simplify=0.99", 5.2, 0, 1, 0},
      {"particle", "voxel_m=0.2", 11.8, 0.9, 0.83, 9e-3},
      {"particle", "refine=none voxel_m=0.2", 9.1, 2.85, 0.8186, 7.1e-3},
      {"particle", "refine=none voxels=512", 14.2, 1.76, 0.9012, 3.6e-3},
      {"particle", "backend=gl refine=triangle", 98, 0, 0.999996, 4e-6},
      {"depth_camera", "depth=uint16", 116, 1.59, 0.9845, 8e-4},
      {"depth_camera", "layout=three_120", 145, 0.0464, 0.9845, 8e-4},
      {"depth_camera", "layout=three_120 sampling=nearest depth=half_500", 144, 0.465, 0.9845, 8e-4},
      {"depth_camera", "sampling=nearest resolution=512", 30, 1.84, 0.9525, 1.9e-3},
      {"particle", "levels=1 voxel_m=1 refine=none", 7.7, 3.63, 0.6502, 0.0132}};
  for (const ExampleSetting& s : settings) study.settings.push_back(exampleResult(s));
  SettingResult failed;
  failed.setting = {"depth_camera renderer=blender", "depth_camera", "{renderer: blender}"};
  failed.failure = "Blender was not found: scripts/setup --blender installs it";
  study.settings.push_back(failed);
  study.commonStages = {{"effects", 0.0061}, {"encode pcd", 0.013}};
  study.sensing = {
      {"truth: 127 rays a beam", "", 0.92, 1.09, 131'072, 120'000, 0, 0, 120'000, {}, 0},
      {"1 ray a beam", "", 0.016, 0.039, 131'072, 119'300, 700, 300, 118'100, exampleSpread(119'300, 0.9), 1.5},
      {"clear air", "the sensor does not say how wide its beams are", 0, 0, 0, 0, 0, 0, 0, {}, 0}};
  study.encodings = {{"pcd", "pcd", "{}", "", 10.1e6, 24e6, 14.6, 0, 0},
                     {"pcd encoding=binary", "pcd", "{encoding: binary}", "", 140e6, 210e6, 32, 0, 0},
                     {"draco max_error_mm=0.1", "draco", "{max_error_mm: 0.1}", "", 7.4e6, 9.9e6, 4.1, 9.1e-5, 1e-4},
                     {"draco max_error_mm=1", "draco", "{max_error_mm: 1}", "", 9.1e6, 12.1e6, 3.1, 8.8e-4, 1e-3},
                     {"draco max_error_mm=10", "draco", "{max_error_mm: 10}", "", 10.6e6, 14e6, 2.2, 8.1e-3, 1e-2},
                     {"draco max_error_mm=50", "draco", "{max_error_mm: 50}", "", 11.9e6, 15e6, 1.6, 0.042, 0.05}};
  study.leftOut = {"depth_camera resolution=4096: the budget of 5 min was used up"};
  return study;
}

// That study with other settings.
inline Study studyOf(const std::vector<ExampleSetting>& settings) {
  Study study = exampleStudy();
  study.settings.clear();
  for (const ExampleSetting& s : settings) study.settings.push_back(exampleResult(s));
  return study;
}

}  // namespace scanmill
