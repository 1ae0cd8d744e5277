// draco: Google Draco point clouds, encoded sequentially, so that points keep their order and duplicates are kept.
//
//   format: draco
//   max_error_mm: 1     # largest Euclidean error of a position
//   speed: 7            # Draco's scale: 10 is the least effort; here it only sets the precision of the probabilities
//   time: false         # time follows from ring and column by the beam table in the manifest, so it is left out
//
// POSITION is a quantised float32 attribute, so that every reader gets metres. The other columns are GENERIC attributes
// with a metadata entry "name", in the order of the table of columns (scan/columns.h); Column::loss says which columns
// may be rounded, and by how much. Integers are stored exactly in the narrowest of u8, u16 and u32. Intensities are
// stored likewise if all are whole numbers up to 65535, else as float32. The geometry's metadata contains the
// sensor's numbers of rings and columns. Misses are left out: ring and column identify the beams of the remaining
// points. Foreign columns are kept if their type is u8, u16, u32 or float32.
//
// Measured (tests/benchmarks/encoders.cpp) on a scan of a street by 64 x 2048 beams with 10 mm of range noise, points
// in firing order, on one core of an AMD EPYC, family 26: this file encodes 31 million points per second to 3.6 bytes
// per point; Draco's encoder writes as few bytes at 8 million points per second, its kd-tree method 7.2 bytes at 4.2
// million. Speed 0 saves up to 1.4 % of the bytes, but halves the speed of decoding; therefore the default is 7.

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

#include "base/instruction_sets.h"
#include "base/raw_vector.h"
#include "formats/draco_writer.h"
#include "formats/readers.h"

namespace scanmill {

namespace {

// Upper bounds of the bytes that do not depend on the number of points: the header with its metadata, and for each
// column its descriptor and its table of probabilities.
constexpr double kMostHeaderBytes = 100;
constexpr double kMostColumnBytes = 200;

// Returns an upper bound of the bits that appendSymbols() writes for an entry of `components` symbols, if each symbol
// has `bits` bits: the code of this length, the symbols themselves, and less than one bit for rounded probabilities. If
// coding the symbols by their own probabilities is shorter, appendSymbols() does so.
double symbolBits(int bits, int components) {
  return bits * components + std::log2(bits + 1.0) + 1;
}

struct DracoOptions {
  double maxError;  // m, largest error of a position
  int speed;        // 0 (fewest bytes) to 10
  bool time;        // true: the column time is kept
};

bool allFinite(std::span<const float> values) {
  // The sum of v * 0 is 0 if all v are finite, otherwise NaN. With several sums the loop can be vectorised.
  float sums[16] = {};
  std::size_t i = 0;
  for (; i + 16 <= values.size(); i += 16) {
    for (std::size_t k = 0; k < 16; ++k) sums[k] += values[i + k] * 0.0f;
  }
  for (; i < values.size(); ++i) sums[0] += values[i] * 0.0f;
  return std::all_of(std::begin(sums), std::end(sums), [](float sum) { return sum == 0; });
}

// Returns the values as integers; empty unless each value is exactly an integer from 0 to 65535 (-0 is refused).
std::vector<std::uint16_t> asIntegers(std::span<const float> values) {
  std::vector<std::uint16_t> integers(values.size());
  std::uint32_t differences = 0;  // bits in which a value differs from its integer
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool fits = values[i] >= 0 && values[i] <= 65535;  // false for NaN
    const auto integer = static_cast<std::uint16_t>(fits ? values[i] : 0.0f);
    integers[i] = integer;
    // The sign bit is tested separately: with -fno-trapping-math, g++ replaces the two conversions by a truncation,
    // which would accept -0.
    const auto bits = std::bit_cast<std::uint32_t>(values[i]);
    differences |= (std::bit_cast<std::uint32_t>(static_cast<float>(integer)) ^ bits) | (bits >> 31);
  }
  if (differences != 0) integers.clear();
  return integers;
}

// Returns the indices of the grid points nearest to the values. The memory is valid until the next call on this thread.
SCANMILL_BEST_INSTRUCTIONS QuantisedColumn onGrid(std::span<const float> values, const Grid& grid) {
  thread_local RawVector<std::int32_t> scratch;
  scratch.resize(values.size());
  quantise(values, grid, scratch.data());
  return {scratch, grid.low, grid.step};
}

class DracoFormat : public Format {
 public:
  explicit DracoFormat(const DracoOptions& options) : options_(options) {}

  double maxError() const override { return options_.maxError; }
  bool keepsMisses() const override { return false; }

