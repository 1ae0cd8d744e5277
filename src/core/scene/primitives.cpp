#include "scene/primitives.h"

#include <algorithm>
#include <array>
#include <vector>

namespace scanmill {
namespace {

// Appends vertices and triangles, given in the primitive's frame. If `meshFromShape` mirrors, triangles are flipped, so
// that their normals still point outwards.
class Appender {
 public:
  Appender(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape)
      : mesh_(mesh),
        surface_(surface),
        meshFromShape_(meshFromShape),
        mirrored_(determinant(meshFromShape.linear) < 0) {}
  ~Appender() {
    if (!mesh_.uvs.empty()) mesh_.uvs.resize(mesh_.positions.size());
  }
  Appender& operator=(Appender&&) = delete;  // neither copied nor moved

  std::uint32_t vertex(const Vec3d& p) {
    mesh_.positions.push_back(Vec3f(meshFromShape_ * p));
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh_.triangles.push_back(mirrored_ ? Triangle{a, c, b} : Triangle{a, b, c});
    mesh_.surfaceOf.push_back(surface_);
  }
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }

 private:
  Mesh& mesh_;
  std::uint16_t surface_;
  Affine meshFromShape_;
  bool mirrored_;
};

struct ProfilePoint {
  double radius;  // m
  double z;       // m
};

// Appends a closed solid of revolution about z. The profile starts at the bottom on the axis and ends at the top on the
// axis. Each profile point on the axis becomes a single vertex, so that no triangle is degenerate and no edge is open.
void appendRevolution(Appender& appender, const std::vector<ProfilePoint>& profile, int segments) {
  const auto sides = static_cast<std::uint32_t>(std::max(segments, 3));
  struct Ring {
    std::uint32_t first;  // index of the ring's first vertex
    bool onAxis;          // true: the ring is a single vertex
    std::uint32_t vertex(std::uint32_t k, std::uint32_t count) const { return onAxis ? first : first + k % count; }
  };
  std::vector<Ring> rings;
  for (const ProfilePoint& p : profile) {
    const bool onAxis = !(p.radius > 0);
    rings.push_back({appender.vertex({onAxis ? 0 : p.radius, 0, p.z}), onAxis});
    for (std::uint32_t k = 1; k < sides && !onAxis; ++k) {
      const double angle = 2 * kPi * k / sides;
      appender.vertex({p.radius * std::cos(angle), p.radius * std::sin(angle), p.z});
    }
  }
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    const Ring& low = rings[i];
    const Ring& high = rings[i + 1];
    for (std::uint32_t k = 0; k < sides; ++k) {
      if (!low.onAxis) appender.triangle(low.vertex(k, sides), low.vertex(k + 1, sides), high.vertex(k, sides));
      if (!high.onAxis) appender.triangle(low.vertex(k + 1, sides), high.vertex(k + 1, sides), high.vertex(k, sides));
    }
  }
}

}  // namespace

void appendBox(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, const Vec3d& size) {
  Appender appender(mesh, surface, meshFromShape);
  std::uint32_t
      v[8];  // corner i has the greater x if bit 0 of i is set, the greater y for bit 1, the greater z for bit 2
  for (int i = 0; i < 8; ++i) {
    v[i] =
        appender.vertex({size.x * (i & 1 ? 0.5 : -0.5), size.y * (i & 2 ? 0.5 : -0.5), size.z * (i & 4 ? 0.5 : -0.5)});
  }
  constexpr std::array<std::array<std::size_t, 4>, 6> kSides{{{0, 2, 3, 1},    // z low
                                                              {4, 5, 7, 6},    // z high
                                                              {0, 1, 5, 4},    // y low
                                                              {2, 6, 7, 3},    // y high
                                                              {0, 4, 6, 2},    // x low
                                                              {1, 3, 7, 5}}};  // x high
  for (const auto& [a, b, c, d] : kSides) appender.quad(v[a], v[b], v[c], v[d]);
}

void appendSphere(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double radius, int segments) {
  appendCapsule(mesh, surface, meshFromShape, radius, 0, segments);
}

void appendCylinder(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double bottomRadius,
                    double topRadius, double height, int segments) {
  Appender appender(mesh, surface, meshFromShape);
  std::vector<ProfilePoint> profile{{0, -height / 2}};
  if (bottomRadius > 0) profile.push_back({bottomRadius, -height / 2});
  if (topRadius > 0) profile.push_back({topRadius, height / 2});
  profile.push_back({0, height / 2});
  appendRevolution(appender, profile, segments);
}

void appendCapsule(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double radius, double height,
                   int segments) {
  Appender appender(mesh, surface, meshFromShape);
  const int stackCount = std::max(segments / 4, 1);  // number of stacks of each half sphere
  std::vector<ProfilePoint> profile{{0, -height / 2 - radius}};
  for (int k = 1; k <= stackCount; ++k) {
    const double latitude = kPi / 2 * (k - stackCount) / stackCount;
    profile.push_back({radius * std::cos(latitude), radius * std::sin(latitude) - height / 2});
  }
  for (int k = height > 0 ? 0 : 1; k < stackCount; ++k) {
    const double latitude = kPi / 2 * k / stackCount;
    profile.push_back({radius * std::cos(latitude), radius * std::sin(latitude) + height / 2});
  }
  profile.push_back({0, height / 2 + radius});
  appendRevolution(appender, profile, segments);
}

void appendPlane(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double sizeX, double sizeY,
                 int cells) {
  Appender appender(mesh, surface, meshFromShape);
  const auto cellCount = static_cast<std::uint32_t>(std::max(cells, 1));
  const auto firstVertex = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t row = 0; row <= cellCount; ++row) {
    for (std::uint32_t column = 0; column <= cellCount; ++column) {
      appender.vertex({sizeX * (double(column) / cellCount - 0.5), sizeY * (double(row) / cellCount - 0.5), 0});
    }
  }
  for (std::uint32_t row = 0; row < cellCount; ++row) {
    for (std::uint32_t column = 0; column < cellCount; ++column) {
      const std::uint32_t corner = firstVertex + row * (cellCount + 1) + column;
      appender.quad(corner, corner + 1, corner + cellCount + 2, corner + cellCount + 1);
    }
  }
}

void appendQuad(Mesh& mesh, std::uint16_t surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  Appender appender(mesh, surface, {});
  const std::uint32_t v[4] = {appender.vertex(a), appender.vertex(b), appender.vertex(c), appender.vertex(d)};
  appender.quad(v[0], v[1], v[2], v[3]);
}

}  // namespace scanmill
