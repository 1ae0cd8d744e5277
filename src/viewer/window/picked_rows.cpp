#include "viewer/window/picked_rows.h"

#include <fmt/core.h>

#include <optional>

#include "viewer/window/class_filter.h"

namespace scanmill {

namespace {

using Rows = std::vector<std::pair<std::string, std::string>>;

std::string angle(double rad) {
  return fmt::format("{:.3f} deg", degrees(rad));
}

double elevationOf(const Vec3d& direction) {
  return std::atan2(direction.z, std::hypot(direction.x, direction.y));
}

// Index of the point's beam in the sensor's table, ring * columns + column.
std::optional<std::size_t> beamOf(const Scan& scan, std::size_t point) {
  if (scan.organised) return point;
  if (scan.ring.empty() || scan.column.empty()) return {};
  return std::size_t{scan.ring[point]} * scan.columns + scan.column[point];
}

void addBeam(Rows& rows, const ViewScan& scan, std::size_t point) {
  const auto beam = beamOf(scan.scan, point);
  const BeamTable* const table = scan.beams.get();
  const bool known = beam && table != nullptr && table->columns == scan.scan.columns && *beam < table->direction.size();
  const Vec3d direction = known ? table->direction[*beam] : Vec3d(scan.scan.position[point]);
  if (scan.scan.organised) {
    rows.emplace_back("ring", fmt::format("{}", point / scan.scan.columns));
    rows.emplace_back("column", fmt::format("{}", point % scan.scan.columns));
  } else {
    if (!scan.scan.ring.empty()) rows.emplace_back("ring", fmt::format("{}", scan.scan.ring[point]));
    if (!scan.scan.column.empty()) rows.emplace_back("column", fmt::format("{}", scan.scan.column[point]));
  }
  const std::string of = known ? "beam " : "";  // else those of the point itself
  rows.emplace_back(of + "azimuth", angle(std::atan2(direction.y, direction.x)));
  rows.emplace_back(of + "elevation", angle(elevationOf(direction)));
  if (known && *beam < table->time.size()) {
    rows.emplace_back("beam fires at", fmt::format("{:.4f} ms", table->time[*beam] * 1e3));
  }
}

}  // namespace

PickedThing describePoint(const ViewScan& viewed, std::size_t scanIndex, std::size_t point, const Ontology* ontology) {
  const Scan& scan = viewed.scan;
  const Vec3d p(scan.position[point]);
  PickedThing thing;
  thing.scan = scanIndex;
  thing.point = point;
  Rows& rows = thing.rows;
  thing.heading = scan.label.empty() ? "point" : className(ontology, scan.label[point]);
  if (!scan.instance.empty() && scan.instance[point] != 0) {
    thing.heading += fmt::format(" {}", scan.instance[point]);
  }
  if (!scan.label.empty()) {
    rows.emplace_back("class", fmt::format("{} ({})", className(ontology, scan.label[point]), scan.label[point]));
  }
  if (!scan.instance.empty()) {
    rows.emplace_back("instance", scan.instance[point] == 0 ? "none" : fmt::format("{}", scan.instance[point]));
  }
  rows.emplace_back("range", fmt::format("{:.3f} m", length(p)));
  rows.emplace_back("x", fmt::format("{:.3f} m", p.x));
  rows.emplace_back("y", fmt::format("{:.3f} m", p.y));
  rows.emplace_back("z", fmt::format("{:.3f} m", p.z));
  if (!scan.intensity.empty()) rows.emplace_back("intensity", fmt::format("{:.5g}", scan.intensity[point]));
  if (!scan.rangeTrue.empty()) {
    rows.emplace_back("range_true", fmt::format("{:.4f} m", scan.rangeTrue[point]));
  }
  if (!scan.incidence.empty()) rows.emplace_back("incidence", angle(double{scan.incidence[point]}));
  if (!viewed.error.empty()) {
    const double error = double{viewed.error[point]};
    rows.emplace_back(viewed.errorTitle.empty() ? "error" : viewed.errorTitle,
                      std::isfinite(error) ? fmt::format("{:.4f} m", error) : "not known");
  }
  if (!scan.time.empty()) rows.emplace_back("time", fmt::format("{:.4f} ms", double{scan.time[point]} * 1e3));
  addBeam(rows, viewed, point);
  if (!viewed.sensor.empty()) rows.emplace_back("sensor", viewed.sensor);
  if (!viewed.method.empty()) rows.emplace_back("method", viewed.method);
  rows.emplace_back("point", fmt::format("{} of {}", point, groupedCount(scan.size())));
  return thing;
}

PickedThing describeTriangle(const ViewMesh& mesh, std::size_t triangle, const Vec3d& worldPlace) {
  PickedThing thing;
  thing.scan = kNoScan;
  thing.point = triangle;
  const std::uint16_t semantic = mesh.semantic[triangle];
  const std::uint32_t instance = mesh.instance[triangle];
  const std::uint16_t material = mesh.material[triangle];
  const std::string name = className(&mesh.ontology, semantic);
  thing.heading = instance == 0 ? name : fmt::format("{} {}", name, instance);
  thing.rows.emplace_back("object", mesh.part[triangle] < mesh.parts.size() ? mesh.parts[mesh.part[triangle]] : "");
  thing.rows.emplace_back("class", fmt::format("{} ({})", name, semantic));
  thing.rows.emplace_back("instance", instance == 0 ? "none" : fmt::format("{}", instance));
  if (material < mesh.materials.size()) thing.rows.emplace_back("material", mesh.materials[material]);
  if (material < mesh.reflectance.size()) {
    thing.rows.emplace_back("reflectance", fmt::format("{:.3g}", mesh.reflectance[material]));
  }
  thing.rows.emplace_back("world x", fmt::format("{:.3f} m", worldPlace.x));
  thing.rows.emplace_back("world y", fmt::format("{:.3f} m", worldPlace.y));
  thing.rows.emplace_back("world z", fmt::format("{:.3f} m", worldPlace.z));
  thing.rows.emplace_back("triangle", fmt::format("{} of {}", triangle, groupedCount(mesh.size())));
  return thing;
}

std::string groupedCount(std::uint64_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
  return digits;
}

}  // namespace scanmill
