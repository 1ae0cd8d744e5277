#include "viewer/frames/frame_source.h"

#include <atomic>
#include <set>

#include "base/file.h"
#include "base/parallel.h"
#include "dataset/scan_store.h"
#include "tests/studio/viewer/frames/frame_fixture.h"
#include "tests/support/shared_data.h"
#include "viewer/frames/stored_frames.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

void expectSameScan(const Scan& a, const Scan& b) {
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(columnNames(a), columnNames(b));
  EXPECT_EQ(a[kLabel], b[kLabel]);
  EXPECT_EQ(a[kInstance], b[kInstance]);
  EXPECT_EQ(a[kTime], b[kTime]);
  EXPECT_EQ(a.organised, b.organised);
}

class Frames : public testing::Test {
 protected:
  Frames() : data(folder.path() / "data"), manifest(writeTestDataset(data)) {}

  ViewInput input() const { return {.path = data}; }
  std::filesystem::path changed(const std::string& name, const DatasetChanges& changes = {}) const {
    writeChangedDataset(folder.path() / name, changes);
    return folder.path() / name;
  }

  TemporaryFolder folder;
  std::filesystem::path data;
  Manifest manifest;
};

TEST_F(Frames, EqualWhatFindScanGives) {
  const auto source = openFrames(input());
  EXPECT_EQ(source->title(), "data");
  EXPECT_FALSE(source->isScene());
  ASSERT_EQ(source->keys().size(), 9u);
  ASSERT_NE(source->ontology(), nullptr);
  EXPECT_EQ(source->ontology()->find(65535)->name, "car");
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(source->keys()[i], manifest.samples[i].key);
    const ViewFrame frame = source->load(i);
    EXPECT_EQ(frame.key, source->keys()[i]);
    EXPECT_THAT(frame.problems, IsEmpty());
    EXPECT_THAT(namesOf(frame), ElementsAre("top", "Rear"));
    for (std::size_t s = 0; s < 2; ++s) {
      const ViewScan& scan = frame.scans[s];
      expectSameScan(scan.scan, findScan(data, frame.key, scan.sensor).scan);
      const ScanRecord& record = manifest.samples[i].scans[s];
      EXPECT_EQ(scan.sensor, record.sensor);
      EXPECT_EQ(scan.method, "ray_tracing");
      EXPECT_EQ(scan.time, record.time);
      EXPECT_EQ(scan.worldFromSensor, record.worldFromSensor.front());
      ASSERT_NE(scan.beams, nullptr);
      EXPECT_EQ(scan.beams->direction, manifest.sensors[s].beams.direction);
      EXPECT_EQ(scan.errorTitle, "range error (m)");
      EXPECT_EQ(scan.error.size(), scan.scan.size());
    }
  }
}

// The fixture's sensors move from their first pose to their second one while they turn, and its scans are not deskewed.
TEST_F(Frames, HaveThePointsWhereTheSensorSawThem) {
  const ViewFrame frame = openFrames(input())->load(4);
  for (std::size_t s = 0; s < 2; ++s) {
    const ViewScan& scan = frame.scans[s];
    const std::vector<Pose>& poses = manifest.samples[4].scans[s].worldFromSensor;
    ASSERT_EQ(scan.drawnPositions().size(), scan.scan.size());
    int moved = 0;
    for (std::size_t i = 0; i < scan.scan.size(); ++i) {
      const double part = scan.scan[kColumn][i] / (scan.scan.columns - 1.0);
      const Vec3d world = interpolate(poses[0], poses[1], part) * Vec3d(scan.scan.position[i]);
      EXPECT_NEAR(length(poses[0] * Vec3d(scan.drawnPositions()[i]) - world), 0, 1e-4);
      moved += length(Vec3d(scan.drawnPositions()[i]) - Vec3d(scan.scan.position[i])) > 0.1 ? 1 : 0;
    }
    EXPECT_GT(moved, 0);
  }
  const auto still = changed("deskewed", {.manifest = [](Manifest& m) { m.deskewed = true; }});
  EXPECT_TRUE(openFrames({.path = still})->load(0).scans[0].placed.empty());
}

