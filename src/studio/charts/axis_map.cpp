#include "charts/axis_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace scanmill {

namespace {

constexpr double kBandPixels = 40;  // of the zeros beside a logarithmic axis
constexpr double kPad = 0.03;       // of an axis, between its ends and the data

struct Prefix {
  double factor;
  const char* text;
};
constexpr std::array<Prefix, 9> kPrefixes{{{1e12, "T"},
                                           {1e9, "G"},
                                           {1e6, "M"},
                                           {1e3, "k"},
                                           {1, ""},
                                           {1e-3, "m"},
                                           {1e-6, "\xC2\xB5"},
                                           {1e-9, "n"},
                                           {1e-12, "p"}}};

// Without the zero that C writes before an exponent of one digit: 1e-5.
std::string plainNumber(double value) {
  std::string text = fmt::format("{:.6g}", value);
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  const std::string digits = text.substr(text.find_first_not_of("+-0", e + 1));
  return fmt::format("{}e{}{}", text.substr(0, e), text[e + 1] == '-' ? "-" : "", digits);
}

// 1, 2 or 5 times a power of ten, not below `least`.
double niceStep(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

// The next of 1, 2, 5 times a power of ten below or above, as a logarithm.
double niceLog(double logarithm, bool up) {
  const double decade = std::floor(logarithm + 1e-9);
  const std::array<double, 4> stops{0, std::log10(2.0), std::log10(5.0), 1};
  if (up) {
    for (const double stop : stops) {
      if (decade + stop >= logarithm - 1e-9) return decade + stop;
    }
  }
  double best = decade;
  for (const double stop : stops) {
    if (decade + stop <= logarithm + 1e-9) best = decade + stop;
  }
  return best;
}

}  // namespace

std::string axisNumber(double value, const std::string& unit) {
  if (unit == "%") return plainNumber(value * 100) + " %";
  const std::string space = unit.empty() ? "" : " ";
  const double size = std::abs(value);
  if (size == 0) return "0" + space + unit;
  const bool small = size < 1;
  if ((small && unit.empty()) || size < 1e-13 || size >= 1e16) return plainNumber(value) + space + unit;
  for (const Prefix& prefix : kPrefixes) {
    if (size < prefix.factor * (1 - 1e-9)) continue;
    const std::string unitText = std::string(prefix.text) + unit;
    return plainNumber(value / prefix.factor) + (unitText.empty() ? "" : " " + unitText);
  }
  return plainNumber(value) + space + unit;
}

AxisMap::AxisMap(const ChartAxis& axis, const std::vector<double>& values, bool fromZero, double pixels,
                 double tickPixels) {
  if (!axis.names.empty()) {
    low_ = -0.5;
    high_ = static_cast<double>(axis.names.size()) - 0.5;
    for (const double v : values) {
      low_ = std::min(low_, v - 0.5);
      high_ = std::max(high_, v + 0.5);
    }
    for (std::size_t i = 0; i < axis.names.size(); ++i) ticks_.push_back({static_cast<double>(i), axis.names[i]});
  } else if (axis.scale == AxisScale::Log) {
    logarithmic(axis, values, pixels, tickPixels);
  } else {
    linear(axis, values, fromZero, std::max(pixels / (1.3 * tickPixels), 2.0));
  }
}

void AxisMap::logarithmic(const ChartAxis& axis, const std::vector<double>& values, double pixels, double tickPixels) {
  log_ = true;
  bool any = false;
  const auto hold = [&](double value) {
    const double logarithm = std::log10(value);
    low_ = any ? std::min(low_, logarithm) : logarithm;
    high_ = any ? std::max(high_, logarithm) : logarithm;
    any = true;
  };
  for (const double v : values) {
    if (v > 0) {
      hold(v);
    } else {
      band_ = true;
    }
  }
  if (!any && (!axis.low || !axis.high)) hold(axis.low.value_or(axis.high.value_or(1)));
  const double pad = kPad * (high_ - low_);
  const bool lowGiven = axis.low && *axis.low > 0, highGiven = axis.high && *axis.high > 0;
  if (lowGiven) hold(*axis.low);
  if (highGiven) hold(*axis.high);
  const double dataLow = low_, dataHigh = high_;
  if (!lowGiven || std::log10(*axis.low) > dataLow) low_ = niceLog(dataLow - pad, false);
  if (!highGiven || std::log10(*axis.high) < dataHigh) high_ = niceLog(dataHigh + pad, true);
  if (high_ - low_ < 0.9) {
    low_ = std::floor(low_ + 1e-9);
    high_ = std::max(std::ceil(high_ - 1e-9), low_ + 1);
  }

  const double perDecade = (pixels - (band_ ? kBandPixels : 0)) / (high_ - low_);
  const int stride = perDecade >= tickPixels ? 1 : static_cast<int>(std::ceil(tickPixels / std::max(perDecade, 0.1)));
  const bool labelled = perDecade > 4 * tickPixels;
  const int first = static_cast<int>(std::floor(low_ + 1e-9)), last = static_cast<int>(std::floor(high_ + 1e-9));
  for (int decade = first; decade <= last; ++decade) {
    for (int digit = 1; digit < 10; ++digit) {
      const double place = decade + std::log10(digit);
      if (place < low_ - 1e-9 || place > high_ + 1e-9) continue;
      const double value = digit * std::pow(10, decade);
      const bool major = digit == 1 ? decade % stride == 0 : labelled && (digit == 2 || digit == 5);
      if (major) {
        ticks_.push_back({value, axisNumber(value, axis.unit)});
      } else if (stride == 1) {
        minor_.push_back(value);
      }
    }
  }
}

void AxisMap::linear(const ChartAxis& axis, const std::vector<double>& values, bool fromZero, double steps) {
  bool any = false;
  const auto hold = [&](double value) {
    low_ = any ? std::min(low_, value) : value;
    high_ = any ? std::max(high_, value) : value;
    any = true;
  };
  for (const double v : values) hold(v);
  if (fromZero || !any) hold(0);
  const double pad = kPad * (high_ - low_);
  const bool zeroLow = fromZero && low_ == 0, zeroHigh = fromZero && high_ == 0;
  const bool lowGiven = axis.low && *axis.low <= low_, highGiven = axis.high && *axis.high >= high_;
  if (axis.low) hold(*axis.low);
  if (axis.high) hold(*axis.high);
  if (!(high_ > low_)) {
    const double half = low_ == 0 ? 1 : std::abs(low_) * 0.1;
    if (!lowGiven && !zeroLow) low_ -= half;
    if (!highGiven) high_ += half;
  }
  const double step = niceStep((high_ - low_) / steps);
  const bool positive = low_ >= 0;  // an axis of what cannot be negative does not go there
  if (!lowGiven && !zeroLow) low_ = std::floor((low_ - pad) / step) * step;
  if (!highGiven && !zeroHigh) high_ = std::ceil((high_ + pad) / step) * step;
  if (positive) low_ = std::max(low_, 0.0);
  const auto first = static_cast<std::int64_t>(std::ceil(low_ / step - 1e-9));
  for (std::int64_t i = first; static_cast<double>(i) * step <= high_ + step * 1e-9; ++i) {
    const double value = static_cast<double>(i) * step;
    ticks_.push_back({value, axisNumber(value, axis.unit)});
  }
}

void AxisMap::place(double lowEnd, double highEnd) {
  lowEnd_ = from_ = lowEnd;
  to_ = highEnd;
  if (band_) from_ += highEnd > lowEnd ? kBandPixels : -kBandPixels;
}

double AxisMap::mapped(double value) const {
  return (value - low_) / (high_ - low_) * (to_ - from_) + from_;
}

double AxisMap::at(double value) const {
  if (!log_) return mapped(value);
  if (value > 0) return mapped(std::log10(value));
  return (lowEnd_ + from_) / 2;
}

double AxisMap::base() const {
  if (log_) return lowEnd_;
  return mapped(std::clamp(0.0, low_, high_));
}

std::optional<double> AxisMap::zeroLine() const {
  if (!band_) return std::nullopt;
  return (lowEnd_ + from_) / 2;
}

}  // namespace scanmill
