#include "report/dataset/alike_lines.h"

#include <fmt/core.h>
#include <gmock/gmock.h>

namespace scanmill {
namespace {

using testing::ElementsAre;

TEST(AlikeLines, NamesThatDifferInTheirNumberAreOne) {
  std::vector<std::string> names{"Tree"};
  for (int i = 1; i <= 50; ++i) names.push_back(fmt::format("Bauble.{:03}", i));
  names.insert(names.end(), {"Star", "Bauble", "candle_1", "candle_2", "lamp 7", "3", "4"});
  EXPECT_THAT(alikeLines(names),
              ElementsAre("Tree", "Bauble (50)", "Star", "Bauble", "candle (2)", "lamp 7", "3 to 4 (2 times)"));
}

TEST(AlikeLines, OfOtherNumbersTheRangeIsTold) {
  EXPECT_THAT(alikeLines({"277 objects of 3", "geometry: exact", "1294 objects of 3", "geometry: exact"}),
              ElementsAre("277 to 1294 objects of 3 (2 times)", "geometry: exact"));
  EXPECT_THAT(alikeLines({"a 1 b 2", "a 2 b 3"}), ElementsAre("a 1 to 2 b 2 to 3 (2 times)"));
  EXPECT_TRUE(alikeLines({}).empty());
}

}  // namespace
}  // namespace scanmill
