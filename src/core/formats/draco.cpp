// draco: Google Draco point clouds, sequential, so points keep their order and identical ones stay.
//
//   format: draco
//   max_error_mm: 1     # Euclidean, of a position; range_true keeps the same bound
//   speed: 7            # Draco's scale, 10 the least effort; here it only sets the precision of the probabilities
//   intensity_bits: 0   # 0 keeps every bit; else as many over the span of each scan's intensities
//   time: false         # time follows from ring and column by the beam table in the manifest, so it is left out
//
// POSITION is a quantised float32 attribute: any reader gets metres. The others are GENERIC with a metadata entry
// "name" (label, instance, ring, column, intensity, time, range_true, incidence). Integers have the narrowest of u8,
// u16 and u32 and are never changed; intensities that are all integers up to 65535 are such too, others are float32.
// Incidences are quantised, within 0.1 mrad. The geometry's metadata holds rings and columns of the sensor. Misses are
// left out: ring and column join what stays.
//
// What was measured (tests/benchmarks/encoders.cpp): a street seen by 64 x 2048 beams with 10 mm of range noise, in
// firing and in image order; xyz, intensity, label, instance, ring, column; 1 mm. Million points per second of
// processor time on one core of an AMD EPYC (family 26) that had other work too, and bytes a point:
//
//   this file: quantised floats, narrow integers                31, 34     3.6, 2.6
//   Draco's encoder, the same attributes                        8.0, 8.4   3.6, 2.6
//     with integer positions: no faster, and not in metres      7.6, 8.4   3.6, 2.6
//     without entropy coding                                     15, 15     14, 14
//     kd-tree, which reorders the points                        4.2, 4.3   7.2, 7.2
//     with de-duplication                                       2.7, 3.6   3.6, 2.6
//     u32 ids and the bits of the time as u32                   0.3, 0.3   3.8, 4.8
//
// The last line is Draco's table of frequencies, as long as the largest correction: about 0.7 GB for the bits of times.
// Speed 0 saves up to 1.4 % of the bytes and decodes at 5.5 and 8.5 instead of 11 and 13, so the default is 7.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

#include "formats/columns.h"
#include "formats/draco_reader.h"
#include "formats/draco_writer.h"
#include "formats/grid.h"
#include "formats/makers.h"
#include "formats/scratch.h"

namespace scanmill {

namespace {

// Beside the points' own: metadata and descriptors; tables of probabilities of the lengths of symbols.
constexpr double kMostHeaderBytes = 100;
constexpr double kMostColumnBytes = 200;

// rad, 0.006 deg: less than the 0.35 mrad between the angles whose float32 cosines are nearest to 1.
constexpr double kIncidenceError = 1e-4;

// What an entry of symbols of so many bits takes at most: its length, the symbols themselves, and less than one for
// probabilities that are rounded. Symbols with probabilities of their own are only taken where they are shorter.
double symbolBits(int bits, int components) {
  return bits * components + std::log2(bits + 1.0) + 1;
}

struct DracoOptions {
  double maxError = 0;  // m
  int speed = 0;
  int intensityBits = 0;
  bool time = false;
};

bool allFinite(std::span<const float> values) {
  // A sum of v * 0 is 0 unless some v is not finite; several sums let the loop be vectorised in any order.
  float sums[16] = {};
  std::size_t i = 0;
  for (; i + 16 <= values.size(); i += 16) {
    for (std::size_t k = 0; k < 16; ++k) sums[k] += values[i + k] * 0.0f;
  }
  for (; i < values.size(); ++i) sums[0] += values[i] * 0.0f;
  return std::all_of(std::begin(sums), std::end(sums), [](float sum) { return sum == 0; });
}

// Values as integers, empty unless each is exactly one of 0 to 65535 (-0 is none).
std::vector<std::uint16_t> asIntegers(std::span<const float> values) {
  std::vector<std::uint16_t> integers(values.size());
  std::uint32_t different = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool fits = values[i] >= 0 && values[i] <= 65535;  // false for NaN
    const auto integer = static_cast<std::uint16_t>(fits ? values[i] : 0.0f);
    integers[i] = integer;
    // The sign is looked at by itself: without trapping mathematics g++ turns the two conversions into a truncation,
    // and that keeps the sign of -0.
    const auto bits = std::bit_cast<std::uint32_t>(values[i]);
    different |= (std::bit_cast<std::uint32_t>(static_cast<float>(integer)) ^ bits) | (bits >> 31);
  }
  if (different != 0) integers.clear();
  return integers;
}

// Valid until the thread makes another.
QuantisedColumn onGrid(std::span<const float> values, const Grid& grid) {
  thread_local Scratch<std::int32_t> scratch;
  std::int32_t* indices = scratch.get(values.size());
  quantise(values, grid, indices);
  return {{indices, values.size()}, grid.low, grid.step};
}

class DracoFormat : public Format {
 public:
  explicit DracoFormat(const DracoOptions& options) : options_(options) {}

  std::string_view suffix() const override { return "drc"; }
  double maxError() const override { return options_.maxError; }
  bool keepsMisses() const override { return false; }

