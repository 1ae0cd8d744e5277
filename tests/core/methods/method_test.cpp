#include "methods/method.h"

#include <set>

#include "tests/core/methods/trace.h"

namespace scanmill {
namespace {

TEST(Methods, RowsSayWhatTheirMethodsCan) {
  const Scene nothing;
  std::set<std::array<std::uint8_t, 3>> colors;
  for (const MethodEntry& entry : methods()) {
    EXPECT_EQ(&requireMethod(entry.name, {}), &entry);
    EXPECT_EQ(methodOf(entry.name, nothing)->depthCamera() != nullptr, entry.can.passes) << entry.name;
    EXPECT_TRUE(colors.insert(entry.color).second) << entry.name << " looks like another";
  }
  EXPECT_EQ(findMethod("lidar"), nullptr);
}

TEST(Methods, SomeRowCanBeTheReferenceAndSomeDrawsPasses) {
  EXPECT_TRUE(firstMethodThat(&MethodCapabilities::reference).can.reference);
  EXPECT_TRUE(firstMethodThat(&MethodCapabilities::passes).can.passes);
}

}  // namespace
}  // namespace scanmill
