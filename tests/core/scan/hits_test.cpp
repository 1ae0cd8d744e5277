#include "scan/hits.h"

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

TEST(Hits, WhatIsNotAskedForDoesNotOutliveAReset) {
  Hits hits;
  hits.roughness = hits.metallic = hits.retroreflectance = {0.5f};
  hits.unresolved = {1, 4};
  hits.reset(2, 3, Channels::all());
  EXPECT_TRUE(hits.roughness.empty() && hits.metallic.empty() && hits.retroreflectance.empty());
  EXPECT_TRUE(hits.unresolved.empty());
  hits.range[0] = kMiss;
  EXPECT_FALSE(hits.hit(0));
}

}  // namespace
}  // namespace scanmill
