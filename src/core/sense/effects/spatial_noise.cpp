#include "sense/effects/spatial_noise.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/instruction_sets.h"

namespace scanmill {

namespace {

// The position of a coordinate between two neighbouring corners of the lattice.
struct LatticePosition {
  std::uint32_t corner;  // index of the lower corner, modulo 2^32
  double lowerWeight;
  double upperWeight;
};

// Returns the lattice position of a coordinate (in units of cubes, -2^51 to 2^51). Uses no std::floor(), so that loops
// are vectorised: the sum with 1.5 * 2^52 has the integer nearest to the coordinate in its last bits.
LatticePosition latticePosition(double coordinate) {
  const double shifted = coordinate + 0x1.8p52;
  const double offset = coordinate - (shifted - 0x1.8p52);  // distance from the nearest integer, -0.5 to 0.5
  const bool roundedUp = offset < 0;
  const double t = roundedUp ? offset + 1 : offset;  // distance from the lower corner, 0 to 1
  const double upper = t * t * t * (t * (t * 6 - 15) + 10);
  const auto nearest = static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(shifted));
  return {.corner = nearest - (roundedUp ? 1u : 0u), .lowerWeight = 1 - upper, .upperWeight = upper};
}

// Returns philox4x32(counter, key). Each word is in the lower half of 64 bits: with AVX-512, GCC's vectorised code for
// these products is three times as fast as for 32-bit words.
std::array<std::uint64_t, 4> widePhilox(std::array<std::uint64_t, 4> counter, std::array<std::uint32_t, 2> key) {
  constexpr std::uint64_t kLower = 0xFFFFFFFF;
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = 0xD2511F53 * counter[0];
    const std::uint64_t p1 = 0xCD9E8D57 * counter[2];
    counter = {(p1 >> 32) ^ counter[1] ^ key[0], p1 & kLower, (p0 >> 32) ^ counter[3] ^ key[1], p0 & kLower};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

// Returns the sum of four uniform numbers, scaled to mean 0 and variance 1. The distribution is close to normal within
// two standard deviations; absolute values stay below 3.5.
double standard(const std::array<std::uint64_t, 4>& words) {
  const std::uint64_t sum = words[0] + words[1] + words[2] + words[3];
  return ((std::bit_cast<double>(kBitsOf2To52 + sum) - 0x1p52) * 0x1p-32 - 2) * 1.7320508075688772;
}

}  // namespace

PositionsOfHits::PositionsOfHits(const Hits& hits, const Shot& shot, const Returns& returns)
    : hits_(hits), shot_(shot), returns_(returns) {
  for (const Pose& pose : shot.worldFromSensor) rotation_.push_back(toMatrix(pose.rotation));
  for (std::uint32_t column = 0; column < shot.beams->columns; ++column) stepOf_.push_back(shot.stepOf(column));
}

void PositionsOfHits::compute(std::size_t first, Positions& positions, Positions* directions) const {
  const BeamTable& beams = *shot_.beams;
  for (std::size_t i = 0; i < kBatch; ++i) {
    positions.set(i, {});
    if (directions != nullptr) directions->set(i, {});
    const std::size_t row = first + i;
    if (row >= returns_.size() || !returns_.returned(row) || returns_.hit(row) == kNoHit) continue;
    const std::uint32_t beam = returns_.beam(row);
    const std::size_t step = rotation_.size() == 1 ? 0 : stepOf_[beam % beams.columns];
    const Vec3d inSensor = beams.direction[beam] * double{hits_.range[returns_.hit(row)]} + beams.originOf(beam);
    positions.set(i, shot_.worldFromSensor[step].translation + rotation_[step] * inSensor);
    if (directions != nullptr) directions->set(i, rotation_[step] * beams.direction[beam]);
  }
}

SpatialField::SpatialField(std::uint64_t seed, Purpose purpose, std::uint32_t number)
    : tag_((number << 20) | static_cast<std::uint32_t>(purpose)),
      key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
      entries_(kEntries),
      numbers_(kEntries + kBatch) {
  // At first, every entry holds the cube whose lower corner has the indices 0.
  computeCorners({}, 1);
  for (std::uint32_t i = 0; i < kEntries; ++i) entries_[i].row = i;
  std::fill_n(numbers_.begin(), kEntries, std::array(numbers_[kEntries]));
}

SCANMILL_BEST_INSTRUCTIONS void SpatialField::computeCorners(const CubeIndices& cubes, std::size_t count) {
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    const std::uint32_t dx = corner & 1;
    const std::uint32_t dy = (corner >> 1) & 1;
    const std::uint32_t dz = corner >> 2;
    for (std::size_t i = 0; i < count; ++i) {
      numbers_[kEntries + i][corner] =
          standard(widePhilox({cubes.x[i] + dx, cubes.y[i] + dy, cubes.z[i] + dz, tag_}, key_));
    }
  }
}

