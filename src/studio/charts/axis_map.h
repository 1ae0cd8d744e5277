#pragma once

// Where a chart's values lie: ranges, ticks and pixels of an axis.

#include <optional>
#include <string>
#include <vector>

#include "charts/chart.h"

namespace scanmill {

// As an axis of this unit writes it: 0.001, 10 k, 1 M; 10 µm; 0.1 %.
std::string axisNumber(double value, const std::string& unit);

struct AxisTick {
  double value = 0;
  std::string text;
};

class AxisMap {
 public:
  // `values`: what must have a place, finite. `fromZero`: a linear axis holds zero, for bars. `pixels`: about how
  // long; a tick with text takes `tickPixels` of them.
  AxisMap(const ChartAxis& axis, const std::vector<double>& values, bool fromZero, double pixels, double tickPixels);

  // Pixels of the axis' low and high end.
  void place(double lowEnd, double highEnd);

  double at(double value) const;
  double base() const;  // where bars begin
  // The line for zeros and below, and where the band that it lies in ends; none on axes that need none.
  std::optional<double> zeroLine() const;
  double bandEnd() const { return from_; }
  const std::vector<AxisTick>& ticks() const { return ticks_; }
  const std::vector<double>& minorTicks() const { return minor_; }  // without text or grid

 private:
  double mapped(double value) const;
  void logarithmic(const ChartAxis& axis, const std::vector<double>& values, double pixels, double tickPixels);
  void linear(const ChartAxis& axis, const std::vector<double>& values, bool fromZero, double steps);

  bool log_ = false;
  bool band_ = false;
  double low_ = 0, high_ = 1;  // of logarithms on a logarithmic axis
  double lowEnd_ = 0;          // pixels
  double from_ = 0, to_ = 1;   // pixels of low_ and high_
  std::vector<AxisTick> ticks_;
  std::vector<double> minor_;
};

}  // namespace scanmill
