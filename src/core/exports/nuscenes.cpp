// The layout of nuScenes (Caesar et al., "nuScenes: A multimodal dataset for autonomous driving", CVPR 2020) with the
// labels of Panoptic nuScenes (Fong et al., RA-L 2022), which the devkit opens as version v1.0-trainval. The schema of
// nuScenes and the contents of the files are described in docs/ and python-sdk/nuscenes/eval/ of
// github.com/nutonomy/nuscenes-devkit:
//
//   v1.0-trainval/*.json                               the tables, and splits.json
//   samples/LIDAR_TOP/KEY__LIDAR_TOP__TIME.pcd.bin     float32 x, y, z, intensity, ring per point
//   samples/LIDAR_REAR/...                             likewise for a sensor `rear`; the first sensor is LIDAR_TOP
//   lidarseg/v1.0-trainval/TOKEN_lidarseg.bin          uint8 per point: its class
//   panoptic/v1.0-trainval/TOKEN_panoptic.npz          uint16 per point: 1000 * class + instance
//   maps/TOKEN.png                                     a white map
//   sweeps/LIDAR_TOP/                                  further revolutions of a sensor in a sample, without labels
//
// - Points are in the frame of the real LIDAR_TOP, x to the right, y forward, z up, so that models trained on nuScenes
//   can be used; calibrated_sensor has the frame's pose on the vehicle. Rings are numbered from the lowest beam; they
//   are all 0 if the dataset has no ring numbers. Intensities are integers from 0 to 255, as from the real sensor:
//   intensities above the full scale become 255, and all are 0 without the column `intensity`.
// - Every frame is a key frame with a sample, however close the frames are. A sensor that turns faster than others has
//   several revolutions in a sample: the first one is the key frame, the others are sweeps.
// - Each sequence is a scene with a log. The first scene is on 2020-01-01, and each further scene one day later,
//   because times must differ from scene to scene. Times and ego_pose are those at the start of a revolution.
// - sample_annotation has the listed objects that have at least one point and whose class in labels/nuscenes.yaml is a
//   thing class, because nuScenes has boxes only for these. A box has the object's pose at the time when the first
//   lidar that sees the object hits it. All boxes of an instance have the size of the largest in the scene.
//   num_lidar_pts counts the points of all lidars; visibility is the highest among the lidars.
// - Instances are numbered from 1 to 999 within each class of a scene, in the order of the dataset's ids.
// - splits.json lists the scenes of each split, for newer versions of the devkit. These versions reserve the names of
//   nuScenes's splits (`train`, `val`, ...), so each split is also listed with a prefix, as `scanmill_train`.
// - Without the column `label` there are no labels, without the column `instance` there are no panoptic labels, and
//   without lists of objects the tables sample_annotation and instance are empty. The devkit refuses to read labels of
//   a scan without points.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "base/error.h"
#include "exports/instance_numbers.h"
#include "exports/layout.h"
#include "exports/nuscenes_names.h"
#include "formats/little_endian.h"
#include "formats/npy.h"

