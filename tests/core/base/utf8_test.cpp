#include <fmt/core.h>

#include <string>

#include "base/terminal.h"

namespace scanmill {
namespace {

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
