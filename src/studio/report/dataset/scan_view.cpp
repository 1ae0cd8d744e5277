#include "report/dataset/scan_view.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <utility>

#include "base/hash.h"
#include "report/page/page.h"
#include "viewer/color_map.h"

namespace scanmill {

namespace {

using OrderedJson = nlohmann::ordered_json;

// Encodes numbers of `size` bytes as base64 of their little-endian bytes, whatever the machine's byte order.
OrderedJson column(const std::vector<std::uint32_t>& numbers, std::size_t size) {
  std::string bytes;
  bytes.reserve(numbers.size() * size);
  for (const std::uint32_t n : numbers) {
    for (std::size_t b = 0; b < size; ++b) bytes += static_cast<char>(n >> (8 * b) & 0xFF);
  }
  return {{"type", fmt::format("u{}", 8 * size)}, {"data", base64(bytes)}};
}

// Encodes numbers in the smallest of the types u8, u16 and u32 that can represent all of them.
OrderedJson narrowColumn(const std::vector<std::uint32_t>& numbers) {
  const std::uint32_t most = numbers.empty() ? 0 : *std::ranges::max_element(numbers);
  return column(numbers, most < 1u << 8 ? 1 : most < 1u << 16 ? 2 : 4);
}

// Builds the JSON of one scan, as scan_view.h describes it.
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
  // Adds the positions, quantised to 16 bits within the shown points' bounding box.
  void positions() {
    constexpr double kSteps = 65535;
    Box box;
    for (const std::size_t i : points_) box.add(Vec3d(scan_.position[i]));
    const Vec3d low = box.empty() ? Vec3d{} : box.low, high = box.empty() ? Vec3d{} : box.high;
    const auto stepFor = [](double extent) { return extent > 0 ? extent / kSteps : 1; };
    const Vec3d step{stepFor(high.x - low.x), stepFor(high.y - low.y), stepFor(high.z - low.z)};
    const auto quantised = [&](double value, double lowest, double stepSize) {
      return static_cast<std::uint32_t>(std::clamp(std::round((value - lowest) / stepSize), 0.0, kSteps));
    };
    std::vector<std::uint32_t> numbers;
    for (const std::size_t i : points_) {
      const Vec3d p(scan_.position[i]);
      numbers.insert(numbers.end(),
                     {quantised(p.x, low.x, step.x), quantised(p.y, low.y, step.y), quantised(p.z, low.z, step.z)});
    }
    json_["box"] = {{"low", {low.x, low.y, low.z}}, {"step", {step.x, step.y, step.z}}};
    json_["position"] = column(numbers, 2);
  }

  // Returns, for each shown point, the index of its value among the keys of `entries`. All shown values must be keys.
  std::vector<std::uint32_t> indicesIn(const auto& entries, const auto& values) const {
    std::map<std::uint32_t, std::uint32_t> indexOf;
    for (const auto& [value, count] : entries) indexOf.emplace(value, static_cast<std::uint32_t>(indexOf.size()));
    std::vector<std::uint32_t> indices;
    for (const std::size_t i : points_) indices.push_back(indexOf.at(values[i]));
    return indices;
  }

  // Adds the list of the classes in the complete scan, and for each shown point the index of its class in this list.
  void classes() {
    if (scan_[kLabel].empty()) return;
    std::map<std::uint16_t, std::uint64_t> pointsOfClass;
    for (std::size_t i = 0; i < scan_.size(); ++i) {
      if (isFinite(scan_.position[i])) ++pointsOfClass[scan_[kLabel][i]];
    }
    json_["classes"] = OrderedJson::array();
    for (const auto& [id, points] : pointsOfClass) {
      json_["classes"].push_back(
          {{"id", id}, {"name", className(&ontology_, id)}, {"color", classColor(&ontology_, id)}, {"points", points}});
    }
    json_["class"] = narrowColumn(indicesIn(pointsOfClass, scan_[kLabel]));
  }

  // Adds the list of the instances with shown points, and for each shown point the index of its instance in this list.
  void instances() {
    if (scan_[kInstance].empty()) return;
    std::map<std::uint32_t, std::uint64_t> pointsOfInstance;
    for (const std::size_t i : points_) ++pointsOfInstance[scan_[kInstance][i]];
    OrderedJson ids = OrderedJson::array(), colors = OrderedJson::array();
    for (const auto& [id, points] : pointsOfInstance) {
      ids.push_back(id);
      colors.push_back(instanceColor(id));
    }
    json_["instances"] = {{"ids", std::move(ids)}, {"colors", std::move(colors)}};
    json_["instance"] = narrowColumn(indicesIn(pointsOfInstance, scan_[kInstance]));
  }

