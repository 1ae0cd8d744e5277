#include <map>
#include <set>

#include "scenefile/labelling.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A box of twelve triangles that share corners.
void addBox(AssetPart& part, const Vec3d& middle, const Vec3d& size) {
  const auto first = static_cast<std::uint32_t>(part.positions.size());
  for (int i = 0; i < 8; ++i) {
    part.positions.push_back(Vec3f(
        middle + Vec3d{(i & 1 ? 0.5 : -0.5) * size.x, (i & 2 ? 0.5 : -0.5) * size.y, (i & 4 ? 0.5 : -0.5) * size.z}));
  }
  for (const auto& [a, b, c, d] : {std::array{0U, 1U, 3U, 2U},
                                   {4U, 5U, 7U, 6U},
                                   {0U, 1U, 5U, 4U},
                                   {2U, 3U, 7U, 6U},
                                   {0U, 2U, 6U, 4U},
                                   {1U, 3U, 7U, 5U}}) {
    part.triangles.push_back({first + a, first + b, first + c});
    part.triangles.push_back({first + a, first + c, first + d});
  }
}

AssetPart named(const std::string& node, std::uint32_t index) {
  AssetPart part;
  part.node = node;
  part.nodeIndex = index;
  addBox(part, {}, {1, 1, 1});
  return part;
}

ThingBounds bounds(const std::string& yaml) {
  const Value value = parseYaml("{instances: " + yaml + "}", "s.yaml");
  Fields f(value, "object");
  return readThingBounds(f, ThingBounds::By::Object);
}

// Of each part the number of its first triangle's thing.
std::vector<std::uint32_t> firsts(const std::string& yaml, const std::vector<AssetPart>& parts) {
  std::vector<ThingTriangles> triangles;
  for (const AssetPart& part : parts) triangles.push_back({&part, 1});
  std::vector<std::uint32_t> numbers;
  for (const auto& own : numberThings(bounds(yaml), triangles)) numbers.push_back(own.front());
  return numbers;
}

TEST(Things, AreOneOrByNodeOrByWhatTheirNamesShare) {
  const std::vector<AssetPart> parts{named("chair_2/leg", 4), named("chair_1/leg", 1), named("chair_1/seat", 2),
                                     named("lamp", 3), named("chair_2/seat", 5)};
  EXPECT_THAT(firsts("object", parts), ElementsAre(1, 1, 1, 1, 1));
  EXPECT_THAT(firsts("node", parts), ElementsAre(4, 1, 2, 3, 5));
  EXPECT_THAT(firsts("'/chair_[0-9]+/'", parts), ElementsAre(3, 1, 1, 2, 3));
  EXPECT_THAT(firsts("'/^(chair)_.*/'", parts), ElementsAre(1, 1, 1, 2, 1)) << "what the group matches";
}

TEST(Things, OfDifferentClassesAreNeverOneByClass) {
  const std::vector<AssetPart> parts{named("instance 1", 0), named("instance 1", 0), named("instance 2", 1)};
  for (const char* yaml : {"node", "/instance .*/"}) {
    ThingBounds own = bounds(yaml);
    const std::vector<ThingTriangles> triangles{{&parts[0], 7}, {&parts[1], 3}, {&parts[2], 7}};
    const auto first = [&] {
      std::vector<std::uint32_t> numbers;
      for (const auto& partNumbers : numberThings(own, triangles)) numbers.push_back(partNumbers.front());
      return numbers;
    };
    EXPECT_THAT(first(), ElementsAre(1, 1, 2));
    own.byClass = true;
    EXPECT_THAT(first(), ElementsAre(2, 1, 3));
  }
}

TEST(Things, ThatAreConnectedAreOneAndHaveTheirWheels) {
  AssetPart cars;  // bodies and glass of three cars, the third connected with nothing of its own
  for (const double x : {0.0, 10.0, 20.0}) {
    addBox(cars, {x, 0, 1}, {4, 2, 1.5});
    for (const double wheel : {-1.5, 1.5}) addBox(cars, {x + wheel, 1, 0.3}, {0.6, 0.2, 0.6});
  }
  AssetPart glass;
  addBox(glass, {10, 0, 1.6}, {2, 1, 0.4});
  const std::vector<ThingTriangles> triangles{{&cars, 20}, {&glass, 20}};
  const auto numbers = numberThings(bounds("part"), triangles);
  for (std::size_t t = 0; t < cars.triangles.size(); ++t) EXPECT_EQ(numbers[0][t], 1 + t / 36) << t;
  for (const std::uint32_t number : numbers[1]) EXPECT_EQ(number, 2u);
  // Of another class they are other things.
  const auto apart = numberThings(bounds("part"), {{&cars, 20}, {&glass, 21}});
  EXPECT_EQ(apart[1].front(), 4u);
}

