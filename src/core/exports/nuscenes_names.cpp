#include "exports/nuscenes_names.h"

#include <fmt/core.h>

#include <cctype>
#include <chrono>
#include <cmath>

#include "base/hash.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::sys_days kFirstDay = std::chrono::year{2020} / 1 / 1;
constexpr std::int64_t kMicroseconds = 1'000'000;  // microseconds per second

std::chrono::sys_days dayOf(std::size_t sequence) {
  return kFirstDay + std::chrono::days(sequence);
}

}  // namespace

std::string nuScenesToken(const ExportPlan& plan, std::string_view table, std::string_view row) {
  return sha256(fmt::format("{}\n{}\n{}", plan.manifest.name, table, row)).substr(0, 32);
}

std::int64_t nuScenesTime(std::size_t sequence, const ScanRecord& scan) {
  const std::chrono::seconds midnight = dayOf(sequence).time_since_epoch();
  return midnight.count() * kMicroseconds + std::llround(scan.time * kMicroseconds);
}

std::string nuScenesDate(std::size_t sequence) {
  const std::chrono::year_month_day day = dayOf(sequence);
  return fmt::format("{:04}-{:02}-{:02}", int{day.year()}, unsigned{day.month()}, unsigned{day.day()});
}

std::string nuScenesChannel(const ExportPlan& plan, std::size_t sensor) {
  if (sensor == 0) return "LIDAR_TOP";
  std::string channel = "LIDAR_" + plan.sensors[sensor]->name;
  for (char& c : channel)
    c = std::isalnum(static_cast<unsigned char>(c)) == 0 ? '_' : static_cast<char>(std::toupper(c));
  return channel == "LIDAR_TOP" ? "LIDAR_TOP_2" : channel;
}

std::string nuScenesScan(const ExportPlan& plan, const SampleRecord& sample, std::size_t sensor,
                         std::uint32_t revolution) {
  const std::string key = sensor == 0 ? sample.key : sample.key + " " + plan.sensors[sensor]->name;
  return revolution == 0 ? key : fmt::format("{}\n{}", key, revolution);
}

fs::path pointsFile(const ExportPlan& plan, std::size_t sequence, const SampleRecord& sample, std::size_t sensor,
                    const ScanRecord& scan) {
  const std::string channel = nuScenesChannel(plan, sensor);
  return fs::path(scan.revolution == 0 ? "samples" : "sweeps") / channel /
         fmt::format("{}__{}__{}.pcd.bin", sample.key, channel, nuScenesTime(sequence, scan));
}

fs::path labelFile(const ExportPlan& plan, const SampleRecord& sample, std::size_t sensor, NuScenesLabels kind) {
  const bool isPanoptic = kind == NuScenesLabels::Panoptic;
  const std::string folder = isPanoptic ? "panoptic" : "lidarseg";
  // The devkit finds the file by the scan's token, with which the file's name starts.
  const std::string token = nuScenesToken(plan, "sample_data", nuScenesScan(plan, sample, sensor));
  return fs::path(folder) / kNuScenesVersion / fmt::format("{}_{}.{}", token, folder, isPanoptic ? "npz" : "bin");
}

}  // namespace scanmill
