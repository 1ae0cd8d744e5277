#pragma once

// Small GeoTIFF files: TIFF 6.0 and "OGC GeoTIFF Standard" 1.1, one strip of float32.

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace scanmill {

struct GeoTiff {
  std::uint32_t width = 0, height = 0;
  std::vector<float> values;                            // by rows, the northern first
  double west = 0, north = 0;                           // of the upper left corner
  double step = 1;                                      // from sample to sample
  std::uint16_t epsg = 32633;                           // UTM 33N; 4326: longitude and latitude
  std::string none = "";                                // the text of the value that stands for none
  std::vector<std::array<std::uint16_t, 2>> keys = {};  // further keys with their values, ascending from 3073

  std::string bytes() const {
    std::string out("II*\0\0\0\0\0", 8);
    const auto add = [&](const auto& value) {
      out.append(reinterpret_cast<const char*>(&value), sizeof(value));
      return static_cast<std::uint32_t>(out.size() - sizeof(value));
    };
    const std::uint32_t strip = static_cast<std::uint32_t>(out.size());
    for (const float v : values) add(v);
    const std::uint32_t scale = static_cast<std::uint32_t>(out.size());
    for (const double v : {step, step, 0.0}) add(v);
    const std::uint32_t tie = static_cast<std::uint32_t>(out.size());
    for (const double v : {0.0, 0.0, 0.0, west, north, 0.0}) add(v);
    const bool geographic = epsg == 4326;
    const std::uint32_t keysAt = static_cast<std::uint32_t>(out.size());
    const auto system = static_cast<std::uint16_t>(geographic ? 2048 : 3072);
    std::vector<std::uint16_t> directory{1,    1, 0, 3, 1024,   0, 1, static_cast<std::uint16_t>(geographic ? 2 : 1),
                                         1025, 0, 1, 1, system, 0, 1, epsg};
    for (const auto& [key, value] : keys) {
      directory.insert(directory.end(), {key, 0, 1, value});
      ++directory[3];
    }
    for (const std::uint16_t v : directory) add(v);
    const std::string text = none + std::string(1 + (none.size() + 1) % 2, '\0');
    const std::uint32_t noneAt = static_cast<std::uint32_t>(out.size());
    out += text;
    struct Tag {
      std::uint16_t tag, type;
      std::uint32_t count, value;
    };
    std::vector<Tag> tags{{256, 4, 1, width},
                          {257, 4, 1, height},
                          {258, 3, 1, 32},
                          {259, 3, 1, 1},
                          {262, 3, 1, 1},
                          {273, 4, 1, strip},
                          {277, 3, 1, 1},
                          {278, 4, 1, height},
                          {279, 4, 1, static_cast<std::uint32_t>(4 * values.size())},
                          {339, 3, 1, 3},
                          {33550, 12, 3, scale},
                          {33922, 12, 6, tie},
                          {34735, 3, static_cast<std::uint32_t>(directory.size()), keysAt}};
    if (none.size() > 3) tags.push_back({42113, 2, static_cast<std::uint32_t>(none.size() + 1), noneAt});
    const std::uint32_t first = static_cast<std::uint32_t>(out.size());
    std::memcpy(out.data() + 4, &first, 4);
    add(static_cast<std::uint16_t>(tags.size()));
    for (const Tag& t : tags) add(t.tag), add(t.type), add(t.count), add(t.value);
    add(std::uint32_t{0});
    return out;
  }
};

}  // namespace scanmill
