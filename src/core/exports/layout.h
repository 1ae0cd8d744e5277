#pragma once

// The layouts of folders and files in which other programs read datasets. A new layout needs a new file and a row in
// layouts().

#include <fmt/core.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "dataset/manifest.h"
#include "dataset/objects.h"
#include "dataset/voxels.h"
#include "exports/class_map.h"
#include "scan/scan.h"

namespace scanmill {

// One drive along one trajectory through one scene, as consecutive frames.
struct ExportSequence {
  std::string name;                  // the common beginning of the keys of its samples: "street-s1-lane"
  std::string split;                 // split of its first sample
  std::vector<std::size_t> samples;  // indices into Manifest::samples, in the order of the frames
};

struct ExportScan {
  const ScanRecord* record = nullptr;
  const SensorRecord* sensor = nullptr;
  std::size_t sensorNumber = 0;  // index of the sensor in ExportPlan::sensors
  Scan scan;                     // dense, or organised with misses as NaN; its classes are those of the dataset
};

// Returns a point's intensity divided by the full scale of its sensor. The result may be more than 1; it is 0 if the
// scan has no intensity.
inline float unitIntensity(const ExportScan& exportScan, std::size_t point) {
  const std::vector<float>& values = exportScan.scan[kIntensity];
  return values.empty() ? 0.0f : static_cast<float>(values[point] / exportScan.sensor->intensityFullScale);
}

struct ExportSample {
  const SampleRecord* record = nullptr;
  std::size_t sequence = 0;              // index into ExportPlan::sequences
  std::size_t frame = 0;                 // number of the frame in the sequence, from 0
  std::vector<ExportScan> scans;         // revolutions of the exported sensors, in the order of ExportPlan::sensors
  std::optional<SampleObjects> objects;  // none: the dataset lists no objects
  std::optional<ScanVoxels> voxels;      // voxels around the first exported sensor; none: absent or not read
};

// Names in files for ROS.
struct RosNames {
  std::string world = "map", vehicle = "base_link";  // frames, as REP 105 names them
  std::filesystem::path robot;                       // URDF file of the vehicle; empty: none
  std::vector<std::string> links = {};               // names of its links, the root link first
};

// The parts of a dataset that are exported, and the mapping of its classes.
struct ExportPlan {
  std::filesystem::path dataset;
  Manifest manifest;
  ClassMap classes;
  std::vector<const SensorRecord*> sensors;
  std::vector<ExportSequence> sequences;  // ordered by their first samples
  RosNames ros = {};                      // only for MCAP
};

// Throws an InputError that names the dataset.
template <class... Values>
[[noreturn]] void refuse(const ExportPlan& plan, fmt::format_string<Values...> reason, Values&&... values) {
  throw InputError({plan.dataset.string()}, fmt::format(reason, std::forward<Values>(values)...));
}

// Returns true if the dataset lists the objects of every exported sample.
bool listsObjects(const ExportPlan& plan);
// Returns the indices of the scan's points, without misses, in the order of KITTI's files: rings from top to bottom,
// each ring counter-clockwise, starting straight ahead. Some loaders derive the rings from this order. If the scan has
// no ring numbers, the points keep their order.
std::vector<std::size_t> velodyneOrder(const ExportScan& exportScan);
// Returns the bytes of a KITTI file velodyne/*.bin: float32 x, y, z (m) and intensity (0 to 1) of each point. `order`:
// indices of the points to write.
std::string velodynePoints(const ExportScan& exportScan, std::span<const std::size_t> order);
// Returns a warning if a sensor moves during a revolution and the dataset is not deskewed, otherwise an empty list. The
// layout named `layout` stores one pose and no times, so that this pose would not apply to all points.
std::vector<std::string> skewWarnings(const ExportPlan& plan, std::string_view layout);
// Returns the scans of an exported sensor (index in ExportPlan::sensors), one for each of its revolutions in the
// sample. Returns none if a slow sensor has no revolution in the sample.
std::vector<const ScanRecord*> revolutionsOf(const ExportPlan& plan, const SampleRecord& sample, std::size_t sensor);
// Returns the first scan that revolutionsOf() returns. Throws InputError if there is none.
const ScanRecord& scanOf(const ExportPlan& plan, const SampleRecord& sample, std::size_t sensor = 0);

// Throws InputError if nameOf() returns the same name for two exported sensors (indices in ExportPlan::sensors).
// `what`: for the message, the kind of thing that has the name in the layout, such as "folder".
void requireDistinct(const ExportPlan& plan, std::string_view what,
                     const std::function<std::string(std::size_t)>& nameOf);

using ReadSample = std::function<ExportSample(std::size_t sequence, std::size_t frame)>;
using ReadObjects = std::function<std::optional<SampleObjects>(std::size_t sequence, std::size_t frame)>;

// The output folder. Files get their final names only when they are complete.
class ExportFolder {
 public:
  explicit ExportFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& path() const { return folder_; }
  // Writes a file and creates the folders above it. `name`: relative to the output folder. Throws Error if this fails.
  void write(const std::filesystem::path& name, std::string_view bytes) const;
  // Creates the folders above a file and returns the file's full path, for callers that write the file step by step
  // (AtomicFile).
  std::filesystem::path prepareFile(const std::filesystem::path& name) const;

