#pragma once

// The layouts of folders and files in which other programs read datasets. A new layout needs a new file and a row in
// layouts().

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/manifest.h"
#include "dataset/objects.h"
#include "dataset/voxels.h"
#include "exports/class_map.h"
#include "scan/scan.h"

namespace scanmill {

// One drive along one trajectory through one scene: consecutive frames.
struct ExportSequence {
  std::string name;                  // the beginning of its samples' keys: "street-s1-lane"
  std::string split;                 // the split of the sequence's first sample
  std::vector<std::size_t> samples;  // indices into Manifest::samples, in the order of the frames
};

struct ExportScan {
  const ScanRecord* record = nullptr;
  const SensorRecord* sensor = nullptr;
  std::size_t sensorNumber = 0;  // index into ExportPlan::sensors
  Scan scan;                     // dense, or organised with misses of NaN; has the classes of the dataset
};

// Returns a point's intensity over the full scale of its sensor, which may be more than 1; 0 if the scan has no
// intensity.
inline float unitIntensity(const ExportScan& given, std::size_t point) {
  const std::vector<float>& values = given.scan[kIntensity];
  return values.empty() ? 0.0f : static_cast<float>(values[point] / given.sensor->intensityFullScale);
}

struct ExportSample {
  const SampleRecord* record = nullptr;
  std::size_t sequence = 0;              // index into ExportPlan::sequences
  std::size_t frame = 0;                 // in the sequence, from 0
  std::vector<ExportScan> scans;         // the scans of the sensors that are exported, in the order of the sensors
  std::optional<SampleObjects> objects;  // none: the dataset lists no objects
  std::optional<ScanVoxels> voxels;      // around the first sensor; none: the sample has none, or the layout reads none
};

// The parts of a dataset to export, and the map of its classes.
struct ExportPlan {
  std::filesystem::path dataset;
  Manifest manifest;
  ClassMap classes;
  std::vector<const SensorRecord*> sensors;
  std::vector<ExportSequence> sequences;  // in the order of their first samples
};

// True if the dataset lists the objects of every sample that is exported.
bool listsObjects(const ExportPlan& plan);
// True if the dataset's scans have a column.
bool hasColumn(const ExportPlan& plan, std::string_view column);
// True if the sample of a frame has voxels around the first sensor that is exported.
bool hasVoxels(const ExportPlan& plan, std::size_t sequence, std::size_t frame);
// Returns the indices of the scan's points, without misses, in the order of KITTI's files, from which some loaders
// derive the rings: ring after ring from the top, each counter-clockwise from straight ahead. If the scan does not know
// its rings, the points keep their order.
std::vector<std::size_t> velodyneOrder(const ExportScan& given);
// Returns the points, in this order, as in KITTI's files velodyne/*.bin: x, y, z (m) and intensity (0 to 1), float32.
std::string velodynePoints(const ExportScan& given, std::span<const std::size_t> order);
// Returns the scan of the first sensor that is exported, for layouts of one sensor. Throws InputError if there is none.
const ScanRecord& onlyScanOf(const ExportPlan& plan, const SampleRecord& sample);

using ReadSample = std::function<ExportSample(std::size_t sequence, std::size_t frame)>;
using ReadObjects = std::function<std::optional<SampleObjects>(std::size_t sequence, std::size_t frame)>;

// The folder that is written. Files get their final names only when they are complete.
class ExportFolder {
 public:
  explicit ExportFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& path() const { return folder_; }
  // Writes a file, and creates the folders above it. `name` is relative. Throws Error.
  void write(const std::filesystem::path& name, std::string_view bytes) const;
  // Creates the folders above a file and returns its full path, for callers that write it piece by piece (AtomicFile).
  std::filesystem::path place(const std::filesystem::path& name) const;

 private:
  std::filesystem::path folder_;
};

// Safe to use from several threads. All calls throw an InputError with the sample or the sensor if the dataset does not
// fit the layout.
class Layout {
 public:
  virtual ~Layout() = default;

  // Throws InputError if the dataset does not fit, by its manifest alone. Called before anything is written.
  virtual void check(const ExportPlan&) const {}
  // True if values of samples may not fit. Then checkSample() is called for all samples before any is written.
  virtual bool checksSamples(const ExportPlan&) const { return false; }
  virtual void checkSample(const ExportPlan&, const ExportSample&) const {}

  // True if write() needs ExportSample::voxels.
  virtual bool readsVoxels() const { return false; }

  // A unit of work is one frame, or one sequence if its frames share a file; then this returns true.
  virtual bool bySequence() const { return false; }
  // Returns the files of a unit, relative to the folder; the unit is done when all exist. `frame`: 0 for sequences.
  virtual std::vector<std::filesystem::path> filesOf(const ExportPlan&, std::size_t sequence,
                                                     std::size_t frame) const = 0;
  virtual void write(const ExportPlan&, std::size_t sequence, std::size_t frame, const ReadSample& read,
                     const ExportFolder& folder) const = 0;
  // Writes the files about the complete dataset, once all units are done. Returns warnings for the user.
  virtual std::vector<std::string> finish(const ExportPlan&, const ReadObjects&, const ExportFolder&) const {
    return {};
  }
};

struct LayoutEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view labels;  // name of its ontology in labels/; empty: the dataset's own classes
  bool oneSensor = false;   // the sequence holds the scans of only one sensor
  bool boxesAlone = false;  // only boxes have classes, not points
  std::unique_ptr<Layout> (*make)();
};

std::span<const LayoutEntry> layouts();
// Throws an InputError with all names if there is no layout of this name.
const LayoutEntry& requireLayout(std::string_view name);

// The functions that create the layouts in the rows of layouts(), each in the file of its name.
std::unique_ptr<Layout> makeSemanticKitti();
std::unique_ptr<Layout> makeKitti();
std::unique_ptr<Layout> makeNuScenes();
std::unique_ptr<Layout> makeLas();
std::unique_ptr<Layout> makePly();
std::unique_ptr<Layout> makeNpz();
std::unique_ptr<Layout> makeMcap();

}  // namespace scanmill
