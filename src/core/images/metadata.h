#pragma once

// Properties that images state beside their pixels, and that would change how they look. All functions are inline,
// since modules use them too.

#include <cstddef>
#include <string_view>

namespace scanmill {

// What readers name in ImageHeader::leftOut.
inline constexpr const char* kProfiles = "colour profiles other than sRGB (colours count as sRGB)";
inline constexpr const char* kGammas = "gammas other than that of sRGB (gAMA)";
inline constexpr const char* kOrientations = "orientations (Exif), by which viewers turn the image";
inline constexpr const char* kFurtherImages = "sets of further images (the first image counts)";
inline constexpr const char* kFewColors = "images without red, green or blue (EXR; their first channel counts as grey)";
inline constexpr const char* kFurtherChannels = "channels that are neither colour nor alpha";

// True if an ICC profile has "sRGB" in one of its texts (ASCII, or UTF-16 with the high byte first).
inline bool isSrgb(std::string_view profile) {
  return profile.find("sRGB") != profile.npos || profile.find(std::string_view("s\0R\0G\0B", 7)) != profile.npos;
}

// True if Exif data, which start with the TIFF header, state an orientation other than that of the stored rows.
inline bool isTurned(std::string_view exif) {
  const bool little = exif.starts_with("II");
  const auto number = [&](std::size_t at, std::size_t bytes) {
    std::size_t value = 0;
    for (std::size_t i = 0; i < bytes && at < exif.size() && exif.size() - at >= bytes; ++i) {
      value = value << 8 | static_cast<unsigned char>(exif[at + (little ? bytes - 1 - i : i)]);
    }
    return value;
  };
  const std::size_t directory = number(4, 4);
  for (std::size_t k = 0, count = number(directory, 2); k < count; ++k) {
    const std::size_t entry = directory + 2 + 12 * k;
    if (number(entry, 2) == 0x112) return number(entry + 8, 2) > 1;
  }
  return false;
}

}  // namespace scanmill
