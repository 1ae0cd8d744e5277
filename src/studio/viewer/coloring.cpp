#include "viewer/coloring.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <type_traits>
#include <variant>

#include "base/error.h"
#include "base/parallel.h"
#include "base/short_text.h"
#include "scan/reasons.h"

namespace scanmill {

namespace {

[[noreturn]] void failForColumn(const Scan& scan, const ColorBy& by, std::string_view column) {
  throw InputError(
      fmt::format("the scan has no column '{}', which colours by {} need; it has {} (a dataset's scans have "
                  "what `output.columns` of its pipeline names)",
                  column, by.name(), fmt::join(columnNames(scan), ", ")));
}

const ForeignColumn* foreignOf(const Scan& scan, const ColorBy& by) {
  const auto found = std::ranges::find(scan.foreign, by.name(), &ForeignColumn::name);
  return found == scan.foreign.end() ? nullptr : &*found;
}

bool holds(const Scan& scan, const Column& column) {
  return columnsOf(scan).has(columnIndex(column.name));
}

ColorBy defaultFor(const Scan& scan) {
  if (!scan[kLabel].empty()) return kByClass;
  return scan[kIntensity].empty() ? kByRange : kByIntensity;
}

// True if the legend counts the point.
bool isCounted(const Scan& scan, const ColorContext& context, std::size_t point) {
  const Vec3f& position = scan.position[point];
  return isFinite(position) && (!context.closeUp || context.closeUp->holds(Vec3d(position)));
}

// Colours points by ids. Returns the ids of the points that the legend counts.
std::map<std::uint32_t, ColorOfId> paintPoints(const Scan& scan, const ColorContext& context, const auto& idOf,
                                               const auto& colorOf, std::vector<Rgb>& colors) {
  return paint(
      scan.size(), idOf, colorOf, [&](std::size_t i) { return isCounted(scan, context, i); }, colors);
}

Coloring byClass(const Scan& scan, const ColorContext& context) {
  Coloring out;
  const auto color = [&](std::uint32_t id) { return classColor(context.ontology, static_cast<std::uint16_t>(id)); };
  const auto id = [&](std::size_t i) { return scan[kLabel][i]; };
  out.legend = classLegend(paintPoints(scan, context, id, color, out.colors), context.ontology);
  return out;
}

Coloring byInstance(const Scan& scan, const ColorContext& context) {
  Coloring out;
  const auto id = [&](std::size_t i) { return scan[kInstance][i]; };
  out.legend = instanceLegend(paintPoints(scan, context, id, instanceColor, out.colors));
  return out;
}

// Colours points by cause. Causes are categories without an order, so each has a separate colour.
Coloring byCause(const Scan& scan, const ColorContext& context) {
  Coloring out{{}, {.title = std::string(kCause.row.name)}};
  const auto cause = [&](std::size_t i) { return scan[kCause][i]; };
  const auto reason = [](std::uint32_t of) { return findReason(static_cast<std::uint8_t>(of)); };
  const auto color = [&](std::uint32_t of) { return reason(of) == nullptr ? kNoValue : Rgb(reason(of)->color); };
  for (const auto& [of, held] : paintPoints(scan, context, cause, color, out.colors)) {
    const ReasonEntry* const known = reason(of);
    const std::string name = known == nullptr ? fmt::format("cause {}", of) : std::string(known->name);
    out.legend.entries.push_back({name, held.color, -1, held.count});
  }
  return out;
}

// Colours points by return number. There are few numbers, so each has a separate colour.
Coloring byReturn(const Scan& scan, const ColorContext& context) {
  constexpr double kFirstReturn = 0.7;  // position of the first return's colour on the colour map
  const bool single = scan[kReturn].empty() && scan.planes == 1;
  const auto number = [&](std::size_t i) {
    return single ? 1U : scan[kReturn].empty() ? keyOf(scan, i).number + 1U : scan[kReturn][i];
  };
  const auto color = [&](std::uint32_t of) { return of == 1 ? viridis(kFirstReturn) : instanceColor(of); };
  Coloring out{{}, {.title = "return"}};
  for (const auto& [of, held] : paintPoints(scan, context, number, color, out.colors)) {
    const std::string name = single    ? "first return (the only one)"
                             : of == 0 ? "not known"
                                       : fmt::format("return {}", of);
    out.legend.entries.push_back({name, held.color, -1, held.count});
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
  double clipped = 0;  // fraction of the values to cut off at an end that is not fixed
  double power = 1;
  std::optional<double> low{};  // fixed ends of the scale; absent: the ends are computed from the values
  std::optional<double> high{};
  bool integers = false;
};

constexpr double kClipped = 0.01;
constexpr std::size_t kMostSorted = 1'000'000;  // maximum number of values from which percentiles are computed

// Colours points by a number. at(i) returns the value of point i. If the context has no ends of the scale, `scale`
// states how they follow from the values.
Coloring byNumber(const Scan& scan, const Scale& scale, const ColorContext& context, const auto& at) {
  const std::optional<ScaleRange>& given = context.scale;
  Coloring out{{}, {.title = scale.title, .scale = true, .power = scale.power}};
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
      if (!std::isfinite(value) && isCounted(scan, context, i)) ++missing;
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
    Coloring out = byNumber(scan, scale, context, [&](std::size_t i) { return context.error[i]; });
    out.legend.whyUnknown = context.whyNoError;
    return out;
  }
  if (scan[kRangeTrue].empty() && scan.size() > 0) {
    throw InputError(
        fmt::format("colours by error need something to compare with: name `range_true` in output.columns of the "
                    "pipeline, or give the noise-free reference; the scan has {}",
                    fmt::join(columnNames(scan), ", ")));
  }
  return byNumber(scan, scale, context,
                  [&](std::size_t i) { return std::abs(distanceOf(scan, i) - scan[kRangeTrue][i]); });
}

Coloring byColumn(const Scan& scan, const Column& column, const ColorContext& context) {
  if (column.display.colors == ColumnColors::Classes) return byClass(scan, context);
  if (column.display.colors == ColumnColors::Instances) return byInstance(scan, context);
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
    out =
        byNumber(scan, scale, context, [&](std::size_t i) { return static_cast<double>(values[i]) * display.factor; });
  });
  return out;
}

