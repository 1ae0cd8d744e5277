#include "formats/draco_writer.h"

#include <draco/attributes/geometry_attribute.h>
#include <draco/compression/config/compression_shared.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/instruction_sets.h"
#include "base/raw_vector.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

// Least number of bits of a quantised attribute. From 25 bits on, float32 rounds 2^bits - 1 to 2^bits, so that a
// decoder's step, range / float(2^bits - 1), equals the encoder's step, range / 2^bits.
constexpr int kLeastBits = 25;

void appendEntry(std::string_view key, std::string_view value, std::string& out) {
  out.push_back(static_cast<char>(key.size()));
  out += key;
  appendVarint(value.size(), out);
  out += value;
}

// Maps 0, -1, 1, -2, 2 ... to 0, 1, 2, 3, 4 ...
std::uint32_t zigzag(std::int32_t value) {
  return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31);
}

struct Symbols {
  std::span<std::uint32_t> values;  // valid until the thread's next call of toSymbols()
  std::int32_t low = 0;             // the least and the greatest of the coded values
  std::int32_t high = 0;
  bool predicted = true;  // true: `values` are differences to the previous point; false: the values themselves
};

// Returns the symbols of a column with at least one value: the differences to the previous point, wrapped around the
// values' range (the specification's "wrap transform"), or the values themselves if the range is too large to wrap.
template <class T>
Symbols toSymbols(std::span<const T> values, std::size_t components) {
  thread_local RawVector<std::uint32_t> scratch;
  scratch.resize(values.size());
  const auto valueAt = [&](std::size_t i) { return static_cast<std::int32_t>(values[i]); };
  std::int32_t low = valueAt(0);
  std::int32_t high = valueAt(0);
  for (std::size_t i = 1; i < values.size(); ++i) {
    low = std::min(low, valueAt(i));
    high = std::max(high, valueAt(i));
  }
  Symbols result{.values = scratch, .low = low, .high = high};
  const std::int64_t span = std::int64_t{high} - low + 1;
  if (span > std::numeric_limits<std::int32_t>::max()) {
    result.predicted = false;
    for (std::size_t i = 0; i < values.size(); ++i) result.values[i] = zigzag(valueAt(i));
    return result;
  }
  const auto period = static_cast<std::int32_t>(span);
  const std::int32_t leastDifference = -(period / 2);
  const std::int32_t mostDifference = (period - 1) / 2;
  const auto correction = [=](std::int32_t value, std::int32_t prediction) {
    std::int32_t difference = value - prediction;
    difference -= difference > mostDifference ? period : 0;
    difference += difference < leastDifference ? period : 0;
    return zigzag(difference);
  };
  for (std::size_t i = 0; i < components; ++i) result.values[i] = correction(valueAt(i), std::clamp(0, low, high));
  for (std::size_t i = components; i < values.size(); ++i) {
    result.values[i] = correction(valueAt(i), valueAt(i - components));
  }
  return result;
}

constexpr double kMaxIndex = (1 << 30) - 2;
constexpr double kHalfUlp = 0x1p-24;    // largest relative rounding error of a float32
constexpr double kFloatWhole = 0x1p24;  // integers up to here are exact in float32

}  // namespace

void DracoWriter::addEntry(std::string_view key, std::int32_t value) {
  appendEntry(key, std::string_view(reinterpret_cast<const char*>(&value), sizeof(value)), entryBytes_);
  ++entries_;
}

SCANMILL_BEST_INSTRUCTIONS void DracoWriter::addQuantised(std::string_view name, const QuantisedColumn& column) {
  describe(name, draco::DT_FLOAT32, column.low.size(), draco::SEQUENTIAL_ATTRIBUTE_ENCODER_QUANTIZATION);
  addSymbols(column.indices, static_cast<int>(column.low.size()));
  std::uint32_t unionOfBits = 0;
  for (const std::int32_t index : column.indices) unionOfBits |= static_cast<std::uint32_t>(index);
  const int bits = std::max(kLeastBits, static_cast<int>(std::bit_width(unionOfBits)));
  for (const float low : column.low) putNumber(low, grids_);
  putNumber(std::ldexp(column.step, bits), grids_);
  grids_.push_back(static_cast<char>(bits));
}

