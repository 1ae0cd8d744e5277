#include "charts/chart_scale.h"

#include "base/short_text.h"

namespace scanmill {

namespace {

constexpr double kRounding = 1e-9;  // tolerance for rounding errors of values that are at a tick

// Rounds `limit`, a logarithm to base 10, down to the logarithm of 1, 2 or 5 times a power of ten.
double roundLogDown(double limit) {
  const double decade = std::floor(limit + kRounding);
  double largest = decade;
  for (const double step : {std::log10(2), std::log10(5)}) {
    if (decade + step <= limit + kRounding) largest = decade + step;
  }
  return largest;
}

}  // namespace

ChartScale::ChartScale(const ChartAxis& axis, const std::vector<double>& values, bool includesZero, double labelRoom)
    : log_(axis.scale == AxisScale::Log),
      hasBand_(log_ && std::ranges::any_of(values, [](double v) { return !(v > 0); })) {
  if (!axis.names.empty()) {
    // The name with index i covers the values from i - 0.5 to i + 0.5; the value i is in the middle.
    low_ = -0.5, high_ = static_cast<double>(axis.names.size()) - 0.5;
    for (const std::string& name : axis.names) ticks_.push_back({positionOf(static_cast<double>(ticks_.size())), name});
    return;
  }
  std::vector<double> mappedValues;
  for (const double v : values) {
    if (!log_ || v > 0) mappedValues.push_back(mapped(v));
  }
  if (includesZero || mappedValues.empty()) mappedValues.push_back(0);
  const auto [least, greatest] = std::ranges::minmax(mappedValues);
  low_ = least, high_ = greatest;
  widen(includesZero);
  const auto isOnScale = [&](const std::optional<double>& end) { return end && (!log_ || *end > 0); };
  if (isOnScale(axis.low) && mapped(*axis.low) <= least) low_ = mapped(*axis.low);
  if (isOnScale(axis.high) && mapped(*axis.high) >= greatest) high_ = mapped(*axis.high);
  if (hasBand_) ticks_.push_back({positionOf(0), axis.zero});
  labelRoom = std::max(labelRoom, 2.0);
  log_ ? addLogarithmicTicks(axis.unit, labelRoom) : addLinearTicks(axis.unit, labelRoom);
}

double ChartScale::mapped(double value) const {
  return log_ ? std::log10(value) : value;
}

double ChartScale::positionOf(double value) const {
  if (log_ && value <= 0) return kBand / 2;
  const double fraction = (mapped(value) - low_) / (high_ - low_);  // 0 at `low_`, 1 at `high_`
  return hasBand_ ? kBand + (1 - kBand) * fraction : fraction;
}

// Adds a margin to both ends of the axis; the low end of a linear axis without negative values stays at least 0. Rounds
// the ends of a logarithmic axis to 1, 2 or 5 times powers of ten.
void ChartScale::widen(bool includesZero) {
  constexpr double kEndMargin = 0.04;  // fraction of the axis's length
  if (!(high_ > low_)) {
    // If all values are equal, both ends move outwards by one decade (logarithmic), 10 % of the value or, for 0, by 1.
    const double halfLength = log_ || low_ == 0 ? 1 : std::abs(low_) * 0.1;
    low_ -= halfLength, high_ += halfLength;
  }
  const double margin = kEndMargin * (high_ - low_);
  const bool staysPositive = !log_ && low_ >= 0;
  if (!(includesZero && low_ == 0)) low_ -= margin;
  high_ += margin;
  if (staysPositive) low_ = std::max(low_, 0.0);
  // Since 1, 2 and 5 are symmetric about the decade (1/5 = 2/10), -roundLogDown(-x) rounds x up.
  if (log_) low_ = roundLogDown(low_), high_ = -roundLogDown(-high_);
}

void ChartScale::addLinearTicks(const std::string& unit, double labelRoom) {
  const double step = niceStep((high_ - low_) / labelRoom);
  for (double i = std::ceil(low_ / step - kRounding) + 0.0; i * step <= high_ + step * kRounding; ++i) {
    ticks_.push_back({positionOf(i * step), axisNumber(i * step, unit)});
  }
}

// Adds ticks at 1, 2 and 5 times powers of ten or, if there is not enough room, only at every n-th power of ten.
void ChartScale::addLogarithmicTicks(const std::string& unit, double labelRoom) {
  const double decades = high_ - low_;
  const int decadeStep = std::max(1, static_cast<int>(std::ceil(decades / labelRoom)));
  for (int decade = static_cast<int>(std::floor(low_)); decade <= high_ + kRounding; ++decade) {
    for (const int digit : {1, 2, 5}) {
      if (decade % decadeStep != 0 || (digit > 1 && 3 * decades > labelRoom)) continue;
      const double valueLog = decade + std::log10(digit);
      const double value = digit * std::pow(10, decade);
      if (valueLog >= low_ - kRounding && valueLog <= high_ + kRounding)
        ticks_.push_back({positionOf(value), axisNumber(value, unit)});
    }
  }
}

}  // namespace scanmill
