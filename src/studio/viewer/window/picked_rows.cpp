#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "base/short_text.h"
#include "viewer/window/picking.h"

namespace scanmill {

namespace {

using Rows = std::vector<std::pair<std::string, std::string>>;

std::string angle(double rad) {
  return fmt::format("{:.3f} deg", degrees(rad));
}

// Returns ring, column and return number of a point; nothing if the scan does not assign points to beams.
std::optional<PointKey> keyIn(const Scan& scan, std::size_t point) {
  return knowsBeams(scan) ? std::optional(keyOf(scan, point)) : std::nullopt;
}

std::string valueIn(const Rows& rows, const std::string& name) {
  const auto found = std::ranges::find(rows, name, &Rows::value_type::first);
  return found == rows.end() ? "" : found->second;
}

// Returns the index of the point with this ring, column and return number; nothing if the scan has no such point.
std::optional<std::size_t> pointOf(const Scan& scan, const PointKey& wanted) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (keyOf(scan, i) == wanted) return i;
  }
  return {};
}

// Adds the point's values in the columns of the table and in the file's foreign columns, except for class, instance,
// ring and column, which other rows show.
void addColumns(Rows& rows, const Scan& scan, std::size_t point) {
  const ColumnSet inOtherRows(kLabel, kInstance, kRing, kColumn);
  visitTable(scan, [&](auto key, const auto& values) {
    if (values.empty() || inOtherRows.has(key)) return;
    rows.emplace_back(key.row.name, displayText(key.row, static_cast<double>(values[point])));
  });
  for (const ForeignColumn& column : scan.foreign) {
    // A column of another program may have the same name as a column of the table.
    const bool known = std::ranges::any_of(rows, [&](const auto& row) { return row.first == column.name; });
    std::visit(
        [&](const auto& values) {
          rows.emplace_back(column.name + (known ? " (in the file)" : ""), fmt::format("{}", values[point]));
        },
        column.values);
  }
}

void addBeam(Rows& rows, const ViewScan& scan, std::size_t point) {
  const std::optional<PointKey> key = keyIn(scan.scan, point);
  const BeamTable* const table = scan.beams.get();
  const bool same = key && table != nullptr && table->columns == scan.scan.columns && key->column < table->columns;
  const std::size_t beam = key ? std::size_t{key->ring} * scan.scan.columns + key->column : 0;
  const bool known = same && beam < table->direction.size();
  const Vec3d direction = known ? table->direction[beam] : Vec3d(scan.scan.position[point]);
  if (scan.scan.organised || !scan.scan[kRing].empty()) {
    rows.emplace_back("ring", fmt::format("{}", scan.scan.organised ? key->ring : scan.scan[kRing][point]));
  }
  if (scan.scan.organised || !scan.scan[kColumn].empty()) {
    rows.emplace_back("column", fmt::format("{}", scan.scan.organised ? key->column : scan.scan[kColumn][point]));
  }
  if (scan.scan.organised && scan.scan.planes > 1 && scan.scan[kReturn].empty()) {
    rows.emplace_back("return", fmt::format("{}", key->number + 1));
  }
  const std::string of = known ? "beam " : "";  // if the beam is unknown, the angles of the point are shown
  rows.emplace_back(of + "azimuth", angle(std::atan2(direction.y, direction.x)));
  rows.emplace_back(of + "elevation", angle(std::atan2(direction.z, std::hypot(direction.x, direction.y))));
  if (known && beam < table->time.size()) {
    rows.emplace_back("beam fires at", displayText(kTime.row, double{table->time[beam]}));
  }
}

void addPosition(Rows& rows, const std::string& frame, const Vec3d& p) {
  for (const auto& [axis, metres] : {std::pair("x", p.x), {"y", p.y}, {"z", p.z}}) {
    rows.emplace_back(frame + axis, fmt::format("{:.3f} m", metres));
  }
}

// Returns the title of the errors without its unit, such as "range error" for "range error (m)"; the value is shown
// with its unit.
std::string errorRow(const ViewScan& viewed) {
  const std::string& title = viewed.errorTitle;
  if (title.empty()) return "error";
  return title.ends_with(')') ? title.substr(0, title.rfind(" (")) : title;
}

}  // namespace

PickedElement describePoint(const ViewScan& viewed, std::size_t scanIndex, std::size_t point, const Ontology* ontology) {
  const Scan& scan = viewed.scan;
  const Vec3d p(scan.position[point]);
  PickedElement picked;
  picked.scan = scanIndex;
  picked.point = point;
  Rows& rows = picked.rows;
  picked.heading = scan[kLabel].empty() ? "point" : className(ontology, scan[kLabel][point]);
  if (!scan[kInstance].empty() && scan[kInstance][point] != 0) {
    picked.heading += fmt::format(" {}", scan[kInstance][point]);
  }
  if (!scan[kLabel].empty()) {
    rows.emplace_back("class", fmt::format("{} ({})", className(ontology, scan[kLabel][point]), scan[kLabel][point]));
  }
  if (!scan[kInstance].empty()) {
    rows.emplace_back("instance", scan[kInstance][point] == 0 ? "none" : fmt::format("{}", scan[kInstance][point]));
  }
  rows.emplace_back("range", fmt::format("{:.3f} m", length(p)));
  addPosition(rows, "", p);
  addColumns(rows, scan, point);
  if (!viewed.error.empty()) {
    const double error = double{viewed.error[point]};
    rows.emplace_back(errorRow(viewed), std::isfinite(error) ? fmt::format("{:.4f} m", error) : "not known");
  }
  addBeam(rows, viewed, point);
  if (!viewed.sensor.empty()) rows.emplace_back("sensor", viewed.sensor);
  if (!viewed.method.empty()) rows.emplace_back("method", viewed.method);
  rows.emplace_back("point", fmt::format("{} of {}", point, grouped(scan.size())));
  return picked;
}

