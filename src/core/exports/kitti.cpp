// Writes the folders of KITTI's object benchmark (Geiger, Lenz and Urtasun, "Are we ready for Autonomous Driving? The
// KITTI Vision Benchmark Suite", CVPR 2012; devkit_object/readme.txt):
//
//   training/velodyne/000000.bin   float32 x, y, z, reflectance per point
//   training/label_2/000000.txt    a line for each object: type, truncation, occlusion, alpha, box in the image (px),
//                                  height, width, length, position in the camera frame (m), rotation about camera y;
//                                  without objects a line of the type DontCare, since OpenPCDet reads no empty file
//   training/calib/000000.txt      P0 to P3, R0_rect, Tr_velo_to_cam, Tr_imu_to_velo
//   training/image_2/000000.png    required by loaders; black, since there is no camera
//   training/planes/000000.txt     the plane of the road, taken as the plane z = 0 of the vehicle; absent if the
//                                  sensor is mounted less than 0.1 m above this plane
//   ImageSets/train.txt            the frames of each split; those of `test` are in testing/
//
// The camera is placed at the sensor's origin, looks along the sensor's x axis and has the field of view of KITTI's
// left colour camera. As in KITTI, only objects in the image are listed. The frames of all sequences in a folder are
// numbered consecutively.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <vector>

#include "exports/layout.h"
#include "images/images.h"

namespace scanmill {

namespace {

// Image size and intrinsics of KITTI's camera 2 (px).
constexpr int kWidth = 1242;
constexpr int kHeight = 375;
constexpr double kFocal = 721.5377;
constexpr double kCenterX = 609.5593;
constexpr double kCenterY = 172.854;
constexpr double kNear = 0.1;  // m, distance of the near clipping plane in front of the camera

// Line for a frame without objects: a region of one pixel in which the benchmark ignores detections.
constexpr const char* kNoObject = "DontCare -1 -1 -10 0.00 0.00 1.00 1.00 -1 -1 -1 -1000 -1000 -1000 -10\n";

constexpr std::size_t kMostFrames = 1'000'000;  // largest number of frames, because their numbers have six digits

// Converts a point from the sensor's axes to the camera's: x right, y down, z forward.
Vec3d inCamera(const Vec3d& p) {
  return {-p.y, -p.z, p.x};
}

struct ImageBox {
  double left = INFINITY, top = INFINITY, right = -INFINITY, bottom = -INFINITY;

