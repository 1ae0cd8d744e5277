#pragma once

// A walled yard with two cars, and a pipeline that drives through it with a sensor of 8 x 64 beams.

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "dataset/reader.h"
#include "dataset/recording.h"
#include "dataset/verify.h"
#include "pipeline/run/generate.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// The yard's inner faces are at x = +-30 and y = +-20; the cars stand at x = 8.
inline std::string yardScene() {
  return fmt::format(R"(ontology: {0}/labels/scanmill.yaml
materials: {0}/labels/materials.yaml
objects:
  - {{name: floor, primitive: plane, size: [80, 80], class: ground, material: concrete}}
  - name: across
    primitive: box
    size: [1, 60, 20]
    class: wall
    material: brick
    copies: {{at: [{{position: [30.5, 0, 10]}}, {{position: [-30.5, 0, 10]}}]}}
  - name: along
    primitive: box
    size: [80, 1, 20]
    class: wall
    material: brick
    copies: {{at: [{{position: [0, 20.5, 10]}}, {{position: [0, -20.5, 10]}}]}}
  - name: car
    primitive: box
    size: [4, 2, 1.5]
    class: car
    material: painted_metal
    copies: {{at: [{{position: [8, 5, 0.75]}}, {{position: [8, -5, 0.75]}}]}}
)",
                     SCANMILL_SOURCE_DIR);
}

constexpr const char* kYardPipeline = R"(name: yard
seed: 3
scenes:
  - scene: scenes/yard.yaml
trajectories:
  - {name: drive, waypoints: [[-10, 0, 0], [10, 0, 0]], speed: 20, every_s: 0.1, frames: 4}
sensors:
  - name: top
    columns: 64
    rate_hz: 10
    elevation_deg: {top: 5, bottom: -25, rings: 8}
    range_m: [0.5, 100]
    mount: {position: [0, 0, 1.8]}
method: ray_tracing
output:
  columns: [intensity, label, instance, ring, column, time, range_true]
  formats: [pcd]
)";

// The pipeline's sensor, to be followed by others: "sensors=[" + kTop + ", {name: front, ...}]".
inline const std::string kTop =
    "{name: top, columns: 64, rate_hz: 10, elevation_deg: {top: 5, bottom: -25, rings: 8}, range_m: [0.5, 100], "
    "mount: {position: [0, 0, 1.8]}}";

using MembersByName = std::map<std::string, std::string>;  // by name relative to the dataset's folder

class Yard : public testing::Test {
 protected:
  Yard() {
    folder_.write("scenes/yard.yaml", yardScene());
    pipeline_ = folder_.write("yard.yaml", kYardPipeline);
  }

  std::filesystem::path out(const std::string& name = "out") const { return folder_.path() / name; }

  Plan planOf(const std::vector<std::string>& overrides = {},
              std::shared_ptr<const Recording> recording = nullptr) const {
    return makePlan(readPipeline(pipeline_, overrides, std::move(recording)));
  }

  // Returns the message by which planning with these overrides is refused.
  std::string refusal(const std::vector<std::string>& overrides) const {
    return messageOf([&] { planOf(overrides); });
  }

  GenerateSummary run(const std::vector<std::string>& overrides = {}, const std::string& name = "out",
                      bool overwrite = false, const std::atomic<bool>* stop = nullptr) const {
    return generate(planOf(overrides), {.folder = out(name), .overwrite = overwrite, .quiet = true, .stop = stop});
  }

  // Every dataset that these tests make must be sound.
  Manifest sound(const std::vector<std::string>& overrides = {}, const std::string& name = "out") const {
    const GenerateSummary summary = run(overrides, name);
    const Verification verification = verifyDataset(out(name));
    EXPECT_THAT(verification.problems, testing::IsEmpty());
    EXPECT_EQ(verification.samples, summary.manifest.samples.size());
    return readManifest(out(name));
  }

  // All members of all shards of a dataset.
  MembersByName members(const std::string& name = "out") const {
    MembersByName all;
    for (const ShardRecord& shard : readManifest(out(name)).shards) {
      readTar(out(name) / shard.file, [&](const std::string& member, std::string_view bytes) { all[member] = bytes; });
    }
    return all;
  }

  // The scans of the members with a suffix, in the order of their names, hence of the frames.
  std::vector<Scan> scans(const std::string& suffix = ".pcd", const std::string& name = "out") const {
    std::vector<Scan> found;
    for (const auto& [member, bytes] : members(name)) {
      if (member.ends_with(suffix)) found.push_back(decodeMember(member, bytes));
    }
    return found;
  }

  MembersByName shards(const std::string& name = "out") const {
    MembersByName all;
    for (const ShardRecord& shard : readManifest(out(name)).shards) all[shard.file] = readFile(out(name) / shard.file);
    return all;
  }

  std::shared_ptr<const Recording> recordingIn(const std::filesystem::path& folder,
                                               RecordingKind kind = RecordingKind::Hits) const {
    return std::make_shared<const Recording>(readRecording(folder, kind));
  }

  TemporaryFolder folder_;
  std::filesystem::path pipeline_;
};

// Index of the row of each beam, by ring and column.
inline std::map<std::pair<int, int>, std::size_t> rowsByBeam(const Scan& scan) {
  std::map<std::pair<int, int>, std::size_t> rows;
  for (std::size_t i = 0; i < scan.size(); ++i) rows[{scan[kRing][i], scan[kColumn][i]}] = i;
  return rows;
}

}  // namespace scanmill
