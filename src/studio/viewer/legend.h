#pragma once

// The strips above and below a scan: what is shown, and what its colours mean.

#include <string>

#include "viewer/coloring.h"
#include "viewer/image.h"

namespace scanmill {

// The scan's own part of a picture: all rows from `top` to below `bottom`. Nothing else is drawn there.
struct PictureLayout {
  int width = 0;
  int height = 0;
  int top = 0;
  int bottom = 0;
  double cell = 1;  // of the text, pixels
};

// The legend takes at most two fifths of the height; entries for which there is no room are counted instead.
PictureLayout layoutPicture(int width, int height, const Legend& legend);

// For a scan's part of `bodyHeight` rows: the picture becomes as high as it must.
PictureLayout layoutAround(int width, int bodyHeight, const Legend& legend);

void drawTitle(Image& image, const PictureLayout& layout, const std::string& left, const std::string& right);
void drawLegend(Image& image, const PictureLayout& layout, const Legend& legend);

// In the middle of the scan's part, large.
void drawNotice(Image& image, const PictureLayout& layout, const std::string& text);

}  // namespace scanmill
