#include <fmt/format.h>

#include <array>

#include "formats/cloud_file.h"
#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A reader of a binary PLY of one element, with numpy and nothing of ours.
const std::string kPlyReader = R"(
class Ply:
    def __init__(self, path):
        head, body = path.read_bytes().split(b'end_header\n', 1)
        lines = head.decode().splitlines()
        assert lines[:2] == ['ply', 'format binary_little_endian 1.0']
        self.comments = [line[8:] for line in lines if line.startswith('comment ')]
        words = [line.split() for line in lines[2:] if not line.startswith('comment ')]
        assert words[0][:2] == ['element', 'vertex'] and {w[0] for w in words[1:]} == {'property'}
        names = {'float': '<f4', 'uchar': 'u1', 'uint16': '<u2', 'uint': '<u4'}
        self.kind = np.dtype([(name, names[kind]) for _, kind, name in words[1:]])
        assert len(body) == int(words[0][2]) * self.kind.itemsize
        self.points = np.frombuffer(body, self.kind)
        self.xyz = np.stack([self.points[axis] for axis in 'xyz'], axis=1)
        self.colors = np.stack([self.points[part] for part in ('red', 'green', 'blue')], axis=1)
    def __getitem__(self, name):
        return self.points[name]
)";

class PlyLayout : public ExportWorld {
 protected:
  PlyLayout() : ExportWorld(makePly()) {}

  // Of what Python finds in the file of the first sample's first sensor.
  std::string ply(const std::string& code) const {
    return python(kPlyReader + "ply = Ply(folder / 'train/street-s1-lane-000000.top.ply')\n" + code);
  }
};

TEST_F(PlyLayout, PointsHaveAllColumnsAndTheColoursOfTheirClasses) {
  useBothSensors();
  write(*layout_);
  std::string classes = "colors = {";
  for (const char* name : {"car", "pedestrian", "building"}) {
    const SemanticClass& c = plan_.manifest.ontology.require(name, {});
    classes += fmt::format("{}: ({}, {}, {}), ", c.id, c.color[0], c.color[1], c.color[2]);
  }
  python(kPlyReader + classes + R"(}
ply = Ply(folder / 'val/street-s2-lane-000001.rear.ply')
assert ply.kind.names == ('x', 'y', 'z', 'red', 'green', 'blue', 'intensity', 'label', 'instance', 'ring', 'column',
                          'time', 'range_true')
assert [ply.kind[n].str for n in ply.kind.names[6:]] == ['<f4', '<u2', '<u4', '<u2', '<u2', '<f4', '<f4']
i = np.array([i for i in range(360) if i % 7])
distance = 12 + 0.01 * i
angle = np.radians(4 * (i % 90)) - np.pi
want = np.stack([distance * np.cos(angle), distance * np.sin(angle), 0.1 * (i // 90)], axis=1)
assert np.abs(ply.xyz - want).max() < 1e-6
assert (ply['ring'] == i // 90).all() and (ply['column'] == i % 90).all()
assert (ply['instance'] == np.select([i % 5 == 1, i % 5 == 2], [7, 9], 0)).all()
assert (ply['intensity'] == (i / 360).astype(np.float32)).all()
assert set(ply['label']) == set(colors) and len(colors) == 3
for id, color in colors.items():
    assert (ply.colors[ply['label'] == id] == color).all()
)");
}

TEST_F(PlyLayout, CommentsTellWhatTheScanIs) {
  plan_.manifest.name = "two\nlines";
  write(*layout_);
  EXPECT_THAT(ply("print('\\n'.join(ply.comments))"),
              AllOf(HasSubstr("dataset two lines\nsample street-s1-lane-000000\nsensor top\ntime 0\nframe sensor"),
                    HasSubstr(fmt::format("\nclass {} car\n", classId("car"))), HasSubstr("\nclass 0 unlabeled\n")));
  const Pose& pose = plan_.manifest.samples[0].scans[0].worldFromSensor.front();
  const Vec3d moved = pose * Vec3d{1, 2, 3};
  ply(fmt::format("moved = [{}, {}, {}]", moved.x, moved.y, moved.z) + R"(
words = [c.split() for c in ply.comments if c.startswith('world_from_sensor')]
assert len(words) == 1 and words[0][1] == 'quaternion_wxyz' and words[0][6] == 'translation'
w, x, y, z = map(float, words[0][2:6])
v = np.array([1.0, 2, 3])
u = np.array([x, y, z])
turned = 2 * u.dot(v) * u + (w * w - u.dot(u)) * v + 2 * w * np.cross(u, v)    # of a unit quaternion
assert np.abs(turned + list(map(float, words[0][7:])) - moved).max() < 1e-9
)");
}

TEST_F(PlyLayout, WithoutClassesPointsAreGreyByTheirIntensity) {
  ExportSample sample = this->sample(0, 0);
  Scan& scan = sample.scans[0].scan;
  scan[kLabel].clear();
  const std::array<float, 5> intensity{-1, 0.5f, 1, 7, std::numeric_limits<float>::quiet_NaN()};
  std::copy(intensity.begin(), intensity.end(), scan[kIntensity].begin());
  writeSample(sample);
  ply(R"(
assert ply.colors[:5, 0].tolist() == [0, 128, 255, 255, 0]
assert (ply.colors == ply.colors[:, :1]).all() and 'label' not in ply.kind.names
)");
  scan[kIntensity].clear();
  writeSample(sample);
  ply("assert (ply.colors == 128).all() and 'intensity' not in ply.kind.names\n");
}

TEST_F(PlyLayout, ScansWithoutPointsHaveTheDatasetsColumns) {
  ExportSample sample = this->sample(0, 0);
  Scan& scan = sample.scans[0].scan;
  scan.position.clear();
  visitTable(scan, [](auto, auto& values) { values.clear(); });
  writeSample(sample);
  ply("assert len(ply.points) == 0 and 'label' in ply.kind.names\n");
}

}  // namespace
}  // namespace scanmill
