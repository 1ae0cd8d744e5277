#include "scan/reasons.h"

namespace scanmill {
namespace {

TEST(Reasons, RowsAreToldApartByValueNameAndColour) {
  std::set<std::uint8_t> values;
  std::set<std::string_view> names;
  std::set<std::array<std::uint8_t, 3>> colors;
  for (const ReasonEntry& row : reasons()) {
    EXPECT_TRUE(values.insert(static_cast<std::uint8_t>(row.reason)).second) << row.name;
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_TRUE(colors.insert(row.color).second) << row.name;
    EXPECT_FALSE(row.meaning.empty());
    EXPECT_EQ(findReason(row.name), &row);
    EXPECT_EQ(findReason(static_cast<std::uint8_t>(row.reason)), &row);
  }
  EXPECT_EQ(findReason("no"), nullptr);
  EXPECT_EQ(findReason(std::uint8_t{0}), nullptr);
}

TEST(Reasons, AreCounted) {
  EXPECT_EQ(countReasons(std::vector<std::uint8_t>{1, 16, 1, 18}), (ReasonCounts{{1, 2}, {16, 1}, {18, 1}}));
  EXPECT_TRUE(countReasons({}).empty());
}

}  // namespace
}  // namespace scanmill
