#include "scan/channels.h"

namespace scanmill {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Channels, IsASet) {
  constexpr Channels kAsked = Channel::Range | Channel::Semantic;
  EXPECT_TRUE(kAsked.has(Channel::Range));
  EXPECT_TRUE(kAsked.has(Channel::Semantic));
  EXPECT_FALSE(kAsked.has(Channel::Instance));
  EXPECT_EQ(kAsked | Channel::Range, kAsked);
  EXPECT_EQ(Channel::Semantic | Channel::Range, kAsked);
  EXPECT_FALSE(Channels{}.has(Channel::Range));
  Channels grown;
  grown |= Channel::Incidence;
  EXPECT_EQ(grown, Channels(Channel::Incidence));
}

TEST(Channels, NamesFollowTheEnumeration) {
  EXPECT_THAT(channelNames({}), IsEmpty());
  EXPECT_THAT(channelNames(Channel::Incidence | Channel::Range), ElementsAre("range", "incidence"));
  const std::vector<std::string> all = channelNames(Channels::all());
  ASSERT_EQ(all.size(), kChannels.size());
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], kChannels[i].name);
}

}  // namespace
}  // namespace scanmill
