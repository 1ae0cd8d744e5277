#include "viewer/coloring.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <atomic>
#include <type_traits>

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

bool hasColumn(const Scan& scan, const Column& column) {
  return columnsOf(scan).has(columnIndex(column.name));
}

ColorBy defaultFor(const Scan& scan) {
  if (!scan[kLabel].empty()) return kByClass;
  return scan[kIntensity].empty() ? kByRange : kByIntensity;
}

// True if the legend counts the point: its position is finite and in the close-up, if there is a close-up.
bool isCounted(const Scan& scan, const ColorContext& context, std::size_t point) {
  const Vec3f& position = scan.position[point];
  return isFinite(position) && (!context.closeUp || context.closeUp->contains(Vec3d(position)));
}

// Appends a colour to `colors` for each point. idOf(point) returns the point's id, colorOf(id) the id's colour. Returns
// the colour and the number of points for each id that the legend lists.
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
  const auto causeOf = [&](std::size_t point) { return scan[kCause][point]; };
  const auto rowOf = [](std::uint32_t cause) { return findReason(static_cast<std::uint8_t>(cause)); };
  const auto colorOf = [&](std::uint32_t cause) { return rowOf(cause) ? Rgb(rowOf(cause)->color) : kNoValue; };
  for (const auto& [cause, counted] : paintPoints(scan, context, causeOf, colorOf, out.colors)) {
    const ReasonEntry* const row = rowOf(cause);
    const std::string name = row == nullptr ? fmt::format("cause {}", cause) : std::string(row->name);
    out.legend.entries.push_back({.name = name, .color = counted.color, .points = counted.count});
  }
  return out;
}

// Colours points by return number. There are few numbers, so each has a separate colour.
Coloring byReturn(const Scan& scan, const ColorContext& context) {
  constexpr double kFirstReturn = 0.7;  // position of the first return's colour on the colour map
  const bool hasOneReturn = scan[kReturn].empty() && scan.planes == 1;
  const auto numberOf = [&](std::size_t point) {
    return hasOneReturn ? 1U : scan[kReturn].empty() ? keyOf(scan, point).number + 1U : scan[kReturn][point];
  };
  const auto colorOf = [&](std::uint32_t number) {
    return number == 1 ? viridis(kFirstReturn) : instanceColor(number);
  };
  Coloring out{{}, {.title = "return"}};
  for (const auto& [number, counted] : paintPoints(scan, context, numberOf, colorOf, out.colors)) {
    const std::string name = hasOneReturn  ? "not numbered (no column `return`)"
                             : number == 0 ? "not known"
                                           : fmt::format("return {}", number);
    out.legend.entries.push_back({.name = name, .color = counted.color, .points = counted.count});
  }
  return out;
}

