#include "formats/cloud_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "config/resources.h"
#include "config/text.h"
#include "formats/format.h"
#include "formats/ply_file.h"
#include "formats/readers.h"

namespace scanmill {

Vec3d cloudOrigin(const Vec3d& position) {
  constexpr double kNear = 1000;  // m; coordinates with a smaller absolute value get the offset 0
  const auto rounded = [](double d) { return std::fabs(d) < kNear ? 0.0 : std::floor(d); };
  return {rounded(position.x), rounded(position.y), rounded(position.z)};
}

namespace {

// True for the suffixes of point clouds that readCloud() refuses with advice.
bool isUnreadCloud(const std::string& suffix) {
  return suffix == ".e57" || suffix == ".pts" || suffix == ".ptx";
}

// True if a file .asc lists points: its first 4 KiB have a line that begins with three numbers, and no grid keyword.
bool listsPoints(const std::filesystem::path& file) {
  std::string head = lowerCase(firstBytes(file, 4096));
  for (const char* word : {"ncols", "nrows", "rows:", "cols:"}) {
    if (head.find(word) != std::string::npos) return false;
  }
  std::ranges::replace_if(
      head, [](char c) { return c == ',' || c == ';'; }, ' ');
  std::istringstream lines(head);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    Vec3d point;
    if (cells >> point.x >> point.y >> point.z) return true;
  }
  return false;
}

}  // namespace

bool isCloud(const std::filesystem::path& file) {
  const std::string suffix = lowerExtension(file);
  if (suffix == ".las" || suffix == ".laz" || suffix == ".xyz" || isUnreadCloud(suffix)) return true;
  if (suffix == ".asc") return listsPoints(file);
  if (suffix != ".ply") return !suffix.empty() && formatBySuffix(suffix.substr(1)) != nullptr;
  if (!isFile(file) || std::filesystem::file_size(file) == 0) return false;
  const PlyHeader header = readPlyHeader(file);
  return std::ranges::none_of(
      header.elements, [](const PlyElement& e) { return (e.name == "face" || e.name == "tristrips") && e.count > 0; });
}

bool isScan(const std::filesystem::path& file) {
  const std::string suffix = lowerExtension(file);
  return numbersOfRecord(file) > 0 || suffix == ".npz" || (!isUnreadCloud(suffix) && isCloud(file));
}

std::string scanSuffixes() {
  std::string list;
  for (const FormatEntry& f : formats()) list += fmt::format(".{}, ", f.suffix);
  return list + ".xyz, .asc, .las, .ply, .bin, .pcd.bin";
}

Cloud readCloud(const std::filesystem::path& file, CloudUnit unit) {
  const InputBudget budget;
  const std::string suffix = lowerExtension(file);
  const std::string name = file.string();
  if (suffix == ".ply") return readPly(file);
  if (isUnreadCloud(suffix)) {
    throw InputError({name},
                     "is a cloud of the kind {}, which is not read: convert it, by `pdal translate "
                     "a{} a.las` or by CloudCompare into LAS, PLY or PCD",
                     suffix, suffix);
  }
  if (suffix == ".npz") {
    throw InputError({name},
                     "is an archive of NumPy, which is not read: write its points as text, by "
                     "numpy.savetxt('a.csv', points, delimiter=',', header='x,y,z,label', comments='')");
  }
  const std::string bytes = readFile(file);
  if (suffix == ".las" || suffix == ".laz") return readLas(bytes, name, unit);
  if (suffix == ".pcd") return readPcd(bytes, name);
  if (suffix == ".csv" || suffix == ".xyz" || suffix == ".asc") return readCsv(bytes, name);
  if (const std::size_t numbers = numbersOfRecord(file); numbers > 0) {
    Cloud cloud{{}, readPointRecords(bytes, numbers, name)};
    if (const auto labels = labelsBeside(file); !labels.empty()) {
      addSemanticKittiLabels(readFile(labels), labels.string(), cloud.scan);
    }
    return cloud;
  }
  const FormatEntry* const format = suffix.empty() ? nullptr : formatBySuffix(suffix.substr(1));
  if (format == nullptr) {
    throw InputError({name}, "is no scan of a known kind: {} are read", scanSuffixes());
  }
  const Value none;
  Fields options(none, "format");
  return {{}, format->make(options)->decode(bytes, name)};
}

Scan scanOf(Cloud cloud, const std::string& what) {
  cloud.leftOut.warn(what);
  return std::move(cloud.scan);
}

}  // namespace scanmill
