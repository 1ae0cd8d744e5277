#include <algorithm>
#include <cmath>

#include "viewer/legend.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {

namespace {

constexpr double kBarHeight = 20;       // cells, with a slider
constexpr double kPlainBarHeight = 15;  // cells, without one
constexpr double kCaptionHeight = 13;   // cells
constexpr double kSliderShare = 0.42;   // of the canvas's width
constexpr double kNarrow = 230;         // cells: below it the slider takes the whole bar
constexpr double kFlattest = 1.0 / 7;   // height over width of an image that is to be read

// Height over width as it is shown: what is flatter than one can read is stretched upright, as range images are.
double shownRatio(const Image& image) {
  return std::max(static_cast<double>(image.height) / std::max(image.width, 1), kFlattest);
}

// Panes are of one size, and none stays empty: of the numbers of columns for which that is so, the one whose panes are
// nearest to a pleasing shape.
int paneColumns(const PixelRect& body, int panes) {
  constexpr double kPleasing = 1.4;  // width over height
  int best = 1;
  double bestStray = 1e9;
  for (int columns = 1; columns <= panes; ++columns) {
    if (panes % columns != 0) continue;
    const int rows = panes / columns;
    const double shape = (static_cast<double>(body.width) / columns) / (static_cast<double>(body.height) / rows);
    const double stray = std::abs(std::log(shape / kPleasing));
    if (stray < bestStray - 1e-9) {
      bestStray = stray;
      best = columns;
    }
  }
  return best;
}

// Parts of a length, with gaps between them; at least one pixel each.
std::pair<int, int> part(int from, int length, int parts, int index, int gap) {
  const auto edge = [&](int i) { return static_cast<int>(static_cast<std::int64_t>(length + gap) * i / parts); };
  return {from + edge(index), std::max(edge(index + 1) - edge(index) - gap, 1)};
}

void placePanes(int panes, HudFrame& frame) {
  if (panes == 0) return;
  const PixelRect& body = frame.body;
  const int columns = paneColumns(body, panes);
  const int rows = panes / columns;
  const bool roomy = body.width >= 16 * columns && body.height >= 16 * rows;
  const int gap = frame.paneGap = roomy ? std::max(toPixels(1, frame.cell), 1) : 0;
  for (int i = 0; i < panes; ++i) {
    const auto [left, width] = part(body.left, body.width, columns, i % columns, gap);
    const auto [top, height] = part(body.top, body.height, rows, i / columns, gap);
    frame.panes.push_back({left, top, width, height});
  }
}

// As large as fits; enlarged in whole steps where that loses little.
PixelRect fitted(const Image& image, const PixelRect& room) {
  if (image.pixels.empty() || isEmpty(room)) return {};
  const double ratio = shownRatio(image);
  constexpr double kWorthwhile = 0.75;
  double width = std::min<double>(room.width, room.height / ratio);
  const double whole = std::floor(width / image.width) * image.width;
  if (whole >= kWorthwhile * width) width = whole;
  const int shownWidth = std::clamp(static_cast<int>(width), 1, room.width);
  const int shownHeight = std::clamp(static_cast<int>(std::lround(width * ratio)), 1, room.height);
  return {room.left + (room.width - shownWidth) / 2, room.top + (room.height - shownHeight) / 2, shownWidth,
          shownHeight};
}

// The image's rows in whole steps where there is room for that.
int stripHeight(const Image& image, int width, int height) {
  constexpr double kMostShare = 0.2;  // of the canvas's height
  const int wanted = std::max(static_cast<int>(std::min(width * kFlattest, height * kMostShare)), 1);
  if (image.height <= 0 || image.height > wanted) return wanted;
  return wanted / image.height * image.height;
}

void placeBar(const HudState& state, HudFrame& frame) {
  const int margin = toPixels(kHudMargin, frame.cell);
  const PixelRect& bar = frame.bar;
  int left = margin;
  if (state.frame) {
    const int inset = toPixels(3, frame.cell);
    const int size = bar.height - 2 * inset;
    frame.play = {left, bar.top + inset, size, size};
    left += size + margin / 2;
    const bool narrow = bar.width < kNarrow * frame.cell;
    const int width = narrow ? bar.width - margin - left : static_cast<int>(bar.width * kSliderShare);
    frame.slider = {left, bar.top + inset, std::max(width, 1), size};
    left += frame.slider.width + margin;
    if (narrow) return;
  }
  frame.barText = {left, bar.top, std::max(bar.width - margin - left, 0), bar.height};
}

}  // namespace

