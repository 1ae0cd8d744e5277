#pragma once

// Where an image stands in the room that a window has for it: fitted, enlarged about a place, moved.

#include <optional>
#include <utility>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// Places are pixels of the canvas.
class ImagePane {
 public:
  // What is in the middle stays there.
  void place(int imageWidth, int imageHeight, const PixelRect& room);
  // What lies at (x, y) stays there. Not smaller than fits.
  void zoomAt(double by, double x, double y);
  // The middle of the room stays over the image.
  void moveBy(double right, double down);
  void showWhole();

  // Column and row of the image; none beside it or outside of the room.
  std::optional<std::pair<int, int>> pixelAt(int x, int y) const;
  // The middle of an image's pixel; may lie outside.
  std::pair<double, double> placeOf(int column, int row) const;
  // The whole image; it may reach beyond the room.
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
  double fit_ = 1;      // px of the room per column when all is seen
  double upright_ = 1;  // rows are so much higher than columns are wide: flat images are stretched
  double zoom_ = 1;
  double centerX_ = 0, centerY_ = 0;  // of the room, in the image's pixels
};

}  // namespace scanmill
