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
  const auto fit = [&](auto& column, Channel channel) { column.resize(channels.has(channel) ? size() : 0); };
  fit(range, Channel::Range);
  fit(normal, Channel::Normal);
  fit(instance, Channel::Instance);
  fit(semantic, Channel::Semantic);
  fit(material, Channel::Material);
  fit(primitive, Channel::Primitive);
  fit(reflectance, Channel::Reflectance);
  fit(incidence, Channel::Incidence);
  roughness.clear();
  metallic.clear();
  retroreflectance.clear();
  unresolved.clear();
}

}  // namespace scanmill
