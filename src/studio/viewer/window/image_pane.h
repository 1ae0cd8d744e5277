#pragma once

// Where an image stands in the room that a window has for it: fitted, enlarged about a place, moved.

#include <optional>
#include <utility>

#include "viewer/panels/parts.h"

namespace scanmill {

class ImagePane {
 public:
  // Sizes in pixels. What is in the middle stays there.
  void place(int imageWidth, int imageHeight, int roomWidth, int roomHeight);
  // What lies at (x, y), px of the room, stays there. Not smaller than fits.
  void zoomAt(double by, double x, double y);
  // By px of the room; the middle of the room stays over the image.
  void moveBy(double right, double down);
  void showWhole();

  // Column and row at a place of the room; none beside the image.
  std::optional<std::pair<int, int>> pixelAt(double x, double y) const;
  // Pixel of the room over the middle of an image's pixel; may lie outside.
  std::pair<int, int> roomPixelOf(int column, int row) const;
  // The part of the image that is seen, in shares of its sides, and where it stands, px of the room.
  struct Seen {
    ImagePart part;
    PixelRect rect;
  };
  Seen seen() const;

 private:
  double scaleX() const { return fit_ * zoom_; }
  double scaleY() const { return fit_ * zoom_ * upright_; }
  double columnAt(double x) const { return centerX_ + (x - roomWidth_ / 2.0) / scaleX(); }
  double rowAt(double y) const { return centerY_ + (y - roomHeight_ / 2.0) / scaleY(); }
  double mostZoom() const;
  void keep();

  int width_ = 0, height_ = 0;
  int roomWidth_ = 1, roomHeight_ = 1;
  double fit_ = 1;      // px of the room per column when all is seen
  double upright_ = 1;  // rows are so much higher than columns are wide: flat images are stretched
  double zoom_ = 1;
  double centerX_ = 0, centerY_ = 0;  // of the room, in the image's pixels
};

}  // namespace scanmill
