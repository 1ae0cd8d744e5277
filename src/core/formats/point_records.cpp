#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "config/text.h"
#include "formats/npy.h"
#include "formats/readers.h"

namespace scanmill {

static_assert(std::endian::native == std::endian::little, "records are read as they lie");

namespace {

constexpr float kFarthest = 1e5f;  // m, largest absolute value of a coordinate

template <class T>
std::vector<T> valuesOf(std::string_view bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

// Returns the azimuth of each point (rad); a miss has the azimuth of the point before it.
std::vector<double> azimuthsOf(const std::vector<Vec3f>& points) {
  std::vector<double> azimuths;
  for (const Vec3f& p : points) {
    const double before = azimuths.empty() ? 0 : azimuths.back();
    azimuths.push_back(isFinite(p) ? std::atan2(double{p.y}, double{p.x}) : before);
  }
  return azimuths;
}

// Returns the index of the first point of each ring. Assumes that each ring is a turn from straight ahead. A new ring
// begins where the azimuth crosses straight ahead after at least half a turn, so that points slightly out of order near
// this azimuth begin no further rings.
std::vector<std::size_t> ringStarts(const std::vector<double>& azimuths) {
  double sum = 0;  // rad, of the steps from point to point
  for (std::size_t i = 1; i < azimuths.size(); ++i) sum += wrapped(azimuths[i] - azimuths[i - 1]);
  const double direction = sum < 0 ? -1 : 1;  // 1: counter-clockwise
  std::vector<std::size_t> starts{0};
  double turned = 0;  // rad since the start of the ring
  for (std::size_t i = 1; i < azimuths.size(); ++i) {
    turned += direction * wrapped(azimuths[i] - azimuths[i - 1]);
    const bool crossesZero =
        direction * azimuths[i - 1] < 0 && direction * azimuths[i] >= 0 && std::fabs(azimuths[i]) < kPi / 2;
    if (!crossesZero || turned <= kPi) continue;
    starts.push_back(i);
    turned = 0;
  }
  return starts;
}

// Returns the median elevation (rad) of the points [first, last); nothing if all of them are misses.
std::optional<double> medianElevation(const std::vector<Vec3f>& points, std::size_t first, std::size_t last) {
  std::vector<double> elevations;
  for (std::size_t i = first; i < last; ++i) {
    const Vec3d p(points[i]);
    if (isFinite(p)) elevations.push_back(std::atan2(p.z, std::hypot(p.x, p.y)));
  }
  if (elevations.empty()) return std::nullopt;
  const auto middle = elevations.begin() + static_cast<std::ptrdiff_t>(elevations.size() / 2);
  std::nth_element(elevations.begin(), middle, elevations.end());
  return *middle;
}

// Returns the ring of each point, if the points are ordered by ring from the top; empty for other orders.
std::vector<std::uint16_t> ringsByOrder(const std::vector<Vec3f>& points) {
  constexpr std::size_t kFewest = 8, kMost = 256;
  constexpr double kOrdered = 0.9;  // least fraction of rings whose median elevation is below the previous ring's
  std::vector<std::size_t> starts = ringStarts(azimuthsOf(points));
  const std::size_t count = starts.size();
  if (count < kFewest || count > kMost) return {};
  starts.push_back(points.size());
  std::vector<std::uint16_t> rings;
  std::size_t descending = 0;  // number of rings below the ring before
  double previous = 0;         // rad, median elevation of the ring above
  for (std::size_t ring = 0; ring < count; ++ring) {
    rings.resize(starts[ring + 1], static_cast<std::uint16_t>(ring));
    const std::optional<double> elevation = medianElevation(points, starts[ring], starts[ring + 1]);
    if (!elevation) return {};
    if (ring > 0 && *elevation < previous) ++descending;
    previous = *elevation;
  }
  if (static_cast<double>(descending) < kOrdered * static_cast<double>(count - 1)) return {};
  return rings;
}

void requireOneEach(std::size_t labels, const Scan& scan, const std::string& what) {
  if (labels != scan.size()) {
    throw InputError({what}, "has {} labels; its scan has {} points", labels, scan.size());
  }
}

}  // namespace

const FormatSupport kPointRecordsFormat{
    "KITTI, SemanticKITTI and nuScenes", ".bin, .pcd.bin",
    "float32: x, y, z, intensity in .bin, and ring in .pcd.bin; points with NaN or infinite coordinates are misses. "
    "Classes and instances of SemanticKITTI (labels/*.label, beside velodyne/), and of nuScenes where lidarseg.json "
    "and panoptic.json name their files. Poses, times and boxes count for nothing: recorded scans stay in the frame "
    "of their sensor"};

std::size_t numbersOfRecord(const std::filesystem::path& file) {
  if (lowerExtension(file) != ".bin") return 0;
  return lowerExtension(file.stem()) == ".pcd" ? 5 : 4;
}

Scan readPointRecords(std::string_view bytes, std::size_t numbers, const std::string& what) {
  constexpr double kMostInvalid = 0.05;  // largest fraction of invalid intensities in a file of records
  const bool hasRing = numbers == 5;
  const std::string record = hasRing ? "x, y, z, intensity, ring" : "x, y, z, intensity";
  if (bytes.size() % (numbers * sizeof(float)) != 0) {
    throw InputError({what}, "has {} bytes, which are no whole records of {} float32 ({})", bytes.size(), numbers,
                     record);
  }
  const std::string advice = fmt::format(
      ": these are no records of {} float32 ({}); {}convert others, such as 6, by numpy.fromfile(a, "
      "'f4').reshape(-1, 6)[:, :4].tofile(b)",
      numbers, record, hasRing ? "" : "if they have 5 (x, y, z, intensity, ring), name the file .pcd.bin; ");
  const std::vector<float> values = valuesOf<float>(bytes);
  Scan scan;
  std::size_t invalidIntensities = 0;
  std::size_t misses = 0;
  for (std::size_t first = 0; first < values.size(); first += numbers) {
    const Vec3f p{values[first], values[first + 1], values[first + 2]};
    const bool isMiss = !isFinite(p);
    if (!isMiss && std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)}) > kFarthest) {
      throw InputError({what}, "point {} lies at {}, {}, {}{}", first / numbers, p.x, p.y, p.z, advice);
    }
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    const float intensity = isMiss ? 0 : values[first + 3];
    scan.position.push_back(isMiss ? Vec3f{kNaN, kNaN, kNaN} : p);
    scan[kIntensity].push_back(intensity);
    misses += isMiss ? 1u : 0u;
    invalidIntensities += intensity >= 0 ? 0u : 1u;  // also NaN
    if (!hasRing) continue;
    const float ring = isMiss ? 0 : values[first + 4];
    if (!(ring >= 0 && ring <= 65535) || ring != std::floor(ring)) {
      throw InputError({what}, "the ring of point {} is {}: no whole number from 0", first / numbers, ring);
    }
    scan[kRing].push_back(static_cast<std::uint16_t>(ring));
  }
  if (misses > 0 && misses == scan.size()) {
    throw InputError({what}, "no coordinate of a point is finite{}", advice);
  }
  if (static_cast<double>(invalidIntensities) > kMostInvalid * static_cast<double>(scan.size())) {
    throw InputError({what}, "{} of {} intensities are below 0 or no numbers{}", invalidIntensities, scan.size(),
                     advice);
  }
  if (!hasRing) scan[kRing] = ringsByOrder(scan.position);
  if (!scan[kRing].empty()) scan.rings = std::ranges::max(scan[kRing]) + 1u;
  return scan;
}