void addBrief(PickedElement& picked, const ViewScan& viewed, const ColorBy& shown) {
  const bool inHeading = shown == kByClass || shown == kByInstance;
  for (const auto& [name, value] : picked.rows) {
    const bool isShown = shown == kByError    ? name == errorRow(viewed)
                         : shown == kByHeight ? name == "z"
                                              : name == shown.name() && !inHeading;
    if (name == "range" || name == "ring" || name == "column" || isShown) picked.brief.emplace_back(name, value);
  }
}

void addInstance(PickedElement& picked, const InstanceSummary& summary, const Ontology* ontology) {
  const Vec3d& size = summary.size;
  const std::string points = pluralOf(summary.points.size(), "point");
  Rows rows{{"its points", grouped(summary.points.size())},
            {"its upright box", fmt::format("{:.2f} x {:.2f} x {:.2f} m", size.x, size.y, size.z)}};
  picked.brief.emplace_back("instance", fmt::format("{}, {:.1f} x {:.1f} x {:.1f} m", points, size.x, size.y, size.z));
  if (summary.classes.size() > 1) {
    std::string classes;
    for (const auto& [id, count] : summary.classes) {
      classes += fmt::format("{}{} {}", classes.empty() ? "" : ", ", className(ontology, id), grouped(count));
    }
    picked.alarm = "its classes";
    rows.emplace_back(picked.alarm, classes);
    picked.brief.emplace_back(picked.alarm, classes);
  }
  auto after = std::ranges::find_if(picked.rows, [](const auto& r) { return r.first == "instance"; });
  if (after != picked.rows.end()) ++after;
  picked.rows.insert(after, rows.begin(), rows.end());
}

void addSameBeam(PickedElement& picked, const Scan& own, const ViewScan& other, const Ontology* ontology) {
  const Scan& scan = other.scan;
  const std::optional<PointKey> key = keyIn(own, picked.point);
  if (!key || !knowsBeams(scan) || own.rings != scan.rings || own.columns != scan.columns) return;
  const auto point = pointOf(scan, *key);
  if (!point || !isFinite(scan.position[*point])) {
    picked.rows.emplace_back(other.name, "no return");
    return;
  }
  std::string text = fmt::format("{:.2f} m", length(Vec3d(scan.position[*point])));
  if (!scan[kLabel].empty()) text += ", " + className(ontology, scan[kLabel][*point]);
  picked.rows.emplace_back(other.name, text);
}

std::string fullName(const ViewScan& scan, const std::string& dataset) {
  std::string name = scan.name;
  for (const std::string* part : {&scan.sensor, &scan.method}) {
    if (!part->empty() && name.find(*part) == std::string::npos) name += ", " + *part;
  }
  return name.find(dataset) == std::string::npos && name.find(": ") == std::string::npos ? dataset + ": " + name : name;
}

PickedElement describeTriangle(const ViewMesh& mesh, std::size_t triangle, const Vec3d& worldPosition) {
  PickedElement picked;
  picked.scan = kNoScan;
  picked.point = triangle;
  const std::uint16_t semantic = mesh.semantic[triangle];
  const std::uint32_t instance = mesh.instance[triangle];
  const ViewSurface& surface = mesh.surfaceOf(triangle);
  const std::string name = className(&mesh.ontology, semantic);
  picked.heading = instance == 0 ? name : fmt::format("{} {}", name, instance);
  picked.rows.emplace_back("object", mesh.parts[surface.part]);
  picked.rows.emplace_back("class", fmt::format("{} ({})", name, semantic));
  picked.rows.emplace_back("class by", mesh.rules[surface.rule]);
  picked.rows.emplace_back("instance", instance == 0 ? "none" : fmt::format("{}", instance));
  picked.rows.emplace_back("material", mesh.materials[surface.material]);
  picked.rows.emplace_back("reflectance", fmt::format("{:.3g}", mesh.reflectance[surface.material]));
  picked.rows.emplace_back("texture", surface.texture == 0 ? "none" : mesh.textures[surface.texture]);
  addPosition(picked.rows, "world ", worldPosition);
  picked.rows.emplace_back("triangle", fmt::format("{} of {}", triangle, grouped(mesh.size())));
  for (const char* row : {"object", "class by", "material", "reflectance"}) {
    if (const std::string value = valueIn(picked.rows, row); !value.empty()) picked.brief.emplace_back(row, value);
  }
  return picked;
}

}  // namespace scanmill
