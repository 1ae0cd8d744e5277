#include "formats/format.h"

#include <gmock/gmock.h>

#include "tests/formats/scans.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;

TEST(Formats, TableAndSuffixesAgree) {
  for (const FormatEntry& entry : formats()) {
    const auto format = makeFormat(entry.name);
    EXPECT_EQ(format->suffix(), entry.suffix);
    EXPECT_EQ(formatBySuffix(entry.suffix), &entry);
    EXPECT_EQ(&requireFormat(entry.name, {}), &entry);
    EXPECT_FALSE(entry.summary.empty());
  }
  EXPECT_EQ(formatBySuffix("las"), nullptr);
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

TEST(Formats, ColumnsOfDifferentLengthAreRefused) {
  for (const FormatEntry& entry : formats()) {
    Scan scan = randomScan(5, 2, 3, kAllColumns, false, 10);
    scan.ring.pop_back();
    EXPECT_THROW(makeFormat(entry.name)->encode(scan), Error) << entry.name;
    Scan organised = randomScan(5, 2, 3, 0, true, 10);
    organised.rings = 4;
    EXPECT_THROW(makeFormat(entry.name)->encode(organised), Error) << entry.name;
  }
}

}  // namespace
}  // namespace scanmill
