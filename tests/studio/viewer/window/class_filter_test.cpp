#include "tests/studio/viewer/window/fake_frames.h"
#include "tests/support/message_of.h"
#include "viewer/window/session_context.h"

namespace scanmill {
namespace {

TEST(ClassFilter, HidesOrShowsAlone) {
  const Ontology ontology = fakeOntology();
  const ClassFilter hidden({"road", "20"}, false, &ontology);
  EXPECT_FALSE(hidden.shows(kFakeRoad));
  EXPECT_FALSE(hidden.shows(kFakeCar));
  EXPECT_TRUE(hidden.shows(kFakeTree));
  EXPECT_EQ(hidden.text(&ontology), "without road, car");
  const ClassFilter alone({"road", "20"}, true, &ontology);
  for (std::uint32_t id = 0; id <= UINT16_MAX; ++id) {
    const auto c = static_cast<std::uint16_t>(id);
    EXPECT_NE(hidden.shows(c), alone.shows(c));
  }
  EXPECT_EQ(alone.text(nullptr), "only class 1, class 20");
}

TEST(ClassFilter, TogglingTwiceChangesNothing) {
  ClassFilter filter;
  EXPECT_TRUE(filter.showsAll());
  filter.toggle(7);
  EXPECT_FALSE(filter.shows(7));
  filter.toggle(7);
  EXPECT_TRUE(filter.showsAll());
  filter.showOnly(7);
  EXPECT_TRUE(filter.shows(7));
  EXPECT_FALSE(filter.shows(8));
  filter.toggle(8);
  EXPECT_TRUE(filter.shows(8));
  filter.toggle(8);
  filter.toggle(7);
  EXPECT_EQ(filter.text(nullptr), "all classes hidden");
  filter.showAll();
  EXPECT_TRUE(filter.showsAll());
  EXPECT_EQ(filter.text(nullptr), "");
}

TEST(ClassFilter, UnknownNamesAreRefused) {
  const Ontology ontology = fakeOntology();
  EXPECT_THAT(messageOf([&] { ClassFilter({"raod"}, false, &ontology); }), testing::HasSubstr("road"));
  EXPECT_THAT(messageOf([] { ClassFilter({"road"}, false, nullptr); }), testing::HasSubstr("--ontology"));
  EXPECT_NO_THROW(ClassFilter({"4711"}, false, nullptr));
}

}  // namespace
}  // namespace scanmill
