#pragma once

// Fits an image into its rectangle of the window, enlarges it about a place and moves it.

#include <optional>
#include <utility>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// All positions are pixels of the canvas, unless they are a column and a row of the image.
class ImagePane {
 public:
  // Sets the image's size and the rectangle `room`; the image pixel in the middle of the rectangle stays there.
  void place(int imageWidth, int imageHeight, const PixelRect& room);
  // Enlarges by the factor `by`; the image pixel at (x, y) stays there. The image never gets smaller than fitted.
  void zoomAt(double by, double x, double y);
  // Moves the image; the middle of the rectangle stays over the image.
  void moveBy(double right, double down);
  void showWhole();

  // Returns the image's column and row at (x, y); none beside the image or outside the rectangle.
  std::optional<std::pair<int, int>> pixelAt(int x, int y) const;
  // Returns the middle of an image pixel, which may lie outside the rectangle.
  std::pair<double, double> placeOf(int column, int row) const;
  // Returns the rectangle of the whole image, which may reach beyond the rectangle `room`.
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
  double fit_ = 1;      // px of the canvas per column when the whole image is seen
  double upright_ = 1;  // a row's height over a column's width: flat images are stretched
  double zoom_ = 1;
  double centerX_ = 0, centerY_ = 0;  // column and row of the image in the middle of the rectangle
};

}  // namespace scanmill
