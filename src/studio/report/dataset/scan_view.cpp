#include "report/dataset/scan_view.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/hash.h"
#include "report/page/page.h"
#include "viewer/color_map.h"

namespace scanmill {

namespace {

using OrderedJson = nlohmann::ordered_json;

// Encodes numbers as base64 of their little-endian bytes, whatever the machine's byte order.
template <class Number>
OrderedJson column(const std::vector<std::uint32_t>& numbers) {
  std::string bytes;
  bytes.reserve(numbers.size() * sizeof(Number));
  for (const std::uint32_t n : numbers) {
    for (std::size_t b = 0; b < sizeof(Number); ++b) bytes += static_cast<char>(n >> (8 * b) & 0xFF);
  }
  return {{"type", fmt::format("u{}", 8 * sizeof(Number))}, {"data", base64(bytes)}};
}

// Encodes numbers in the smallest of the types u8, u16 and u32 that can represent all of them.
OrderedJson narrowColumn(const std::vector<std::uint32_t>& numbers) {
  const std::uint32_t most = numbers.empty() ? 0 : *std::ranges::max_element(numbers);
  return most < 1u << 8    ? column<std::uint8_t>(numbers)
         : most < 1u << 16 ? column<std::uint16_t>(numbers)
                           : column<std::uint32_t>(numbers);
}

class ViewData {
 public:
  ViewData(const ViewedScan& viewed, const Ontology& ontology)
      : scan_(viewed.scan), ontology_(ontology), points_(pointsToView(viewed.scan, kMostViewedPoints)) {
    json_["title"] = viewed.title;
    json_["points"] = std::ranges::count_if(scan_.position, isFinite<float>);
    json_["shown"] = points_.size();
  }

  OrderedJson make() {
    positions();
    classes();
    instances();
    json_["values"] = OrderedJson::array();
    visitTable(scan_, [&](auto key, const auto& values) {
      if (!key.row.display.inReport) return;
      const std::string_view unit = key.row.display.unit == "deg" ? "\xC2\xB0" : key.row.display.unit;
      addValues(key.row.name, unit, values, key.row.display.factor);
    });
    return std::move(json_);
  }

 private:
  void positions() {
    constexpr double kSteps = 65535;
    Box box;
    for (const std::size_t i : points_) box.add(Vec3d(scan_.position[i]));
    const Vec3d low = box.empty() ? Vec3d{} : box.low, high = box.empty() ? Vec3d{} : box.high;
    const auto stepOf = [](double extent) { return extent > 0 ? extent / kSteps : 1; };
    const Vec3d step{stepOf(high.x - low.x), stepOf(high.y - low.y), stepOf(high.z - low.z)};
    std::vector<std::uint32_t> numbers;
    const auto add = [&](double value, double from, double size) {
      numbers.push_back(static_cast<std::uint32_t>(std::clamp(std::round((value - from) / size), 0.0, kSteps)));
    };
    for (const std::size_t i : points_) {
      const Vec3d p(scan_.position[i]);
      add(p.x, low.x, step.x);
      add(p.y, low.y, step.y);
      add(p.z, low.z, step.z);
    }
    json_["box"] = {{"low", {low.x, low.y, low.z}}, {"step", {step.x, step.y, step.z}}};
    json_["position"] = column<std::uint16_t>(numbers);
  }

  void classes() {
    if (scan_[kLabel].empty()) return;
    std::map<std::uint16_t, std::uint64_t> counts;
    for (std::size_t i = 0; i < scan_.size(); ++i) {
      if (isFinite(scan_.position[i])) ++counts[scan_[kLabel][i]];
    }
    std::map<std::uint16_t, std::uint32_t> indexOf;
    OrderedJson classes = OrderedJson::array();
    for (const auto& [id, count] : counts) {
      indexOf.emplace(id, static_cast<std::uint32_t>(indexOf.size()));
      classes.push_back(
          {{"id", id}, {"name", className(&ontology_, id)}, {"color", classColor(&ontology_, id)}, {"points", count}});
    }
    std::vector<std::uint32_t> indices;
    for (const std::size_t i : points_) indices.push_back(indexOf.at(scan_[kLabel][i]));
    json_["classes"] = std::move(classes);
    json_["class"] = narrowColumn(indices);
  }

  void instances() {
    if (scan_[kInstance].empty()) return;
    std::map<std::uint32_t, std::uint32_t> indexOf;
    for (const std::size_t i : points_) indexOf.emplace(scan_[kInstance][i], 0);
    OrderedJson ids = OrderedJson::array(), colors = OrderedJson::array();
    std::uint32_t next = 0;
    for (auto& [id, index] : indexOf) {
      index = next++;
      ids.push_back(id);
      colors.push_back(instanceColor(id));
    }
    std::vector<std::uint32_t> indices;
    for (const std::size_t i : points_) indices.push_back(indexOf.at(scan_[kInstance][i]));
    json_["instances"] = {{"ids", std::move(ids)}, {"colors", std::move(colors)}};
    json_["instance"] = narrowColumn(indices);
  }

