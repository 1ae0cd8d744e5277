#include <fmt/format.h>

#include <set>
#include <vector>

#include "assets/asset.h"
#include "formats/cloud_file.h"
#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A reader from "LAS Specification 1.4 - R15" with Python's struct and nothing of ours.
const std::string kLasReader = R"(
class Las:
    def __init__(self, path):
        b = path.read_bytes()
        assert b[:4] == b'LASF' and struct.unpack_from('<BB', b, 24) == (1, 4)
        self.encoding = struct.unpack_from('<H', b, 6)[0]
        self.system, self.software = (b[at:at + 32].rstrip(b'\0').decode() for at in (26, 58))
        self.day, self.year, size, first, records, form, step = struct.unpack_from('<HHHIIBH', b, 90)
        assert size == 375 and form == 6
        assert b[107:131] == bytes(24)                      # counts of earlier versions
        self.scale = np.array(struct.unpack_from('<3d', b, 131))
        self.offset = np.array(struct.unpack_from('<3d', b, 155))
        box = struct.unpack_from('<6d', b, 179)
        self.high, self.low = np.array(box[0::2]), np.array(box[1::2])
        assert struct.unpack_from('<QQI', b, 227) == (0, 0, 0)
        self.count = struct.unpack_from('<Q', b, 247)[0]
        self.by_return = list(struct.unpack_from('<15Q', b, 255))
        self.records, at = {}, size
        for _ in range(records):
            reserved, user, number, length, _text = struct.unpack_from('<H16sHH32s', b, at)
            assert reserved == 0
            self.records[user.rstrip(b'\0').decode(), number] = b[at + 54:at + 54 + length]
            at += 54 + length
        assert at == first                                   # no gap before the points
        fields = [('place', '<i4', 3), ('intensity', '<u2'), ('returns', 'u1'), ('flags', 'u1'), ('class', 'u1'),
                  ('user', 'u1'), ('angle', '<i2'), ('source', '<u2'), ('time', '<f8')]
        types = ['', 'u1', 'i1', '<u2', '<i2', '<u4', '<i4', '<u8', '<i8', '<f4', '<f8']
        self.extra, self.units = {}, {}
        extra = self.records.get(('LASF_Spec', 4), b'')
        assert len(extra) % 192 == 0
        for k in range(0, len(extra), 192):
            kind, options = struct.unpack_from('<BB', extra, k + 2)
            assert extra[k:k + 2] == bytes(2) and options == 0 and extra[k + 36:k + 160] == bytes(124)
            name = extra[k + 4:k + 36].rstrip(b'\0').decode()
            self.extra[name] = types[kind]
            self.units[name] = extra[k + 160:k + 192].rstrip(b'\0').decode()
            fields.append((name + '+', types[kind]))
        kind = np.dtype(fields)
        assert kind.itemsize == step and len(b) == first + step * self.count
        self.points = np.frombuffer(b, kind, offset=first)
        self.xyz = self.points['place'] * self.scale + self.offset
        self.number, self.all = self.points['returns'] & 15, self.points['returns'] >> 4
    def __getitem__(self, name):
        return self.points[name]
)";

class LasLayout : public ExportWorld {
 protected:
  LasLayout() : ExportWorld(makeLas()) {}

  // Returns what Python finds in the file of the first sequence's first sensor.
  std::string las(const std::string& code) const {
    return python(kLasReader + "las = Las(folder / 'train/street-s1-lane.top.las')\n" + code);
  }
  // Writes a sequence of this sample alone.
  void writeSample(const ExportSample& sample) {
    plan_.sequences[sample.sequence].samples = {
        static_cast<std::size_t>(sample.record - plan_.manifest.samples.data())};
    ExportWorld::writeSample(sample);
  }
  void expect(const std::vector<Vec3d>& places) const {
    folder_.write("places.bin", {reinterpret_cast<const char*>(places.data()), places.size() * sizeof(Vec3d)});
  }
};

