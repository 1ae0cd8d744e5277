#include <algorithm>
#include <cmath>

#include "models/models.h"
#include "scene/primitives.h"

namespace scanmill::models {

Draw::Draw(std::uint64_t seed, Kind kind, std::int64_t object) {
  address_.seed = seed;
  address_.scene = static_cast<std::uint32_t>(kind);
  address_.beam = static_cast<std::uint32_t>(object);
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

std::vector<double> steps(double begin, double end, double step) {
  std::vector<double> values;
  for (double value = begin; value < end; value += step) values.push_back(value);
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

Affine sideView(const Vec3d& origin) {
  return {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, origin};
}

std::vector<Point2> regularPolygon(int corners, double radius, double firstAngle) {
  std::vector<Point2> polygon;
  for (int k = 0; k < corners; ++k) {
    const double angle = firstAngle + 2 * kPi * k / corners;
    polygon.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return polygon;
}

std::vector<Vec3d> levelRectangle(double z, double halfX, double halfY, double middleX) {
  return {{middleX - halfX, -halfY, z},
          {middleX + halfX, -halfY, z},
          {middleX + halfX, halfY, z},
          {middleX - halfX, halfY, z}};
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

void Shape::boxAt(SurfaceIndex surface, const Affine& pose, const Vec3d& size) {
  appendBox(mesh, surface, frame * pose, size);
}

void Shape::ball(SurfaceIndex surface, const Vec3d& center, const Vec3d& radii, int segments) {
  appendSphere(mesh, surface, frame * Affine{Mat3::scale(radii), center}, 1.0, segments);
}

void Shape::pipe(SurfaceIndex surface, const std::vector<Vec3d>& points, const std::vector<double>& radii,
                 int segments) {
  const std::size_t last = points.size() - 1;
  const Vec3d start = normalized(points[1] - points[0]);
  // u and v are unit vectors across the pipe. Parallel transport of u along the pipe avoids a twist of the pipe.
  Vec3d u = normalized(cross(start, std::abs(start.z) < 0.8 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}));
  // Each point of the line has a row of points around the pipe. An additional first row and last row repeat the line's
  // end points, which closes the pipe's ends.
  std::vector<std::vector<Vec3d>> rows{std::vector<Vec3d>(static_cast<std::size_t>(segments), points.front())};
  for (std::size_t i = 0; i <= last; ++i) {
    const Vec3d direction = normalized(points[std::min(i + 1, last)] - points[i == 0 ? 0 : i - 1]);
    u = normalized(u - direction * dot(u, direction));
    const Vec3d v = cross(direction, u);
    std::vector<Vec3d>& ring = rows.emplace_back();
    for (const Point2& p : regularPolygon(segments, radii[i])) ring.push_back(points[i] + u * p.x + v * p.y);
  }
  rows.emplace_back(segments, points.back());
  grid(rows, Loop::Closed, surface);
}

void Shape::pipe(SurfaceIndex surface, const std::vector<Vec3d>& points, double radius, int segments) {
  pipe(surface, points, std::vector<double>(points.size(), radius), segments);
}

void Shape::tube(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double radiusA, double radiusB, int segments) {
  pipe(surface, {a, b}, {radiusA, radiusB}, segments);
}

void Shape::rod(SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double radius, int segments) {
  pipe(surface, {a, b}, radius, segments);
}

void Shape::revolve(SurfaceIndex surface, const Affine& pose, const std::vector<Point2>& profile, int segments,
                    Loop loop) {
  std::vector<std::vector<Vec3d>> rows;
  for (const auto& [radius, z] : profile) {
    std::vector<Vec3d>& ring = rows.emplace_back();
    for (const Point2& p : regularPolygon(segments, radius)) ring.push_back(pose * Vec3d{p.x, p.y, z});
  }
  if (loop == Loop::Closed) rows.push_back(rows.front());
  grid(rows, Loop::Closed, surface);
}

void Shape::torus(SurfaceIndex surface, const Affine& pose, double radius, double thickness, int segments,
                  int corners) {
  std::vector<Point2> profile = regularPolygon(corners, thickness);
  for (Point2& p : profile) p.x += radius;
  revolve(surface, pose, profile, segments, Loop::Closed);
}

void Shape::prism(SurfaceIndex front, SurfaceIndex rim, const Affine& pose, const std::vector<Point2>& polygon,
                  double thickness) {
  const std::size_t n = polygon.size();
  const auto low = [&](std::size_t i) { return pose * Vec3d{polygon[i % n].x, polygon[i % n].y, 0}; };
  const auto high = [&](std::size_t i) { return pose * Vec3d{polygon[i % n].x, polygon[i % n].y, thickness}; };
  for (std::size_t i = 0; i < n; ++i) quad(rim, low(i), low(i + 1), high(i + 1), high(i));
  for (std::size_t i = 1; i + 1 < n; ++i) {
    triangle(front, high(0), high(i), high(i + 1));
    triangle(rim, low(0), low(i + 1), low(i));
  }
}

void Shape::grid(const std::vector<std::vector<Vec3d>>& rows, Loop loop,
                 const std::function<SurfaceIndex(int, int)>& surfaceAt) {
  const int columns = static_cast<int>(rows.front().size());
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const auto& row : rows) {
    for (const Vec3d& p : row) vertex(p);
  }
  const auto addUnlessFlat = [&](SurfaceIndex surface, const Triangle& t) {
    const Vec3f& a = mesh.positions[t[0]];
    const Vec3f& b = mesh.positions[t[1]];
    const Vec3f& c = mesh.positions[t[2]];
    if (a == b || b == c || c == a) return;
    mesh.triangles.push_back(t);
    mesh.surfaceOf.push_back(surface);
  };
  const auto vertexAt = [&](int row, int column) {
    return first + static_cast<std::uint32_t>(row * columns + column % columns);
  };
  for (int r = 0; r + 1 < static_cast<int>(rows.size()); ++r) {
    for (int c = 0; c < (loop == Loop::Closed ? columns : columns - 1); ++c) {
      const SurfaceIndex surface = surfaceAt(r, c);
      const std::uint32_t opposite = vertexAt(r + 1, c + 1);
      addUnlessFlat(surface, {vertexAt(r, c), vertexAt(r, c + 1), opposite});
      addUnlessFlat(surface, {vertexAt(r, c), opposite, vertexAt(r + 1, c)});
    }
  }
}

Model Shape::finish() {
  const Box bounds = mesh.bounds();
  return {builder_.addMesh(std::move(mesh)), bounds};
}

}  // namespace scanmill::models
