#include "viewer/coloring.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

void requireColumn(const Scan& scan, bool present, ColorBy colorBy, const char* column) {
  if (present || scan.size() == 0) return;
  throw InputError(
      fmt::format("the scan has no column '{}', which colours by {} need; it has {} (a dataset's scans have "
                  "what `output.columns` of its pipeline names)",
                  column, kColorNames[static_cast<std::size_t>(colorBy)], fmt::join(columnNames(scan), ", ")));
}

ColorBy defaultFor(const Scan& scan) {
  if (!scan.label.empty()) return ColorBy::Class;
  return scan.intensity.empty() ? ColorBy::Range : ColorBy::Intensity;
}

Coloring byClass(const Scan& scan, const Ontology* ontology) {
  Coloring out;
  out.legend.title = "class";
  constexpr std::size_t kIds = std::size_t{1} << 16;
  std::vector<std::uint64_t> present(kIds);
  std::vector<bool> known(kIds);
  std::vector<Rgb> colors(kIds);
  out.colors.reserve(scan.size());
  for (std::size_t i = 0; i < scan.label.size(); ++i) {
    const std::uint16_t id = scan.label[i];
    if (!known[id]) {
      known[id] = true;
      colors[id] = classColor(ontology, id);
    }
    out.colors.push_back(colors[id]);
    present[id] += isFinite(scan.position[i]) ? 1 : 0;
  }
  for (std::size_t k = 0; k < kIds; ++k) {
    const std::uint64_t points = present[k];
    if (points == 0) continue;
    const auto id = static_cast<std::uint16_t>(k);
    const SemanticClass* named = ontology == nullptr ? nullptr : ontology->find(id);
    out.legend.entries.push_back(
        {named == nullptr ? fmt::format("class {}", id) : named->name, colors[id], id, points});
  }
  return out;
}

Coloring byInstance(const Scan& scan) {
  Coloring out;
  out.legend.title = "instance";
  std::map<std::uint32_t, std::uint64_t> present;
  out.colors.reserve(scan.size());
  std::uint64_t* count = &present[0];
  std::uint32_t last = 0;
  Rgb color = instanceColor(last);
  for (std::size_t i = 0; i < scan.instance.size(); ++i) {
    if (scan.instance[i] != last) {  // neighbours mostly share their instance
      last = scan.instance[i];
      color = instanceColor(last);
      count = &present[last];
    }
    out.colors.push_back(color);
    *count += isFinite(scan.position[i]) ? 1 : 0;
  }
  std::erase_if(present, [](const auto& entry) { return entry.first != 0 && entry.second == 0; });
  const std::uint64_t none = present[0];
  present.erase(0);
  if (!present.empty()) {
    std::uint64_t points = 0;
    for (const auto& [id, held] : present) points += held;
    out.legend.entries.push_back(
        {fmt::format("{} instance{}, a colour each", present.size(), present.size() == 1 ? "" : "s"),
         instanceColor(present.begin()->first), -1, points});
  }
  out.legend.entries.push_back({"no instance", instanceColor(0), -1, none});
  return out;
}

Coloring inOneColor(const Scan& scan, std::string title, std::string name, const Rgb& color) {
  Coloring out;
  out.colors.assign(scan.size(), color);
  out.legend.title = std::move(title);
  const auto points = std::count_if(scan.position.begin(), scan.position.end(), isFinite<float>);
  out.legend.entries.push_back({std::move(name), color, -1, static_cast<std::uint64_t>(points)});
  return out;
}

double percentile(std::vector<double>& values, double share) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

struct Scale {
  std::string title;
  double clipped = 0;  // share of the values beyond either end that is given by the values
  double power = 1;
  std::optional<double> low{};  // ends that are given by what is shown
  std::optional<double> high{};
  bool integers = false;
};

constexpr double kClipped = 0.01;
constexpr std::size_t kMostSorted = 1'000'000;  // values that percentiles are taken from
constexpr double kFirstReturn = 0.7;            // of the colour map

