#include "methods/field/build.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "methods/field/brick.h"
#include "methods/field/nearby.h"
#include "methods/particle/shape.h"

namespace scanmill {

namespace {

constexpr std::uint32_t kNew = kNoWord;  // instead of an index of a brick of the field before
constexpr float kNothing = 1e30f;        // voxels, to the nearest surface of an empty world
constexpr std::size_t kBricksPerTask = 8;

class Builder {
 public:
  Builder(const World& world, const FieldShape& shape, const DistanceField* before);

  std::shared_ptr<const DistanceField> build();

 private:
  BrickPlace placeOf(std::size_t level, const Corner& brick) const;
  Corner brickOf(std::size_t level, std::uint32_t entry) const;
  std::size_t levelOf(std::uint32_t entry) const;
  const std::uint32_t* entryBefore(std::size_t level, const Corner& brick) const;
  void fillRow(std::size_t level, std::size_t row, FacetCache& facets);
  void numberBricks();
  void makeBricks();
  void placeLists();
  void assemble();

  const World& world_;
  const DistanceField* before_;
  std::shared_ptr<DistanceField> field_;
  std::vector<std::uint32_t> keptBefore_;            // per entry, full ones only: see DistanceField::before
  std::vector<std::uint32_t> bricks_;                // per full brick, its entry of the table
  std::vector<std::vector<std::uint32_t>> entries_;  // per full brick, its lists; of new ones
};

Builder::Builder(const World& world, const FieldShape& shape, const DistanceField* before)
    : world_(world), before_(before), field_(std::make_shared<DistanceField>()) {
  if (!world.placed.empty()) throw Error("particle: a field is built of a world without instanced meshes");
  if (before_ != nullptr && (before_->shape.voxel != shape.voxel || before_->shape.lists != shape.lists)) {
    before_ = nullptr;
  }
  static std::atomic<std::uint64_t> built{0};
  field_->number = ++built;
  field_->movedFrom = before_ != nullptr ? before_->number : 0;
  field_->shape = shape;
  field_->levels = fieldLevels(shape);
}

BrickPlace Builder::placeOf(std::size_t level, const Corner& brick) const {
  const double voxel = std::ldexp(field_->shape.voxel, static_cast<int>(level));
  const auto centre = [&](std::int64_t b) { return static_cast<double>(b * kBrickVoxels + kHalfBrick) * voxel; };
  return {{centre(brick[0]), centre(brick[1]), centre(brick[2])}, voxel};
}

std::size_t Builder::levelOf(std::uint32_t entry) const {
  std::size_t level = field_->levels.size() - 1;
  while (field_->levels[level].firstEntry > entry) --level;
  return level;
}

Corner Builder::brickOf(std::size_t level, std::uint32_t entry) const {
  const LevelBox& box = field_->shape.levels[level];
  const std::uint32_t i = entry - field_->levels[level].firstEntry;
  return {box.firstBrick[0] + i % box.bricks[0], box.firstBrick[1] + i / box.bricks[0] % box.bricks[1],
          box.firstBrick[2] + i / box.bricks[0] / box.bricks[1]};
}

// Of the field before; null where it has no such brick.
const std::uint32_t* Builder::entryBefore(std::size_t level, const Corner& brick) const {
  if (before_ == nullptr || level >= before_->levels.size()) return nullptr;
  const LevelBox& box = before_->shape.levels[level];
  std::array<std::uint32_t, 3> at;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::int64_t i = brick[k] - box.firstBrick[k];
    if (i < 0 || i >= box.bricks[k]) return nullptr;
    at[k] = static_cast<std::uint32_t>(i);
  }
  return &before_->table[before_->levels[level].firstEntry + (at[2] * box.bricks[1] + at[1]) * box.bricks[0] + at[0]];
}

// Which bricks of a row along x are empty, and how far they are from everything.
void Builder::fillRow(std::size_t level, std::size_t row, FacetCache& facets) {
  const LevelBox& box = field_->shape.levels[level];
  const auto first = static_cast<std::uint32_t>(field_->levels[level].firstEntry + row * box.bricks[0]);
  std::uint32_t nearest = 0;
  for (std::uint32_t i = 0; i < box.bricks[0]; ++i) {
    const Corner brick = brickOf(level, first + i);
    std::uint32_t& entry = field_->table[first + i];
    if (const std::uint32_t* before = entryBefore(level, brick)) {
      entry = *before;
      keptBefore_[first + i] = *before >= kFullBrick ? *before - kFullBrick : 0;
      continue;
    }
    keptBefore_[first + i] = kNew;
    float distance = kNothing;
    if (!world_.baked.triangles.empty()) {
      const BrickPlace place = placeOf(level, brick);
      facets.startBrick();
      const float known2 = facets.of(world_.baked, nearest, place).distance2(0, 0, 0);
      const NearestFacet found = nearestFacet(world_, place, {}, {known2, nearest}, facets);
      nearest = found.triangle;
      distance = std::sqrt(found.distance2) * (1 - 1e-5f);  // for float32
    }
    entry = distance >= kEmptyBrick ? std::bit_cast<std::uint32_t>(distance) : kFullBrick;
  }
}

void Builder::numberBricks() {
  // Lanes find distances by offsets of 31 bits.
  constexpr std::uint64_t kMost = 0x7FFFFFFFu / (kBrickStride * sizeof(std::uint16_t));
  for (std::uint32_t i = 0; i < field_->table.size(); ++i) {
    std::uint32_t& entry = field_->table[i];
    if (entry < kFullBrick) continue;
    if (bricks_.size() == kMost) {
      throw Error(
          fmt::format("particle: with voxels of {:g} m over {} million bricks are near surfaces: choose larger "
                      "voxels or fewer of them",
                      field_->shape.voxel, kMost / 1'000'000));
    }
    entry = kFullBrick + static_cast<std::uint32_t>(bricks_.size());
    bricks_.push_back(i);
    field_->before.push_back(keptBefore_[i]);
  }
}

void Builder::makeBricks() {
  field_->distance.resize(bricks_.size() * kBrickStride);
  field_->word.resize(bricks_.size() * kBrickStride);
  entries_.resize(field_->shape.lists ? bricks_.size() : 0);
  std::vector<std::uint32_t> made;
  for (std::uint32_t i = 0; i < bricks_.size(); ++i) {
    if (field_->before[i] == kNew) made.push_back(i);
  }
  parallelFor(made.size(), kBricksPerTask, [&](std::size_t first, std::size_t last) {
    BrickMaker maker(world_, field_->shape.lists);
    std::vector<std::uint32_t> entries;
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t index = made[i];
      const std::uint32_t entry = bricks_[index];
      const std::size_t level = levelOf(entry);
      const std::size_t at = std::size_t{index} * kBrickStride;
      entries.clear();
      maker.make(placeOf(level, brickOf(level, entry)), &field_->distance[at], &field_->word[at], entries);
      if (field_->shape.lists) entries_[index].assign(entries.begin(), entries.end());
    }
  });
}

