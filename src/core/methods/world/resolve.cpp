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

float texturedReflectance(const TileHits& from, const CompactMaterial& material, int lane) {
  const HitTriangle& hit = from.triangles[lane];
  const Vec3d point = from.rays.origin(lane) + from.rays.direction(lane) * from.planes.range[lane];
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

// Labels of the lanes' hits, looked up from their triangles.
struct HitLabels {
  std::uint32_t instance[kPacket];
  std::uint16_t semantic[kPacket];
  std::uint16_t material[kPacket];
  std::uint32_t primitive[kPacket];
};

HitLabels labelsOf(const TileHits& from) {
  HitLabels labels;
  const HitTriangle* last = nullptr;  // the hit whose labels the next two variables have
  HitSurface surfaceOfLast{};
  std::uint32_t primitiveOfLast = 0;
  for (int i = 0; i < kPacket; ++i) {
    HitSurface surface{};
    std::uint32_t primitive = 0;
    if (from.hit(i)) {
      const HitTriangle& t = from.triangles[i];
      if (last == nullptr || !t.sameTriangle(*last)) {
        const BlockTriangle& triangle = t.block->triangles[t.index];
        surfaceOfLast = t.block->surfaces[triangle.surface];
        primitiveOfLast = triangle.primitive;
        if (t.placed != nullptr) {
          surfaceOfLast.instance = instanceId(t.placed->firstInstanceId, surfaceOfLast.instance);
        }
        last = &t;
      }
      surface = surfaceOfLast;
      primitive = primitiveOfLast;
    }
    labels.instance[i] = surface.instance;
    labels.semantic[i] = surface.semantic;
    labels.material[i] = surface.material;
    labels.primitive[i] = primitive;
  }
  return labels;
}

void storeReflectance(const TileHits& from, const std::vector<CompactMaterial>& materials, const HitLabels& labels,
                      Hits& hits) {
  float reflectance[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const CompactMaterial& material = materials[labels.material[i]];
    reflectance[i] = from.hit(i) ? material.reflectance : 0.0f;
    if (from.hit(i) && material.texture != nullptr) reflectance[i] = texturedReflectance(from, material, i);
  }
  storeRows(from.tile, reflectance, hits.reflectance, hits.columns);
}

void storeIncidence(const TileHits& from, Hits& hits) {
  alignas(64) float incidence[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const double cosine = std::abs(from.planes.cosine[i]);
    const double bounded = cosine < 1 ? cosine : 1;
    incidence[i] = static_cast<float>(from.hit(i) ? bounded : 0);
  }
  storeRows(from.tile, incidence, hits.incidence, hits.columns);
}

void storeNormals(const TileHits& from, Hits& hits) {
  const HitPlanes& planes = from.planes;
  alignas(64) float x[kPacket], y[kPacket], z[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const double towards = planes.cosine[i] > 0 ? -1 : 1;
    const bool hit = from.hit(i);
    x[i] = static_cast<float>(hit ? planes.nx[i] * towards : 0);
    y[i] = static_cast<float>(hit ? planes.ny[i] * towards : 0);
    z[i] = static_cast<float>(hit ? planes.nz[i] * towards : 0);
  }
  Vec3f normal[kPacket];
  for (int i = 0; i < kPacket; ++i) normal[i] = {x[i], y[i], z[i]};
  storeRows(from.tile, normal, hits.normal, hits.columns);
}

// Values of the lanes of a packet. The second half is room for writes of kPacket values that begin at any lane.
struct PaddedLane {
  alignas(64) double value[2 * kPacket];

  void fillFrom(int lane, double with) { std::fill_n(value + lane, kPacket, with); }
};

// The poses of the rays of a packet: lane by lane the columns of the rotation, and the position.
struct LanePoses {
  PaddedLane value[12];

  void fillFrom(int lane, const Mat3& rotation, const Vec3d& position) {
    int k = 0;
    for (const Vec3d* v : {&rotation.x, &rotation.y, &rotation.z, &position}) {
      value[k++].fillFrom(lane, v->x);
      value[k++].fillFrom(lane, v->y);
      value[k++].fillFrom(lane, v->z);
    }
  }
};

// Sets up kPacket neighbouring rays of one ring. The arithmetic is that of Mat3 * Vec3d, lane by lane.
void setUpRowOfRays(const ShotFrame& frame, const BeamTable& beams, const Tile& tile, Rays& rays) {
  const std::size_t first = std::size_t{tile.ring} * beams.columns + tile.column;
  const std::uint32_t* const step = &frame.step[tile.column];
  LanePoses poses;
  for (int lane = 0; lane < kPacket; ++lane) {
    if (lane > 0 && step[lane] == step[lane - 1]) continue;
    poses.fillFrom(lane, frame.rotation[step[lane]], frame.position[step[lane]]);
  }
  const auto pose = [&](int k) { return poses.value[k].value; };
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
  return {beams.minRange > 0 ? beams.minRange : std::numeric_limits<double>::denorm_min(),
          beams.maxRange * (1 + 1e-12)};
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
  const double time =
      beams.time.empty() ? beams.columnTime(column / beams.raysPerBeam * beams.raysPerBeam) : double{beams.time[ray]};
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
  for (; lane < kPacket; ++lane) {
    rays.ox[lane] = rays.ox[0];
    rays.oy[lane] = rays.oy[0];
    rays.oz[lane] = rays.oz[0];
    rays.dx[lane] = rays.dx[0];
    rays.dy[lane] = rays.dy[0];
    rays.dz[lane] = rays.dz[0];
  }
}

SCANMILL_BEST_INSTRUCTIONS void usePlaneRanges(const Rays& rays, const BeamTable& beams, HitPlanes& planes) {
  const RangeLimits limits = limitsOf(beams);
  for (int i = 0; i < kPacket; ++i) {
    const double along = planes.nx[i] * rays.dx[i] + planes.ny[i] * rays.dy[i] + planes.nz[i] * rays.dz[i];
    const double origin = planes.nx[i] * rays.ox[i] + planes.ny[i] * rays.oy[i] + planes.nz[i] * rays.oz[i];
    const double toPlane = (planes.offset[i] - origin) / along;
    const double low = planes.traced[i] - (kRangeErrorBound * planes.traced[i] + kRangeErrorBound);
    const double high = planes.traced[i] + (kRangeErrorBound * planes.traced[i] + kRangeErrorBound);
    double range = toPlane > low ? toPlane : low;  // `low` also if `toPlane` is NaN
    range = range < high ? range : high;
    const bool inside = (range >= limits.nearest) & (range <= limits.farthest) & (planes.traced[i] < kNoRange);
    planes.range[i] = inside ? range : kNoRange;
    planes.cosine[i] = along;
  }
}

SCANMILL_BEST_INSTRUCTIONS void useTracedRanges(const Rays& rays, const BeamTable& beams, HitPlanes& planes) {
  const RangeLimits limits = limitsOf(beams);
  for (int i = 0; i < kPacket; ++i) {
    const bool inside = (planes.traced[i] >= limits.nearest) & (planes.traced[i] <= limits.farthest);
    planes.range[i] = inside ? planes.traced[i] : kNoRange;
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
  const TileHits from{tile, rays, planes, triangles};
  const Channels requested = hits.channels;
  alignas(64) float range[kPacket];
  for (int i = 0; i < kPacket; ++i) range[i] = static_cast<float>(planes.range[i]);
  storeRows(tile, range, hits.range, hits.columns);
  if (requested.has(Channel::Incidence)) storeIncidence(from, hits);
  if (requested.has(Channel::Normal)) storeNormals(from, hits);
  const HitLabels labels = labelsOf(from);
  if (requested.has(Channel::Instance)) storeRows(tile, labels.instance, hits.instance, hits.columns);
  if (requested.has(Channel::Semantic)) storeRows(tile, labels.semantic, hits.semantic, hits.columns);
  if (requested.has(Channel::Material)) storeRows(tile, labels.material, hits.material, hits.columns);
  if (requested.has(Channel::Primitive)) storeRows(tile, labels.primitive, hits.primitive, hits.columns);
  if (requested.has(Channel::Reflectance)) storeReflectance(from, materials, labels, hits);
}

}  // namespace scanmill
