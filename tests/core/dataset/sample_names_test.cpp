#include "dataset/sample_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/message_of.h"

namespace scanmill {

namespace {

using testing::AllOf;
using testing::HasSubstr;

void expectParts(const std::string& member, const MemberName& expected) {
  const MemberName parts = partsOfMember(member);
  EXPECT_EQ(parts.key, expected.key) << member;
  EXPECT_EQ(parts.sensor, expected.sensor) << member;
  EXPECT_EQ(parts.method, expected.method) << member;
  EXPECT_EQ(parts.suffix, expected.suffix) << member;
}

TEST(PartsOfMember, ByDots) {
  expectParts("street-s1-lane-000012.top.ray_tracing.pcd", {"street-s1-lane-000012", "top", "ray_tracing", "pcd"});
  expectParts("a.top.pcd", {"a", "top", "", "pcd"});
  expectParts("a.pcd", {"a", "", "", "pcd"});
  expectParts("a", {"a", "", "", ""});
  expectParts("v1.2/a.top.x.y.drc", {"v1.2/a", "top", "x.y", "drc"});
  expectParts("a..pcd", {"a", "", "", "pcd"});
  expectParts("", {"", "", "", ""});
}

const std::vector<std::string> kKeys{"town-s1-lane-000000", "town-s1-lane-000001", "town-s2-lane-000000"};

std::string complaintOf(const std::string& wanted) {
  return messageOf<InputError>([&] { findKey(kKeys, wanted, "data"); });
}

TEST(FindKey, ByKeyIndexPartOrTheMiddle) {
  EXPECT_EQ(findKey(kKeys, "", "data"), 1u);
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    EXPECT_EQ(findKey(kKeys, kKeys[i], "data"), i);
    EXPECT_EQ(findKey(kKeys, std::to_string(i), "data"), i);
  }
  EXPECT_EQ(findKey(kKeys, "s2", "data"), 2u);
  EXPECT_EQ(findKey(kKeys, "lane-000001", "data"), 1u);
}

TEST(FindKey, SaysWhatThereIs) {
  EXPECT_THAT(complaintOf("3"), AllOf(HasSubstr("data"), HasSubstr("0 to 2")));
  EXPECT_THAT(complaintOf("99999999999999999999"), HasSubstr("0 to 2"));
  EXPECT_THAT(complaintOf("s1"),
              AllOf(HasSubstr("part of 2 keys"), HasSubstr("town-s1-lane-000000, town-s1-lane-000001")));
  EXPECT_THAT(complaintOf("town-s2-lane-000001"), HasSubstr("most similar of 3 keys are: town-s1-lane-000001"));
  EXPECT_THAT(messageOf<InputError>([] { findKey({}, "", "data"); }), HasSubstr("has no samples"));
}

}  // namespace

}  // namespace scanmill
