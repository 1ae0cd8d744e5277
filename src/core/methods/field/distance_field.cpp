#include "methods/field/distance_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "methods/field/brick.h"
#include "methods/field/nearby.h"

namespace scanmill {

namespace {

// Returns the level that is used at a point: the smallest l with |coordinates| <= reach * 2^l, or the last level.
int levelAt(const DistanceField& field, const Vec3f& point) {
  const float largest = std::max({std::fabs(point.x), std::fabs(point.y), std::fabs(point.z)});
  const int lastLevel = static_cast<int>(field.levels.size()) - 1;
  int level = 0;
  for (float reach = field.shape.reach; level < lastLevel && largest > reach; reach *= 2) ++level;
  return level;
}

constexpr std::uint32_t kNewBrick = 0xFFFFFFFFu;  // table entry of a full brick that has no index in a pool yet
constexpr std::uint32_t kNone = 0xFFFFFFFFu;      // means "no index"
constexpr float kEmptyWorldDistance = 1e30f;      // voxels, the distance to surfaces in an empty world
constexpr std::size_t kBricksPerTask = 8;
// Largest number of full bricks: march_stream.h addresses their distances by byte offsets of 31 bits.
constexpr std::size_t kMostBricks = 0x7FFFFFFFu / (kBrickStride * sizeof(std::uint16_t));

// Returns the number of bricks for which a moving field with `count` bricks reserves space. On a street this is enough
// for about twenty moves of the field; then its bricks must be copied to a new pool.
constexpr std::size_t withRoom(std::size_t count) {
  return count + count / 2;
}

// Returns the table entry of a brick. `distance`: from the brick's centre to the nearest surface (voxels).
constexpr std::uint32_t tableEntry(float distance) {
  return distance >= kEmptyBrick ? std::bit_cast<std::uint32_t>(distance) : kNewBrick;
}

// Builds one field: fills the table, makes the new bricks in a pool, then places their lists in the pool.
class Builder {
 public:
  Builder(const World& world, const FieldShape& shape, const std::vector<std::shared_ptr<const DistanceField>>& before)
      : world_(world), field_(std::make_shared<DistanceField>()) {
    if (!world.placed.empty()) throw Error("particle: a field cannot be built of instanced meshes");
    for (const auto& field : before) {
      if (field->shape.voxel != shape.voxel || field->shape.lists != shape.lists) continue;
      if (earlierPool_ == nullptr) earlierPool_ = field->pool;
      if (field->pool == earlierPool_) earlierFields_.push_back(field.get());
    }
    field_->shape = shape;
    field_->levels = fieldLevels(shape);
  }

  std::shared_ptr<const DistanceField> build() {
    std::unique_lock<std::mutex> lock;
    if (earlierPool_ != nullptr) lock = std::unique_lock(earlierPool_->appending);
    fillTable();
    findNewBricks();
    // A field gets a new pool if there is no earlier pool, if more of the field's bricks are new than from earlier
    // fields, or if the earlier pool has no room for the new bricks.
    const bool appended =
        earlierPool_ != nullptr && reusedBricks_ >= newEntries_.size() && earlierPool_->room() >= newEntries_.size();
    appended ? appendToEarlierPool() : startOwnPool();
    makeBricks();
    if (field_->shape.lists) {
      std::uint64_t listsEnd = placeLists();
      if (appended && listsEnd > pool_->lists.size()) {
        startOwnPool();
        listsEnd = placeLists();
      }
      if (listsEnd >= kNoTriangle) {
        throw Error(
            "particle: voxels of {:g} m give more than 4 billion entries in lists of triangles: choose "
            "larger voxels (voxel_m), or `refine: none`",
            field_->shape.voxel);
      }
      if (pool_->lists.empty()) {
        pool_->lists.resize(earlierPool_ == nullptr ? listsEnd
                                                    : std::min<std::uint64_t>(withRoom(listsEnd), kNoTriangle - 1));
      }
    }
    copyBricksAndLists();
    pool_->bricks = firstPoolIndex_ + bricks_.size();
    field_->distance = std::span(pool_->distance).first(pool_->bricks * kBrickStride);
    field_->triangleOrList = std::span(pool_->triangleOrList).first(pool_->bricks * kBrickStride);
    field_->lists = std::span(pool_->lists).first(pool_->firstList[pool_->bricks]);
    field_->pool = std::move(pool_);
    return std::move(field_);
  }

 private:
  BrickFrame frameOf(std::size_t level, const Corner& brick) const {
    const double voxel = std::ldexp(field_->shape.voxel, static_cast<int>(level));
    const auto centre = [&](std::int64_t b) { return static_cast<double>(b * kBrickVoxels + kHalfBrick) * voxel; };
    return {{centre(brick[0]), centre(brick[1]), centre(brick[2])}, voxel};
  }

