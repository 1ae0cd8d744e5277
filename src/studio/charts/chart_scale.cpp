#include "charts/chart_scale.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/short_text.h"

namespace scanmill {

namespace {

constexpr double kRounding = 1e-9;  // tolerance for rounding errors of values that are at a tick

// Returns the logarithm of the largest number that equals 1, 2 or 5 times a power of ten and whose logarithm is at most
// `log`.
double niceLog(double log) {
  const double decade = std::floor(log + kRounding);
  double nice = decade;
  for (const double stop : {std::log10(2), std::log10(5)}) {
    if (decade + stop <= log + kRounding) nice = decade + stop;
  }
  return nice;
}

}  // namespace

ChartScale::ChartScale(const ChartAxis& axis, const std::vector<double>& values, bool fromZero, double most)
    : log_(axis.scale == AxisScale::Log),
      hasBand_(log_ && std::ranges::any_of(values, [](double v) { return !(v > 0); })) {
  std::vector<double> shown;
  for (const double v : values) {
    if (!log_ || v > 0) shown.push_back(mapped(v));
  }
  if (!axis.names.empty()) shown = {-0.5, static_cast<double>(axis.names.size()) - 0.5};
  if (fromZero || shown.empty()) shown.push_back(0);
  const auto [least, greatest] = std::ranges::minmax(shown);
  low_ = least, high_ = greatest;
  if (axis.names.empty()) {
    widen(fromZero);
    const auto isPossible = [&](const std::optional<double>& end) { return end && (!log_ || *end > 0); };
    if (isPossible(axis.low) && mapped(*axis.low) <= least) low_ = mapped(*axis.low);
    if (isPossible(axis.high) && mapped(*axis.high) >= greatest) high_ = mapped(*axis.high);
  }
  if (hasBand_) ticks_.push_back({at(0), axis.zero});
  for (std::size_t i = 0; i < axis.names.size(); ++i) ticks_.push_back({at(static_cast<double>(i)), axis.names[i]});
  if (!axis.names.empty()) return;
  most = std::max(most, 2.0);
  log_ ? addLogarithmicTicks(axis.unit, most) : addLinearTicks(axis.unit, most);
}

double ChartScale::mapped(double value) const {
  return log_ ? std::log10(value) : value;
}

double ChartScale::at(double value) const {
  if (log_ && value <= 0) return kBand / 2;
  const double share = (mapped(value) - low_) / (high_ - low_);
  return hasBand_ ? kBand + (1 - kBand) * share : share;
}

// Adds a margin to both ends of the axis, but not below a linear axis that starts at or above zero, and rounds the ends
// of a logarithmic axis to 1, 2 or 5 times powers of ten.
void ChartScale::widen(bool fromZero) {
  constexpr double kEndMargin = 0.04;  // as a fraction of the axis
  if (!(high_ > low_)) {
    const double half = log_ || low_ == 0 ? 1 : std::abs(low_) * 0.1;
    low_ -= half, high_ += half;
  }
  const double margin = kEndMargin * (high_ - low_);
  const bool positive = !log_ && low_ >= 0;
  if (!(fromZero && low_ == 0)) low_ -= margin;
  high_ += margin;
  if (positive) low_ = std::max(low_, 0.0);
  if (log_) low_ = niceLog(low_), high_ = -niceLog(-high_);
}

void ChartScale::addLinearTicks(const std::string& unit, double most) {
  const double step = niceStep((high_ - low_) / most);
  for (double i = std::ceil(low_ / step - kRounding) + 0.0; i * step <= high_ + step * kRounding; ++i) {
    ticks_.push_back({at(i * step), axisNumber(i * step, unit)});
  }
}

// Labels 1, 2 and 5 times powers of ten, or only every n-th power of ten if there is not enough room.
void ChartScale::addLogarithmicTicks(const std::string& unit, double most) {
  const int stride = std::max(1, static_cast<int>(std::ceil((high_ - low_) / most)));
  for (int decade = static_cast<int>(std::floor(low_)); decade <= high_ + kRounding; ++decade) {
    for (const int digit : {1, 2, 5}) {
      const double log = decade + std::log10(digit);
      if (decade % stride != 0 || (digit > 1 && 3 * (high_ - low_) > most)) continue;
      const double value = digit * std::pow(10, decade);
      if (log >= low_ - kRounding && log <= high_ + kRounding) ticks_.push_back({at(value), axisNumber(value, unit)});
    }
  }
}

}  // namespace scanmill