TEST_F(Frames, OfOneSensor) {
  ViewInput rear = input();
  rear.sensor = "rear";
  const auto source = openFrames(rear);
  EXPECT_THAT(namesOf(source->load(3)), ElementsAre("Rear"));
  rear.sensor = "left";
  EXPECT_THAT(messageOf([&] { openFrames(rear); }), AllOf(HasSubstr("'left'"), HasSubstr("top, Rear")));
}

TEST_F(Frames, OfAShardWithAndWithoutItsManifest) {
  const auto shard = data / manifest.shards.front().file;
  const auto source = openFrames({.path = shard});
  const auto whole = openFrames(input());
  ASSERT_FALSE(source->keys().empty());
  EXPECT_LT(source->keys().size(), 9u);
  ASSERT_NE(source->ontology(), nullptr);
  const auto bare = folder.path() / "lonely.tar";
  std::filesystem::copy(shard, bare);
  const auto lonely = openFrames({.path = bare});
  EXPECT_EQ(lonely->keys(), source->keys());
  EXPECT_EQ(lonely->ontology(), nullptr);
  for (std::size_t i = 0; i < source->keys().size(); ++i) {
    const ViewFrame frame = source->load(i);
    const ViewFrame other = lonely->load(i);
    ASSERT_EQ(frame.scans.size(), 2u);
    EXPECT_THAT(namesOf(frame), ElementsAre("top", "Rear"));
    EXPECT_THAT(namesOf(other), ElementsAre("top", "rear"));
    for (std::size_t s = 0; s < 2; ++s) {
      expectSameScan(frame.scans[s].scan, whole->load(i).scans[s].scan);
      expectSameScan(other.scans[s].scan, frame.scans[s].scan);
      EXPECT_TRUE(frame.scans[s].worldFromSensor);
      EXPECT_FALSE(other.scans[s].worldFromSensor);
      EXPECT_EQ(other.scans[s].beams, nullptr);
    }
  }
  EXPECT_EQ(source->trajectory(0), whole->trajectory(0));
  EXPECT_THAT(lonely->trajectory(0), IsEmpty());
}

TEST_F(Frames, OfASingleScan) {
  for (const FormatEntry& format : formats()) {
    const auto file = folder.write("one." + std::string(format.suffix),
                                   encode(std::string(format.name), testScan(manifest.sensors[0].beams, 4)));
    const auto source = openFrames({.path = file});
    EXPECT_THAT(source->keys(), ElementsAre(file.filename().string()));
    const ViewFrame frame = source->load(0);
    EXPECT_THAT(frame.problems, IsEmpty());
    EXPECT_THAT(namesOf(frame), ElementsAre(file.filename().string()));
    expectSameScan(frame.scans[0].scan, findScan(file, "", "").scan);
    EXPECT_THAT(source->trajectory(0), IsEmpty());
    std::string why;
    EXPECT_FALSE(source->scene(0, why));
    EXPECT_THAT(why, HasSubstr("--scene FILE"));
  }
}

TEST_F(Frames, AnEmptyScanIsShown) {
  const auto file = folder.write("none.pcd", encode("pcd", Scan{}));
  const ViewFrame frame = openFrames({.path = file})->load(0);
  EXPECT_THAT(frame.problems, IsEmpty());
  ASSERT_EQ(frame.scans.size(), 1u);
  EXPECT_EQ(frame.scans[0].scan.size(), 0u);
}

TEST_F(Frames, SeveralMethodsOfASample) {
  const auto source = openFrames({.path = changed("both", {.methods = {"ray_tracing", "particle"}})});
  EXPECT_THAT(namesOf(source->load(1)),
              ElementsAre("top, ray_tracing", "top, particle", "Rear, ray_tracing", "Rear, particle"));
}

