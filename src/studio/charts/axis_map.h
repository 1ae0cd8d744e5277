#pragma once

// Places a chart's values: the range, the ticks and the pixels of an axis.

#include <optional>
#include <string>
#include <vector>

#include "charts/chart.h"

namespace scanmill {

// A number as an axis with this unit writes it: "0.001", "10 k", "1 M"; "10 µm"; "0.1 %".
std::string axisNumber(double value, const std::string& unit);

struct AxisTick {
  double value = 0;
  std::string text;
};

class AxisMap {
 public:
  // The axis has a place for all `values`, which must be finite. With `fromZero` a linear axis includes zero, as bars
  // need it. It is about `pixels` long, of which a tick with its text takes `tickPixels`.
  AxisMap(const ChartAxis& axis, const std::vector<double>& values, bool fromZero, double pixels, double tickPixels);

  // Sets the pixels of the axis' low and high end.
  void place(double lowEnd, double highEnd);

  double at(double value) const;  // the pixel of a value
  double base() const;            // the pixel at which bars begin
  // The pixel of the line for values of zero and below, and the pixel at which the band around it ends. Absent on axes
  // that have no such line.
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
  double lowEnd_ = 0;          // pixel of the axis' low end
  double from_ = 0, to_ = 1;   // pixels of low_ and high_
  std::vector<AxisTick> ticks_;
  std::vector<double> minor_;
};

}  // namespace scanmill
