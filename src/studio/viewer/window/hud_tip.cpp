// What is pointed at, and what was clicked, in rows of name and value.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "viewer/font.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {

namespace {

constexpr double kSwatch = 8;         // cells
constexpr double kHeadingLeft = 12;   // cells
constexpr double kWidestValue = 190;  // cells

// Where the parts of a tip stand in its box; px.
struct TipShape {
  std::size_t lines = 0;  // with the heading; 0: there is no room
  double names = 0;
  double valueLeft = 0;
  double width = 0;  // within the box
  int boxWidth = 0;
  int boxHeight = 0;
};

TipShape shapeOf(const HudTip& tip, int width, int height, double cell) {
  const int inset = toPixels(kHudMargin, cell);
  const double roomWidth = width - 2.0 * inset;
  const double roomHeight = height - 2.0 * inset;
  TipShape shape;
  if (roomWidth < kSwatch * cell) return shape;
  shape.lines = std::min(tip.rows.size() + 1, fittingLines(roomHeight, cell));
  double values = 0;
  for (const auto& [name, value] : tip.rows) {
    shape.names = std::max(shape.names, textWidth(name, cell));
    values = std::max(values, textWidth(value, cell));
  }
  shape.names = std::min(shape.names, roomWidth * 0.4);
  shape.valueLeft = tip.rows.empty() ? 0 : shape.names + 8 * cell;
  const double heading = kHeadingLeft * cell + std::min(textWidth(tip.heading, cell), kWidestValue * cell);
  shape.width = std::min(std::max(heading, shape.valueLeft + std::min(values, kWidestValue * cell)), roomWidth);
  shape.boxWidth = std::min(static_cast<int>(std::ceil(shape.width)) + 2 * inset, width);
  shape.boxHeight = std::min(static_cast<int>(std::ceil(linesHeight(shape.lines, cell))) + 2 * inset, height);
  return shape;
}

void paintTip(HudPaint& paint, const HudTip& tip, const TipShape& shape, const PixelRect& box, double cell) {
  paint.panel(box, kEdge, cell);
  const int inset = toPixels(kHudMargin, cell);
  const double left = box.left + inset;
  const double top = box.top + inset;
  const int size = toPixels(kSwatch, cell);
  paint.fill({static_cast<int>(left), static_cast<int>(std::lround(top - 0.5 * cell)), size, size}, opaque(tip.color));
  const double headingLeft = kHeadingLeft * cell;
  paint.text(left + headingLeft, top, fittedText(tip.heading, shape.width - headingLeft, cell), kText, cell);
  for (std::size_t i = 1; i < shape.lines; ++i) {
    const double y = top + static_cast<double>(i) * kHudRow * cell;
    if (i + 1 == shape.lines && shape.lines < tip.rows.size() + 1) {
      const std::string more = fmt::format("+ {} more", tip.rows.size() + 1 - i);
      paint.text(left, y, fittedText(more, shape.width, cell), kDimText, cell);
      break;
    }
    const auto& [name, value] = tip.rows[i - 1];
    const bool warns = !tip.alarm.empty() && name == tip.alarm;
    paint.text(left, y, fittedText(name, shape.names, cell), warns ? kAlarm : kDimText, cell);
    paint.text(left + shape.valueLeft, y, fittedText(value, shape.width - shape.valueLeft, cell),
               warns ? kAlarm : kText, cell);
  }
}

int overlap(const PixelRect& a, const PixelRect& b) {
  const int width = std::min(a.left + a.width, b.left + b.width) - std::max(a.left, b.left);
  const int height = std::min(a.top + a.height, b.top + b.height) - std::max(a.top, b.top);
  return std::max(width, 0) * std::max(height, 0);
}

// Pixels of panels below it.
int covered(const PixelRect& box, const HudRegions& regions) {
  int pixels = 0;
  for (const HudRegion& region : regions) {
    if (region.part == HudPart::Panel) pixels += overlap(box, region.rect);
  }
  return pixels;
}

}  // namespace

