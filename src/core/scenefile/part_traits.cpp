#include <algorithm>
#include <cmath>
#include <cstdint>

#include "images/srgb.h"
#include "scenefile/connected_parts.h"
#include "scenefile/labelling.h"

namespace scanmill {

PartTraits::PartTraits(const AssetPart& part, const PartFrame& frame, bool withSizes) : part_(part), frame_(frame) {
  if (!withSizes) return;
  const ConnectedParts connected = connect({&part});
  for (const std::uint32_t number : connected.of.front()) {
    const Vec3d size = connected.boxes[number].high - connected.boxes[number].low;
    sizes_.push_back(std::max({size.x, size.y, size.z}));
  }
}

Rgb PartTraits::colorAt(const Triangle& triangle) const {
  std::array<double, 3> linear{part_.color[0], part_.color[1], part_.color[2]};
  const Texture* const texture = part_.fileMaterial.texture.get();
  if (part_.fileMaterial.textured && texture != nullptr && !part_.uvs.empty()) {
    Vec2f uv{0, 0};
    for (const std::uint32_t corner : triangle) {
      uv.x += part_.uvs[corner].x / 3;
      uv.y += part_.uvs[corner].y / 3;
    }
    const std::uint8_t* const texel = texture->texel(uv.x, uv.y);
    for (std::size_t c = 0; c < 3; ++c) linear[c] *= linearOf(texel[c] / 255.0);
  }
  Rgb color{};
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(srgbOf(linear[c]), 0.0, 1.0)));
  }
  return color;
}

TriangleTraits PartTraits::at(std::size_t triangle) const {
  const Triangle& t = part_.triangles[triangle];
  TriangleTraits traits;
  traits.color = colorAt(t);
  for (const std::uint32_t corner : t) traits.middle = traits.middle + Vec3d(part_.positions[corner]) * (1.0 / 3);
  traits.height = traits.middle.z - frame_.lowest;
  traits.middle = traits.middle + frame_.origin;
  const Vec3d a(part_.positions[t[0]]);
  const Vec3d normal = cross(Vec3d(part_.positions[t[1]]) - a, Vec3d(part_.positions[t[2]]) - a);
  traits.slope = std::atan2(std::hypot(normal.x, normal.y), std::fabs(normal.z));
  if (!sizes_.empty()) traits.size = sizes_[triangle];
  return traits;
}

}  // namespace scanmill