void addSemanticKittiLabels(std::string_view bytes, const std::string& what, Scan& scan) {
  if (bytes.size() % sizeof(std::uint32_t) != 0) throw InputError({what}, "is no list of uint32");
  const std::vector<std::uint32_t> values = valuesOf<std::uint32_t>(bytes);
  requireOneEach(values.size(), scan, what);
  for (const std::uint32_t value : values) {
    scan[kLabel].push_back(static_cast<std::uint16_t>(value & 0xffff));
    scan[kInstance].push_back(value >> 16);
  }
}

void addLidarsegLabels(std::string_view bytes, const std::string& what, Scan& scan) {
  requireOneEach(bytes.size(), scan, what);
  for (const char c : bytes) scan[kLabel].push_back(static_cast<unsigned char>(c));
}

void addPanopticLabels(std::string_view bytes, const std::string& what, Scan& scan) {
  constexpr std::uint32_t kClassStep = 1000;
  const std::vector<NpyArray> arrays = readNpzArrays(bytes, what);
  const auto data = std::ranges::find(arrays, "data", &NpyArray::name);
  if (data == arrays.end() || data->type != "<u2") throw InputError({what}, "has no array `data` of uint16");
  const auto values = valuesOf<std::uint16_t>(data->bytes);
  requireOneEach(values.size(), scan, what);
  const bool addLabels = scan[kLabel].empty();
  for (const std::uint16_t value : values) {
    if (addLabels) scan[kLabel].push_back(static_cast<std::uint16_t>(value / kClassStep));
    scan[kInstance].push_back(value % kClassStep == 0 ? 0u : std::uint32_t{value});
  }
}

std::filesystem::path labelsBeside(const std::filesystem::path& scan) {
  const std::filesystem::path absolute = std::filesystem::absolute(scan);
  if (absolute.parent_path().filename() != "velodyne") return {};
  const std::filesystem::path file =
      scan.parent_path() / ".." / "labels" / std::filesystem::path(scan.filename()).replace_extension(".label");
  return isFile(file) ? file.lexically_normal() : std::filesystem::path();
}

}  // namespace scanmill
