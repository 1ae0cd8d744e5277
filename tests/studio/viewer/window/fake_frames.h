#pragma once

// Frames in memory: rings of points about a sensor that drives along x.

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "viewer/frames/frame_source.h"
#include "viewer/image.h"

namespace scanmill {

constexpr std::uint16_t kFakeRoad = 1;
constexpr std::uint16_t kFakeTree = 2;
constexpr std::uint16_t kFakeCar = 20;
constexpr Rgb kFakeRoadColor{128, 64, 128};
constexpr Rgb kFakeTreeColor{20, 200, 60};
constexpr Rgb kFakeCarColor{250, 90, 10};

// A scene file up to its objects, and one with two boxes about the sensors.
inline const std::string kSceneHead =
    "ontology: " SCANMILL_SOURCE_DIR "/labels/scanmill.yaml\nmaterials: " SCANMILL_SOURCE_DIR
    "/labels/materials.yaml\nobjects:\n";
inline const std::string kWallScene =
    kSceneHead +
    "  - {primitive: box, size: [60, 60, 0.1], class: road, material: asphalt, position: [5, 100, 0]}\n"
    "  - {primitive: box, size: [4, 2, 1.5], class: car, material: asphalt, position: [15, 100, 1]}\n";

inline Ontology fakeOntology() {
  Ontology ontology;
  ontology.classes = {{0, "unlabeled", {0, 0, 0}, false, {}},
                      {kFakeRoad, "road", kFakeRoadColor, false, {}},
                      {kFakeTree, "tree", kFakeTreeColor, false, {}},
                      {kFakeCar, "car", kFakeCarColor, true, {}, {}, true}};
  return ontology;
}

// The ground is road; beyond 12 m stand a tree on the left and a car on the right. Rings differ in their range.
inline Scan fakeScan(std::uint32_t rings, std::uint32_t columns, double grown = 1) {
  Scan scan;
  scan.rings = rings;
  scan.columns = columns;
  for (std::uint32_t r = 0; r < rings; ++r) {
    for (std::uint32_t c = 0; c < columns; ++c) {
      const double azimuth = 2 * kPi * c / columns;
      const double range = grown * (4 + 2.5 * (rings - 1 - r));
      const bool far = range > 12;
      const Vec3d p{range * std::cos(azimuth), range * std::sin(azimuth), far ? -1.8 + 0.3 * (rings - r) : -1.8};
      scan.position.push_back(Vec3f(p));
      const std::uint16_t label = !far ? kFakeRoad : c < columns / 2 ? kFakeTree : kFakeCar;
      scan[kLabel].push_back(label);
      scan[kInstance].push_back(label == kFakeCar ? 4711 : 0);
      scan[kIntensity].push_back(0.25F + static_cast<float>(r) / 64);
      scan[kRing].push_back(static_cast<std::uint16_t>(r));
      scan[kColumn].push_back(static_cast<std::uint16_t>(c));
      scan[kTime].push_back(static_cast<float>(c) * 1e-4F);
      scan[kRangeTrue].push_back(static_cast<float>(length(p)) + 0.01F);
      scan[kIncidence].push_back(0.5F);
    }
  }
  return scan;
}

class FakeFrames : public FrameSource {
 public:
  explicit FakeFrames(std::size_t count, std::vector<std::string> methods = {"ray_tracing"})
      : ontology_(fakeOntology()) {
    for (std::size_t f = 0; f < count; ++f) {
      keys_.push_back("sample-" + std::to_string(100 + f));
      ViewFrame frame{keys_.back(), {}, {}};
      for (std::size_t m = 0; m < methods.size(); ++m) {
        ViewScan scan;
        scan.name = "top, " + methods[m];
        scan.sensor = "top";
        scan.method = methods[m];
        scan.scan = fakeScan(8, 72, 1 + 0.1 * static_cast<double>(m) + 0.001 * static_cast<double>(f));
        scan.worldFromSensor = Pose{{}, {2.0 * static_cast<double>(f), 100, 1.8}};
        scan.time = 0.1 * static_cast<double>(f);
        scan.error.assign(scan.scan.size(), 0.01F);
        scan.errorTitle = "range error (m)";
        frame.scans.push_back(std::move(scan));
      }
      frames.push_back(std::move(frame));
    }
  }

  std::string title() const override { return "fake"; }
  const std::vector<std::string>& keys() const override { return keys_; }
  const Ontology* ontology() const override { return named ? &ontology_ : nullptr; }
  ViewFrame load(std::size_t frame) const override {
    std::unique_lock lock(mutex_);
    opened_.wait(lock, [&] { return open_ || (only_ && *only_ != frame); });
    return frames.at(frame);
  }
  std::vector<Pose> trajectory(std::size_t) const override {
    std::vector<Pose> poses;
    for (const ViewFrame& f : frames) {
      if (!f.scans.empty() && f.scans.front().worldFromSensor) poses.push_back(*f.scans.front().worldFromSensor);
    }
    return poses;
  }
  std::optional<SceneChoice> scene(std::size_t frame, std::string& why) const override {
    if (frame < scenes.size() && !scenes[frame].empty()) return SceneChoice{scenes[frame], 1};
    why = "there is no scene here";
    return {};
  }

  std::optional<std::filesystem::path> vehicle() const override { return vehicleFile; }

  // While it is shut, loading waits; of one frame only, where that is given.
  void setOpen(bool open, std::optional<std::size_t> only = {}) {
    {
      const std::lock_guard lock(mutex_);
      open_ = open;
      only_ = only;
    }
    opened_.notify_all();
  }

  std::vector<ViewFrame> frames;
  std::vector<std::filesystem::path> scenes;  // of the frames, as far as they have one
  bool named = true;
  std::optional<std::filesystem::path> vehicleFile;

 private:
  std::vector<std::string> keys_;
  Ontology ontology_;
  mutable std::mutex mutex_;
  mutable std::condition_variable opened_;
  bool open_ = true;
  std::optional<std::size_t> only_;
};

}  // namespace scanmill
