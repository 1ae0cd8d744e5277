// Writes a LAS 1.4 file for each strip, the frames of a sequence in their order: "LAS Specification 1.4 - R15",
// American Society for Photogrammetry and Remote Sensing, 2019. Point format 6, uncompressed:
//
//   X, Y, Z              in the world (m), in steps of 0.5 mm, so that a coordinate is off by at most 0.25 mm. The
//                        file's offset is the sensor's first position, rounded to whole metres
//   intensity            0 to the sensor's full scale becomes 0 to 65535; higher values are clamped
//   return number and    columns `return` and `returns`, limited to 15. If a scan lacks one of them, the returns are
//   number of returns    counted, and the header says so (global encoding, bit 3)
//   classification       class ids of the ontology that is exported, up to 255, not ASPRS's own; their names are in the
//                        classification lookup record
//   synthetic            set, since the points are simulated
//   withheld             set for points that come from no surface: false positives, weather and stray light, if the
//                        scan has the column `cause`; without a class, they get the one that is named noise
//   GPS time             seconds since the start of the sequence: the point's time if the scan has the column `time`,
//                        else the scan's time. The global encoding says GPS week time, but the time belongs to no week
//   scan angle           about the vehicle's direction of travel from straight down, positive to the right
//   point source ID      the number of the strip, from 1: each sensor of each sequence
//   extra bytes          the other columns in their own types, the unscaled intensity as `intensity_f`, and the
//                        dataset's own class ids as `dataset_label` if another ontology is exported
//
// The coordinate system is local, without a position on the earth. Misses are left out.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/file.h"
#include "base/vec.h"
#include "config/version.h"
#include "dataset/world_positions.h"
#include "exports/layout.h"
#include "formats/little_endian.h"
#include "formats/readers.h"
#include "scan/columns.h"
#include "scan/reasons.h"
#include "scene/ontology.h"

namespace scanmill {

namespace {

constexpr std::uint16_t kMostLasClass = 255;
constexpr double kStep = 0.0005;  // m; coordinates are stored as multiples of the step, relative to the offset

// The values of the header that describe the points.
struct LasPoints {
  static constexpr std::uint8_t kMostReturns = 15;
  static constexpr std::uint16_t kBytes = 30;  // bytes of a point, without extra bytes

