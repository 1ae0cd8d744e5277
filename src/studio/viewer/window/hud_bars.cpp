#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "viewer/font.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {

namespace {

const char* const kHelpHint = "h for help";

double lettersTop(const PixelRect& rect, double cell) {
  return rect.top + (rect.height - kCapCells * cell) / 2;
}

void drawPlayButton(HudPaint& paint, const HudState& state, const PixelRect& rect) {
  const int inset = std::max(rect.height / 5, 1);
  const PixelRect sign{rect.left + inset, rect.top + inset, rect.width - 2 * inset, rect.height - 2 * inset};
  if (!state.playing) {
    paint.arrow(sign, kText);
    return;
  }
  const int beam = std::max(sign.width / 3, 1);
  paint.fill({sign.left, sign.top, beam, sign.height}, opaque(kText));
  paint.fill({sign.left + sign.width - beam, sign.top, beam, sign.height}, opaque(kText));
}

void drawSlider(HudPaint& paint, const HudState& state, const HudFrame& frame) {
  const PixelRect& slider = frame.slider;
  const double radius = knobRadius(slider);
  const double knob = knobAt(slider, state.frames, *state.frame);
  const int thick = std::max(toPixels(2, frame.cell), 1);
  const int top = slider.top + (slider.height - thick) / 2;
  const int left = slider.left + static_cast<int>(radius);
  const int passed = static_cast<int>(knob) - left;
  const int whole = slider.width - 2 * static_cast<int>(radius);
  paint.fill({left, top, whole, thick}, opaque(kEdge));
  paint.fill({left, top, passed, thick}, opaque(kAccent));
  const int high = std::max(slider.height / 2, 1);
  for (const std::size_t number : state.damaged) {
    if (number >= state.frames) break;
    const int at = static_cast<int>(knobAt(slider, state.frames, number));
    paint.fill({at - thick / 2, slider.top + (slider.height - high) / 2, thick, high}, opaque(kAlarm));
  }
  paint.disc(knob, slider.top + slider.height * 0.5, radius, kAccent);
  paint.disc(knob, slider.top + slider.height * 0.5, radius * 0.4, kPanel);
}

// The mark of an hourglass's shape says that something is going on; it stands still, so nothing is drawn anew for it.
double drawBusy(HudPaint& paint, const std::string& busy, const PixelRect& rect, double right, double room,
                double cell) {
  const double mark = kCapCells * cell;
  const std::string text = fittedText(busy, room - mark - 4 * cell, cell);
  if (text.empty()) return right;
  const double left = right - textWidth(text, cell) - mark - 4 * cell;
  paint.ring(left + mark / 2, lettersTop(rect, cell) + mark / 2, mark * 0.4, mark * 0.18, kAccent);
  paint.disc(left + mark / 2, lettersTop(rect, cell) + mark / 2, mark * 0.14, kAccent);
  paint.text(left + mark + 4 * cell, lettersTop(rect, cell), text, kAccent, cell);
  return left - kHudMargin * cell;
}

void drawBarText(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions) {
  const double cell = frame.cell;
  const PixelRect& rect = frame.barText;
  const double margin = kHudMargin * cell;
  double right = rect.left + rect.width;
  const double hint = textWidth(kHelpHint, cell);
  if (hint + margin < rect.width * 0.5 || (!state.frame && hint <= rect.width)) {
    right -= hint;
    paint.text(right, lettersTop(rect, cell), kHelpHint, kDimText, cell);
    const int left = static_cast<int>(right - margin / 2);
    regions.push_back({HudPart::Help, {left, rect.top, frame.bar.left + frame.bar.width - left, rect.height}, 0, 0});
    right -= 2 * margin;
  }
  if (!state.busy.empty()) {
    right = drawBusy(paint, state.busy, rect, right, (right - rect.left) * (state.frame ? 0.5 : 1.0), cell);
  }
  if (!state.frame) return;
  double left = rect.left;
  if (const double width = textWidth(state.speed, cell); !state.speed.empty() && width < (right - left) / 3) {
    paint.text(left, lettersTop(rect, cell), state.speed, state.playing ? kAccent : kDimText, cell);
    left += width + margin;
  }
  // Places count from 1, indices from 0: the sign tells them apart.
  const std::string text = fmt::format("{} of {}, #{}: {}", *state.frame + 1, state.frames, *state.frame, state.key);
  paint.text(left, lettersTop(rect, cell), fittedText(text, right - left, cell), kText, cell);
}

}  // namespace