  double mostBytes(const ScanOutline& outline) const override {
    double bits = symbolBits(mostIndexBits(outline.reach, 3, options_.maxError), 3);  // per point; of the position
    double columns = 1;
    forEachColumn([&]<class Key>(Key key) {
      if (!outline.held.has(key) || !keeps(key.row)) return;
      ++columns;
      if (key.row.loss == ColumnLoss::AsPositions) {
        bits += symbolBits(mostIndexBits(outline.reach, 1, options_.maxError), 1);
      } else if (key.row.type == ColumnType::Float32) {
        bits += 32;  // an upper bound: integers and quantised values take fewer bits
      } else {
        const std::uint32_t largest = key.row.validity == ColumnValidity::Rings     ? outline.rings
                                      : key.row.validity == ColumnValidity::Columns ? outline.columns
                                                                                    : largestOf<typename Key::Value>();
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

  Scan decode(std::string_view bytes, const std::string& what) const override {
    return scanOf(readDraco(bytes, what), what);
  }

 private:
  // Encodes a scan without misses.
  std::string encodeDense(const Scan& scan) const {
    if (scan.size() > std::numeric_limits<std::int32_t>::max() / 4) {
      throw Error("{} points are more than Draco holds", scan.size());
    }
    DracoWriter writer(static_cast<std::uint32_t>(scan.size()), 10 - options_.speed);
    writer.addEntry("rings", static_cast<std::int32_t>(scan.rings));
    writer.addEntry("columns", static_cast<std::int32_t>(scan.columns));
    if (scan.size() == 0) return encodeEmpty(scan, writer);
    addPosition(scan, writer);
    visitTable(scan, [&](auto key, const auto& values) {
      if (!values.empty() && keeps(key.row)) addColumn(key.row, values, writer);
    });
    for (const ForeignColumn& column : scan.foreign) {
      std::visit([&](const auto& values) { addForeign(column.name, values, writer); }, column.values);
    }
    return writer.finish();
  }

  // Returns a file without points, which names the columns.
  std::string encodeEmpty(const Scan& scan, DracoWriter& writer) const {
    if (columnNames(scan).size() > 3) writer.addEmpty("position");
    visitColumns(scan, [&](std::string_view name, const auto&) {
      if (name != kTime.row.name || options_.time) writer.addEmpty(name);
    });
    return writer.finish();
  }

  // True if the file has the column. Times follow from rings and columns, and are stored only with the option `time`.
  bool keeps(const Column& column) const { return column.name != kTime.row.name || options_.time; }

  template <class T>
  static constexpr std::uint32_t largestOf() {
    return std::is_integral_v<T> ? static_cast<std::uint32_t>(std::numeric_limits<T>::max()) : 0;
  }

  template <class T>
  void addColumn(const Column& column, const std::vector<T>& values, DracoWriter& writer) const {
    if constexpr (std::is_integral_v<T>) {
      writer.addIntegers(column.name, std::span<const T>(values));
    } else if (column.name == kIntensity.row.name) {
      addIntensity(values, writer);
    } else if (column.loss == ColumnLoss::Exact || !allValid(column, values)) {
      writer.addFloats(column.name, values);
    } else {
      addBounded(std::string(column.name), values,
                 column.loss == ColumnLoss::AsPositions ? options_.maxError : column.lossBound, writer);
    }
  }

  template <class T>
  static void addForeign(const std::string& name, const std::vector<T>& values, DracoWriter& writer) {
    if constexpr (std::is_same_v<T, float>) {
      writer.addFloats(name, values);
    } else if constexpr (std::is_unsigned_v<T> && sizeof(T) <= 4) {
      writer.addIntegers(name, std::span<const T>(values));
    }
  }

  // True if all values are valid for the column, so that they may be rounded. Other programs may store invalid values.
  static bool allValid(const Column& column, const std::vector<float>& values) {
    if (!allFinite(values)) return false;
    if (column.validity != ColumnValidity::Interval) return true;
    const double slack = 2 * column.lossBound;
    return std::ranges::all_of(values, [&](float v) { return v >= column.low - slack && v <= column.high + slack; });
  }

  SCANMILL_BEST_INSTRUCTIONS void addPosition(const Scan& scan, DracoWriter& writer) const {
    Vec3f low = scan.position[0];
    Vec3f high = low;
    for (const Vec3f& p : scan.position) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const Grid grid = chooseGrid({&low.x, 3}, {&high.x, 3}, options_.maxError, "draco: a scan");
    writer.addQuantised("position",
                        onGrid({reinterpret_cast<const float*>(scan.position.data()), 3 * scan.size()}, grid));
  }

  SCANMILL_BEST_INSTRUCTIONS void addIntensity(const std::vector<float>& values, DracoWriter& writer) const {
    const std::string_view name = kIntensity.row.name;
    const std::vector<std::uint16_t> integers = asIntegers(values);
    if (!integers.empty()) return writer.addIntegers(name, std::span<const std::uint16_t>(integers));
    writer.addFloats(name, values);
  }

  static void addBounded(const std::string& name, std::span<const float> values, double bound, DracoWriter& writer) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const Grid grid = chooseGrid({&*low, 1}, {&*high, 1}, bound, "draco: " + name);
    writer.addQuantised(name, onGrid(values, grid));
  }

  DracoOptions options_;
};

}  // namespace

std::unique_ptr<Format> makeDraco(Fields& options) {
  const DracoOptions draco{.maxError = options.number("max_error_mm", {0.001, 1000}, 1) * 1e-3,
                           .speed = static_cast<int>(options.integer("speed", 0, 10, 7)),
                           .time = options.boolean("time", false)};
  options.finish();
  return std::make_unique<DracoFormat>(draco);
}

}  // namespace scanmill
