#include "viewer/color_map.h"

#include <fmt/core.h>

#include <algorithm>

namespace scanmill {

namespace {

// Converts a colour from HSV to RGB; h, s and v are from 0 to 1.
Rgb fromHsv(double h, double s, double v) {
  constexpr std::array kChannelOffsets{5.0, 3.0, 1.0};  // offsets of red, green and blue in hue (sixths of the circle)
  Rgb rgb{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double k = std::fmod(h * 6 + kChannelOffsets[c], 6.0);
    rgb[c] = static_cast<std::uint8_t>(std::lround(255 * v * (1 - s * std::clamp(std::min(k, 4 - k), 0.0, 1.0))));
  }
  return rgb;
}

// Returns a colour for an id. Since hues advance by the golden ratio, they are evenly spread for any number of ids.
// Saturation and brightness vary, so that similar hues differ, too.
Rgb colorOfId(std::uint32_t id) {
  const double hue = std::fmod(id * 0.6180339887498949, 1.0);
  return fromHsv(hue, 0.45 + 0.15 * (id % 3), 0.95 - 0.15 * (id / 3 % 2));
}

}  // namespace

Rgb viridis(double t) {
  // Every 17th colour of the map's 256 colours.
  static constexpr std::array<std::uint32_t, 16> kSamples{0x440154, 0x481A6C, 0x472F7D, 0x414487, 0x39568C, 0x31688E,
                                                          0x2A788E, 0x23888E, 0x1F988B, 0x22A884, 0x35B779, 0x54C568,
                                                          0x7AD151, 0xA5DB36, 0xD2E21B, 0xFDE725};  // 0xRRGGBB
  const auto sample = [](std::size_t i) {
    return Rgb{static_cast<std::uint8_t>(kSamples[i] >> 16), static_cast<std::uint8_t>(kSamples[i] >> 8 & 0xFF),
               static_cast<std::uint8_t>(kSamples[i] & 0xFF)};
  };
  const double position = std::clamp(t, 0.0, 1.0) * (kSamples.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(position), kSamples.size() - 2);
  return mix(sample(low), sample(low + 1), position - static_cast<double>(low));
}

Rgb instanceColor(std::uint32_t instance) {
  return instance == 0 ? kNoValue : colorOfId(instance);
}

Rgb classColor(const Ontology* ontology, std::uint16_t id) {
  const SemanticClass* const found = ontology == nullptr ? nullptr : ontology->find(id);
  if (found == nullptr) return id == 0 ? kNoValue : colorOfId(id);
  constexpr double kDarkest = 60;  // least luma of a class's colour (Rec. 601, 0 to 255); chosen by eye
  const Rgb color = found->color;
  const double luma = 0.299 * color[0] + 0.587 * color[1] + 0.114 * color[2];
  return luma >= kDarkest ? color : mix(color, {255, 255, 255}, (kDarkest - luma) / (255 - luma));
}

std::string className(const Ontology* ontology, std::uint16_t id) {
  const SemanticClass* const found = ontology == nullptr ? nullptr : ontology->find(id);
  return found == nullptr ? fmt::format("class {}", id) : found->name;
}

}  // namespace scanmill
