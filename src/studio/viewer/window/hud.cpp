#include "viewer/window/hud.h"

#include <algorithm>
#include <cmath>

#include "viewer/font.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {

namespace {

// Messages stand in the lower left corner: right of what is docked there, or above it where that leaves no room.
void keepOff(PixelRect& body, const PixelRect& docked) {
  const int bottom = body.top + body.height;
  const bool corner = docked.left < body.left + body.width / 4 && docked.top + docked.height > bottom - body.height / 4;
  if (isEmpty(docked) || !corner) return;
  const int right = docked.left + docked.width;
  if (body.left + body.width - right > body.width / 3) {
    body.width -= right - body.left;
    body.left = right;
  } else if (docked.top - body.top > body.height / 3) {
    body.height = docked.top - body.top;
  }
}

}  // namespace

void drawHudLabels(HudPaint& paint, const HudState& state, const HudFrame& frame) {
  const double cell = frame.cell;
  const double away = 5 * cell;
  for (const HudLabel& label : state.labels) {
    if (!(label.x >= 0) || !(label.y >= 0) || label.x > paint.width() || label.y > paint.height()) continue;
    if (label.mark) {
      paint.ring(label.x, label.y, 4 * cell, 2.4 * cell, {0, 0, 0});
      paint.ring(label.x, label.y, 4 * cell, 1.2 * cell, label.color);
    }
    if (label.text.empty()) continue;
    const std::string text = fittedText(label.text, paint.width() - 2 * away, cell);
    const double width = textWidth(text, cell);
    const double height = kCapCells * cell;
    // On the other side of the mark where it would leave the canvas.
    double x = label.x + 2 * away;
    if (x + width + away > paint.width()) x = std::max(label.x - 2 * away - width, away);
    double y = label.y - away - height;
    if (y < frame.body.top + away) y = label.y + 2 * away;
    const int inset = toPixels(3, cell);
    paint.fill({static_cast<int>(x) - inset, static_cast<int>(y) - inset, static_cast<int>(width) + 2 * inset,
                static_cast<int>(height) + 2 * inset},
               withAlpha(kBackground, kPanelAlpha));
    paint.text(x, y, text, label.color, cell);
  }
}

void drawHudPanes(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions) {
  const double cell = frame.cell;
  const bool several = state.panes.size() > 1;
  for (const PixelRect& pane : frame.panes) {  // what no view covers would be black
    const int gap = frame.paneGap;
    const int right = pane.left + pane.width;
    const int bottom = pane.top + pane.height;
    if (right < frame.body.left + frame.body.width) {
      paint.fill({right, pane.top, gap, pane.height + gap}, opaque(kEdge));
    }
    if (bottom < frame.body.top + frame.body.height) paint.fill({pane.left, bottom, pane.width, gap}, opaque(kEdge));
  }
  for (std::size_t i = 0; i < state.panes.size(); ++i) {
    drawHudLegend(paint, state.panes[i], i, frame, regions);
    const PixelRect& rect = frame.panes[i];
    if (!several) continue;
    const HudPane& shown = state.panes[i];
    if (shown.active) paint.frame(rect, opaque(kAccent), std::max(toPixels(1.5, cell), 2));
    if (shown.caption.empty()) continue;
    const int margin = toPixels(kHudMargin, cell);
    const int inset = toPixels(4, cell);
    const bool alone = !shown.legend.scale && shown.legend.entries.empty();
    const double room = rect.width * (alone ? 1.0 : 0.5) - (alone ? 2 : 1) * margin - 2 * inset;
    const std::string text = fittedText(shown.caption, room, cell);
    const int height = toPixels(kCapCells, cell) + 2 * inset;
    if (text.empty() || height + margin > rect.height) continue;
    paint.fill({rect.left + margin, rect.top + margin, static_cast<int>(textWidth(text, cell)) + 2 * inset, height},
               shown.active ? opaque(kAccent) : withAlpha(kPanel, kPanelAlpha));
    paint.text(rect.left + margin + inset, rect.top + margin + inset, text, shown.active ? kBackground : kText, cell);
  }
}

void drawHudPaneMessages(HudPaint& paint, const HudState& state, const HudFrame& frame) {
  constexpr double kLarge = 1.8;
  constexpr double kWidest = 260;  // of the larger cells
  constexpr std::size_t kMostLines = 8;
  const double cell = frame.cell * kLarge;
  for (std::size_t i = 0; i < state.panes.size(); ++i) {
    const PixelRect& rect = frame.panes[i];
    const double margin = kHudMargin * cell;
    const double room = std::min(rect.width - 4 * margin, kWidest * cell);
    const double fitting = std::floor((rect.height - 4 * margin) / (kHudRow * cell));
    if (state.panes[i].message.empty() || room < margin || fitting < 1) continue;
    const std::size_t most = std::min(kMostLines, static_cast<std::size_t>(fitting));
    const std::vector<std::string> lines = wrappedText(state.panes[i].message, room, cell, most);
    double widest = 0;
    for (const std::string& line : lines) widest = std::max(widest, textWidth(line, cell));
    const double height = (static_cast<double>(lines.size()) * kHudRow - (kHudRow - kCapCells)) * cell;
    const double top = rect.top + (rect.height - height) / 2;
    paint.fill({static_cast<int>(rect.left + (rect.width - widest) / 2 - margin), static_cast<int>(top - margin),
                static_cast<int>(widest + 2 * margin), static_cast<int>(height + 2 * margin)},
               withAlpha(kBackground, kPanelAlpha));
    for (std::size_t k = 0; k < lines.size(); ++k) {
      paint.text(rect.left + (rect.width - textWidth(lines[k], cell)) / 2,
                 top + static_cast<double>(k) * kHudRow * cell, lines[k], kText, cell);
    }
  }
}

Hud drawHud(const HudState& state) {
  const HudFrame frame = frameOf(state);
  HudPaint paint(std::max(state.width, 1), std::max(state.height, 1));
  Hud hud;
  drawHudLabels(paint, state, frame);
  if (state.picture) {
    drawHudPicture(paint, *state.picture, frame, hud.regions);
  } else {
    drawHudPaneMessages(paint, state, frame);
  }
  if (!state.bare) drawHudPanes(paint, state, frame, hud.regions);
  if (!state.bare) {
    if (state.strip) drawHudStrip(paint, *state.strip, frame, hud.regions);
    drawHudTitle(paint, state, frame, hud.regions);
    drawHudBar(paint, state, frame, hud.regions);
    if (state.picture) drawHudMark(paint, *state.picture, frame.picture, frame.cell);
    if (state.strip) drawHudMark(paint, *state.strip, frame.strip, frame.cell);
    HudFrame free = frame;
    if (state.docked) keepOff(free.body, drawHudDocked(paint, *state.docked, frame, hud.regions));
    drawHudMessages(paint, state, free, hud.regions);
    if (state.prompt) drawHudPrompt(paint, state, frame, hud.regions);
    if (state.help) drawHudHelp(paint, state, frame, hud.regions);
    if (state.tip) drawHudTip(paint, *state.tip, frame, hud.regions);
  }
  hud.pixels = paint.take();
  return hud;
}

const HudRegion* regionAt(const Hud& hud, int x, int y) {
  const auto found = std::find_if(hud.regions.rbegin(), hud.regions.rend(),
                                  [&](const HudRegion& region) { return region.rect.contains(x, y); });
  return found == hud.regions.rend() ? nullptr : &*found;
}

}  // namespace scanmill
