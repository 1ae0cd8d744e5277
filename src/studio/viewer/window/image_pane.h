#pragma once

// Fits an image into a rectangle of the window, and lets the user enlarge and move it.

#include <optional>
#include <utility>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// Positions are pixels of the canvas; columns and rows are pixels of the image.
class ImagePane {
 public:
  // Sets the image's size and the rectangle `room` for it. The image pixel in the middle of the rectangle stays there.
  void place(int imageWidth, int imageHeight, const PixelRect& room);
  // Enlarges by the factor `by`; the image pixel at (x, y) stays there. At zoom 1, the image fits the rectangle; it
  // cannot be made smaller.
  void zoomAt(double by, double x, double y);
  // Moves the image by pixels, at most until one of its edges is in the middle of the rectangle.
  void moveBy(double right, double down);
  void showWhole();

  // Returns the image's column and row at (x, y); nothing if (x, y) is beside the image or outside of the rectangle.
  std::optional<std::pair<int, int>> pixelAt(int x, int y) const;
  // Returns the position of the middle of an image pixel, which may be outside of the rectangle.
  std::pair<double, double> placeOf(int column, int row) const;
  // Returns the rectangle of the complete image, which may extend beyond the rectangle `room`.
  PixelRect rect() const;

 private:
  double scaleX() const { return fit_ * zoom_; }
  double scaleY() const { return fit_ * zoom_ * upright_; }
  double middleX() const { return room_.left + room_.width / 2.0; }
  double middleY() const { return room_.top + room_.height / 2.0; }
  double columnAt(double x) const { return centerX_ + (x - middleX()) / scaleX(); }
  double rowAt(double y) const { return centerY_ + (y - middleY()) / scaleY(); }
  void keep();

  int width_ = 0, height_ = 0;
  PixelRect room_;
  double fit_ = 1;      // pixels of the canvas per column at zoom 1, which shows the complete image
  double upright_ = 1;  // height of a row divided by the width of a column; above 1 for flat images
  double zoom_ = 1;
  double centerX_ = 0, centerY_ = 0;  // column and row of the image in the middle of the rectangle
};

}  // namespace scanmill