void SpatialField::lookUp(const CubeIndices& cubes, CornerNumbers& numbers) {
  Batch<std::uint32_t> entryOf;    // by row of the batch: index in entries_
  Batch<std::uint32_t> numbersOf;  // by row of the batch: index in numbers_
  for (std::size_t i = 0; i < kBatch; ++i) entryOf[i] = (cubes.x[i] + 32 * cubes.y[i] + 5 * cubes.z[i]) % kEntries;
  // The numbers of new cubes are first stored at the end of numbers_, because earlier rows of this batch may still need
  // the numbers that the new cubes will replace.
  CubeIndices added;
  Batch<std::uint32_t> entryOfAdded;
  std::size_t count = 0;
  for (std::size_t i = 0; i < kBatch; ++i) {
    Entry& entry = entries_[entryOf[i]];
    const std::uint32_t x = cubes.x[i];
    const std::uint32_t y = cubes.y[i];
    const std::uint32_t z = cubes.z[i];
    if (entry.x != x || entry.y != y || entry.z != z) {
      entry = {x, y, z, static_cast<std::uint32_t>(kEntries + count)};
      added.x[count] = x;
      added.y[count] = y;
      added.z[count] = z;
      entryOfAdded[count++] = entryOf[i];
    }
    numbersOf[i] = entry.row;
  }
  computeCorners(added, count);
  for (std::size_t i = 0; i < kBatch; ++i) {
    for (std::size_t corner = 0; corner < 8; ++corner) numbers[corner][i] = numbers_[numbersOf[i]][corner];
  }
  for (std::size_t i = 0; i < count; ++i) {
    numbers_[entryOfAdded[i]] = numbers_[kEntries + i];
    entries_[entryOfAdded[i]].row = entryOfAdded[i];
  }
}

SCANMILL_BEST_INSTRUCTIONS void SpatialField::add(const Positions& positions, const Batch<double>& cubesPerMetre,
                                                  const Batch<double>& factor, Batch<double>& values) {
  CubeIndices cubes;
  Positions lower;  // weights of the corners at the lower end of each axis
  Positions upper;
  for (std::size_t i = 0; i < kBatch; ++i) {
    const LatticePosition x = latticePosition(positions.x[i] * cubesPerMetre[i]);
    const LatticePosition y = latticePosition(positions.y[i] * cubesPerMetre[i]);
    const LatticePosition z = latticePosition(positions.z[i] * cubesPerMetre[i]);
    lower.set(i, {x.lowerWeight, y.lowerWeight, z.lowerWeight});
    upper.set(i, {x.upperWeight, y.upperWeight, z.upperWeight});
    cubes.x[i] = x.corner;
    cubes.y[i] = y.corner;
    cubes.z[i] = z.corner;
  }
  CornerNumbers numbers;
  lookUp(cubes, numbers);
  for (std::size_t i = 0; i < kBatch; ++i) {
    const double x[] = {lower.x[i], upper.x[i]};
    const double y[] = {lower.y[i], upper.y[i]};
    const double z[] = {lower.z[i], upper.z[i]};
    double sum = 0, squares = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const double weight = x[corner & 1] * y[(corner >> 1) & 1] * z[corner >> 2];
      sum += weight * numbers[corner][i];
      squares += weight * weight;
    }
    values[i] += factor[i] * sum / std::sqrt(squares);
  }
}

}  // namespace scanmill
