#pragma once

// The scale of a chart's axis: the positions of values along the axis, and the values that have a label.

#include <string>
#include <vector>

#include "charts/chart.h"

namespace scanmill {

// Maps values to positions along an axis, from 0 at its start to 1 at its end. On a logarithmic axis, values of zero
// and below are in a band at its start.
class ChartScale {
 public:
  static constexpr double kBand = 0.1;  // length of the band for values of zero and below

  struct Tick {
    double position;
    std::string text;
  };

  // `values`: coordinates along the axis of all marks, bars and error bars. `includesZero`: the axis includes 0 (a
  // logarithmic axis: 1), since it shows bars. `labelRoom`: number of labels for which there is room.
  ChartScale(const ChartAxis& axis, const std::vector<double>& values, bool includesZero, double labelRoom);

  double positionOf(double value) const;  // returns the position of a value
  bool hasBand() const { return hasBand_; }
  const std::vector<Tick>& ticks() const { return ticks_; }

 private:
  double mapped(double value) const;  // returns the value, or its logarithm to base 10 if the axis is logarithmic
  void widen(bool includesZero);
  void addLinearTicks(const std::string& unit, double labelRoom);
  void addLogarithmicTicks(const std::string& unit, double labelRoom);

  bool log_, hasBand_;
  double low_, high_;  // ends of the axis without the band: values, or their logarithms to base 10
  std::vector<Tick> ticks_;
};

}  // namespace scanmill