TEST_F(Frames, LieOverOneAnother) {
  const auto a = changed("a/out", {.frames = 3});
  const auto b = changed("b/out", {.frames = 2});
  const auto file = folder.write("one.pcd", encode("pcd", testScan(manifest.sensors[0].beams, 4)));
  const auto source = openFrames({.path = a, .over = {b, file}});
  EXPECT_EQ(source->title(), "a/out");
  EXPECT_EQ(source->keys().size(), 3u);
  EXPECT_THAT(namesOf(source->load(0)),
              ElementsAre("a/out: top", "a/out: Rear", "b/out: top", "b/out: Rear", "one.pcd"));
  const ViewFrame last = source->load(2);
  EXPECT_THAT(namesOf(last), ElementsAre("a/out: top", "a/out: Rear", "one.pcd"));
  EXPECT_THAT(last.problems, ElementsAre(AllOf(HasSubstr("b/out"), HasSubstr("'town-s3-drive-000002'"))));
  EXPECT_THAT(namesOf(openFrames({.path = a, .over = {a}, .sensor = "top"})->load(0)),
              ElementsAre("out: top", "out: top (2)"));
}

TEST_F(Frames, OtherClassesAreNoted) {
  const auto a = changed("a");
  const auto b = changed("b", {.manifest = [](Manifest& m) {
                           m.ontology.name = "theirs";
                           m.ontology.classes[1].name = "lawn";
                         }});
  const ViewInput both{.path = a, .over = {b}};
  EXPECT_THAT(openFrames(both)->load(0).problems,
              ElementsAre(AllOf(HasSubstr("b has other classes"), HasSubstr("class 7 is road in 'ours' and lawn in"))));
  const auto labels = std::filesystem::path(SCANMILL_SOURCE_DIR) / "labels/scanmill.yaml";
  const auto ours = openFrames({.path = a, .over = {b}, .ontology = labels});
  EXPECT_THAT(ours->load(0).problems, IsEmpty());
  ASSERT_NE(ours->ontology(), nullptr);
  EXPECT_EQ(ours->ontology()->name, readOntology(labels).name);
}

// The noise that a dataset was given is the error that its frames show, whatever the reference's method.
TEST_F(Frames, TheReferenceShowsTheNoise) {
  const auto shift = [](std::size_t point, std::size_t sample) {
    return 0.01 * double(point % 5) + 0.001 * double(sample);
  };
  const auto clean = changed("clean", {.methods = {"particle"}, .revolutions = 2});
  const auto noisy = changed("noisy", {.scan =
                                           [&](Scan& scan, std::size_t sample, std::size_t) {
                                             for (std::size_t i = 0; i < scan.size(); ++i) {
                                               const Vec3d p(scan.position[i]);
                                               scan.position[i] = Vec3f(p + normalized(p) * shift(i, sample));
                                             }
                                           },
                                       .revolutions = 2});
  const auto source = openFrames({.path = noisy, .reference = clean});
  for (std::size_t f = 0; f < source->keys().size(); ++f) {
    const ViewFrame frame = source->load(f);
    EXPECT_THAT(frame.problems, IsEmpty());
    ASSERT_EQ(frame.scans.size(), 4u);
    for (const ViewScan& scan : frame.scans) {
      EXPECT_EQ(scan.errorTitle, "distance to the reference (m)");
      ASSERT_EQ(scan.error.size(), scan.scan.size());
      for (std::size_t i = 0; i < scan.error.size(); ++i) EXPECT_NEAR(scan.error[i], shift(i, f), 2e-5);
    }
  }
}

