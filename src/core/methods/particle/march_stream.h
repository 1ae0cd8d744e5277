// Steps particles, as many at a time as the CPU has lanes, for march_cpu.cpp. The shader
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

#include "methods/field/march_rule.h"
#include "methods/particle/march.h"
#include "methods/particle/march_triangles.h"

HWY_BEFORE_NAMESPACE();
namespace scanmill::HWY_NAMESPACE {

constexpr std::size_t kLaneGroups = 12;
static_assert(kLaneGroups * kLanes <= ListIntersector::kLines);

constexpr std::uint32_t kCornerRow = kBrickCorners;
constexpr std::uint32_t kCornerLayer = kBrickCorners * kBrickCorners;

// The particles in a group of lanes.
struct LaneGroup {
  HWY_ALIGN_MAX LaneFloats o[3] = {}, d[3] = {}, begin = {}, end = {};
  HWY_ALIGN_MAX LaneFloats w[3] = {}, inverse[3] = {};  // used only in fields with lists
  HWY_ALIGN_MAX LaneFloats travelled = {};
  HWY_ALIGN_MAX LaneWords outcome = {};  // 4 * number of steps; record() gets this number plus the Outcome
  std::size_t particle[kLanes] = {};
  LaneBits active = 0;  // lanes that have a particle

  // State of the current step.
  HWY_ALIGN_MAX LaneFloats f[3] = {}, scale = {};  // position in the voxel; scale = 2^-level
  HWY_ALIGN_MAX LaneWords in[3] = {};              // coordinates of the voxel in its brick
  HWY_ALIGN_MAX LaneWords entry = {}, cell = {};
  HWY_ALIGN_MAX LaneWords rows[4] = {};           // pairs of distances; with lists, only the pair of the nearest corner
  HWY_ALIGN_MAX LaneFloats travelledBefore = {};  // `travelled` before the advance
  HWY_ALIGN_MAX LaneWords corner = {};  // without lists: the corner nearest to a particle that rests at a surface
  LaneBits mayHit = 0;                  // lanes that rest at a surface, or have triangles to test
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

  template <class D>
  static hn::Vec<D> at(D d, const hn::TFromD<D>* table, Ints level) {
    if constexpr (kLanes == kSize) {
      return hn::TableLookupLanes(hn::Load(d, table), hn::IndicesFromVec(d, level));
    } else {
      return hn::GatherIndex(d, table, level);
    }
  }
};

inline Mask isFull(Words entry) {
  return hn::RebindMask(kFloats, hn::TestBit(entry, hn::Set(kWords, kFullBrick)));
}

inline Floats mixed(Floats a, Floats b, Floats t) {
  return hn::Add(a, hn::Mul(hn::Sub(b, a), t));
}

// Returns the distance in the lower half of each pair; upperOf() returns the distance in the upper half, which belongs
// to the next corner along x.
inline Floats lowerOf(Words pair) {
  return hn::ConvertTo(kFloats, hn::BitCast(kInts, hn::And(pair, hn::Set(kWords, 0xFFFFu))));
}

inline Floats upperOf(Words pair) {
  return hn::ConvertTo(kFloats, hn::BitCast(kInts, hn::ShiftRight<16>(pair)));
}

inline Words wordsWhere(Mask mask, Words yes, Words no) {
  return hn::IfThenElse(hn::RebindMask(kWords, mask), yes, no);
}

// Marches particles. Without lists, the record of a hit contains the corner whose word is the triangle; marchCpu()
// replaces the corner by the triangle.
template <bool kLists>
class ParticleStream {
 public:
  ParticleStream(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t steps,
                 const Particles& particles, std::span<const std::uint32_t> which, HitRecords& records)
      : field_(field),
        exhaustedAt_(4 * steps),
        particles_(particles),
        which_(which),
        records_(records),
        tables_(field),
        intersector_(field, triangles) {}

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
  void record(std::size_t i, float travelled, std::uint32_t triangle, std::uint32_t outcome) {
    records_.travelled[i] = travelled;
    records_.triangle[i] = triangle;
    records_.outcome[i] = outcome;
  }

