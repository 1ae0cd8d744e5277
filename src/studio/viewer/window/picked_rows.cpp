#include "viewer/window/picked_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "base/grouped.h"
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

// "range error (m)" as "range error": the value has the unit.
std::string withoutUnit(const std::string& title) {
  const std::size_t unit = title.rfind(" (");
  return unit == std::string::npos || title.back() != ')' ? title : title.substr(0, unit);
}

std::string valueIn(const Rows& rows, const std::string& name) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row.first == name; });
  return found == rows.end() ? "" : found->second;
}

std::optional<std::size_t> pointOfBeam(const Scan& scan, std::size_t beam) {
  if (scan.organised) return beam < scan.size() ? std::optional(beam) : std::nullopt;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (std::size_t{scan.ring[i]} * scan.columns + scan.column[i] == beam) return i;
  }
  return {};
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
    rows.emplace_back(viewed.errorTitle.empty() ? "error" : withoutUnit(viewed.errorTitle),
                      std::isfinite(error) ? fmt::format("{:.4f} m", error) : "not known");
  }
  if (!scan.time.empty()) rows.emplace_back("time", fmt::format("{:.4f} ms", double{scan.time[point]} * 1e3));
  addBeam(rows, viewed, point);
  if (!viewed.sensor.empty()) rows.emplace_back("sensor", viewed.sensor);
  if (!viewed.method.empty()) rows.emplace_back("method", viewed.method);
  rows.emplace_back("point", fmt::format("{} of {}", point, grouped(scan.size())));
  return thing;
}

void addBrief(PickedThing& thing, ColorBy shown) {
  const Rows& rows = thing.rows;
  thing.brief.emplace_back("range", valueIn(rows, "range"));
  const std::string ring = valueIn(rows, "ring");
  const std::string column = valueIn(rows, "column");
  if (!ring.empty() && !column.empty()) {
    thing.brief.emplace_back("ring, column", fmt::format("{}, {}", ring, column));
  } else if (!ring.empty()) {
    thing.brief.emplace_back("ring", ring);
  }
  const auto add = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) thing.brief.emplace_back(name, value);
  };
  switch (shown) {
    case ColorBy::Intensity:
      return add("intensity", valueIn(rows, "intensity"));
    case ColorBy::Time:
      return add("time", valueIn(rows, "time"));
    case ColorBy::Height:
      return add("height", valueIn(rows, "z"));
    case ColorBy::Incidence:
      return add("incidence", valueIn(rows, "incidence"));
    case ColorBy::Method:
      return add("method", valueIn(rows, "method"));
    case ColorBy::Error: {
      const auto error = std::find_if(rows.begin(), rows.end(), [](const auto& row) {
        return row.first.find("error") != std::string::npos || row.first.find("reference") != std::string::npos;
      });
      if (error != rows.end()) add(error->first, error->second);
      return;
    }
    case ColorBy::Class:
    case ColorBy::Instance:
    case ColorBy::Return:
    case ColorBy::Range:
    case ColorBy::Ring:
      return;
  }
}

void addInstance(PickedThing& thing, const InstanceSummary& summary, const Ontology* ontology) {
  const Vec3d& size = summary.size;
  const std::string points =
      fmt::format("{} point{}", grouped(summary.points.size()), summary.points.size() == 1 ? "" : "s");
  Rows rows{{"its points", points.substr(0, points.find(' '))},
            {"its upright box", fmt::format("{:.2f} x {:.2f} x {:.2f} m", size.x, size.y, size.z)}};
  thing.brief.emplace_back("instance", fmt::format("{}, {:.1f} x {:.1f} x {:.1f} m", points, size.x, size.y, size.z));
  if (summary.classes.size() > 1) {
    std::string classes;
    for (const auto& [id, count] : summary.classes) {
      classes += fmt::format("{}{} {}", classes.empty() ? "" : ", ", className(ontology, id), grouped(count));
    }
    thing.alarm = "its classes";
    rows.emplace_back(thing.alarm, classes);
    thing.brief.emplace_back(thing.alarm, classes);
  }
  auto after = std::find_if(thing.rows.begin(), thing.rows.end(), [](const auto& r) { return r.first == "instance"; });
  if (after != thing.rows.end()) ++after;
  thing.rows.insert(after, rows.begin(), rows.end());
}

void addSameBeam(PickedThing& thing, const Scan& own, const ViewScan& other, const Ontology* ontology) {
  const Scan& scan = other.scan;
  const auto beam = beamOf(own, thing.point);
  const bool known = scan.organised || (!scan.ring.empty() && !scan.column.empty());
  if (!beam || !known || own.rings != scan.rings || own.columns != scan.columns) return;
  const auto point = pointOfBeam(scan, *beam);
  if (!point || !isFinite(scan.position[*point])) {
    thing.rows.emplace_back(other.name, "no return");
    return;
  }
  std::string told = fmt::format("{:.2f} m", length(Vec3d(scan.position[*point])));
  if (!scan.label.empty()) told += ", " + className(ontology, scan.label[*point]);
  thing.rows.emplace_back(other.name, told);
}

std::string wholeName(const ViewScan& scan, const std::string& dataset) {
  std::string name = scan.name;
  for (const std::string* part : {&scan.sensor, &scan.method}) {
    if (!part->empty() && name.find(*part) == std::string::npos) name += ", " + *part;
  }
  return name.find(dataset) == std::string::npos && name.find(": ") == std::string::npos ? dataset + ": " + name : name;
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
  thing.rows.emplace_back("triangle", fmt::format("{} of {}", triangle, grouped(mesh.size())));
  for (const char* row : {"object", "material", "reflectance"}) {
    if (const std::string value = valueIn(thing.rows, row); !value.empty()) thing.brief.emplace_back(row, value);
  }
  return thing;
}

}  // namespace scanmill
