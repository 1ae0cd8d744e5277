#include "scan/channels.h"

namespace scanmill {

std::vector<std::string> channelNames(Channels channels) {
  std::vector<std::string> names;
  for (const ChannelRow& row : kChannels) {
    if (channels.has(row.channel)) names.emplace_back(row.name);
  }
  return names;
}

}  // namespace scanmill