Coloring byForeign(const Scan& scan, const ForeignColumn& column, const ColorContext& context) {
  return std::visit(
      [&]<class T>(const std::vector<T>& values) {
        const Scale scale{.title = column.name, .clipped = kClipped, .integers = std::is_integral_v<T>};
        return byNumber(scan, scale, context, [&](std::size_t i) { return static_cast<double>(values[i]); });
      },
      column.values);
}

std::vector<std::string> namesInOrder() {
  // The quantities that are not columns, and the keys in the viewer that select them.
  const std::map<char, ColorBy> figures{{'4', kByRange}, {'7', kByHeight}, {'0', kByError}};
  std::vector<std::string> names;
  for (const char key : {'1', '2', '3', '4', '5', '6', '7', '8', '9', '0', '\0'}) {  // 0: columns without a key
    for (const Column& column : kColumns) {
      if (column.display.key == key) names.emplace_back(ColorBy::titleOf(column));
    }
    if (figures.contains(key)) names.push_back(figures.at(key).name());
  }
  return names;
}

}  // namespace

const Column* ColorBy::column() const {
  const auto found = std::ranges::find(kColumns, name_, titleOf);
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

bool hasColor(const Scan& scan, const ColorBy& by, bool errorKnown) {
  if (by == kByRange || by == kByHeight || by == kByReturn) return true;
  if (by == kByError) return errorKnown || !scan[kRangeTrue].empty();
  const Column* const column = by.column();
  return column == nullptr ? foreignOf(scan, by) != nullptr : holds(scan, *column);
}

Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const ColorContext& context) {
  const ColorBy by = colorBy.value_or(defaultFor(scan));
  if (by == kByRange) {
    return byNumber(scan, {"range (m)", kClipped, 2}, context, [&](std::size_t i) { return distanceOf(scan, i); });
  }
  if (by == kByHeight) {
    return byNumber(scan, {"height above the sensor (m)", kClipped}, context,
                    [&](std::size_t i) { return scan.position[i].z; });
  }
  if (by == kByError) return byError(scan, context);
  if (by == kByReturn) return byReturn(scan, context);
  if (by == kByCause && !scan[kCause].empty()) return byCause(scan, context);
  if (const Column* const column = by.column()) {
    if (!holds(scan, *column) && scan.size() > 0) failForColumn(scan, by, column->name);
    return byColumn(scan, *column, context);
  }
  const ForeignColumn* const foreign = foreignOf(scan, by);
  if (foreign == nullptr) failForColumn(scan, by, by.name());
  return byForeign(scan, *foreign, context);
}