  Vec3d offset;  // m, world: subtracted from coordinates before they are stored as steps
  std::uint64_t count = 0;
  std::array<std::uint64_t, kMostReturns> byReturn{};  // number of points that are first returns, second returns, ...
  std::array<std::int32_t, 3> least{}, greatest{};     // bounds of the coordinates (steps); zero if there are no points
  bool returnsAreMadeUp = false;                       // true if return numbers do not come from the sensor
};

// A column that is stored after the fields of the point format.
struct LasExtra {
  std::string_view name;  // at most 32 characters
  std::uint8_t type;      // number of the type in the descriptor
  std::size_t bytes;
  std::string_view unit;  // may be empty
};

constexpr std::uint16_t kHeaderBytes = 375;
constexpr std::uint8_t kFormat = 6;
constexpr std::uint16_t kReturnsAreMadeUp = 1 << 3;  // bit of the global encoding: return numbers are synthetic
constexpr std::uint16_t kCoordinatesAreWkt = 1 << 4;

// A local coordinate system without a position on the earth, in the notation of "OpenGIS Implementation Specification:
// Coordinate Transformation Services", OGC 01-009, 7.2, in which a local datum may have the types 10000 to 32767. The z
// axis is left out, because PROJ, which most readers use, refuses a local system with three axes.
constexpr std::string_view kCoordinateSystem =
    R"(LOCAL_CS["scanmill world",LOCAL_DATUM["scanmill world",32767],UNIT["metre",1],AXIS["x",EAST],AXIS["y",NORTH]])";

// Appends a text as a field of `length` bytes: truncated, or padded with zeros.
void putText(std::string text, std::size_t length, std::string& bytes) {
  text.resize(length, '\0');
  bytes += text;
}

void putRecord(const char* user, std::uint16_t id, const char* description, std::string_view data, std::string& bytes) {
  putNumber(std::uint16_t{0}, bytes);
  putText(user, 16, bytes);
  putNumber(id, bytes);
  putNumber(static_cast<std::uint16_t>(data.size()), bytes);
  putText(description, 32, bytes);
  bytes += data;
}

// Returns the classification lookup: 256 entries of 16 bytes, each with a class id and 15 characters of the class's
// name.
std::string classNames(const Ontology& classes) {
  std::string bytes;
  for (std::uint16_t id = 0; id <= kMostLasClass; ++id) {
    const SemanticClass* const semantic = classes.find(id);
    putNumber(static_cast<std::uint8_t>(id), bytes);
    putText(semantic == nullptr ? "" : semantic->name, 15, bytes);
  }
  return bytes;
}

// Returns the descriptors of the extra bytes, 192 bytes for each column.
std::string descriptors(std::span<const LasExtra> extra) {
  std::string bytes;
  for (const LasExtra& column : extra) {
    putNumber(std::uint16_t{0}, bytes);
    putNumber(column.type, bytes);
    putNumber(std::uint8_t{0}, bytes);  // options: no value for "no data", no range, no scale and no offset
    putText(std::string(column.name), 32, bytes);
    bytes.append(4 + 5 * 24, '\0');  // unused fields: no data, minimum, maximum, scale and offset
    putText(column.unit.empty() ? "" : fmt::format("unit: {}", column.unit), 32, bytes);
  }
  return bytes;
}

// Returns the header and the variable length records: the coordinate system, the names of classes with ids up to 255,
// and the columns in `extra`.
std::string lasHead(const LasPoints& points, std::span<const LasExtra> extra, const Ontology& classes) {
  std::string records;
  putRecord("LASF_Projection", 2112, "coordinate system, WKT", std::string(kCoordinateSystem) + '\0', records);
  putRecord("LASF_Spec", 0, "classification lookup", classNames(classes), records);
  if (!extra.empty()) putRecord("LASF_Spec", 4, "extra bytes", descriptors(extra), records);
  std::size_t pointBytes = LasPoints::kBytes;
  for (const LasExtra& column : extra) pointBytes += column.bytes;

  std::string bytes = "LASF";
  putNumber(std::uint16_t{0}, bytes);  // file source ID: none
  putNumber(static_cast<std::uint16_t>(kCoordinatesAreWkt | (points.returnsAreMadeUp ? kReturnsAreMadeUp : 0)), bytes);
  bytes.append(16, '\0');  // project ID: none
  putNumber(std::uint8_t{1}, bytes);
  putNumber(std::uint8_t{4}, bytes);
  putText("SIMULATION", 32, bytes);
  putText(fmt::format("scanmill {}", kVersion), 32, bytes);
  putNumber(std::uint16_t{1}, bytes);  // day and year of creation: mandatory, but always 2000-01-01
  putNumber(std::uint16_t{2000}, bytes);
  putNumber(kHeaderBytes, bytes);
  putNumber(static_cast<std::uint32_t>(kHeaderBytes + records.size()), bytes);
  putNumber(static_cast<std::uint32_t>(extra.empty() ? 2 : 3), bytes);
  putNumber(kFormat, bytes);
  putNumber(static_cast<std::uint16_t>(pointBytes), bytes);
  bytes.append(4 + 5 * 4, '\0');  // counts of points as in earlier versions: 0
  for (int axis = 0; axis < 3; ++axis) putNumber(kStep, bytes);
  const std::array<double, 3> offset{points.offset.x, points.offset.y, points.offset.z};
  for (const double coordinate : offset) putNumber(coordinate, bytes);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto coordinateOf = [&](std::int32_t steps) { return points.count == 0 ? 0 : steps * kStep + offset[axis]; };
    putNumber(coordinateOf(points.greatest[axis]), bytes);
    putNumber(coordinateOf(points.least[axis]), bytes);
  }
  putNumber(std::uint64_t{0}, bytes);  // start of the waveform data: none
  putNumber(std::uint64_t{0}, bytes);  // start of the extended records after the points: none
  putNumber(std::uint32_t{0}, bytes);
  putNumber(points.count, bytes);
  for (const std::uint64_t count : points.byReturn) putNumber(count, bytes);
  return bytes + records;
}

// Bits of the classification flags.
constexpr std::uint8_t kSynthetic = 1;
constexpr std::uint8_t kWithheld = 4;

constexpr ColumnKey<columnIndex("returns")> kReturns;

// Returns, for each point, its return number in the lower four bits and the number of returns of its beam in the upper
// four; 0 for a miss. If the scan lacks the column `return` or `returns`, but knows the beam of each point, the points
// of each beam are counted, in the order of the scan, which is the order of the beam's returns.
std::vector<std::uint8_t> returnNumbers(const Scan& scan) {
  const bool counts = (scan[kReturn].empty() || scan[kReturns].empty()) && knowsBeams(scan);
  const PointKey extent = counts ? extentOf(scan) : PointKey{};
  const auto beamOf = [&](std::size_t point) {
    const PointKey key = keyOf(scan, point);
    return std::size_t{key.ring} * extent.column + key.column;
  };
  std::vector<std::uint32_t> points(std::size_t{extent.ring} * extent.column);  // by beam
  for (std::size_t i = 0; counts && i < scan.size(); ++i) {
    if (isFinite(scan.position[i])) ++points[beamOf(i)];
  }
  std::vector<std::uint32_t> visitedPoints(points.size());  // by beam
  std::vector<std::uint8_t> numbers(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    std::uint32_t number = counts ? ++visitedPoints[beamOf(i)] : 1;
    std::uint32_t returns = counts ? points[beamOf(i)] : 1;
    if (!scan[kReturn].empty()) number = scan[kReturn][i];
    if (!scan[kReturns].empty()) returns = scan[kReturns][i];
    number = std::clamp<std::uint32_t>(number, 1, LasPoints::kMostReturns);
    returns = std::clamp<std::uint32_t>(returns, number, LasPoints::kMostReturns);
    numbers[i] = static_cast<std::uint8_t>(number | returns << 4);
  }
  return numbers;
}

// Appends X, Y and Z of a point at `position` (m, world), and extends the bounds in `points`. Throws InputError if a
// coordinate is NaN or does not fit into 32 bits.
void putPosition(const ExportPlan& plan, const ExportSample& sample, const ExportScan& exportScan,
                 const Vec3d& position, LasPoints& points, std::string& bytes) {
  const Vec3d unrounded = (position - points.offset) * (1 / kStep);
  std::size_t axis = 0;
  for (const double coordinate : {unrounded.x, unrounded.y, unrounded.z}) {
    if (!(std::fabs(coordinate) < std::numeric_limits<std::int32_t>::max())) {
      refuse(plan,
             "the sample {} has a point of the sensor '{}' more than 1000 km away, which LAS "
             "cannot store in steps of {} m: check the dataset with scanmill verify",
             sample.record->key, exportScan.sensor->name, kStep);
    }
    const auto steps = static_cast<std::int32_t>(std::lround(coordinate));
    putNumber(steps, bytes);
    points.least[axis] = points.count == 0 ? steps : std::min(points.least[axis], steps);
    points.greatest[axis] = points.count == 0 ? steps : std::max(points.greatest[axis], steps);
    ++axis;
  }
}

// Returns the scan angle (steps of 0.006 deg) of a point `ray` (m, world) from its sensor: the angle about the
// direction of travel from straight down, positive to the right (15.3.11 of the specification).
std::int16_t scanAngle(const Vec3d& ray, const Vec3d& forward) {
  const double right = ray.x * forward.y - ray.y * forward.x;
  return static_cast<std::int16_t>(std::lround(degrees(std::atan2(right, -ray.z)) / 0.006));
}

// Returns the horizontal unit vector to the front of the vehicle.
Vec3d forwardOf(const ExportScan& exportScan) {
  const Pose vehicleFromSensor = mountOf(*exportScan.sensor, *exportScan.record);
  const Vec3d front =
      toMatrix((exportScan.record->worldFromSensor.front() * inverse(vehicleFromSensor)).rotation) * Vec3d{1, 0, 0};
  const double ahead = std::hypot(front.x, front.y);
  return ahead > 1e-9 ? Vec3d{front.x / ahead, front.y / ahead, 0} : Vec3d{1, 0, 0};
}

// The file of a strip while it is written.
class Strip {
 public:
  Strip(const ExportPlan& plan, const std::filesystem::path& path, const ExportScan& first, std::size_t number)
      : plan_(plan), file_(path), number_(static_cast<std::uint16_t>(number)) {
    const Vec3d& sensor = first.record->worldFromSensor.front().translation;
    points_.offset = {std::round(sensor.x), std::round(sensor.y), std::round(sensor.z)};
    const ColumnSet columns = exportedColumns(plan, first.scan);
    points_.returnsAreMadeUp = !columns.has(kReturn) || !columns.has(kReturns);
    // Extra bytes have the columns that no field of the point format represents completely.
    extraColumns_ = columns.without(kReturn).without(kReturns).without(kTime);
    if (plan.classes.target().name == plan.manifest.ontology.name) extraColumns_ = extraColumns_.without(kLabel);
    if (const SemanticClass* const noise = plan.classes.target().find("noise")) noiseClass_ = noise->id;
    visitTable(first.scan, [&]<class T>(auto key, const std::vector<T>&) {
      // The type numbers of float, unsigned char, unsigned short and unsigned long in table 24 of the specification.
      constexpr std::uint8_t kType = std::is_floating_point_v<T> ? 9 : sizeof(T) == 1 ? 1 : sizeof(T) == 2 ? 3 : 5;
      if (!extraColumns_.has(key)) return;
      const std::string_view name = key.index == kIntensity.index ? kLasExactIntensity
                                    : key.index == kLabel.index   ? "dataset_label"
                                                                  : key.row.name;
      extra_.push_back({name, kType, sizeof(T), key.row.unit});
    });
    file_.write(lasHead(points_, extra_, plan.classes.target()));
  }

