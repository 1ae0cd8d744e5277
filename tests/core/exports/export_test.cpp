// Datasets on disk, exported as a whole.

#include "exports/export.h"

#include <fmt/core.h>

#include <atomic>
#include <map>

#include "base/file.h"
#include "base/folder_lock.h"
#include "base/parallel.h"
#include "dataset/scan_store.h"
#include "tests/core/dataset/fixture.h"
#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Exports : public testing::Test {
 protected:
  Exports() {
    Manifest manifest = testManifest();
    PackedDataset dataset(folder_.path() / "data", false, 1'000'000);
    for (std::uint32_t i = 0; i < 6; ++i) {
      const std::string key = fmt::format("street-s{}-lane-00000{}", i / 3 + 1, i);
      dataset.add(testSample(manifest, i, key, i < 3 ? "train" : "val"));
    }
    dataset.finish(manifest);
  }

  ExportOptions options(const std::string& layout, const std::string& out) const {
    ExportOptions options;
    if (layout == "las") {  // whose classes have 8 bits
      options.classes =
          folder_.write("small.yaml",
                        "name: small\nclasses:\n  - {id: 0, name: unlabeled, color: [0, 0, 0]}\n"
                        "  - {id: 3, name: road, color: [9, 9, 9]}\n  - {id: 4, name: car, color: [9, 9, 99]}\n");
    }
    options.dataset = folder_.path() / "data";
    options.layout = &requireLayout(layout);
    options.folder = folder_.path() / out;
    return options;
  }

  TemporaryFolder folder_;
};

TEST_F(Exports, EveryLayoutWritesTheSameBytesWhateverTheThreads) {
  for (const LayoutEntry& entry : layouts()) {
    if (entry.name == "kitti") continue;  // needs a list of objects
    SCOPED_TRACE(entry.name);
    std::map<std::string, std::string> first;
    for (const int threads : {1, 2}) {
      const ThreadLimit limit(threads);
      const std::string out = fmt::format("{}{}", entry.name, threads);
      const ExportSummary summary = exportDataset(options(std::string(entry.name), out));
      EXPECT_EQ(summary.frames, 6u);
      EXPECT_EQ(summary.sequences, 2u);
      const auto files = filesIn(folder_.path() / out);
      EXPECT_TRUE(files.contains("scanmill_export.json"));
      EXPECT_FALSE(files.contains(".scanmill_export.json"));
      EXPECT_GE(files.size(), 3u);
      if (first.empty()) first = files;
      EXPECT_EQ(files, first);
    }
  }
}

// Layouts with one scan of each sensor in a frame refuse samples with several, or none, of a sensor; the others write
// all.
TEST_F(Exports, EveryRevolutionIsWrittenOrRefused) {
  Manifest manifest = testManifest();
  PackedDataset dataset(folder_.path() / "data", true, 1'000'000);
  for (std::uint32_t i = 0; i < 2; ++i) {
    Sample sample = testSample(manifest, i, fmt::format("street-s1-lane-00000{}", i), "train");
    const Sample other = testSample(manifest, i + 10, "other", "train");
    ScanRecord second = other.scans.front();
    second.revolution = 1;
    for (const FormatRecord& format : manifest.formats) {
      sample.files.push_back(
          {memberSuffix(second, format.suffix), other.files[&format - manifest.formats.data()].bytes});
    }
    sample.scans.push_back(second);
    dataset.add(sample);
  }
  dataset.finish(manifest);
  const std::string name = manifest.sensors.front().name;
  EXPECT_THAT(messageOf<InputError>([&] { exportDataset(options("semantic_kitti", "refused")); }),
              HasSubstr(fmt::format("has 2 of '{}', which turns at another rate than others", name)));
  EXPECT_FALSE(fs::exists(folder_.path() / "refused"));
  exportDataset(options("ply", "ply"));
  const auto files = filesIn(folder_.path() / "ply");
  const std::string file = "train/street-s1-lane-000001." + name;
  const auto holds = [&](const std::string& revolution, std::uint64_t points) {
    return files.at(file + revolution + ".ply").find(fmt::format("element vertex {}\n", points)) != std::string::npos;
  };
  const ScanStore store(folder_.path() / "data");
  const std::vector<StoredScan> scans = store.scans(1, name);
  ASSERT_NE(scans.at(0).record->points, scans.at(1).record->points);
  EXPECT_TRUE(holds("", scans[0].record->points));
  EXPECT_TRUE(holds(".1", scans[1].record->points));
}

