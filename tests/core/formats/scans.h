#pragma once

// Scans and comparisons that the tests of all formats share.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "config/value.h"
#include "formats/format.h"
#include "tests/support/message_of.h"

namespace scanmill {

inline std::unique_ptr<Format> makeFormat(std::string_view name, std::string_view options = "{}") {
  const Value value = parseYaml(options, "options.yaml");
  Fields fields(value, "format");
  return requireFormat(name, {}).make(fields);
}

// Bits of `present`: which rows of the table of columns the scan has.
constexpr unsigned kAllColumns = (1u << kColumnCount) - 1;

// Bits of columns: none, all, each alone, each left out, and some hundred others.
inline std::vector<unsigned> setsOfColumns() {
  std::vector<unsigned> sets{0, kAllColumns};
  for (std::size_t k = 0; k < kColumnCount; ++k) {
    sets.push_back(1u << k);
    sets.push_back(kAllColumns & ~(1u << k));
  }
  std::mt19937 random(7);
  for (int k = 0; k < 200; ++k) sets.push_back(static_cast<unsigned>(random()) & kAllColumns);
  return sets;
}

// Any bits a float can have but infinities, NaN and, as PCL's text reader knows none, -0.
inline float anyFloat(std::mt19937& generator) {
  for (;;) {
    const float value = std::bit_cast<float>(static_cast<std::uint32_t>(generator()));
    if (std::isfinite(value) && value != 0) return value;
  }
}

// Positions within `reach` and values that are valid, or anything that their types can hold where it is 0; rings and
// columns are the beams'. About a tenth of an organised scan misses.
inline Scan randomScan(std::uint32_t seed, std::uint32_t rings, std::uint32_t columns, unsigned present,
                       bool organised = false, float reach = 0) {
  std::mt19937 generator(seed);
  Scan scan;
  scan.rings = rings;
  scan.columns = columns;
  scan.organised = organised;
  const auto coordinate = [&] {
    return reach > 0 ? std::uniform_real_distribution<float>(-reach, reach)(generator) : anyFloat(generator);
  };
  for (std::uint32_t i = 0; i < rings * columns; ++i) {
    const bool miss = organised && generator() % 10 == 0;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    scan.position.push_back(miss ? Vec3f{nan, nan, nan} : Vec3f{coordinate(), coordinate(), coordinate()});
    const auto valueFor = [&]<class T>(const Column& column, T) {
      if (column.validity == ColumnValidity::Rings) return static_cast<T>(i / columns);
      if (column.validity == ColumnValidity::Columns) return static_cast<T>(i % columns);
      if constexpr (std::is_integral_v<T>) {
        return static_cast<T>(generator() >> (generator() % 32));
      } else {
        if (column.loss == ColumnLoss::AsPositions) return std::fabs(coordinate());
        if (column.validity != ColumnValidity::Interval || reach == 0) return anyFloat(generator);
        return std::uniform_real_distribution<float>(static_cast<float>(column.low),
                                                     static_cast<float>(column.high))(generator);
      }
    };
    visitTable(scan, [&]<class T>(auto key, std::vector<T>& values) {
      if ((present >> key.index & 1u) == 0) return;
      const T value = valueFor(key.row, T{});
      values.push_back(miss ? static_cast<T>(key.row.none) : value);
    });
  }
  return scan;
}

// The values at the ends of every type.
inline Scan extremeScan() {
  using Limits = std::numeric_limits<float>;
  Scan scan = randomScan(1, 1, 8, kAllColumns);
  scan.position = {{Limits::denorm_min(), -Limits::denorm_min(), Limits::min()},
                   {Limits::max(), Limits::lowest(), 1e30f},
                   {-1e30f, 1e-30f, -1e-45f},
                   {0, 1, -1},
                   {0.1f, 1.0f / 3, 16777217.0f},
                   {std::nextafter(1.0f, 2.0f), std::nextafter(1.0f, 0.0f), 123456.789f},
                   {7, 7, 7},
                   {7, 7, 7}};
  scan[kLabel] = {0, 1, 255, 256, 32767, 32768, 65534, 65535};
  scan[kInstance] = {0, 1, 65535, 65536, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFEu, 0xFFFFFFFFu};
  scan[kRing] = {0, 255, 256, 65535, 0, 0, 1, 2};
  scan[kColumn] = {65535, 0, 65535, 0, 1, 2, 3, 4};
  scan[kIntensity] = {0, 255, 65535, 65536, 0.5f, -1, Limits::denorm_min(), Limits::max()};
  return scan;
}

inline void expectSameBits(const std::vector<float>& a, const std::vector<float>& b, std::string_view column) {
  ASSERT_EQ(a.size(), b.size()) << column;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) && std::isnan(b[i])) continue;
    ASSERT_EQ(std::bit_cast<std::uint32_t>(a[i]), std::bit_cast<std::uint32_t>(b[i])) << column << " of point " << i;
  }
}

inline std::vector<float> coordinates(const Scan& scan) {
  std::vector<float> values;
  for (const Vec3f& p : scan.position) values.insert(values.end(), {p.x, p.y, p.z});
  return values;
}

inline void expectSameColumns(const Scan& a, const Scan& b) {
  expectSameBits(coordinates(a), coordinates(b), "position");
  visitTable(a, [&]<class T>(auto key, const std::vector<T>& values) {
    if constexpr (std::is_integral_v<T>) {
      EXPECT_EQ(values, b[key]) << key.row.name;
    } else {
      expectSameBits(values, b[key], key.row.name);
    }
  });
}

inline void expectSame(const Scan& a, const Scan& b) {
  expectSameColumns(a, b);
  EXPECT_EQ(a.rings, b.rings);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.organised, b.organised);
  EXPECT_EQ(a.planes, b.planes);
}

}  // namespace scanmill
