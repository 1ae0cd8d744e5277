// Defines SIMD lanes with Google Highway, and intersects the lines of many particles with the triangles of their lists.
// Included only by march_stream.h, so that no other file uses Highway's types, and once for each instruction set: see
// march_cpu.cpp.
#if defined(SCANMILL_MARCH_TRIANGLES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SCANMILL_MARCH_TRIANGLES_H
#undef SCANMILL_MARCH_TRIANGLES_H
#else
#define SCANMILL_MARCH_TRIANGLES_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "methods/field/distance_field.h"
#include "methods/field/march_rule.h"
#include "methods/world/world.h"

HWY_BEFORE_NAMESPACE();
namespace scanmill::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::ScalableTag<float> kFloats;
constexpr hn::ScalableTag<std::uint32_t> kWords;
constexpr hn::ScalableTag<std::int32_t> kInts;
using Floats = hn::Vec<decltype(kFloats)>;
using Words = hn::Vec<decltype(kWords)>;
using Ints = hn::Vec<decltype(kInts)>;
using Mask = hn::Mask<decltype(kFloats)>;

constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
static_assert(kLanes <= 16);
using LaneFloats = float[kLanes];
using LaneWords = std::uint32_t[kLanes];

// A set of lanes, one bit per lane. A loop takes firstOf(lanes), and removes this lane by `lanes &= lanes - 1`.
using LaneBits = std::uint32_t;

inline LaneBits bitsOf(Mask mask) {
  std::uint8_t bytes[8] = {};  // Highway may write up to 8 bytes
  hn::StoreMaskBits(kFloats, mask, bytes);
  std::uint16_t bits = 0;
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

inline std::size_t firstOf(LaneBits lanes) {
  return static_cast<std::size_t>(std::countr_zero(lanes));
}

inline Floats dotOf(const Floats (&a)[3], const Floats (&b)[3]) {
  return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
}

// The section of a particle's line that is tested: from `low` to `high` along d, counted from the point x y z (all in
// m, relative to the world's origin). The section is stored in two records of four floats, LineStart and LineCourse.
struct LineStart {
  float x, y, z, low;
};
struct LineCourse {
  float dx, dy, dz, high;
};

// A line's hit on a triangle, at the distance numerator / denominator (m) from the point x y z of LineStart.
struct LineHit {
  float numerator, denominator;  // denominator > 0: the line hits the triangle
  std::uint32_t triangle;
};

// Intersects lines with the triangles in the lists of corners, kLanes pairs of a line and a triangle at a time. Lists
// differ in length, so the pairs of all lines are collected first. Lists are prefetched: they are scattered in memory.
class ListIntersector {
 public:
  static constexpr std::size_t kLines = 16 * kLanes;

  ListIntersector(const DistanceField& field, const TriangleBlock& triangles) : field_(field), triangles_(triangles) {}

  // The caller sets `start`, `course` and `tie` (m) of each added line. A hit replaces another if nearer by over `tie`.
  HWY_ALIGN_MAX LineStart start[kLines] = {};
  HWY_ALIGN_MAX LineCourse course[kLines] = {};
  HWY_ALIGN_MAX float tie[kLines] = {};

  void add(std::size_t line, std::uint32_t corner) {
    queued_.push_back({static_cast<std::uint32_t>(line), corner});
    __builtin_prefetch(&field_.triangleOrList[corner]);
    nearest[line].denominator = 0;
  }

  // Intersects each added line with the triangles that its corner lists, sets `nearest`, and removes the added lines.
  void intersect();

  LineHit nearest[kLines] = {};

 private:
  struct QueuedLine {
    std::uint32_t line;
    std::uint32_t cornerOrList;  // the corner, which intersect() replaces by the start of the corner's list
  };
  struct Pair {
    std::uint32_t line, triangle;
  };

  void intersectPairs(const Pair* pairs);

  const DistanceField& field_;
  const TriangleBlock& triangles_;
  std::vector<QueuedLine> queued_;
  std::vector<Pair> pairs_;
};

inline void ListIntersector::intersect() {
  std::size_t lists = 0;  // number of lines that have a list; these move to the front of queued_
  for (const QueuedLine& queued : queued_) {
    const std::uint32_t list = field_.triangleOrList[queued.cornerOrList];
    if (list == kNoTriangle) continue;
    queued_[lists++] = {queued.line, list};
    __builtin_prefetch(&field_.lists[list]);
  }
  std::size_t count = 0;
  for (std::size_t k = 0; k < lists; ++k) {
    const std::uint32_t line = queued_[k].line;
    const std::uint32_t* entry = &field_.lists[queued_[k].cornerOrList];
    for (bool isLast = false; !isLast; ++entry) {
      isLast = *entry >= kLastOfList;
      if (count + kLanes >= pairs_.size()) pairs_.resize(2 * count + kLines);
      pairs_[count++] = {line, *entry & ~kLastOfList};
    }
  }
  queued_.clear();
  // Repeats the last pair to fill the last lanes. Repeats change nothing, because only a nearer hit replaces a hit.
  for (; count % kLanes != 0; ++count) pairs_[count] = pairs_[count - 1];
  for (std::size_t k = 0; k < count; k += kLanes) intersectPairs(pairs_.data() + k);
}

// Sets `product` to the cross product of a and b, lane by lane.
inline void crossOf(const Floats (&a)[3], const Floats (&b)[3], Floats (&product)[3]) {
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const int m = (k + 2) % 3;
    product[k] = hn::Sub(hn::Mul(a[l], b[m]), hn::Mul(a[m], b[l]));
  }
}