  double area() const { return right > left && bottom > top ? (right - left) * (bottom - top) : 0; }
  ImageBox within(double width, double height) const {
    return {std::clamp(left, 0.0, width), std::clamp(top, 0.0, height), std::clamp(right, 0.0, width),
            std::clamp(bottom, 0.0, height)};
  }
};

// Returns the bounds (px) of the projected edges of a box. Edges that reach behind the camera are clipped at the plane
// kNear in front of it.
ImageBox projected(const Pose& sensorFromBox, const Vec3d& size) {
  // Bit 0 of a corner's index is set at the greater x, bit 1 at the greater y, bit 2 at the greater z, so that the
  // corners of an edge differ in one bit.
  std::array<Vec3d, 8> corners;
  for (std::size_t k = 0; k < 8; ++k) {
    corners[k] = inCamera(sensorFromBox * Vec3d{(k & 1 ? 0.5 : -0.5) * size.x, (k & 2 ? 0.5 : -0.5) * size.y,
                                                (k & 4 ? 0.5 : -0.5) * size.z});
  }
  ImageBox box;
  const auto extendTo = [&](const Vec3d& p) {
    const double u = kFocal * p.x / p.z + kCenterX;
    const double v = kFocal * p.y / p.z + kCenterY;
    box = {std::min(box.left, u), std::min(box.top, v), std::max(box.right, u), std::max(box.bottom, v)};
  };
  for (std::size_t k = 0; k < 8; ++k) {
    if (corners[k].z >= kNear) extendTo(corners[k]);
    for (const std::size_t axisBit : {1u, 2u, 4u}) {
      if ((k & axisBit) != 0) continue;  // each edge once, from its lesser corner
      const Vec3d& a = corners[k];
      const Vec3d& b = corners[k | axisBit];
      if ((a.z < kNear) != (b.z < kNear)) extendTo(a + (b - a) * ((kNear - a.z) / (b.z - a.z)));
    }
  }
  return box;
}

// Returns the devkit's level of occlusion: 0 fully visible, 1 partly occluded, 2 largely occluded. The devkit does not
// define the levels by figures; these limits are chosen by eye.
int occlusion(const ObjectView& view) {
  constexpr double kFullyVisible = 0.8, kPartlyVisible = 0.4;
  const double visibility = view.visibility().value_or(0);
  return visibility >= kFullyVisible ? 0 : visibility >= kPartlyVisible ? 1 : 2;
}

// Returns the centre of the box's bottom face in the camera's axes (m), which KITTI takes for the object's position.
Vec3d bottomInCamera(const ObjectRecord& object, const ObjectView& view) {
  return inCamera(view.sensorFromBox * Vec3d{0, 0, -object.size.z / 2});
}

// Returns true if a part of the box is in the image, and the centre of its bottom face is in front of the camera.
bool isShown(const ObjectRecord& object, const ObjectView& view) {
  const ImageBox seen = projected(view.sensorFromBox, object.size).within(kWidth - 1, kHeight - 1);
  return seen.area() > 0 && bottomInCamera(object, view).z >= kNear;
}

// Returns the object's line in the file in label_2; empty if the object is not in the image.
std::string labelOf(const std::string& type, const ObjectRecord& object, const ObjectView& view) {
  if (!isShown(object, view)) return {};
  const ImageBox unclipped = projected(view.sensorFromBox, object.size);
  const ImageBox seen = unclipped.within(kWidth - 1, kHeight - 1);
  const Vec3d bottom = bottomInCamera(object, view);
  const Vec3d heading = inCamera(toMatrix(view.sensorFromBox.rotation).x);
  const double rotation = std::atan2(-heading.z, heading.x);                // rad, about the camera's y axis
  const double alpha = wrapped(rotation - std::atan2(bottom.x, bottom.z));  // rad, relative to the line of sight
  return fmt::format(
      "{} {:.2f} {} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f} {:.2f}\n", type,
      1 - seen.area() / unclipped.area(), occlusion(view), alpha, seen.left, seen.top, seen.right, seen.bottom,
      object.size.z, object.size.y, object.size.x, bottom.x, bottom.y, bottom.z, rotation);
}

// Returns the calibration text. It is the same for all frames, as the camera is fixed at the sensor's origin.
std::string calibration() {
  std::string text;
  for (int camera = 0; camera < 4; ++camera) {
    text += fmt::format("P{}: {:.12e} 0 {:.12e} 0 0 {:.12e} {:.12e} 0 0 0 1 0\n", camera, kFocal, kCenterX, kFocal,
                        kCenterY);
  }
  return text +
         "R0_rect: 1 0 0 0 1 0 0 0 1\n"
         "Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
         "Tr_imu_to_velo: 1 0 0 0 0 1 0 0 0 0 1 0\n";
}

// Returns the file that describes the road's plane, a x + b y + c z + d = 0 in the camera's frame; empty if the sensor
// is mounted so low that its height above the road is uncertain.
std::string planeText(const ExportPlan& plan, const SampleRecord& sample) {
  constexpr double kLowestMount = 0.1;  // m: a lower sensor is probably not mounted on a vehicle
  const Pose& mount = mountOf(*plan.sensors[0], scanOf(plan, sample, 0));
  if (mount.translation.z < kLowestMount) return {};
  const Vec3d up = inCamera(transposed(toMatrix(mount.rotation)) * Vec3d{0, 0, 1});
  return fmt::format("# Plane\nWidth 4\nHeight 1\n{:.9e} {:.9e} {:.9e} {:.9e}\n", up.x, up.y, up.z,
                     mount.translation.z);
}

class Kitti : public ExportLayout {
 public:
  void check(const ExportPlan& plan) const override {
    std::size_t frames = 0;
    for (const ExportSequence& sequence : plan.sequences) frames += sequence.samples.size();
    if (frames > kMostFrames) {
      refuse(plan, "has {} frames, but the numbers of KITTI's frames have six digits: take fewer frames with --split",
             frames);
    }
    if (listsObjects(plan)) return;
    refuse(plan, "lists no objects, but KITTI's labels are boxes: generate it with `output: {{objects: true}}`");
  }

