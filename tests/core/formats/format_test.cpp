#include "formats/format.h"

#include <fmt/format.h>

#include "tests/core/formats/scans.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(Formats, TableAndSuffixesAgree) {
  for (const FormatEntry& entry : formats()) {
    EXPECT_EQ(formatBySuffix(entry.suffix), &entry);
    EXPECT_EQ(&requireFormat(entry.name, {}), &entry);
    EXPECT_FALSE(entry.summary.empty());
  }
  EXPECT_EQ(formatBySuffix("nonsense"), nullptr);
}

TEST(Formats, UnknownNamesGetASuggestion) {
  EXPECT_THAT(messageOf([] {
                requireFormat("darco", {"a.yaml", 3, 4});
              }),
              AllOf(HasSubstr("a.yaml:3:4"), HasSubstr("draco")));
}

TEST(Formats, OptionsAreStrict) {
  EXPECT_THAT(messageOf([] { makeFormat("pcd", "encodign: ascii"); }), HasSubstr("encoding"));
  EXPECT_THAT(messageOf([] { makeFormat("pcd", "encoding: zip"); }), HasSubstr("zip"));
  EXPECT_THAT(messageOf([] { makeFormat("draco", "max_error_mm: 0"); }), HasSubstr("max_error_mm"));
  EXPECT_THAT(messageOf([] { makeFormat("draco", "speed: 11"); }), HasSubstr("speed"));
  EXPECT_THAT(messageOf([] { makeFormat("csv", "separator: tab"); }), HasSubstr("separator"));
}

TEST(Formats, ErrorBoundsAreThoseAskedFor) {
  EXPECT_EQ(makeFormat("pcd")->maxError(), 0);
  EXPECT_EQ(makeFormat("csv")->maxError(), 0);
  EXPECT_DOUBLE_EQ(makeFormat("draco")->maxError(), 0.001);
  EXPECT_DOUBLE_EQ(makeFormat("draco", "max_error_mm: 20")->maxError(), 0.02);
}

TEST(Formats, TheSameScanGivesTheSameBytes) {
  const Scan large = randomScan(3, 16, 64, kAllColumns, true, 100);
  const Scan small = randomScan(4, 2, 3, kAllColumns, false, 100);
  for (const FormatEntry& entry : formats()) {
    const auto format = makeFormat(entry.name);
    const std::string before = format->encode(small);
    format->encode(large);
    EXPECT_EQ(format->encode(small), before) << entry.name;
  }
}

const std::pair<const char*, const char*> kEncodings[] = {
    {"pcd", "{}"},
    {"pcd", "encoding: binary"},
    {"pcd", "encoding: ascii"},
    {"csv", "{}"},
    {"draco", "{}"},
    {"draco", "{max_error_mm: 50, speed: 10}"},
    {"draco", "{max_error_mm: 0.1, speed: 0, time: true}"},
};

ScanOutline outlineOf(const Scan& scan, double reach) {
  return {scan.size(), scan.rings, scan.columns, reach, columnsOf(scan)};
}

// Noise is what no encoding makes smaller. A bound far above what scans take would give shards of odd sizes.
TEST(Formats, NoScanIsLargerThanItsOutlineSaysAndManyAreAlmost) {
  for (const auto& [name, options] : kEncodings) {
    const auto format = makeFormat(name, options);
    const double leastReach = std::string_view(name) == "draco" ? 1 : 1e-3;
    for (std::uint32_t seed = 1; seed <= 60; ++seed) {
      std::mt19937 generator(seed);
      const unsigned columns = seed == 1 ? kAllColumns : generator() & kAllColumns;
      const std::uint32_t length = seed % 5 == 0 ? 1 + seed % 7 : 500;
      const auto reach = static_cast<float>(leastReach * std::pow(4, generator() % 5));
      const bool organised = format->keepsMisses() && seed % 2 == 0;
      const Scan scan = randomScan(seed, 8, length, columns, organised, reach);
      SCOPED_TRACE(fmt::format("{} {} of {} points, seed {}", name, options, scan.size(), seed));
      EXPECT_LE(static_cast<double>(format->encode(scan).size()), format->mostBytes(outlineOf(scan, reach)));
    }
    const Scan usual = randomScan(2, 64, 500, kAllColumns, format->keepsMisses(), 100);
    EXPECT_LE(format->mostBytes(outlineOf(usual, 100)), 3 * static_cast<double>(format->encode(usual).size())) << name;
    Scan none = randomScan(1, 0, 0, 0);
    EXPECT_LE(static_cast<double>(format->encode(none).size()), format->mostBytes(outlineOf(none, 1))) << name;
  }
  for (const char* options : {"encoding: ascii", "encoding: binary", "{}"}) {
    const Scan extreme = extremeScan();
    const auto format = makeFormat("pcd", options);
    EXPECT_LE(static_cast<double>(format->encode(extreme).size()), format->mostBytes(outlineOf(extreme, 1e39)));
  }
}