  // Returns the frame of the brick whose table entry has the index `entry`.
  BrickFrame frameOf(std::uint32_t entry) const {
    std::size_t level = field_->levels.size() - 1;
    while (field_->levels[level].firstEntry > entry) --level;
    return frameOf(level, brickOf(level, entry));
  }

  // Returns the lattice coordinates of the brick of this level whose table entry has the index `entry`.
  Corner brickOf(std::size_t level, std::uint32_t entry) const {
    const LevelBox& box = field_->shape.levels[level];
    const std::uint32_t inLevel = entry - field_->levels[level].firstEntry;
    return {box.firstBrick[0] + inLevel % box.bricks[0], box.firstBrick[1] + inLevel / box.bricks[0] % box.bricks[1],
            box.firstBrick[2] + inLevel / box.bricks[0] / box.bricks[1]};
  }

  // Returns the table entry of the brick with lattice coordinates `brick`; null if the field does not have the brick.
  static const std::uint32_t* entryOf(const DistanceField& field, std::size_t level, const Corner& brick) {
    if (level >= field.levels.size()) return nullptr;
    const LevelBox& box = field.shape.levels[level];
    std::size_t entry = field.levels[level].firstEntry;
    std::size_t stride = 1;  // number of table entries from a brick to the next one along axis k
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int64_t index = brick[k] - box.firstBrick[k];
      if (index < 0 || index >= box.bricks[k]) return nullptr;
      entry += static_cast<std::size_t>(index) * stride;
      stride *= box.bricks[k];
    }
    return &field.table[entry];
  }

  // Returns the table entry of a brick in the first earlier field that has the brick; null if none has it.
  const std::uint32_t* earlierEntry(std::size_t level, const Corner& brick) const {
    for (const DistanceField* field : earlierFields_) {
      if (const std::uint32_t* entry = entryOf(*field, level, brick)) return entry;
    }
    return nullptr;
  }

  // Fills the table entries of a row of bricks along x. Copies the entry of a brick that an earlier field has.
  // Otherwise the entry is the distance of an empty brick, or kNewBrick for a full brick.
  void fillRow(std::size_t level, std::size_t row, FacetCache& facets) {
    const LevelBox& box = field_->shape.levels[level];
    const auto first = static_cast<std::uint32_t>(field_->levels[level].firstEntry + row * box.bricks[0]);
    std::uint32_t nearest = 0;  // triangle nearest to the centre of the previous brick: a first guess for the next one
    for (std::uint32_t i = 0; i < box.bricks[0]; ++i) {
      const Corner brick = brickOf(level, first + i);
      std::uint32_t& entry = field_->table[first + i];
      if (const std::uint32_t* earlier = earlierEntry(level, brick)) {
        entry = *earlier;
      } else if (world_.baked.triangles.empty()) {
        entry = tableEntry(kEmptyWorldDistance);
      } else {
        const BrickFrame frame = frameOf(level, brick);
        facets.startBrick();
        const float guess2 = facets.facetOf(world_.baked, nearest, frame).distance2(0, 0, 0);
        const NearestFacet facet = nearestFacet(world_, frame, {}, {guess2, nearest}, facets);
        nearest = facet.triangle;
        entry = tableEntry(std::sqrt(facet.distance2) * brick::kShortened);
      }
    }
  }

  // Fills the table: see fillRow().
  void fillTable() {
    constexpr std::size_t kGrain = 4;  // rows per task
    std::uint64_t entries = 0;
    for (const LevelBox& box : field_->shape.levels) entries += box.size();
    field_->table.resize(entries);
    for (std::size_t level = 0; level < field_->levels.size(); ++level) {
      const LevelBox& box = field_->shape.levels[level];
      parallelFor(std::size_t{box.bricks[1]} * box.bricks[2], kGrain, [&](std::size_t begin, std::size_t end) {
        FacetCache facets;
        for (std::size_t row = begin; row < end; ++row) fillRow(level, row, facets);
      });
    }
  }

  // Sets newEntries_ to the new full bricks, and counts the reused ones. Throws Error if the field has too many bricks.
  void findNewBricks() {
    for (std::uint32_t i = 0; i < field_->table.size(); ++i) {
      const std::uint32_t entry = field_->table[i];
      if (entry == kNewBrick) {
        newEntries_.push_back(i);
      } else if (entry >= kFullBrick) {
        ++reusedBricks_;
      }
    }
    if (reusedBricks_ + newEntries_.size() <= kMostBricks) return;
    throw Error(
        "particle: voxels of {:g} m give more than {} million bricks near surfaces: choose larger voxels "
        "(voxel_m) or fewer (voxels)",
        field_->shape.voxel, kMostBricks / 1'000'000);
  }

