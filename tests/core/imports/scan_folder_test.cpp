#include "imports/scan_folder.h"

#include <fmt/core.h>

#include "base/error.h"
#include "formats/npy.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

template <class T>
std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Records of x, y, z, intensity.
const std::string kTwoPoints = bytesOf<float>({1, 2, 3, 0.25f, 4, 5, 6, 0.5f});

std::vector<std::string> keysOf(const ScanFolder& folder) {
  std::vector<std::string> keys;
  for (const FolderScan& scan : folder.scans) keys.push_back(scan.key);
  return keys;
}

TEST(ScanFolder, SemanticKittiIsReadFromItsRootASequenceAndItsScans) {
  const TemporaryFolder folder;
  const std::string labels = bytesOf<std::uint32_t>({252u | 7u << 16, 40});
  for (const char* frame : {"08/velodyne/000001", "08/velodyne/000000", "00/velodyne/000000"}) {
    folder.write(fmt::format("sequences/{}.bin", frame), kTwoPoints);
  }
  folder.write("sequences/08/labels/000000.label", labels);
  folder.write("sequences/08/labels/000001.label", labels);
  const auto root = scanFolderIn(folder.path());
  ASSERT_TRUE(root);
  EXPECT_EQ(root->layout, "kitti");
  EXPECT_EQ(root->sensor, "velodyne");
  EXPECT_THAT(keysOf(*root), ElementsAre("00-000000", "08-000000", "08-000001"));
  ASSERT_TRUE(root->ontology);
  EXPECT_EQ(root->ontology->name, "semantic_kitti");
  for (const char* part : {"sequences/08", "sequences/08/", "sequences/08/velodyne"}) {
    const auto own = scanFolderIn(folder.path() / part);
    ASSERT_TRUE(own) << part;
    EXPECT_THAT(keysOf(*own), ElementsAre("000000", "000001"));
  }
  const Scan scan = readFolderScan(root->scans[1]);
  ASSERT_EQ(scan.size(), 2u);
  EXPECT_EQ(scan.position[1], (Vec3f{4, 5, 6}));
  EXPECT_THAT(scan[kIntensity], ElementsAre(0.25f, 0.5f));
  EXPECT_THAT(scan[kLabel], ElementsAre(252, 40));
  EXPECT_THAT(scan[kInstance], ElementsAre(7u, 0u));
  EXPECT_TRUE(readFolderScan(root->scans[0])[kLabel].empty());
}

TEST(ScanFolder, KittisObjectBenchmarkAndRawDrivesAreRead) {
  const TemporaryFolder folder;
  folder.write("object/training/velodyne/000007.bin", kTwoPoints);
  folder.write("object/testing/velodyne/000007.bin", kTwoPoints);
  folder.write("drive_0001_sync/velodyne_points/data/0000000003.bin", kTwoPoints);
  EXPECT_THAT(keysOf(*scanFolderIn(folder.path() / "object")), ElementsAre("testing-000007", "training-000007"));
  EXPECT_THAT(keysOf(*scanFolderIn(folder.path() / "object/training")), ElementsAre("000007"));
  const auto drive = scanFolderIn(folder.path() / "drive_0001_sync");
  EXPECT_THAT(keysOf(*drive), ElementsAre("0000000003"));
  EXPECT_FALSE(drive->ontology);
}

class NuScenesFolder : public testing::Test {
 protected:
  NuScenesFolder() {
    tables("scene", R"([{"token": "s", "name": "scene-0061"}])");
    tables("sample", R"([{"token": "a", "scene_token": "s"}, {"token": "b", "scene_token": "s"}])");
    tables("lidarseg", R"([{"token": "l", "sample_data_token": "d1", "filename": "lidarseg/v1.0-mini/d1.bin"}])");
    tables("sample_data",
           row("d1", "a", "samples/LIDAR_TOP/one.pcd.bin", 1532402927647951, true) + "," +
               row("d2", "b", "samples/LIDAR_TOP/two.pcd.bin", 1532402928147847, true) + "," +
               row("d3", "b", "sweeps/LIDAR_TOP/between.pcd.bin", 1532402927897000, false) + "," +
               row("d4", "b", "samples/CAM_FRONT/two.jpg", 1532402928147000, true) + "]",
           "[");
    const std::string points = bytesOf<float>({1, 2, 3, 17, 31, 4, 5, 6, 255, 0});
    folder_.write("samples/LIDAR_TOP/one.pcd.bin", points);
    folder_.write("samples/LIDAR_TOP/two.pcd.bin", points);
    folder_.write("lidarseg/v1.0-mini/d1.bin", std::string("\x11\x18", 2));
  }
  void tables(const std::string& name, const std::string& text, const std::string& before = "") const {
    folder_.write("v1.0-mini/" + name + ".json", before + text);
  }
  static std::string row(const char* token, const char* sample, const char* file, std::uint64_t time, bool key) {
    return fmt::format(
        R"({{"token": "{}", "sample_token": "{}", "filename": "{}", "timestamp": {}, "is_key_frame": {}}})", token,
        sample, file, time, key);
  }

  TemporaryFolder folder_;
};