// Returns the percentile `rank` (0 to 1) of the values. Reorders the values, which must not be empty.
double percentile(std::vector<double>& values, double rank) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(rank * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

// How numbers are mapped to colours.
struct Scale {
  Legend legend;                // `title`, `power` and `integers` alone
  double clipped = 0;           // fraction of the values that is cut off at each end that is not fixed
  std::optional<double> low{};  // fixed ends of the scale; absent: the ends are computed from the values
  std::optional<double> high{};
};

constexpr double kClipped = 0.01;
constexpr std::size_t kMostSorted = 1'000'000;  // maximum number of values from which percentiles are computed

// Returns the ends of a scale. Ends that are not fixed are computed from the values of points with finite positions;
// they are 0 if no value is known. valueOf(point) returns a value; NaN: unknown.
ScaleRange endsOf(const Scan& scan, const Scale& scale, const auto& valueOf) {
  std::vector<double> finite;
  const std::size_t step = scale.clipped > 0 ? scan.size() / kMostSorted + 1 : 1;
  for (std::size_t i = 0; i < scan.size(); i += step) {
    const double value = valueOf(i);
    if (isFinite(scan.position[i]) && std::isfinite(value)) finite.push_back(value);
  }
  const auto endAt = [&](double rank) { return finite.empty() ? 0 : percentile(finite, rank); };
  const double low = scale.low ? *scale.low : endAt(scale.clipped);
  return {low, scale.high ? *scale.high : endAt(1 - scale.clipped)};
}

// Colours points by a number on the scale `context.scale` or, if this is absent, between the ends that endsOf()
// returns. valueOf(point) returns the number; NaN: unknown.
Coloring byNumber(const Scan& scan, const Scale& scale, const ColorContext& context, const auto& valueOf) {
  const ScaleRange ends = context.scale ? *context.scale : endsOf(scan, scale, valueOf);
  const double span = ends.high - ends.low;
  Coloring out{std::vector<Rgb>(scan.size()), scale.legend};
  std::atomic<std::uint64_t> unknown = 0;
  parallelFor(scan.size(), 1 << 14, [&](std::size_t first, std::size_t last) {
    std::uint64_t unknownInRange = 0;
    for (std::size_t i = first; i < last; ++i) {
      const double value = valueOf(i);
      const double fraction = span > 0 ? std::clamp((value - ends.low) / span, 0.0, 1.0) : 0.5;
      out.colors[i] = std::isfinite(value) ? viridis(std::pow(fraction, 1 / scale.legend.power)) : kNoValue;
      if (!std::isfinite(value) && isCounted(scan, context, i)) ++unknownInRange;
    }
    unknown += unknownInRange;
  });
  out.legend.scale = true;
  out.legend.low = ends.low;
  out.legend.high = ends.high;
  out.legend.endsChosen = context.scale.has_value();
  out.legend.unknown = unknown;
  return out;
}

double distanceOf(const Scan& scan, std::size_t point) {
  return length(Vec3d(scan.position[point]));
}

// Colours points by the errors of the context or, if it has none, by the difference from the column `range_true`.
Coloring byError(const Scan& scan, const ColorContext& context) {
  const std::string title = context.errorTitle.empty() ? "error (m)" : context.errorTitle;
  const Scale scale{.legend = {.title = title, .power = 2}, .clipped = kClipped, .low = 0.0};
  if (!context.error.empty()) {
    if (context.error.size() != scan.size()) {
      throw Error("{} errors for the {} points of a scan", context.error.size(), scan.size());
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

// Colours points by a column that the scan has. The table of columns states the kind of colours and the unit.
Coloring byColumn(const Scan& scan, const Column& column, const ColorContext& context) {
  const ColumnDisplay& display = column.display;
  if (display.colors == ColumnColors::Classes) return byClass(scan, context);
  if (display.colors == ColumnColors::Instances) return byInstance(scan, context);
  Scale scale{.legend = {.title = withUnit(ColorBy::titleOf(column), display.unit),
                         .power = display.scalePower,
                         .integers = column.type != ColumnType::Float32},
              .clipped = display.scaleClipped};
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
        const Scale scale{.legend = {.title = column.name, .integers = std::is_integral_v<T>}, .clipped = kClipped};
        return byNumber(scan, scale, context, [&](std::size_t i) { return static_cast<double>(values[i]); });
      },
      column.values);
}

}  // namespace

const Column* ColorBy::column() const {
  const auto found = std::ranges::find(kColumns, name_, titleOf);
  return found == kColumns.end() ? nullptr : &*found;
}

const std::vector<std::string>& colorNames() {
  static const std::vector<std::string> inOrder = [] {
    constexpr char kNoKey = '\0';
    const std::map<char, ColorBy> computed{{'4', kByRange}, {'7', kByHeight}, {'0', kByError}};  // not columns
    std::vector<std::string> names;
    for (const char key : {'1', '2', '3', '4', '5', '6', '7', '8', '9', '0', kNoKey}) {
      for (const Column& column : kColumns) {
        if (column.display.key == key) names.emplace_back(ColorBy::titleOf(column));
      }
      if (computed.contains(key)) names.push_back(computed.at(key).name());
    }
    return names;
  }();
  return inOrder;
}

std::vector<ColorBy> colorsOf(const Scan& scan) {
  std::vector<ColorBy> colors;
  for (const std::string& name : colorNames()) colors.emplace_back(name);
  for (const ForeignColumn& column : scan.foreign) colors.emplace_back(column.name);
  return colors;
}

bool hasColor(const Scan& scan, const ColorBy& by, bool hasErrors) {
  if (by == kByRange || by == kByHeight || by == kByReturn) return true;
  if (by == kByError) return hasErrors || !scan[kRangeTrue].empty();
  const Column* const column = by.column();
  return column == nullptr ? foreignOf(scan, by) != nullptr : hasColumn(scan, *column);
}

Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const ColorContext& context) {
  const ColorBy by = colorBy.value_or(defaultFor(scan));
  if (by == kByRange) {
    const Scale scale{.legend = {.title = "range (m)", .power = 2}, .clipped = kClipped};
    return byNumber(scan, scale, context, [&](std::size_t i) { return distanceOf(scan, i); });
  }
  if (by == kByHeight) {
    const Scale scale{.legend = {.title = "height above the sensor (m)"}, .clipped = kClipped};
    return byNumber(scan, scale, context, [&](std::size_t i) { return scan.position[i].z; });
  }
  if (by == kByError) return byError(scan, context);
  if (by == kByReturn) return byReturn(scan, context);
  if (by == kByCause && !scan[kCause].empty()) return byCause(scan, context);
  if (const Column* const column = by.column()) {
    if (!hasColumn(scan, *column) && scan.size() > 0) failForColumn(scan, by, column->name);
    return byColumn(scan, *column, context);
  }
  const ForeignColumn* const foreign = foreignOf(scan, by);
  if (foreign == nullptr) failForColumn(scan, by, by.name());
  return byForeign(scan, *foreign, context);
}

