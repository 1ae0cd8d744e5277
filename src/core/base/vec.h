#pragma once

// Vectors, rotations and transforms. Frames are right-handed, in metres and radians; x forward, y left, z up (REP 103).
// This header is installed because scan/scan.h includes it.
//
//   const Pose worldFromSensor{fromYawPitchRoll(radians(90), 0, 0), {0, 0, 1.9}};
//   const Vec3d point = worldFromSensor * Vec3d{10, 0, 0};  // (0, 10, 1.9)

#include <algorithm>
#include <array>
#include <cmath>

namespace scanmill {

template <class T>
struct Vec3 {
  T x{};
  T y{};
  T z{};

  constexpr Vec3 operator+(const Vec3& o) const { return {x + o.x, y + o.y, z + o.z}; }
  constexpr Vec3 operator-(const Vec3& o) const { return {x - o.x, y - o.y, z - o.z}; }
  constexpr Vec3 operator-() const { return {-x, -y, -z}; }
  constexpr Vec3 operator*(T s) const { return {x * s, y * s, z * s}; }
  constexpr Vec3& operator+=(const Vec3& o) { return *this = *this + o; }
  constexpr bool operator==(const Vec3&) const = default;

  template <class U>
  constexpr explicit operator Vec3<U>() const {
    return {static_cast<U>(x), static_cast<U>(y), static_cast<U>(z)};
  }
};

using Vec3d = Vec3<double>;
using Vec3f = Vec3<float>;

template <class T>
struct Vec2 {
  T x{};
  T y{};
  constexpr bool operator==(const Vec2&) const = default;
};

using Vec2d = Vec2<double>;
using Vec2f = Vec2<float>;

template <class T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class T>
T length(const Vec3<T>& v) {
  return std::sqrt(dot(v, v));
}

// Returns the unit vector of the same direction. The zero vector stays zero.
template <class T>
[[nodiscard]] Vec3<T> normalized(const Vec3<T>& v) {
  const T l = length(v);
  return l > T(0) ? v * (T(1) / l) : v;
}

template <class T>
bool isFinite(const Vec3<T>& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// A 3 x 3 matrix, stored as its three columns, which are the images of the axes x, y and z.
struct Mat3 {
  Vec3d x{1, 0, 0};
  Vec3d y{0, 1, 0};
  Vec3d z{0, 0, 1};

  constexpr Vec3d operator*(const Vec3d& v) const { return x * v.x + y * v.y + z * v.z; }
  constexpr Mat3 operator*(const Mat3& o) const { return {*this * o.x, *this * o.y, *this * o.z}; }
  constexpr bool operator==(const Mat3&) const = default;

  static constexpr Mat3 scale(const Vec3d& s) { return {{s.x, 0, 0}, {0, s.y, 0}, {0, 0, s.z}}; }
};

constexpr double determinant(const Mat3& m) {
  return dot(m.x, cross(m.y, m.z));
}

// True if the matrix is singular, exactly or nearly: it has no usable inverse.
inline bool isSingular(const Mat3& m) {
  const double volume = std::abs(determinant(m));
  return !(volume > 1e-12 * length(m.x) * length(m.y) * length(m.z)) || !std::isfinite(1.0 / volume);
}

[[nodiscard]] constexpr Mat3 transposed(const Mat3& m) {
  return {{m.x.x, m.y.x, m.z.x}, {m.x.y, m.y.y, m.z.y}, {m.x.z, m.y.z, m.z.z}};
}

// Returns the inverse matrix. The matrix must not be singular: check isSingular() first.
[[nodiscard]] constexpr Mat3 inverse(const Mat3& m) {
  const double s = 1.0 / determinant(m);
  return transposed({cross(m.y, m.z) * s, cross(m.z, m.x) * s, cross(m.x, m.y) * s});
}

// An affine transform: a point p becomes linear * p + translation.
struct Affine {
  Mat3 linear;
  Vec3d translation;

  constexpr Vec3d operator*(const Vec3d& point) const { return linear * point + translation; }
  constexpr Affine operator*(const Affine& o) const {
    return {linear * o.linear, linear * o.translation + translation};
  }
  constexpr bool operator==(const Affine&) const = default;
};

[[nodiscard]] constexpr Affine inverse(const Affine& a) {
  const Mat3 linear = inverse(a.linear);
  return {linear, -(linear * a.translation)};
}

// A unit quaternion, w first.
struct Quat {
  double w = 1;
  double x = 0;
  double y = 0;
  double z = 0;
  constexpr bool operator==(const Quat&) const = default;
};

constexpr Quat operator*(const Quat& a, const Quat& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

// Returns the rotation matrix of a unit quaternion.
constexpr Mat3 toMatrix(const Quat& q) {
  return {{1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.w * q.z), 2 * (q.x * q.z - q.w * q.y)},
          {2 * (q.x * q.y - q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z + q.w * q.x)},
          {2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)}};
}

// Returns the unit quaternion of the same rotation. The length of `q` must be above 0.
[[nodiscard]] inline Quat normalized(const Quat& q) {
  const double n = 1 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w * n, q.x * n, q.y * n, q.z * n};
}

