#include "base/hash.h"

namespace scanmill {
namespace {

// FIPS 180-4 examples.
TEST(Sha256, GivesTheKnownAnswers) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, PiecesAddUpToTheWhole) {
  const std::string text(1000, 'x');
  for (const std::size_t cut : {0u, 1u, 63u, 64u, 65u, 999u, 1000u}) {
    Sha256 hash;
    hash.add(std::string_view(text).substr(0, cut));
    hash.add(std::string_view(text).substr(cut));
    EXPECT_EQ(hash.hex(), sha256(text)) << cut;
  }
}

// What `xxhsum -H3` prints.
TEST(Xxh3, GivesWhatOtherProgramsGive) {
  EXPECT_EQ(xxh3(""), "2d06800538d394c2");
  EXPECT_EQ(xxh3("abc"), "78af5f94892f3950");
  EXPECT_NE(xxh3(std::string(5000, 'x')), xxh3(std::string(4999, 'x') + "y"));
}

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
