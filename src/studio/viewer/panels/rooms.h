#pragma once

// Computes the rectangles of panels on a canvas, and the rectangle that is left to the views.

#include <vector>

#include "viewer/canvas/canvas.h"

namespace scanmill {

struct PanelNeeds {
  double letter = 15;  // px, see Toolkit
  double row = 21;     // px: height of a menu, a button or a slider
  bool title = true;
  bool side = true;     // the panel with the legends and the clicked point
  bool bar = true;      // the frame slider
  int stripHeight = 0;  // px: height of the range image, without its caption; 0: none
};

// Return the letter height (px) in a window on a display of this scale (see Canvas), and in a picture of this size.
double letterOfWindow(double scale);
double letterOfPicture(int width, int height);

// Returns the needs of a picture with a title and, if `side`, the legend.
PanelNeeds needsOfPicture(int width, int height, bool side);

// Rectangles of the panels, empty for panels that are not shown. `body` is for the views and is never empty.
struct PanelRooms {
  PixelRect title, side, strip, bar, body;
};

PanelRooms roomsOf(int width, int height, const PanelNeeds& needs);

// Returns the height (px) at which a range image is drawn on such a canvas: a whole multiple of its rows if it fits.
int stripHeight(int imageHeight, int width, int height);

// Divides `body` into a full grid of equal parts with gaps between them, each at least one pixel. Of the grids with
// exactly `parts` cells the one is taken whose cells' aspect ratio is best.
std::vector<PixelRect> partsOf(const PixelRect& body, std::size_t parts, int gap);

}  // namespace scanmill
