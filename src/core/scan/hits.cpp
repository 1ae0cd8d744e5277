#include "scan/hits.h"

namespace scanmill {

void Hits::reset(std::uint32_t ringCount, std::uint32_t columnCount, Channels asked) {
  rings = ringCount;
  columns = columnCount;
  channels = asked | Channel::Range;
  beamOfRay.clear();
  weightOfRay.clear();
  pathOfRay.clear();
  glassIsClear = false;
  forEachChannel(
      [&](const ChannelRow& row, auto member) { (this->*member).resize(channels.has(row.channel) ? size() : 0); });
  roughness.clear();
  metallic.clear();
  retroreflectance.clear();
  unresolved.clear();
}

}  // namespace scanmill
