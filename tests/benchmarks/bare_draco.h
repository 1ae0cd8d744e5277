#pragma once

// What Draco's own encoder costs: the yardstick of ours.

#include <draco/compression/expert_encode.h>

#include <span>
#include <string>

#include "base/error.h"
#include "scan/scan.h"

namespace scanmill {

// m; a bound of 1 mm on the distance, with a margin for rounding.
constexpr double kBareDracoStep = 2 * 0.001 / 1.7320508 * 0.97;

template <class T, class Values>
int addDracoAttribute(draco::PointCloud& cloud, draco::GeometryAttribute::Type type, draco::DataType dataType,
                      int components, const Values& values) {
  draco::GeometryAttribute shape;
  shape.Init(type, nullptr, static_cast<std::int8_t>(components), dataType, false,
             static_cast<std::int64_t>(sizeof(T)) * components, 0);
  const int id = cloud.AddAttribute(shape, true, cloud.num_points());
  auto* to = reinterpret_cast<T*>(cloud.attribute(id)->buffer()->data());
  for (std::size_t i = 0; i < values.size(); ++i) to[i] = static_cast<T>(values[i]);
  return id;
}

// Draco's own encoder as its documentation shows it, with the narrowest types that hold the columns. Coordinates must
// lie within 130 m. All columns must be there.
inline std::string bareDracoBytes(const Scan& scan) {
  draco::EncoderBuffer buffer;
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<std::uint32_t>(scan.size()));
  const std::span<const float> coordinates(&scan.position[0].x, 3 * scan.size());
  const auto generic = draco::GeometryAttribute::GENERIC;
  const int position =
      addDracoAttribute<float>(cloud, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, coordinates);
  addDracoAttribute<std::uint8_t>(cloud, generic, draco::DT_UINT8, 1, scan[kIntensity]);
  addDracoAttribute<std::uint8_t>(cloud, generic, draco::DT_UINT8, 1, scan[kLabel]);
  addDracoAttribute<std::uint16_t>(cloud, generic, draco::DT_UINT16, 1, scan[kInstance]);
  addDracoAttribute<std::uint8_t>(cloud, generic, draco::DT_UINT8, 1, scan[kRing]);
  addDracoAttribute<std::uint16_t>(cloud, generic, draco::DT_UINT16, 1, scan[kColumn]);
  draco::ExpertEncoder encoder(cloud);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(7, 7);
  const float low[3] = {-130, -130, -130};
  encoder.SetAttributeExplicitQuantization(position, 18, 3, low, static_cast<float>(kBareDracoStep * ((1 << 18) - 1)));
  if (!encoder.EncodeToBuffer(&buffer).ok()) throw Error("Draco refuses");
  return {buffer.data(), buffer.size()};
}

}  // namespace scanmill
