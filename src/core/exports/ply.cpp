// Writes a PLY file for each scan (Turk, "The PLY Polygon File Format", 1994; paulbourke.net/dataformats/ply), binary
// and little-endian, which CloudCompare, MeshLab, Blender and Open3D open:
//
//   comment dataset, sample, sensor, time of the scan (s), frame of the points, world_from_sensor (at the first column
//           and, if the sensor moves, at the last), and a line `class ID NAME` for each class
//   element vertex
//     float x, y, z                in the sensor's frame (m)
//     uchar red, green, blue       colour of the class; in a scan without classes grey, by the intensity
//     the scan's columns           under their own names, in their own types
//
// Misses are left out. The points keep the order of the scan.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <type_traits>

#include "exports/layout.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

using Color = std::array<std::uint8_t, 3>;

constexpr std::uint8_t kMiddleGrey = 128;  // grey level of points with neither class nor intensity

// PLY's name of a type. uint16 is the same as ushort, but Open3D skips properties of type ushort.
template <class T>
constexpr std::string_view kPlyType = std::is_floating_point_v<T> ? "float"
                                      : sizeof(T) == 1            ? "uchar"
                                      : sizeof(T) == 2            ? "uint16"
                                                                  : "uint";

// Replaces line breaks by blanks, because a line break would end a comment of the header.
std::string withoutBreaks(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

// Returns the header of a scan's file. `points`: number of points without misses.
std::string header(const ExportPlan& plan, const ExportSample& sample, const ExportScan& exportScan,
                   std::size_t points) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment dataset {}\ncomment sample {}\ncomment sensor {}\ncomment time "
      "{}\n"
      "comment frame sensor: metres; x forward, y left, z up\n",
      withoutBreaks(plan.manifest.name), withoutBreaks(sample.record->key), withoutBreaks(exportScan.sensor->name),
      exportScan.record->time);
  for (const Pose& pose : exportScan.record->worldFromSensor) {
    const Quat& q = pose.rotation;
    const Vec3d& t = pose.translation;
    text += fmt::format("comment world_from_sensor quaternion_wxyz {} {} {} {} translation {} {} {}\n", q.w, q.x, q.y,
                        q.z, t.x, t.y, t.z);
  }
  for (const SemanticClass& c : plan.classes.target().classes) {
    text += fmt::format("comment class {} {}\n", c.id, withoutBreaks(c.name));
  }
  const ColumnSet columns = exportedColumns(plan, exportScan.scan);
  text += fmt::format(
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n",
      points);
  visitTable(exportScan.scan, [&]<class T>(auto key, const std::vector<T>&) {
    if (columns.has(key)) text += fmt::format("property {} {}\n", kPlyType<T>, key.row.name);
  });
  return text + "end_header\n";
}

// Returns the colour of a point's class. In a scan without classes, returns a grey level that grows with intensity.
Color colorOf(const ExportPlan& plan, const ExportScan& exportScan, std::size_t point) {
  const Scan& scan = exportScan.scan;
  if (!scan[kLabel].empty()) return plan.classes.classOf(scan[kLabel][point]).color;
  std::uint8_t grey = kMiddleGrey;
  if (!scan[kIntensity].empty()) {
    const float intensity = unitIntensity(exportScan, point);
    grey = intensity > 0 ? static_cast<std::uint8_t>(std::min(intensity, 1.0f) * 255 + 0.5f) : std::uint8_t{0};
  }
  return {grey, grey, grey};
}

std::string plyBytes(const ExportPlan& plan, const ExportSample& sample, const ExportScan& exportScan) {
  const Scan& scan = exportScan.scan;
  const auto points = static_cast<std::size_t>(std::ranges::count_if(scan.position, isFinite<float>));
  std::string bytes = header(plan, sample, exportScan, points);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3f& p = scan.position[i];
    if (!isFinite(p)) continue;
    for (const float coordinate : {p.x, p.y, p.z}) putNumber(coordinate, bytes);
    for (const std::uint8_t channel : colorOf(plan, exportScan, i)) putNumber(channel, bytes);
    visitTable(scan, [&](auto key, const auto& values) {
      if (!values.empty()) putNumber(exported(plan.classes, key, values[i]), bytes);
    });
  }
  return bytes;
}

}  // namespace

std::unique_ptr<ExportLayout> makePly() {
  return std::make_unique<ScanFiles>("ply", plyBytes);
}

}  // namespace scanmill
