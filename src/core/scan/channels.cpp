#include "scan/channels.h"

#include <array>
#include <utility>

namespace scanmill {

std::vector<std::string> channelNames(Channels channels) {
  static constexpr std::array<std::pair<Channel, const char*>, 8> kNames{{{Channel::Range, "range"},
                                                                          {Channel::Normal, "normal"},
                                                                          {Channel::Instance, "instance"},
                                                                          {Channel::Semantic, "semantic"},
                                                                          {Channel::Material, "material"},
                                                                          {Channel::Primitive, "primitive"},
                                                                          {Channel::Reflectance, "reflectance"},
                                                                          {Channel::Incidence, "incidence"}}};
  std::vector<std::string> names;
  for (const auto& [channel, name] : kNames) {
    if (channels.has(channel)) names.emplace_back(name);
  }
  return names;
}

}  // namespace scanmill
