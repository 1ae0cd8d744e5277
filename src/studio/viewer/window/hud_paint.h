#pragma once

// What the layer over the picture is painted with: pixels with opacity, and boxes, text, round shapes and images.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "viewer/canvas/canvas.h"
#include "viewer/color_map.h"
#include "viewer/image.h"

namespace scanmill {

constexpr Rgb kEdge{66, 72, 86};        // of panels
constexpr Rgb kDimText{152, 157, 168};  // captions, units, what is hidden
constexpr Rgb kAccent{98, 168, 255};    // what can be moved or is going on
constexpr Rgb kAlarm{240, 72, 60};
constexpr std::uint8_t kPanelAlpha = 228;  // the scan shines through, text stays readable

inline Rgba withAlpha(const Rgb& color, std::uint8_t alpha) {
  return {color[0], color[1], color[2], alpha};
}

inline Rgba opaque(const Rgb& color) {
  return withAlpha(color, 255);
}

// Whole pixels of a length in cells of the text.
inline int toPixels(double cells, double cell) {
  return static_cast<int>(std::lround(cells * cell));
}

// Of an image that is stretched over `shown` pixels: its column or row at one of them.
inline int nearestPixel(int at, int pixels, int shown) {
  return static_cast<int>(static_cast<std::int64_t>(at) * pixels / shown);
}

// Whatever juts out is left out.
class HudPaint {
 public:
  // Nothing is there at first: alpha 0.
  HudPaint(int width, int height)
      : width_(width), height_(height), pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  int width() const { return width_; }
  int height() const { return height_; }
  std::vector<Rgba> take() { return std::move(pixels_); }

  void fill(const PixelRect& rect, const Rgba& color);
  // The rectangle's edge, inside of it.
  void frame(const PixelRect& rect, const Rgba& color, int thickness);
  // Translucent, with an edge.
  void panel(const PixelRect& rect, const Rgb& edge, double cell);
  // (x, y) is the upper left corner of a capital.
  void text(double x, double y, std::string_view text, const Rgb& color, double cell);
  // Stretched by nearest pixels; opaque.
  void image(const PixelRect& rect, const Image& image);
  void disc(double x, double y, double radius, const Rgb& color);
  void ring(double x, double y, double radius, double thickness, const Rgb& color);
  // A triangle that points to the right and just fits the rectangle.
  void arrow(const PixelRect& rect, const Rgb& color);

 private:
  Rgba* row(int y) { return pixels_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_); }
  PixelRect inside(const PixelRect& rect) const;

  // `depthAt(x, y)`: how far inside of the shape a place is, px; negative outside. Edges are smooth.
  template <class DepthAt>
  void shape(const PixelRect& rect, const Rgb& color, const DepthAt& depthAt);

  int width_;
  int height_;
  std::vector<Rgba> pixels_;
};

// As fitText(), but quick for texts of any length.
std::string fittedText(std::string_view text, double width, double cell);

// The end of the text that fits, after "..." where something is missing.
std::string fittedTail(std::string_view text, double width, double cell);

// Lines broken at spaces and line ends, and within words that are too long; at most `most`, the last one then ends with
// "...".
std::vector<std::string> wrappedText(std::string_view text, double width, double cell, std::size_t most);

}  // namespace scanmill