  double mostBytes(const ScanOutline& outline) const override {
    double bits = symbolBits(mostIndexBits(outline.reach, 3, options_.maxError), 3);
    double columns = 1;
    visitNamedColumns(outline.names, [&]<class T>(std::string_view name, const std::vector<T>&) {
      if (name == "time" && !options_.time) return;
      ++columns;
      if (name == "range_true") {
        bits += symbolBits(mostIndexBits(outline.reach, 1, options_.maxError), 1);
      } else if (std::is_floating_point_v<T>) {
        bits += 32;  // more than integers and quantised values take
      } else {
        const std::uint32_t largest = name == "ring"     ? outline.rings
                                      : name == "column" ? outline.columns
                                                         : std::numeric_limits<T>::max();
        bits += symbolBits(std::bit_width(largest), 1);
      }
    });
    return kMostHeaderBytes + columns * kMostColumnBytes + static_cast<double>(outline.points) * bits / 8;
  }

  std::string encode(const Scan& scan) const override {
    requireConsistent(scan);
    const float* coordinates = reinterpret_cast<const float*>(scan.position.data());
    if (allFinite({coordinates, 3 * scan.size()})) return encodeDense(scan);
    return encodeDense(withoutMisses(scan));
  }

  Scan decode(std::string_view bytes, const std::string& what) const override { return readDraco(bytes, what); }

 private:
  std::string encodeDense(const Scan& scan) const {
    if (scan.size() > std::numeric_limits<std::int32_t>::max() / 4) {
      throw Error(fmt::format("{} points are more than Draco holds", scan.size()));
    }
    DracoWriter writer(static_cast<std::uint32_t>(scan.size()), 10 - options_.speed);
    writer.addEntry("rings", static_cast<std::int32_t>(scan.rings));
    writer.addEntry("columns", static_cast<std::int32_t>(scan.columns));
    if (scan.size() == 0) return writer.finish();
    addPosition(scan, writer);
    if (!scan.intensity.empty()) addIntensity(scan, writer);
    if (!scan.label.empty()) writer.addIntegers("label", scan.label);
    if (!scan.instance.empty()) writer.addIntegers("instance", scan.instance);
    if (!scan.ring.empty()) writer.addIntegers("ring", scan.ring);
    if (!scan.column.empty()) writer.addIntegers("column", scan.column);
    if (options_.time && !scan.time.empty()) writer.addFloats("time", scan.time);
    if (!scan.rangeTrue.empty()) addBounded("range_true", scan.rangeTrue, options_.maxError, writer);
    if (!scan.incidence.empty()) addIncidence(scan, writer);
    return writer.finish();
  }

  void addPosition(const Scan& scan, DracoWriter& writer) const {
    Vec3f low = scan.position[0];
    Vec3f high = low;
    for (const Vec3f& p : scan.position) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const Grid grid = chooseGrid({&low.x, 3}, {&high.x, 3}, options_.maxError, "draco: a scan");
    writer.addPosition(onGrid({reinterpret_cast<const float*>(scan.position.data()), 3 * scan.size()}, grid));
  }

  void addIntensity(const Scan& scan, DracoWriter& writer) const {
    const std::vector<std::uint16_t> integers = asIntegers(scan.intensity);
    if (!integers.empty()) return writer.addIntegers("intensity", integers);
    if (options_.intensityBits > 0 && allFinite(scan.intensity)) {
      const auto [low, high] = std::minmax_element(scan.intensity.begin(), scan.intensity.end());
      const double bound = (double{*high} - double{*low}) / (std::exp2(options_.intensityBits) - 1) / 2;
      // A narrow span far from zero has no more bits than these to give: it stays as it is.
      if (bound > std::max(std::fabs(*low), std::fabs(*high)) * 0x1p-21) {
        const Grid grid = chooseGrid({&*low, 1}, {&*high, 1}, bound, "draco: intensity");
        return writer.addQuantised("intensity", onGrid(scan.intensity, grid));
      }
    }
    writer.addFloats("intensity", scan.intensity);
  }

  static void addIncidence(const Scan& scan, DracoWriter& writer) {
    // A foreign scan may hold anything under this name.
    const auto isAngle = [](float angle) { return angle >= 0 && angle < 2; };
    if (!std::all_of(scan.incidence.begin(), scan.incidence.end(), isAngle)) {
      return writer.addFloats("incidence", scan.incidence);
    }
    addBounded("incidence", scan.incidence, kIncidenceError, writer);
  }

  static void addBounded(const std::string& name, std::span<const float> values, double bound, DracoWriter& writer) {
    if (!allFinite(values)) return writer.addFloats(name, values);
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const Grid grid = chooseGrid({&*low, 1}, {&*high, 1}, bound, "draco: " + name);
    writer.addQuantised(name, onGrid(values, grid));
  }

  DracoOptions options_;
};

}  // namespace

std::unique_ptr<Format> makeDraco(Fields& options) {
  DracoOptions draco;
  draco.maxError = options.number("max_error_mm", {0.001, 1000}, 1) * 1e-3;
  draco.speed = static_cast<int>(options.integer("speed", 0, 10, 7));
  draco.intensityBits = static_cast<int>(options.integer("intensity_bits", 0, 16, 0));
  draco.time = options.boolean("time", false);
  options.finish();
  return std::make_unique<DracoFormat>(draco);
}

}  // namespace scanmill
