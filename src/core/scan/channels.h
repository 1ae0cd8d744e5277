#pragma once

// Channels are the properties of a hit that may be computed. A channel is allocated and computed only if an effect, a
// column or a recording asks for it. Each channel has a row in kChannels, a member of Hits with a line in
// forEachChannel() (scan/hits.h), and code that fills this member. This header is installed because scan/hits.h
// includes it.
//
//   const Channels asked = Channel::Range | Channel::Semantic;
//   const bool normals = asked.has(Channel::Normal);  // false

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Each channel is one array of Hits; scan/hits.h describes the values.
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
  [[nodiscard]] constexpr Channels without(Channels o) const { return Channels(bits_ & ~o.bits_); }
  constexpr Channels& operator|=(Channels o) { return *this = *this | o; }
  constexpr bool has(Channel c) const { return (bits_ & static_cast<std::uint32_t>(c)) != 0; }
  constexpr bool operator==(const Channels&) const = default;
  static constexpr Channels all();

 private:
  constexpr explicit Channels(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_ = 0;
};

constexpr Channels operator|(Channel a, Channel b) {
  return Channels(a) | Channels(b);
}

struct ChannelRow {
  Channel channel;
  std::string_view name;  // name in messages and plans
  std::string_view exr;   // name in EXR files of hits; for a vector the name of its x component
  bool rendered;          // true: renderers render it as an image
  bool recorded;          // true: `generate --keep-hits` stores it
};

inline constexpr std::array<ChannelRow, 8> kChannels{{
    {Channel::Range, "range", "range", true, true},  // rendered as a depth image
    {Channel::Normal, "normal", "N.X", true, false},
    {Channel::Instance, "instance", "instance", true, true},
    {Channel::Semantic, "semantic", "semantic", true, true},
    {Channel::Material, "material", "material", true, true},
    {Channel::Primitive, "primitive", "primitive", true, false},
    {Channel::Reflectance, "reflectance", "reflectance", true, true},
    {Channel::Incidence, "incidence", "incidence", false, true},  // computed from the normal
}};

// Returns the row of a channel.
constexpr const ChannelRow& rowOf(Channel channel) {
  for (const ChannelRow& row : kChannels) {
    if (row.channel == channel) return row;
  }
  return kChannels.front();
}

// Returns the channels whose row has the flag `flag` set, for example channelsThat(&ChannelRow::rendered).
constexpr Channels channelsThat(bool ChannelRow::*flag) {
  Channels channels;
  for (const ChannelRow& row : kChannels) channels |= row.*flag ? Channels(row.channel) : Channels();
  return channels;
}

constexpr Channels Channels::all() {
  Channels channels;
  for (const ChannelRow& row : kChannels) channels |= row.channel;
  return channels;
}

// Returns the names of the channels in the set, in the order of kChannels.
inline std::vector<std::string> channelNames(Channels channels) {
  std::vector<std::string> names;
  for (const ChannelRow& row : kChannels) {
    if (channels.has(row.channel)) names.emplace_back(row.name);
  }
  return names;
}

}  // namespace scanmill
