#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace scanmill {

// Reduces an image by a whole factor, row by row: each pixel is the mean of a square of factor x factor pixels. Colours
// are averaged in linear light, weighted by alpha.
class Reduction {
 public:
  // `width` is the width of the image to reduce (px).
  Reduction(int width, int factor);

  // Adds a row of 8-bit RGBA.
  void add(const std::uint8_t* rgba);
  // Writes one reduced row, (width + factor - 1) / factor pixels: the means of the rows added since the last call.
  void take(std::uint8_t* rgba);

 private:
  struct Sum {
    std::array<float, 3> light{};
    float weight = 0;
    std::uint32_t alpha = 0;
    std::uint32_t count = 0;
  };

  int width_;
  int factor_;
  std::vector<Sum> sums_;
};

}  // namespace scanmill
