#include <fmt/core.h>

#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class KittiLayout : public ExportWorld {
 protected:
  KittiLayout() : ExportWorld(makeKitti(), "kitti") {
    for (SampleRecord& sample : plan_.manifest.samples) sample.objects.emplace();
  }
};

// As loaders read them: the corners of each box, rotated about the camera's y and carried back by the calibration, are
// those of the object.
TEST_F(KittiLayout, BoxesComeBackThroughTheCalibration) {
  // Ahead of the sensor, as the image sees them.
  write(*layout_);
  std::string wanted;
  const SampleObjects all = objects(0, 1);
  for (const ObjectRecord& object : all.objects) {
    for (int k = 0; k < 8; ++k) {
      const Vec3d p = object.views[0].sensorFromBox * Vec3d{(k & 1 ? 0.5 : -0.5) * object.size.x,
                                                            (k & 2 ? 0.5 : -0.5) * object.size.y,
                                                            (k & 4 ? 0.5 : -0.5) * object.size.z};
      wanted += fmt::format("[{}, {}, {}], ", p.x, p.y, p.z);
    }
  }
  python("wanted = np.array([" + wanted + "]).reshape(-1, 8, 3)\n" + R"(
calibration = {}
for line in (folder / 'training/calib/000001.txt').read_text().splitlines():
    name, numbers = line.split(':')
    calibration[name] = np.array(numbers.split(), dtype=float)
assert [len(calibration[k]) for k in ('P0', 'P1', 'P2', 'P3', 'R0_rect', 'Tr_velo_to_cam', 'Tr_imu_to_velo')] == [12] * 4 + [9, 12, 12]
camera = np.eye(4); camera[:3] = calibration['Tr_velo_to_cam'].reshape(3, 4)
lines = (folder / 'training/label_2/000001.txt').read_text().splitlines()
assert [line.split()[0] for line in lines] == ['Car', 'Pedestrian'], lines
for line, corners in zip(lines, wanted):
    f = [float(x) for x in line.split()[1:]]
    assert len(f) == 14
    truncated, occluded, alpha = f[:3]
    box, (h, w, l), (x, y, z), ry = f[3:7], f[7:10], f[10:13], f[13]
    c, s = np.cos(ry), np.sin(ry)
    own = np.array([[c * a * l / 2 + s * b * w / 2 + x, y - e * h, -s * a * l / 2 + c * b * w / 2 + z]
                    for a in (-1, 1) for b in (-1, 1) for e in (0, 1)])
    back = (np.linalg.inv(camera) @ np.c_[own, np.ones(8)].T).T[:, :3]
    apart = np.linalg.norm(back[:, None] - corners[None], axis=2).min(axis=1)
    assert apart.max() < 0.03, apart                        # two decimals, and the sensor is level
    assert 0 <= truncated <= 1 and occluded == 1            # 60 and 72 of 100 beams
    assert abs(np.remainder(ry - np.arctan2(x, z) - alpha + np.pi, 2 * np.pi) - np.pi) < 0.02
    p2 = calibration['P2'].reshape(3, 4)
    uv = (p2 @ np.c_[own, np.ones(8)].T).T
    uv = uv[:, :2] / uv[:, 2:]
    seen = np.clip(uv, 0, [1241, 374])
    assert np.abs(np.r_[seen.min(0), seen.max(0)] - box).max() < 3, (seen, box)
)");
}

TEST_F(KittiLayout, FramesAreNumberedThroughTheSplits) {
  plan_.sequences[1].split = "test";
  write(*layout_);
  const auto set = [&](const char* name) {
    return readFile(folder_.path() / "ImageSets" / (std::string(name) + ".txt"));
  };
  EXPECT_EQ(set("train"), "000000\n000001\n");
  EXPECT_EQ(set("test"), "000000\n000001\n");
  EXPECT_EQ(set("val"), "");
  EXPECT_EQ(set("trainval"), set("train"));
  const std::string png = readFile(folder_.path() / "testing/image_2/000001.png");
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_LT(png.size(), 20000u);
  EXPECT_EQ(readFile(folder_.path() / "training/velodyne/000001.bin").size(), scan(0, 1).size() * 16);
}

TEST_F(KittiLayout, WhatIsBehindOrUnseenIsNotListed) {
  writeChanged(*layout_, 0, 0, [](ExportSample& own) {
    own.objects->objects[0].views[0].sensorFromBox.translation.x *= -1;  // the car, behind
    own.objects->objects[1].views[0].points = 0;
  });
  EXPECT_EQ(readFile(folder_.path() / "training/label_2/000000.txt"),
            "DontCare -1 -1 -10 0.00 0.00 1.00 1.00 -1 -1 -1 -1000 -1000 -1000 -10\n")
      << "OpenPCDet stops at an empty file";
}

// Points of a moving sensor cannot be placed by one pose unless they are deskewed.
TEST_F(KittiLayout, PointsThatAreNotDeskewedAreToldOf) {
  std::vector<Pose>& poses = plan_.manifest.samples[1].scans[0].worldFromSensor;
  poses.push_back(poses.front());
  EXPECT_THAT(write(*layout_), testing::ElementsAre(HasSubstr("deskew: true")));
  plan_.manifest.deskewed = true;
  EXPECT_THAT(write(*layout_), testing::IsEmpty());
}

// Of the boxes with points, how many are not listed is told.
TEST_F(KittiLayout, WhatTheImageLeavesOutIsCounted) {
  EXPECT_THAT(write(*layout_), testing::IsEmpty());
  const ReadObjects read = [&](std::size_t s, std::size_t f) {
    SampleObjects own = objects(s, f);
    if (s == 1) own.objects[0].views[0].sensorFromBox.translation.x *= -1;  // two frames
    if (f == 1) own.objects[1].views[0].points = 0;                         // of each sequence one
    return std::optional(own);
  };
  EXPECT_THAT(layout_->finish(plan_, read, ExportFolder(folder_.path())),
              testing::ElementsAre(HasSubstr("2 of 6 boxes")));
}

// A box through which the image's plane passes has a finite box in the image, and is truncated.
TEST_F(KittiLayout, WhatReachesBehindTheCameraIsCut) {
  writeChanged(*layout_, 0, 0, [](ExportSample& own) {
    own.objects->objects.resize(1);
    own.objects->objects[0].views[0].sensorFromBox = {{}, {1, 1, -0.5}};
  });
  python(R"(
f = (folder / 'training/label_2/000000.txt').read_text().split()
assert f[0] == 'Car' and 0.3 < float(f[1]) <= 1, f
assert 0 <= float(f[4]) < float(f[6]) <= 1241 and 0 <= float(f[5]) < float(f[7]) <= 374, f
)");
}

TEST_F(KittiLayout, NeedsTheListOfObjects) {
  EXPECT_NO_THROW(layout_->check(plan_));
  plan_.manifest.samples[2].objects.reset();
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }), HasSubstr("objects: true"));
}

}  // namespace
}  // namespace scanmill
