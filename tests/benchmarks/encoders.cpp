// Encoders: points/s of one core, bytes a point and largest error, beside what the libraries' own encoders do with the
// same scan in the same run. The scan is a street of walls, cars and poles from 64 x 2048 beams, with range noise of
// 10 mm; "firing" order is column by column, "image" order is ring by ring.

#include <benchmark/benchmark.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>

#include "base/random.h"
#include "formats/format.h"
#include "tests/benchmarks/bare_draco.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kRings = 64;
constexpr std::uint32_t kColumns = 2048;
constexpr double kNoise = 0.01;

struct Return {
  double range = 120;  // m; nothing is seen beyond
  std::uint16_t label = 0;
  std::uint32_t instance = 0;
};

void meetBox(const Vec3d& direction, const Vec3d& low, const Vec3d& high, Return found, Return& nearest) {
  double enter = 0.5;
  double leave = nearest.range;
  const auto slab = [&](double first, double second, double slope) {
    enter = std::max(enter, std::min(first / slope, second / slope));
    leave = std::min(leave, std::max(first / slope, second / slope));
  };
  slab(low.x, high.x, direction.x);
  slab(low.y, high.y, direction.y);
  slab(low.z, high.z, direction.z);
  if (enter >= leave) return;
  nearest = found;
  nearest.range = enter;
}

Return look(const Vec3d& direction) {
  Return nearest;
  meetBox(direction, {-200, -200, -3}, {200, 200, -1.8}, {0, 1, 0}, nearest);
  meetBox(direction, {-200, 4, -3}, {200, 9, -1.65}, {0, 2, 0}, nearest);
  for (int k = 0; k < 40; ++k) {
    const Vec3d house{-160.0 + 8 * k, k % 2 == 0 ? -9.0 - k % 3 : 11.0 + k % 5, 0};
    meetBox(direction, house - Vec3d{7.5, k % 2 == 0 ? 8.0 : 0.0, 3}, house + Vec3d{7.5, k % 2 == 0 ? 0.0 : 8.0, 8},
            {0, 3, 0}, nearest);
    const Vec3d car{-100 + 5.1 * k, k % 2 == 0 ? -4.5 : 5.5, -1.05};
    meetBox(direction, car - Vec3d{2.1, 0.9, 0.75}, car + Vec3d{2.1, 0.9, 0.75},
            {0, 4, static_cast<std::uint32_t>(k + 1)}, nearest);
    const Vec3d pole{-98 + 5.1 * k, k % 2 == 0 ? 8.0 : -7.0, 1};
    meetBox(direction, pole - Vec3d{0.1, 0.1, 3}, pole + Vec3d{0.1, 0.1, 3},
            {0, 5, static_cast<std::uint32_t>(k + 100)}, nearest);
  }
  return nearest;
}

void addBeam(std::uint32_t ring, std::uint32_t column, Scan& scan) {
  const double elevation = radians(2 - 26.8 * ring / (kRings - 1));
  const double azimuth = 1e-4 - 2 * kPi * column / kColumns;
  const Vec3d direction{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                        std::sin(elevation)};
  const Return met = look(direction);
  if (met.label == 0) return;
  const RandomBlock random = randomBlock({.seed = 5, .beam = ring * kColumns + column});
  const double gauss =
      std::sqrt(-2 * std::log(uniform(random[0]))) * std::cos(2 * kPi * uniform(random[1]));  // Box and Muller
  scan.position.push_back(Vec3f(direction * (met.range + kNoise * gauss)));
  scan[kIntensity].push_back(
      static_cast<float>(std::floor(255 * std::min(1.0, (0.2 + 0.1 * met.label) * 20 / (met.range * met.range)))));
  scan[kLabel].push_back(met.label);
  scan[kInstance].push_back(met.instance);
  scan[kRing].push_back(static_cast<std::uint16_t>(ring));
  scan[kColumn].push_back(static_cast<std::uint16_t>(column));
  scan[kTime].push_back(0.1f * static_cast<float>(column) / kColumns);
}

Scan makeStreet(bool firingOrder) {
  Scan scan;
  scan.rings = kRings;
  scan.columns = kColumns;
  for (std::uint32_t i = 0; i < kRings * kColumns; ++i) {
    if (firingOrder) {
      addBeam(i % kRings, i / kRings, scan);
    } else {
      addBeam(i / kColumns, i % kColumns, scan);
    }
  }
  return scan;
}

const Scan& street(bool firingOrder) {
  static const Scan kFiring = makeStreet(true);
  static const Scan kImage = makeStreet(false);
  return firingOrder ? kFiring : kImage;
}

double largestError(const Scan& scan, const Scan& read) {
  double worst = scan.size() == read.size() ? 0 : INFINITY;
  for (std::size_t i = 0; i < std::min(scan.size(), read.size()); ++i) {
    worst = std::max(worst, length(Vec3d(scan.position[i]) - Vec3d(read.position[i])));
  }
  return worst;
}