TEST_F(LasLayout, HeaderAndRecordsAreTheSpecifications) {
  write(*layout_);
  EXPECT_THAT(las(R"(
assert las.encoding == 1 << 4 | 1 << 3, las.encoding        # WKT; the scan has no numbers of returns
assert las.system == 'SIMULATION' and las.software.startswith('scanmill ')
assert 1 <= las.day <= 366 and las.year == 2000
assert (las.scale == 0.0005).all() and (las.offset == [101, 20, 2]).all(), las.offset
assert las.count == 616 and las.by_return == [616] + [0] * 14 # of both frames
assert (las.low == las.xyz.min(axis=0)).all() and (las.high == las.xyz.max(axis=0)).all()
wkt = las.records['LASF_Projection', 2112]
assert wkt.startswith(b'LOCAL_CS["scanmill world",') and wkt.endswith(b']\0') and wkt.count(b'\0') == 1
names = las.records['LASF_Spec', 0]
assert len(names) == 256 * 16 and [names[k] for k in range(0, 4096, 16)] == list(range(256))
names = {names[k]: names[k + 1:k + 16].rstrip(b'\0').decode() for k in range(0, 4096, 16)}
for c in set(las['class']): print(c, names[c])
assert names[255] == ''
assert las.extra == {'intensity_f': '<f4', 'instance': '<u4', 'ring': '<u2', 'column': '<u2', 'range_true': '<f4'}
assert las.units['range_true'] == 'unit: m' and las.units['ring'] == ''
)"),
              AllOf(HasSubstr(fmt::format("{} car\n", classId("car"))),
                    HasSubstr(fmt::format("{} pedestrian\n", classId("pedestrian"))),
                    HasSubstr(fmt::format("{} building\n", classId("building")))));
}

TEST_F(LasLayout, PointsStandInTheWorldWithAllTheirColumns) {
  useBothSensors();
  write(*layout_);
  std::vector<Vec3d> places;  // and the sensor's positions
  for (const int frame : {0, 1}) {
    const Pose worldFromSensor = vehicle(frame) * *plan_.sensors[1]->vehicleFromSensor;
    for (const Vec3f& p : scan(1, static_cast<std::size_t>(frame)).position) {
      places.push_back(worldFromSensor * Vec3d(p));
      places.push_back(worldFromSensor.translation);
    }
  }
  expect(places);
  python(kLasReader + R"(
las = Las(folder / 'val/street-s2-lane.rear.las')
places, sensor = np.fromfile(folder / 'places.bin').reshape(-1, 2, 3).swapaxes(0, 1)
assert np.abs(las.xyz - places).max() <= 0.00025 + 1e-9
ray = places - sensor
right = ray @ [np.sin(0.2), -np.cos(0.2), 0]                 # of the vehicle, which is turned to the left by 0.2 rad
wrong = las['angle'] * 0.006 - np.degrees(np.arctan2(right, -ray[:, 2]))
assert np.abs((wrong + 180) % 360 - 180).max() <= 0.0031
i = np.tile([i for i in range(360) if i % 7], 2)
assert (las['ring+'] == i // 90).all() and (las['column+'] == i % 90).all()
assert (las['instance+'] == np.select([i % 5 == 1, i % 5 == 2], [7, 9], 0)).all()
assert len(set(zip(las['instance+'], las['class']))) == 3
intensity = (i / 360).astype(np.float32)
assert (las['intensity_f+'] == intensity).all()
assert np.abs(las['intensity'] / 65535 - intensity).max() < 1e-5
assert (las['range_true+'] == (np.repeat([11, 12], 308) + 0.01 * i).astype(np.float32)).all()
assert np.abs(las['time'] - (np.repeat([0, 0.1], 308) + i % 90 * 0.1 / 90)).max() < 1e-8
assert (las['source'] == 4).all() and (las['flags'] == 1).all()
assert not las['user'].any()
assert (Las(folder / 'val/street-s2-lane.top.las')['source'] == 3).all()
)");
}

// Two cars of an export are two things where the file is an object of a scene.
TEST_F(LasLayout, InstancesComeBackToAScene) {
  write(*layout_);
  AssetOptions options;
  for (const SemanticClass& c : plan_.manifest.ontology.classes) options.points.labels[c.id] = c.name;
  const Asset asset = readAsset(folder_.path() / "train/street-s1-lane.top.las", options);
  std::set<std::pair<std::string, std::string>> found;
  for (const AssetPart& part : asset.parts) found.emplace(part.node, part.ownClass);
  EXPECT_THAT(found, testing::UnorderedElementsAre(std::pair{"instance 7", "car"},
                                                   std::pair{"instance 9", "pedestrian"}, std::pair{"", "building"}));
  const Cloud cloud = readCloud(folder_.path() / "train/street-s1-lane.top.las");
  EXPECT_EQ(cloud.classNames.at(classId("car")), "car") << "the file names its classes";
}

// The sensor drives 3 m and turns by 0.2 rad while it scans points of a helix; what it reports is in its own frame at
// the time of each column.
class MovingLas : public LasLayout {
 protected:
  MovingLas() {
    plan_.manifest.samples[0].scans[0].worldFromSensor = {poseAt(0), poseAt(1)};
    sample_ = sample(0, 0);
  }

  static Pose poseAt(double share) {
    return {fromYawPitchRoll(0.2 * share, 0, 0), {50 + 3 * share, -7 + 0.5 * share, 2}};
  }

  // `shareOf(column)`: how much of the way the sensor has come.
  template <class ShareOf>
  void place(const ShareOf& shareOf) {
    std::vector<Vec3d> places;
    Scan& scan = sample_.scans[0].scan;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const auto column = columns_[i];
      const double turn = radians(4.0 * column);
      places.push_back({50 + 20 * std::cos(turn), 20 * std::sin(turn), 0.01 * static_cast<double>(i)});
      scan.position[i] = Vec3f(inverse(poseAt(shareOf(column))) * places[i]);
    }
    expect(places);
  }

  void check() {
    writeSample(sample_);
    las("places = np.fromfile(folder / 'places.bin').reshape(-1, 3)\n"
        "assert np.abs(las.xyz - places).max() < 0.00026, np.abs(las.xyz - places).max()\n");
  }

  ExportSample sample_;
  const std::vector<std::uint16_t> columns_ = scan(0, 0)[kColumn];
};