void drawHudTitle(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions) {
  paint.fill(frame.title, opaque(kPanel));
  regions.push_back({HudPart::Panel, frame.title, 0, 0});
  const double cell = frame.cell;
  const double margin = kHudMargin * cell;
  const double y = lettersTop(frame.title, cell);
  const std::string left = fittedText(state.title, frame.title.width - 2 * margin, cell);
  paint.text(margin, y, left, kText, cell);
  const double room = frame.title.width - 4 * margin - textWidth(left, cell);
  const std::string right = fittedText(state.summary, room, cell);
  if (right.size() < 5 && right != state.summary) return;  // nothing but dots
  paint.text(frame.title.width - margin - textWidth(right, cell), y, right, kDimText, cell);
}

void drawHudBar(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions) {
  if (isEmpty(frame.bar)) return;
  paint.fill(frame.bar, opaque(kPanel));
  regions.push_back({HudPart::Panel, frame.bar, 0, 0});
  if (state.frame) {
    drawPlayButton(paint, state, frame.play);
    regions.push_back({HudPart::PlayButton, frame.play, 0, 0});
    drawSlider(paint, state, frame);
    regions.push_back({HudPart::Slider, frame.slider, 0, 0});
  }
  drawBarText(paint, state, frame, regions);
}

void drawHudStrip(HudPaint& paint, const HudStrip& strip, const HudFrame& frame, HudRegions& regions) {
  if (isEmpty(frame.strip)) return;
  const double cell = frame.cell;
  paint.fill(frame.stripBand, opaque(kPanel));
  regions.push_back({HudPart::Panel, frame.stripBand, 0, 0});
  const int caption = frame.strip.top - frame.stripBand.top;
  if (caption > kCapCells * cell) {
    const double margin = kHudMargin * cell;
    paint.text(margin, frame.stripBand.top + (caption - kCapCells * cell) / 2,
               fittedText(strip.caption, frame.stripBand.width - 2 * margin, cell), kDimText, cell);
  }
  paint.image(frame.strip, strip.image);
  regions.push_back({HudPart::Strip, frame.strip, 0, 0});
}

void drawHudPicture(HudPaint& paint, const HudStrip& picture, const HudFrame& frame, HudRegions& regions) {
  const double cell = frame.cell;
  paint.fill(frame.body, opaque(kBackground));
  regions.push_back({HudPart::Panel, frame.body, 0, 0});
  if (!isEmpty(frame.pictureCaption)) {
    const double margin = kHudMargin * cell;
    paint.text(margin, lettersTop(frame.pictureCaption, cell),
               fittedText(picture.caption, frame.pictureCaption.width - 2 * margin, cell), kText, cell);
  }
  if (isEmpty(frame.picture)) return;
  paint.image(frame.picture, picture.image);
  regions.push_back({HudPart::Picture, frame.picture, 0, 0});
}

void drawHudMark(HudPaint& paint, const HudStrip& strip, const PixelRect& rect, double cell) {
  const auto& [width, height] = std::pair(strip.image.width, strip.image.height);
  if (!strip.mark || isEmpty(rect) || width <= 0 || height <= 0) return;
  const auto [column, row] = *strip.mark;
  if (column < 0 || row < 0 || column >= width || row >= height) return;
  const double x = rect.left + (column + 0.5) * rect.width / width;
  const double y = rect.top + (row + 0.5) * rect.height / height;
  // White between black, so that it is seen on every colour.
  paint.ring(x, y, 5 * cell, 2.6 * cell, {0, 0, 0});
  paint.ring(x, y, 5 * cell, 1.2 * cell, {255, 255, 255});
}

}  // namespace scanmill