  void add(const ExportSample& sample, const ExportScan& exportScan) {
    const Scan& scan = exportScan.scan;
    requireConsistent(scan);
    const WorldPositions positions(scan, *exportScan.record, exportScan.sensor->beams, plan_.manifest.deskewed);
    const Vec3d forward = forwardOf(exportScan);
    const std::vector<std::uint8_t> returns = returnNumbers(scan);
    std::string bytes;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (!isFinite(scan.position[i])) continue;
      const Pose worldFromPoint = positions.poseOf(i);
      const Vec3d position = worldFromPoint * Vec3d(scan.position[i]);
      putPosition(plan_, sample, exportScan, position, points_, bytes);
      const float intensity = unitIntensity(exportScan, i);
      putNumber(static_cast<std::uint16_t>(intensity > 0 ? std::lround(std::min(intensity, 1.0f) * 65535) : 0), bytes);
      putNumber(returns[i], bytes);
      const auto cause = scan[kCause].empty() ? Reason::Surface : static_cast<Reason>(scan[kCause][i]);
      const bool isNoise = cause == Reason::FalsePositive || cause == Reason::Weather || cause == Reason::StrayLight;
      const std::uint16_t label = scan[kLabel].empty() ? 0 : plan_.classes.targetId(scan[kLabel][i]);
      putNumber(static_cast<std::uint8_t>(kSynthetic | (isNoise ? kWithheld : 0)), bytes);
      putNumber(static_cast<std::uint8_t>(isNoise && label == 0 ? noiseClass_ : label), bytes);
      putNumber(std::uint8_t{0}, bytes);  // user data
      putNumber(scanAngle(position - worldFromPoint.translation, forward), bytes);
      putNumber(number_, bytes);
      putNumber(exportScan.record->time + (scan[kTime].empty() ? 0 : double{scan[kTime][i]}), bytes);
      visitTable(scan, [&](auto key, const auto& values) {
        if (!extraColumns_.has(key)) return;
        putNumber(key.index == kLabel.index ? values[i] : exported(plan_.classes, key, values[i]), bytes);
      });
      ++points_.byReturn[(returns[i] & 0x0F) - 1u];
      ++points_.count;
    }
    file_.write(bytes);
  }