  // Gives new bricks indices in the pool of the earlier fields, after the bricks that the pool already contains.
  void appendToEarlierPool() {
    pool_ = earlierPool_;
    firstPoolIndex_ = pool_->bricks;
    for (const std::uint32_t entry : newEntries_) {
      const auto newNumber = static_cast<std::uint32_t>(bricks_.size());
      field_->table[entry] = kFullBrick + static_cast<std::uint32_t>(firstPoolIndex_) + newNumber;
      bricks_.push_back({entry, newNumber, kNone});
    }
  }

  // Gives all bricks indices in a new pool, including new bricks that were already appended to the earlier pool.
  void startOwnPool() {
    const bool wereAppended = !bricks_.empty();
    const std::size_t count = reusedBricks_ + newEntries_.size();
    pool_ = std::make_shared<BrickPool>(earlierPool_ != nullptr ? std::min(withRoom(count), kMostBricks) : count);
    std::vector<Brick> bricks;
    bricks.reserve(count);
    std::uint32_t newNumber = 0;
    for (std::uint32_t i = 0; i < field_->table.size(); ++i) {
      std::uint32_t& entry = field_->table[i];
      if (entry < kFullBrick) continue;
      const std::uint32_t copiedFrom = entry == kNewBrick ? kNone : entry - kFullBrick;
      const bool isNew = copiedFrom == kNone || (wereAppended && copiedFrom >= firstPoolIndex_);
      entry = kFullBrick + static_cast<std::uint32_t>(bricks.size());
      bricks.push_back({i, isNew ? newNumber++ : kNone, copiedFrom});
    }
    bricks_ = std::move(bricks);
    firstPoolIndex_ = 0;
  }

  // Makes the new bricks in the pool, and their lists in lists_.
  void makeBricks() {
    lists_.resize(newEntries_.size());
    parallelFor(bricks_.size(), kBricksPerTask, [&](std::size_t begin, std::size_t end) {
      BrickMaker maker(world_, field_->shape.lists);
      std::vector<std::uint32_t> listEntries;
      for (std::size_t i = begin; i < end; ++i) {
        const Brick& brick = bricks_[i];
        if (brick.newNumber == kNone) continue;
        const std::size_t firstCorner = (firstPoolIndex_ + i) * kBrickStride;
        listEntries.clear();
        maker.make(frameOf(brick.entry), &pool_->distance[firstCorner], &pool_->triangleOrList[firstCorner],
                   listEntries);
        lists_[brick.newNumber].assign(listEntries.begin(), listEntries.end());
      }
    });
  }

  // Sets the start of each brick's lists. Returns the end of the last brick's lists, which may exceed the pool's space.
  std::uint64_t placeLists() {
    const auto countOf = [&](const Brick& brick) -> std::uint64_t {
      if (brick.newNumber != kNone) return lists_[brick.newNumber].size();
      const auto& first = earlierPool_->firstList;
      return first[brick.copiedFrom + 1] - first[brick.copiedFrom];
    };
    std::uint64_t end = pool_->firstList[firstPoolIndex_];
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      end += countOf(bricks_[i]);
      pool_->firstList[firstPoolIndex_ + i + 1] = static_cast<std::uint32_t>(end);
    }
    return end;
  }

  // Copies the bricks that are taken from the earlier pool, and the lists of all bricks, to their indices in the pool.
  // placeLists() must have been called if the field has lists.
  void copyBricksAndLists() {
    parallelForEach(bricks_.size(), kBricksPerTask, [&](std::size_t i) {
      const std::uint32_t copiedFrom = bricks_[i].copiedFrom;
      const std::size_t firstCorner = (firstPoolIndex_ + i) * kBrickStride;
      if (copiedFrom != kNone) {
        const std::size_t firstCopied = std::size_t{copiedFrom} * kBrickStride;
        std::copy_n(&earlierPool_->distance[firstCopied], kBrickStride, &pool_->distance[firstCorner]);
        std::copy_n(&earlierPool_->triangleOrList[firstCopied], kBrickStride, &pool_->triangleOrList[firstCorner]);
      }
      if (field_->shape.lists) copyLists(i);
    });
  }

