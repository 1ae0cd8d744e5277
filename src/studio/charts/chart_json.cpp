#include <cmath>
#include <nlohmann/json.hpp>

#include "charts/chart.h"

namespace scanmill {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kMarks[]{"dots", "line", "line and dots", "bars"};

// Rounds a number to six significant digits, which is finer than a screen can show; null if the number is not finite.
OrderedJson numberJson(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0) return 0;
  const double unit = std::pow(10, 5 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(unit) && unit > 0 ? std::round(value * unit) / unit : value;
}

OrderedJson pairsJson(const std::vector<Vec2d>& pairs) {
  OrderedJson list = OrderedJson::array();
  for (const Vec2d& p : pairs) list.push_back({numberJson(p.x), numberJson(p.y)});
  return list;
}

OrderedJson axisJson(const ChartAxis& axis) {
  OrderedJson json{
      {"title", axis.title}, {"log", axis.scale == AxisScale::Log}, {"unit", axis.unit}, {"zero", axis.zero}};
  if (axis.low) json["low"] = *axis.low;
  if (axis.high) json["high"] = *axis.high;
  if (!axis.names.empty()) json["names"] = axis.names;
  return json;
}

}  // namespace

std::string chartJson(const Chart& chart) {
  OrderedJson json{{"stacked", chart.stacked}, {"x", axisJson(chart.x)}, {"y", axisJson(chart.y)}};
  json["series"] = OrderedJson::array();
  for (const ChartSeries& s : chart.series) {
    OrderedJson series{
        {"name", s.name},         {"color", s.color},       {"mark", kMarks[static_cast<std::size_t>(s.mark)]},
        {"strong", s.emphasised}, {"first", s.labelsFirst}, {"points", pairsJson(s.points)}};
    if (!s.spans.empty()) series["spans"] = pairsJson(s.spans);
    if (!s.labels.empty()) series["labels"] = s.labels;
    if (!s.details.empty()) series["details"] = s.details;
    if (!s.fills.empty()) series["fills"] = s.fills;
    json["series"].push_back(std::move(series));
  }
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace scanmill