// Tiers and a trunk stand on one another; mirrors stick out; the next tree is another.
TEST(Things, HaveWhatStandsOnThemAndWhatSticksOut) {
  AssetPart trees;
  for (const double x : {0.0, 2.2}) {
    addBox(trees, {x, 0, 0.5}, {0.3, 0.3, 1});
    addBox(trees, {x, 0, 1.6}, {2, 2, 1.2});
    addBox(trees, {x, 0, 2.6}, {1.2, 1.2, 1});
  }
  const auto numbers = numberThings(bounds("part"), {{&trees, 1}}).front();
  for (std::size_t t = 0; t < numbers.size(); ++t) EXPECT_EQ(numbers[t], 1 + t / 36) << t;
  AssetPart car;
  addBox(car, {0, 0, 1}, {4, 2, 1.5});
  addBox(car, {0.8, 1.1, 1.1}, {0.2, 0.18, 0.15});  // a mirror
  addBox(car, {1.3, 1.02, 0.3}, {0.7, 0.25, 0.7});  // a wheel that sticks out
  addBox(car, {0, 4.5, 1}, {4, 2, 1.5});            // the next car
  const auto cars = numberThings(bounds("part"), {{&car, 1}}).front();
  for (std::size_t t = 0; t < cars.size(); ++t) EXPECT_EQ(cars[t], t < 36 ? 1u : 2u) << t;
}

// The result follows from what is there, not from the order of the triangles.
TEST(Things, AreTheSameInAnyOrder) {
  std::vector<Vec3d> places;
  for (int i = 0; i < 60; ++i) places.push_back({(i * 37) % 60 * 0.3, (i * 37) % 60 % 2 * 3.0, 0});
  const auto thingsAt = [&](const std::vector<Vec3d>& order) {
    AssetPart part;
    for (const Vec3d& at : order) addBox(part, at, {1, 1, 1});
    const auto numbers = numberThings(bounds("part"), {{&part, 1}}).front();
    std::map<std::pair<double, double>, std::uint32_t> found;
    for (std::size_t i = 0; i < order.size(); ++i) found[{order[i].x, order[i].y}] = numbers[12 * i];
    return found;
  };
  std::vector<Vec3d> turned(places.rbegin(), places.rend());
  const auto a = thingsAt(places);
  const auto b = thingsAt(turned);
  std::set<std::uint32_t> things;
  for (const auto& [p, number] : a) {
    things.insert(number);
    for (const auto& [q, other] : a) EXPECT_EQ(number == other, b.at(p) == b.at(q));
  }
  EXPECT_GT(things.size(), 10u);
  EXPECT_LT(things.size(), 60u);
}

TEST(ConnectedParts, AreJoinedByPlacesOfCornersAcrossParts) {
  AssetPart a, b;
  addBox(a, {0, 0, 0}, {1, 1, 1});
  addBox(b, {1, 0, 0}, {1, 1, 1});  // shares a face with it
  addBox(b, {5, 0, 0}, {1, 1, 1});
  const ConnectedParts connected = connect({&a, &b});
  ASSERT_EQ(connected.boxes.size(), 2u);
  EXPECT_EQ(connected.numbers[0].front(), connected.numbers[1].front());
  EXPECT_EQ(connected.numbers[1].back(), 1u);
  EXPECT_EQ(connected.boxes[0].high.x, 1.5);
  EXPECT_EQ(connected.boxes[1].low.x, 4.5);
}

TEST(Things, PatternsTakeLongNames) {
  const std::vector<AssetPart> parts{named(std::string(400'000, 'a'), 1)};
  EXPECT_EQ(messageOf([&] { firsts("'/(a|b)+/'", parts); }), "accepted");
}

TEST(Things, MistakesAreNamed) {
  EXPECT_THAT(messageOf([] { bounds("nodes"); }),
              AllOf(HasSubstr("s.yaml:1"), HasSubstr("nodes"), HasSubstr("'node'")));
  EXPECT_THAT(messageOf([] { bounds("'/chair_[/'"); }), AllOf(HasSubstr("s.yaml:1"), HasSubstr("RE2")));
}

}  // namespace
}  // namespace scanmill