TEST_F(Frames, AReferenceThatLacksSamplesOrColumnsIsAProblem) {
  const auto scan = changed("scan");
  const auto reference = changed("reference", {.frames = 2});
  const auto bare = changed("bare", {.scan = [](Scan& s, std::size_t, std::size_t) { s[kColumn].clear(); }});
  const auto other = changed("other", {.manifest = [](Manifest& m) { m.sensors.pop_back(); }});
  const ViewFrame third = openFrames({.path = scan, .reference = reference})->load(2);
  EXPECT_EQ(third.scans.size(), 2u);
  EXPECT_TRUE(third.scans[0].error.empty());
  EXPECT_THAT(third.problems, ElementsAre(AllOf(HasSubstr("reference"), HasSubstr("000002"))));
  EXPECT_THAT(openFrames({.path = scan, .reference = bare})->load(0).problems,
              ElementsAre(AllOf(HasSubstr("bare"), HasSubstr("ring and column in output.columns"))));
  const auto twice = changed("twice", {.revolutions = 2});
  EXPECT_THAT(openFrames({.path = twice, .reference = scan, .sensor = "top"})->load(0).problems,
              ElementsAre(HasSubstr("has no revolution 1 of 'top'")));
  const ViewFrame half = openFrames({.path = scan, .reference = other})->load(0);
  EXPECT_FALSE(half.scans[0].error.empty());
  EXPECT_TRUE(half.scans[1].error.empty());
  EXPECT_THAT(half.problems, ElementsAre(AllOf(HasSubstr("'Rear'"), HasSubstr("it has top"))));
  const auto file = folder.write("one.pcd", encode("pcd", testScan(manifest.sensors[0].beams, 0)));
  EXPECT_THAT(openFrames({.path = scan, .reference = file})->load(0).problems,
              ElementsAre(HasSubstr("--sensor whose")));
  const ViewFrame joined = openFrames({.path = scan, .reference = file, .sensor = "top"})->load(0);
  EXPECT_THAT(joined.problems, IsEmpty());
  for (const float e : joined.scans[0].error) EXPECT_EQ(e, 0);
}

TEST_F(Frames, PointsMovedToTheStartOfTheTurnHaveNoRangeError) {
  const auto moved = changed("moved", {.manifest = [](Manifest& m) { m.deskewed = true; }});
  EXPECT_TRUE(openFrames({.path = moved})->load(0).scans[0].error.empty());
}

TEST_F(Frames, TrajectoryOfTheSequence) {
  const auto source = openFrames(input());
  for (const std::size_t frame : {0u, 5u, 6u, 8u}) {
    const std::string split = manifest.samples[frame].split;
    std::vector<Pose> expected;
    for (const SampleRecord& s : manifest.samples) {
      if (s.split == split) expected.push_back(s.scans.front().worldFromSensor.front());
    }
    EXPECT_EQ(source->trajectory(frame), expected) << frame;
  }
  const auto rear = openFrames({.path = data, .sensor = "rear"});
  EXPECT_EQ(rear->trajectory(8).front(), manifest.samples[8].scans[1].worldFromSensor.front());
}

TEST_F(Frames, FindFrame) {
  const auto source = openFrames(input());
  EXPECT_EQ(source->find(""), 4u);
  EXPECT_EQ(source->find("7"), 7u);
  EXPECT_EQ(source->find(manifest.samples[6].key), 6u);
  EXPECT_EQ(source->find("test"), 8u);
  EXPECT_THAT(messageOf([&] { source->find("train"); }), HasSubstr("part of 6 keys"));
  EXPECT_THAT(messageOf([&] { source->find("9"); }), AllOf(HasSubstr("data"), HasSubstr("0 to 8")));
}

