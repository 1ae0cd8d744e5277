#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "methods/field/brick.h"

namespace scanmill {

namespace {

constexpr float kHalf = kHalfBrick;
constexpr float kSlack = 1e-3f;  // voxels, for rounding
constexpr float kListed2 = kListed * kListed;

// Where lists are not wanted, so many triangles at most are held against their corners: with more, it is faster to let
// all corners search.
constexpr std::size_t kScattered = 1024;

// Triangles near more corners are held against them as lanes.
constexpr int kFewCubes = 8;

// More candidates of a block are worth searching among.
constexpr std::size_t kFewOfBlock = 128;

// 3 x 3 x 3 corners from a place on, x fastest.
struct alignas(64) Window {
  BrickMaker::Lanes x{}, y{}, z{};
  std::array<std::uint32_t, BrickMaker::kLanes> bit{}, corner{};
};

constexpr Window kWindow = [] {
  Window w;
  for (int i = 0; i < BrickMaker::kBlock; ++i) {
    const int row = i / 3;
    const int layer = row / 3;
    w.x[i] = static_cast<float>(i % 3);
    w.y[i] = static_cast<float>(row % 3);
    w.z[i] = static_cast<float>(layer);
    w.bit[i] = 1u << i;
    w.corner[i] = brick::cornerIndex(0, i);
  }
  return w;
}();

// Which corners of a window lie in a brick, that has so many left along each axis.
std::uint32_t inside(int x, int y, int z) {
  constexpr std::array<std::uint32_t, 4> kX{0, 0x1249249, 0x36DB6DB, 0x7FFFFFF};
  constexpr std::array<std::uint32_t, 4> kY{0, 0x1C0E07, 0xFC7E3F, 0x7FFFFFF};
  constexpr std::array<std::uint32_t, 4> kZ{0, 0x1FF, 0x3FFFF, 0x7FFFFFF};
  return kX[std::min(x, 3)] & kY[std::min(y, 3)] & kZ[std::min(z, 3)];
}

}  // namespace

// Holds a triangle against the corners that it is listed by, or that are within kListed of it where there are no lists.
void BrickMaker::scatter(const BrickPlace& place, std::uint32_t triangle) {
  const TriangleCorners corners = cornersAt(world_.baked, triangle, place);
  const auto& [a, b, c] = corners;
  const double reach = (lists_ ? kListedHalf : kListed) + 1e-4;
  const auto range = [=](double i, double j, double k) {
    const double low = std::max(std::min(std::min(i, j), k) - reach, -kBrickVoxels / 2.0);
    const double high = std::min(std::max(std::max(i, j), k) + reach, kBrickVoxels / 2.0);
    return Range{static_cast<int>(std::ceil(low + kHalf)), static_cast<int>(std::floor(high + kHalf))};
  };
  const Ranges near{range(a.x, b.x, c.x), range(a.y, b.y, c.y), range(a.z, b.z, c.z)};
  const auto& [xs, ys, zs] = near;
  if (xs.first > xs.last || ys.first > ys.last || zs.first > zs.last) return;
  const int count = (xs.last - xs.first + 1) * (ys.last - ys.first + 1) * (zs.last - zs.first + 1);
  if (lists_ && count <= kFewCubes) {
    scatterSmall(place, triangle, corners, near);
    return;
  }
  const Facet<float> facet = rounded(facetOf(a, b, c));
  const CubeTest cube = lists_ ? cubeTestOf(corners, kListedHalf) : CubeTest{};
  for (int z = zs.first; z <= zs.last; z += 3) {
    for (int y = ys.first; y <= ys.last; y += 3) {
      for (int x = xs.first; x <= xs.last; x += 3) {
        const Vec3f first{static_cast<float>(x) - kHalf, static_cast<float>(y) - kHalf, static_cast<float>(z) - kHalf};
        alignas(64) Lanes distance2;
        for (int i = 0; i < kLanes; ++i) {
          distance2[i] = facet.distance2(first.x + kWindow.x[i], first.y + kWindow.y[i], first.z + kWindow.z[i]);
        }
        std::uint32_t bits = 0;
        if (lists_) {
          for (int i = 0; i < kLanes; ++i) {
            const float excess = cube.excess(first.x + kWindow.x[i], first.y + kWindow.y[i], first.z + kWindow.z[i]);
            bits |= excess <= 0 ? kWindow.bit[i] : 0u;
          }
        } else {
          for (int i = 0; i < kLanes; ++i) bits |= distance2[i] <= kListed2 ? kWindow.bit[i] : 0u;
        }
        bits &= inside(kBrickCorners - x, kBrickCorners - y, kBrickCorners - z);
        const auto base = static_cast<std::uint32_t>((z * kBrickCorners + y) * kBrickCorners + x);
        for (; bits != 0; bits &= bits - 1) {
          const int i = std::countr_zero(bits);
          const std::uint32_t corner = base + kWindow.corner[i];
          if (!open_[corner]) continue;
          if (distance2[i] < distance2_[corner]) {
            distance2_[corner] = distance2[i];
            nearest_[corner] = triangle;
          }
          if (lists_) listings_.push_back({corner, triangle});
        }
      }
    }
  }
}

// The same for a triangle that is near few corners. Most of those of foliage lie in one cube as a whole, and most of
// the others have a corner in each cube that they meet; and few are nearer to a corner than one before.
void BrickMaker::scatterSmall(const BrickPlace& place, std::uint32_t triangle, const TriangleCorners& corners,
                              const Ranges& near) {
  const auto& [a, b, c] = corners;
  const auto lower = [](double i, double j, double k) { return std::min(std::min(i, j), k); };
  const auto higher = [](double i, double j, double k) { return std::max(std::max(i, j), k); };
  const Vec3d low{lower(a.x, b.x, c.x), lower(a.y, b.y, c.y), lower(a.z, b.z, c.z)};
  const Vec3d high{higher(a.x, b.x, c.x), higher(a.y, b.y, c.y), higher(a.z, b.z, c.z)};
  std::optional<CubeTest> cube;
  const auto meets = [&](const Vec3d& p) {
    for (const Vec3d& corner : corners) {
      const Vec3d away = corner - p;
      if (higher(std::fabs(away.x), std::fabs(away.y), std::fabs(away.z)) < kListedHalf - kSlack) return true;
    }
    if (!cube) cube = cubeTestOf(corners, kListedHalf);
    return cube->excess(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)) <= 0;
  };
  for (int z = near[2].first; z <= near[2].last; ++z) {
    for (int y = near[1].first; y <= near[1].last; ++y) {
      for (int x = near[0].first; x <= near[0].last; ++x) {
        const auto corner = static_cast<std::uint32_t>((z * kBrickCorners + y) * kBrickCorners + x);
        const Vec3d p{x - double{kHalf}, y - double{kHalf}, z - double{kHalf}};
        if (!open_[corner] || !meets(p)) continue;
        listings_.push_back({corner, triangle});
        const Vec3d gap{higher(low.x - p.x, p.x - high.x, 0), higher(low.y - p.y, p.y - high.y, 0),
                        higher(low.z - p.z, p.z - high.z, 0)};
        if (dot(gap, gap) > distance2_[corner] + double{kSlack}) continue;
        const Facet<float>& facet = cache_.of(world_.baked, triangle, place);
        const float distance2 =
            facet.distance2(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
        distance2_[corner] = std::min(distance2_[corner], distance2);
      }
    }
  }
}

// Makes the lists of corners, whose triangles stay in order.
void BrickMaker::sortListings() {
  std::array<std::uint32_t, kCornersPerBrick + 1> first{};
  for (const Listing& l : listings_) ++first[l.corner + 1];
  for (int c = 0; c < kCornersPerBrick; ++c) first[c + 1] += first[c];
  listingsByCorner_.resize(listings_.size());
  auto next = first;
  for (const Listing& l : listings_) listingsByCorner_[next[l.corner]++] = l.triangle;
  for (int c = 0; c < kCornersPerBrick; ++c) {
    if (first[c] == first[c + 1]) continue;
    listed_.insert(listed_.end(), listingsByCorner_.begin() + first[c], listingsByCorner_.begin() + first[c + 1]);
    list_[c] = addList();
  }
}

// The nearest triangle of a point of the brick that is at most `reach` away.
NearestFacet BrickMaker::search(const BrickPlace& place, const Vec3f& point, float reach) {
  NearestFacet best{(reach + 1e-3f) * (reach + 1e-3f), kNoTriangle};
  if (guess_ != kNoTriangle) {
    const float distance2 = cache_.of(world_.baked, guess_, place).distance2(point.x, point.y, point.z);
    if (distance2 <= best.distance2) best = {distance2, guess_};
  }
  best = nearestFacet(world_, place, point, best, cache_);
  if (best.triangle != kNoTriangle) guess_ = best.triangle;
  return best;
}

// Whether the blocks before this one have too many candidates, so that it will have too.
bool BrickMaker::amongCrowded(int block) const {
  const auto crowded = [&](int b) { return std::find(crowded_.begin(), crowded_.end(), b) != crowded_.end(); };
  const bool x = block % 3 == 0 || crowded(block - 1);
  const bool y = block / 3 % 3 == 0 || crowded(block - 3);
  const bool z = block / 9 == 0 || crowded(block - 9);
  return block > 0 && x && y && z;
}

// False where the block has too many candidates.
bool BrickMaker::makeBlock(const BrickPlace& place, int block) {
  const Points& centres = brick::kBlockCentres;
  const Vec3f centre{centres.x[block], centres.y[block], centres.z[block]};
  const float seen = brick::seenFrom(block);
  blockDistance_[block] = std::min(std::sqrt(search(place, centre, seen).distance2), seen);
  if (blockDistance_[block] > kExact + brick::kBlockRadius) return true;
  // No corner is farther from its nearest triangle than from the centre's.
  const Points& p = brick::kBlockCorners[block];
  const Facet<float> facet = cache_.of(world_.baked, guess_, place);
  float farthest2 = lists_ ? brick::kListedRadius * brick::kListedRadius : 0.0f;
  alignas(64) Lanes distance2;
  for (int i = 0; i < kLanes; ++i) distance2[i] = facet.distance2(p.x[i], p.y[i], p.z[i]);
  for (int i = 0; i < kLanes; ++i) farthest2 = std::max(farthest2, distance2[i]);
  const float margin = std::min(std::sqrt(farthest2), kExact) + kSlack;
  if (amongCrowded(block) || !gatherTriangles(world_, place, centre, 1, margin, kFewOfBlock, triangles_)) return false;
  sortTriangles();
  candidates_.clear();
  candidateTriangles_ = triangles_;
  for (const std::uint32_t t : triangles_) candidates_.push_back(cache_.of(world_.baked, t, place));
  fillBlock(place, block);
  return true;
}

void BrickMaker::searchBlock(const BrickPlace& place, int block) {
  const Points& p = brick::kBlockCorners[block];
  // So near, all triangles have been held against the corner.
  constexpr float kKnown = kListedHalf - kSlack;
  const float known2 = lists_ ? kKnown * kKnown : kListed2;
  for (int i = 0; i < kBlock; ++i) {
    const std::uint32_t corner = brick::cornerIndex(block, i);
    if (distance2_[corner] <= known2) continue;
    const NearestFacet found = search(place, {p.x[i], p.y[i], p.z[i]}, kExact);
    if (found.triangle == kNoTriangle) continue;
    distance2_[corner] = found.distance2;
    nearest_[corner] = found.triangle;
  }
}

void BrickMaker::makeDense(const BrickPlace& place) {
  cache_.startBrick();
  guess_ = kNoTriangle;
  crowded_.clear();
  open_.fill(false);
  for (int block = 0; block < kBlock; ++block) {
    if (!makeBlock(place, block)) crowded_.push_back(block);
  }
  if (crowded_.empty()) return;
  for (const int block : crowded_) {
    for (int i = 0; i < kBlock; ++i) open_[brick::cornerIndex(block, i)] = true;
  }
  const std::size_t most = lists_ ? std::numeric_limits<std::size_t>::max() - 1 : kScattered;
  const float half = lists_ ? kHalf + kListedHalf : kHalf;
  const float margin = (lists_ ? 0.0f : kListed) + 0.01f;
  listings_.clear();
  if (gatherTriangles(world_, place, {}, half, margin, most, triangles_)) {
    sortTriangles();
    for (const std::uint32_t triangle : triangles_) scatter(place, triangle);
    if (lists_) sortListings();
  }
  for (const int block : crowded_) searchBlock(place, block);
}

}  // namespace scanmill
