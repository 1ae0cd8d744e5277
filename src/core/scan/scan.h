#pragma once

// What the sensor reports and what is written: one row per point.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// A scan is dense (misses left out, height 1) or organised (width = columns, height = rings, misses have NaN positions
// and zeros elsewhere). A beam's index, ring * columns + column, is stable: it joins a noisy scan to its noise-free
// twin. Optional columns are empty where nobody asked for them.
struct Scan {
  std::uint32_t rings = 0;    // of the sensor
  std::uint32_t columns = 0;  // of the sensor
  bool organised = false;

  std::vector<Vec3f> position;          // m, sensor frame
  std::vector<float> intensity;         // unit of the intensity effect; optional
  std::vector<std::uint16_t> label;     // class id; optional
  std::vector<std::uint32_t> instance;  // 0: none; optional
  std::vector<std::uint16_t> ring;      // optional
  std::vector<std::uint16_t> column;    // optional
  std::vector<float> time;              // s since the start of the turn; optional
  std::vector<float> rangeTrue;         // m, noise-free; NaN on an organised miss; optional
  // rad, between the beam and the normal of the surface that it meets, noise-free: 0 head-on, pi/2 grazing; NaN on an
  // organised miss, and where a recording does not know the normal; optional
  std::vector<float> incidence;

  std::size_t size() const { return position.size(); }
  std::uint32_t width() const { return organised ? columns : static_cast<std::uint32_t>(size()); }
  std::uint32_t height() const { return organised ? rings : 1; }
};

// Names of the columns that a scan holds: "x", "y", "z", "intensity", "label", "instance", "ring", "column", "time",
// "range_true", "incidence", in this order.
std::vector<std::string> columnNames(const Scan& scan);

}  // namespace scanmill