  // Loads the next particle into a lane. If no particle is left, the lane becomes inactive.
  void refill(LaneGroup& group, std::size_t lane) {
    group.active &= ~(LaneBits{1} << lane);
    while (next_ < which_.size()) {
      const std::uint32_t i = which_[next_++];
      const std::uint32_t taken = 4 * records_.stepsOf(i);
      if (taken >= exhaustedAt_ || !(particles_.begin[i] < particles_.end[i])) {
        record(i, 0, 0, taken + static_cast<std::uint32_t>(taken >= exhaustedAt_ ? Outcome::Exhausted : Outcome::Miss));
        continue;
      }
      group.o[0][lane] = particles_.ox[i];
      group.o[1][lane] = particles_.oy[i];
      group.o[2][lane] = particles_.oz[i];
      group.d[0][lane] = particles_.dx[i];
      group.d[1][lane] = particles_.dy[i];
      group.d[2][lane] = particles_.dz[i];
      group.begin[lane] = group.travelled[lane] = particles_.begin[i];
      group.end[lane] = particles_.end[i];
      if constexpr (kLists) {
        group.w[0][lane] = particles_.wx[i];
        group.w[1][lane] = particles_.wy[i];
        group.w[2][lane] = particles_.wz[i];
        group.inverse[0][lane] = particles_.ix[i];
        group.inverse[1][lane] = particles_.iy[i];
        group.inverse[2][lane] = particles_.iz[i];
      }
      group.outcome[lane] = taken;
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
      q[k] = hn::Add(hn::Load(kFloats, group.o[k]), hn::Mul(hn::Load(kFloats, group.d[k]), travelled));
    }
    const Floats most = hn::Max(hn::Abs(q[0]), hn::Max(hn::Abs(q[1]), hn::Abs(q[2])));
    const Floats share = hn::Mul(most, hn::Set(kFloats, 1.0f / field_.shape.reach));
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
      const Words word = hn::BitCast(kWords, corner);
      brick[k] = hn::ShiftRight<3>(word);
      hn::Store(hn::And(word, hn::Set(kWords, 7)), kWords, group.in[k]);
      hn::Store(hn::Sub(u, hn::ConvertTo(kFloats, corner)), kFloats, group.f[k]);
    }
    const Words row = hn::Mul(brick[1], tables_.at(kWords, tables_.row, level));
    const Words layer = hn::Mul(brick[2], tables_.at(kWords, tables_.layer, level));
    const Words at = hn::Add(hn::Add(tables_.at(kWords, tables_.first, level), brick[0]), hn::Add(row, layer));
    hn::Store(hn::GatherIndex(kWords, field_.table.data(), hn::BitCast(kInts, at)), kWords, group.entry);
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
    const Words x = hn::Add(hn::Mul(index, hn::Set(kWords, kBrickStride)), hn::Load(kWords, group.in[0]));
    const Words y = hn::Mul(hn::Load(kWords, group.in[1]), hn::Set(kWords, kCornerRow));
    const Words z = hn::Mul(hn::Load(kWords, group.in[2]), hn::Set(kWords, kCornerLayer));
    Words cell = hn::IfThenElseZero(hn::RebindMask(kWords, full), hn::Add(hn::Add(x, y), z));
    if constexpr (kLists) cell = nearestOf(group, cell);
    hn::Store(cell, kWords, group.cell);
    const std::uint16_t* distance = field_.distance.data();
    for (const std::uint32_t corner : group.cell) {
      __builtin_prefetch(distance + corner);
      if constexpr (!kLists) __builtin_prefetch(distance + corner + kCornerLayer);
    }
  }

  // For particles in full bricks, loads the distances at the corners of the voxel or, with lists, at the corner that
  // aim() chose.
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

  static Mask isUpper(const LaneGroup& group, int axis) {
    return hn::Ge(hn::Load(kFloats, group.f[axis]), hn::Set(kFloats, 0.5f));
  }

  static Words nearestOf(const LaneGroup& group, Words cell) {
    constexpr std::uint32_t kSteps[3] = {1, kCornerRow, kCornerLayer};
    for (int k = 0; k < 3; ++k) {
      cell = hn::Add(cell, wordsWhere(isUpper(group, k), hn::Set(kWords, kSteps[k]), hn::Zero(kWords)));
    }
    return cell;
  }

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

  static Floats interpolate(const LaneGroup& group) {
    const auto along = [&](int k) {
      const Words row = hn::Load(kWords, group.rows[k]);
      return mixed(lowerOf(row), upperOf(row), hn::Load(kFloats, group.f[0]));
    };
    const Floats y = hn::Load(kFloats, group.f[1]);
    const Floats between =
        mixed(mixed(along(0), along(1), y), mixed(along(2), along(3), y), hn::Load(kFloats, group.f[2]));
    return hn::Mul(between, hn::Set(kFloats, kDistanceStep));
  }

