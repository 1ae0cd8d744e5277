#include "formats/lzf.h"

#include <lzf.h>

#include <random>

namespace scanmill {
namespace {

std::string compressed(const std::string& bytes) {
  std::string out(mostLzfBytes(bytes.size()), '\0');
  out.resize(compressLzf(bytes.data(), bytes.size(), out.data()));
  return out;
}

std::string decompressed(const std::string& packed, std::size_t size) {
  std::string out(size, '\0');
  EXPECT_EQ(
      lzf_decompress(packed.data(), static_cast<unsigned>(packed.size()), out.data(), static_cast<unsigned>(size)),
      size);
  return out;
}

// Texts of few and of many letters have long matches, overlapping ones, matches at the very end, and none.
TEST(Lzf, LiblzfReadsWhatIsWritten) {
  std::minstd_rand random(1);
  for (int i = 0; i < 3000; ++i) {
    std::string bytes(1 + random() % 700, '\0');
    const auto letters = i % 5 == 0 ? 256 : 1 + random() % 6;
    for (char& c : bytes) c = static_cast<char>(random() % letters);
    if (i % 3 == 0) bytes += bytes;
    const std::string packed = compressed(bytes);
    EXPECT_LE(packed.size(), mostLzfBytes(bytes.size()));
    ASSERT_EQ(decompressed(packed, bytes.size()), bytes) << i;
  }
  EXPECT_EQ(compressed(""), "");
}

TEST(Lzf, MatchesAtTheFormatsReachAreRead) {
  std::minstd_rand random(2);
  for (const std::size_t between : {8190u, 8191u, 8192u, 8193u}) {
    std::string bytes = "abc";
    for (std::size_t i = 0; i + 3 < between; ++i) bytes += static_cast<char>('A' + random() % 26);
    bytes += "abc";
    ASSERT_EQ(decompressed(compressed(bytes), bytes.size()), bytes);
  }
  const std::string run(100000, 'x');
  EXPECT_LT(compressed(run).size(), run.size() / 80);
}

}  // namespace
}  // namespace scanmill
