#include "scene/primitives.h"

#include <algorithm>
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
  Appender(const Appender&) = delete;
  Appender& operator=(const Appender&) = delete;

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
  double radius;
  double z;
};

// Appends a closed solid of revolution about z. The profile starts at the bottom on the axis and ends at the top on the
// axis. Each profile point on the axis becomes a single vertex, so that no triangle is degenerate and no edge is open.
void appendRevolution(Appender& out, const std::vector<ProfilePoint>& profile, int segments) {
  const auto n = static_cast<std::uint32_t>(std::max(segments, 3));
  struct Ring {
    std::uint32_t first;
    bool onAxis;
    std::uint32_t at(std::uint32_t k, std::uint32_t count) const { return onAxis ? first : first + k % count; }
  };
  std::vector<Ring> rings;
  for (const ProfilePoint& p : profile) {
    const bool onAxis = !(p.radius > 0);
    rings.push_back({out.vertex({onAxis ? 0 : p.radius, 0, p.z}), onAxis});
    for (std::uint32_t k = 1; k < n && !onAxis; ++k) {
      const double angle = 2 * kPi * k / n;
      out.vertex({p.radius * std::cos(angle), p.radius * std::sin(angle), p.z});
    }
  }
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    const Ring& low = rings[i];
    const Ring& high = rings[i + 1];
    for (std::uint32_t k = 0; k < n; ++k) {
      if (!low.onAxis) out.triangle(low.at(k, n), low.at(k + 1, n), high.at(k, n));
      if (!high.onAxis) out.triangle(low.at(k + 1, n), high.at(k + 1, n), high.at(k, n));
    }
  }
}

}  // namespace

void appendBox(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, const Vec3d& size) {
  Appender out(mesh, surface, meshFromShape);
  std::uint32_t v[8];
  for (int i = 0; i < 8; ++i) {
    v[i] = out.vertex({size.x * (i & 1 ? 0.5 : -0.5), size.y * (i & 2 ? 0.5 : -0.5), size.z * (i & 4 ? 0.5 : -0.5)});
  }
  out.quad(v[0], v[2], v[3], v[1]);  // z low
  out.quad(v[4], v[5], v[7], v[6]);  // z high
  out.quad(v[0], v[1], v[5], v[4]);  // y low
  out.quad(v[2], v[6], v[7], v[3]);  // y high
  out.quad(v[0], v[4], v[6], v[2]);  // x low
  out.quad(v[1], v[3], v[7], v[5]);  // x high
}

void appendSphere(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double radius, int segments) {
  appendCapsule(mesh, surface, meshFromShape, radius, 0, segments);
}

void appendCylinder(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double bottomRadius,
                    double topRadius, double height, int segments) {
  Appender out(mesh, surface, meshFromShape);
  std::vector<ProfilePoint> profile{{0, -height / 2}};
  if (bottomRadius > 0) profile.push_back({bottomRadius, -height / 2});
  if (topRadius > 0) profile.push_back({topRadius, height / 2});
  profile.push_back({0, height / 2});
  appendRevolution(out, profile, segments);
}

void appendCapsule(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double radius, double height,
                   int segments) {
  Appender out(mesh, surface, meshFromShape);
  const int stacks = std::max(segments / 4, 1);  // number of stacks of each half sphere
  std::vector<ProfilePoint> profile{{0, -height / 2 - radius}};
  for (int i = 1; i <= stacks; ++i) {
    const double latitude = kPi / 2 * (i - stacks) / stacks;
    profile.push_back({radius * std::cos(latitude), radius * std::sin(latitude) - height / 2});
  }
  for (int i = height > 0 ? 0 : 1; i < stacks; ++i) {
    const double latitude = kPi / 2 * i / stacks;
    profile.push_back({radius * std::cos(latitude), radius * std::sin(latitude) + height / 2});
  }
  profile.push_back({0, height / 2 + radius});
  appendRevolution(out, profile, segments);
}

void appendPlane(Mesh& mesh, std::uint16_t surface, const Affine& meshFromShape, double sizeX, double sizeY,
                 int cells) {
  Appender out(mesh, surface, meshFromShape);
  const auto n = static_cast<std::uint32_t>(std::max(cells, 1));
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      out.vertex({sizeX * (double(i) / n - 0.5), sizeY * (double(j) / n - 0.5), 0});
    }
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t v = first + j * (n + 1) + i;
      out.quad(v, v + 1, v + n + 2, v + n + 1);
    }
  }
}

void appendQuad(Mesh& mesh, std::uint16_t surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  Appender out(mesh, surface, {});
  const std::uint32_t v[4] = {out.vertex(a), out.vertex(b), out.vertex(c), out.vertex(d)};
  out.quad(v[0], v[1], v[2], v[3]);
}

}  // namespace scanmill