  // Adds a column of values. If all are integers from 0 to 65534, they are stored exactly; otherwise they are quantised
  // to 65534 steps, with one additional code for values that are not finite.
  template <class Number>
  void addValues(std::string_view name, std::string_view unit, const std::vector<Number>& values, double factor) {
    if (values.empty()) return;
    constexpr double kSteps = 65534, kNone = 65535;
    std::vector<double> shown;
    for (const std::size_t i : points_) shown.push_back(factor * static_cast<double>(values[i]));
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double v : shown) {
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
    }
    if (low > high) return;
    const bool integers = factor == 1 && low >= 0 && high < kNone &&
                          std::ranges::all_of(shown, [](double v) { return v == std::floor(v) && std::isfinite(v); });
    if (integers) low = 0;
    const double step = integers ? 1 : high > low ? (high - low) / kSteps : 1;
    std::vector<std::uint32_t> codes;
    for (const double v : shown) {
      codes.push_back(static_cast<std::uint32_t>(std::isfinite(v) ? std::round((v - low) / step) : kNone));
    }
    OrderedJson added = narrowColumn(codes);
    added.update({{"name", name}, {"unit", unit}, {"whole", integers}, {"low", low}, {"step", step}});
    json_["values"].push_back(std::move(added));
  }

  const Scan& scan_;
  const Ontology& ontology_;
  std::vector<std::size_t> points_;  // indices of the shown points in the scan
  OrderedJson json_;
};

// An instance or a class with at most this number of points is kept complete if possible.
constexpr std::size_t kFewPoints = 1000;

// Adds a group for each value (instance id or class) that at most kFewPoints points have. `zeroIsNone`: points with the
// value 0 form no group.
template <class Value>
void addRare(const Scan& scan, const std::vector<Value>& values, const std::vector<std::size_t>& finite,
             bool zeroIsNone, std::vector<std::pair<std::size_t, std::vector<std::size_t>>>& groups) {
  if (values.size() != scan.size()) return;
  std::map<Value, std::vector<std::size_t>> pointsOf;
  for (const std::size_t i : finite) {
    if (!zeroIsNone || values[i] != 0) pointsOf[values[i]].push_back(i);
  }
  for (auto& [value, points] : pointsOf) {
    if (points.size() <= kFewPoints) groups.emplace_back(points.size(), std::move(points));
  }
}

double weightOf(const Vec3f& position) {
  constexpr double kLeast = 1e-3;  // least weight (m²): a point at the sensor must not have the weight zero
  const Vec3d p(position);
  return std::max(dot(p, p), kLeast);
}

// Returns the factor f for which the sum of min(f * weight, 1) over all weights is `kept`. f * weight is then the
// probability of keeping a point.
double factorFor(std::vector<double> weights, double kept) {
  std::ranges::sort(weights, std::greater<>());
  double sum = 0;  // of the weights from index `certain` on
  for (const double w : weights) sum += w;
  // The points with the largest weights are certain to be kept.
  for (std::size_t certain = 0; certain < weights.size(); ++certain) {
    const double factor = (kept - static_cast<double>(certain)) / sum;
    if (factor * weights[certain] <= 1) return factor;
    sum -= weights[certain];
  }
  return 0;
}

}  // namespace

std::string scanView(const std::vector<ViewedScan>& scans, const Ontology& ontology) {
  if (scans.empty()) return "";
  constexpr int kMapColors = 64;
  OrderedJson data;
  for (int i = 0; i < kMapColors; ++i) data["viridis"].push_back(viridis(static_cast<double>(i) / (kMapColors - 1)));
  data["background"] = kBackground;
  data["none"] = kNoValue;
  for (const ViewedScan& viewed : scans) data["scans"].push_back(ViewData(viewed, ontology).make());
  return scriptJson(data.dump(-1, ' ', false, OrderedJson::error_handler_t::replace));
}

std::vector<std::size_t> pointsToView(const Scan& scan, std::size_t most) {
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i])) finite.push_back(i);
  }
  if (finite.size() <= most) return finite;

  std::vector<bool> rare(scan.size(), false);  // points that are kept whatever their distance
  std::size_t rareCount = 0;
  std::vector<std::pair<std::size_t, std::vector<std::size_t>>> groups;
  addRare(scan, scan[kInstance], finite, true, groups);
  addRare(scan, scan[kLabel], finite, false, groups);
  std::ranges::stable_sort(groups, [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [count, points] : groups) {
    if (rareCount + count > most / 2) break;
    for (const std::size_t i : points) {
      rareCount += rare[i] ? 0 : 1;
      rare[i] = true;
    }
  }

  std::vector<double> weights;
  for (const std::size_t i : finite) {
    if (!rare[i]) weights.push_back(weightOf(scan.position[i]));
  }
  const double factor = factorFor(std::move(weights), static_cast<double>(most - rareCount));
  // Add up the probabilities along the scan, and keep a point whenever the sum reaches one.
  std::vector<std::size_t> kept;
  double sum = 0.5;
  for (const std::size_t i : finite) {
    if (rare[i]) {
      kept.push_back(i);
      continue;
    }
    sum += std::min(factor * weightOf(scan.position[i]), 1.0);
    if (sum < 1) continue;
    sum -= 1;
    kept.push_back(i);
  }
  if (kept.size() > most) kept.resize(most);  // rounding may have caused one point too many
  return kept;
}

}  // namespace scanmill