// Returns the rotation of a matrix with orthonormal columns. Shepperd's method: finds the largest of the four
// components first, to avoid a division by a small number.
inline Quat fromMatrix(const Mat3& m) {
  const double trace = m.x.x + m.y.y + m.z.z;
  Quat q;
  if (trace >= m.x.x && trace >= m.y.y && trace >= m.z.z) {
    q = {1 + trace, m.y.z - m.z.y, m.z.x - m.x.z, m.x.y - m.y.x};
  } else if (m.x.x >= m.y.y && m.x.x >= m.z.z) {
    q = {m.y.z - m.z.y, 1 + m.x.x - m.y.y - m.z.z, m.x.y + m.y.x, m.z.x + m.x.z};
  } else if (m.y.y >= m.z.z) {
    q = {m.z.x - m.x.z, m.x.y + m.y.x, 1 + m.y.y - m.x.x - m.z.z, m.y.z + m.z.y};
  } else {
    q = {m.x.y - m.y.x, m.z.x + m.x.z, m.y.z + m.z.y, 1 + m.z.z - m.x.x - m.y.y};
  }
  return normalized(q);
}

// Returns the rotation Rz(yaw) * Ry(pitch) * Rx(roll); angles in rad. A positive pitch looks down (x forward, z up).
inline Quat fromYawPitchRoll(double yaw, double pitch, double roll) {
  const Quat qz{std::cos(yaw / 2), 0, 0, std::sin(yaw / 2)};
  const Quat qy{std::cos(pitch / 2), 0, std::sin(pitch / 2), 0};
  const Quat qx{std::cos(roll / 2), std::sin(roll / 2), 0, 0};
  return qz * qy * qx;
}

// Returns the yaw (rad) of the rotated x axis, the `yaw` of fromYawPitchRoll().
inline double headingOf(const Quat& q) {
  const Vec3d x = toMatrix(q).x;
  return std::atan2(x.y, x.x);
}

// Interpolates spherically along the shorter arc: t = 0 gives a, t = 1 gives b.
[[nodiscard]] inline Quat slerp(const Quat& a, Quat b, double t) {
  double cosine = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
  if (cosine < 0) {  // b and -b are the same rotation; take the nearer one
    b = {-b.w, -b.x, -b.y, -b.z};
    cosine = -cosine;
  }
  double wa = 1 - t;  // weights
  double wb = t;
  if (cosine < 1 - 1e-8) {
    const double angle = std::acos(cosine);
    wa = std::sin((1 - t) * angle) / std::sin(angle);
    wb = std::sin(t * angle) / std::sin(angle);
  }
  return normalized(Quat{wa * a.w + wb * b.w, wa * a.x + wb * b.x, wa * a.y + wb * b.y, wa * a.z + wb * b.z});
}

// The pose of a frame in another frame. `worldFromSensor` transforms points from the sensor's frame to the world's:
// world point = rotation * sensor point + translation (m).
struct Pose {
  Quat rotation;
  Vec3d translation;

  constexpr Vec3d operator*(const Vec3d& point) const { return toMatrix(rotation) * point + translation; }
  constexpr Pose operator*(const Pose& o) const { return {rotation * o.rotation, *this * o.translation}; }
  constexpr bool operator==(const Pose&) const = default;
};

[[nodiscard]] constexpr Pose inverse(const Pose& p) {
  const Quat r{p.rotation.w, -p.rotation.x, -p.rotation.y, -p.rotation.z};
  return {r, -(toMatrix(r) * p.translation)};
}

// Returns the pose between a (t = 0) and b (t = 1): rotations by slerp(), translations on a straight line.
inline Pose interpolate(const Pose& a, const Pose& b, double t) {
  return {slerp(a.rotation, b.rotation, t), a.translation + (b.translation - a.translation) * t};
}

constexpr Affine toAffine(const Pose& p) {
  return {toMatrix(p.rotation), p.translation};
}

// Returns the 4 x 4 matrix of a transform, for column vectors, row by row.
constexpr std::array<double, 16> matrixRows(const Affine& a) {
  const auto& [x, y, z] = a.linear;
  const Vec3d& t = a.translation;
  return {x.x, y.x, z.x, t.x, x.y, y.y, z.y, t.y, x.z, y.z, z.z, t.z, 0, 0, 0, 1};
}

// An axis-aligned box (m). A new box is empty; add() extends it.
struct Box {
  Vec3d low{INFINITY, INFINITY, INFINITY};
  Vec3d high{-INFINITY, -INFINITY, -INFINITY};

  bool empty() const { return !(low.x <= high.x); }
  void add(const Vec3d& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add(const Box& b) {
    if (!b.empty()) {
      add(b.low);
      add(b.high);
    }
  }
  Vec3d center() const { return (low + high) * 0.5; }
  // Returns the distance to a point; 0 inside of the box.
  double distanceTo(const Vec3d& p) const {
    const auto beyond = [](double x, double least, double most) { return std::max({least - x, x - most, 0.0}); };
    return length(Vec3d{beyond(p.x, low.x, high.x), beyond(p.y, low.y, high.y), beyond(p.z, low.z, high.z)});
  }
  // Returns the corners: bit 2 of a corner's index is set for high.x, bit 1 for high.y, and bit 0 for high.z.
  std::array<Vec3d, 8> corners() const {
    std::array<Vec3d, 8> all;
    for (unsigned i = 0; i < 8; ++i) all[i] = {i & 4 ? high.x : low.x, i & 2 ? high.y : low.y, i & 1 ? high.z : low.z};
    return all;
  }
  bool operator==(const Box&) const = default;
};

constexpr double kPi = 3.14159265358979323846;
constexpr double radians(double degrees) {
  return degrees * (kPi / 180.0);
}
constexpr double degrees(double radians) {
  return radians * (180.0 / kPi);
}
// Returns the equivalent angle from -kPi to kPi (rad).
inline double wrapped(double angle) {
  return std::remainder(angle, 2 * kPi);
}

}  // namespace scanmill
