#include "scene/shares.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/message_of.h"
#include "tests/support/town.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<ShareBound> sharesOf(const std::string& yaml, const std::string& ontology = "scanmill.yaml") {
  return readShares(parseYaml(yaml, "scene.yaml"), readOntology(kLabels / ontology));
}

TEST(Shares, AreOfClassesAndOfAllThatAFactorGoverns) {
  const std::vector<ShareBound> bounds = sharesOf("{car: [0, 0.02], greenery: [0.2, 0.4], person: [0.001, 1]}");
  ASSERT_EQ(bounds.size(), 3u);
  EXPECT_THAT(bounds[0].classes, ElementsAre(20));
  EXPECT_EQ(bounds[0].supply, Supply::Vehicles);
  EXPECT_THAT(bounds[1].classes, ElementsAre(11, 10, 12));
  EXPECT_EQ(bounds[1].supply, Supply::Greenery);
  EXPECT_EQ(bounds[1].least, 0.2);
  EXPECT_EQ(bounds[1].most, 0.4);
  EXPECT_THAT(bounds[2].classes, ElementsAre(30)) << "by its alias";
  EXPECT_EQ(bounds[2].supply, Supply::People);
}

TEST(Shares, CountClassesThatAnOntologyTakesAsOneOnce) {
  EXPECT_THAT(sharesOf("{greenery: [0.2, 0.4]}", "semantic_kitti.yaml")[0].classes, ElementsAre(70, 71));
}

TEST(Shares, RefuseWhatNoTownCanMeet) {
  const auto refusal = [](const std::string& yaml) { return messageOf([&] { sharesOf(yaml); }); };
  EXPECT_THAT(refusal("{road: [0, 0.5]}"),
              AllOf(HasSubstr("scene.yaml:1"), HasSubstr("road"), HasSubstr("vehicles (car, truck")));
  EXPECT_THAT(refusal("{caar: [0, 0.5]}"), HasSubstr("did you mean 'car'"));
  EXPECT_THAT(refusal("{greenary: [0, 0.5]}"), HasSubstr("did you mean 'greenery'"));
  EXPECT_THAT(messageOf([] { makeTown("{vehicles: 0, shares: {car: [0.1, 0.5]}}", 1); }),
              AllOf(HasSubstr("town.yaml:1"), HasSubstr("`vehicles: 0`")));
  EXPECT_THAT(refusal("{car: 0.5}"), AllOf(HasSubstr("scene.yaml:1"), HasSubstr("list")));
  EXPECT_THAT(refusal("{car: [0.5]}"), HasSubstr("[least, most]"));
  EXPECT_THAT(refusal("{car: [0.5, 0.2]}"), HasSubstr("[least, most]"));
  EXPECT_THAT(refusal("{car: [0, 20]}"), HasSubstr("1"));
  EXPECT_EQ(sharesOf("{car: [0, 0]}")[0].most, 0) << "none at all";
  EXPECT_THAT(refusal("{}"), HasSubstr("bounds"));
  EXPECT_THAT(refusal("[car]"), HasSubstr("bounds"));
}

}  // namespace
}  // namespace scanmill
