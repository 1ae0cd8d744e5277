#pragma once

// The reasons of a scan's beams as an image: a PNG with a palette whose pixels are the values of Reason, one row per
// ring and one column per column of the sensor. Image viewers show the reasons' colours; programs that read palette
// indices (PIL's mode P) get the values.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Suffix of the members of shards that are images of reasons.
inline constexpr std::string_view kReasonsSuffix = "reasons.png";

// Returns the bytes of the image. Throws Error unless reasonOfBeam has rings * columns values.
std::string encodeReasons(const std::vector<std::uint8_t>& reasonOfBeam, std::uint32_t rings, std::uint32_t columns);

struct ReasonsImage {
  std::uint32_t rings = 0;
  std::uint32_t columns = 0;
  std::vector<std::uint8_t> reasonOfBeam;
};
// Decodes the image. Throws an InputError that begins with `what` if the bytes are no image of reasons.
ReasonsImage decodeReasons(std::string_view bytes, const std::string& what);

// Returns an upper bound of the bytes that encodeReasons() returns.
std::uint64_t mostReasonsBytes(std::uint32_t rings, std::uint32_t columns);

}  // namespace scanmill
