// Steps particles, as many at a time as the CPU has lanes of SIMD, for march_cpu.cpp. The shader
// methods/gpu/shaders/march.glsl takes the same steps.
//
// Particles stream through the lanes: as soon as a particle is done, the next particle takes its lane, so that a long
// path leaves no other lane idle. A step is split into stages, and each stage is done for all groups of lanes before
// the next stage begins: while one group waits for its loads, which take far longer than arithmetic, the CPU
// works on the other groups. The result of a particle does not depend on other particles. Compared with one particle at
// a time, the lanes of AVX-512 make scans 3.1 to 3.5 times as fast; the groups contribute 15 to 25 % of this speed-up
// (docs/particle.md).
//
// Included once for each instruction set: see march_cpu.cpp.
#if defined(SCANMILL_MARCH_STREAM_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SCANMILL_MARCH_STREAM_H
#undef SCANMILL_MARCH_STREAM_H
#else
#define SCANMILL_MARCH_STREAM_H
#endif

#include <span>

#include "methods/particle/march_triangles.h"
#include "methods/particle/particles.h"

HWY_BEFORE_NAMESPACE();
namespace scanmill::HWY_NAMESPACE {

constexpr std::size_t kLaneGroups = 12;
static_assert(kLaneGroups * kLanes <= ListIntersector::kLines);

constexpr std::uint32_t kCornerRow = kBrickCorners;
constexpr std::uint32_t kCornerLayer = kBrickCorners * kBrickCorners;

// The particles in a group of lanes.
struct LaneGroup {
  HWY_ALIGN_MAX LaneFloats origin[3] = {}, direction[3] = {}, begin = {}, end = {};
  HWY_ALIGN_MAX LaneFloats worldOrigin[3] = {}, inverse[3] = {};  // used only in fields with lists
  HWY_ALIGN_MAX LaneFloats travelled = {};
  HWY_ALIGN_MAX LaneWords steps = {};  // number of steps taken
  std::size_t particle[kLanes] = {};
  LaneBits active = 0;  // lanes that have a particle

  // State of the current step. Here and above, `travelled` is in voxels of level 0.
  HWY_ALIGN_MAX LaneFloats inVoxel[3] = {}, scale = {};  // position in the voxel, 0 to 1; scale = 2^-level
  HWY_ALIGN_MAX LaneWords voxel[3] = {};                 // coordinates of the voxel in its brick
  HWY_ALIGN_MAX LaneWords entry = {};                    // the brick's entry in DistanceField::table
  HWY_ALIGN_MAX LaneWords cell = {};     // index of the voxel's first corner or, with lists, of the nearest corner
  HWY_ALIGN_MAX LaneWords rows[4] = {};  // pairs of distances; with lists, only the pair of the nearest corner
  HWY_ALIGN_MAX LaneFloats travelledBefore = {};  // `travelled` before the step
  HWY_ALIGN_MAX LaneWords corner = {};            // without lists: the corner nearest to a particle at a surface
  LaneBits mayHit = 0;  // lanes at a surface (without lists), or with triangles to test (with lists)
};

// The parameters of all levels, indexed by level.
struct LevelTables {
  static constexpr std::size_t kSize = kMaxLevels;
  HWY_ALIGN_MAX float offset[3][kSize] = {};
  HWY_ALIGN_MAX std::int32_t last[3][kSize] = {};  // largest index of a voxel's first corner, by axis and level
  HWY_ALIGN_MAX std::uint32_t row[kSize] = {};     // number of bricks from one row to the next
  HWY_ALIGN_MAX std::uint32_t layer[kSize] = {};
  HWY_ALIGN_MAX std::uint32_t first[kSize] = {};

  explicit LevelTables(const DistanceField& field) {
    for (std::size_t l = 0; l < field.levels.size(); ++l) {
      const FieldLevel& level = field.levels[l];
      for (int k = 0; k < 3; ++k) {
        offset[k][l] = level.offset[k];
        last[k][l] = static_cast<std::int32_t>(level.bricks[k]) * kBrickVoxels - 1;
      }
      row[l] = level.bricks[0];
      layer[l] = level.bricks[0] * level.bricks[1];
      first[l] = level.firstEntry;
    }
  }

