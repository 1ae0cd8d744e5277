#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "methods/field/brick.h"

namespace scanmill {

namespace {

constexpr float kHalf = kHalfBrick;
constexpr float kMargin = 1e-3f;  // margin for rounding, in voxels or voxels^2

// Number of candidates of a block above which each corner searches for its nearest triangle.
constexpr std::size_t kFewOfBlock = 128;

}  // namespace

// If a triangle intersects the cube around a corner of a crowded block, adds the triangle to listings_ for this corner
// and updates the corner's distance. The cube test is rarely needed: most triangles of foliage are completely inside
// one cube, and most others have a corner in each cube that they intersect. The exact distance is also rarely needed:
// few triangles are nearer to a corner than all earlier triangles.
void BrickMaker::addListings(const BrickFrame& frame, std::uint32_t triangle) {
  const TriangleCorners corners = cornersAt(world_.baked, triangle, frame);
  Box box;
  for (const Vec3d& corner : corners) box.add(corner);
  struct CornerRange {
    int first, last;  // indices of corners along an axis
  };
  const auto cornersNear = [](double low, double high) {
    constexpr double kReach = kListHalfSide + 1e-4;  // with a margin for rounding
    return CornerRange{static_cast<int>(std::ceil(std::max(low - kReach + kHalf, 0.0))),
                       static_cast<int>(std::floor(std::min(high + kReach + kHalf, double{kBrickVoxels})))};
  };
  const CornerRange xs = cornersNear(box.low.x, box.high.x);
  const CornerRange ys = cornersNear(box.low.y, box.high.y);
  const CornerRange zs = cornersNear(box.low.z, box.high.z);
  const auto larger = [](double i, double j, double k) { return std::max(std::max(i, j), k); };
  std::optional<CubeTest> cube;  // made when it is first needed
  const auto isInCube = [&](const Vec3d& p) {
    for (const Vec3d& corner : corners) {
      const Vec3d offset = corner - p;
      if (larger(std::fabs(offset.x), std::fabs(offset.y), std::fabs(offset.z)) < kListHalfSide - kMargin) return true;
    }
    if (!cube) cube = cubeTestOf(corners, kListHalfSide);
    return cube->excess(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)) <= 0;
  };
  for (int z = zs.first; z <= zs.last; ++z) {
    for (int y = ys.first; y <= ys.last; ++y) {
      for (int x = xs.first; x <= xs.last; ++x) {
        const auto corner = static_cast<std::uint32_t>((z * kBrickCorners + y) * kBrickCorners + x);
        const Vec3d p{x - double{kHalf}, y - double{kHalf}, z - double{kHalf}};
        if (!isCrowded_[corner] || !isInCube(p)) continue;
        listings_.push_back({corner, triangle});
        const Vec3d gap{larger(box.low.x - p.x, p.x - box.high.x, 0), larger(box.low.y - p.y, p.y - box.high.y, 0),
                        larger(box.low.z - p.z, p.z - box.high.z, 0)};
        if (dot(gap, gap) > distance2_[corner] + double{kMargin}) continue;
        const Facet<float>& facet = cache_.facetOf(world_.baked, triangle, frame);
        distance2_[corner] =
            std::min(distance2_[corner],
                     facet.distance2(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)));
      }
    }
  }
}

// Makes the lists of all corners from listings_, by counting sort: the triangles of a list keep their order.
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
    endList(static_cast<std::uint32_t>(c));
  }
}

// Returns the triangle nearest to a point of the brick; kNoTriangle if none is within `reach` + 0.001 voxels.
NearestFacet BrickMaker::search(const BrickFrame& frame, const Vec3f& point, float reach) {
  NearestFacet nearest{(reach + kMargin) * (reach + kMargin), kNoTriangle};
  if (guess_ != kNoTriangle) {
    const float distance2 = cache_.facetOf(world_.baked, guess_, frame).distance2(point.x, point.y, point.z);
    if (distance2 <= nearest.distance2) nearest = {distance2, guess_};
  }
  nearest = nearestFacet(world_, frame, point, nearest, cache_);
  if (nearest.triangle != kNoTriangle) guess_ = nearest.triangle;
  return nearest;
}

