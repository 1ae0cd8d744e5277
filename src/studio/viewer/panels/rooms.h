#pragma once

// Where panels stand on a canvas, and what they leave to the views.

#include <vector>

#include "viewer/canvas/canvas.h"

namespace scanmill {

struct PanelNeeds {
  double letter = 15;  // px, see Toolkit
  double row = 21;     // px: of a menu, a button or a slider
  bool title = true;
  bool side = true;     // what colours mean, the point that was clicked
  bool bar = true;      // frames
  int stripHeight = 0;  // px: of the range image, without its caption; 0: none
};

// Letters, px: in a window on a display of this scale (see Canvas), and in a picture of this size.
double letterOfWindow(double scale);
double letterOfPicture(int width, int height);

// Of a picture with a title and, where asked for, what colours mean.
PanelNeeds needsOfPicture(int width, int height, bool side);

// What is not there is empty; the body never is.
struct PanelRooms {
  PixelRect title, side, strip, bar, body;
};

PanelRooms roomsOf(int width, int height, const PanelNeeds& needs);

// A range image's height over such a canvas: its rows in whole steps where there is room for that.
int stripHeight(int imageHeight, int width, int height);

// Parts of one size, at least one pixel each, side by side or below one another, with gaps between them. None stays
// empty, and they are as near to a pleasing shape as that lets them be.
std::vector<PixelRect> partsOf(const PixelRect& body, std::size_t parts, int gap);

}  // namespace scanmill