Legend classLegend(const std::map<std::uint32_t, ColorOfId>& classes, const Ontology* ontology) {
  Legend legend{.title = "class"};
  for (const auto& [id, counted] : classes) {
    legend.entries.push_back(
        {className(ontology, static_cast<std::uint16_t>(id)), counted.color, std::int64_t{id}, counted.count});
  }
  return legend;
}

Legend instanceLegend(std::map<std::uint32_t, ColorOfId> instances) {
  Legend legend{.title = "instance"};
  const std::uint64_t withoutInstance = instances[0].count;
  instances.erase(0);
  if (!instances.empty()) {
    std::uint64_t withInstance = 0;
    for (const auto& [id, counted] : instances) withInstance += counted.count;
    legend.entries.push_back({.name = pluralOf(instances.size(), "instance") + ", a colour each",
                              .color = instances.begin()->second.color,
                              .points = withInstance});
  }
  legend.entries.push_back({.name = "no instance", .color = instanceColor(0), .points = withoutInstance});
  return legend;
}

std::vector<ScaleTick> scaleTicks(const Legend& legend) {
  constexpr std::size_t kMostTicks = 6;
  // Least distance between ticks, as a fraction of the bar's length, so that labels do not overlap.
  constexpr double kLeastDistance = 0.13;
  constexpr double kSlack = 1e-9;  // tolerance as a fraction of the span, so that round values at the ends get a tick
  constexpr int kMostMultiples = 1000;
  const double low = legend.low;
  const double span = legend.high - low;
  if (!(span > 0) || !std::isfinite(span) || !(legend.power > 0)) return {{0.5, fmt::format("{:.4g}", low)}};
  std::vector<ScaleTick> ticks;
  const double largest = niceStep(std::max(span / (kMostTicks - 1), legend.integers ? 1.0 : 0.0));
  // A scale that is not linear may have room for ticks at multiples of smaller steps. niceStep(step / 2.5) is the next
  // smaller step, since consecutive steps differ by at most the factor 2.5.
  for (double step = largest; step > span / 100 && ticks.size() < kMostTicks; step = niceStep(step / 2.5)) {
    const double first = std::ceil((low - kSlack * span) / step);
    for (int k = 0; k < kMostMultiples && ticks.size() < kMostTicks; ++k) {
      const double value = (first + k) * step;
      if (value > legend.high + kSlack * span) break;
      const double position = std::pow(std::clamp((value - low) / span, 0.0, 1.0), 1 / legend.power);
      const auto isFar = [&](const ScaleTick& other) { return std::abs(other.position - position) >= kLeastDistance; };
      if (!std::ranges::all_of(ticks, isFar)) continue;
      ticks.push_back({position, fmt::format("{:.10g}", value == 0 ? 0.0 : value)});  // never "-0"
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
  if (legend.endsChosen) title += ", held";
  return title;
}

}  // namespace scanmill