TEST_F(MovingLas, PointsAreWhereTheyWereMet) {
  place([](int column) { return column / 89.0; });
  check();
  sample_.scans[0].scan[kColumn].clear();  // then the time tells how far the sensor has come
  check();
}

TEST_F(MovingLas, PointsOfColumnsThatFireUnevenlyToo) {
  auto listed = std::make_shared<ListedBeams>();
  for (int beam = 0; beam < 360; ++beam) listed->time.push_back(0.1 * (beam % 90) * (beam % 90) / 8100);
  plan_.manifest.sensors[0].beams.pattern = listed;
  place([](int column) { return column * column / 7921.0; });
  check();
}

TEST_F(MovingLas, PointsOfADeskewedScanAreInTheFrameOfTheStart) {
  plan_.manifest.deskewed = true;
  place([](int) { return 0.0; });
  check();
}

TEST_F(LasLayout, ReturnsAreTheColumnsOrAreCounted) {
  ExportSample sample = this->sample(0, 0);
  Scan& scan = sample.scans[0].scan;
  // Of one column: three returns of ring 0, one of ring 1, two of ring 2.
  const std::vector<std::uint16_t> rings{0, 0, 0, 1, 2, 2};
  scan = Scan();
  scan.rings = 4;
  scan.columns = 90;
  for (const std::uint16_t ring : rings) {
    scan.position.push_back({10, 1.0f * static_cast<float>(scan.size()), 0});
    scan[kRing].push_back(ring);
    scan[kColumn].push_back(3);
  }
  writeSample(sample);
  las("assert las.number.tolist() == [1, 2, 3, 1, 1, 2] and las.all.tolist() == [3, 3, 3, 1, 2, 2]\n"
      "assert las.by_return == [3, 2, 1] + [0] * 12 and las.encoding & 8\n");

  // Of five returns of a beam the scan has kept some; LAS counts to 15.
  scan[kReturn] = {1, 3, 5, 1, 2, 18};
  scan[ColumnKey<columnIndex("returns")>()] = {5, 5, 5, 1, 2, 20};
  writeSample(sample);
  las("assert las.number.tolist() == [1, 3, 5, 1, 2, 15] and las.all.tolist() == [5, 5, 5, 1, 2, 15]\n"
      "assert las.by_return == [2, 1, 1, 0, 1] + [0] * 9 + [1] and not las.encoding & 8\n"
      "assert set(las.extra) == {'ring', 'column'}\n");
}