TEST(Formats, ScansWithoutPointsKeepTheirColumns) {
  for (const auto& [name, options] : kEncodings) {
    SCOPED_TRACE(fmt::format("{} {}", name, options));
    const auto format = makeFormat(name, options);
    Scan scan;
    scan.columnsIfEmpty = ColumnSet(kIntensity, kLabel, kInstance, kRing);
    scan.foreign.push_back({"near_ir", std::vector<std::uint16_t>{}});
    const Scan back = format->decode(format->encode(scan), "empty.file");
    EXPECT_EQ(back.size(), 0u);
    EXPECT_EQ(columnNames(back), columnNames(scan));
    EXPECT_EQ(columnNames(back).size(), 8u);
  }
}

TEST(Formats, LosslessOnesRestoreEverySetOfColumns) {
  for (const auto& [name, options] : kEncodings) {
    const auto format = makeFormat(name, options);
    if (format->maxError() > 0) continue;
    const bool knowsSensor = std::string_view(name) == "pcd";  // text does not describe the sensor
    const auto expectRoundTrips = [&](const Scan& scan) {
      const Scan back = format->decode(format->encode(scan), "test.file");
      knowsSensor ? expectSame(back, scan) : expectSameColumns(back, scan);
    };
    for (const unsigned columns : setsOfColumns()) {
      for (const bool organised : {false, true}) {
        SCOPED_TRACE(fmt::format("{} {} columns {:x} organised {}", name, options, columns, organised));
        expectRoundTrips(randomScan(columns, 7, 45, columns, organised));
      }
    }
    for (const Scan& scan : {Scan{}, extremeScan(), randomScan(9, 1, 1, kAllColumns, true)}) expectRoundTrips(scan);
  }
}

// Other damage: tests/fuzz.
TEST(Formats, TruncatedFilesAreRefused) {
  for (const auto& [name, options] : kEncodings) {
    const auto format = makeFormat(name, options);
    const std::string good = format->encode(randomScan(77, 8, 40, kAllColumns, format->keepsMisses(), 60));
    // The last line of a text may lack its end, but no value.
    const std::size_t end = good.back() == '\n' ? good.find_last_of(", ") : good.size() - 2;
    for (const std::size_t size : {std::size_t{0}, good.size() / 50, good.size() / 2, end}) {
      EXPECT_THAT(messageOf([&] { format->decode(good.substr(0, size), "damaged.file"); }), StartsWith("damaged.file"))
          << name << ' ' << options << ' ' << size;
    }
  }
}

TEST(Formats, ColumnsOfDifferentLengthAreRefused) {
  for (const FormatEntry& entry : formats()) {
    Scan scan = randomScan(5, 2, 3, kAllColumns, false, 10);
    scan[kRing].pop_back();
    EXPECT_THROW(makeFormat(entry.name)->encode(scan), Error) << entry.name;
    Scan organised = randomScan(5, 2, 3, 0, true, 10);
    organised.rings = 4;
    EXPECT_THROW(makeFormat(entry.name)->encode(organised), Error) << entry.name;
  }
}

}  // namespace
}  // namespace scanmill
