#include "viewer/panels/panel_rects.h"

namespace scanmill {

namespace {

// Returns the number of columns of a grid that divides `body` into `cells` rectangles, which should be 1.4 times as
// wide as high: 1 or `cells` columns, or, for 4 cells in a `body` of suitable shape, 2.
int columnsFor(const PixelRect& body, int cells) {
  constexpr double kPleasing = 1.4;  // width of a view divided by its height; chosen by eye
  const double shape = body.width / (kPleasing * body.height);
  if (cells == 4 && shape > 0.5 && shape < 2) return 2;
  return shape > 1 ? cells : 1;
}

// Removes the lowest `height` pixels of a rectangle and returns them.
PixelRect cutBottom(PixelRect& rect, int height) {
  rect.height -= height;
  return {rect.left, rect.top + rect.height, rect.width, height};
}

}  // namespace

double pictureLineHeight(int width, int height) {
  constexpr double kLines = 56;  // lines of text that fill the largest 16 : 9 rectangle in the picture; chosen by eye
  return std::clamp(std::round(std::min(width / 16.0 * 9, static_cast<double>(height)) / kLines), 10.0, 90.0);
}

double windowLineHeight(double displayScale) {
  constexpr double kUsual = 15;  // line height on a display with the scale 1 (pixels)
  return std::clamp(std::round(kUsual * displayScale), 10.0, 60.0);
}

int sideWidth(double lineHeight) {
  constexpr double kLineHeights = 17;  // width of a panel for long names and counts of points (in line heights)
  return static_cast<int>(std::lround(kLineHeights * lineHeight));
}

PanelRects panelRects(int width, int height, const PanelNeeds& needs) {
  constexpr double kLeastLetters = 30;  // canvases narrower than this (in line heights) get no side panel
  PanelRects rects;
  PixelRect body{0, 0, std::max(width, 1), std::max(height, 1)};
  const int row = std::min(static_cast<int>(std::lround(needs.row)), body.height / 4);
  if (needs.title && row > 0) {
    rects.title = {0, 0, body.width, row};
    body.top = row;
    body.height -= row;
  }
  if (needs.bar && row > 0) {
    rects.bar = cutBottom(body, std::min(static_cast<int>(std::lround(needs.row * 1.5)), body.height / 3));
  }
  if (needs.stripHeight > 0) {
    int caption = static_cast<int>(std::lround(needs.lineHeight * 1.5));
    const int image = std::clamp(needs.stripHeight, 1, std::max(body.height / 2, 1));
    if (caption + image > body.height * 2 / 3) caption = 0;
    rects.strip = cutBottom(body, std::min(caption + image, body.height - 1));
  }
  if (needs.side && width >= needs.lineHeight * kLeastLetters) {
    body.width -= sideWidth(needs.lineHeight);
    rects.side = {body.width, body.top, sideWidth(needs.lineHeight), body.height};
  }
  rects.body = body;
  return rects;
}

int stripHeight(int imageHeight, int width, int height) {
  constexpr double kFlattest = 1.0 / 7;  // preferred height divided by width; flatter images are hard to read
  constexpr double kMostShare = 0.2;     // maximum height as a fraction of the canvas's height
  const int preferred = std::max(static_cast<int>(std::min(width * kFlattest, height * kMostShare)), 1);
  return imageHeight <= 0 || imageHeight > preferred ? preferred : preferred / imageHeight * imageHeight;
}

std::vector<PixelRect> gridRects(const PixelRect& body, std::size_t cells) {
  constexpr int kLeastWithGaps = 16;  // least side of a cell that has gaps (pixels)
  const int count = static_cast<int>(cells);
  const int columns = columnsFor(body, count);
  const int rows = count / columns;
  const int gap = body.width < kLeastWithGaps * columns || body.height < kLeastWithGaps * rows ? 0 : 1;
  const auto xAt = [&](int column) { return (body.width + gap) * column / columns; };  // left edge, relative to `body`
  const auto yAt = [&](int row) { return (body.height + gap) * row / rows; };
  std::vector<PixelRect> rects;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      rects.push_back({.left = body.left + xAt(column),
                       .top = body.top + yAt(row),
                       .width = std::max(xAt(column + 1) - xAt(column) - gap, 1),
                       .height = std::max(yAt(row + 1) - yAt(row) - gap, 1)});
    }
  }
  return rects;
}

}  // namespace scanmill