namespace scanmill {

namespace {

constexpr double kMostFrameGap = 1.5;  // s, greatest gap between key frames over which the devkit computes velocities

constexpr std::uint16_t kClassStep = 1000;   // difference between the panoptic labels of successive classes
constexpr std::size_t kMostInstances = 999;  // largest number of instances of a class in a scene
constexpr std::size_t kMostClasses = 65;     // largest number of classes: the label 64 * 1000 + 999 fits 16 bits
constexpr float kFullIntensity = 255;

// The group of an instance is its class id in the exported ontology. The instance id alone does not suffice, because
// the parts of an object may have different classes.
using Instance = InstanceNumbers::Instance;

// Returns the point's class id (as the group) and instance id; the instance id is 0 unless the class is a thing class.
Instance instanceOf(const ExportPlan& plan, const Scan& scan, std::size_t point) {
  const SemanticClass& c = plan.classes.classOf(scan[kLabel].empty() ? std::uint16_t{0} : scan[kLabel][point]);
  return {c.id, c.thing && !scan[kInstance].empty() ? scan[kInstance][point] : 0};
}

// Returns the new number of each ring, counted from the lowest ring. If the rings are not cones, keeps the numbers.
std::vector<std::uint16_t> ringsFromBelow(const BeamTable& beams) {
  std::vector<std::uint16_t> order(beams.rings);
  std::iota(order.begin(), order.end(), std::uint16_t{0});
  if (!beams.onCones() || beams.elevation.size() != beams.rings) return order;
  std::ranges::stable_sort(order,
                           [&](std::uint16_t a, std::uint16_t b) { return beams.elevation[a] < beams.elevation[b]; });
  std::vector<std::uint16_t> numbers(beams.rings);
  for (std::size_t i = 0; i < order.size(); ++i) numbers[order[i]] = static_cast<std::uint16_t>(i);
  return numbers;
}

// Returns the bytes of the points, in LIDAR_TOP's frame: x to the right, y forward, z up.
std::string pointsOf(const ExportScan& exported) {
  const Scan& scan = exported.scan;
  const std::vector<std::uint16_t> numbersFromBelow = ringsFromBelow(exported.sensor->beams);
  std::string bytes;
  bytes.reserve(scan.size() * 5 * sizeof(float));
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3f& p = scan.position[i];
    if (!isFinite(p)) continue;
    const float unit = unitIntensity(exported, i);
    const float intensity = unit > 0 ? std::round(std::min(unit, 1.0f) * kFullIntensity) : 0;
    std::size_t ring = 0;
    if (!scan[kRing].empty() || scan.organised) {
      ring = !scan[kRing].empty() ? scan[kRing][i] : keyOf(scan, i).ring;
      if (ring < numbersFromBelow.size()) ring = numbersFromBelow[ring];
    }
    for (const float value : {-p.y, p.x, p.z, intensity, static_cast<float>(ring)}) putNumber(value, bytes);
  }
  return bytes;
}

class NuScenes : public ExportLayout {
 public:
  void check(const ExportPlan& plan) const override {
    checkClasses(plan);
    requireDistinct(plan, "channel", [&](std::size_t sensor) { return nuScenesChannel(plan, sensor); });
    for (std::size_t s = 0; s < plan.sequences.size(); ++s) {
      std::int64_t previousTime = -1;  // microseconds
      for (const std::size_t number : plan.sequences[s].samples) {
        const SampleRecord& sample = plan.manifest.samples[number];
        const ScanRecord& scan = scanOf(plan, sample);
        for (std::size_t sensor = 1; sensor < plan.sensors.size(); ++sensor) scanOf(plan, sample, sensor);
        if (!(scan.time >= 0 && scan.time < kNuScenesDay)) {
          refuse(plan, "the sample {} has the time {} s, but scenes of nuScenes last at most a day: split its sequence",
                 sample.key, scan.time);
        }
        const std::int64_t time = nuScenesTime(s, scan);
        if (time <= previousTime) {
          refuse(plan,
                 "the sample {} at {} s is less than a microsecond after the sample before it, but nuScenes "
                 "identifies samples by their times: give the frames of its sequence different times",
                 sample.key, scan.time);
        }
        previousTime = time;
      }
    }
  }

  bool checksSamples(const ExportPlan& plan) const override { return isPanoptic(plan); }
  void checkSample(const ExportPlan& plan, const ExportSample& sample) const override { numbers_.add(plan, sample); }

  void write(const ExportPlan& plan, std::size_t sequence, std::size_t frame, const ReadSample& read,
             const ExportFolder& folder) const override {
    const ExportSample sample = read(sequence, frame);
    const InstanceNumbers::Numbers numbers = numbers_.numbersOf(sequence);
    for (const ExportScan& scan : sample.scans) {
      folder.write(pointsFile(plan, sequence, *sample.record, scan.sensorNumber, *scan.record), pointsOf(scan));
      if (scan.record->revolution == 0 && plan.manifest.hasColumn("label"))
        writeLabels(plan, *sample.record, scan, numbers, folder);
    }
  }

