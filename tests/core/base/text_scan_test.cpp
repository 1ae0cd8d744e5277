#include "base/text_scan.h"

namespace scanmill {
namespace {

using ::testing::ElementsAre;

TEST(TextScan, LinesWordsAndCellsComeWithoutBlanks) {
  std::string_view rest = textOfFile("\xEF\xBB\xBF a\tb \r\nlast");
  EXPECT_THAT(wordsOf(takeLine(rest)), ElementsAre("a", "b"));
  EXPECT_EQ(takeLine(rest), "last");
  EXPECT_TRUE(rest.empty());
  std::vector<std::string_view> cells;
  splitCells(" a, \"b,c\" ,,d", ',', cells);
  EXPECT_THAT(cells, ElementsAre("a", "b,c", "", "d"));
  splitCells("a  \"b c\"\t d ", ' ', cells);
  EXPECT_THAT(cells, ElementsAre("a", "b c", "d"));
}

TEST(TextScan, NumbersAreWholeWordsThatTheTypeCanHold) {
  for (const char* text : {"", "+", "+-1", "1x", " 1", "1,5", "1e400"}) {
    double number = 0;
    EXPECT_FALSE(parseNumber(text, number)) << text;
  }
  double number = 1;
  EXPECT_TRUE(parseNumber("+1.5", number) && number == 1.5);
  EXPECT_TRUE(parseNumber("1e-400", number) && number == 0);
  float narrow = 1;
  EXPECT_TRUE(parseNumber("1e-60", narrow) && narrow == 0);
  EXPECT_FALSE(parseNumber("1e60", narrow));
  std::uint8_t byte = 0;
  EXPECT_TRUE(parseNumber("255", byte) && byte == 255);
  EXPECT_FALSE(parseNumber("256", byte));
}

}  // namespace
}  // namespace scanmill
