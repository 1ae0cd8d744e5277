#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "tests/core/formats/scans.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;

Scan decoded(const std::string& text) {
  return makeFormat("csv")->decode(text, "test.csv");
}

TEST(Csv, RoundTripIsExactForSetsOfColumns) {
  const auto csv = makeFormat("csv");
  for (const unsigned columns : setsOfColumns()) {
    for (const bool organised : {false, true}) {
      SCOPED_TRACE(fmt::format("columns {:x} organised {}", columns, organised));
      const Scan scan = randomScan(columns, 5, 40, columns, organised);
      expectSameColumns(decoded(csv->encode(scan)), scan);
    }
  }
  expectSameColumns(decoded(csv->encode(extremeScan())), extremeScan());
  expectSameColumns(decoded(csv->encode(Scan{})), Scan{});
}

TEST(Csv, TextIsWhatAPersonWouldWrite) {
  Scan scan;
  scan.position = {{1.5f, -2.25f, 0.1f}, {std::nanf(""), -std::nanf(""), std::nanf("")}};
  scan[kLabel] = {4, 0};
  scan[kTime] = {0.05f, 0};
  EXPECT_EQ(makeFormat("csv")->encode(scan), "x,y,z,label,time\n1.5,-2.25,0.1,4,0.05\nnan,nan,nan,0,0\n");
  EXPECT_EQ(makeFormat("csv")->encode(Scan{}), "x,y,z\n");
}

TEST(Csv, HeaderNamesTheColumnsInTheirOrder) {
  const Scan scan = randomScan(1, 2, 2, kAllColumns);
  const std::string text = makeFormat("csv")->encode(scan);
  EXPECT_EQ(text.substr(0, text.find('\n')), fmt::format("{}", fmt::join(columnNames(scan), ",")));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5);
}

TEST(Csv, ColumnsMayComeInAnyOrder) {
  const Scan scan = decoded("label,z,x,y\n7,3,1,2\n");
  EXPECT_EQ(scan.position[0], (Vec3f{1, 2, 3}));
  EXPECT_EQ(scan[kLabel][0], 7);
}

TEST(Csv, LinesMayEndAsOnOtherSystems) {
  const Scan scan = decoded("x,y,z,label\r\n1,2,3,7\r\n4,5,6,8\r\n");
  EXPECT_EQ(scan.position[1], (Vec3f{4, 5, 6}));
  EXPECT_EQ(scan[kLabel], (std::vector<std::uint16_t>{7, 8}));
}

TEST(Csv, ForeignColumnsAreKept) {
  const std::string text = "x,y,z,label,near_ir,signal\n1,2,3,7,812,-0.25\n4,5,6,8,0,1e-300\n";
  const Scan scan = decoded(text);
  ASSERT_EQ(scan.foreign.size(), 2u);
  EXPECT_EQ(scan.foreign[0].name, "near_ir");
  EXPECT_EQ(std::get<std::vector<double>>(scan.foreign[1].values), (std::vector<double>{-0.25, 1e-300}));
  EXPECT_EQ(makeFormat("csv")->encode(scan), text);
}

TEST(Csv, ErrorsNameTheLine) {
  const std::pair<const char*, const char*> bad[] = {
      {"", "test.csv:1"},
      {"x,y,z", "test.csv:1: the last line has no end"},
      {"x,y,z\n1,2,3\n4,5", "test.csv:3: the last line has no end"},
      {"x,y\n1,2\n", "test.csv:1: there is no column 'z'"},
      {"x,y,z,labl\n", "label"},
      {"x,y,z,x\n", "named twice"},
      {"x,y,z,\n", "'' is no name of a column"},
      {"x,y,z,4\n", "'4' is no name of a column"},
      {"x,y,z\n1,2,3\n1,2\n", "test.csv:3: 2 values"},
      {"x,y,z\n1,2,3,4\n", "test.csv:2: 4 values"},
      {"x,y,z\n1,2,\n", "test.csv:2: z"},
      {"x,y,z\n1, 2,3\n", "test.csv:2: y"},
      {"x,y,z\n1,2,3\r4\n", "test.csv:2: z"},
      {"x,y,z\n\n", "test.csv:2"},
      {"x,y,z,label\n1,2,3,65536\n", "65535"},
      {"x,y,z,label\n1,2,3,-1\n", "label"},
      {"x,y,z,instance\n1,2,3,1.0\n", "instance"},
      {"x,y,z,instance\n1,2,3,4294967296\n", "4294967295"},
  };
  for (const auto& [text, message] : bad) {
    EXPECT_THAT(messageOf([&] { decoded(text); }), HasSubstr(message)) << text;
  }
}

}  // namespace
}  // namespace scanmill
