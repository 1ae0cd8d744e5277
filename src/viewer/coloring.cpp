#include "viewer/coloring.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "viewer/color_map.h"

namespace scanmill {

namespace {

void requireColumn(const Scan& scan, bool present, ColorBy colorBy, const char* column) {
  if (present || scan.size() == 0) return;
  throw InputError(fmt::format("the scan has no column '{}', which --color {} needs; it has {}", column,
                               kColorNames[static_cast<std::size_t>(colorBy)], fmt::join(columnNames(scan), ", ")));
}

ColorBy defaultFor(const Scan& scan) {
  if (!scan.label.empty()) return ColorBy::Class;
  return scan.intensity.empty() ? ColorBy::Range : ColorBy::Intensity;
}

Coloring byClass(const Scan& scan, const Ontology* ontology) {
  Coloring out;
  out.legend.title = "class";
  std::set<std::uint16_t> present;
  for (std::size_t i = 0; i < scan.label.size(); ++i) {
    out.colors.push_back(classColor(ontology, scan.label[i]));
    if (isFinite(scan.position[i])) present.insert(scan.label[i]);
  }
  for (const std::uint16_t id : present) {
    const SemanticClass* known = ontology == nullptr ? nullptr : ontology->find(id);
    out.legend.entries.push_back(
        {known == nullptr ? fmt::format("class {}", id) : known->name, classColor(ontology, id)});
  }
  return out;
}

Coloring byInstance(const Scan& scan) {
  Coloring out;
  out.legend.title = "instance";
  std::set<std::uint32_t> present;
  for (std::size_t i = 0; i < scan.instance.size(); ++i) {
    out.colors.push_back(instanceColor(scan.instance[i]));
    if (isFinite(scan.position[i]) && scan.instance[i] != 0) present.insert(scan.instance[i]);
  }
  if (!present.empty()) {
    out.legend.entries.push_back(
        {fmt::format("{} instance{}, a colour each", present.size(), present.size() == 1 ? "" : "s"),
         instanceColor(*present.begin())});
  }
  out.legend.entries.push_back({"no instance", instanceColor(0)});
  return out;
}

double percentile(std::vector<double>& values, double share) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

// `at(i)` is the value of point i.
template <class At>
Coloring byNumber(const Scan& scan, std::string title, double clipped, double power, const At& at) {
  Coloring out;
  out.legend.title = std::move(title);
  out.legend.scale = true;
  out.legend.power = power;
  std::vector<double> finite;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i]) && std::isfinite(static_cast<double>(at(i)))) finite.push_back(at(i));
  }
  if (!finite.empty()) {
    out.legend.low = percentile(finite, clipped);
    out.legend.high = percentile(finite, 1 - clipped);
  }
  const double span = out.legend.high - out.legend.low;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double value = at(i);
    const double share = span > 0 ? std::clamp((value - out.legend.low) / span, 0.0, 1.0) : 0.5;
    out.colors.push_back(std::isfinite(value) ? viridis(std::pow(share, 1 / power)) : kNoValue);
  }
  return out;
}

}  // namespace

Coloring colorScan(const Scan& scan, std::optional<ColorBy> colorBy, const Ontology* ontology) {
  constexpr double kClipped = 0.01;
  const ColorBy by = colorBy.value_or(defaultFor(scan));
  switch (by) {
    case ColorBy::Class:
      requireColumn(scan, !scan.label.empty(), by, "label");
      return byClass(scan, ontology);
    case ColorBy::Instance:
      requireColumn(scan, !scan.instance.empty(), by, "instance");
      return byInstance(scan);
    case ColorBy::Intensity:
      requireColumn(scan, !scan.intensity.empty(), by, "intensity");
      return byNumber(scan, "intensity", kClipped, 2, [&](std::size_t i) { return scan.intensity[i]; });
    case ColorBy::Ring:
      requireColumn(scan, !scan.ring.empty(), by, "ring");
      return byNumber(scan, "ring", 0, 1, [&](std::size_t i) { return scan.ring[i]; });
    case ColorBy::Time:
      requireColumn(scan, !scan.time.empty(), by, "time");
      return byNumber(scan, "time (ms)", 0, 1, [&](std::size_t i) { return scan.time[i] * 1e3; });
    case ColorBy::Height:
      return byNumber(scan, "height above the sensor (m)", kClipped, 1,
                      [&](std::size_t i) { return scan.position[i].z; });
    case ColorBy::Range:
      break;
  }
  return byNumber(scan, "range (m)", kClipped, 1, [&](std::size_t i) { return length(Vec3d(scan.position[i])); });
}

}  // namespace scanmill
