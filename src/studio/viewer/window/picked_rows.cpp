#include <fmt/core.h>

#include "base/short_text.h"
#include "viewer/window/picking.h"

namespace scanmill {

namespace {

std::string angleText(double radians) {
  return fmt::format("{:.3f} deg", degrees(radians));
}

// Returns ring, column and return number of a point; nothing if the scan does not assign points to beams.
std::optional<PointKey> keyIn(const Scan& scan, std::size_t point) {
  return knowsBeams(scan) ? std::optional(keyOf(scan, point)) : std::nullopt;
}

// Returns the index of the point with this ring, column and return number; nothing if the scan has no such point.
std::optional<std::size_t> pointWithKey(const Scan& scan, const PointKey& key) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (keyOf(scan, i) == key) return i;
  }
  return {};
}

// Adds the point's values in the columns of the table and in the file's foreign columns, except for class, instance,
// ring and column, which other rows show.
void addColumns(NamedValues& rows, const Scan& scan, std::size_t point) {
  const ColumnSet inOtherRows(kLabel, kInstance, kRing, kColumn);
  visitTable(scan, [&](auto key, const auto& values) {
    if (values.empty() || inOtherRows.has(key)) return;
    rows.emplace_back(key.row.name, displayText(key.row, static_cast<double>(values[point])));
  });
  for (const ForeignColumn& column : scan.foreign) {
    // A foreign column may have the same name as a column of the table.
    const bool isUsed = std::ranges::count(rows, column.name, &NamedValues::value_type::first) > 0;
    std::visit(
        [&](const auto& values) {
          rows.emplace_back(column.name + (isUsed ? " (in the file)" : ""), fmt::format("{}", values[point]));
        },
        column.values);
  }
}

// Adds the ring, the column and the return number of a point, except those that the scan lacks.
void addKey(NamedValues& rows, const Scan& scan, std::size_t point) {
  const PointKey key = scan.organised ? keyOf(scan, point) : PointKey{};  // an organised scan need not have columns
  if (scan.organised || !scan[kRing].empty()) {
    rows.emplace_back("ring", fmt::format("{}", scan.organised ? key.ring : scan[kRing][point]));
  }
  if (scan.organised || !scan[kColumn].empty()) {
    rows.emplace_back("column", fmt::format("{}", scan.organised ? key.column : scan[kColumn][point]));
  }
  if (scan.organised && scan.planes > 1 && scan[kReturn].empty()) {
    rows.emplace_back("return", fmt::format("{}", key.number + 1));
  }
}

// Returns the index of the point's beam in the scan's beam table; nothing if the beam is unknown.
std::optional<std::size_t> beamOf(const ViewScan& viewed, std::size_t point) {
  const std::optional<PointKey> key = keyIn(viewed.scan, point);
  const BeamTable* const table = viewed.beams.get();
  if (!key || table == nullptr || table->columns != viewed.scan.columns || key->column >= table->columns) return {};
  const std::size_t beam = std::size_t{key->ring} * table->columns + key->column;
  return beam < table->direction.size() ? std::optional(beam) : std::nullopt;
}

// Adds the angles of the point's beam or, if the beam is unknown, of the point, and the time at which the beam fires.
void addBeam(NamedValues& rows, const ViewScan& viewed, std::size_t point) {
  const std::optional<std::size_t> beam = beamOf(viewed, point);
  const Vec3d direction = beam ? viewed.beams->direction[*beam] : Vec3d(viewed.scan.position[point]);
  const std::string prefix = beam ? "beam " : "";
  rows.emplace_back(prefix + "azimuth", angleText(std::atan2(direction.y, direction.x)));
  rows.emplace_back(prefix + "elevation", angleText(std::atan2(direction.z, std::hypot(direction.x, direction.y))));
  if (beam && *beam < viewed.beams->time.size()) {
    rows.emplace_back("beam fires at", displayText(kTime.row, double{viewed.beams->time[*beam]}));
  }
}

void addPosition(NamedValues& rows, const std::string& frame, const Vec3d& p) {
  for (const auto& [axis, metres] : {std::pair("x", p.x), {"y", p.y}, {"z", p.z}}) {
    rows.emplace_back(frame + axis, fmt::format("{:.3f} m", metres));
  }
}

// Returns the title of the errors without the unit, such as "range error" for "range error (m)"; default: "error".
std::string errorRow(const ViewScan& viewed) {
  const std::string& title = viewed.errorTitle;
  if (title.empty()) return "error";
  return title.ends_with(')') ? title.substr(0, title.rfind(" (")) : title;
}

}  // namespace

