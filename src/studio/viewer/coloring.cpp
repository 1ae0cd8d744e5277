#include "viewer/coloring.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <type_traits>
#include <variant>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

[[noreturn]] void failForColumn(const Scan& scan, const ColorBy& by, std::string_view column) {
  throw InputError(
      fmt::format("the scan has no column '{}', which colours by {} need; it has {} (a dataset's scans have "
                  "what `output.columns` of its pipeline names)",
                  column, by.name(), fmt::join(columnNames(scan), ", ")));
}

const ForeignColumn* foreignOf(const Scan& scan, const ColorBy& by) {
  const auto found = std::find_if(scan.foreign.begin(), scan.foreign.end(),
                                  [&](const ForeignColumn& column) { return column.name == by.name(); });
  return found == scan.foreign.end() ? nullptr : &*found;
}

bool holds(const Scan& scan, const Column& column) {
  return columnsOf(scan).has(columnIndex(column.name));
}

ColorBy defaultFor(const Scan& scan) {
  if (!scan[kLabel].empty()) return kByClass;
  return scan[kIntensity].empty() ? kByRange : kByIntensity;
}

Coloring byClass(const Scan& scan, const Ontology* ontology) {
  Coloring out;
  out.legend.title = "class";
  constexpr std::size_t kIds = std::size_t{1} << 16;
  std::vector<std::uint64_t> present(kIds);
  std::vector<bool> known(kIds);
  std::vector<Rgb> colors(kIds);
  out.colors.reserve(scan.size());
  for (std::size_t i = 0; i < scan[kLabel].size(); ++i) {
    const std::uint16_t id = scan[kLabel][i];
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
    out.legend.entries.push_back({className(ontology, id), colors[id], id, points});
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
  for (std::size_t i = 0; i < scan[kInstance].size(); ++i) {
    if (scan[kInstance][i] != last) {  // neighbours mostly share their instance
      last = scan[kInstance][i];
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

constexpr double kFirstReturn = 0.7;  // of the colour map

Rgb returnColor(std::uint32_t number) {
  return number == 1 ? viridis(kFirstReturn) : instanceColor(number);
}

std::uint32_t returnOf(const Scan& scan, std::size_t point) {
  return scan[kReturn].empty() ? keyOf(scan, point).number + 1 : scan[kReturn][point];
}

// A colour each: the numbers are few, and no scale.
Coloring byReturn(const Scan& scan) {
  if (scan[kReturn].empty() && scan.planes == 1) {
    return inOneColor(scan, "return", "first return (the only one)", viridis(kFirstReturn));
  }
  Coloring out;
  out.legend.title = "return";
  std::map<std::uint32_t, std::uint64_t> present;
  out.colors.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::uint32_t number = returnOf(scan, i);
    out.colors.push_back(returnColor(number));
    if (isFinite(scan.position[i])) ++present[number];
  }
  for (const auto& [number, points] : present) {
    out.legend.entries.push_back(
        {number == 0 ? "not known" : fmt::format("return {}", number), returnColor(number), -1, points});
  }
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
  if (scan[kRangeTrue].empty() && scan.size() > 0) {
    throw InputError(
        fmt::format("colours by error need something to compare with: name `range_true` in output.columns of the "
                    "pipeline, or give the noise-free reference; the scan has {}",
                    fmt::join(columnNames(scan), ", ")));
  }
  return byNumber(scan, scale, context.scale,
                  [&](std::size_t i) { return std::abs(distanceOf(scan, i) - scan[kRangeTrue][i]); });
}

Coloring byColumn(const Scan& scan, const Column& column, const ColorContext& context) {
  if (column.display.colors == ColumnColors::Classes) return byClass(scan, context.ontology);
  if (column.display.colors == ColumnColors::Instances) return byInstance(scan);
  const ColumnDisplay& display = column.display;
  Scale scale{withUnit(ColorBy::titleOf(column), display.unit), display.scaleClipped, display.scalePower};
  scale.integers = column.type != ColumnType::Float32;
  if (display.scaleOfValidity) {
    scale.low = column.low * display.factor;
    scale.high = column.high * display.factor;
  }
  Coloring out;
  visitTable(scan, [&](auto key, const auto& values) {
    if (key.row.name != column.name) return;
    out = byNumber(scan, scale, context.scale,
                   [&](std::size_t i) { return static_cast<double>(values[i]) * display.factor; });
  });
  return out;
}

Coloring byForeign(const Scan& scan, const ForeignColumn& column, const ColorContext& context) {
  return std::visit(
      [&]<class T>(const std::vector<T>& values) {
        const Scale scale{.title = column.name, .clipped = kClipped, .integers = std::is_integral_v<T>};
        return byNumber(scan, scale, context.scale, [&](std::size_t i) { return static_cast<double>(values[i]); });
      },
      column.values);
}

// The figures that are no columns, and the viewer's keys for them.
struct Figure {
  const ColorBy& by;
  char key;
};

std::vector<std::string> namesInOrder() {
  const Figure figures[] = {{kByRange, '4'}, {kByHeight, '7'}, {kByError, '0'}};
  std::vector<std::string> names;
  for (const char key : std::string_view("1234567890")) {
    for (const Column& column : kColumns) {
      if (column.display.key == key) names.emplace_back(ColorBy::titleOf(column));
    }
    for (const Figure& figure : figures) {
      if (figure.key == key) names.push_back(figure.by.name());
    }
  }
  names.push_back(kByMethod.name());
  for (const Column& column : kColumns) {
    if (column.display.key == 0) names.emplace_back(ColorBy::titleOf(column));
  }
  return names;
}

}  // namespace

const Column* ColorBy::column() const {
  const auto found =
      std::find_if(kColumns.begin(), kColumns.end(), [&](const Column& c) { return titleOf(c) == name_; });
  return found == kColumns.end() ? nullptr : &*found;
}

const std::vector<std::string>& colorNames() {
  static const std::vector<std::string> names = namesInOrder();
  return names;
}

std::vector<ColorBy> colorsOf(const Scan& scan) {
  std::vector<ColorBy> colors;
  for (const std::string& name : colorNames()) colors.emplace_back(name);
  for (const ForeignColumn& column : scan.foreign) colors.emplace_back(column.name);
  return colors;
}

bool hasColor(const Scan& scan, const ColorBy& by, bool errorKnown, bool methodKnown) {
  if (by == kByRange || by == kByHeight || by == kByReturn) return true;
  if (by == kByMethod) return methodKnown;
  if (by == kByError) return errorKnown || !scan[kRangeTrue].empty();
  const Column* const column = by.column();
  return column == nullptr ? foreignOf(scan, by) != nullptr : holds(scan, *column);
}

Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const ColorContext& context) {
  const ColorBy by = colorBy.value_or(defaultFor(scan));
  if (by == kByRange) {
    return byNumber(scan, {"range (m)", kClipped, 2}, context.scale,
                    [&](std::size_t i) { return distanceOf(scan, i); });
  }
  if (by == kByHeight) {
    return byNumber(scan, {"height above the sensor (m)", kClipped}, context.scale,
                    [&](std::size_t i) { return scan.position[i].z; });
  }
  if (by == kByError) return byError(scan, context);
  if (by == kByMethod) {
    return inOneColor(scan, "method", context.method.empty() ? "not known" : context.method, context.methodColor);
  }
  if (by == kByReturn) return byReturn(scan);
  if (const Column* const column = by.column()) {
    if (!holds(scan, *column) && scan.size() > 0) failForColumn(scan, by, column->name);
    return byColumn(scan, *column, context);
  }
  const ForeignColumn* const foreign = foreignOf(scan, by);
  if (foreign == nullptr) failForColumn(scan, by, by.name());
  return byForeign(scan, *foreign, context);
}

Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const Ontology* ontology) {
  return colorScan(scan, colorBy, ColorContext{.ontology = ontology});
}

}  // namespace scanmill
