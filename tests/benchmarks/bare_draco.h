#pragma once

// What Draco's own encoder costs: the yardstick of ours.

#include <draco/compression/expert_encode.h>

#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "scan/scan.h"

namespace scanmill {

// m; a bound of 1 mm on the distance, with a margin for rounding.
constexpr double kBareDracoStep = 2 * 0.001 / 1.7320508 * 0.97;

// Draco's own encoder as its documentation shows it.
struct BareDraco {
  bool narrow = true;     // u8 and u16; else u32, and the bits of the time
  bool integers = false;  // positions as integer steps; else quantised floats
  int method = draco::POINT_CLOUD_SEQUENTIAL_ENCODING;
  bool entropy = true;
  bool deduplicate = false;
};

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

// Coordinates must lie within 130 m. All columns must be there.
inline std::string bareDracoBytes(const Scan& scan, const BareDraco& options) {
  draco::EncoderBuffer buffer;
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<std::uint32_t>(scan.size()));
  const std::span<const float> coordinates(&scan.position[0].x, 3 * scan.size());
  const auto generic = draco::GeometryAttribute::GENERIC;
  int position = 0;
  if (options.integers) {
    std::vector<std::int32_t> steps(coordinates.size());
    for (std::size_t i = 0; i < steps.size(); ++i)
      steps[i] = static_cast<std::int32_t>(std::lrint(coordinates[i] / kBareDracoStep));
    position = addDracoAttribute<std::int32_t>(cloud, draco::GeometryAttribute::POSITION, draco::DT_INT32, 3, steps);
  } else {
    position = addDracoAttribute<float>(cloud, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, coordinates);
  }
  if (options.narrow) {
    addDracoAttribute<std::uint8_t>(cloud, generic, draco::DT_UINT8, 1, scan[kIntensity]);
    addDracoAttribute<std::uint8_t>(cloud, generic, draco::DT_UINT8, 1, scan[kLabel]);
    addDracoAttribute<std::uint16_t>(cloud, generic, draco::DT_UINT16, 1, scan[kInstance]);
    addDracoAttribute<std::uint8_t>(cloud, generic, draco::DT_UINT8, 1, scan[kRing]);
    addDracoAttribute<std::uint16_t>(cloud, generic, draco::DT_UINT16, 1, scan[kColumn]);
  } else {
    addDracoAttribute<std::uint32_t>(cloud, generic, draco::DT_UINT32, 1, scan[kIntensity]);
    addDracoAttribute<std::uint32_t>(cloud, generic, draco::DT_UINT32, 1, scan[kLabel]);
    addDracoAttribute<std::uint32_t>(cloud, generic, draco::DT_UINT32, 1, scan[kInstance]);
    addDracoAttribute<std::uint32_t>(cloud, generic, draco::DT_UINT32, 1, scan[kRing]);
    addDracoAttribute<std::uint32_t>(cloud, generic, draco::DT_UINT32, 1, scan[kColumn]);
    std::vector<std::uint32_t> bits(scan.size());
    std::memcpy(bits.data(), scan[kTime].data(), scan.size() * sizeof(float));
    addDracoAttribute<std::uint32_t>(cloud, generic, draco::DT_UINT32, 1, bits);
  }
  if (options.deduplicate) {
    cloud.DeduplicateAttributeValues();
    cloud.DeduplicatePointIds();
  }
  draco::ExpertEncoder encoder(cloud);
  encoder.SetEncodingMethod(options.method);
  encoder.SetSpeedOptions(7, 7);
  encoder.SetUseBuiltInAttributeCompression(options.entropy);
  if (!options.integers) {
    const float low[3] = {-130, -130, -130};
    encoder.SetAttributeExplicitQuantization(position, 18, 3, low,
                                             static_cast<float>(kBareDracoStep * ((1 << 18) - 1)));
  }
  if (!encoder.EncodeToBuffer(&buffer).ok()) throw Error("Draco refuses");
  return {buffer.data(), buffer.size()};
}

}  // namespace scanmill
