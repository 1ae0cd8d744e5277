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
  for (const std::uint32_t number : connected.numbers.front()) {
    const Vec3d size = connected.boxes[number].high - connected.boxes[number].low;
    sizes_.push_back(std::max({size.x, size.y, size.z}));
  }
}

// Returns the base colour at the triangle's centre: the part's colour times that of its texture.
Rgb PartTraits::colorAt(const Triangle& triangle) const {
  std::array<double, 3> linear{part_.color[0], part_.color[1], part_.color[2]};
  const Texture* const texture = part_.fileMaterial.texture.get();
  if (part_.fileMaterial.textured && texture != nullptr && !part_.uvs.empty()) {
    Vec2f centre{0, 0};
    for (const std::uint32_t corner : triangle) {
      centre.x += part_.uvs[corner].x / 3;
      centre.y += part_.uvs[corner].y / 3;
    }
    const std::uint8_t* const texel = texture->texel(centre.x, centre.y);
    for (std::size_t c = 0; c < 3; ++c) linear[c] *= linearOf(texel[c] / 255.0);
  }
  Rgb color{};
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(srgbOf(linear[c]), 0.0, 1.0)));
  }
  return color;
}

TriangleTraits PartTraits::at(std::size_t triangle) const {
  const Triangle& corners = part_.triangles[triangle];
  TriangleTraits traits;
  traits.color = colorAt(corners);
  for (const std::uint32_t corner : corners) traits.middle += Vec3d(part_.positions[corner]) * (1.0 / 3);
  traits.height = traits.middle.z - frame_.lowest;
  traits.middle += frame_.origin;
  const Vec3d a(part_.positions[corners[0]]);
  const Vec3d normal = cross(Vec3d(part_.positions[corners[1]]) - a, Vec3d(part_.positions[corners[2]]) - a);
  traits.slope = std::atan2(std::hypot(normal.x, normal.y), std::fabs(normal.z));
  if (!sizes_.empty()) traits.size = sizes_[triangle];
  return traits;
}

}  // namespace scanmill