void drawHudTip(HudPaint& paint, const HudTip& tip, const HudFrame& frame, const HudRegions& regions) {
  constexpr double kAway = 15;  // cells, from the pointer: what it points at stays free
  const double cell = frame.cell;
  const TipShape shape = shapeOf(tip, paint.width(), paint.height(), cell);
  if (shape.lines == 0) return;
  const int away = toPixels(kAway, cell);
  const int x = std::clamp(tip.x, 0, paint.width());
  const int y = std::clamp(tip.y, 0, paint.height());
  const auto within = [](int at, int size, int whole) { return std::clamp(at, 0, whole - size); };
  const std::array columns{x + away, x - away - shape.boxWidth};
  const std::array rows{y + away, y - away - shape.boxHeight};
  // To the right and below; on another side of the pointer where that is outside, or over a panel.
  PixelRect best;
  std::int64_t least = -1;
  for (const int top : rows) {
    for (const int left : columns) {
      const PixelRect box{within(left, shape.boxWidth, paint.width()), within(top, shape.boxHeight, paint.height()),
                          shape.boxWidth, shape.boxHeight};
      const std::int64_t moved = std::abs(box.left - left) + std::abs(box.top - top);
      const std::int64_t cost = (box.contains(x, y) ? std::int64_t{1} << 40 : 0) + moved * 1000 + covered(box, regions);
      if (least >= 0 && cost >= least) continue;
      least = cost;
      best = box;
    }
  }
  paintTip(paint, tip, shape, best, cell);
}

PixelRect drawHudDocked(HudPaint& paint, const HudTip& tip, const HudFrame& frame, HudRegions& regions) {
  const double cell = frame.cell;
  const int margin = toPixels(kHudMargin, cell);
  const int caption = frame.panes.size() > 1 ? toPixels(kCapCells + 8 + kHudMargin, cell) : 0;
  PixelRect best;
  TipShape bestShape;
  std::int64_t least = -1;
  for (std::size_t p = 0; p < frame.panes.size(); ++p) {
    const PixelRect& pane = frame.panes[p];
    const TipShape shape = shapeOf(tip, pane.width - 2 * margin, pane.height - 2 * margin, cell);
    if (shape.lines == 0) continue;
    const int right = pane.left + pane.width - margin - shape.boxWidth;
    const int bottom = pane.top + pane.height - margin - shape.boxHeight;
    const int top = std::min(pane.top + margin + caption, bottom);
    const std::array<std::pair<int, int>, 4> corners{
        {{pane.left + margin, bottom}, {right, bottom}, {pane.left + margin, top}, {right, top}}};
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const PixelRect box{corners[c].first, corners[c].second, shape.boxWidth, shape.boxHeight};
      const PixelRect about{box.left - margin, box.top - margin, box.width + 2 * margin, box.height + 2 * margin};
      const auto over = std::count_if(tip.keepClear.begin(), tip.keepClear.end(),
                                      [&](const auto& place) { return about.contains(place.first, place.second); });
      // First of all it covers no place, then no panel, then it has room for its rows, then it stands in its own pane.
      const std::int64_t cost = (std::int64_t{over} << 50) + (std::int64_t{covered(box, regions)} << 16) +
                                static_cast<std::int64_t>((tip.rows.size() + 1 - shape.lines) << 8) +
                                (p == tip.pane ? 0 : 16 + static_cast<std::int64_t>(4 * p)) +
                                static_cast<std::int64_t>(c);
      if (least >= 0 && cost >= least) continue;
      least = cost;
      best = box;
      bestShape = shape;
    }
  }
  if (least < 0) return {};
  paint.fill(best, opaque(kPanel));
  paintTip(paint, tip, bestShape, best, cell);
  regions.push_back({HudPart::Panel, best, tip.pane, 0});
  return best;
}

}  // namespace scanmill