  std::vector<std::string> finish(const ExportPlan& plan, const ReadObjects& read,
                                  const ExportFolder& folder) const override {
    const std::size_t boxes = writeNuScenesTables(plan, read, folder);
    std::vector<std::string> warnings = skewWarnings(plan, "nuScenes");
    if (boxes == 0 && listsObjects(plan)) {
      warnings.emplace_back("there is no box: no object with points has a class of which nuScenes counts things");
    }
    std::size_t gaps = 0;         // frames that are more than kMostFrameGap after the frame before
    std::size_t otherScenes = 0;  // scenes whose split is neither train nor val
    for (const ExportSequence& sequence : plan.sequences) {
      otherScenes += sequence.split == "train" || sequence.split == "val" ? 0 : 1;
      for (std::size_t f = 1; f < sequence.samples.size(); ++f) {
        const auto timeOf = [&](std::size_t frame) {
          return scanOf(plan, plan.manifest.samples[sequence.samples[frame]], 0).time;
        };
        gaps += timeOf(f) - timeOf(f - 1) > kMostFrameGap ? 1 : 0;
      }
    }
    if (otherScenes > 0) {
      warnings.push_back(fmt::format(
          "{} scenes are neither of the split train nor of val: training programs take them for validation, so "
          "leave them out with `--split train --split val`",
          otherScenes));
    }
    if (gaps > 0 && listsObjects(plan)) {
      warnings.push_back(fmt::format(
          "{} frames are more than {:g} s after the one before, so that nuScenes' devkit gives their boxes no "
          "velocity: drive with `every_s: 0.5`",
          gaps, kMostFrameGap));
    }
    if (!listsObjects(plan)) {
      warnings.emplace_back(
          "the dataset lists no objects, so that the export has no boxes: generate it with `output: {objects: true}`");
    }
    return warnings;
  }

 private:
  static bool isPanoptic(const ExportPlan& plan) {
    return plan.manifest.hasColumn("label") && plan.manifest.hasColumn("instance");
  }

  // Writes the class and, if the dataset has instances, the panoptic label of each point. `numbers`: the new numbers of
  // the instances.
  static void writeLabels(const ExportPlan& plan, const SampleRecord& sample, const ExportScan& exported,
                          const InstanceNumbers::Numbers& numbers, const ExportFolder& folder) {
    const Scan& scan = exported.scan;
    std::string classes, panoptic;  // contents of the files
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (!isFinite(scan.position[i])) continue;
      const Instance instance = instanceOf(plan, scan, i);
      putNumber(static_cast<std::uint8_t>(instance.group), classes);
      const std::uint16_t number = instance.id == 0 ? std::uint16_t{0} : numbers.at(instance);
      putNumber(static_cast<std::uint16_t>(instance.group * kClassStep + number), panoptic);
    }
    folder.write(labelFile(plan, sample, exported.sensorNumber, NuScenesLabels::Lidarseg), classes);
    if (!isPanoptic(plan)) return;
    const std::pair<std::string, std::string> array{"data.npy", npyOf("<u2", {classes.size()}, panoptic)};
    folder.write(labelFile(plan, sample, exported.sensorNumber, NuScenesLabels::Panoptic), zipOf({&array, 1}));
  }

  // Throws InputError if the class ids are not 0, 1, 2, ... without gaps, which the devkit requires to count points by
  // class, or if there are more than kMostClasses classes.
  static void checkClasses(const ExportPlan& plan) {
    const Ontology& target = plan.classes.target();
    std::set<std::uint16_t> ids;
    for (const SemanticClass& c : target.classes) ids.insert(c.id);
    if (ids.size() <= kMostClasses && !ids.empty() && *ids.rbegin() == ids.size() - 1) return;
    throw InputError(
        fmt::format("the classes of {} must have the ids 0, 1, 2 and so on without gaps, at most {} classes, as the "
                    "categories of nuScenes: leave --classes out, or copy labels/nuscenes.yaml and change its aliases",
                    target.name, kMostClasses));
  }

  mutable InstanceNumbers numbers_{"nuScenes", kMostInstances, instanceOf,
                                   [](const ExportPlan& plan, std::uint16_t category) {
                                     return "instances of " + plan.classes.target().find(category)->name;
                                   }};
};

}  // namespace

std::unique_ptr<ExportLayout> makeNuScenes() {
  return std::make_unique<NuScenes>();
}

}  // namespace scanmill
