#include "viewer/panels/rooms.h"

namespace scanmill {
namespace {

bool overlap(const PixelRect& a, const PixelRect& b) {
  return a.width > 0 && b.width > 0 && a.height > 0 && b.height > 0 && a.left < b.left + b.width &&
         b.left < a.left + a.width && a.top < b.top + b.height && b.top < a.top + a.height;
}

long areaOf(const PixelRect& rect) {
  return static_cast<long>(std::max(rect.width, 0)) * std::max(rect.height, 0);
}

// Together they fill the canvas, none lies over another, and something is left for the views, at every size.
TEST(PanelRooms, FillTheCanvasAndLeaveABody) {
  for (int width = 1; width < 2000; width += 37) {
    for (int height = 1; height < 1200; height += 31) {
      for (int kinds = 0; kinds < 16; ++kinds) {
        const PanelNeeds needs{.title = (kinds & 1) != 0,
                               .side = (kinds & 2) != 0,
                               .bar = (kinds & 4) != 0,
                               .stripHeight = (kinds & 8) != 0 ? stripHeight(64, width, height) : 0};
        const PanelRooms rooms = roomsOf(width, height, needs);
        const PixelRect all[] = {rooms.title, rooms.side, rooms.strip, rooms.bar, rooms.body};
        long area = 0;
        for (const PixelRect& rect : all) {
          area += areaOf(rect);
          for (const PixelRect& other : all) {
            ASSERT_TRUE(&rect == &other || !overlap(rect, other)) << width << " x " << height << ", " << kinds;
          }
        }
        ASSERT_EQ(area, static_cast<long>(width) * height) << width << " x " << height << ", " << kinds;
        ASSERT_GE(rooms.body.width, 1);
        ASSERT_GE(rooms.body.height, 1);
        if (width > 600 && height > 400) {
          EXPECT_EQ(rooms.side.width > 0, needs.side);
          EXPECT_GT(areaOf(rooms.body), area / 4);
        }
      }
    }
  }
}

TEST(PanelRooms, PartsAreAlikeAndFillTheBody) {
  for (const PixelRect& body : {PixelRect{0, 20, 1300, 700}, PixelRect{3, 5, 200, 900}, PixelRect{0, 0, 7, 5}}) {
    for (std::size_t parts = 1; parts <= 8; ++parts) {
      const auto rects = partsOf(body, parts, 1);
      ASSERT_EQ(rects.size(), parts);
      long area = 0;
      for (const PixelRect& rect : rects) {
        ASSERT_GE(rect.width, 1);
        ASSERT_GE(rect.height, 1);
        EXPECT_LE(std::abs(rect.width - rects[0].width), 1);
        EXPECT_LE(std::abs(rect.height - rects[0].height), 1);
        area += areaOf(rect);
        for (const PixelRect& other : rects) {
          EXPECT_TRUE(&rect == &other || body.width < 100 || !overlap(rect, other));
        }
      }
      EXPECT_TRUE(body.width < 100 || area > areaOf(body) * 97 / 100);
    }
  }
}

TEST(PanelRooms, StripsHaveTheirRowsInWholeSteps) {
  for (const int rings : {16, 32, 64, 128}) {
    const int height = stripHeight(rings, 1600, 1000);
    EXPECT_LE(height, 200);
    EXPECT_EQ(height % rings, 0) << rings;
  }
  EXPECT_EQ(stripHeight(4000, 700, 1000), 100) << "more rows than pixels";
}

}  // namespace
}  // namespace scanmill
