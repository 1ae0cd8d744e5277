#include <draco/compression/entropy/symbol_decoding.h>
#include <fmt/format.h>

#include <random>

#include "formats/draco_writer.h"

namespace scanmill {
namespace {

constexpr std::uint16_t kBitstream = 0x0203;

std::vector<std::uint32_t> throughDraco(const std::string& bytes, std::size_t count, int components) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size(), kBitstream);
  std::vector<std::uint32_t> symbols(count);
  EXPECT_TRUE(draco::DecodeSymbols(static_cast<std::uint32_t>(count), components, &buffer, symbols.data()));
  EXPECT_EQ(buffer.remaining_size(), 0);
  return symbols;
}

TEST(DracoSymbols, DracoReadsThemBack) {
  std::mt19937 generator(11);
  for (const int components : {1, 3}) {
    for (const std::size_t entries : {1u, 2u, 17u, 1000u, 30000u}) {
      for (const int level : {0, 3, 5, 7, 9, 10}) {
        for (unsigned bits = 0; bits <= 31; bits += bits < 20 ? 1 : 4) {
          SCOPED_TRACE(fmt::format("{} x {}, level {}, {} bits", entries, components, level, bits));
          std::vector<std::uint32_t> symbols(entries * static_cast<std::size_t>(components));
          // Small values are frequent, as after prediction.
          for (std::uint32_t& symbol : symbols) {
            const unsigned width = static_cast<unsigned>(generator()) % (bits + 1);
            symbol = static_cast<std::uint32_t>(generator() & ((std::uint64_t{1} << width) - 1));
          }
          std::string bytes;
          appendSymbols(symbols, components, level, bytes);
          ASSERT_EQ(throughDraco(bytes, symbols.size(), components), symbols);
        }
      }
    }
  }
}

TEST(DracoSymbols, AlphabetsAtTheLimitOfTheTable) {
  for (const std::uint32_t size : {1u << 12, (1u << 17) - 1, 1u << 18, (1u << 18) + 1}) {
    std::vector<std::uint32_t> symbols;
    for (std::uint32_t s = 0; s < size; ++s) symbols.insert(symbols.end(), 1 + (s % 97 == 0), s);
    symbols.insert(symbols.end(), 3 * size, 5);  // one symbol that takes nearly all of the probability
    std::string bytes;
    appendSymbols(symbols, 1, 0, bytes);
    ASSERT_EQ(throughDraco(bytes, symbols.size(), 1), symbols) << size;
  }
}

TEST(DracoSymbols, SkewedDistributionsComeNearTheirEntropy) {
  for (const double rare : {0.5, 0.1, 0.01, 0.001}) {
    std::mt19937 generator(3);
    std::bernoulli_distribution draw(rare);
    std::vector<std::uint32_t> symbols(100'000);
    for (std::uint32_t& symbol : symbols) symbol = draw(generator) ? 9 : 0;
    std::string bytes;
    appendSymbols(symbols, 1, 7, bytes);
    const double entropy = -(rare * std::log2(rare) + (1 - rare) * std::log2(1 - rare)) * 100'000 / 8;
    EXPECT_LT(static_cast<double>(bytes.size()), 1.05 * entropy + 20) << rare;
    ASSERT_EQ(throughDraco(bytes, symbols.size(), 1), symbols);
  }
}

TEST(DracoSymbols, OneSymbolAloneTakesNoSpace) {
  std::string bytes;
  appendSymbols(std::vector<std::uint32_t>(1'000'000, 3), 1, 3, bytes);
  EXPECT_LT(bytes.size(), 16u);
  EXPECT_EQ(throughDraco(bytes, 1'000'000, 1), std::vector<std::uint32_t>(1'000'000, 3));
}

}  // namespace
}  // namespace scanmill
