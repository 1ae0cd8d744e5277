#include "town/layout.h"

namespace scanmill::town {
namespace {

const Polygon kPlot{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
const Polygon kPond{{4, 4}, {4, 6}, {6, 6}, {6, 4}};

TEST(Areas, TheSmallestAreaIsTold) {
  Areas areas;
  areas.add({Land::Grass, {{-100, -100}, {100, -100}, {100, 100}, {-100, 100}}, {}});
  areas.add({Land::Water, kPlot, {kPond}});
  EXPECT_EQ(areas.landAt({50, 50}), Land::Grass);
  EXPECT_EQ(areas.landAt({2, 2}), Land::Water);
  EXPECT_EQ(areas.landAt({5, 5}), Land::Grass) << "an island";
  EXPECT_EQ(areas.landAt({500, 0}), std::nullopt);
  EXPECT_NEAR(areas.outsideHard({2, 5}), -2, 1e-12);
  EXPECT_NEAR(areas.outsideHard({13, 5}), 3, 1e-12);
  EXPECT_NEAR(areas.outsideHard({5, 5}), 1, 1e-12);
  EXPECT_EQ(areas.outsideHard({60, 60}), Areas::kReach);
}

}  // namespace
}  // namespace scanmill::town