  // Adds a column of values. If all are integers from 0 to 65534, they are stored exactly; otherwise they are quantised
  // to 65534 steps, with one additional code for values that are not finite.
  template <class Number>
  void addValues(std::string_view name, std::string_view unit, const std::vector<Number>& values, double factor) {
    if (values.empty()) return;
    constexpr double kSteps = 65534, kNone = 65535;
    std::vector<double> shown;  // values of the shown points, in the unit of the page
    for (const std::size_t i : points_) shown.push_back(factor * static_cast<double>(values[i]));
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double v : shown) {
      if (!std::isfinite(v)) continue;
      low = std::min(low, v);
      high = std::max(high, v);
    }
    if (low > high) return;  // no value is finite
    const bool areIntegers = factor == 1 && low >= 0 && high < kNone && std::ranges::all_of(shown, [](double v) {
                               return v == std::floor(v) && std::isfinite(v);
                             });
    if (areIntegers) low = 0;
    const double step = areIntegers ? 1 : high > low ? (high - low) / kSteps : 1;
    std::vector<std::uint32_t> codes;
    for (const double v : shown) {
      codes.push_back(static_cast<std::uint32_t>(std::isfinite(v) ? std::round((v - low) / step) : kNone));
    }
    OrderedJson added = narrowColumn(codes);
    added.update({{"name", name}, {"unit", unit}, {"whole", areIntegers}, {"low", low}, {"step", step}});
    json_["values"].push_back(std::move(added));
  }

  const Scan& scan_;
  const Ontology& ontology_;
  std::vector<std::size_t> points_;  // indices of the shown points in the scan
  OrderedJson json_;
};

// Instances and classes with at most this number of points count as rare, see pointsToView().
constexpr std::size_t kFewPoints = 1000;

using PointGroup = std::vector<std::size_t>;  // indices of points

// For each value (instance id or class) that at most kFewPoints of `finitePoints` have, adds the group of these points.
// `values`: the value of each point of the scan, or empty; then no group is added. `noGroup`: a value without a group.
template <class Value>
void addRareGroups(const std::vector<Value>& values, const std::vector<std::size_t>& finitePoints,
                   std::optional<Value> noGroup, std::vector<PointGroup>& groups) {
  if (values.empty()) return;
  std::map<Value, PointGroup> pointsOf;
  for (const std::size_t i : finitePoints) pointsOf[values[i]].push_back(i);
  for (auto& [value, points] : pointsOf) {
    if (points.size() <= kFewPoints && noGroup != value) groups.push_back(std::move(points));
  }
}

// Returns a point's weight: the squared distance (m²), to which the probability of keeping the point is proportional.
double weightOf(const Vec3f& position) {
  constexpr double kLeastWeight = 1e-3;  // a point at the sensor must not have the weight zero
  const Vec3d p(position);
  return std::max(dot(p, p), kLeastWeight);
}

// Returns the factor f for which the sum of min(f * weight, 1) over all weights is `keptPoints`, which must be less
// than the number of weights. The probability of keeping a point is then min(f * weight, 1).
double probabilityFactor(std::vector<double> weights, double keptPoints) {
  std::ranges::sort(weights, std::greater<>());
  double weightSum = std::accumulate(weights.begin(), weights.end(), 0.0);  // sum without the certain points
  // The points with the largest weights are certain to be kept.
  for (std::size_t certainPoints = 0; certainPoints < weights.size(); ++certainPoints) {
    const double factor = (keptPoints - static_cast<double>(certainPoints)) / weightSum;
    if (factor * weights[certainPoints] <= 1) return factor;
    weightSum -= weights[certainPoints];
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

  std::vector<bool> isRare(scan.size(), false);  // true: the point is kept whatever its distance
  std::size_t rarePoints = 0;
  std::vector<PointGroup> groups;
  addRareGroups(scan[kInstance], finite, {0}, groups);  // 0: no instance
  addRareGroups(scan[kLabel], finite, {}, groups);
  std::ranges::stable_sort(groups, {}, [](const PointGroup& group) { return group.size(); });
  for (const PointGroup& group : groups) {
    if (rarePoints + group.size() > most / 2) break;
    for (const std::size_t i : group) {
      rarePoints += isRare[i] ? 0 : 1;
      isRare[i] = true;
    }
  }

  std::vector<double> weights;
  for (const std::size_t i : finite) {
    if (!isRare[i]) weights.push_back(weightOf(scan.position[i]));
  }
  const double factor = probabilityFactor(std::move(weights), static_cast<double>(most - rarePoints));
  // Add up the probabilities along the scan, and keep a point whenever the sum reaches one.
  std::vector<std::size_t> kept;
  double sum = 0.5;
  for (const std::size_t i : finite) {
    if (!isRare[i]) {
      sum += std::min(factor * weightOf(scan.position[i]), 1.0);
      if (sum < 1) continue;
      sum -= 1;
    }
    kept.push_back(i);
  }
  if (kept.size() > most) kept.resize(most);  // rounding may have caused one point too many
  return kept;
}

}  // namespace scanmill
