#pragma once

// Writes point clouds in Draco's bit stream, version 2.3, sequential method (https://google.github.io/draco/spec).
//
// Draco's own encoder copies every column into an attribute, then into 32-bit integers, then into corrections, value by
// value, and computes the entropy of each column; draco.cpp has the speeds. This writer turns a column into symbols in
// one pass. Any Draco decoder reads the result.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Appends a number as LEB128, which the specification calls varUI32 and varUI64.
void appendVarint(std::uint64_t value, std::string& out);

// Appends `symbols` as Draco's DecodeSymbols() reads them, by the rANS coder of the specification's section "Symbol
// decoding" (draco_symbols.cpp). Each symbol is below 2^31, and `components` (1 or 3) successive symbols make one
// entry. A higher `level` (0 to 10) stores probabilities more precisely and gives fewer bytes.
void appendSymbols(std::span<const std::uint32_t> symbols, int components, int level, std::string& out);

// Regular grids for quantised floats. The value that a reader computes in float32 from an index differs from the
// original value by at most a given bound.
//
// Component c of a grid point is low[c] + index * step. A reader computes float(float(index) * step) + low[c].
struct Grid {
  std::vector<float> low;
  float step = 1;
};

// Chooses a grid for values between `low` and `high`, which have one entry per component. Quantising moves no point by
// more than `bound`, a Euclidean distance over all components that includes the reader's rounding. Each side of the
// grid has at most 2^30 points. If float32 has enough bits, the grid's points are exact in float32 and the step is as
// large as the bound allows. If the bound is too small, throws an InputError with `what` and the least possible bound.
Grid chooseGrid(std::span<const float> low, std::span<const float> high, double bound, const std::string& what);

// Returns an upper bound of the number of bits of an index on chooseGrid()'s grid for values from -reach to reach.
int mostIndexBits(double reach, std::size_t components, double bound);

// Writes for each value the index of the nearest grid point; the components of a point follow each other. `indices`
// must have room for one index per value.
void quantise(std::span<const float> values, const Grid& grid, std::int32_t* indices);

// A column of values on a regular grid. A component of a value is low + index * step.
struct QuantisedColumn {
  std::span<const std::int32_t> indices;  // all 0 or more; point by point, with a point's components in succession
  std::span<const float> low;             // one number per component
  float step = 0;
};

class DracoWriter {
 public:
  DracoWriter(std::uint32_t points, int level) : points_(points), level_(level) {}

  // Adds an entry to the geometry's metadata.
  void addEntry(std::string_view key, std::int32_t value);

  // Adds a column as an attribute, in the order of the calls. `name` becomes the attribute's metadata entry "name". A
  // quantised column of three components is the position of the points. Integers are stored in the narrowest type that
  // can represent all values; floats are stored unchanged.
  void addQuantised(std::string_view name, const QuantisedColumn& column);
  void addIntegers(std::string_view name, std::span<const std::uint8_t> values);
  void addIntegers(std::string_view name, std::span<const std::uint16_t> values);  // stored as u8 if all values fit
  void addIntegers(std::string_view name, std::span<const std::uint32_t> values);  // stored as u8, u16 or u32
  void addFloats(std::string_view name, std::span<const float> values);            // stored unchanged
  // Adds a column of a cloud without points.
  void addEmpty(std::string_view name);

  // Returns the bytes of the complete point cloud.
  [[nodiscard]] std::string finish() const;

 private:
  // Adds the metadata, the descriptor and the encoder of an attribute. The caller must then add the attribute's values.
  void describe(std::string_view name, int dataType, std::size_t components, int encoder);
  template <class T>
  void addNarrowed(std::string_view name, std::span<const T> values);
  template <class T>
  void addSymbols(std::span<const T> values, int components);

  std::uint32_t points_;
  int level_;                     // see appendSymbols()
  std::uint32_t attributes_ = 0;  // number of attributes so far
  std::uint32_t entries_ = 0;     // number of entries of the geometry's metadata; entryBytes_ has their bytes
  std::string entryBytes_;
  std::string names_;        // metadata of the attributes
  std::string descriptors_;  // types and components of the attributes
  std::string encoders_;     // one byte per attribute
  std::string values_;
  std::string grids_;
};

}  // namespace scanmill
