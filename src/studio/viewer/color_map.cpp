#include "viewer/color_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace scanmill {

namespace {

// h, s and v from 0 to 1.
Rgb fromHsv(double h, double s, double v) {
  Rgb out{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double k = std::fmod(h * 6 + std::array{5.0, 3.0, 1.0}[c], 6.0);
    out[c] = static_cast<std::uint8_t>(std::lround(255 * v * (1 - s * std::clamp(std::min(k, 4 - k), 0.0, 1.0))));
  }
  return out;
}

// Steps of the golden ratio spread hues evenly, however many are drawn.
Rgb colorOfNumber(std::uint32_t number) {
  const double turn = std::fmod(number * 0.6180339887498949, 1.0);
  return fromHsv(turn, 0.45 + 0.15 * (number % 3), 0.95 - 0.15 * (number / 3 % 2));
}

}  // namespace

Rgb viridis(double t) {
  // Every 17th of the map's 256 colours.
  static constexpr std::array<Rgb, 16> kSamples{{{0x44, 0x01, 0x54},
                                                 {0x48, 0x1A, 0x6C},
                                                 {0x47, 0x2F, 0x7D},
                                                 {0x41, 0x44, 0x87},
                                                 {0x39, 0x56, 0x8C},
                                                 {0x31, 0x68, 0x8E},
                                                 {0x2A, 0x78, 0x8E},
                                                 {0x23, 0x88, 0x8E},
                                                 {0x1F, 0x98, 0x8B},
                                                 {0x22, 0xA8, 0x84},
                                                 {0x35, 0xB7, 0x79},
                                                 {0x54, 0xC5, 0x68},
                                                 {0x7A, 0xD1, 0x51},
                                                 {0xA5, 0xDB, 0x36},
                                                 {0xD2, 0xE2, 0x1B},
                                                 {0xFD, 0xE7, 0x25}}};
  const double place = std::clamp(t, 0.0, 1.0) * (kSamples.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(place), kSamples.size() - 2);
  return mix(kSamples[low], kSamples[low + 1], place - static_cast<double>(low));
}

Rgb instanceColor(std::uint32_t instance) {
  return instance == 0 ? kNoValue : colorOfNumber(instance);
}

Rgb classColor(const Ontology* ontology, std::uint16_t id) {
  const SemanticClass* known = ontology == nullptr ? nullptr : ontology->find(id);
  if (known == nullptr) return id == 0 ? kNoValue : colorOfNumber(id);
  constexpr double kDarkest = 60;  // luma of Rec. 601
  const Rgb color = known->color;
  const double luma = 0.299 * color[0] + 0.587 * color[1] + 0.114 * color[2];
  return luma >= kDarkest ? color : mix(color, {255, 255, 255}, (kDarkest - luma) / (255 - luma));
}

}  // namespace scanmill
