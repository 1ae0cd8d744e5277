#include "base/base64.h"

namespace scanmill {
namespace {

TEST(Base64, IsAsItsStandardSays) {  // RFC 4648, section 10
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xFF\xFE\xFD"), "//79");
}

TEST(Base64, ComesBack) {
  std::string bytes;
  for (int i = 0; i < 300; ++i) {
    bytes += static_cast<char>(i * 7);
    EXPECT_EQ(fromBase64(base64(bytes)), bytes);
  }
  EXPECT_EQ(fromBase64("Zm8"), "fo") << "without padding";
  const std::string large(10'000'001, 'x');
  EXPECT_EQ(fromBase64(base64(large)), large);
  for (const char* const text : {"Zm9v!", "Z", "Zm9v Zm9v", "Zm=v", " Zm9v", "Zm9v\n", "Zm9-"})
    EXPECT_FALSE(fromBase64(text)) << text;
}

}  // namespace
}  // namespace scanmill