  void write(const ExportPlan& plan, std::size_t sequence, std::size_t frame, const ReadSample& read,
             const ExportFolder& folder) const override {
    const ExportSample sample = read(sequence, frame);
    std::string labels;
    forObjectsWithPoints(plan, *sample.objects,
                         [&](const std::string& type, const ObjectRecord& object, const ObjectView& view) {
                           labels += labelOf(type, object, view);
                         });
    if (labels.empty()) labels = kNoObject;
    const std::string number = fmt::format("{:06}", numberOf(plan, sequence, frame));
    const std::filesystem::path split = folderOf(plan.sequences[sequence]);
    const ExportScan& scan = sample.scans.front();
    folder.write(split / "label_2" / (number + ".txt"), labels);
    folder.write(split / "calib" / (number + ".txt"), calibration());
    folder.write(split / "image_2" / (number + ".png"), image_);
    folder.write(split / "velodyne" / (number + ".bin"), velodynePoints(scan, velodyneOrder(scan)));
    const std::string plane = planeText(plan, *sample.record);
    if (!plane.empty()) folder.write(split / "planes" / (number + ".txt"), plane);
  }

  std::vector<std::string> finish(const ExportPlan& plan, const ReadObjects& read,
                                  const ExportFolder& folder) const override {
    std::map<std::string, std::string> frameLists{{"train", ""}, {"val", ""}, {"test", ""}};  // by split
    std::size_t boxes = 0;                                                                    // objects with points
    std::size_t shownBoxes = 0;
    for (std::size_t s = 0; s < plan.sequences.size(); ++s) {
      for (std::size_t f = 0; f < plan.sequences[s].samples.size(); ++f) {
        frameLists[plan.sequences[s].split] += fmt::format("{:06}\n", numberOf(plan, s, f));
        forObjectsWithPoints(plan, *read(s, f),
                             [&](const std::string&, const ObjectRecord& object, const ObjectView& view) {
                               ++boxes;
                               shownBoxes += isShown(object, view) ? 1 : 0;
                             });
      }
    }
    frameLists["trainval"] = frameLists["train"] + frameLists["val"];
    for (const auto& [split, frames] : frameLists)
      folder.write(std::filesystem::path("ImageSets") / (split + ".txt"), frames);
    std::vector<std::string> warnings = skewWarnings(plan, "KITTI");
    if (shownBoxes == 0)
      warnings.emplace_back("there is no box: no object of a class of KITTI is in view of its camera");
    if (shownBoxes == boxes) return warnings;
    warnings.push_back(
        fmt::format("{} of {} boxes with points are left out, since KITTI lists only objects in the image of its "
                    "camera, which looks along the sensor's x axis; all points are written",
                    boxes - shownBoxes, boxes));
    return warnings;
  }

 private:
  // Calls work(type, object, view) for the objects that have points in the scan and a class that KITTI has.
  template <class Work>
  static void forObjectsWithPoints(const ExportPlan& plan, const SampleObjects& objects, const Work& work) {
    for (const ObjectRecord& object : objects.objects) {
      const SemanticClass& type = plan.classes.classOf(object.semantic);
      if (type.id == 0) continue;
      for (const ObjectView& view : object.views) {
        if (view.sensor == plan.sensors.front()->name && view.points > 0) work(type.name, object, view);
      }
    }
  }

  static const char* folderOf(const ExportSequence& sequence) {
    return sequence.split == "test" ? "testing" : "training";
  }

  // Returns the number of a frame among the frames of all sequences in the same folder.
  static std::size_t numberOf(const ExportPlan& plan, std::size_t sequence, std::size_t frame) {
    const std::string_view folder = folderOf(plan.sequences[sequence]);
    std::size_t number = frame;
    for (std::size_t s = 0; s < sequence; ++s) {
      if (folderOf(plan.sequences[s]) == folder) number += plan.sequences[s].samples.size();
    }
    return number;
  }

  std::string image_ = encodePng(std::vector<std::uint8_t>(std::size_t{3} * kWidth * kHeight).data(), kWidth, kHeight);
};

}  // namespace

std::unique_ptr<ExportLayout> makeKitti() {
  return std::make_unique<Kitti>();
}

}  // namespace scanmill
