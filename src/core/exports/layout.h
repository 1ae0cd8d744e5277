#pragma once

// Folders and files in which other programs want datasets. Adding a layout is a new file and a row in layouts().

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

// One scene driven along one way, whose frames follow one another.
struct ExportSequence {
  std::string name;                  // as samples' keys begin: "street-s1-lane"
  std::string split;                 // of its first sample
  std::vector<std::size_t> samples;  // indices into Manifest::samples, in the order of the frames
};

struct ExportScan {
  const ScanRecord* record = nullptr;
  const SensorRecord* sensor = nullptr;
  std::size_t sensorNumber = 0;  // into ExportPlan::sensors
  Scan scan;                     // dense, or organised with misses of NaN; classes are the dataset's
};

// A point's intensity as a part of the full one of its sensor; 0 where the scan has none, more than 1 where it has
// more.
inline float unitIntensity(const ExportScan& given, std::size_t point) {
  const std::vector<float>& values = given.scan[kIntensity];
  return values.empty() ? 0.0f : static_cast<float>(values[point] / given.sensor->intensityFullScale);
}

struct ExportSample {
  const SampleRecord* record = nullptr;
  std::size_t sequence = 0;              // into ExportPlan::sequences
  std::size_t frame = 0;                 // in the sequence, from 0
  std::vector<ExportScan> scans;         // of the sensors that are exported, in their order
  std::optional<SampleObjects> objects;  // none where the dataset lists none
  std::optional<ScanVoxels> voxels;      // about the first sensor; none where there are none, or the layout reads none
};

// What is exported.
struct ExportPlan {
  std::filesystem::path dataset;
  Manifest manifest;
  ClassMap classes;
  std::vector<const SensorRecord*> sensors;
  std::vector<ExportSequence> sequences;  // in the order of their first samples
};

// Whether the dataset lists the objects of every sample that is exported.
bool listsObjects(const ExportPlan& plan);
// Whether the dataset's scans have a column.
bool hasColumn(const ExportPlan& plan, std::string_view column);
// Whether the sample of a frame has voxels about the first sensor that is exported.
bool hasVoxels(const ExportPlan& plan, std::size_t sequence, std::size_t frame);
// The scan's points, without misses, as KITTI's files order theirs, which some loaders find the rings by: ring after
// ring from the top, each from straight ahead over the left round to there. In the scan's own order where it knows no
// rings.
std::vector<std::size_t> velodyneOrder(const ExportScan& given);
// These points of KITTI's files velodyne/*.bin: x, y, z (m) and the part of 1 that comes back, float32.
std::string velodynePoints(const ExportScan& given, std::span<const std::size_t> order);
// The scan of the first sensor that is exported, for layouts that hold one. Throws InputError where there is none.
const ScanRecord& onlyScanOf(const ExportPlan& plan, const SampleRecord& sample);

using ReadSample = std::function<ExportSample(std::size_t sequence, std::size_t frame)>;
using ReadObjects = std::function<std::optional<SampleObjects>(std::size_t sequence, std::size_t frame)>;

// The folder that is written. Files get their names only when they are whole.
class ExportFolder {
 public:
  explicit ExportFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& path() const { return folder_; }
  // Writes a file, and the folders above it. `name` is relative. Throws Error.
  void write(const std::filesystem::path& name, std::string_view bytes) const;
  // The whole path of a file whose folder is there from now on, for those who write it piece by piece (AtomicFile).
  std::filesystem::path place(const std::filesystem::path& name) const;

 private:
  std::filesystem::path folder_;
};

// Safe to use from several threads. Throws InputError for datasets that do not fit, with the sample or the sensor.
class Layout {
 public:
  virtual ~Layout() = default;

  // Before anything is written: by the manifest alone.
  virtual void check(const ExportPlan&) const {}
  // Whether values of samples may not fit. Then checkSample() sees all that are to be written before any is.
  virtual bool checksSamples(const ExportPlan&) const { return false; }
  virtual void checkSample(const ExportPlan&, const ExportSample&) const {}

  // Whether ExportSample::voxels are wanted.
  virtual bool readsVoxels() const { return false; }

  // A unit of work is one frame, or one sequence where its frames share a file.
  virtual bool bySequence() const { return false; }
  // The files of a unit, relative to the folder; it is done when all are there. `frame`: 0 of sequences.
  virtual std::vector<std::filesystem::path> filesOf(const ExportPlan&, std::size_t sequence,
                                                     std::size_t frame) const = 0;
  virtual void write(const ExportPlan&, std::size_t sequence, std::size_t frame, const ReadSample& read,
                     const ExportFolder& folder) const = 0;
  // Once all units are there: what is of the whole dataset. Returns what users should be warned of.
  virtual std::vector<std::string> finish(const ExportPlan&, const ReadObjects&, const ExportFolder&) const {
    return {};
  }
};

struct LayoutEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view labels;  // the ontology that it has, of labels/; empty: the dataset's own classes
  bool oneSensor = false;   // it holds the scans of one sensor
  bool boxesAlone = false;  // points have no classes there, only boxes
  std::unique_ptr<Layout> (*make)();
};

std::span<const LayoutEntry> layouts();
// Throws InputError, with the names that there are.
const LayoutEntry& requireLayout(std::string_view name);

// Makers of the rows, each in the file of its name.
std::unique_ptr<Layout> makeSemanticKitti();
std::unique_ptr<Layout> makeKitti();
std::unique_ptr<Layout> makeNuScenes();
std::unique_ptr<Layout> makeLas();
std::unique_ptr<Layout> makePly();
std::unique_ptr<Layout> makeNpz();
std::unique_ptr<Layout> makeMcap();

}  // namespace scanmill
