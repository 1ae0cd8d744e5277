#pragma once

// Computes the rectangles of panels on a canvas, and the remaining rectangle for the views.

#include <cstddef>
#include <vector>

#include "viewer/canvas/canvas.h"

namespace scanmill {

struct PanelNeeds {
  double lineHeight = 15;  // height of a line of text in pixels, see ImGuiLayer
  double row = 21;         // height of a menu, a button or a slider (pixels)
  bool title = true;
  bool side = true;     // true: a panel with the legends and the selected point
  bool bar = true;      // true: a bar with the frame slider
  int stripHeight = 0;  // height of the range image without its caption (pixels); 0: no range image
};

// Return the height of a line of text (pixels): pictureLineHeight() in a picture of `width` x `height` pixels,
// windowLineHeight() in a window. `displayScale`: see Canvas::scale().
double pictureLineHeight(int width, int height);
double windowLineHeight(double displayScale);

// Returns the width of a side panel (pixels).
int sideWidth(double lineHeight);

// The rectangles of the panels (empty for a panel that is not shown), and `body`, which the views fill (never empty).
struct PanelRects {
  PixelRect title, side, strip, bar, body;
};

PanelRects panelRects(int width, int height, const PanelNeeds& needs);

// Returns the height (pixels) at which a range image of `imageHeight` rows is drawn on a canvas of the given size. The
// height is a multiple of `imageHeight`, unless `imageHeight` is too large for the canvas.
int stripHeight(int imageHeight, int width, int height);

// Divides `body` into `cells` equal rectangles of at least one pixel, row by row. Unless they are small, they are one
// pixel apart.
std::vector<PixelRect> gridRects(const PixelRect& body, std::size_t cells);

}  // namespace scanmill