void Builder::placeLists() {
  std::vector<std::uint32_t>& first = field_->firstList;
  first.assign(bricks_.size() + 1, 0);
  std::uint64_t end = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const std::uint32_t from = field_->before[i];
    end += from == kNew ? entries_[i].size() : before_->firstList[from + 1] - before_->firstList[from];
    if (end >= kNoWord) {
      throw Error(
          fmt::format("particle: with voxels of {:g} m the field would name over 4 billion triangles: choose "
                      "larger voxels, or refine: normal",
                      field_->shape.voxel));
    }
    first[i + 1] = static_cast<std::uint32_t>(end);
  }
  field_->lists.resize(end);
}

// Copies the bricks taken over, and all lists to their places.
void Builder::assemble() {
  const bool lists = field_->shape.lists;
  if (lists) placeLists();
  parallelFor(bricks_.size(), kBricksPerTask, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t from = field_->before[i];
      std::uint32_t* word = &field_->word[i * kBrickStride];
      const std::uint32_t* source = word;
      if (from != kNew) {
        std::memcpy(&field_->distance[i * kBrickStride], &before_->distance[std::size_t{from} * kBrickStride],
                    kBrickStride * sizeof(std::uint16_t));
        source = &before_->word[std::size_t{from} * kBrickStride];
      }
      if (lists) {
        const std::uint32_t first = field_->firstList[i];
        const std::uint32_t* entries =
            from == kNew ? entries_[i].data() : before_->lists.data() + before_->firstList[from];
        const std::uint32_t moved = from == kNew ? first : first - before_->firstList[from];
        for (int c = 0; c < kBrickStride; ++c) word[c] = source[c] == kNoWord ? kNoWord : source[c] + moved;
        std::copy_n(entries, field_->firstList[i + 1] - first, field_->lists.begin() + first);
      } else if (from != kNew) {
        std::memcpy(word, source, kBrickStride * sizeof(std::uint32_t));
      }
    }
  });
}

std::shared_ptr<const DistanceField> Builder::build() {
  std::uint64_t entries = 0;
  for (const LevelBox& box : field_->shape.levels) entries += box.size();
  field_->table.resize(entries);
  keptBefore_.resize(entries);
  for (std::size_t level = 0; level < field_->levels.size(); ++level) {
    const LevelBox& box = field_->shape.levels[level];
    parallelFor(std::size_t{box.bricks[1]} * box.bricks[2], 4, [&](std::size_t first, std::size_t last) {
      FacetCache facets;
      for (std::size_t row = first; row < last; ++row) fillRow(level, row, facets);
    });
  }
  numberBricks();
  makeBricks();
  assemble();
  return std::move(field_);
}

}  // namespace

std::shared_ptr<const DistanceField> buildField(const World& world, const FieldShape& shape,
                                                const DistanceField* before) {
  return Builder(world, shape, before).build();
}

}  // namespace scanmill
