#pragma once

// What may be known of the hits of a shot's rays. Only the channels that an effect, a column or a recording asks for
// are allocated and computed.

#include <cstdint>
#include <string>
#include <vector>

namespace scanmill {

// One array of Hits each (scan/hits.h), where the values are described.
enum class Channel : std::uint32_t {
  Range = 1u << 0,
  Normal = 1u << 1,
  Instance = 1u << 2,
  Semantic = 1u << 3,
  Material = 1u << 4,
  Primitive = 1u << 5,
  Reflectance = 1u << 6,
  Incidence = 1u << 7,
};

// A set of channels.
class Channels {
 public:
  constexpr Channels() = default;
  constexpr Channels(Channel c) : bits_(static_cast<std::uint32_t>(c)) {}  // NOLINT: a channel is a set of one
  constexpr Channels operator|(Channels o) const { return Channels(bits_ | o.bits_); }
  constexpr Channels operator&(Channels o) const { return Channels(bits_ & o.bits_); }
  constexpr Channels without(Channels o) const { return Channels(bits_ & ~o.bits_); }
  constexpr Channels& operator|=(Channels o) { return *this = *this | o; }
  constexpr bool has(Channel c) const { return (bits_ & static_cast<std::uint32_t>(c)) != 0; }
  constexpr bool operator==(const Channels&) const = default;
  static constexpr Channels all() { return Channels(0xFFu); }

 private:
  constexpr explicit Channels(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_ = 0;
};

constexpr Channels operator|(Channel a, Channel b) {
  return Channels(a) | Channels(b);
}

// The names of the channels in the set, such as "range" and "normal", in the order of the enumeration.
std::vector<std::string> channelNames(Channels channels);

}  // namespace scanmill
