#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "effects/effect.h"

namespace scanmill {
namespace {

// Beams lie in memory ring by ring, dense scans column by column. Tiles keep both sides in the nearest cache: short
// rows of beams are read whole, and as many places as a tile has columns are written to in turn.
constexpr std::uint32_t kTileRings = 16;
constexpr std::uint32_t kTileColumns = 64;
constexpr std::size_t kPoints = std::size_t{kTileRings} * kTileColumns;

// The returns of a tile: from which beam, and to which row of the scan.
struct Moves {
  std::size_t count = 0;
  std::array<std::uint32_t, kPoints> from;
  std::array<std::uint32_t, kPoints> to;
  std::array<std::uint16_t, kPoints> ring;
  std::array<std::uint16_t, kPoints> column;
};

// A stretch of columns, and where the next point of each goes.
struct Strip {
  std::uint32_t firstColumn;
  std::uint32_t width;
  std::array<std::uint32_t, kTileColumns> next;
};

constexpr std::array kChannels{Channel::Range,    Channel::Normal,    Channel::Instance,    Channel::Semantic,
                               Channel::Material, Channel::Primitive, Channel::Reflectance, Channel::Incidence};

void checkColumns(const Hits& hits, const Shot& shot, Channels needed) {
  const BeamTable& beams = *shot.beams;
  if (hits.rings != beams.rings || hits.columns != beams.columns || hits.range.size() != hits.size()) {
    throw Error(fmt::format("hits of {} x {} beams do not belong to a sensor of {} x {}", hits.rings, hits.columns,
                            beams.rings, beams.columns));
  }
  for (const Channel channel : kChannels) {
    if (needed.has(channel) && !hits.channels.has(channel)) {
      throw Error(fmt::format("hits lack the channel {} that the effects and the columns asked for need",
                              channelNames(channel).front()));
    }
  }
}

// Gives every column its size; what was not asked for is empty. Organised scans start as all misses.
void shape(Scan& scan, const Hits& hits, const ScanColumns& asked, bool lit, std::size_t points) {
  scan.rings = hits.rings;
  scan.columns = hits.columns;
  scan.organised = asked.organised;
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const auto fit = [&](auto& column, bool wanted, auto miss) {
    if (!wanted) {
      column.clear();
    } else if (asked.organised) {
      column.assign(hits.size(), miss);
    } else {
      column.resize(points);
    }
  };
  fit(scan.position, true, Vec3f{kNaN, kNaN, kNaN});
  fit(scan.intensity, asked.intensity && lit, 0.0f);
  fit(scan.label, asked.label, std::uint16_t{0});
  fit(scan.instance, asked.instance, std::uint32_t{0});
  fit(scan.ring, asked.ring, std::uint16_t{0});
  fit(scan.column, asked.column, std::uint16_t{0});
  fit(scan.time, asked.time, 0.0f);
  fit(scan.rangeTrue, asked.rangeTrue, kNaN);
  fit(scan.incidence, asked.incidence, kNaN);
}

// Looks up the rows of a dense scan at which the columns of a strip start; `row` is where the strip starts and ends.
void startStrip(const Hits& hits, const float* range, Strip& strip, std::uint32_t& row) {
  std::array<std::uint32_t, kTileColumns> returned{};
  for (std::uint32_t ring = 0; ring < hits.rings; ++ring) {
    const float* const line = range + std::size_t{ring} * hits.columns + strip.firstColumn;
    for (std::uint32_t c = 0; c < strip.width; ++c) returned[c] += line[c] < kMiss ? 1u : 0u;
  }
  for (std::uint32_t c = 0; c < strip.width; ++c) {
    strip.next[c] = row;
    row += returned[c];
  }
}

void collect(const Hits& hits, const float* range, bool organised, std::uint32_t firstRing, Strip& strip,
             Moves& moves) {
  std::size_t count = 0;
  const std::uint32_t endRing = std::min(firstRing + kTileRings, hits.rings);
  for (std::uint32_t ring = firstRing; ring < endRing; ++ring) {
    const std::uint32_t line = ring * hits.columns + strip.firstColumn;
    for (std::uint32_t c = 0; c < strip.width; ++c) {
      // Written always, kept only where there is a return: misses are too irregular for branches.
      moves.from[count] = line + c;
      moves.to[count] = organised ? line + c : strip.next[c];
      moves.ring[count] = static_cast<std::uint16_t>(ring);
      moves.column[count] = static_cast<std::uint16_t>(strip.firstColumn + c);
      const std::uint32_t returned = range[line + c] < kMiss ? 1u : 0u;
      count += returned;
      strip.next[c] += returned;
    }
  }
  moves.count = count;
}

// From the frame of a step of the turn to that of the turn's start. Differences of the large world coordinates first.
Affine startFromStep(const Shot& shot, std::size_t step) {
  if (step == 0) return {};
  const Pose& start = shot.worldFromSensor[0];
  const Pose& now = shot.worldFromSensor[step];
  const Mat3 startFromWorld = transposed(toMatrix(start.rotation));
  return {startFromWorld * toMatrix(now.rotation), startFromWorld * (now.translation - start.translation)};
}

// Positions in the sensor's frame; in that of the turn's start where `toStart` is given, one entry per column of the
// strip.
void place(const BeamTable& beams, const Returns& returns, const Moves& moves, std::uint32_t firstColumn,
           const Affine* toStart, Vec3f* position) {
  std::array<double, kPoints> x;
  std::array<double, kPoints> y;
  std::array<double, kPoints> z;
  for (std::size_t m = 0; m < moves.count; ++m) {
    const Vec3d& direction = beams.direction[moves.from[m]];
    const double range = returns.range[moves.from[m]];
    x[m] = direction.x * range;
    y[m] = direction.y * range;
    z[m] = direction.z * range;
  }
  const auto add = [&](const std::vector<Vec3f>& offsets) {
    for (std::size_t m = 0; m < moves.count && !offsets.empty(); ++m) {
      const Vec3f& offset = offsets[moves.from[m]];
      x[m] += offset.x;
      y[m] += offset.y;
      z[m] += offset.z;
    }
  };
  add(beams.origin);
  add(returns.displacement);
  for (std::size_t m = 0; m < moves.count && toStart != nullptr; ++m) {
    const Vec3d point = toStart[moves.column[m] - firstColumn] * Vec3d{x[m], y[m], z[m]};
    x[m] = point.x;
    y[m] = point.y;
    z[m] = point.z;
  }
  for (std::size_t m = 0; m < moves.count; ++m) {
    position[moves.to[m]] = {static_cast<float>(x[m]), static_cast<float>(y[m]), static_cast<float>(z[m])};
  }
}

template <class T>
void copy(const Moves& moves, const std::vector<T>& from, std::vector<T>& to) {
  if (to.empty()) return;
  const T* const source = from.data();
  T* const target = to.data();
  for (std::size_t m = 0; m < moves.count; ++m) target[moves.to[m]] = source[moves.from[m]];
}

// From cosines. In double, as the float versions of the function differ between libraries. NaN stays NaN.
void copyAngles(const Moves& moves, const std::vector<float>& cosines, std::vector<float>& to) {
  if (to.empty()) return;
  for (std::size_t m = 0; m < moves.count; ++m) {
    to[moves.to[m]] = static_cast<float>(std::acos(std::clamp(double{cosines[moves.from[m]]}, 0.0, 1.0)));
  }
}

void put(const Moves& moves, const std::array<std::uint16_t, kPoints>& values, std::vector<std::uint16_t>& to) {
  if (to.empty()) return;
  std::uint16_t* const target = to.data();
  for (std::size_t m = 0; m < moves.count; ++m) target[moves.to[m]] = values[m];
}

}  // namespace

Channels channelsFor(std::span<const std::unique_ptr<Effect>> effects, const ScanColumns& columns) {
  Channels channels = Channel::Range;
  for (const auto& effect : effects) channels |= effect->reads();
  if (columns.label) channels |= Channel::Semantic;
  if (columns.instance) channels |= Channel::Instance;
  if (columns.incidence) channels |= Channel::Incidence;
  return channels;
}

void sense(const Hits& hits, const Shot& shot, std::span<const std::unique_ptr<Effect>> effects,
           std::span<const Material> materials, const ScanColumns& columns, Returns& scratch, Scan& scan) {
  checkColumns(hits, shot, channelsFor(effects, columns));
  const BeamTable& beams = *shot.beams;
  scratch.range = hits.range;
  scratch.power.clear();
  scratch.intensity.clear();
  scratch.displacement.clear();
  for (const auto& effect : effects) effect->apply(hits, shot, materials, scratch);

  const float* const range = scratch.range.data();
  std::size_t points = 0;
  for (std::size_t beam = 0; beam < hits.size(); ++beam) points += range[beam] < kMiss ? 1u : 0u;
  shape(scan, hits, columns, !scratch.intensity.empty(), points);

  const bool deskew = shot.deskew && shot.worldFromSensor.size() > 1;
  std::array<Affine, kTileColumns> toStart;
  Moves moves;
  Strip strip;
  std::uint32_t row = 0;
  for (std::uint32_t first = 0; first < hits.columns; first += kTileColumns) {
    strip.firstColumn = first;
    strip.width = std::min(kTileColumns, hits.columns - first);
    startStrip(hits, range, strip, row);
    for (std::uint32_t c = 0; deskew && c < strip.width; ++c) toStart[c] = startFromStep(shot, shot.stepOf(first + c));
    for (std::uint32_t ring = 0; ring < hits.rings; ring += kTileRings) {
      collect(hits, range, columns.organised, ring, strip, moves);
      place(beams, scratch, moves, first, deskew ? toStart.data() : nullptr, scan.position.data());
      copy(moves, scratch.intensity, scan.intensity);
      copy(moves, hits.semantic, scan.label);
      copy(moves, hits.instance, scan.instance);
      copy(moves, beams.time, scan.time);
      copy(moves, hits.range, scan.rangeTrue);
      copyAngles(moves, hits.incidence, scan.incidence);
      put(moves, moves.ring, scan.ring);
      put(moves, moves.column, scan.column);
    }
  }
}

}  // namespace scanmill
