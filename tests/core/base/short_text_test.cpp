#include "base/short_text.h"

namespace scanmill {
namespace {

TEST(ShortText, NumbersHaveThreeDigits) {
  EXPECT_EQ(shortNumber(7), "7");
  EXPECT_EQ(shortNumber(456'000), "456 k");
  EXPECT_EQ(shortNumber(999'900), "1 M");
  EXPECT_EQ(shortNumber(12'345'678), "12.3 M");
  EXPECT_EQ(shortNumber(-2.5e9), "-2.5 G");
}

TEST(ShortText, SizesHaveBinaryPrefixes) {
  EXPECT_EQ(shortBytes(1000), "1000 B");
  EXPECT_EQ(shortBytes(1024), "1.0 KiB");
  EXPECT_EQ(shortBytes(1.25 * 1024 * 1024 * 1024), "1.2 GiB");
}

TEST(ShortText, LengthsAreMetresAndKilometres) {
  EXPECT_EQ(shortLength(881.83), "881.8 m");
  EXPECT_EQ(shortLength(-0.0012), "-0.0012 m");
  EXPECT_EQ(shortLength(89240), "89.2 km");
  EXPECT_EQ(shortLength(12345678), "12346 km");
}

TEST(ShortText, TimesAreSecondsMinutesAndHours) {
  EXPECT_EQ(shortTime(6), "6.0 s");
  EXPECT_EQ(shortTime(245), "4 min 5 s");
  EXPECT_EQ(shortTime(3723), "1 h 2 min");
}

TEST(ShortText, ListsNameTheFirstAndCountTheOthers) {
  EXPECT_EQ(shortList({}, 2), "");
  EXPECT_EQ(shortList({"a", "b"}, 2), "a, b");
  EXPECT_EQ(shortList({"a", "b", "c", "d"}, 2), "a, b and 2 more");
}

}  // namespace
}  // namespace scanmill