  // Returns, for each lane, the entry of `table` for the lane's level.
  template <class D>
  static hn::Vec<D> at(D d, const hn::TFromD<D>* table, Ints level) {
    if constexpr (kLanes == kSize) {
      return hn::TableLookupLanes(hn::Load(d, table), hn::IndicesFromVec(d, level));
    } else {
      return hn::GatherIndex(d, table, level);
    }
  }
};

// True for lanes whose brick is full. `entry`: entries of DistanceField::table.
inline Mask isFull(Words entry) {
  return hn::RebindMask(kFloats, hn::TestBit(entry, hn::Set(kWords, kFullBrick)));
}

// Interpolates linearly between a and b.
inline Floats mixed(Floats a, Floats b, Floats t) {
  return hn::Add(a, hn::Mul(hn::Sub(b, a), t));
}

// Each pair has the distances of two corners that are neighbours along x: lowerOf() returns the first corner's
// distance, upperOf() the second corner's.
inline Floats lowerOf(Words pair) {
  return hn::ConvertTo(kFloats, hn::BitCast(kInts, hn::And(pair, hn::Set(kWords, 0xFFFFu))));
}

inline Floats upperOf(Words pair) {
  return hn::ConvertTo(kFloats, hn::BitCast(kInts, hn::ShiftRight<16>(pair)));
}

inline Words wordsWhere(Mask mask, Words yes, Words no) {
  return hn::IfThenElse(hn::RebindMask(kWords, mask), yes, no);
}

// Marches particles. Without lists, the record of a hit contains the corner that stores the triangle; marchCpu()
// replaces the corner by the triangle.
template <bool kLists>
class ParticleStream {
 public:
  ParticleStream(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t maxSteps,
                 const Particles& particles, std::span<const std::uint32_t> indices, HitRecords& records)
      : field_(field),
        maxSteps_(maxSteps),
        particles_(particles),
        indices_(indices),
        records_(records),
        tables_(field),
        intersector_(field, triangles) {}