// A map has one point in each voxel that the samples' points are in, and this point is one of them.
TEST_F(Frames, AMapHasOnePointOfEachVoxel) {
  const std::shared_ptr<const FrameSource> samples = openFrames({.path = changed("drive")});
  const std::vector<ViewScan> maps = mapOf(samples, "2")->load(0).scans;
  ASSERT_EQ(maps.size(), 1u);
  const Pose mapFromWorld = inverse(*maps[0].worldFromSensor);
  std::vector<std::pair<Vec3f, float>> points;  // positions in the map, and intensities
  for (std::size_t i = 0; i < samples->keys().size(); ++i) {
    const ViewFrame sample = samples->load(i);
    for (const ViewScan& scan : sample.scans) {
      for (std::size_t k = 0; k < scan.scan.size(); ++k) {
        points.emplace_back(mapFromWorld * (*scan.worldFromSensor * Vec3d(scan.drawnPositions()[k])),
                            scan.scan[kIntensity][k]);
      }
    }
  }
  const auto voxelOf = [](const Vec3f& p, double size) {
    return std::array{std::floor(double{p.x} / size), std::floor(double{p.y} / size), std::floor(double{p.z} / size)};
  };
  for (const std::size_t most : {kMostMapPoints, std::size_t{20}}) {
    const Scan map = mapOf(samples, "0", most)->load(0).scans[0].scan;
    std::set<std::array<double, 3>> occupied, voxels;
    double size = kFinestMapVoxel / 2;
    do {
      size *= 2;
      occupied.clear();
      for (const auto& [position, intensity] : points) occupied.insert(voxelOf(position, size));
    } while (occupied.size() > most);
    for (std::size_t i = 0; i < map.size(); ++i) {
      voxels.insert(voxelOf(map.position[i], size));
      EXPECT_TRUE(std::ranges::any_of(points, [&](const auto& point) {
        return length(point.first - map.position[i]) < 1e-4F && point.second == map[kIntensity][i];
      }));
    }
    EXPECT_EQ(voxels, occupied);
    EXPECT_EQ(map.size(), occupied.size());
    EXPECT_EQ(mapOf(samples, "3", most)->load(0).scans[0].scan.position, map.position);
  }
}

TEST_F(Frames, ThreadsLoadTheSame) {
  const auto source = openFrames(input());
  std::atomic<int> wrong = 0;
  parallelFor(90, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const ViewFrame frame = source->load(i % 9);
      const Scan expected = testScan(manifest.sensors[0].beams, static_cast<std::uint32_t>(i % 9 * 10));
      if (!frame.problems.empty() || frame.scans[0].scan.position != expected.position) ++wrong;
    }
  });
  EXPECT_EQ(wrong, 0);
}

TEST(SceneFrames, HoldNoScans) {
  const std::filesystem::path street = std::filesystem::path(SCANMILL_SOURCE_DIR) / "scenes/street.yaml";
  const auto source = openFrames({.path = street});
  EXPECT_TRUE(source->isScene());
  EXPECT_THAT(source->keys(), ElementsAre("street.yaml"));
  EXPECT_THAT(source->load(0).scans, IsEmpty());
  std::string why;
  EXPECT_EQ(source->scene(0, why), (SceneChoice{street, 1}));
  EXPECT_EQ(openFrames({.path = street, .seed = 7})->scene(0, why), (SceneChoice{street, 7}));
  EXPECT_THAT(messageOf([&] { openFrames({.path = street, .sensor = "top"}); }), HasSubstr("is a scene"));
  EXPECT_THAT(messageOf([&] { openFrames({.path = street.parent_path(), .seed = 7}); }), HasSubstr("is no scene"));
}

TEST(RealFrames, OfRecordedSensors) {
  SKIP_WITHOUT_SHARED_DATA("lidar/ouster_os1_128/frame_1795.pcd");
  const auto file = sharedData() / "lidar/ouster_os1_128/frame_1795.pcd";
  const ViewFrame frame = openFrames({.path = file})->load(0);
  EXPECT_THAT(frame.problems, IsEmpty());
  EXPECT_EQ(frame.scans.at(0).scan.size(), 131072u);
  const ViewFrame reference = openFrames({.path = file, .reference = file})->load(0);
  EXPECT_THAT(reference.problems, IsEmpty());
  for (const float e : reference.scans.at(0).error) ASSERT_TRUE(std::isnan(e) || e == 0);
}

namespace fs = std::filesystem;

class SceneLookup : public testing::Test {
 protected:
  SceneLookup() {
    town = folder.write("scenes/town.yaml", "objects: []\n");
    old = folder.write("old/Old Town.v2.yaml", "objects: []\n");
  }

