#include <fmt/core.h>

#include <algorithm>
#include <string>

#include "base/error.h"
#include "passes/exr/exr_file.h"
#include "passes/pass_image.h"

namespace scanmill {

namespace {

// Returns the channel called `name`, or otherwise the only channel of a layer with that name ("<layer>.<name>"); null
// if the file has neither.
const ExrChannel* findInAnyLayer(const ExrReader& file, const std::string& name) {
  if (const ExrChannel* channel = file.find(name)) return channel;
  const ExrChannel* layered = nullptr;
  for (const ExrChannel& channel : file.channels()) {
    if (!channel.name.ends_with("." + name)) continue;
    if (layered != nullptr) {
      throw InputError({file.name()},
                       fmt::format("channels '{}' and '{}' could both be meant: keep one, or rename it '{}'",
                                   layered->name, channel.name, name));
    }
    layered = &channel;
  }
  return layered;
}

// Returns a channel "<layer>.Z" that is a depth: not the third component of a vector, and without further levels
// (unlike Blender's "<layer>.Mist.Z"). Null if there is none.
const ExrChannel* findLayerZ(const ExrReader& file) {
  const auto isDepth = [&](const ExrChannel& channel) {
    if (!channel.name.ends_with(".Z") || channel.name.find('.') != channel.name.size() - 2) return false;
    return file.find(channel.name.substr(0, channel.name.size() - 1) + "X") == nullptr;
  };
  const auto depth = std::ranges::find_if(file.channels(), isDepth);
  return depth == file.channels().end() ? nullptr : &*depth;
}

// Returns the names of the file's channels, for messages.
std::string channelList(const ExrReader& file) {
  constexpr std::size_t kListed = 24;  // so that the message stays readable
  std::string list;
  for (std::size_t i = 0; i < std::min(file.channels().size(), kListed); ++i) {
    list += (list.empty() ? "" : ", ") + file.channels()[i].name;
  }
  return file.channels().size() > kListed ? list + " ..." : list;
}

[[noreturn]] void refuseAbsence(const ExrReader& file, std::string_view channel, std::string_view remedy) {
  throw InputError({file.name()},
                   fmt::format("channel '{}' is absent: write {}; there are {}", channel, remedy, channelList(file)));
}

}  // namespace

const ExrChannel* findPass(const ExrReader& file, std::string_view pass) {
  std::vector<std::string> names{std::string(pass)};
  if (pass == "instance") names.push_back("IndexOB");
  if (pass == "material") names.push_back("IndexMA");
  for (const std::string& name : names) {
    for (const char* end : {"", ".X", ".V"}) {
      if (const ExrChannel* channel = findInAnyLayer(file, name + end)) return channel;
    }
  }
  return nullptr;
}

std::array<const ExrChannel*, 3> findNormal(const ExrReader& file) {
  for (const std::string name : {"N.", "Normal."}) {
    const std::array axes{findInAnyLayer(file, name + "X"), findInAnyLayer(file, name + "Y"),
                          findInAnyLayer(file, name + "Z")};
    if (std::none_of(axes.begin(), axes.end(), [](const ExrChannel* c) { return c == nullptr; })) return axes;
  }
  return {};
}

const ExrChannel& requirePass(const ExrReader& file, std::string_view pass) {
  if (const ExrChannel* channel = findPass(file, pass)) return *channel;
  refuseAbsence(file, pass, fmt::format("the pass '{}'{}", pass, insteadOf(pass)));
}

const ExrChannel& requireDepth(const ExrReader& file) {
  if (const ExrChannel* channel = file.find("Z")) return *channel;
  for (const char* name : {"Depth.Z", "depth.Z"}) {
    if (const ExrChannel* channel = findInAnyLayer(file, name)) return *channel;
  }
  if (const ExrChannel* channel = findLayerZ(file)) return *channel;
  refuseAbsence(file, "Z", "the planar depth as 32 bit FLOAT");
}

std::array<const ExrChannel*, 3> requireNormal(const ExrReader& file) {
  const auto axes = findNormal(file);
  if (axes[0] == nullptr) {
    refuseAbsence(file, "N.X, N.Y, N.Z", fmt::format("the normals, in world axes{}", insteadOf("normal")));
  }
  return axes;
}

}  // namespace scanmill