TEST_F(NuScenesFolder, KeyFramesOfTheLidarAreRead) {
  for (const fs::path& given : {folder_.path(), folder_.path() / "v1.0-mini"}) {
    const auto found = scanFolderIn(given);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->layout, "nuscenes");
    EXPECT_EQ(found->sensor, "LIDAR_TOP");
    EXPECT_THAT(keysOf(*found), ElementsAre("scene-0061-1532402927647951", "scene-0061-1532402928147847"));
    ASSERT_TRUE(found->ontology);
    const Scan scan = readFolderScan(found->scans[0]);
    EXPECT_THAT(scan[kRing], ElementsAre(31, 0));
    EXPECT_THAT(scan[kIntensity], ElementsAre(17.0f, 255.0f));
    EXPECT_THAT(scan[kLabel], ElementsAre(0x11, 0x18));
    EXPECT_EQ(scan.rings, 32u);
    EXPECT_TRUE(readFolderScan(found->scans[1])[kLabel].empty());
  }
}

TEST_F(NuScenesFolder, InstancesArePanopticLabels) {
  tables("panoptic", R"([{"token": "p", "sample_data_token": "d1", "filename": "panoptic/v1.0-mini/d1.npz"}])");
  std::string labels;
  for (const std::uint16_t label : std::vector<std::uint16_t>{17002, 24000})
    labels.append(reinterpret_cast<const char*>(&label), 2);
  std::pair<std::string, std::string> array{"data.npy", npyOf("<u2", {2}, labels)};
  folder_.write("panoptic/v1.0-mini/d1.npz", zipOf({&array, 1}));
  Scan scan = readFolderScan(scanFolderIn(folder_.path())->scans[0]);
  EXPECT_THAT(scan[kLabel], ElementsAre(0x11, 0x18));
  EXPECT_THAT(scan[kInstance], ElementsAre(17002, 0));
  fs::remove(folder_.path() / "v1.0-mini/lidarseg.json");
  scan = readFolderScan(scanFolderIn(folder_.path())->scans[0]);
  EXPECT_THAT(scan[kLabel], ElementsAre(17, 24));
  array.second = npyOf("<u2", {1}, labels.substr(0, 2));
  folder_.write("panoptic/v1.0-mini/d1.npz", zipOf({&array, 1}));
  EXPECT_THAT(messageOf([&] { readFolderScan(scanFolderIn(folder_.path())->scans[0]); }),
              HasSubstr("d1.npz: has 1 labels; its scan has 2 points"));
}

TEST_F(NuScenesFolder, DamageIsToldWithTheFile) {
  tables("sample", R"([{"token": "a"}])");
  EXPECT_THAT(messageOf([&] { scanFolderIn(folder_.path()); }), HasSubstr("sample.json: is not a table of nuScenes"));
  tables("sample", R"({"token": "a"})");
  EXPECT_THAT(messageOf([&] { scanFolderIn(folder_.path()); }), HasSubstr("it must be a list"));
  tables("sample", R"([3])");
  EXPECT_THAT(messageOf([&] { scanFolderIn(folder_.path()); }), HasSubstr("it must be a list of objects"));
  tables("sample", "[");
  EXPECT_THAT(messageOf([&] { scanFolderIn(folder_.path()); }), HasSubstr("sample.json"));
  tables("sample", R"([{"token": "a", "scene_token": "s"}])");
  fs::remove_all(folder_.path() / "samples");
  EXPECT_THAT(messageOf([&] { scanFolderIn(folder_.path()); }), HasSubstr("the scans that they list are missing"));
}

TEST(ScanFolder, FilesOfScansInOneFolderAreRead) {
  const TemporaryFolder folder;
  folder.write("b.csv", "x,y,z\n1,2,3\n");
  folder.write("a.bin", kTwoPoints);
  folder.write("notes.txt", "none");
  const auto found = scanFolderIn(folder.path());
  ASSERT_TRUE(found);
  EXPECT_THAT(keysOf(*found), ElementsAre("a.bin", "b.csv"));
  EXPECT_EQ(readFolderScan(found->scans[1]).size(), 1u);
  const TemporaryFolder empty;
  empty.write("notes.txt", "none");
  EXPECT_FALSE(scanFolderIn(empty.path()));
  EXPECT_FALSE(scanFolderIn(empty.path() / "absent"));
}

// Frames of one recording lack the same: one warning tells it.
TEST(ScanFolder, WhatReadersLeaveOutIsToldOnceAFolder) {
  const TemporaryFolder folder;
  for (const char* name : {"1.pcd", "2.pcd"}) {
    folder.write(
        name,
        "FIELDS x y z n\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 3\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 5 0 0 1 0 0 0\n"
        "DATA ascii\n1 2 3 0 0 1\n");
  }
  const auto found = scanFolderIn(folder.path());
  const auto readAll = [&] {
    for (const FolderScan& scan : found->scans) {
      EXPECT_EQ(readFolderScan(scan).position[0], (Vec3f{1, 2, 3})) << "in the frame of the sensor";
    }
  };
  EXPECT_THAT(printedBy(readAll), testing::AllOf(HasSubstr("1.pcd: left out: 1 fields of several values 'n'"),
                                                 testing::Not(HasSubstr("2.pcd"))));
}

TEST(ScanFolder, LabelsThatAreNotOneAPointAreRefused) {
  const TemporaryFolder folder;
  folder.write("velodyne/000000.bin", kTwoPoints);
  folder.write("labels/000000.label", bytesOf<std::uint32_t>({1, 2, 3}));
  const auto found = scanFolderIn(folder.path());
  EXPECT_THAT(messageOf([&] { readFolderScan(found->scans[0]); }),
              testing::AllOf(HasSubstr("000000.label"), HasSubstr("has 3 labels; its scan has 2 points")));
}

}  // namespace
}  // namespace scanmill