Legend classLegend(const std::map<std::uint32_t, ColorOfId>& present, const Ontology* ontology) {
  Legend legend{.title = "class"};
  for (const auto& [id, held] : present) {
    legend.entries.push_back(
        {className(ontology, static_cast<std::uint16_t>(id)), held.color, std::int64_t{id}, held.count});
  }
  return legend;
}

Legend instanceLegend(std::map<std::uint32_t, ColorOfId> present) {
  Legend legend{.title = "instance"};
  const std::uint64_t none = present[0].count;
  present.erase(0);
  if (!present.empty()) {
    std::uint64_t counted = 0;
    for (const auto& [id, held] : present) counted += held.count;
    legend.entries.push_back(
        {pluralOf(present.size(), "instance") + ", a colour each", present.begin()->second.color, -1, counted});
  }
  legend.entries.push_back({"no instance", instanceColor(0), -1, none});
  return legend;
}

std::vector<ScaleTick> scaleTicks(const Legend& legend) {
  constexpr std::size_t kMostTicks = 6;
  // Least distance between ticks, as a fraction of the bar's length, so that labels do not overlap.
  constexpr double kApart = 0.13;
  constexpr double kSlack = 1e-9;  // tolerance as a fraction of the span, so that round values at the ends get a tick
  constexpr int kMostMultiples = 1000;
  const double low = legend.low;
  const double span = legend.high - low;
  if (!(span > 0) || !std::isfinite(span) || !(legend.power > 0)) return {{0.5, fmt::format("{:.4g}", low)}};
  std::vector<ScaleTick> ticks;
  const double largest = niceStep(std::max(span / (kMostTicks - 1), legend.integers ? 1.0 : 0.0));
  // The next smaller steps add ticks where a scale that is not linear has room.
  for (double step = largest; step > span / 100 && ticks.size() < kMostTicks; step = niceStep(step / 2.5)) {
    const double first = std::ceil((low - kSlack * span) / step);
    for (int k = 0; k < kMostMultiples && ticks.size() < kMostTicks; ++k) {
      const double value = (first + k) * step;
      if (value > legend.high + kSlack * span) break;
      const double share = std::pow(std::clamp((value - low) / span, 0.0, 1.0), 1 / legend.power);
      const auto isFar = [&](const ScaleTick& other) { return std::abs(other.position - share) >= kApart; };
      if (std::ranges::all_of(ticks, isFar)) ticks.push_back({share, fmt::format("{:.10g}", value == 0 ? 0.0 : value)});
    }
    if (legend.power == 1 || (legend.integers && step <= 1)) break;
  }
  if (ticks.empty()) return {{0, fmt::format("{:.6g}", low)}, {1, fmt::format("{:.6g}", legend.high)}};
  std::ranges::sort(ticks, {}, &ScaleTick::position);
  return ticks;
}

std::string scaleTitle(const Legend& legend) {
  std::string title = legend.title;
  if (legend.power == 2) title += ", by its square root";
  if (legend.held) title += ", held";
  return title;
}

}  // namespace scanmill
