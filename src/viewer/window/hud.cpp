#include "viewer/window/hud.h"

#include <algorithm>
#include <cmath>

#include "viewer/font.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {

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
    if (!several || state.panes[i].caption.empty()) continue;
    const int margin = toPixels(kHudMargin, cell);
    const int inset = toPixels(4, cell);
    const std::string text = fittedText(state.panes[i].caption, rect.width * 0.5 - margin - 2 * inset, cell);
    const int height = toPixels(kCapCells, cell) + 2 * inset;
    if (text.empty() || height + margin > rect.height) continue;
    paint.fill({rect.left + margin, rect.top + margin, static_cast<int>(textWidth(text, cell)) + 2 * inset, height},
               withAlpha(kPanel, kPanelAlpha));
    paint.text(rect.left + margin + inset, rect.top + margin + inset, text, kText, cell);
  }
}

Hud drawHud(const HudState& state) {
  const HudFrame frame = frameOf(state);
  HudPaint paint(std::max(state.width, 1), std::max(state.height, 1));
  Hud hud;
  drawHudLabels(paint, state, frame);
  if (state.picture) {
    drawHudPicture(paint, *state.picture, frame, hud.regions);
  } else if (!state.bare) {
    drawHudPanes(paint, state, frame, hud.regions);
  }
  if (!state.bare) {
    if (state.strip) drawHudStrip(paint, *state.strip, frame, hud.regions);
    drawHudTitle(paint, state, frame, hud.regions);
    drawHudBar(paint, state, frame, hud.regions);
    if (state.picture) drawHudMark(paint, *state.picture, frame.picture, frame.cell);
    if (state.strip) drawHudMark(paint, *state.strip, frame.strip, frame.cell);
    drawHudMessages(paint, state, frame, hud.regions);
    if (state.prompt) drawHudPrompt(paint, state, frame, hud.regions);
    if (state.help) drawHudHelp(paint, state, frame, hud.regions);
    if (state.tip) drawHudTip(paint, *state.tip, frame);
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
