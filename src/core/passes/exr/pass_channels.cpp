#include "passes/exr/pass_channels.h"

#include <fmt/core.h>

#include <algorithm>
#include <string>

#include "base/error.h"
#include "passes/pass_image.h"

namespace scanmill {

namespace {

// Returns the channel called `name`, or otherwise the only channel of a layer with that name ("<layer>.<name>"); null
// if the file has neither.
const ExrChannel* findName(const ExrReader& file, const std::string& name) {
  const ExrChannel* found = nullptr;
  for (const ExrChannel& channel : file.channels()) {
    if (channel.name == name) return &channel;
  }
  for (const ExrChannel& channel : file.channels()) {
    if (!channel.name.ends_with("." + name)) continue;
    if (found != nullptr) {
      throw InputError({file.name()},
                       fmt::format("channels '{}' and '{}' could both be meant: keep one, or rename it '{}'",
                                   found->name, channel.name, name));
    }
    found = &channel;
  }
  return found;
}

// Returns a channel "<layer>.Z" that is a depth: not the third component of a vector, and without further levels
// (unlike Blender's "<layer>.Mist.Z"). Null if there is none.
const ExrChannel* findLayerZ(const ExrReader& file) {
  const auto& all = file.channels();
  const auto isDepth = [&](const ExrChannel& channel) {
    if (!channel.name.ends_with(".Z") || channel.name.find('.') != channel.name.size() - 2) return false;
    std::string x = channel.name;
    x.back() = 'X';
    return std::none_of(all.begin(), all.end(), [&](const ExrChannel& other) { return other.name == x; });
  };
  const auto found = std::find_if(all.begin(), all.end(), isDepth);
  return found == all.end() ? nullptr : &*found;
}

std::string channelList(const ExrReader& file) {
  constexpr std::size_t kMost = 24;
  std::string list;
  for (std::size_t i = 0; i < std::min(file.channels().size(), kMost); ++i) {
    list += (list.empty() ? "" : ", ") + file.channels()[i].name;
  }
  return file.channels().size() > kMost ? list + " ..." : list;
}

[[noreturn]] void refuseAbsence(const ExrReader& file, std::string_view channel, std::string_view what) {
  throw InputError({file.name()},
                   fmt::format("channel '{}' is absent: write {}; there are {}", channel, what, channelList(file)));
}

}  // namespace

const ExrChannel* findPass(const ExrReader& file, std::string_view pass) {
  std::vector<std::string> names{std::string(pass)};
  if (pass == "instance") names.push_back("IndexOB");
  if (pass == "material") names.push_back("IndexMA");
  for (const std::string& name : names) {
    for (const char* end : {"", ".X", ".V"}) {
      if (const ExrChannel* channel = findName(file, name + end)) return channel;
    }
  }
  return nullptr;
}

std::array<const ExrChannel*, 3> findNormal(const ExrReader& file) {
  for (const std::string name : {"N.", "Normal."}) {
    const std::array axes{findName(file, name + "X"), findName(file, name + "Y"), findName(file, name + "Z")};
    if (std::none_of(axes.begin(), axes.end(), [](const ExrChannel* c) { return c == nullptr; })) return axes;
  }
  return {};
}

const ExrChannel& requirePass(const ExrReader& file, std::string_view pass) {
  if (const ExrChannel* channel = findPass(file, pass)) return *channel;
  refuseAbsence(file, pass, fmt::format("the pass '{}'{}", pass, insteadOf(pass)));
}

const ExrChannel& requireDepth(const ExrReader& file) {
  for (const ExrChannel& channel : file.channels()) {
    if (channel.name == "Z") return channel;
  }
  for (const char* name : {"Depth.Z", "depth.Z"}) {
    if (const ExrChannel* channel = findName(file, name)) return *channel;
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
