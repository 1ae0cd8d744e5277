#pragma once

// Text without installed fonts.

#include <string>
#include <string_view>

#include "viewer/image.h"

namespace scanmill {

// Letters are drawn on a grid of cells, `cell` pixels wide: capitals are 7 cells high, and 2 more reach below the line.
constexpr int kCapCells = 7;

// Width in pixels. Anything but printable ASCII counts and is drawn as '?', a UTF-8 sequence as one.
double textWidth(std::string_view text, double cell);

// (x, y) is the upper left corner of a capital. Smooth edges; what juts out of the image is left out.
void drawText(Image& image, double x, double y, std::string_view text, const Rgb& color, double cell);

// The text, or as much of its beginning as fits into `width` pixels together with "...".
std::string fitText(std::string_view text, double width, double cell);

}  // namespace scanmill
