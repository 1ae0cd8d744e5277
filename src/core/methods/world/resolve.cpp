#include "methods/world/resolve.h"

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.h"

namespace scanmill {

namespace {

constexpr double kNoRange = std::numeric_limits<double>::infinity();

// The hits of a tile's rays, which store() writes.
struct TileHits {
  const Tile& tile;
  const Rays& rays;
  const HitPlanes& planes;
  const HitTriangle* triangles;  // one per lane

  bool hit(int lane) const { return planes.range[lane] < kNoRange; }
};

// Returns the reflectance of the texel that a lane's ray hits.
float texturedReflectance(const TileHits& tileHits, const CompactMaterial& material, int lane) {
  const HitTriangle& hit = tileHits.triangles[lane];
  const Vec3d point = tileHits.rays.origin(lane) + tileHits.rays.direction(lane) * tileHits.planes.range[lane];
  return material.texturedAt(
      textureCoordinates(hit.block->uvs, hit.block->corners[hit.index], barycentric(hit, point)));
}

// Copies one value per lane into a column of rings x columns values, one row of the tile at a time.
template <class T>
void storeRows(const Tile& tile, const T* lanes, std::vector<T>& column, std::uint32_t columns) {
  if (tile.width == kPacket) {  // a single row, whose length is a constant for the compiler
    std::copy_n(lanes, kPacket, &column[std::size_t{tile.ring} * columns + tile.column]);
    return;
  }
  for (std::uint32_t r = 0; r < tile.rows; ++r) {
    std::copy_n(lanes + r * tile.width, tile.width, &column[std::size_t{tile.ring + r} * columns + tile.column]);
  }
}

// Labels of the triangles that the lanes' rays hit.
struct HitLabels {
  std::uint32_t instance[kPacket];
  std::uint16_t semantic[kPacket];
  std::uint16_t material[kPacket];
  std::uint32_t primitive[kPacket];
};

// Returns the labels of all lanes, 0 without a hit. A triangle that neighbouring lanes hit is looked up only once.
HitLabels labelsOf(const TileHits& tileHits) {
  HitLabels labels{};
  const HitTriangle* lookedUp = nullptr;  // the hit to which `surface` and `primitive` belong
  HitSurface surface{};
  std::uint32_t primitive = 0;
  for (int i = 0; i < kPacket; ++i) {
    if (!tileHits.hit(i)) continue;
    const HitTriangle& hit = tileHits.triangles[i];
    if (lookedUp == nullptr || !hit.sameTriangle(*lookedUp)) {
      const BlockTriangle& triangle = hit.block->triangles[hit.index];
      surface = hit.block->surfaces[triangle.surface];
      primitive = triangle.primitive;
      if (hit.placed != nullptr) surface.instance = instanceId(hit.placed->firstInstanceId, surface.instance);
      lookedUp = &hit;
    }
    labels.instance[i] = surface.instance;
    labels.semantic[i] = surface.semantic;
    labels.material[i] = surface.material;
    labels.primitive[i] = primitive;
  }
  return labels;
}

void storeReflectance(const TileHits& tileHits, const std::vector<CompactMaterial>& materials, const HitLabels& labels,
                      Hits& hits) {
  float reflectance[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const CompactMaterial& material = materials[labels.material[i]];
    reflectance[i] = tileHits.hit(i) ? material.reflectance : 0.0f;
    if (tileHits.hit(i) && material.texture != nullptr) reflectance[i] = texturedReflectance(tileHits, material, i);
  }
  storeRows(tileHits.tile, reflectance, hits.reflectance, hits.columns);
}

void storeIncidence(const TileHits& tileHits, Hits& hits) {
  alignas(64) float incidence[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const double cosine = std::abs(tileHits.planes.cosine[i]);
    const double bounded = cosine < 1 ? cosine : 1;
    incidence[i] = static_cast<float>(tileHits.hit(i) ? bounded : 0);
  }
  storeRows(tileHits.tile, incidence, hits.incidence, hits.columns);
}

// Stores unit normals that are turned against the rays, and zero for misses.
void storeNormals(const TileHits& tileHits, Hits& hits) {
  const HitPlanes& planes = tileHits.planes;
  alignas(64) float x[kPacket], y[kPacket], z[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const double sign = planes.cosine[i] > 0 ? -1 : 1;
    const bool hit = tileHits.hit(i);
    x[i] = static_cast<float>(hit ? planes.nx[i] * sign : 0);
    y[i] = static_cast<float>(hit ? planes.ny[i] * sign : 0);
    z[i] = static_cast<float>(hit ? planes.nz[i] * sign : 0);
  }
  Vec3f normal[kPacket];
  for (int i = 0; i < kPacket; ++i) normal[i] = {x[i], y[i], z[i]};
  storeRows(tileHits.tile, normal, hits.normal, hits.columns);
}

// The poses of the rays of a packet, by component and lane. The components are the columns of the rotation, then the
// position. Each component has 2 * kPacket values, because fillFrom() writes kPacket values from any lane on.
struct LanePoses {
  alignas(64) double component[12][2 * kPacket];