 private:
  std::filesystem::path folder_;
};

// A layout. It may be used by several threads at once. All calls throw an InputError with the sample or the sensor if
// the dataset does not fit the layout.
class ExportLayout {
 public:
  virtual ~ExportLayout() = default;

  // Throws InputError if the dataset's manifest shows that the layout cannot store the dataset. Called before
  // anything is written.
  virtual void check(const ExportPlan&) const {}
  // Returns true if the samples must be checked, too: checkSample() is then called for all samples before any sample is
  // written.
  virtual bool checksSamples(const ExportPlan&) const { return false; }
  virtual void checkSample(const ExportPlan&, const ExportSample&) const {}

  // Returns true if the frames of a sequence share a file, so that a unit of work is a sequence; otherwise a unit is a
  // frame.
  virtual bool bySequence() const { return false; }
  // Writes the files of a unit of work. `frame` is 0 if the unit is a sequence.
  virtual void write(const ExportPlan&, std::size_t sequence, std::size_t frame, const ReadSample& read,
                     const ExportFolder& folder) const = 0;
  // Writes the files that describe the complete dataset; called after all units. Returns warnings for the user.
  virtual std::vector<std::string> finish(const ExportPlan&, const ReadObjects&, const ExportFolder&) const {
    return {};
  }
};

// A layout that writes a file for each scan: SPLIT/KEY.SENSOR.SUFFIX, "train/street-s1-lane-000000.top.las", or
// "train/street-s1-lane-000000.top.1.las" for a sensor's second revolution in the sample.
class ScanFiles : public ExportLayout {
 public:
  // A function that returns the bytes of the file for one scan of the sample.
  using BytesOf = std::string (*)(const ExportPlan& plan, const ExportSample& sample, const ExportScan& scan);

  // `suffix`: suffix of the files, without a dot.
  ScanFiles(std::string suffix, BytesOf bytesOf) : suffix_(std::move(suffix)), bytesOf_(bytesOf) {}

  void write(const ExportPlan& plan, std::size_t sequence, std::size_t frame, const ReadSample& read,
             const ExportFolder& folder) const override;

 private:
  std::string suffix_;
  BytesOf bytesOf_;
};

// Returns the columns that a scan's file has in addition to the position: the columns of the scan or, if the scan has
// no points, the columns of the dataset.
ColumnSet exportedColumns(const ExportPlan& plan, const Scan& scan);

// Returns the value of a column to write: classes are mapped to the exported ontology, other values are unchanged.
template <class Key>
typename Key::Value exported(const ClassMap& classes, Key, typename Key::Value value) {
  if constexpr (Key::row.display.colors == ColumnColors::Classes) {
    static_assert(std::is_same_v<typename Key::Value, std::uint16_t>);
    return classes.targetId(value);
  } else {
    return value;
  }
}

struct LayoutEntry {
  std::string_view name;
  std::string_view summary;
  // Name of the layout's ontology in labels/; empty: the dataset's own classes are exported.
  std::string_view labels = {};
  bool oneSensor = false;   // true: the layout can have only one sensor
  bool boxesAlone = false;  // true: the layout has classes of boxes, but not of points
  bool revolutions = true;  // false: the layout has one scan of each sensor in a frame, no more and no less
  bool voxels = false;      // true: the layout needs ExportSample::voxels
  std::unique_ptr<ExportLayout> (*make)();
};

std::span<const LayoutEntry> layouts();
// Returns the layout with this name. If there is none, throws an InputError that lists all names.
const LayoutEntry& requireLayout(std::string_view name);

// The functions that create the layouts, for the rows of layouts(). Each is in the file named after the layout.
std::unique_ptr<ExportLayout> makeSemanticKitti();
std::unique_ptr<ExportLayout> makeKitti();
std::unique_ptr<ExportLayout> makeNuScenes();
std::unique_ptr<ExportLayout> makeLas();
std::unique_ptr<ExportLayout> makePly();
std::unique_ptr<ExportLayout> makeMcap();

}  // namespace scanmill