  // Returns the length (voxels) after which the particle leaves its voxel.
  static Floats exitOf(const LaneGroup& group, const Floats (&r)[3]) {
    const auto face = [&](int k) {
      const Floats inverse = hn::Load(kFloats, group.inverse[k]);
      return hn::Mul(hn::Sub(hn::CopySignToAbs(hn::Set(kFloats, kExitPlane), inverse), r[k]), inverse);
    };
    return hn::Min(face(0), hn::Min(face(1), face(2)));
  }

  // Takes one step of the particles in group g, without intersecting triangles yet.
  void advance(std::size_t g) {
    LaneGroup& group = groups_[g];
    const Floats d[3] = {hn::Load(kFloats, group.d[0]), hn::Load(kFloats, group.d[1]), hn::Load(kFloats, group.d[2])};
    const Floats travelled = hn::Load(kFloats, group.travelled);
    const Floats scale = hn::Load(kFloats, group.scale);
    const Floats voxelSize = hn::BitCast(kFloats, hn::Sub(hn::Set(kWords, 254u << 23), hn::BitCast(kWords, scale)));
    const Words entry = hn::Load(kWords, group.entry);
    const Mask full = isFull(entry);
    const bool anyFull = !hn::AllFalse(kFloats, full);
    // Computes `radius`, the radius of a ball without surfaces, and r, the particle's position relative to the ball's
    // centre, which is the centre of the brick or the nearest corner.
    Floats r[3];
    for (int k = 0; k < 3; ++k) {
      const Ints middle = hn::Sub(hn::BitCast(kInts, hn::Load(kWords, group.in[k])), hn::Set(kInts, kBrickVoxels / 2));
      r[k] = hn::Add(hn::Load(kFloats, group.f[k]), hn::ConvertTo(kFloats, middle));
    }
    Floats radius = hn::BitCast(kFloats, entry);
    Floats chordFactor = hn::Set(kFloats, kEmptyChordFactor);
    [[maybe_unused]] Mask far = hn::Not(full);
    if (anyFull) {
      for (int k = 0; k < 3; ++k) {
        const Floats corner = hn::IfThenElseZero(isUpper(group, k), hn::Set(kFloats, 1.0f));
        r[k] = hn::IfThenElse(full, hn::Sub(hn::Load(kFloats, group.f[k]), corner), r[k]);
      }
      radius = hn::IfThenElse(full, nearestDistance(group), radius);
      far = hn::Gt(radius, hn::Set(kFloats, kNearestLimit));
      const Floats fullChordFactor =
          hn::IfThenElse(far, hn::Set(kFloats, kNearestChordFactor), hn::Set(kFloats, kListChordFactor));
      chordFactor = hn::IfThenElse(full, fullChordFactor, chordFactor);
    }
    const Floats square = dotOf(r, r);
    const Floats along = dotOf(r, d);
    const Floats half = hn::Sub(radius, hn::Mul(hn::Sub(square, hn::Mul(along, along)), chordFactor));
    Floats ahead = hn::Sub(half, along);
    Mask mayHit = hn::FirstN(kFloats, 0);
    if constexpr (kLists) {
      if (anyFull) {
        const Floats exit = exitOf(group, r);
        const Mask inside = hn::Gt(radius, hn::Set(kFloats, kListLimit));
        const Floats out = hn::Add(square, hn::Mul(hn::Add(hn::Add(along, along), exit), exit));
        const Floats ball = hn::Mul(radius, radius);
        mayHit = hn::AndNot(inside, hn::Or(hn::Gt(square, ball), hn::Gt(out, ball)));
        const Floats longer = hn::IfThenElse(inside, hn::Max(ahead, exit), exit);
        ahead = hn::IfThenElse(full, longer, ahead);
      }
    } else if (!hn::AllTrue(kFloats, far)) {
      const Floats here = interpolate(group);
      mayHit = hn::AndNot(far, hn::Le(here, hn::Set(kFloats, kHitDistance)));
      ahead = hn::IfThenElse(far, ahead, here);
    }
    hn::Store(travelled, kFloats, group.travelledBefore);
    group.mayHit = bitsOf(mayHit) & group.active;
    if (group.mayHit != 0) {
      if constexpr (kLists) {
        queueLines(g, d, travelled, ahead, voxelSize);
      } else {
        hn::Store(nearestOf(group, hn::Load(kWords, group.cell)), kWords, group.corner);
      }
    }
    // Inactive lanes move too, but only up to the end of their last path.
    const Floats end = hn::Load(kFloats, group.end);
    hn::Store(hn::Min(hn::Add(travelled, hn::Mul(ahead, voxelSize)), end), kFloats, group.travelled);
    hn::Store(hn::Add(hn::Load(kWords, group.outcome), hn::Set(kWords, 4)), kWords, group.outcome);
  }

