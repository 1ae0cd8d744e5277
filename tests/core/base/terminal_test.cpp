#include "base/terminal.h"

#include <random>

namespace scanmill {
namespace {

TEST(Terminal, ControlCharactersAreWrittenOut) {
  EXPECT_EQ(forTerminal("a\x1b[2Jb"), "a\\x1b[2Jb");
  EXPECT_EQ(forTerminal("\x1b]0;title\x07"), "\\x1b]0;title\\x07");
  EXPECT_EQ(forTerminal(std::string_view("\0", 1)), "\\x00");
  EXPECT_EQ(forTerminal("\x7f"), "\\x7f");
  EXPECT_EQ(forTerminal("\xc2\x9b[2J"), "\\x9b[2J") << "CSI in one character";
  EXPECT_EQ(forTerminal("\x9b[2J"), "\\x9b[2J") << "and in one byte";
  EXPECT_EQ(forTerminal("a\xff\xe9z\xe2\x82"), "a\\xff\\xe9z\\xe2\\x82") << "what is no UTF-8";
  EXPECT_EQ(forTerminal("\u00e9 \u20ac \U0001f600"), "\u00e9 \u20ac \U0001f600");
  EXPECT_EQ(forTerminal("a\rb"), "a\\rb");
  EXPECT_EQ(forTerminal("gpj\xe2\x80\xae.exe"), "gpj\\u202e.exe");
  EXPECT_EQ(forTerminal("a\u2028b\u2069\u061c\ufeff"), "a\\u2028b\\u2069\\u061c\\ufeff");
  EXPECT_EQ(forTerminal("\xe0\x82\x9b\xed\xa0\x80"), "\\xe0\\x82\\x9b\\xed\\xa0\\x80") << "overlong, a surrogate";
}

TEST(Terminal, AllElseStays) {
  const std::string text = "Stra\xc3\x9f, 1\n2\t3 \xe6\x9d\xb1\xe4\xba\xac \xf0\x9f\x9a\x97 \\ \" ~";
  EXPECT_EQ(forTerminal(text), text);
  EXPECT_EQ(oneLine("a\nerror: b\t"), "a\\nerror: b\\t");
  EXPECT_EQ(indented("a\nerror: b"), "a\n  error: b");
}

// Whatever a file holds: no control character comes out, neither as a byte nor as UTF-8.
TEST(Terminal, NothingElseComesThrough) {
  std::minstd_rand random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string text(random() % 20, ' ');
    for (char& c : text) c = static_cast<char>(random());
    for (const unsigned char c : oneLine(text)) EXPECT_TRUE(c >= 0x20 && c != 0x7f);
    const std::string fit = forTerminal(text);
    EXPECT_EQ(forTerminal(fit), fit);
    for (std::size_t k = 0; k + 1 < fit.size(); ++k) {
      const auto next = static_cast<unsigned char>(fit[k + 1]);
      EXPECT_FALSE(fit[k] == '\xc2' && next >= 0x80 && next < 0xa0);
    }
  }
}

TEST(Utf8, HasTheCharactersOfUnicode) {
  for (const auto& [text, code] : {std::pair{"a", U'a'},
                                   {"\xC2\x80", U'\u0080'},
                                   {"\xDF\xBF", U'\u07FF'},
                                   {"\xE0\xA0\x80", U'\u0800'},
                                   {"\xEF\xBF\xBD", U'\uFFFD'},
                                   {"\xF0\x9F\x9A\x97", U'\U0001F697'},
                                   {"\xF4\x8F\xBF\xBF", U'\U0010FFFF'}}) {
    EXPECT_EQ(utf8At(text, 0).code, code) << text;
    EXPECT_EQ(utf8At(text, 0).bytes, std::string(text).size()) << text;
    EXPECT_TRUE(isUtf8(text));
  }
}

TEST(Utf8, HasNothingElse) {
  for (const char* const text : {"\x80", "\xC0\x80", "\xC1\xBF", "\xC2", "\xC2 ", "\xE0\x9F\xBF", "\xED\xA0\x80",
                                 "\xE2\x82", "\xF0\x8F\xBF\xBF", "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF"}) {
    EXPECT_EQ(utf8At(text, 0).code, kNoCharacter);
    EXPECT_EQ(utf8At(text, 0).bytes, 1u);
    EXPECT_FALSE(isUtf8(fmt::format("a{}", text)));
  }
  EXPECT_EQ(utf8At("a", 1).code, kNoCharacter);
  EXPECT_TRUE(isUtf8(""));
}

TEST(Utf8, ControlsAreUnseen) {
  for (const char32_t c :
       U"\u0001\n\u001b\u007f\u0080\u009b\u009f\u061c\u200e\u200f\u2028\u2029\u202a\u202e\u2066"
       U"\u2069\ufeff") {
    EXPECT_TRUE(isUnseenControl(c)) << static_cast<unsigned>(c);
  }
  for (const char32_t c :
       {U' ', U'~', U'\u00a0', U'\u00e9', U'\u2027', U'\u202f', U'\u2065', U'\u206a', U'\U0001F697', kNoCharacter}) {
    EXPECT_FALSE(isUnseenControl(c)) << static_cast<unsigned>(c);
  }
}

}  // namespace
}  // namespace scanmill