  // Marches all particles until their records are complete.
  void run() {
    LaneBits active = 0;
    for (LaneGroup& group : groups_) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) refill(group, lane);
      active |= group.active;
    }
    while (active != 0) {
      for (LaneGroup& group : groups_) {
        if (group.active != 0) locateVoxels(group);
      }
      for (LaneGroup& group : groups_) {
        if (group.active != 0) chooseCorners(group);
      }
      for (LaneGroup& group : groups_) {
        if (group.active != 0) loadDistances(group);
      }
      for (std::size_t g = 0; g < kLaneGroups; ++g) {
        if (groups_[g].active != 0) advance(g);
      }
      if constexpr (kLists) intersector_.intersect();
      active = 0;
      for (std::size_t g = 0; g < kLaneGroups; ++g) {
        if (groups_[g].active != 0) recordAndRefill(g);
        active |= groups_[g].active;
      }
    }
  }

 private:
  void record(std::size_t i, float travelled, std::uint32_t triangle, std::uint32_t steps, Outcome outcome) {
    records_.travelled[i] = travelled;
    records_.triangle[i] = triangle;
    records_.outcome[i] = 4 * steps + static_cast<std::uint32_t>(outcome);
  }

  void recordWithoutHit(std::size_t i, std::uint32_t steps) {
    record(i, 0, 0, steps, steps >= maxSteps_ ? Outcome::Exhausted : Outcome::Miss);
  }

  // Loads the next particle into a lane; if no particle remains, the lane becomes inactive. Skips and records particles
  // that have no path or have used up their steps.
  void refill(LaneGroup& group, std::size_t lane) {
    group.active &= ~(LaneBits{1} << lane);
    while (next_ < indices_.size()) {
      const std::uint32_t i = indices_[next_++];
      const std::uint32_t steps = records_.stepsOf(i);
      if (steps >= maxSteps_ || !(particles_.begin[i] < particles_.end[i])) {
        recordWithoutHit(i, steps);
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        group.origin[k][lane] = particles_.origin[k][i];
        group.direction[k][lane] = particles_.direction[k][i];
        if constexpr (kLists) group.worldOrigin[k][lane] = particles_.worldOrigin[k][i];
        if constexpr (kLists) group.inverse[k][lane] = particles_.inverse[k][i];
      }
      group.begin[lane] = group.travelled[lane] = particles_.begin[i];
      group.end[lane] = particles_.end[i];
      group.steps[lane] = steps;
      group.particle[lane] = i;
      group.active |= LaneBits{1} << lane;
      return;
    }
  }

  // Finds the level, brick and voxel of each particle, and loads the brick's table entry.
  void locateVoxels(LaneGroup& group) const {
    const Floats travelled = hn::Load(kFloats, group.travelled);
    Floats q[3];
    for (int k = 0; k < 3; ++k) {
      q[k] = hn::Add(hn::Load(kFloats, group.origin[k]), hn::Mul(hn::Load(kFloats, group.direction[k]), travelled));
    }
    // The level is the binary logarithm of `share`, rounded up: `share`'s exponent, bits 23 to 30 of the float32, minus
    // 126. Subtracting 1 from the bits first makes the level right for powers of two too.
    const Floats largest = hn::Max(hn::Abs(q[0]), hn::Max(hn::Abs(q[1]), hn::Abs(q[2])));
    const Floats share = hn::Mul(largest, hn::Set(kFloats, 1.0f / field_.shape.reach));
    const Ints exponent = hn::ShiftRight<23>(hn::Sub(hn::BitCast(kInts, share), hn::Set(kInts, 1)));
    const Ints coarsest = hn::Set(kInts, static_cast<std::int32_t>(field_.levels.size()) - 1);
    const Ints level = hn::Min(hn::Max(hn::Sub(exponent, hn::Set(kInts, 126)), hn::Zero(kInts)), coarsest);
    const Floats scale = hn::BitCast(kFloats, hn::ShiftLeft<23>(hn::Sub(hn::Set(kInts, 127), level)));
    hn::Store(scale, kFloats, group.scale);
    Words brick[3];
    for (int k = 0; k < 3; ++k) {
      const Floats offset = tables_.at(kFloats, tables_.offset[k], level);
      const Floats u = hn::Max(hn::Add(hn::Mul(q[k], scale), offset), hn::Zero(kFloats));
      const Ints corner = hn::Min(hn::ConvertTo(kInts, u), tables_.at(kInts, tables_.last[k], level));
      const Words voxel = hn::BitCast(kWords, corner);  // kBrickVoxels = 8 times the brick, plus a remainder
      brick[k] = hn::ShiftRight<3>(voxel);
      hn::Store(hn::And(voxel, hn::Set(kWords, kBrickVoxels - 1)), kWords, group.voxel[k]);
      hn::Store(hn::Sub(u, hn::ConvertTo(kFloats, corner)), kFloats, group.inVoxel[k]);
    }
    const Words row = hn::Mul(brick[1], tables_.at(kWords, tables_.row, level));
    const Words layer = hn::Mul(brick[2], tables_.at(kWords, tables_.layer, level));
    const Words index = hn::Add(hn::Add(tables_.at(kWords, tables_.first, level), brick[0]), hn::Add(row, layer));
    hn::Store(hn::GatherIndex(kWords, field_.table.data(), hn::BitCast(kInts, index)), kWords, group.entry);
  }

  // Loads the distance of a corner (into the lower half) and of the next corner along x (into the upper half).
  Words pair(Words corner) const {
    return hn::GatherOffset(kWords, reinterpret_cast<const std::uint32_t*>(field_.distance.data()),
                            hn::BitCast(kInts, hn::ShiftLeft<1>(corner)));
  }

  // In full bricks, finds the first corner of the voxel or, with lists, the corner nearest to the particle. Prefetches
  // the corner's distances, which may be anywhere in memory.
  void chooseCorners(LaneGroup& group) const {
    const Words entry = hn::Load(kWords, group.entry);
    const Mask full = isFull(entry);
    const LaneBits lanes = bitsOf(full);
    if (lanes == 0) return;
    const Words index = hn::AndNot(hn::Set(kWords, kFullBrick), entry);
    const Words x = hn::Add(hn::Mul(index, hn::Set(kWords, kBrickStride)), hn::Load(kWords, group.voxel[0]));
    const Words y = hn::Mul(hn::Load(kWords, group.voxel[1]), hn::Set(kWords, kCornerRow));
    const Words z = hn::Mul(hn::Load(kWords, group.voxel[2]), hn::Set(kWords, kCornerLayer));
    Words cell = hn::IfThenElseZero(hn::RebindMask(kWords, full), hn::Add(hn::Add(x, y), z));
    if constexpr (kLists) cell = nearestOf(group, cell);
    hn::Store(cell, kWords, group.cell);
    const std::uint16_t* distance = field_.distance.data();
    for (const std::uint32_t corner : group.cell) {
      __builtin_prefetch(distance + corner);
      if constexpr (!kLists) __builtin_prefetch(distance + corner + kCornerLayer);
    }
  }

  // In full bricks, loads the distances at the voxel's corners or, with lists, at the corner nearest to the particle.
  void loadDistances(LaneGroup& group) const {
    if (hn::AllFalse(kFloats, isFull(hn::Load(kWords, group.entry)))) return;
    const Words cell = hn::Load(kWords, group.cell);
    if constexpr (kLists) {
      hn::Store(pair(cell), kWords, group.rows[0]);
    } else {
      constexpr std::uint32_t kCorner[4] = {0, kCornerRow, kCornerLayer, kCornerLayer + kCornerRow};
      for (int k = 0; k < 4; ++k) {
        hn::Store(pair(hn::Add(cell, hn::Set(kWords, kCorner[k]))), kWords, group.rows[k]);
      }
    }
  }

  // True for lanes whose particle is in the upper half of its voxel.
  static Mask isUpper(const LaneGroup& group, int axis) {
    return hn::Ge(hn::Load(kFloats, group.inVoxel[axis]), hn::Set(kFloats, 0.5f));
  }

  // Returns the corner of the voxel that is nearest to the particle. `cell`: the voxel's first corner.
  static Words nearestOf(const LaneGroup& group, Words cell) {
    constexpr std::uint32_t kSteps[3] = {1, kCornerRow, kCornerLayer};
    for (int k = 0; k < 3; ++k) {
      cell = hn::Add(cell, wordsWhere(isUpper(group, k), hn::Set(kWords, kSteps[k]), hn::Zero(kWords)));
    }
    return cell;
  }

  // Returns the distance (voxels) that is stored at the corner nearest to the particle.
  static Floats nearestDistance(const LaneGroup& group) {
    Words row = hn::Load(kWords, group.rows[0]);
    if constexpr (!kLists) {
      const Mask y = isUpper(group, 1);
      const Words above = wordsWhere(y, hn::Load(kWords, group.rows[3]), hn::Load(kWords, group.rows[2]));
      row = wordsWhere(isUpper(group, 2), above, wordsWhere(y, hn::Load(kWords, group.rows[1]), row));
      row = wordsWhere(isUpper(group, 0), hn::ShiftRight<16>(row), row);
    }
    return hn::Mul(lowerOf(row), hn::Set(kFloats, kDistanceStep));
  }

  // Returns the distance (voxels) interpolated between the corners of the voxel; for fields without lists.
  static Floats interpolate(const LaneGroup& group) {
    const auto along = [&](int k) {
      const Words row = hn::Load(kWords, group.rows[k]);
      return mixed(lowerOf(row), upperOf(row), hn::Load(kFloats, group.inVoxel[0]));
    };
    const Floats y = hn::Load(kFloats, group.inVoxel[1]);
    const Floats between =
        mixed(mixed(along(0), along(1), y), mixed(along(2), along(3), y), hn::Load(kFloats, group.inVoxel[2]));
    return hn::Mul(between, hn::Set(kFloats, kDistanceStep));
  }

  // Returns the length (voxels) to the exit from the voxel around a corner. `r`: the particle relative to the corner.
  static Floats exitOf(const LaneGroup& group, const Floats (&r)[3]) {
    const auto face = [&](int k) {
      const Floats inverse = hn::Load(kFloats, group.inverse[k]);
      return hn::Mul(hn::Sub(hn::CopySignToAbs(hn::Set(kFloats, kExitPlane), inverse), r[k]), inverse);
    };
    return hn::Min(face(0), hn::Min(face(1), face(2)));
  }

  // A ball without surfaces, around the centre of an empty brick or around the corner nearest to the particle. Lengths
  // are in voxels of the particle's level.
  struct FreeBall {
    Floats radius, chordFactor;  // chordFactor: c in march_rule.h
    Floats r[3];                 // position of the particle relative to the ball's centre
    Mask isolated;               // no surface is within kNearestLimit of the centre
    Floats centre2;              // squared distance of the particle from the centre
    Floats along;                // length from the middle of the particle's chord through the ball to the particle
    Floats ahead;  // lower bound of the length from the particle to the chord's end; with lists, not valid unless
                   // the radius is above kListLimit
  };

  // Returns the free balls of the particles, which move in direction d.
  HWY_INLINE static FreeBall freeBallOf(const LaneGroup& group, const Floats (&d)[3]) {
    const Words entry = hn::Load(kWords, group.entry);
    const Mask full = isFull(entry);
    // As in an empty brick, whose entry has the bits of its distance; changed below for the lanes in full bricks.
    FreeBall ball{};
    ball.radius = hn::BitCast(kFloats, entry);
    ball.chordFactor = hn::Set(kFloats, kEmptyChordFactor);
    ball.isolated = hn::Not(full);
    for (int k = 0; k < 3; ++k) {
      const Ints middle = hn::Sub(hn::BitCast(kInts, hn::Load(kWords, group.voxel[k])), hn::Set(kInts, kHalfBrick));
      ball.r[k] = hn::Add(hn::Load(kFloats, group.inVoxel[k]), hn::ConvertTo(kFloats, middle));
    }
    if (!hn::AllFalse(kFloats, full)) {
      for (int k = 0; k < 3; ++k) {
        const Floats corner = hn::IfThenElseZero(isUpper(group, k), hn::Set(kFloats, 1.0f));
        ball.r[k] = hn::IfThenElse(full, hn::Sub(hn::Load(kFloats, group.inVoxel[k]), corner), ball.r[k]);
      }
      ball.radius = hn::IfThenElse(full, nearestDistance(group), ball.radius);
      ball.isolated = hn::Gt(ball.radius, hn::Set(kFloats, kNearestLimit));
      const Floats factorInFullBrick =
          hn::IfThenElse(ball.isolated, hn::Set(kFloats, kNearestChordFactor), hn::Set(kFloats, kListChordFactor));
      ball.chordFactor = hn::IfThenElse(full, factorInFullBrick, ball.chordFactor);
    }
    ball.centre2 = dotOf(ball.r, ball.r);
    ball.along = dotOf(ball.r, d);
    const Floats across2 = hn::Sub(ball.centre2, hn::Mul(ball.along, ball.along));
    ball.ahead = hn::Sub(hn::Sub(ball.radius, hn::Mul(across2, ball.chordFactor)), ball.along);
    return ball;
  }

  // The length of a step (voxels), and whether the particle may hit a surface on the step (with lists), or is at a
  // surface already (without lists).
  struct Stride {
    Floats length;
    Mask mayHit;
  };

  // Returns the strides with lists. In a full brick, a particle moves to the end of the voxel around the nearest
  // corner, or farther if no surface intersects the voxel; it may hit a triangle if its path leaves the free ball.
  HWY_INLINE static Stride strideWithLists(const LaneGroup& group, const FreeBall& ball) {
    const Mask full = isFull(hn::Load(kWords, group.entry));
    if (hn::AllFalse(kFloats, full)) return {ball.ahead, hn::FirstN(kFloats, 0)};
    const Floats exit = exitOf(group, ball.r);
    const Mask emptyVoxel = hn::Gt(ball.radius, hn::Set(kFloats, kListLimit));
    const Floats exit2 = hn::Add(ball.centre2, hn::Mul(hn::Add(hn::Add(ball.along, ball.along), exit), exit));
    const Floats radius2 = hn::Mul(ball.radius, ball.radius);
    const Mask leavesBall = hn::Or(hn::Gt(ball.centre2, radius2), hn::Gt(exit2, radius2));
    const Floats inFullBrick = hn::IfThenElse(emptyVoxel, hn::Max(ball.ahead, exit), exit);
    return {hn::IfThenElse(full, inFullBrick, ball.ahead), hn::AndNot(emptyVoxel, leavesBall)};
  }

  // Near a surface, the stride is the interpolated distance, and the particle hits if this is at most kHitDistance.
  HWY_INLINE static Stride strideWithoutLists(const LaneGroup& group, const FreeBall& ball) {
    if (hn::AllTrue(kFloats, ball.isolated)) return {ball.ahead, hn::FirstN(kFloats, 0)};
    const Floats distance = interpolate(group);
    return {hn::IfThenElse(ball.isolated, ball.ahead, distance),
            hn::AndNot(ball.isolated, hn::Le(distance, hn::Set(kFloats, kHitDistance)))};
  }

  // Takes one step of the particles in group g, without intersecting triangles yet.
  void advance(std::size_t g) {
    LaneGroup& group = groups_[g];
    const Floats d[3] = {hn::Load(kFloats, group.direction[0]), hn::Load(kFloats, group.direction[1]),
                         hn::Load(kFloats, group.direction[2])};
    const Floats travelled = hn::Load(kFloats, group.travelled);
    // Computes 1 / scale from the bits: scale is a power of two.
    const Words scale = hn::BitCast(kWords, hn::Load(kFloats, group.scale));
    const Floats voxelSize = hn::BitCast(kFloats, hn::Sub(hn::Set(kWords, 254u << 23), scale));
    const FreeBall ball = freeBallOf(group, d);
    const Stride stride = kLists ? strideWithLists(group, ball) : strideWithoutLists(group, ball);
    hn::Store(travelled, kFloats, group.travelledBefore);
    group.mayHit = bitsOf(stride.mayHit) & group.active;
    if (group.mayHit != 0) {
      if constexpr (kLists) {
        queueLines(g, d, travelled, stride.length, voxelSize);
      } else {
        hn::Store(nearestOf(group, hn::Load(kWords, group.cell)), kWords, group.corner);
      }
    }
    // Inactive lanes move too, but only up to the end of their last path.
    const Floats end = hn::Load(kFloats, group.end);
    hn::Store(hn::Min(hn::Add(travelled, hn::Mul(stride.length, voxelSize)), end), kFloats, group.travelled);
    hn::Store(hn::Add(hn::Load(kWords, group.steps), hn::Set(kWords, 1)), kWords, group.steps);
  }

  // Adds a line to intersector_ for each lane of the group that has triangles to test. `travelled` is in voxels of
  // level 0, `exit` (length to the end of the voxel) in voxels of the particle's level, whose size is `voxelSize`.
  void queueLines(std::size_t g, const Floats (&d)[3], Floats travelled, Floats exit, Floats voxelSize) {
    const LaneGroup& group = groups_[g];
    const Floats metresPerUnit = hn::Set(kFloats, static_cast<float>(field_.shape.voxel));
    const Floats voxel = hn::Mul(metresPerUnit, voxelSize);
    const Floats travelledMetres = hn::Mul(travelled, metresPerUnit);
    Floats position[3];  // m, relative to the world's origin
    for (int k = 0; k < 3; ++k) {
      position[k] = hn::Add(hn::Load(kFloats, group.worldOrigin[k]), hn::Mul(d[k], travelledMetres));
    }
    const Floats pathBegin = hn::Mul(hn::Sub(hn::Load(kFloats, group.begin), travelled), metresPerUnit);
    const Floats low = hn::Max(hn::Mul(hn::Set(kFloats, -kBackwardTolerance), voxel), pathBegin);
    const Floats high = hn::Mul(hn::Add(exit, hn::Set(kFloats, kFaceOvershoot)), voxel);
    const std::size_t first = g * kLanes;
    hn::StoreInterleaved4(position[0], position[1], position[2], low, kFloats, &intersector_.start[first].x);
    hn::StoreInterleaved4(d[0], d[1], d[2], high, kFloats, &intersector_.course[first].dx);
    hn::Store(hn::Mul(hn::Set(kFloats, kTieMargin), voxel), kFloats, intersector_.tie + first);
    for (LaneBits lanes = group.mayHit; lanes != 0; lanes &= lanes - 1) {
      const std::size_t lane = firstOf(lanes);
      intersector_.add(first + lane, group.cell[lane]);
    }
  }

  // Returns the lanes of group g whose particles hit a surface in this step.
  LaneBits hitsOf(std::size_t g) const {
    if constexpr (!kLists) return groups_[g].mayHit;
    LaneBits hits = 0;
    for (LaneBits lanes = groups_[g].mayHit; lanes != 0; lanes &= lanes - 1) {
      const std::size_t lane = firstOf(lanes);
      if (intersector_.nearest[g * kLanes + lane].denominator > 0) hits |= LaneBits{1} << lane;
    }
    return hits;
  }

  // Records the hit of the particle in a lane of group g; the travelled distance is in voxels of level 0. Without
  // lists, records the corner and prefetches its entry, from which marchCpu() reads the triangle after the march.
  void recordHit(std::size_t g, std::size_t lane) {
    const LaneGroup& group = groups_[g];
    float travelled = group.travelledBefore[lane];
    std::uint32_t triangleOrCorner = group.corner[lane];
    if constexpr (kLists) {
      const LineHit& nearest = intersector_.nearest[g * kLanes + lane];
      travelled += nearest.numerator / (nearest.denominator * static_cast<float>(field_.shape.voxel));
      triangleOrCorner = nearest.triangle;
    } else {
      __builtin_prefetch(&field_.triangleOrList[triangleOrCorner]);
    }
    record(group.particle[lane], travelled, triangleOrCorner, group.steps[lane], Outcome::Hit);
  }

  // Records the particles that are done, and refills their lanes.
  void recordAndRefill(std::size_t g) {
    LaneGroup& group = groups_[g];
    const LaneBits hits = hitsOf(g);
    const Words steps = hn::Load(kWords, group.steps);
    const Mask exhausted = hn::RebindMask(kFloats, hn::Eq(steps, hn::Set(kWords, maxSteps_)));
    const Mask atEnd = hn::Not(hn::Lt(hn::Load(kFloats, group.travelled), hn::Load(kFloats, group.end)));
    const LaneBits done = (bitsOf(hn::Or(exhausted, atEnd)) & group.active) | hits;
    for (LaneBits lanes = done; lanes != 0; lanes &= lanes - 1) {
      const std::size_t lane = firstOf(lanes);
      if ((hits >> lane & 1) != 0) {
        recordHit(g, lane);
      } else {
        recordWithoutHit(group.particle[lane], group.steps[lane]);
      }
      refill(group, lane);
    }
  }

  const DistanceField& field_;
  const std::uint32_t maxSteps_;
  const Particles& particles_;
  std::span<const std::uint32_t> indices_;
  std::size_t next_ = 0;  // index in indices_ of the next particle to load
  HitRecords& records_;
  LevelTables tables_;
  ListIntersector intersector_;
  LaneGroup groups_[kLaneGroups];
};

}  // namespace scanmill::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