  void commit() {
    file_.rewriteStart(lasHead(points_, extra_, plan_.classes.target()));
    file_.commit();
  }

 private:
  const ExportPlan& plan_;
  AtomicFile file_;
  std::uint16_t number_;          // the point source ID
  std::uint16_t noiseClass_ = 0;  // of points that come from no surface
  LasPoints points_;
  ColumnSet extraColumns_;
  std::vector<LasExtra> extra_;
};

// Throws InputError if an exported scan of the sample has points of a class whose id LAS cannot store.
void checkClasses(const ExportPlan& plan, const SampleRecord& sample) {
  for (const ScanRecord& scan : sample.scans) {
    const bool isExported = std::ranges::find(plan.sensors, scan.sensor, &SensorRecord::name) != plan.sensors.end();
    for (const auto& [id, points] : scan.pointsPerClass) {
      const std::uint16_t target = plan.classes.targetId(id);
      if (!isExported || points == 0 || target <= kMostLasClass) continue;
      refuse(plan,
             "the sample {} has points of the class {} with the id {}, but LAS stores ids up "
             "to {}: give an ontology of smaller ids with --classes FILE",
             sample.key, plan.classes.classOf(id).name, target, kMostLasClass);
    }
  }
}

class Las : public ExportLayout {
 public:
  void check(const ExportPlan& plan) const override {
    for (const ExportSequence& sequence : plan.sequences) {
      for (const std::size_t number : sequence.samples) checkClasses(plan, plan.manifest.samples[number]);
    }
  }

  bool bySequence() const override { return true; }

  void write(const ExportPlan& plan, std::size_t sequence, std::size_t, const ReadSample& read,
             const ExportFolder& folder) const override {
    const ExportSequence& recorded = plan.sequences[sequence];
    std::vector<std::unique_ptr<Strip>> strips(plan.sensors.size());  // null: no scan of the sensor so far
    for (std::size_t frame = 0; frame < recorded.samples.size(); ++frame) {
      const ExportSample sample = read(sequence, frame);
      for (const ExportScan& scan : sample.scans) {
        std::unique_ptr<Strip>& strip = strips[scan.sensorNumber];
        if (strip == nullptr) {
          const std::string file = fmt::format("{}.{}.las", recorded.name, scan.sensor->name);
          const std::size_t number = 1 + sequence * plan.sensors.size() + scan.sensorNumber;
          strip = std::make_unique<Strip>(plan, folder.prepareFile(std::filesystem::path(recorded.split) / file), scan,
                                          number);
        }
        strip->add(sample, scan);
      }
    }
    for (const auto& strip : strips) {
      if (strip != nullptr) strip->commit();
    }
  }
};

}  // namespace

std::unique_ptr<ExportLayout> makeLas() {
  return std::make_unique<Las>();
}

}  // namespace scanmill