  // Copies the lists of brick i to the pool, and shifts the starts of lists that the brick's corners store.
  void copyLists(std::size_t i) {
    const Brick& brick = bricks_[i];
    const std::size_t poolIndex = firstPoolIndex_ + i;
    const bool isNew = brick.newNumber != kNone;
    const std::uint32_t first = pool_->firstList[poolIndex];
    const std::uint32_t firstBefore = isNew ? 0 : earlierPool_->firstList[brick.copiedFrom];
    const std::uint32_t* entries = isNew ? lists_[brick.newNumber].data() : earlierPool_->lists.data() + firstBefore;
    std::uint32_t* const lists = &pool_->triangleOrList[poolIndex * kBrickStride];  // by corner
    for (int c = 0; c < kBrickStride; ++c) lists[c] += lists[c] == kNoTriangle ? 0 : first - firstBefore;
    std::copy_n(entries, pool_->firstList[poolIndex + 1] - first, pool_->lists.begin() + first);
  }

  const World& world_;
  std::vector<const DistanceField*> earlierFields_;  // earlier fields, all of one pool
  std::shared_ptr<BrickPool> earlierPool_;           // pool of the earlier fields; null if there are none
  std::shared_ptr<DistanceField> field_;
  std::shared_ptr<BrickPool> pool_;

  // A full brick (a brick that stores distances), with an index in the pool.
  struct Brick {
    std::uint32_t entry;       // index of the brick's table entry
    std::uint32_t newNumber;   // number of a new brick, an index into lists_; kNone for a brick from an earlier field
    std::uint32_t copiedFrom;  // index in earlierPool_ of a brick that is copied from there; otherwise kNone
  };
  std::vector<Brick> bricks_;                      // in the order of their indices in the pool, which are consecutive
  std::size_t firstPoolIndex_ = 0;                 // index in the pool of the first brick of bricks_
  std::vector<std::uint32_t> newEntries_;          // indices of the table entries of new bricks
  std::size_t reusedBricks_ = 0;                   // number of bricks taken from earlier fields
  std::vector<std::vector<std::uint32_t>> lists_;  // by new brick: the entries of its lists
};

}  // namespace

std::vector<FieldLevel> fieldLevels(const FieldShape& shape) {
  std::vector<FieldLevel> levels;
  std::uint32_t firstEntry = 0;
  const std::array<double, 3> centre{shape.centre.x, shape.centre.y, shape.centre.z};
  for (std::size_t l = 0; l < shape.levels.size(); ++l) {
    const LevelBox& box = shape.levels[l];
    FieldLevel level{.offset = {}, .scale = std::ldexp(1.0f, -int(l)), .bricks = box.bricks, .firstEntry = firstEntry};
    for (std::size_t k = 0; k < 3; ++k) {
      // The offset is counted in complete bricks of level 0, so that it is exact.
      const auto centreBrick = std::llround(centre[k] / (kBrickVoxels * shape.voxel));
      const std::int64_t bricks = centreBrick - box.firstBrick[k] * (std::int64_t{1} << l);
      level.offset[k] = static_cast<float>(std::ldexp(static_cast<double>(bricks * kBrickVoxels), -int(l)));
    }
    firstEntry += static_cast<std::uint32_t>(box.size());
    levels.push_back(level);
  }
  return levels;
}

std::shared_ptr<const DistanceField> buildField(const World& world, const FieldShape& shape,
                                                const std::vector<std::shared_ptr<const DistanceField>>& before) {
  return Builder(world, shape, before).build();
}

double voxelSizeAt(const DistanceField& field, const Vec3f& point) {
  return std::ldexp(field.shape.voxel, levelAt(field, point));
}

std::uint32_t triangleAt(const DistanceField& field, const Vec3f& point) {
  const FieldLevel& level = field.levels[static_cast<std::size_t>(levelAt(field, point))];
  const float coordinates[3] = {point.x, point.y, point.z};
  std::uint32_t entry = level.firstEntry;  // index in DistanceField::table of the point's brick
  std::uint32_t entryStride = 1;           // number of entries from a brick to the next one along axis k
  std::uint32_t nearest = 0;               // index of the nearest corner among the brick's corners
  std::uint32_t cornerStride = 1;          // number of corners from a corner to the next one along axis k
  for (std::size_t k = 0; k < 3; ++k) {
    const float u = std::max(coordinates[k] * level.scale + level.offset[k], 0.0f);
    const std::uint32_t voxel = std::min(static_cast<std::uint32_t>(u), level.bricks[k] * kBrickVoxels - 1);
    const bool isUpper = u - static_cast<float>(voxel) >= 0.5f;  // in the upper half of the voxel
    entry += voxel / kBrickVoxels * entryStride;
    entryStride *= level.bricks[k];
    nearest += (voxel % kBrickVoxels + (isUpper ? 1 : 0)) * cornerStride;
    cornerStride *= kBrickCorners;
  }
  const std::uint32_t brick = field.table[entry];
  if (brick < kFullBrick) return kNoTriangle;
  return field.triangleOrList[std::size_t{brick - kFullBrick} * kBrickStride + nearest];
}

}  // namespace scanmill