// An export that was stopped or killed is not taken for a complete one, and is replaced by the same bytes.
TEST_F(Exports, StoppedOnesAreReplacedByTheSameBytes) {
  for (const std::string layout : {"ply", "mcap"}) {  // a file for each frame, and for each sequence
    SCOPED_TRACE(layout);
    const auto into = [&](const std::string& name) { return options(layout, layout + "_" + name); };
    exportDataset(into("whole"));
    const auto whole = filesIn(into("whole").folder);
    std::atomic<bool> stop = false;
    ExportOptions cut = into("cut");
    cut.stop = &stop;
    cut.progress = [&](const char*, std::uint64_t done, std::uint64_t) { stop = done >= 2; };
    EXPECT_THAT(messageOf<Error>([&] { exportDataset(cut); }), HasSubstr("--overwrite"));
    EXPECT_FALSE(fs::exists(cut.folder / "scanmill_export.json"));
    folder_.write(layout + "_cut/train/x." + layout + ".partial-4711", "half");
    ExportOptions again = into("cut");
    EXPECT_THAT(messageOf<InputError>([&] { exportDataset(again); }), HasSubstr("has an unfinished export"));
    again.overwrite = true;
    {
      const FolderLock other(cut.folder, cut.folder / ".scanmill_export.lock");
      EXPECT_THAT(messageOf<InputError>([&] { exportDataset(again); }), HasSubstr("is being written by process"));
    }
    exportDataset(again);
    EXPECT_EQ(filesIn(cut.folder), whole);
    folder_.write(layout + "_start/.scanmill_export.json.partial-4711", "half");
    exportDataset(into("start"));
    EXPECT_EQ(filesIn(into("start").folder), whole);
  }
}

TEST_F(Exports, TheDatasetsOwnFolderIsNotWrittenInto) {
  for (const char* inside : {"data", "data/ply", "data/../data/x/y"}) {
    EXPECT_THAT(messageOf<InputError>([&] { exportDataset(options("ply", inside)); }),
                HasSubstr("within the dataset's folder"))
        << inside;
    EXPECT_FALSE(fs::exists(folder_.path() / "data/ply"));
  }
  EXPECT_NO_THROW(exportDataset(options("ply", "data_ply")));
}

// An export replaces another one where the caller asks for it, and nothing else.
TEST_F(Exports, ReplaceOthersWhenAsked) {
  ExportOptions first = options("ply", "out");
  exportDataset(first);
  const auto whole = filesIn(first.folder);
  ExportOptions other = options("mcap", "out");
  other.overwrite = true;
  exportDataset(other);
  for (const auto& [name, bytes] : filesIn(first.folder)) EXPECT_FALSE(name.ends_with(".ply")) << name;
  first.overwrite = true;
  exportDataset(first);
  EXPECT_EQ(filesIn(first.folder), whole);
  folder_.write("notes/mine.txt", "mine");
  ExportOptions mine = options("ply", "notes");
  for (const bool overwrite : {false, true}) {
    mine.overwrite = overwrite;
    EXPECT_THAT(messageOf<InputError>([&] { exportDataset(mine); }), HasSubstr("is not empty"));
  }
  EXPECT_THAT(messageOf<InputError>([&] { exportDataset(options("ply", "out")); }), HasSubstr("has a complete export"));
}

