#include "viewer/window/image_pane.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

void ImagePane::place(int imageWidth, int imageHeight, const PixelRect& room) {
  constexpr double kFlattest = 1.0 / 7;  // least height of the drawn image divided by its width
  constexpr double kWorthwhile = 0.75;   // least fraction of the fitted size at which an integer scale is used
  if (imageWidth != width_ || imageHeight != height_) zoom_ = 1;
  width_ = std::max(imageWidth, 1);
  height_ = std::max(imageHeight, 1);
  room_ = room;
  const double ratio = static_cast<double>(height_) / width_;
  upright_ = std::max(kFlattest / ratio, 1.0);
  fit_ = std::min(static_cast<double>(room.width) / width_, room.height / (height_ * upright_));
  if (const double whole = std::floor(fit_); whole >= kWorthwhile * fit_) fit_ = whole;
  keep();
}

void ImagePane::keep() {
  constexpr double kLargestPixel = 64;  // width of an image pixel at the largest zoom (pixels of the canvas)
  zoom_ = std::clamp(zoom_, 1.0, std::max({1.0, std::min(width_, height_) / 4.0, kLargestPixel / fit_}));
  const bool whole = zoom_ == 1;
  centerX_ = whole ? width_ / 2.0 : std::clamp(centerX_, 0.0, static_cast<double>(width_));
  centerY_ = whole ? height_ / 2.0 : std::clamp(centerY_, 0.0, static_cast<double>(height_));
}

void ImagePane::zoomAt(double by, double x, double y) {
  const double column = columnAt(x);
  const double row = rowAt(y);
  zoom_ *= by;
  keep();
  centerX_ = column - (x - middleX()) / scaleX();
  centerY_ = row - (y - middleY()) / scaleY();
  keep();
}

void ImagePane::moveBy(double right, double down) {
  centerX_ -= right / scaleX();
  centerY_ -= down / scaleY();
  keep();
}

void ImagePane::showWhole() {
  zoom_ = 1;
  keep();
}

std::optional<std::pair<int, int>> ImagePane::pixelAt(int x, int y) const {
  const double column = std::floor(columnAt(x + 0.5));
  const double row = std::floor(rowAt(y + 0.5));
  if (!room_.contains(x, y) || column < 0 || column >= width_ || row < 0 || row >= height_) return {};
  return std::pair(static_cast<int>(column), static_cast<int>(row));
}

std::pair<double, double> ImagePane::placeOf(int column, int row) const {
  return {middleX() + (column + 0.5 - centerX_) * scaleX(), middleY() + (row + 0.5 - centerY_) * scaleY()};
}

PixelRect ImagePane::rect() const {
  return {static_cast<int>(std::lround(middleX() - centerX_ * scaleX())),
          static_cast<int>(std::lround(middleY() - centerY_ * scaleY())),
          static_cast<int>(std::lround(width_ * scaleX())), static_cast<int>(std::lround(height_ * scaleY()))};
}

}  // namespace scanmill
