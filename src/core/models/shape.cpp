#include <algorithm>
#include <cmath>

#include "models/models.h"
#include "scene/primitives.h"

namespace scanmill::models {

Draw::Draw(std::uint64_t seed, Kind kind, std::uint32_t object) {
  address_.seed = seed;
  address_.scene = static_cast<std::uint32_t>(kind);
  address_.beam = object;
  address_.purpose = Purpose::Street;
}

double Draw::next() {
  if (used_ == block_.size()) {
    block_ = randomBlock(address_);
    ++address_.frame;
    used_ = 0;
  }
  return uniform(block_[used_++]);
}

Vec3d Draw::direction() {
  const double z = in(-1, 1);
  const double angle = in(0, 2 * kPi);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

std::vector<double> steps(double from, double to, double step) {
  std::vector<double> values;
  for (double value = from; value < to; value += step) values.push_back(value);
  return values;
}

double smooth(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Affine at(const Vec3d& position) {
  return {{}, position};
}

Affine at(const Vec3d& position, double yaw) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}, position};
}

namespace {

Vec3d perpendicular(const Vec3d& d) {
  return normalized(cross(d, std::abs(d.z) < 0.8 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}));
}

}  // namespace

Affine along(const Vec3d& position, const Vec3d& direction) {
  const Vec3d z = normalized(direction);
  const Vec3d x = perpendicular(z);
  return {{x, cross(z, x), z}, position};
}

Shape::Shape(SceneBuilder& builder, std::string name) : builder_(builder) {
  mesh.name = std::move(name);
}

SurfaceIndex Shape::surface(std::string_view className, std::string_view material) {
  std::string key = std::string(className) + '/' + std::string(material);
  for (const auto& [name, index] : surfaces_) {
    if (name == key) return index;
  }
  const auto index = static_cast<SurfaceIndex>(mesh.surfaces.size());
  mesh.surfaces.push_back(builder_.surface(className, material));
  mesh.surfaces.back().node = mesh.name;
  surfaces_.emplace_back(std::move(key), index);
  return index;
}

std::uint32_t Shape::vertex(const Vec3d& p) {
  mesh.positions.push_back(Vec3f(frame * p));
  return static_cast<std::uint32_t>(mesh.positions.size() - 1);
}

void Shape::triangle(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const std::uint32_t i = vertex(a);
  vertex(b);
  vertex(c);
  mesh.triangles.push_back({i, i + 1, i + 2});
  mesh.surfaceOf.push_back(surface);
}

void Shape::quad(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const std::uint32_t i = vertex(a);
  vertex(b);
  vertex(c);
  vertex(d);
  mesh.triangles.insert(mesh.triangles.end(), {{i, i + 1, i + 2}, {i, i + 2, i + 3}});
  mesh.surfaceOf.insert(mesh.surfaceOf.end(), 2, surface);
}

void Shape::box(SurfaceIndex surface, const Vec3d& center, const Vec3d& size) {
  appendBox(mesh, surface, frame * at(center), size);
}

void Shape::boxAt(SurfaceIndex surface, const Affine& place, const Vec3d& size) {
  appendBox(mesh, surface, frame * place, size);
}

void Shape::ball(SurfaceIndex surface, const Vec3d& center, const Vec3d& radii, int segments) {
  appendSphere(mesh, surface, frame * Affine{Mat3::scale(radii), center}, 1.0, segments);
}

void Shape::pipe(SurfaceIndex surface, const std::vector<Vec3d>& points, const std::vector<double>& radii,
                 int segments) {
  std::vector<std::vector<Vec3d>> rows;
  const std::size_t n = points.size();
  const auto ringOf = [&](const Vec3d& center, const Vec3d& u, const Vec3d& v, double radius) {
    std::vector<Vec3d> ring;
    for (int k = 0; k < segments; ++k) {
      const double angle = 2 * kPi * k / segments;
      ring.push_back(center + u * (radius * std::cos(angle)) + v * (radius * std::sin(angle)));
    }
    return ring;
  };
  Vec3d u = perpendicular(normalized(points[1] - points[0]));
  rows.emplace_back(segments, points.front());
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d d = normalized(points[std::min(i + 1, n - 1)] - points[i == 0 ? 0 : i - 1]);
    u = normalized(u - d * dot(u, d));  // parallel transport keeps the pipe from twisting
    rows.push_back(ringOf(points[i], u, cross(d, u), radii[i]));
  }
  rows.emplace_back(segments, points.back());
  grid(rows, true, [&](int, int) { return surface; });
}

