#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "methods/field/brick.h"

namespace scanmill {

namespace {

constexpr float kHalf = kHalfBrick;
constexpr float kSlack = 1e-3f;  // margin for rounding, in voxels or voxels^2

// Number of candidates of a block above which each corner searches for its nearest triangle.
constexpr std::size_t kFewOfBlock = 128;

}  // namespace

// Compares a triangle with all corners that may list it. The cube test is rarely needed: most triangles of foliage are
// completely inside one cube, and most others have a corner in each cube that they intersect. The exact distance is
// also rarely needed: few triangles are nearer to a corner than the triangles before them.
void BrickMaker::scatter(const BrickPlace& place, std::uint32_t triangle) {
  const TriangleCorners corners = cornersAt(world_.baked, triangle, place);
  const auto& [a, b, c] = corners;
  const auto lower = [](double i, double j, double k) { return std::min(std::min(i, j), k); };
  const auto higher = [](double i, double j, double k) { return std::max(std::max(i, j), k); };
  const Vec3d low{lower(a.x, b.x, c.x), lower(a.y, b.y, c.y), lower(a.z, b.z, c.z)};
  const Vec3d high{higher(a.x, b.x, c.x), higher(a.y, b.y, c.y), higher(a.z, b.z, c.z)};
  struct Corners {
    int first, last;  // indices of corners along an axis
  };
  const auto range = [](double least, double most) {
    constexpr double kReach = kListHalfSide + 1e-4;
    return Corners{static_cast<int>(std::ceil(std::max(least - kReach + kHalf, 0.0))),
                   static_cast<int>(std::floor(std::min(most + kReach + kHalf, double{kBrickVoxels})))};
  };
  const Corners xs = range(low.x, high.x);
  const Corners ys = range(low.y, high.y);
  const Corners zs = range(low.z, high.z);
  std::optional<CubeTest> cube;
  const auto inCube = [&](const Vec3d& p) {
    for (const Vec3d& corner : corners) {
      const Vec3d away = corner - p;
      if (higher(std::fabs(away.x), std::fabs(away.y), std::fabs(away.z)) < kListHalfSide - kSlack) return true;
    }
    if (!cube) cube = cubeTestOf(corners, kListHalfSide);
    return cube->excess(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)) <= 0;
  };
  for (int z = zs.first; z <= zs.last; ++z) {
    for (int y = ys.first; y <= ys.last; ++y) {
      for (int x = xs.first; x <= xs.last; ++x) {
        const auto corner = static_cast<std::uint32_t>((z * kBrickCorners + y) * kBrickCorners + x);
        const Vec3d p{x - double{kHalf}, y - double{kHalf}, z - double{kHalf}};
        if (!isCrowded_[corner] || !inCube(p)) continue;
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

// Makes the lists of all corners from listings_. The triangles of a list keep the order that they have in listings_.
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
    addList(static_cast<std::uint32_t>(c));
  }
}

// Returns the triangle nearest to a point of the brick; kNoTriangle if none is within `reach` + 0.001 voxels.
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

// Fills a block and returns true; returns false if the block has too many candidates.
bool BrickMaker::makeBlock(const BrickPlace& place, int block) {
  const Points& centres = brick::kBlockCentres;
  const Vec3f centre{centres.x[block], centres.y[block], centres.z[block]};
  const float known = brick::knownRadius(block);
  blockDistance_[block] = std::min(std::sqrt(search(place, centre, known).distance2), known);
  if (blockDistance_[block] > kExactLimit + brick::kBlockRadius) return true;
  // The search radius is the largest distance from a corner to the triangle that is nearest to the block's centre: no
  // corner's nearest triangle is farther away. With lists it is at least kListRadius. It is at most kExactLimit.
  const Points& p = brick::kBlockCorners[block];
  const Facet<float> facet = cache_.of(world_.baked, guess_, place);
  float farthest2 = lists_ ? brick::kListRadius * brick::kListRadius : 0.0f;
  alignas(64) Lanes distance2;
  for (int i = 0; i < kLanes; ++i) distance2[i] = facet.distance2(p.x[i], p.y[i], p.z[i]);
  for (int i = 0; i < kLanes; ++i) farthest2 = std::max(farthest2, distance2[i]);
  const float margin = std::min(std::sqrt(farthest2), kExactLimit) + kSlack;
  if (!gatherTriangles(world_, place, centre, 1, margin, kFewOfBlock, triangles_)) return false;
  sortTriangles();
  candidates_.clear();
  candidateTriangles_ = triangles_;
  for (const std::uint32_t t : triangles_) candidates_.push_back(cache_.of(world_.baked, t, place));
  fillBlock(place, block);
  return true;
}

void BrickMaker::searchBlock(const BrickPlace& place, int block) {
  const Points& p = brick::kBlockCorners[block];
  // scatter() has compared each corner with all triangles at most this far away, because these are in the corner's
  // list.
  constexpr float kKnown = kListHalfSide - kSlack;
  const float known2 = lists_ ? kKnown * kKnown : -1.0f;
  for (int i = 0; i < kBlock; ++i) {
    const std::uint32_t corner = brick::cornerIndex(block, i);
    if (distance2_[corner] <= known2) continue;
    const NearestFacet found = search(place, {p.x[i], p.y[i], p.z[i]}, kExactLimit);
    if (found.triangle == kNoTriangle) continue;
    distance2_[corner] = found.distance2;
    nearest_[corner] = found.triangle;
  }
}

void BrickMaker::makeDense(const BrickPlace& place) {
  cache_.startBrick();
  guess_ = kNoTriangle;
  crowded_.clear();
  isCrowded_.fill(false);
  for (int block = 0; block < kBlock; ++block) {
    if (!makeBlock(place, block)) crowded_.push_back(block);
  }
  if (crowded_.empty()) return;
  if (lists_) {
    for (const int block : crowded_) {
      for (int i = 0; i < kBlock; ++i) isCrowded_[brick::cornerIndex(block, i)] = true;
    }
    listings_.clear();
    constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max() - 1;
    gatherTriangles(world_, place, {}, kHalf + kListHalfSide, 0.01f, kAll, triangles_);
    sortTriangles();
    for (const std::uint32_t triangle : triangles_) scatter(place, triangle);
    sortListings();
  }
  for (const int block : crowded_) searchBlock(place, block);
}

}  // namespace scanmill
