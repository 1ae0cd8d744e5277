#pragma once

// Scans and comparisons that the tests of all formats share.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
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

// Bits of `columns`: which of intensity, label, instance, ring, column, time, range_true and incidence the scan has.
constexpr unsigned kAllColumns = 255;

// Any bits a float can have but infinities, NaN and, as PCL's text reader knows none, -0.
inline float anyFloat(std::mt19937& generator) {
  for (;;) {
    const float value = std::bit_cast<float>(static_cast<std::uint32_t>(generator()));
    if (std::isfinite(value) && value != 0) return value;
  }
}

// Positions within `reach` and incidences that are angles, or anything that a float can hold where it is 0; about a
// tenth of an organised scan misses.
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
    const auto add = [&](unsigned bit, auto& column, auto value) {
      using T = typename std::remove_reference_t<decltype(column)>::value_type;
      if ((present >> bit & 1u) != 0) column.push_back(miss ? T(0) : static_cast<T>(value));
    };
    add(0, scan.intensity, anyFloat(generator));
    add(1, scan.label, generator() >> (generator() % 32));
    add(2, scan.instance, generator() >> (generator() % 32));
    add(3, scan.ring, i / columns);
    add(4, scan.column, i % columns);
    add(5, scan.time, 0.1f * static_cast<float>(i % columns) / static_cast<float>(columns));
    if ((present >> 6 & 1u) != 0) scan.rangeTrue.push_back(miss ? nan : std::fabs(coordinate()));
    if ((present >> 7 & 1u) != 0) {
      std::uniform_real_distribution<float> angle(0, static_cast<float>(kPi / 2));
      scan.incidence.push_back(miss ? nan : reach > 0 ? angle(generator) : anyFloat(generator));
    }
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
  scan.label = {0, 1, 255, 256, 32767, 32768, 65534, 65535};
  scan.instance = {0, 1, 65535, 65536, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFEu, 0xFFFFFFFFu};
  scan.ring = {0, 255, 256, 65535, 0, 0, 1, 2};
  scan.column = {65535, 0, 65535, 0, 1, 2, 3, 4};
  scan.intensity = {0, 255, 65535, 65536, 0.5f, -1, Limits::denorm_min(), Limits::max()};
  return scan;
}

inline void expectSameBits(const std::vector<float>& a, const std::vector<float>& b, const char* column) {
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
  expectSameBits(a.intensity, b.intensity, "intensity");
  expectSameBits(a.time, b.time, "time");
  expectSameBits(a.rangeTrue, b.rangeTrue, "range_true");
  expectSameBits(a.incidence, b.incidence, "incidence");
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.instance, b.instance);
  EXPECT_EQ(a.ring, b.ring);
  EXPECT_EQ(a.column, b.column);
}

inline void expectSame(const Scan& a, const Scan& b) {
  expectSameColumns(a, b);
  EXPECT_EQ(a.rings, b.rings);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.organised, b.organised);
}

}  // namespace scanmill