TEST_F(Exports, ClassesThatTheLayoutLacksAreNamed) {
  const ExportSummary own = exportDataset(options("ply", "ply"));
  EXPECT_THAT(own.warnings, testing::IsEmpty());
  const auto file = folder_.write("mine.yaml",
                                  "name: mine\nclasses:\n  - {id: 0, name: unlabeled, color: [0, 0, 0]}\n"
                                  "  - {id: 3, name: ways, color: [9, 9, 9], aliases: [street]}\n");
  ExportOptions mapped = options("ply", "mapped");
  mapped.classes = file;
  const ExportSummary summary = exportDataset(mapped);
  ASSERT_EQ(summary.warnings.size(), 1u);
  EXPECT_THAT(summary.warnings[0], testing::AllOf(HasSubstr("mine has no class for car"), HasSubstr("--classes")));
}

TEST_F(Exports, SensorsAndSplitsAreChosenByName) {
  ExportOptions one = options("ply", "rear");
  one.sensors = {"Rear"};
  one.splits = {"val"};
  EXPECT_EQ(exportDataset(one).frames, 3u);
  for (const auto& [name, bytes] : filesIn(one.folder)) EXPECT_EQ(name.find("top"), std::string::npos) << name;
  const ExportSummary first = exportDataset(options("semantic_kitti", "kitti"));
  EXPECT_THAT(testing::PrintToString(first.warnings), HasSubstr("writes those of 'top'"));
  ExportOptions wrong = options("ply", "no");
  wrong.sensors = {"front"};
  EXPECT_THAT(messageOf<InputError>([&] { exportDataset(wrong); }), HasSubstr("it has top, Rear"));
  wrong = options("ply", "no");
  wrong.splits = {"test"};
  EXPECT_THAT(messageOf<InputError>([&] { exportDataset(wrong); }), HasSubstr("it has train, val"));
  EXPECT_FALSE(fs::exists(wrong.folder));
  EXPECT_THAT(messageOf<InputError>([&] { requireLayout("semantickitti"); }), HasSubstr("semantic_kitti"));
}

// What verify would find is not handed on.
TEST_F(Exports, DamagedMembersAreRefused) {
  const fs::path shard = folder_.path() / "data" / "val" / "val-000000.tar";
  std::string bytes = readFile(shard);
  const std::size_t member = bytes.find(".top.ray_tracing.pcd");
  bytes[bytes.find("DATA", member) + 60] ^= 1;
  writeFile(shard, bytes);
  EXPECT_THAT(messageOf<InputError>([&] { exportDataset(options("ply", "out")); }),
              testing::AllOf(HasSubstr("street-s2-lane-000003.top.ray_tracing.pcd"), HasSubstr("changed since"),
                             HasSubstr("scanmill verify")));
}

TEST_F(Exports, WhatDoesNotFitLeavesNoFile) {
  EXPECT_THAT(messageOf<InputError>([&] { exportDataset(options("kitti", "no")); }), HasSubstr("objects: true"));
  EXPECT_FALSE(fs::exists(folder_.path() / "no"));
}

TEST(ClassMaps, GoByNamesAndAliasesOfBoth) {
  const Ontology from{"from",
                      "",
                      {{0, "unlabeled", {}, false, {}},
                       {4, "car", {}, true, {}},
                       {5, "lorry", {}, true, {"truck"}},
                       {6, "moving_car", {}, true, {}, 4},
                       {7, "tree", {}, true, {}}}};
  const Ontology to{"to",
                    "",
                    {{0, "unlabeled", {}, false, {}},
                     {10, "vehicle", {}, true, {"car"}},
                     {11, "truck", {}, true, {}},
                     {20, "moving-vehicle", {}, true, {}, 10}}};
  const ClassMap map(from, to);
  EXPECT_EQ(map.targetId(4), 10);
  EXPECT_EQ(map.targetId(5), 11);
  EXPECT_EQ(map.targetId(6), 10) << "what moves is what it is, where the target does not tell";
  EXPECT_EQ(map.movingTargetId(4), 20);
  EXPECT_EQ(map.movingTargetId(5), 11);
  EXPECT_EQ(map.targetId(7), 0);
  EXPECT_EQ(map.targetId(999), 0);
}

}  // namespace
}  // namespace scanmill
