#include "viewer/window/image_pane.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

void ImagePane::place(int imageWidth, int imageHeight, int roomWidth, int roomHeight) {
  constexpr double kFlattest = 1.0 / 7;  // height over width of an image that is to be read
  constexpr double kWorthwhile = 0.75;   // whole steps, where they lose little
  const bool other = imageWidth != width_ || imageHeight != height_;
  width_ = std::max(imageWidth, 1);
  height_ = std::max(imageHeight, 1);
  roomWidth_ = std::max(roomWidth, 1);
  roomHeight_ = std::max(roomHeight, 1);
  const double ratio = static_cast<double>(height_) / width_;
  upright_ = std::max(kFlattest / ratio, 1.0);
  fit_ = std::min(static_cast<double>(roomWidth_) / width_, roomHeight_ / (height_ * upright_));
  if (const double whole = std::floor(fit_); whole >= kWorthwhile * fit_) fit_ = whole;
  if (other) zoom_ = 1;
  keep();
}

double ImagePane::mostZoom() const {
  constexpr double kLargestPixel = 64;  // px
  return std::max({1.0, std::min(width_, height_) / 4.0, kLargestPixel / fit_});
}

void ImagePane::keep() {
  zoom_ = std::clamp(zoom_, 1.0, mostZoom());
  if (zoom_ == 1) {
    centerX_ = width_ / 2.0;
    centerY_ = height_ / 2.0;
  }
  centerX_ = std::clamp(centerX_, 0.0, static_cast<double>(width_));
  centerY_ = std::clamp(centerY_, 0.0, static_cast<double>(height_));
}

void ImagePane::zoomAt(double by, double x, double y) {
  const double column = columnAt(x);
  const double row = rowAt(y);
  zoom_ = std::clamp(zoom_ * by, 1.0, mostZoom());
  centerX_ = column - (x - roomWidth_ / 2.0) / scaleX();
  centerY_ = row - (y - roomHeight_ / 2.0) / scaleY();
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

std::optional<std::pair<int, int>> ImagePane::pixelAt(double x, double y) const {
  const double column = std::floor(columnAt(x));
  const double row = std::floor(rowAt(y));
  if (!(column >= 0 && column < width_ && row >= 0 && row < height_)) return {};
  return std::pair(static_cast<int>(column), static_cast<int>(row));
}

std::pair<int, int> ImagePane::roomPixelOf(int column, int row) const {
  return {static_cast<int>(std::floor((column + 0.5 - centerX_) * scaleX() + roomWidth_ / 2.0)),
          static_cast<int>(std::floor((row + 0.5 - centerY_) * scaleY() + roomHeight_ / 2.0))};
}

ImagePane::Seen ImagePane::seen() const {
  const double left = std::max(columnAt(0), 0.0);
  const double top = std::max(rowAt(0), 0.0);
  const double right = std::min(columnAt(roomWidth_), static_cast<double>(width_));
  const double bottom = std::min(rowAt(roomHeight_), static_cast<double>(height_));
  const auto x = [&](double column) {
    return static_cast<int>(std::lround((column - centerX_) * scaleX() + roomWidth_ / 2.0));
  };
  const auto y = [&](double row) {
    return static_cast<int>(std::lround((row - centerY_) * scaleY() + roomHeight_ / 2.0));
  };
  return {{left / width_, top / height_, right / width_, bottom / height_},
          {x(left), y(top), std::max(x(right) - x(left), 1), std::max(y(bottom) - y(top), 1)}};
}

}  // namespace scanmill