  static SequenceRecord of(const std::string& sceneFile, bool moving = true) {
    return {"town-s3-drive", "town", sceneFile, 3, "drive", moving, ""};
  }

  TemporaryFolder folder;
  fs::path town;
  fs::path old;
  std::string why;
};

// A path from the folder of the pipeline file, which may be any folder above the dataset or a usual one in it.
TEST_F(SceneLookup, FromTheFoldersAboveTheDataset) {
  const fs::path yard = folder.write("project/pipelines/yard.yaml", "objects: []\n");
  const fs::path data = folder.path() / "project/runs/monday";
  for (const char* scene : {"yard.yaml", "../pipelines/yard.yaml", "pipelines/yard.yaml"}) {
    const SequenceRecord sequence = of(scene);
    EXPECT_EQ(sceneOf(&sequence, data, 0, why), (SceneChoice{yard, 3})) << scene << ": " << why;
  }
}

TEST_F(SceneLookup, AmongTheProgramsOwn) {
  const SequenceRecord sequence = of("scanmill:scenes/street.yaml");
  const auto street = sceneOf(&sequence, folder.path() / "out", 0, why);
  ASSERT_TRUE(street);
  EXPECT_TRUE(fs::equivalent(street->file, fs::path(SCANMILL_SOURCE_DIR) / "scenes/street.yaml"));
}

TEST_F(SceneLookup, SaysWhatIsMissing) {
  const SequenceRecord gone = of("gone.yaml");
  EXPECT_FALSE(sceneOf(&gone, folder.path() / "out", 0, why));
  EXPECT_THAT(why, AllOf(HasSubstr("'gone.yaml'"), HasSubstr("--scene FILE")));
  const SequenceRecord recorded = of("");
  for (const SequenceRecord* sequence : {&recorded, static_cast<const SequenceRecord*>(nullptr)}) {
    EXPECT_FALSE(sceneOf(sequence, folder.path() / "out", 0, why));
    EXPECT_THAT(why, AllOf(HasSubstr("does not say"), HasSubstr("--scene FILE")));
  }
}

// The scene and its seed that the manifest states, whatever the names of scene, trajectory and sample; or the file that
// is given in its place.
TEST_F(SceneLookup, OfFrames) {
  const fs::path data = folder.path() / "out";
  const auto write = [&](const fs::path& at, bool moving) {
    writeChangedDataset(at, {.manifest = [&](Manifest& m) {
                          m.sequences = {of("scenes/town.yaml", moving)};
                          m.sequences.front().seed = 12;
                          m.sequences.front().vehicle = "scanmill:scenes/vehicle.yaml";
                        }});
  };
  write(data, true);
  EXPECT_EQ(openFrames({.path = data})->scene(1, why), (SceneChoice{town, 12, 0.1}));
  EXPECT_EQ(openFrames({.path = data, .scene = old})->scene(1, why), (SceneChoice{old, 12, 0.1}));
  EXPECT_EQ(openFrames({.path = data, .scene = old, .seed = 5})->scene(1, why), (SceneChoice{old, 5, 0.1}));
  EXPECT_EQ(openFrames({.path = data})->vehicle(), fs::path(SCANMILL_SOURCE_DIR) / "scenes/vehicle.yaml");
  const fs::path shard = data / "train/train-000000.tar";
  EXPECT_EQ(openFrames({.path = shard})->scene(1, why), (SceneChoice{town, 12, 0.1}));
  fs::copy(shard, folder.path() / "lonely.tar");
  EXPECT_FALSE(openFrames({.path = folder.path() / "lonely.tar"})->scene(1, why));
  EXPECT_THAT(why, HasSubstr("--scene FILE"));
  write(folder.path() / "still", false);
  EXPECT_EQ(openFrames({.path = folder.path() / "still"})->scene(1, why), (SceneChoice{town, 12, 0}));
}

}  // namespace
}  // namespace scanmill
