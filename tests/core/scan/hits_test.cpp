#include "scan/hits.h"

#include <vector>

namespace scanmill {
namespace {

constexpr std::size_t kCount = kChannels.size();

// Sizes of the arrays in the order of Channel.
std::vector<std::size_t> sizes(const Hits& hits) {
  std::vector<std::size_t> sizes;
  forEachChannel([&](const ChannelRow&, auto member) { sizes.push_back((hits.*member).size()); });
  return sizes;
}

TEST(Hits, OnlyWhatWasAskedForIsAllocated) {
  for (std::uint32_t set = 0; set < 1u << kCount; ++set) {
    Channels asked;
    for (const ChannelRow& row : kChannels) {
      if ((set & static_cast<std::uint32_t>(row.channel)) != 0) asked |= row.channel;
    }
    Hits hits;
    hits.reset(3, 5, asked);
    EXPECT_EQ(hits.size(), 15u);
    EXPECT_EQ(hits.channels, asked | Channel::Range);
    const auto held = sizes(hits);
    EXPECT_EQ(held[0], 15u);
    for (std::size_t bit = 1; bit < kCount; ++bit) EXPECT_EQ(held[bit], (set >> bit & 1) != 0 ? 15u : 0u) << set;
  }
}

TEST(Hits, RowsAreInTheOrderOfTheBits) {
  for (std::size_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(static_cast<std::uint32_t>(kChannels[i].channel), 1u << i) << kChannels[i].name;
  }
}

TEST(Hits, ResetFollowsTheNewShape) {
  Hits hits;
  hits.reset(64, 2048, Channels::all());
  for (const std::size_t n : sizes(hits)) EXPECT_EQ(n, 64u * 2048u);
  hits.reset(1, 1, Channel::Semantic);
  for (std::size_t i = 0; i < kCount; ++i) EXPECT_EQ(sizes(hits)[i], i == 0 || i == 3 ? 1u : 0u) << i;
  hits.reset(0, 0, Channels::all());
  EXPECT_EQ(hits.size(), 0u);
  hits.reset(2048, 2048, Channel::Range);
  EXPECT_EQ(hits.range.size(), 4'194'304u);
}

TEST(Hits, TheLookIsNotAskedForAndDoesNotOutliveAReset) {
  Hits hits;
  hits.reset(2, 3, Channels::all());
  EXPECT_TRUE(hits.roughness.empty() && hits.metallic.empty() && hits.retroreflectance.empty());
  hits.roughness.assign(6, 0.5f);
  hits.metallic.assign(6, 1.0f);
  hits.retroreflectance.assign(6, 2.0f);
  hits.reset(2, 3, Channels::all());
  EXPECT_TRUE(hits.roughness.empty() && hits.metallic.empty() && hits.retroreflectance.empty());
}

TEST(Hits, UnresolvedBeamsDoNotOutliveAReset) {
  Hits hits;
  hits.reset(2, 3, Channel::Range);
  EXPECT_TRUE(hits.unresolved.empty());
  hits.unresolved = {1, 4};
  hits.reset(2, 3, Channel::Range);
  EXPECT_TRUE(hits.unresolved.empty());
}

TEST(Hits, SizeDoesNotOverflow32Bits) {
  Hits hits;
  hits.rings = 1u << 20;
  hits.columns = 1u << 20;
  EXPECT_EQ(hits.size(), std::size_t{1} << 40);
}

TEST(Hits, AMissIsInfinitelyFar) {
  Hits hits;
  hits.reset(1, 3, Channel::Range);
  hits.range = {12.5f, kMiss, 0.0f};
  EXPECT_TRUE(hits.hit(0));
  EXPECT_FALSE(hits.hit(1));
  EXPECT_TRUE(hits.hit(2));
  EXPECT_TRUE(std::isinf(kMiss));
}

}  // namespace
}  // namespace scanmill
