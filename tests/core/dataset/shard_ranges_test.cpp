
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "base/error.h"
#include "dataset/shard_name.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(ShardRanges, AreReadAsPeopleWriteThem) {
  EXPECT_THAT(parseShardRanges("0-3,7,2-4", 8), ElementsAre(0, 1, 2, 3, 4, 7));
  EXPECT_THAT(parseShardRanges("5", 6), ElementsAre(5));
}

TEST(ShardRanges, WrittenAndReadTheyAreTheSame) {
  std::minstd_rand random(5);
  for (int i = 0; i < 200; ++i) {
    std::set<std::uint64_t> some;
    for (std::uint64_t n = 0; n < random() % 40 + 1; ++n) some.insert(random() % 50);
    const std::vector<std::uint64_t> numbers(some.begin(), some.end());
    EXPECT_EQ(parseShardRanges(shardRanges(numbers), 50), numbers) << shardRanges(numbers);
  }
  EXPECT_EQ(shardRanges({0, 1, 2, 5, 7, 8}), "0-2,5,7-8");
}

TEST(ShardRanges, WhatIsNoneIsRefused) {
  for (const char* text :
       {"", ",", "1,", "a", "-1", "1-", "3-1", "1-2-3", "0x1", "99999999999999999999", " 1", "1.5"}) {
    EXPECT_THAT(messageOf<InputError>([&] { parseShardRanges(text, 10); }), HasSubstr("such as 0-9,12")) << text;
  }
  EXPECT_THAT(messageOf<InputError>([&] { parseShardRanges("0-10", 10); }), HasSubstr("has the shards 0 to 9"));
  EXPECT_THAT(messageOf<InputError>([&] { parseShardRanges("1", 1); }), HasSubstr("has only the shard 0"));
}

}  // namespace
}  // namespace scanmill
