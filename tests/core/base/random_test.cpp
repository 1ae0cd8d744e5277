#include "base/random.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kOnes = 0xFFFFFFFF;

// Known answers of the Random123 distribution (kat_vectors, philox4x32 10).
TEST(Philox, GivesTheKnownAnswers) {
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (RandomBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}),
            (RandomBlock{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (RandomBlock{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomBlock, EveryPartOfTheAddressCounts) {
  const RandomAddress base{.seed = 7, .scene = 1, .frame = 2, .sensor = 3, .beam = 4, .number = 1};
  std::vector<RandomAddress> addresses(9, base);
  addresses[1].seed = 8;
  addresses[2].seed += std::uint64_t{1} << 32;
  addresses[3].scene = 2;
  addresses[4].frame = 3;
  addresses[5].sensor = 4095;
  addresses[6].beam = 5;
  addresses[7].number = 15;
  addresses[8].purpose = Purpose::RangeNoise;
  std::set<RandomBlock> blocks;
  for (const RandomAddress& address : addresses) blocks.insert(randomBlock(address));
  EXPECT_EQ(blocks.size(), addresses.size());
}

TEST(RandomBlock, NoTwoAddressesShareACounter) {
  // Philox is a bijection of the counter, so distinct addresses of one seed must give distinct blocks.
  std::set<RandomBlock> blocks;
  std::size_t addresses = 0;
  for (const std::uint32_t sensor : {0u, 1u, 15u, 16u, 4095u}) {
    for (std::uint32_t number = 0; number < 16; ++number) {
      for (const Purpose purpose : {Purpose::RangeNoise, Purpose::AngularJitter, Purpose::ShellNoise, Purpose::DropOut,
                                    Purpose::Street, Purpose::Test}) {
        for (std::uint32_t beam = 0; beam < 3; ++beam) {
          blocks.insert(randomBlock({.sensor = sensor, .beam = beam, .number = number, .purpose = purpose}));
          ++addresses;
        }
      }
    }
  }
  EXPECT_EQ(blocks.size(), addresses);
}

TEST(Uniform, StaysInsideTheOpenInterval) {
  EXPECT_GT(uniform(0), 0.0);
  EXPECT_LT(uniform(kOnes), 1.0);
  EXPECT_TRUE(std::isfinite(std::log(uniform(0))));
  EXPECT_EQ(uniform(0x7FFFFFFF) + uniform(0x80000000), 1.0);
}

}  // namespace
}  // namespace scanmill