// Returns the four floats at address(k), then the four at address(k + 4), and so on while the argument is below kLanes.
template <class Address>
HWY_INLINE Floats loadRow(const Address& address, std::size_t k) {
  constexpr hn::FixedTag<float, 4> four;
  constexpr hn::FixedTag<float, kLanes / 2> half;
  const auto load = [&](std::size_t number) { return hn::LoadU(four, address(number)); };
  static_assert(kLanes == 4 || kLanes == 8 || kLanes == 16);
  if constexpr (kLanes == 4) {
    return load(k);
  } else if constexpr (kLanes == 8) {
    return hn::Combine(kFloats, load(k + 4), load(k));
  } else {
    return hn::Combine(kFloats, hn::Combine(half, load(k + 12), load(k + 8)), hn::Combine(half, load(k + 4), load(k)));
  }
}

// Loads the four floats at address(k) into lane k of x, y, z and w, for each k below kLanes.
template <class Address>
HWY_INLINE void loadTransposed(const Address& address, Floats& x, Floats& y, Floats& z, Floats& w) {
  const Floats row[4] = {loadRow(address, 0), loadRow(address, 1), loadRow(address, 2), loadRow(address, 3)};
  const Floats xyEven = hn::InterleaveLower(kFloats, row[0], row[2]);
  const Floats xyOdd = hn::InterleaveLower(kFloats, row[1], row[3]);
  const Floats zwEven = hn::InterleaveUpper(kFloats, row[0], row[2]);
  const Floats zwOdd = hn::InterleaveUpper(kFloats, row[1], row[3]);
  x = hn::InterleaveLower(kFloats, xyEven, xyOdd);
  y = hn::InterleaveUpper(kFloats, xyEven, xyOdd);
  z = hn::InterleaveLower(kFloats, zwEven, zwOdd);
  w = hn::InterleaveUpper(kFloats, zwEven, zwOdd);
}

// Intersects kLanes pairs of a line and a triangle by the algorithm of Moeller and Trumbore 1997, without the division:
// the barycentric coordinates u and v, and the distance t, are multiplied by `denominator`. Updates `nearest`.
inline void ListIntersector::intersectPairs(const Pair* pairs) {
  const Vec3f* vertices = triangles_.vertices.data();
  const Triangle* triangles = triangles_.corners.data();
  // Reads 16 bytes per vertex; the array has one more vertex as padding.
  const auto vertex = [&](int c) {
    return [=](std::size_t k) { return &vertices[triangles[pairs[k].triangle][c]].x; };
  };
  Floats a[3], ab[3], ac[3], s[3], d[3], low, high, padding;
  loadTransposed(vertex(0), a[0], a[1], a[2], padding);
  loadTransposed(vertex(1), ab[0], ab[1], ab[2], padding);
  loadTransposed(vertex(2), ac[0], ac[1], ac[2], padding);
  loadTransposed([&](std::size_t k) { return &start[pairs[k].line].x; }, s[0], s[1], s[2], low);
  loadTransposed([&](std::size_t k) { return &course[pairs[k].line].dx; }, d[0], d[1], d[2], high);
  for (int k = 0; k < 3; ++k) {
    ab[k] = hn::Sub(ab[k], a[k]);
    ac[k] = hn::Sub(ac[k], a[k]);
    s[k] = hn::Sub(s[k], a[k]);
  }
  Floats p[3], q[3];
  crossOf(d, ac, p);
  crossOf(s, ab, q);
  const Floats determinant = dotOf(ab, p);
  const Mask backFacing = hn::Lt(determinant, hn::Zero(kFloats));
  const Floats sign = hn::IfThenElse(backFacing, hn::Set(kFloats, -1.0f), hn::Set(kFloats, 1.0f));
  const Floats denominator = hn::Mul(determinant, sign);
  const Floats u = hn::Mul(dotOf(s, p), sign);
  const Floats v = hn::Mul(dotOf(d, q), sign);
  const Floats t = hn::Mul(dotOf(ac, q), sign);
  const Floats margin = hn::Mul(denominator, hn::Set(kFloats, kTriangleMargin));
  const Floats minusMargin = hn::Neg(margin);
  const Mask insideTwoEdges = hn::And(hn::Ge(u, minusMargin), hn::Ge(v, minusMargin));
  const Mask insideThirdEdge =
      hn::And(hn::Le(hn::Add(u, v), hn::Add(denominator, margin)), hn::Gt(denominator, hn::Zero(kFloats)));
  const Mask inSection = hn::And(hn::Ge(t, hn::Mul(low, denominator)), hn::Le(t, hn::Mul(high, denominator)));
  LaneBits hits = bitsOf(hn::And(hn::And(insideTwoEdges, insideThirdEdge), inSection));
  if (hits == 0) return;
  HWY_ALIGN_MAX LaneFloats numerators;
  HWY_ALIGN_MAX LaneFloats denominators;
  hn::Store(t, kFloats, numerators);
  hn::Store(denominator, kFloats, denominators);
  for (; hits != 0; hits &= hits - 1) {
    const std::size_t k = firstOf(hits);
    const LineHit hit{numerators[k], denominators[k], pairs[k].triangle};
    LineHit& nearestSoFar = nearest[pairs[k].line];
    const float tieMargin = tie[pairs[k].line] * nearestSoFar.denominator;
    if (!(nearestSoFar.denominator > 0) ||
        hit.numerator * nearestSoFar.denominator < (nearestSoFar.numerator - tieMargin) * hit.denominator) {
      nearestSoFar = hit;
    }
  }
}

}  // namespace scanmill::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
