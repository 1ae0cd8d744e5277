#include "scan/scan.h"

namespace scanmill {
namespace {

using ::testing::ElementsAre;

TEST(Scan, DenseIsOneRowOfItsPointsAndOrganisedHasTheShapeOfTheSensor) {
  Scan scan;
  scan.rings = 4;
  scan.columns = 8;
  scan.position.resize(11);
  EXPECT_EQ(scan.size(), 11u);
  EXPECT_EQ(scan.width(), 11u);
  EXPECT_EQ(scan.height(), 1u);
  scan.organised = true;
  EXPECT_EQ(scan.width(), 8u);
  EXPECT_EQ(scan.height(), 4u);
}

TEST(Scan, WithoutPointsItKeepsTheNamesOfItsColumns) {
  Scan misses;
  misses.organised = true;
  misses.rings = misses.columns = 1;
  misses.position = {{std::nanf(""), 0, 0}};
  misses[kLabel] = {0};
  const Scan none = withoutMisses(misses);
  EXPECT_EQ(none.size(), 0u);
  EXPECT_EQ(columnNames(none), (std::vector<std::string>{"x", "y", "z", "label"}));
  EXPECT_TRUE(none.has(kLabel));
  EXPECT_FALSE(none.has(kRing));
}

TEST(Scan, NamesTheColumnsItHolds) {
  Scan scan;
  scan.position.resize(2);
  EXPECT_THAT(columnNames(scan), ElementsAre("x", "y", "z"));
  scan[kTime].resize(2);
  scan[kLabel].resize(2);
  EXPECT_THAT(columnNames(scan), ElementsAre("x", "y", "z", "label", "time"));
}

}  // namespace
}  // namespace scanmill
