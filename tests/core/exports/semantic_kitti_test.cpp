#include <fmt/core.h>

#include <cstring>
#include <set>

#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class SemanticKittiLayout : public ExportWorld {
 protected:
  SemanticKittiLayout() : ExportWorld(makeSemanticKitti(), "semantic_kitti") {}
};

// Read as its API does: numpy.fromfile, 16 bits each of class and instance.
TEST_F(SemanticKittiLayout, PointsAndLabelsAreThoseOfTheScan) {
  write(*layout_);
  const std::string printed = python(R"(
total = 0
for sequence in ['00', '08']:
    for frame in range(2):
        at = folder / 'sequences' / sequence
        points = np.fromfile(at / 'velodyne' / ('%06d.bin' % frame), dtype=np.float32).reshape(-1, 4)
        label = np.fromfile(at / 'labels' / ('%06d.label' % frame), dtype=np.uint32)
        assert len(points) == len(label) == 308, len(points)
        semantic, instance = label & 0xFFFF, label >> 16
        assert set(semantic) == {50, 252, 30}, set(semantic)   # building, moving car, person
        assert set(instance[semantic == 252]) == {7} and set(instance[semantic == 30]) == {9}
        assert set(instance[semantic == 50]) == {0}
        assert points[:, 3].min() >= 0 and points[:, 3].max() <= 1
        total += len(points)
print(total)
)");
  EXPECT_THAT(printed, HasSubstr("1232"));
}

// As in KITTI's own files: ring after ring from the top, each from straight ahead over the left round to there.
TEST_F(SemanticKittiLayout, PointsFollowOneAnotherAsInKittisFiles) {
  write(*layout_);
  const Scan own = scan(0, 1);
  const std::string bytes = readFile(folder_.path() / "sequences/08/velodyne/000001.bin");
  const std::string labels = readFile(folder_.path() / "sequences/08/labels/000001.label");
  ASSERT_EQ(bytes.size(), own.size() * 16);
  std::set<std::size_t> seen;
  std::pair<int, double> before{-1, 0};
  for (std::size_t i = 0; i < own.size(); ++i) {
    float values[4];
    std::uint32_t label = 0;
    std::memcpy(values, bytes.data() + i * 16, 16);
    std::memcpy(&label, labels.data() + i * 4, 4);
    const auto found = std::find(own.position.begin(), own.position.end(), Vec3f{values[0], values[1], values[2]});
    ASSERT_NE(found, own.position.end());
    const auto at = static_cast<std::size_t>(found - own.position.begin());
    ASSERT_TRUE(seen.insert(at).second);
    ASSERT_EQ(values[3], own[kIntensity][at]);
    ASSERT_EQ(label >> 16, own[kInstance][at]);
    const double azimuth = std::atan2(values[1], values[0]);
    const std::pair<int, double> place{3 - own[kRing][at], azimuth < 0 ? azimuth + 2 * kPi : azimuth};
    ASSERT_LE(before, place);  // ring 0 is the lowest
    before = place;
  }
}

// As the API's auxiliary/laserscan tools do: pose of the lidar = Tr^-1 * pose * Tr.
TEST_F(SemanticKittiLayout, PosesAreTheSensorsOwn) {
  write(*layout_);
  const Pose moved =
      inverse(vehicle(0) * *plan_.sensors[0]->vehicleFromSensor) * vehicle(1) * *plan_.sensors[0]->vehicleFromSensor;
  const Mat3 r = toMatrix(moved.rotation);
  const Vec3d& t = moved.translation;
  python(fmt::format(R"(
def matrix(numbers):
    m = np.eye(4)
    m[:3] = np.array(numbers, dtype=float).reshape(3, 4)
    return m
at = folder / 'sequences' / '00'
calibration = dict(line.split(':') for line in (at / 'calib.txt').read_text().splitlines())
assert sorted(calibration) == ['P0', 'P1', 'P2', 'P3', 'Tr']
tr = matrix(calibration['Tr'].split())
assert np.allclose(tr @ [1, 2, 3, 1], [-2, -3, 1, 1]), tr     # forward is the camera's z, left its -x, up its -y
lines = (at / 'poses.txt').read_text().splitlines()
assert len(lines) == 2
poses = [np.linalg.inv(tr) @ matrix(line.split()) @ tr for line in lines]
assert np.allclose(poses[0], np.eye(4))
wanted = matrix([{}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}])
assert np.allclose(poses[1], wanted, atol=1e-8), poses[1] - wanted
assert np.allclose([float(x) for x in (at / 'times.txt').read_text().split()], [0, 0.1])
)",
                     r.x.x, r.y.x, r.z.x, t.x, r.x.y, r.y.y, r.z.y, t.y, r.x.z, r.y.z, r.z.z, t.z));
}