  // Sets the poses of all lanes from `firstLane` on.
  void fillFrom(int firstLane, const Mat3& rotation, const Vec3d& position) {
    int k = 0;
    for (const Vec3d* v : {&rotation.x, &rotation.y, &rotation.z, &position}) {
      for (const double value : {v->x, v->y, v->z}) std::fill_n(component[k++] + firstLane, kPacket, value);
    }
  }
};

// Sets up the rays of a tile of one ring and kPacket columns. Computes each lane by the operations of Mat3 * Vec3d.
void setUpRowOfRays(const ShotFrame& frame, const BeamTable& beams, const Tile& tile, Rays& rays) {
  const std::size_t first = std::size_t{tile.ring} * beams.columns + tile.column;
  const std::uint32_t* const step = &frame.step[tile.column];
  LanePoses poses;
  for (int lane = 0; lane < kPacket; ++lane) {
    if (lane > 0 && step[lane] == step[lane - 1]) continue;
    poses.fillFrom(lane, frame.rotation[step[lane]], frame.position[step[lane]]);
  }
  const auto pose = [&](int k) { return poses.component[k]; };
  const Vec3d* const directions = &beams.direction[first];
  for (int i = 0; i < kPacket; ++i) {
    const Vec3d d = directions[i];
    rays.dx[i] = pose(0)[i] * d.x + pose(3)[i] * d.y + pose(6)[i] * d.z;
    rays.dy[i] = pose(1)[i] * d.x + pose(4)[i] * d.y + pose(7)[i] * d.z;
    rays.dz[i] = pose(2)[i] * d.x + pose(5)[i] * d.y + pose(8)[i] * d.z;
    rays.ox[i] = pose(9)[i];
    rays.oy[i] = pose(10)[i];
    rays.oz[i] = pose(11)[i];
  }
  if (!beams.origin.empty()) {
    const Vec3f* const origins = &beams.origin[first];
    for (int i = 0; i < kPacket; ++i) {
      const Vec3d o(origins[i]);
      rays.ox[i] += pose(0)[i] * o.x + pose(3)[i] * o.y + pose(6)[i] * o.z;
      rays.oy[i] += pose(1)[i] * o.x + pose(4)[i] * o.y + pose(7)[i] * o.z;
      rays.oz[i] += pose(2)[i] * o.x + pose(5)[i] * o.y + pose(8)[i] * o.z;
    }
  }
  rays.count = kPacket;
}

}  // namespace

RangeLimits limitsOf(const BeamTable& beams) {
  constexpr double kRoundUp = 1 + 1e-12;  // so that a hit at exactly the maximum range counts
  return {beams.minRange > 0 ? beams.minRange : std::numeric_limits<double>::denorm_min(), beams.maxRange * kRoundUp};
}

ShotFrame frameOf(const Shot& shot, const Vec3d& origin, double duration) {
  const BeamTable& beams = *shot.beams;
  ShotFrame frame;
  for (const Pose& pose : shot.worldFromSensor) {
    frame.rotation.push_back(toMatrix(pose.rotation));
    frame.position.push_back(pose.translation - origin);
  }
  frame.step.resize(beams.columns);  // all 0 if there is one pose
  for (std::uint32_t column = 0; column < beams.columns && frame.position.size() > 1; ++column) {
    frame.step[column] = static_cast<std::uint32_t>(shot.stepOf(column));
  }
  if (duration <= 0 || !beams.time.empty()) return frame;
  frame.columnFraction.resize(beams.columns);
  for (std::uint32_t column = 0; column < beams.columns; ++column) {
    frame.columnFraction[column] = firingFraction(beams, column, duration);
  }
  return frame;
}

float firingFraction(const BeamTable& beams, std::size_t ray, double duration) {
  if (duration <= 0) return 0;
  const auto column = static_cast<std::uint32_t>(ray % beams.columns);
  const std::uint32_t firstColumnOfBeam = column / beams.raysPerBeam * beams.raysPerBeam;
  const double time = beams.time.empty() ? beams.columnTime(firstColumnOfBeam) : double{beams.time[ray]};
  return static_cast<float>(std::clamp(time / duration, 0.0, 1.0));
}

void fillFiringFractions(const Shot& shot, const ShotFrame& frame, const Tile& tile, double duration,
                         float* fractions) {
  std::fill_n(fractions, kPacket, 0.0f);
  if (duration <= 0) return;
  const BeamTable& beams = *shot.beams;
  for (std::uint32_t r = 0; r < tile.rows; ++r) {
    float* const row = fractions + r * tile.width;
    if (!frame.columnFraction.empty()) {
      std::copy_n(&frame.columnFraction[tile.column], tile.width, row);
      continue;
    }
    const std::size_t first = std::size_t{tile.ring + r} * beams.columns + tile.column;
    for (std::uint32_t c = 0; c < tile.width; ++c) row[c] = firingFraction(beams, first + c, duration);
  }
}

SCANMILL_BEST_INSTRUCTIONS void setUpRays(const Shot& shot, const ShotFrame& frame, const Tile& tile, Rays& rays) {
  const BeamTable& beams = *shot.beams;
  if (tile.width == kPacket) return setUpRowOfRays(frame, beams, tile, rays);
  int lane = 0;
  for (std::uint32_t r = 0; r < tile.rows; ++r) {
    const std::uint32_t first = (tile.ring + r) * beams.columns + tile.column;
    for (std::uint32_t c = 0; c < tile.width; ++c, ++lane) {
      const std::uint32_t step = frame.step[tile.column + c];
      const Mat3& rotation = frame.rotation[step];
      const Vec3d d = rotation * beams.direction[first + c];
      Vec3d o = frame.position[step];
      if (!beams.origin.empty()) o += rotation * Vec3d(beams.origin[first + c]);
      rays.ox[lane] = o.x;
      rays.oy[lane] = o.y;
      rays.oz[lane] = o.z;
      rays.dx[lane] = d.x;
      rays.dy[lane] = d.y;
      rays.dz[lane] = d.z;
    }
  }
  rays.count = lane;
  for (Lane* values : {&rays.ox, &rays.oy, &rays.oz, &rays.dx, &rays.dy, &rays.dz}) {
    std::fill(*values + lane, *values + kPacket, (*values)[0]);
  }
}

SCANMILL_BEST_INSTRUCTIONS void usePlaneRanges(const Rays& rays, const BeamTable& beams, HitPlanes& planes) {
  const RangeLimits limits = limitsOf(beams);
  for (int i = 0; i < kPacket; ++i) {
    const double cosine = planes.nx[i] * rays.dx[i] + planes.ny[i] * rays.dy[i] + planes.nz[i] * rays.dz[i];
    const double originOffset = planes.nx[i] * rays.ox[i] + planes.ny[i] * rays.oy[i] + planes.nz[i] * rays.oz[i];
    const double toPlane = (planes.offset[i] - originOffset) / cosine;
    const double least = planes.traced[i] - (kRangeErrorBound * planes.traced[i] + kRangeErrorBound);
    const double most = planes.traced[i] + (kRangeErrorBound * planes.traced[i] + kRangeErrorBound);
    double range = toPlane > least ? toPlane : least;  // `least` also if `toPlane` is NaN
    range = range < most ? range : most;
    const bool isHit = (range >= limits.nearest) & (range <= limits.farthest) & (planes.traced[i] < kNoRange);
    planes.range[i] = isHit ? range : kNoRange;
    planes.cosine[i] = cosine;
  }
}

SCANMILL_BEST_INSTRUCTIONS void useTracedRanges(const Rays& rays, const BeamTable& beams, HitPlanes& planes) {
  const RangeLimits limits = limitsOf(beams);
  for (int i = 0; i < kPacket; ++i) {
    const bool isHit = (planes.traced[i] >= limits.nearest) & (planes.traced[i] <= limits.farthest);
    planes.range[i] = isHit ? planes.traced[i] : kNoRange;
    planes.cosine[i] = planes.nx[i] * rays.dx[i] + planes.ny[i] * rays.dy[i] + planes.nz[i] * rays.dz[i];
  }
}

Vec2d barycentric(const HitTriangle& hit, const Vec3d& point) {
  const Triangle& corners = hit.block->corners[hit.index];
  const auto corner = [&](int k) {
    const Vec3d p(hit.block->vertices[corners[k]]);
    return hit.placed == nullptr ? p : hit.placed->at(double{hit.firedAt}) * p;
  };
  const Vec3d a = corner(0);
  return barycentric(corner(1) - a, corner(2) - a, point - a);
}

void prefetchStore(const Tile& tile, Hits& hits) {
  const std::size_t last = std::size_t{tile.ring} * hits.columns + tile.column + tile.width - 1;
  forEachChannel([&](const ChannelRow&, auto member) {
    auto& column = hits.*member;
    if (!column.empty()) __builtin_prefetch(&column[last], 1);
  });
  for (std::size_t k = 1; k < 3 && !hits.normal.empty(); ++k) {
    __builtin_prefetch(&hits.normal[last - k * (tile.width / 3)], 1);
  }
}

static_assert(kChannels.size() == 8, "fill the new channel in store()");

SCANMILL_BEST_INSTRUCTIONS void store(const std::vector<CompactMaterial>& materials, const Tile& tile, const Rays& rays,
                                      const HitPlanes& planes, const HitTriangle* triangles, Hits& hits) {
  const TileHits tileHits{tile, rays, planes, triangles};
  const Channels requested = hits.channels;
  alignas(64) float range[kPacket];
  for (int i = 0; i < kPacket; ++i) range[i] = static_cast<float>(planes.range[i]);
  storeRows(tile, range, hits.range, hits.columns);
  if (requested.has(Channel::Incidence)) storeIncidence(tileHits, hits);
  if (requested.has(Channel::Normal)) storeNormals(tileHits, hits);
  const HitLabels labels = labelsOf(tileHits);
  if (requested.has(Channel::Instance)) storeRows(tile, labels.instance, hits.instance, hits.columns);
  if (requested.has(Channel::Semantic)) storeRows(tile, labels.semantic, hits.semantic, hits.columns);
  if (requested.has(Channel::Material)) storeRows(tile, labels.material, hits.material, hits.columns);
  if (requested.has(Channel::Primitive)) storeRows(tile, labels.primitive, hits.primitive, hits.columns);
  if (requested.has(Channel::Reflectance)) storeReflectance(tileHits, materials, labels, hits);
}

}  // namespace scanmill