  // Adds a line to tester_ for each lane of the group that has triangles to test.
  void queueLines(std::size_t g, const Floats (&d)[3], Floats travelled, Floats exit, Floats voxelSize) {
    const LaneGroup& group = groups_[g];
    const Floats metresPerUnit = hn::Set(kFloats, static_cast<float>(field_.shape.voxel));
    const Floats voxel = hn::Mul(metresPerUnit, voxelSize);
    const Floats gone = hn::Mul(travelled, metresPerUnit);
    Floats place[3];
    for (int k = 0; k < 3; ++k) place[k] = hn::Add(hn::Load(kFloats, group.w[k]), hn::Mul(d[k], gone));
    const Floats past = hn::Mul(hn::Sub(hn::Load(kFloats, group.begin), travelled), metresPerUnit);
    const Floats low = hn::Max(hn::Mul(hn::Set(kFloats, -kBackwardTolerance), voxel), past);
    const Floats high = hn::Mul(hn::Add(exit, hn::Set(kFloats, kFaceOvershoot)), voxel);
    const std::size_t first = g * kLanes;
    hn::StoreInterleaved4(place[0], place[1], place[2], low, kFloats, &intersector_.start[first].x);
    hn::StoreInterleaved4(d[0], d[1], d[2], high, kFloats, &intersector_.course[first].dx);
    hn::Store(hn::Mul(hn::Set(kFloats, kTieMargin), voxel), kFloats, intersector_.tie + first);
    for (LaneBits lanes = group.mayHit; lanes != 0; lanes &= lanes - 1) {
      const std::size_t lane = firstOf(lanes);
      intersector_.add(first + lane, group.cell[lane]);
    }
  }

  // Records the particles that are done, and refills their lanes.
  void recordAndRefill(std::size_t g) {
    LaneGroup& group = groups_[g];
    LaneBits hits = group.mayHit;
    if constexpr (kLists) {
      hits = 0;
      for (LaneBits lanes = group.mayHit; lanes != 0; lanes &= lanes - 1) {
        const std::size_t lane = firstOf(lanes);
        if (intersector_.nearest[g * kLanes + lane].denominator > 0) hits |= LaneBits{1} << lane;
      }
    }
    const Mask spent = hn::RebindMask(kFloats, hn::Eq(hn::Load(kWords, group.outcome), hn::Set(kWords, exhaustedAt_)));
    const Mask done = hn::Not(hn::Lt(hn::Load(kFloats, group.travelled), hn::Load(kFloats, group.end)));
    LaneBits finished = (bitsOf(hn::Or(spent, done)) & group.active) | hits;
    if (finished == 0) return;
    for (; finished != 0; finished &= finished - 1) {
      const std::size_t lane = firstOf(finished);
      const std::size_t i = group.particle[lane];
      const std::uint32_t steps = group.outcome[lane];
      if ((hits >> lane & 1) == 0) {
        const bool exhausted = steps == exhaustedAt_;
        record(i, 0, 0, steps + static_cast<std::uint32_t>(exhausted ? Outcome::Exhausted : Outcome::Miss));
      } else if constexpr (kLists) {
        const LineHit& nearest = intersector_.nearest[g * kLanes + lane];
        const float metresPerUnit = static_cast<float>(field_.shape.voxel);
        record(i, group.travelledBefore[lane] + nearest.numerator / (nearest.denominator * metresPerUnit),
               nearest.triangle, steps);
      } else {
        __builtin_prefetch(&field_.word[group.corner[lane]]);
        record(i, group.travelledBefore[lane], group.corner[lane], steps);
      }
      refill(group, lane);
    }
  }

  const DistanceField& field_;
  const std::uint32_t exhaustedAt_;  // the largest number of steps, times 4 as in LaneGroup::outcome
  const Particles& particles_;
  std::span<const std::uint32_t> which_;
  std::size_t next_ = 0;  // index in which_ of the next particle to load
  HitRecords& records_;
  LevelTables tables_;
  ListIntersector intersector_;
  LaneGroup groups_[kLaneGroups];
};

}  // namespace scanmill::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
