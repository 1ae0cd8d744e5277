#include "viewer/panels/panel_rects.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace scanmill {

namespace {

// Returns the number of columns of a grid of equal parts that come near to being 1.4 times as wide as high.
int columnsFor(const PixelRect& body, int parts) {
  constexpr double kPleasing = 1.4;
  const double shape = body.width / (kPleasing * body.height);
  if (parts == 4 && shape > 0.5 && shape < 2) return 2;
  return shape > 1 ? parts : 1;
}

std::pair<int, int> part(int from, int length, int parts, int index, int gap) {
  const auto edge = [&](int i) { return static_cast<int>(static_cast<std::int64_t>(length + gap) * i / parts); };
  return {from + edge(index), std::max(edge(index + 1) - edge(index) - gap, 1)};
}

}  // namespace

double pictureLineHeight(int width, int height) {
  return std::clamp(std::round(std::min(width / 16.0 * 9, static_cast<double>(height)) / 56), 10.0, 90.0);
}

double lineHeightOf(const Canvas& canvas, bool still) {
  constexpr double kLetter = 15;
  return still ? pictureLineHeight(canvas.width(), canvas.height())
               : std::clamp(std::round(kLetter * canvas.scale()), 10.0, 60.0);
}

int sideWidth(double lineHeight) {
  return static_cast<int>(std::lround(17 * lineHeight));
}

PanelRects panelRects(int width, int height, const PanelNeeds& needs) {
  constexpr double kLeastLetters = 30;  // canvases with a width of fewer line heights get no side panel
  PanelRects rects;
  PixelRect body{0, 0, std::max(width, 1), std::max(height, 1)};
  const int row = std::min(static_cast<int>(std::lround(needs.row)), body.height / 4);
  if (needs.title && row > 0) {
    rects.title = {0, 0, body.width, row};
    body.top = row;
    body.height -= row;
  }
  if (needs.bar && row > 0) {
    const int high = std::min(static_cast<int>(std::lround(needs.row * 1.5)), body.height / 3);
    rects.bar = {0, body.top + body.height - high, body.width, high};
    body.height -= high;
  }
  if (needs.stripHeight > 0) {
    int caption = static_cast<int>(std::lround(needs.lineHeight * 1.5));
    const int image = std::clamp(needs.stripHeight, 1, std::max(body.height / 2, 1));
    if (caption + image > body.height * 2 / 3) caption = 0;
    const int high = std::min(caption + image, body.height - 1);
    rects.strip = {0, body.top + body.height - high, body.width, high};
    body.height -= high;
  }
  if (needs.side && width >= needs.lineHeight * kLeastLetters) {
    const int wide = sideWidth(needs.lineHeight);
    rects.side = {width - wide, body.top, wide, body.height};
    body.width -= wide;
  }
  rects.body = body;
  return rects;
}

int stripHeight(int imageHeight, int width, int height) {
  constexpr double kFlattest = 1.0 / 7;  // preferred height divided by width; flatter images are hard to read
  constexpr double kMostShare = 0.2;     // maximum height as a fraction of the canvas's height
  const int wanted = std::max(static_cast<int>(std::min(width * kFlattest, height * kMostShare)), 1);
  return imageHeight <= 0 || imageHeight > wanted ? wanted : wanted / imageHeight * imageHeight;
}

std::vector<PixelRect> gridRects(const PixelRect& body, std::size_t count, int gap) {
  const int parts = static_cast<int>(count);
  const int columns = columnsFor(body, parts);
  const int rows = parts / columns;
  if (body.width < 16 * columns || body.height < 16 * rows) gap = 0;
  std::vector<PixelRect> rects;
  for (int i = 0; i < parts; ++i) {
    const auto [left, width] = part(body.left, body.width, columns, i % columns, gap);
    const auto [top, height] = part(body.top, body.height, rows, i / columns, gap);
    rects.push_back({left, top, width, height});
  }
  return rects;
}

}  // namespace scanmill