// Sets the block's distance. Then fills the block and returns true, or returns false if its candidates are too many.
bool BrickMaker::makeBlock(const BrickFrame& frame, int block) {
  const Points& centres = brick::kBlockCentres;
  const Vec3f centre{centres.x[block], centres.y[block], centres.z[block]};
  const float reach = brick::gatheredRadius(block);
  const NearestFacet nearest = search(frame, centre, reach);
  blockDistance_[block] = std::min(std::sqrt(nearest.distance2), reach);
  if (blockDistance_[block] > kExactLimit + brick::kBlockRadius) return true;
  // The search radius is the largest distance from a corner to the triangle that is nearest to the block's centre: no
  // corner's nearest triangle is farther away. The radius is at least kListRadius with lists, and at most kExactLimit.
  const Points& p = brick::kBlockCorners[block];
  const Facet<float> facet = cache_.facetOf(world_.baked, nearest.triangle, frame);
  float farthest2 = lists_ ? brick::kListRadius * brick::kListRadius : 0.0f;
  alignas(64) Lanes distance2;
  for (int i = 0; i < kLanes; ++i) distance2[i] = facet.distance2(p.x[i], p.y[i], p.z[i]);
  for (int i = 0; i < kLanes; ++i) farthest2 = std::max(farthest2, distance2[i]);
  constexpr float kHalfBlock = 1;  // voxels, from the block's centre to its corners along an axis
  const float radius = std::min(std::sqrt(farthest2), kExactLimit) + kMargin;
  if (!gatherTriangles(world_, frame, centre, kHalfBlock, radius, kFewOfBlock, triangles_)) return false;
  sortTriangles();
  candidates_.clear();
  candidateTriangles_ = triangles_;
  for (const std::uint32_t t : triangles_) candidates_.push_back(cache_.facetOf(world_.baked, t, frame));
  fillBlock(frame, block);
  return true;
}

// Sets the distances and nearest triangles of the corners of a crowded block, by a search for each corner.
void BrickMaker::searchBlock(const BrickFrame& frame, int block) {
  const Points& p = brick::kBlockCorners[block];
  // With lists, addListings() has already compared a corner with all triangles at most kCompared (voxels) away.
  constexpr float kCompared = kListHalfSide - kMargin;
  const float compared2 = lists_ ? kCompared * kCompared : -1.0f;
  for (int i = 0; i < kBlock; ++i) {
    const std::uint32_t corner = brick::cornerIndex(block, i);
    if (distance2_[corner] <= compared2) continue;
    const NearestFacet nearest = search(frame, {p.x[i], p.y[i], p.z[i]}, kExactLimit);
    if (nearest.triangle == kNoTriangle) continue;
    distance2_[corner] = nearest.distance2;
    nearest_[corner] = nearest.triangle;
  }
}

// Makes a brick with many triangles, block by block. Blocks with too many candidates ("crowded") get their lists
// triangle by triangle, and their distances corner by corner.
void BrickMaker::makeDense(const BrickFrame& frame) {
  cache_.startBrick();
  guess_ = kNoTriangle;
  crowded_.clear();
  isCrowded_.fill(false);
  for (int block = 0; block < kBlock; ++block) {
    if (!makeBlock(frame, block)) crowded_.push_back(block);
  }
  if (crowded_.empty()) return;
  if (lists_) {
    for (const int block : crowded_) {
      for (int i = 0; i < kBlock; ++i) isCrowded_[brick::cornerIndex(block, i)] = true;
    }
    listings_.clear();
    constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max() - 1;
    constexpr float kGatherMargin = 0.01f;  // voxels, for rounding
    gatherTriangles(world_, frame, {}, kHalf + kListHalfSide, kGatherMargin, kNoLimit, triangles_);
    sortTriangles();
    for (const std::uint32_t triangle : triangles_) addListings(frame, triangle);
    sortListings();
  }
  for (const int block : crowded_) searchBlock(frame, block);
}

}  // namespace scanmill