TEST_F(SemanticKittiLayout, MissesAreLeftOutAndWithoutAListNothingMoves) {
  withObjects_ = false;
  EXPECT_THAT(write(*layout_, true), testing::ElementsAre(HasSubstr("objects: true")));
  python(R"(
label = np.fromfile(folder / 'sequences/00/labels/000000.label', dtype=np.uint32)
points = np.fromfile(folder / 'sequences/00/velodyne/000000.bin', dtype=np.float32)
assert len(label) * 4 == len(points) == 356 * 4 and np.isfinite(points).all()
assert set(label & 0xFFFF) == {50, 10, 30}
)");
}

TEST_F(SemanticKittiLayout, TheConfigurationNamesClassesAndSplits) {
  write(*layout_);
  const std::string text = readFile(folder_.path() / "semantic-kitti.yaml");
  EXPECT_THAT(text, HasSubstr("  252: \"moving-car\"\n"));
  EXPECT_THAT(text, HasSubstr("  train:\n    - 0\n"));
  EXPECT_THAT(text, HasSubstr("  valid:\n    - 8\n"));
  EXPECT_THAT(text, HasSubstr("  test: []\n"));
  EXPECT_THAT(text, HasSubstr("  10: [245, 150, 100]\n")) << "blue, green, red";
  const auto trained = [&](int id) {
    const std::size_t map = text.find("learning_map:");
    const std::size_t line = text.find(fmt::format("\n  {}: ", id), map);
    return text.substr(text.find(": ", line) + 2, 3);
  };
  EXPECT_EQ(trained(10), trained(252));
  EXPECT_EQ(trained(16).substr(0, 2), "0\n") << "nothing becomes a thing on rails";
}

// Sequences beyond SemanticKITTI's own number of a split go on behind the last of all.
TEST_F(SemanticKittiLayout, NumbersAreThoseOfTheSplitsThatProgramsKnow) {
  const ExportSequence some = plan_.sequences[0];
  plan_.sequences.clear();
  for (int i = 0; i < 11; ++i) plan_.sequences.push_back(some);
  for (const char* split : {"val", "test", "val", "night"}) {
    plan_.sequences.push_back(some);
    plan_.sequences.back().split = split;
  }
  layout_->finish(plan_, {}, ExportFolder(folder_.path()));
  std::string listed = readFile(folder_.path() / "semantic-kitti.yaml");
  listed.erase(0, listed.find("split:"));
  std::erase(listed, '\n');
  EXPECT_EQ(listed,
            "split:  night:    - 24  test:    - 11"
            "  train:    - 0    - 1    - 2    - 3    - 4    - 5    - 6    - 7    - 9    - 10    - 22"
            "  valid:    - 8    - 23");
  plan_.sequences.assign(100, some);
  layout_->finish(plan_, {}, ExportFolder(folder_.path()));
  const auto files = written();
  EXPECT_EQ(std::ranges::count_if(files, [](const auto& file) { return file.first.ends_with("/poses.txt"); }), 100);
}

// Remissions are parts of 1, whatever the sensor calls full.
TEST_F(SemanticKittiLayout, BytesOfIntensityBecomeParts) {
  plan_.manifest.sensors[0].intensityFullScale = 255;
  writeChanged(*layout_, 0, 0, [](ExportSample& own) {
    for (float& value : own.scans[0].scan[kIntensity]) value = 51;
  });
  python(R"(
points = np.fromfile(folder / 'sequences/00/velodyne/000000.bin', dtype=np.float32).reshape(-1, 4)
assert (points[:, 3] == np.float32(0.2)).all()
)");
}

// A sequence with an id that does not fit into 15 bits is numbered from 1, in the order of the ids: 9 and 40007.
TEST_F(SemanticKittiLayout, IdsThatDoNotFitAreNumberedAnew) {
  const auto large = [](ExportSample& own) {
    for (std::uint32_t& id : own.scans[0].scan[kInstance]) id = id == 7 ? 40007 : id;
  };
  EXPECT_TRUE(layout_->checksSamples(plan_));
  for (const std::size_t frame : {0, 1}) writeChanged(*layout_, 0, frame, large);
  python(R"(
for frame in range(2):
    label = np.fromfile(folder / f'sequences/00/labels/{frame:06}.label', dtype=np.uint32)
    semantic, instance = label & 0xFFFF, label >> 16
    assert set(instance[semantic == 10]) == {2} and set(instance[semantic == 30]) == {1}, set(instance)
    assert set(instance[semantic == 50]) == {0}
)");
  EXPECT_THAT(layout_->finish(plan_, {}, ExportFolder(folder_.path())),
              testing::Contains(HasSubstr("new numbers from 1 in 1 of 2 sequences")));
}

TEST_F(SemanticKittiLayout, MoreSequencesThanNumbersAreRefused) {
  plan_.sequences.resize(101, plan_.sequences[0]);
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }), HasSubstr("101 sequences"));
}

}  // namespace
}  // namespace scanmill