// The layout withholds points that come from no surface, as noise, and keeps the dataset's own classes beside others.
TEST_F(LasLayout, FalsePositivesAreWithheldAsNoise) {
  use("asprs");
  ExportSample sample = this->sample(0, 0);
  Scan& scan = sample.scans[0].scan;
  scan[kCause].assign(scan.size(), 1);
  scan[kCause][7] = 2;
  scan[kLabel][7] = 0;
  writeSample(sample);
  las(fmt::format(R"(
assert las['flags'].tolist() == [1] * 7 + [5] + [1] * 300 and las['class'][7] == 7
assert set(las['class']) == {{1, 6, 7}}                      # cars and pedestrians have no class of their own
assert set(las['dataset_label+']) == {{0, {}, {}, {}}}
)",
                  classId("car"), classId("pedestrian"), classId("building")));
}

TEST_F(LasLayout, MissesAreLeftOutAndSecondPlanesAreSecondReturns) {
  ExportSample sample = this->sample(0, 0, true);
  Scan& scan = sample.scans[0].scan;
  const float none = std::numeric_limits<float>::quiet_NaN();
  scan.planes = 2;
  scan.position.resize(720, {none, none, none});
  scan.position[360 + 95] = {30, 0, 0};
  visitTable(scan, [](auto, auto& values) {
    if (!values.empty()) values.resize(720);
  });
  writeSample(sample);
  las(R"(
assert las.count == 357 and np.isfinite(las.xyz).all()
assert las.number[-1] == 2 and las.all[-1] == 2 and (las.number[:-1] == 1).all()
assert (las.all == 2).sum() == 2 and las.by_return[:2] == [356, 1]
)");
}

TEST_F(LasLayout, IntensitiesBeyondTheRangeAreCut) {
  ExportSample sample = this->sample(0, 0);
  std::vector<float>& intensity = sample.scans[0].scan[kIntensity];
  intensity[0] = -0.5f;
  intensity[1] = 1.25f;
  intensity[2] = std::numeric_limits<float>::quiet_NaN();
  intensity[3] = 1;
  writeSample(sample);
  las("assert las['intensity'][:4].tolist() == [0, 65535, 0, 65535] and las['intensity_f+'][1] == 1.25\n");
}

TEST_F(LasLayout, ClassesBeyondAByteAreRefusedWhereThereArePointsOfThem) {
  Ontology large = plan_.manifest.ontology;
  for (SemanticClass& c : large.classes) {
    if (c.name == "car") c.id = 300;
  }
  plan_.classes = ClassMap(plan_.manifest.ontology, large);
  plan_.manifest.samples[3].scans[0].pointsPerClass = {{classId("building"), 5}};
  plan_.manifest.samples[3].scans[1].pointsPerClass = {{classId("car"), 5}};
  EXPECT_NO_THROW(layout_->check(plan_)) << "of a sensor that is not exported";
  plan_.manifest.samples[3].scans[0].pointsPerClass[classId("car")] = 2;
  expectInputError([&] { layout_->check(plan_); }, {"street-s2-lane-000001", "car", "300", "255", "--classes"});
}

TEST_F(LasLayout, PointsThatNoStepsReachAreRefused) {
  ExportSample sample = this->sample(0, 1);
  sample.scans[0].scan.position[3].x = 1e7f;
  expectInputError([&] { writeSample(sample); }, {"street-s1-lane-000001", "'top'", "1000 km"});
}

}  // namespace
}  // namespace scanmill