void report(benchmark::State& state, const Scan& scan, std::size_t bytes, double error) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scan.size()));
  state.counters["B/point"] = static_cast<double>(bytes) / static_cast<double>(scan.size());
  state.counters["error_mm"] = error * 1e3;
}

std::unique_ptr<Format> makeFormat(const std::string& name, const std::string& options) {
  const Value value = parseYaml(options, "benchmark");
  Fields fields(value, name);
  return requireFormat(name, {}).make(fields);
}

void encode(benchmark::State& state, const std::string& name, const std::string& options, bool firingOrder) {
  const Scan& scan = street(firingOrder);
  const auto format = makeFormat(name, options);
  std::string bytes;
  for (auto _ : state) {
    bytes = format->encode(scan);
    benchmark::DoNotOptimize(bytes.data());
  }
  report(state, scan, bytes.size(), largestError(scan, format->decode(bytes, name)));
}

void decode(benchmark::State& state, const std::string& name, const std::string& options, bool firingOrder) {
  const Scan& scan = street(firingOrder);
  const auto format = makeFormat(name, options);
  const std::string bytes = format->encode(scan);
  Scan read;
  for (auto _ : state) {
    read = format->decode(bytes, name);
    benchmark::DoNotOptimize(read.position.data());
  }
  report(state, scan, bytes.size(), largestError(scan, read));
}

void bareDraco(benchmark::State& state, bool firingOrder) {
  const Scan& scan = street(firingOrder);
  std::string bytes;
  for (auto _ : state) bytes = bareDracoBytes(scan);
  report(state, scan, bytes.size(), largestError(scan, makeFormat("draco", "{}")->decode(bytes, "bare")));
}

pcl::PCLPointCloud2 asPclCloud(const Scan& scan) {
  TemporaryFolder folder;
  const auto file = folder.write("scan.pcd", makeFormat("pcd", "encoding: binary")->encode(scan));
  pcl::PCLPointCloud2 cloud;
  pcl::PCDReader().read(file.string(), cloud);
  return cloud;
}

void pclCompressed(benchmark::State& state, bool firingOrder) {
  const Scan& scan = street(firingOrder);
  const pcl::PCLPointCloud2 cloud = asPclCloud(scan);
  std::size_t bytes = 0;
  for (auto _ : state) {
    std::ostringstream out;
    pcl::PCDWriter().writeBinaryCompressed(out, cloud);
    bytes = static_cast<std::size_t>(out.tellp());
  }
  report(state, scan, bytes, 0);
}

// PCL writes rows to files alone; the page cache takes them.
void pclBinary(benchmark::State& state, bool firingOrder) {
  const Scan& scan = street(firingOrder);
  const pcl::PCLPointCloud2 cloud = asPclCloud(scan);
  TemporaryFolder folder;
  const std::string file = (folder.path() / "pcl.pcd").string();
  for (auto _ : state) pcl::PCDWriter().writeBinary(file, cloud);
  report(state, scan, std::filesystem::file_size(file), 0);
}

void copyColumns(benchmark::State& state) {
  const Scan& scan = street(true);
  Scan copy;
  for (auto _ : state) {
    copy = scan;
    benchmark::DoNotOptimize(copy.position.data());
  }
  report(state, scan, scan.size() * 32, 0);
}

void registerAll() {
  for (const bool firing : {true, false}) {
    const std::string order = firing ? "/firing" : "/image";
    const auto add = [&](const std::string& name, auto&& function, auto... arguments) {
      benchmark::RegisterBenchmark((name + order).c_str(), function, arguments..., firing);
    };
    add("encode/draco 1 mm", encode, "draco", "{}");
    add("encode/draco 1 mm speed 0", encode, "draco", "speed: 0");
    add("encode/draco 1 mm speed 5", encode, "draco", "speed: 5");
    add("encode/draco 1 mm time", encode, "draco", "time: true");
    add("encode/draco 10 mm", encode, "draco", "max_error_mm: 10");
    add("encode/draco 0.1 mm", encode, "draco", "max_error_mm: 0.1");
    add("encode/pcd binary_compressed", encode, "pcd", "{}");
    add("encode/pcd binary", encode, "pcd", "encoding: binary");
    add("encode/pcd ascii", encode, "pcd", "encoding: ascii");
    add("encode/csv", encode, "csv", "{}");
    add("bare/draco 1 mm", bareDraco);
    add("bare/pcl binary_compressed", pclCompressed);
    add("bare/pcl binary to a file", pclBinary);
    add("decode/draco 1 mm", decode, "draco", "{}");
    add("decode/draco 1 mm speed 0", decode, "draco", "speed: 0");
    add("decode/pcd binary_compressed", decode, "pcd", "{}");
    add("decode/pcd binary", decode, "pcd", "encoding: binary");
    add("decode/csv", decode, "csv", "{}");
  }
  benchmark::RegisterBenchmark("bare/copy of the columns", copyColumns);
}

[[maybe_unused]] const bool kRegistered = (registerAll(), true);

}  // namespace
}  // namespace scanmill
