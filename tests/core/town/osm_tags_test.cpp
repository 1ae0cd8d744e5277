#include "town/osm.h"

namespace scanmill::town {
namespace {

using testing::DoubleNear;
using testing::Optional;

TEST(OsmTags, LengthsAreReadInMetres) {
  const std::pair<const char*, double> kLengths[] = {
      {"12", 12},       {"7.5 m", 7.5},   {"30m", 30},       {"0.02 km", 20}, {"10'", 3.048}, {"98 ft", 29.8704},
      {"98'", 29.8704}, {"12'6\"", 3.81}, {"12' 6\"", 3.81}, {"80 cm", 0.8},  {"7 km", 7000}, {"0.1 mi", 160.9344}};
  for (const auto& [text, metres] : kLengths) EXPECT_THAT(metresOf(text), Optional(DoubleNear(metres, 1e-9))) << text;
  for (const char* none : {"", "wide", "-3", "3;4", "3,5", "nan", "inf", "1e9", "1,200", "~10", "12'6", ".", "10-12"}) {
    EXPECT_EQ(metresOf(none), std::nullopt) << none;
  }
}

TEST(OsmTags, DirectionsAreReadInDegrees) {
  EXPECT_THAT(compassOf("ESE"), Optional(112.5));
  EXPECT_THAT(compassOf("90"), Optional(90));
  EXPECT_EQ(compassOf("up"), std::nullopt);
}

// A value that is no number, or beyond the limits, is counted with its element, never replaced in silence.
TEST(OsmTags, ValuesThatCannotBeUsedAreCounted) {
  TagNumbers numbers;
  const auto height = [&](const char* value, const char* element) {
    return numbers.read({element, {{"height", value}}}, "height", metresOf, 0.1, 1000);
  };
  EXPECT_THAT(height("9 m", "way 1"), Optional(9));
  EXPECT_EQ(height("tall", "way 2"), std::nullopt);
  EXPECT_EQ(height("5000", "way 3"), std::nullopt);
  EXPECT_EQ(numbers.read({"way 4", {}}, "height", metresOf, 0, 1), std::nullopt) << "not counted";
  LeftOut leftOut;
  numbers.report(leftOut);
  EXPECT_EQ(leftOut.text(), "2 values of height that cannot be used, such as 'tall' of way 2");
}

}  // namespace
}  // namespace scanmill::town