void Shape::tube(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double radiusA, double radiusB, int segments) {
  pipe(surface, {a, b}, {radiusA, radiusB}, segments);
}

void Shape::revolve(SurfaceIndex surface, const Affine& place, const std::vector<Point2>& profile, int segments,
                    bool closed) {
  std::vector<std::vector<Vec3d>> rows;
  for (const Point2& p : profile) {
    std::vector<Vec3d> ring;
    for (int k = 0; k < segments; ++k) {
      const double angle = 2 * kPi * k / segments;
      ring.push_back(place * Vec3d{p.x * std::cos(angle), p.x * std::sin(angle), p.y});
    }
    rows.push_back(std::move(ring));
  }
  if (closed) rows.push_back(rows.front());
  grid(rows, true, [&](int, int) { return surface; });
}

void Shape::torus(SurfaceIndex surface, const Affine& place, double radius, double thickness, int segments,
                  int around) {
  std::vector<Point2> profile;
  for (int k = 0; k < around; ++k) {
    const double angle = 2 * kPi * k / around;
    profile.push_back({radius + thickness * std::cos(angle), thickness * std::sin(angle)});
  }
  revolve(surface, place, profile, segments, true);
}

void Shape::prism(SurfaceIndex front, SurfaceIndex rim, const Affine& place, const std::vector<Point2>& polygon,
                  double thickness) {
  const std::size_t n = polygon.size();
  const auto low = [&](std::size_t i) { return place * Vec3d{polygon[i % n].x, polygon[i % n].y, 0}; };
  const auto high = [&](std::size_t i) { return place * Vec3d{polygon[i % n].x, polygon[i % n].y, thickness}; };
  for (std::size_t i = 0; i < n; ++i) quad(rim, low(i), low(i + 1), high(i + 1), high(i));
  for (std::size_t i = 1; i + 1 < n; ++i) {
    triangle(front, high(0), high(i), high(i + 1));
    triangle(rim, low(0), low(i + 1), low(i));
  }
}

void Shape::grid(const std::vector<std::vector<Vec3d>>& rows, bool wrap,
                 const std::function<SurfaceIndex(int, int)>& of) {
  const int columns = static_cast<int>(rows.front().size());
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const auto& row : rows) {
    for (const Vec3d& p : row) vertex(p);
  }
  const auto emit = [&](SurfaceIndex surface, const Triangle& t) {
    const Vec3f& a = mesh.positions[t[0]];
    const Vec3f& b = mesh.positions[t[1]];
    const Vec3f& c = mesh.positions[t[2]];
    if (a == b || b == c || c == a) return;
    mesh.triangles.push_back(t);
    mesh.surfaceOf.push_back(surface);
  };
  for (int r = 0; r + 1 < static_cast<int>(rows.size()); ++r) {
    for (int c = 0; c < (wrap ? columns : columns - 1); ++c) {
      const int next = (c + 1) % columns;
      const std::uint32_t p00 = first + r * columns + c;
      const std::uint32_t p01 = first + r * columns + next;
      const std::uint32_t p10 = first + (r + 1) * columns + c;
      const std::uint32_t p11 = first + (r + 1) * columns + next;
      const SurfaceIndex surface = of(r, c);
      emit(surface, {p00, p01, p11});
      emit(surface, {p00, p11, p10});
    }
  }
}

Model Shape::finish() {
  Model model;
  model.bounds = mesh.bounds();
  model.mesh = builder_.addMesh(std::move(mesh));
  return model;
}

}  // namespace scanmill::models
