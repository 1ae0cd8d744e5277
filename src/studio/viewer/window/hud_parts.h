#pragma once

// The rooms of the layer over the picture, and where each of its parts stands.

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "viewer/font.h"
#include "viewer/window/hud.h"
#include "viewer/window/hud_paint.h"

namespace scanmill {

// In cells of the text.
constexpr double kHudMargin = 6;  // between a panel's edge and what it holds, and between panels
constexpr double kHudRow = 13;    // from line to line

// Rectangles that are not there are empty.
struct HudFrame {
  double cell = 1;
  PixelRect title;
  PixelRect body;  // between the title and what stands at the bottom: panes, or the picture
  std::vector<PixelRect> panes;
  int paneGap = 0;  // px between panes
  PixelRect pictureCaption;
  PixelRect picture;
  PixelRect stripBand;  // with its caption
  PixelRect strip;
  PixelRect bar;
  PixelRect play;
  PixelRect slider;
  PixelRect barText;  // what of the bar is left for words
};

HudFrame frameOf(const HudState& state);

// Pixel of the canvas where the slider's knob stands.
double knobAt(const PixelRect& slider, std::size_t frames, std::size_t frame);
double knobRadius(const PixelRect& slider);

inline bool isEmpty(const PixelRect& rect) {
  return rect.width <= 0 || rect.height <= 0;
}

// Height of so many lines; the last one needs no room below its letters.
inline double linesHeight(std::size_t lines, double cell) {
  return lines == 0 ? 0 : (static_cast<double>(lines - 1) * kHudRow + kCapCells) * cell;
}

// Lines that fit into a height.
inline std::size_t fittingLines(double height, double cell) {
  return static_cast<std::size_t>(std::max((height - kCapCells * cell) / (kHudRow * cell) + 1, 0.0));
}

// Each paints its part and adds the regions that the part has. Tips, labels and notices have none: they let the pointer
// through.
using HudRegions = std::vector<HudRegion>;
void drawHudLabels(HudPaint& paint, const HudState& state, const HudFrame& frame);
void drawHudPicture(HudPaint& paint, const HudStrip& picture, const HudFrame& frame, HudRegions& regions);
// Why a pane shows nothing.
void drawHudPaneMessages(HudPaint& paint, const HudState& state, const HudFrame& frame);
void drawHudPanes(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions);
void drawHudLegend(HudPaint& paint, const HudPane& pane, std::size_t number, const HudFrame& frame,
                   HudRegions& regions);
void drawHudStrip(HudPaint& paint, const HudStrip& strip, const HudFrame& frame, HudRegions& regions);
// A ring about what is pointed at in an image that stands at `rect`.
void drawHudMark(HudPaint& paint, const HudStrip& strip, const PixelRect& rect, double cell);
void drawHudTitle(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions);
void drawHudBar(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions);
void drawHudMessages(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions);
void drawHudPrompt(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions);
void drawHudHelp(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions);
// Near the pointer, where it covers no panel.
void drawHudTip(HudPaint& paint, const HudTip& tip, const HudFrame& frame, const HudRegions& regions);
// In a corner of a pane. Returns where.
PixelRect drawHudDocked(HudPaint& paint, const HudTip& tip, const HudFrame& frame, HudRegions& regions);

}  // namespace scanmill