PickedElement describePoint(const ViewScan& viewed, std::size_t scanIndex, std::size_t point,
                            const Ontology* ontology) {
  const Scan& scan = viewed.scan;
  const Vec3d p(scan.position[point]);
  PickedElement picked{.heading = "point", .scan = scanIndex, .point = point};
  NamedValues& rows = picked.rows;
  if (!scan[kLabel].empty()) {
    picked.heading = className(ontology, scan[kLabel][point]);
    rows.emplace_back("class", fmt::format("{} ({})", picked.heading, scan[kLabel][point]));
  }
  if (!scan[kInstance].empty()) {
    const std::uint32_t instance = scan[kInstance][point];
    if (instance != 0) picked.heading += fmt::format(" {}", instance);
    rows.emplace_back("instance", instance == 0 ? "none" : fmt::format("{}", instance));
  }
  rows.emplace_back("range", fmt::format("{:.3f} m", length(p)));
  addPosition(rows, "", p);
  addColumns(rows, scan, point);
  if (!viewed.error.empty()) {
    const double error = double{viewed.error[point]};
    rows.emplace_back(errorRow(viewed), std::isfinite(error) ? fmt::format("{:.4f} m", error) : "not known");
  }
  addKey(rows, scan, point);
  addBeam(rows, viewed, point);
  if (!viewed.sensor.empty()) rows.emplace_back("sensor", viewed.sensor);
  if (!viewed.method.empty()) rows.emplace_back("method", viewed.method);
  rows.emplace_back("point", fmt::format("{} of {}", point, grouped(scan.size())));
  return picked;
}

void addBrief(PickedElement& picked, const ViewScan& viewed, const ColorBy& shown) {
  const bool isInHeading = shown == kByClass || shown == kByInstance;
  const std::string shownRow = shown == kByError    ? errorRow(viewed)
                               : shown == kByHeight ? "z"
                               : isInHeading        ? ""
                                                    : shown.name();
  for (const auto& [name, value] : picked.rows) {
    const bool isBrief = name == "range" || name == "ring" || name == "column" || name == shownRow;
    if (isBrief) picked.brief.emplace_back(name, value);
  }
}

void addInstance(PickedElement& picked, const InstanceSummary& summary, const Ontology* ontology) {
  const Vec3d& size = summary.size;
  const std::string points = pluralOf(summary.points.size(), "point");
  NamedValues rows{{"its points", grouped(summary.points.size())},
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
  auto next = std::ranges::find(picked.rows, "instance", &NamedValues::value_type::first);
  if (next != picked.rows.end()) ++next;  // the row after "instance"
  picked.rows.insert(next, rows.begin(), rows.end());
}

void addSameBeam(PickedElement& picked, const Scan& pickedScan, const ViewScan& otherScan, const Ontology* ontology) {
  const Scan& scan = otherScan.scan;
  const std::optional<PointKey> key = keyIn(pickedScan, picked.point);
  if (!key || !knowsBeams(scan) || pickedScan.rings != scan.rings || pickedScan.columns != scan.columns) return;
  const auto point = pointWithKey(scan, *key);
  if (!point || !isFinite(scan.position[*point])) {
    picked.rows.emplace_back(otherScan.name, "no return");
    return;
  }
  std::string text = fmt::format("{:.2f} m", length(Vec3d(scan.position[*point])));
  if (!scan[kLabel].empty()) text += ", " + className(ontology, scan[kLabel][*point]);
  picked.rows.emplace_back(otherScan.name, text);
}

std::string fullName(const ViewScan& scan, const std::string& dataset) {
  std::string name = scan.name;
  for (const std::string* part : {&scan.sensor, &scan.method}) {
    if (!part->empty() && name.find(*part) == std::string::npos) name += ", " + *part;
  }
  return name.find(dataset) == std::string::npos && name.find(": ") == std::string::npos ? dataset + ": " + name : name;
}

PickedElement describeTriangle(const ViewMesh& mesh, std::size_t triangle, const Vec3d& worldPosition) {
  const std::uint16_t semantic = mesh.semantic[triangle];
  const std::uint32_t instance = mesh.instance[triangle];
  const ViewSurface& surface = mesh.surfaceOf(triangle);
  const std::string name = className(&mesh.ontology, semantic);
  PickedElement picked{.heading = instance == 0 ? name : fmt::format("{} {}", name, instance),
                       .rows = {{"object", mesh.parts[surface.part]},
                                {"class", fmt::format("{} ({})", name, semantic)},
                                {"class by", mesh.rules[surface.rule]},
                                {"instance", instance == 0 ? "none" : fmt::format("{}", instance)},
                                {"material", mesh.materials[surface.material]},
                                {"reflectance", fmt::format("{:.3g}", mesh.reflectance[surface.material])},
                                {"texture", surface.texture == 0 ? "none" : mesh.textures[surface.texture]}},
                       .scan = kNoScan,
                       .point = triangle};
  addPosition(picked.rows, "world ", worldPosition);
  picked.rows.emplace_back("triangle", fmt::format("{} of {}", triangle, grouped(mesh.size())));
  constexpr std::array<std::string_view, 4> kBrief{"object", "class by", "material", "reflectance"};
  std::ranges::copy_if(picked.rows, std::back_inserter(picked.brief), [&](const auto& row) {
    return std::ranges::find(kBrief, row.first) != kBrief.end() && !row.second.empty();
  });
  return picked;
}

}  // namespace scanmill