SCANMILL_BEST_INSTRUCTIONS void DracoWriter::addIntegers(std::string_view name, std::span<const std::uint8_t> values) {
  addNarrowed(name, values);
}

SCANMILL_BEST_INSTRUCTIONS void DracoWriter::addIntegers(std::string_view name, std::span<const std::uint16_t> values) {
  addNarrowed(name, values);
}

SCANMILL_BEST_INSTRUCTIONS void DracoWriter::addIntegers(std::string_view name, std::span<const std::uint32_t> values) {
  addNarrowed(name, values);
}

void DracoWriter::addFloats(std::string_view name, std::span<const float> values) {
  describe(name, draco::DT_FLOAT32, 1, draco::SEQUENTIAL_ATTRIBUTE_ENCODER_GENERIC);
  values_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

void DracoWriter::addEmpty(std::string_view name) {
  describe(name, draco::DT_FLOAT32, name == "position" ? 3 : 1, draco::SEQUENTIAL_ATTRIBUTE_ENCODER_GENERIC);
}

std::string DracoWriter::finish() const {
  std::string out = "DRACO";
  out.push_back(static_cast<char>(draco::kDracoPointCloudBitstreamVersionMajor));
  out.push_back(static_cast<char>(draco::kDracoPointCloudBitstreamVersionMinor));
  out.push_back(static_cast<char>(draco::POINT_CLOUD));
  out.push_back(static_cast<char>(draco::POINT_CLOUD_SEQUENTIAL_ENCODING));
  putNumber(std::uint16_t{METADATA_FLAG_MASK}, out);
  appendVarint(attributes_, out);
  out += names_;
  appendVarint(entries_, out);
  out += entryBytes_;
  appendVarint(0, out);  // no nested metadata
  putNumber(points_, out);
  out.push_back(attributes_ > 0 ? 1 : 0);  // number of groups of attributes
  if (attributes_ == 0) return out;
  appendVarint(attributes_, out);
  out.reserve(out.size() + descriptors_.size() + encoders_.size() + values_.size() + grids_.size());
  out += descriptors_;
  out += encoders_;
  out += values_;
  out += grids_;
  return out;
}

void DracoWriter::describe(std::string_view name, int dataType, std::size_t components, int encoder) {
  appendVarint(attributes_, names_);  // id of the attribute
  appendVarint(1, names_);            // number of entries
  appendEntry("name", name, names_);
  appendVarint(0, names_);  // no nested metadata
  descriptors_.push_back(
      static_cast<char>(components == 3 ? draco::GeometryAttribute::POSITION : draco::GeometryAttribute::GENERIC));
  descriptors_.push_back(static_cast<char>(dataType));
  descriptors_.push_back(static_cast<char>(components));
  descriptors_.push_back(0);  // not normalised
  appendVarint(attributes_, descriptors_);
  encoders_.push_back(static_cast<char>(encoder));
  ++attributes_;
}

template <class T>
void DracoWriter::addNarrowed(std::string_view name, std::span<const T> values) {
  T unionOfBits = 0;
  for (const T value : values) unionOfBits |= value;
  const int type = unionOfBits < (1u << 8)    ? draco::DT_UINT8
                   : unionOfBits < (1u << 16) ? draco::DT_UINT16
                                              : draco::DT_UINT32;
  describe(name, type, 1, draco::SEQUENTIAL_ATTRIBUTE_ENCODER_INTEGER);
  addSymbols(values, 1);
}

template <class T>
void DracoWriter::addSymbols(std::span<const T> values, int components) {
  const Symbols symbols = toSymbols(values, static_cast<std::size_t>(components));
  if (symbols.predicted) {
    values_.push_back(draco::PREDICTION_DIFFERENCE);
    values_.push_back(draco::PREDICTION_TRANSFORM_WRAP);
    values_.push_back(1);  // the symbols are entropy coded
    appendSymbols(symbols.values, components, level_, values_);
    putNumber(symbols.low, values_);
    putNumber(symbols.high, values_);
  } else {
    values_.push_back(static_cast<char>(draco::PREDICTION_NONE));
    values_.push_back(0);  // not entropy coded: stored as integers, whose size in bytes comes next
    values_.push_back(sizeof(std::uint32_t));
    values_.append(reinterpret_cast<const char*>(symbols.values.data()), symbols.values.size_bytes());
  }
}

Grid chooseGrid(std::span<const float> low, std::span<const float> high, double bound, const std::string& what) {
  double extent = 0;
  double magnitude = 0;
  for (std::size_t c = 0; c < low.size(); ++c) {
    extent = std::max(extent, double{high[c]} - double{low[c]});
    magnitude = std::max({magnitude, std::fabs(double{low[c]}), std::fabs(double{high[c]})});
  }
  Grid grid;
  const double diagonal = std::sqrt(static_cast<double>(low.size()));  // diagonal of a cube of side 1
  const double axisBound = bound / diagonal;
  const double largestStep = 2 * axisBound * (1 - 1e-9);  // with a margin for rounding the index in double
  // The step and all coordinates of grid points are whole multiples of `unit`, a power of two. The multiples are at
  // most 2^24, so they are exact in float32 and the indices stay below 2^30. A unit below 2^-20 of the step would make
  // the step only 0.0001 % larger.
  constexpr double kStepBits = 20;
  const double reach = std::max(extent, magnitude) + 2 * largestStep;
  const double unit =
      std::exp2(std::max(std::ceil(std::log2(reach / kFloatWhole)), std::floor(std::log2(largestStep)) - kStepBits));
  const double step = std::floor(largestStep / unit) * unit;
  if (step > 0) {
    grid.step = static_cast<float>(step);
    for (const float l : low) grid.low.push_back(static_cast<float>(std::floor(l / unit) * unit));
    return grid;
  }
  // The bound must include three roundings by the reader, each to half a unit in the last place: of the index and of
  // the product (both up to the extent), and of the sum (up to the magnitude). Results may lie beyond these limits by
  // half a step, which is `axisBound`.
  const double rounding = kHalfUlp * (2 * extent + magnitude + 4 * axisBound);
  const double possible = rounding + extent / kMaxIndex;
  if (!(axisBound >= possible)) {
    throw InputError(
        fmt::format("{} over {:.6g} m, up to {:.6g} m from the origin, cannot be kept within {:.6g} mm "
                    "in 32-bit floats: {:.6g} mm are possible",
                    what, extent, magnitude, bound * 1e3, possible * diagonal * 1e3));
  }
  grid.step = std::nextafter(static_cast<float>(2 * (axisBound - rounding)), 0.0f);
  grid.low.assign(low.begin(), low.end());
  return grid;
}

int mostIndexBits(double reach, std::size_t components, double bound) {
  constexpr int kMostBits = 30;
  const double largestStep = 2 * bound / std::sqrt(static_cast<double>(components)) * (1 - 1e-9);
  // chooseGrid() rounds the step down to a multiple of a power of two; `unit` is an upper bound of that power.
  const double unit = std::max(2 * (2 * reach + 2 * largestStep) / kFloatWhole, largestStep * 0x1p-20);
  if (unit > largestStep / 2) return kMostBits;
  const double largestIndex = (2 * reach + unit) / (largestStep - unit) + 1;
  return std::clamp(static_cast<int>(std::ceil(std::log2(largestIndex + 1))), 1, kMostBits);
}

void quantise(std::span<const float> values, const Grid& grid, std::int32_t* indices) {
  const double stepsPerUnit = 1 / double{grid.step};
  const auto index = [&](float value, float low) {
    return static_cast<std::int32_t>((double{value} - double{low}) * stepsPerUnit + 0.5);
  };
  const std::size_t components = grid.low.size();
  if (components == 3) {
    const float x = grid.low[0];
    const float y = grid.low[1];
    const float z = grid.low[2];
    for (std::size_t i = 0; i + 2 < values.size(); i += 3) {
      indices[i] = index(values[i], x);
      indices[i + 1] = index(values[i + 1], y);
      indices[i + 2] = index(values[i + 2], z);
    }
  } else {
    for (std::size_t i = 0; i < values.size(); ++i) indices[i] = index(values[i], grid.low[i % components]);
  }
}

}  // namespace scanmill
