#pragma once

// A wall that is scanned again and again.

#include <fmt/core.h>

#include <string>
#include <utility>
#include <vector>

#include "study/repeatability/repeatability.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

constexpr const char* kShells = R"(  noise:
    - {name: none, effects: []}
    - {name: 1 mm, effects: [{shell: {scale_m: 0.001}}]}
    - {name: 4 cm, effects: [{shell: {scale_m: 0.04}}]}
    - {name: growing, effects: [{shell: {growth_per_m: 0.001}}]}
  reference: 1 mm
)";

// A wall of 2 x 2 m, its front in the plane x = 0, and a crate far behind the sensor. Beams look at the wall alone:
// rings and columns 0.5 degrees apart over 20 degrees.
class RepeatedScans : public testing::Test {
 protected:
  RepeatedScans() {
    folder_.write("wall.yaml", fmt::format(R"(ontology: {0}/labels/scanmill.yaml
materials: {0}/labels/materials.yaml
objects:
  - {{name: slab, primitive: box, size: [0.2, 2, 2], class: object, material: wood, position: [0.1, 0, 0]}}
  - {{name: crate, primitive: box, size: [1, 1, 1], class: object, material: wood, position: [-40, 0, 0]}}
)",
                                           SCANMILL_SOURCE_DIR));
  }

  std::filesystem::path pipeline(const std::string& repeatability, const std::string& more = "") const {
    return folder_.write("p.yaml", fmt::format(R"(seed: 7
scenes: [{{scene: wall.yaml}}]
trajectories:
  - name: ahead
    poses: [{{position: [-3, 0.01, 0.02]}}, {{position: [-6, 0.01, 0.02]}}, {{position: [-12, 0.01, 0.02]}}]
sensors:
  - {{name: top, columns: 21, rate_hz: 10, first_azimuth_deg: -10, field_deg: 20, elevation_deg: {{top: 10, bottom: -10, rings: 21}}, range_m: [0.5, 100]}}
method: ray_tracing
output: {{formats: [pcd]}}
{}repeatability:
{})",
                                               more, repeatability));
  }

  static Repeatability measure(const std::filesystem::path& file, const std::vector<std::string>& overrides = {}) {
    return measure(readPipeline(file, overrides));
  }
  static Repeatability measure(Pipeline read) {
    const Channels channels = repeatabilityChannels(read);
    const Plan plan = makePlan(std::move(read), channels);
    return measureRepeatability(plan, {.quiet = true});
  }

  // Of kShells: measured once.
  const Repeatability& shells() const {
    static const Repeatability result = measure(pipeline(kShells));
    return result;
  }

  void expectRefusedAt(const std::string& repeatability, const std::vector<std::string>& words) const {
    const std::filesystem::path file = pipeline(repeatability);
    expectInputError([&] { readRepeatabilityChoice(readPipeline(file, {})); }, words);
  }

  TemporaryFolder folder_;
};

}  // namespace scanmill
