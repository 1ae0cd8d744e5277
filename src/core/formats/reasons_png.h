#pragma once

// The reasons of a scan's beams as an image: a PNG with a palette, whose pixels are the values of Reason. A row per
// ring and a column per column of the sensor. Image viewers show the reasons' colours; programs that read the indices
// of the palette (PIL's mode P) find the values.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// What stands in place of a format's suffix in the name of the member.
inline constexpr std::string_view kReasonsSuffix = "reasons.png";

// Throws Error where there are not rings * columns values.
std::string encodeReasons(const std::vector<std::uint8_t>& reasonOfBeam, std::uint32_t rings, std::uint32_t columns);

struct ReasonsImage {
  std::uint32_t rings = 0;
  std::uint32_t columns = 0;
  std::vector<std::uint8_t> reasonOfBeam;
};
// Throws an InputError that begins with `what` for bytes that are no such image.
ReasonsImage decodeReasons(std::string_view bytes, const std::string& what);

// An upper bound of the bytes that encodeReasons() makes.
std::uint64_t mostReasonsBytes(std::uint32_t rings, std::uint32_t columns);

}  // namespace scanmill