HudFrame frameOf(const HudState& state) {
  HudFrame frame;
  const int width = std::max(state.width, 1);
  const int height = std::max(state.height, 1);
  const PictureLayout look = layoutPicture(width, height, {});
  frame.cell = look.cell;
  frame.body = {0, 0, width, height};
  if (!state.bare) {
    frame.title = {0, 0, width, std::min(look.top, height / 3)};
    const double barCells = state.still ? 0 : state.frame ? kBarHeight : kPlainBarHeight;
    const int barHeight = std::min(toPixels(barCells, frame.cell), height / 3);
    frame.bar = {0, height - barHeight, width, barHeight};
    if (!state.still) placeBar(state, frame);
    frame.body.top = frame.title.height;
    frame.body.height = height - frame.title.height - barHeight;
    if (state.strip && !state.strip->image.pixels.empty()) {
      const int image = std::min(stripHeight(state.strip->image, width, height), frame.body.height / 2);
      const int gap = std::max(toPixels(2, frame.cell), 1);
      int caption = toPixels(kCaptionHeight, frame.cell);  // even of no words: they may come later
      if (caption + gap + image > frame.body.height * 2 / 3) caption = 0;
      const int band = std::min(caption + image + (caption > 0 ? gap : 0), frame.body.height - 1);
      frame.stripBand = {0, frame.bar.top - band, width, band};
      frame.strip = {0, frame.stripBand.top + caption, width, std::min(image, band - caption)};
      frame.body.height -= band;
    }
  }
  placePanes(static_cast<int>(state.panes.size()), frame);
  if (state.picture) {
    PixelRect room = frame.body;
    if (!state.bare) {
      const int caption = toPixels(kCaptionHeight, frame.cell);
      if (2 * caption < room.height) {
        frame.pictureCaption = {room.left, room.top, room.width, caption};
        room.top += caption;
        room.height -= caption;
      }
    }
    frame.picture = fitted(state.picture->image, room);
  }
  return frame;
}

double knobRadius(const PixelRect& slider) {
  return std::min(slider.height * 0.36, slider.width * 0.5);
}

double knobAt(const PixelRect& slider, std::size_t frames, std::size_t frame) {
  const double inset = knobRadius(slider);
  const double share =
      frames < 2 ? 0.0 : static_cast<double>(std::min(frame, frames - 1)) / static_cast<double>(frames - 1);
  return slider.left + inset + share * (slider.width - 2 * inset);
}

std::size_t sliderFrame(const PixelRect& slider, std::size_t frames, int x) {
  const double inset = knobRadius(slider);
  const double room = slider.width - 2 * inset;
  if (frames < 2 || !(room > 0)) return 0;
  const double share = std::clamp((x + 0.5 - slider.left - inset) / room, 0.0, 1.0);
  return static_cast<std::size_t>(std::lround(share * static_cast<double>(frames - 1)));
}

HudLayout layoutHud(const HudState& state) {
  HudFrame frame = frameOf(state);
  return {frame.cell, std::move(frame.panes), frame.strip, frame.picture};
}

std::optional<std::pair<int, int>> imagePixelAt(const PixelRect& rect, const Image& image, int x, int y) {
  if (!rect.contains(x, y) || image.pixels.empty()) return {};
  return std::pair(nearestPixel(x - rect.left, image.width, rect.width),
                   nearestPixel(y - rect.top, image.height, rect.height));
}

}  // namespace scanmill
