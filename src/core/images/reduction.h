#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace scanmill {

// Makes an image smaller by a whole number, row by row: each pixel is the mean of a square of them. Colours count by
// their light and their alpha.
class Reduction {
 public:
  // `width`: of the image, px.
  Reduction(int width, int factor);

  // Adds a row of 8 bit RGBA.
  void add(const std::uint8_t* rgba);
  // Writes the row of means of the rows since the last one, (width + factor - 1) / factor pixels.
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