// `at(i)` is the value of point i; `given`, the ends of the scale.
template <class At>
Coloring byNumber(const Scan& scan, const Scale& scale, const std::optional<ScaleRange>& given, const At& at) {
  Coloring out;
  out.legend.title = scale.title;
  out.legend.scale = true;
  out.legend.power = scale.power;
  out.legend.integers = scale.integers;
  out.legend.held = given.has_value();
  std::vector<double> finite;
  const std::size_t step = scale.clipped > 0 ? scan.size() / kMostSorted + 1 : 1;
  for (std::size_t i = 0; i < scan.size() && !given; i += step) {
    if (isFinite(scan.position[i]) && std::isfinite(static_cast<double>(at(i)))) finite.push_back(at(i));
  }
  const auto end = [&](const std::optional<double>& known, double share) {
    return known ? *known : finite.empty() ? 0 : percentile(finite, share);
  };
  out.legend.low = given ? given->low : end(scale.low, scale.clipped);
  out.legend.high = given ? given->high : end(scale.high, 1 - scale.clipped);
  const double span = out.legend.high - out.legend.low;
  out.colors.resize(scan.size());
  std::atomic<std::uint64_t> unknown = 0;
  parallelFor(scan.size(), 1 << 14, [&](std::size_t first, std::size_t last) {
    std::uint64_t missing = 0;
    for (std::size_t i = first; i < last; ++i) {
      const double value = at(i);
      const double share = span > 0 ? std::clamp((value - out.legend.low) / span, 0.0, 1.0) : 0.5;
      out.colors[i] = std::isfinite(value) ? viridis(std::pow(share, 1 / scale.power)) : kNoValue;
      if (!std::isfinite(value) && isFinite(scan.position[i])) ++missing;
    }
    unknown += missing;
  });
  out.legend.unknown = unknown;
  return out;
}

double distanceOf(const Scan& scan, std::size_t i) {
  return length(Vec3d(scan.position[i]));
}

Coloring byError(const Scan& scan, const ColorContext& context) {
  const Scale scale{context.errorTitle.empty() ? "error (m)" : context.errorTitle, kClipped, 2, 0.0};
  if (!context.error.empty()) {
    if (context.error.size() != scan.size()) {
      throw Error(fmt::format("{} errors for the {} points of a scan", context.error.size(), scan.size()));
    }
    Coloring out = byNumber(scan, scale, context.scale, [&](std::size_t i) { return context.error[i]; });
    out.legend.whyUnknown = context.whyNoError;
    return out;
  }
  if (scan.rangeTrue.empty() && scan.size() > 0) {
    throw InputError(
        fmt::format("colours by error need something to compare with: name `range_true` in output.columns of the "
                    "pipeline, or give the noise-free reference; the scan has {}",
                    fmt::join(columnNames(scan), ", ")));
  }
  return byNumber(scan, scale, context.scale,
                  [&](std::size_t i) { return std::abs(distanceOf(scan, i) - scan.rangeTrue[i]); });
}

}  // namespace

Coloring colorScan(const Scan& scan, std::optional<ColorBy> colorBy, const ColorContext& context) {
  const ColorBy by = colorBy.value_or(defaultFor(scan));
  switch (by) {
    case ColorBy::Class:
      requireColumn(scan, !scan.label.empty(), by, "label");
      return byClass(scan, context.ontology);
    case ColorBy::Instance:
      requireColumn(scan, !scan.instance.empty(), by, "instance");
      return byInstance(scan);
    case ColorBy::Intensity:
      requireColumn(scan, !scan.intensity.empty(), by, "intensity");
      return byNumber(scan, {"intensity", kClipped, 2}, context.scale,
                      [&](std::size_t i) { return scan.intensity[i]; });
    case ColorBy::Ring:
      requireColumn(scan, !scan.ring.empty(), by, "ring");
      return byNumber(scan, {.title = "ring", .integers = true}, context.scale,
                      [&](std::size_t i) { return scan.ring[i]; });
    case ColorBy::Time:
      requireColumn(scan, !scan.time.empty(), by, "time");
      return byNumber(scan, {"time (ms)"}, context.scale, [&](std::size_t i) { return scan.time[i] * 1e3; });
    case ColorBy::Height:
      return byNumber(scan, {"height above the sensor (m)", kClipped}, context.scale,
                      [&](std::size_t i) { return scan.position[i].z; });
    case ColorBy::Return:
      // The sensors of this program report one return a beam, so scans have no column of its number.
      return inOneColor(scan, "return", "first return (the only one)", viridis(kFirstReturn));
    case ColorBy::Incidence:
      requireColumn(scan, !scan.incidence.empty(), by, "incidence");
      return byNumber(scan, {"incidence (deg)", 0, 1, 0.0, 90.0}, context.scale,
                      [&](std::size_t i) { return degrees(scan.incidence[i]); });
    case ColorBy::Error:
      return byError(scan, context);
    case ColorBy::Method:
      return inOneColor(scan, "method", context.method.empty() ? "not known" : context.method, context.methodColor);
    case ColorBy::Range:
      break;
  }
  return byNumber(scan, {"range (m)", kClipped, 2}, context.scale, [&](std::size_t i) { return distanceOf(scan, i); });
}

Coloring colorScan(const Scan& scan, std::optional<ColorBy> colorBy, const Ontology* ontology) {
  return colorScan(scan, colorBy, ColorContext{.ontology = ontology});
}

}  // namespace scanmill
