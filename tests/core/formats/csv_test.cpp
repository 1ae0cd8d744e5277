#include <fmt/format.h>

#include "tests/core/formats/scans.h"

namespace scanmill {
namespace {

using ::testing::HasSubstr;

Scan decodedCsv(const std::string& text) {
  return makeFormat("csv")->decode(text, "test.csv");
}

TEST(Csv, TextIsWhatAPersonWouldWrite) {
  Scan scan;
  scan.position = {{1.5f, -2.25f, 0.1f}, {std::nanf(""), -std::nanf(""), std::nanf("")}};
  scan[kLabel] = {4, 0};
  scan[kTime] = {0.05f, 0};
  EXPECT_EQ(makeFormat("csv")->encode(scan), "x,y,z,label,time\n1.5,-2.25,0.1,4,0.05\nnan,nan,nan,0,0\n");
  EXPECT_EQ(makeFormat("csv")->encode(Scan{}), "x,y,z\n");
}

TEST(Csv, ColumnsMayComeInAnyOrder) {
  const Scan scan = decodedCsv("label,z,x,y\n7,3,1,2\n");
  EXPECT_EQ(scan.position[0], (Vec3f{1, 2, 3}));
  EXPECT_EQ(scan[kLabel][0], 7);
}

TEST(Csv, ForeignColumnsAreKept) {
  const std::string text = "x,y,z,label,near_ir,signal\n1,2,3,7,812,-0.25\n4,5,6,8,0,1e-300\n";
  const Scan scan = decodedCsv(text);
  ASSERT_EQ(scan.foreign.size(), 2u);
  EXPECT_EQ(scan.foreign[0].name, "near_ir");
  EXPECT_EQ(std::get<std::vector<double>>(scan.foreign[1].values), (std::vector<double>{-0.25, 1e-300}));
  EXPECT_EQ(makeFormat("csv")->encode(scan), text);
}

TEST(Csv, TextOfOtherProgramsIsRead) {
  for (const char* text : {
           "x,y,z,label\n1,2,3,7",
           "//X;Y;Z;Classification\n1;2;3;7\n",
           "# x y z class\n1  2 3 7.000000\n",
           "\xEF\xBB\xBF\"x\"\t\"y\"\t\"z\"\t\"label\"\r\n1\t+2\t3.0e0\t7\r\n\r\n",
           "# by hand\n\nx, y, z, scalar_Classification\n# the only point\n1, 2, 3, 7\n",
       }) {
    const Scan scan = decodedCsv(text);
    ASSERT_EQ(scan.size(), 1u) << text;
    EXPECT_EQ(scan.position[0], (Vec3f{1, 2, 3})) << text;
    EXPECT_EQ(scan[kLabel], std::vector<std::uint16_t>{7}) << text;
    EXPECT_TRUE(scan.foreign.empty()) << text;
  }
  EXPECT_EQ(decodedCsv("1 2 3\n4 5 6").position[1], (Vec3f{4, 5, 6}));
}

TEST(Csv, OtherColumnsMayHaveAnyName) {
  const Scan scan = decodedCsv(",x,y,z,distance,Slot ID,4\n0,1,2,3,9,7,5\n,4,5,6,9,7,5\n");
  EXPECT_EQ(scan.position, (std::vector<Vec3f>{{1, 2, 3}, {4, 5, 6}}));
  std::vector<std::string> names;
  for (const ForeignColumn& column : scan.foreign) names.push_back(column.name);
  EXPECT_EQ(names, (std::vector<std::string>{"column_1", "distance", "Slot_ID", "_4"}));
  testing::internal::CaptureStderr();
  decodedCsv("x,y,z,Code\n1,2,3,STN\n");
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("test.csv: left out: 1 texts in the column 'Code'"));
}

TEST(Csv, IntensitiesOfZeroGiveWayToOthers) {
  EXPECT_EQ(decodedCsv("x,y,z,intensity,reflectivity\n1,2,3,0,7\n4,5,6,0,8\n")[kIntensity], (std::vector<float>{7, 8}));
  EXPECT_EQ(decodedCsv("x,y,z,intensity,reflectivity\n1,2,3,0,7\n4,5,6,1,8\n")[kIntensity], (std::vector<float>{0, 1}));
}

TEST(Csv, LabelsAndInstancesMayBeNone) {
  const Scan scan = decodedCsv("x,y,z,label,instance\n1,2,3,-100,-1\n4,5,6,8,0\n7,8,9,8,4.0\n");
  EXPECT_EQ(scan[kLabel], (std::vector<std::uint16_t>{0, 8, 8}));
  EXPECT_EQ(scan[kInstance], (std::vector<std::uint32_t>{0, 1, 5}));
  EXPECT_EQ(decodedCsv("x,y,z,label\n1,2,3,-1\n1,2,3,0\n")[kLabel], (std::vector<std::uint16_t>{65535, 0}))
      << "0 may be a class";
}

TEST(Csv, ErrorsNameTheLine) {
  const std::pair<const char*, const char*> bad[] = {
      {"", "test.csv:1"},
      {"# nothing", "test.csv:1: the file is empty"},
      {"x,y,z\n1,2,3\n4,5", "test.csv:3: 2 values"},
      {"x,y\n1,2\n", "test.csv:1: no columns x, y and z: the first line must name them, as x,y,z,label, not 'x,y'"},
      {"Easting,Northing,Elevation\n1,2,3\n", "not 'Easting,Northing,Elevation'"},
      {"x,y,z\r1,2,3\r", "no columns x, y and z"},
      {"2\n1 2 3\n4 5 6\n", "test.csv:1: no columns x, y and z"},
      {"//X Y Z R\n2\n1 2 3 200\n", "test.csv:2: 1 values where the header names 4 columns"},
      {"x,y,z,x\n", "named twice"},
      {"x,y,z (m),4\n", "not 'x,y,z (m),4'"},
      {"x,y,z\n1,2,3\n1,2\n", "test.csv:3: 2 values"},
      {"x,y,z\n1,2,3,4\n", "test.csv:2: 4 values"},
      {"x,y,z\n1,2,\n", "test.csv:2: z"},
      {"x,y,z\n1,2,3\r4\n", "test.csv:2: z"},
      {"x,y,z\n\n# empty\n1,2,x\n", "test.csv:4: z must be a number such as 1234.5"},
      {"x;y;z\n1,5;2;3\n", "test.csv:2: x must be a number"},
      {"x,y,z\n1,5,2,5,3,5\n", "test.csv:2: 6 values where the header names 3 columns: decimals need a point"},
      {"x;y;z\n1.234,5;2;3\n", "test.csv:2: x"},
      {"x;y;z\n1'234;2;3\n", "test.csv:2: x"},
      {"x;y;z\n1 234;2;3\n", "test.csv:2: x"},
      {"x y z\n1 234 2 3\n", "test.csv:2: 4 values"},
      {"x,y,z\n1.0f,2,3\n", "test.csv:2: x must be a number such as 1234.5 or -1.2e-3, not '1.0f'"},
      {"x,y,z\n1D3,2,3\n", "test.csv:2: x"},
      {"x,y,z\n0x10,2,3\n", "test.csv:2: x"},
      {"x,y,z\n+-1,2,3\n", "test.csv:2: x"},
      {"1,2,3,4\n", "test.csv:1: no columns"},
      {"1,5 2,5 3,5\n", "test.csv:1: no columns"},
      {"x,y,z,label\n1,2,3,65536\n", "65535"},
      {"x,y,z,label\n1,2,3,-2\n", "label of point 0 is -2"},
      {"x,y,z,instance\n1,2,3,1.5\n", "test.csv:2: instance"},
      {"x,y,z,instance\n1,2,3,-1\n1,2,3,4294967295\n", "instance of point 1 is 4294967296"},
      {"x,y,z,class\n1,2,3,car\n", "test.csv:2: class must be a number"},
      {"x,y,z,label\n1,2,3,65536.0\n", "65535"},
      {"x,y,z,instance\n1,2,3,4294967296\n", "4294967295"},
  };
  for (const auto& [text, message] : bad) {
    EXPECT_THAT(messageOf([&] { decodedCsv(text); }), HasSubstr(message)) << text;
  }
}

}  // namespace
}  // namespace scanmill
