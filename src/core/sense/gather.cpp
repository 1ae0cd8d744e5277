#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "sense/sense.h"

namespace scanmill {
namespace {

// Beams are stored ring by ring, dense scans column by column. Processing in tiles keeps their data in the first-level
// cache: for each ring a tile reads a few consecutive beams, and for each column it writes consecutive points.
constexpr std::uint32_t kTileRings = 16;
constexpr std::uint32_t kTileColumns = 64;
constexpr std::size_t kTilePoints = std::size_t{kTileRings} * kTileColumns;

constexpr std::uint32_t kNoRow = 0xFFFFFFFF;

// Finds the rows of a beam's returns. Plane n holds the row of the (n + 1)th return of each beam. Returns are ordered
// by range, and by row if their ranges are equal.
class ReturnOrder {
 public:
  ReturnOrder(const Returns& returns, std::size_t beams) : returns_(returns) {
    if (returns.onePerBeam()) return;
    for (std::uint32_t row = 0; row < returns.size(); ++row) {
      if (returns.returned(row)) insert(row, beams);
    }
  }

  std::uint32_t planes() const { return std::max<std::uint32_t>(static_cast<std::uint32_t>(planes_.size()), 1); }
  // Returns the number of returns of the beam; 1 if there is one row per beam.
  std::uint32_t count(std::uint32_t beam) const {
    std::uint32_t number = 0;
    while (number < planes_.size() && planes_[number][beam] != kNoRow) ++number;
    return planes_.empty() ? 1 : number;
  }
  // Returns the row of the beam's return `plane` (counted from 0); kNoRow if the beam has fewer returns.
  std::uint32_t row(std::uint32_t plane, std::uint32_t beam) const {
    return plane < planes_.size() ? planes_[plane][beam] : kNoRow;
  }
  bool severalPerBeam() const { return !returns_.onePerBeam(); }

 private:
  // Inserts a row into the sorted list of its beam's returns. All returns behind the new row move to the next plane.
  void insert(std::uint32_t row, std::size_t beams) {
    const std::uint32_t beam = returns_.beam(row);
    for (std::size_t plane = 0; row != kNoRow; ++plane) {
      if (plane == planes_.size()) planes_.emplace_back(beams, kNoRow);
      std::uint32_t& rowInPlane = planes_[plane][beam];
      if (rowInPlane == kNoRow || precedes(row, rowInPlane)) std::swap(row, rowInPlane);
    }
  }

  bool precedes(std::uint32_t a, std::uint32_t b) const {
    return returns_.range[a] != returns_.range[b] ? returns_.range[a] < returns_.range[b] : a < b;
  }

  const Returns& returns_;
  // planes_[n][beam]: row of the beam's (n + 1)th return, or kNoRow. Empty if there is one row per beam.
  std::vector<std::vector<std::uint32_t>> planes_;
};

// The points of a tile: for each point its beam, its row in the table of returns, its hit, and its row in the scan. If
// there is one row per beam, beam, row and hit have the same index.
class TilePoints {
  std::array<std::uint32_t, kTilePoints> rows_, hits_;

 public:
  explicit TilePoints(bool severalPerBeam)
      : row(severalPerBeam ? rows_.data() : beam.data()), hit(severalPerBeam ? hits_.data() : beam.data()) {}
  TilePoints& operator=(TilePoints&&) = delete;  // neither copied nor moved

  std::size_t count = 0;
  std::array<std::uint32_t, kTilePoints> beam, scanRow;
  std::array<std::uint16_t, kTilePoints> ring, column;
  const std::uint32_t* row;
  const std::uint32_t* hit;

  void set(std::size_t point, std::uint32_t rowOfPoint, std::uint32_t hitOfPoint) {
    rows_[point] = rowOfPoint;
    hits_[point] = hitOfPoint;
  }
};

// Neighbouring columns of beams and, for each, the row of the scan to which its next point is written.
struct Strip {
  std::uint32_t firstColumn, width;
  std::array<std::uint32_t, kTileColumns> next;
};

class Gathering {
 public:
  Gathering(const Hits& hits, const Shot& shot, const Returns& returns, const ScanLayout& layout,
            const InstanceMotions* motions, Scan& scan)
      : hits_(hits),
        shot_(shot),
        beams_(*shot.beams),
        returns_(returns),
        layout_(layout),
        motions_(motions),
        scan_(scan),
        order_(returns, hits.size()),
        points_(order_.severalPerBeam()) {}

  // Fills the scan strip by strip, and each strip tile by tile.
  void run() {
    resizeColumns();
    const bool deskew = shot_.deskew && shot_.worldFromSensor.size() > 1;
    std::array<Affine, kTileColumns> startFromColumn;  // by column of the strip; used only if `deskew`
    std::uint32_t stripRow = 0;
    for (std::uint32_t first = 0; first < hits_.columns; first += kTileColumns) {
      strip_.firstColumn = first;
      strip_.width = std::min(kTileColumns, hits_.columns - first);
      startStrip(stripRow);
      for (std::uint32_t c = 0; deskew && c < strip_.width; ++c) {
        startFromColumn[c] = shot_.startFromStep(shot_.stepOf(first + c));
      }
      for (std::uint32_t ring = 0; ring < hits_.rings; ring += kTileRings) {
        for (std::uint32_t plane = 0; plane < order_.planes(); ++plane) {
          order_.severalPerBeam() ? collectReturn(ring, plane) : collectOnePerBeam(ring);
          fillColumns(deskew ? startFromColumn.data() : nullptr, plane);
        }
      }
    }
  }

 private:
  // Resizes each column to the number of points, or to 0 if it was not asked for. Fills organised scans with misses.
  void resizeColumns() {
    scan_.rings = hits_.rings;
    scan_.columns = hits_.columns;
    scan_.organised = layout_.organised;
    scan_.planes = layout_.organised ? order_.planes() : 1;
    scan_.foreign.clear();
    scan_.columnsIfEmpty = {};
    std::size_t points = 0;
    for (const float range : returns_.range) points += range < kMiss ? 1u : 0u;
    const auto resize = [&](auto& values, bool isFilled, auto none) {
      if (!isFilled) {
        values.clear();
      } else if (layout_.organised) {
        values.assign(scan_.planes * hits_.size(), none);
      } else {
        values.resize(points);
      }
    };
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    resize(scan_.position, true, Vec3f{kNaN, kNaN, kNaN});
    visitTable(scan_, [&]<class T>(auto key, std::vector<T>& values) {
      const bool isComputed = returns_.size() == 0 || ((key.index != kIntensity.index || !returns_.intensity.empty()) &&
                                                       (key.index != kPower.index || !returns_.power.empty()));
      const bool isFilled = layout_.columns.has(key) && isComputed;
      if (isFilled) scan_.columnsIfEmpty.add(key.index);
      resize(values, isFilled, static_cast<T>(key.row.none));
    });
  }

  // Sets Strip::next to the row of a dense scan at which each of the strip's columns begins. `stripRow`: the row at
  // which the strip begins; is set to the row at which the next strip begins.
  void startStrip(std::uint32_t& stripRow) {
    std::array<std::uint32_t, kTileColumns> returnCount{};
    for (std::uint32_t ring = 0; ring < hits_.rings; ++ring) {
      const std::uint32_t firstBeam = ring * hits_.columns + strip_.firstColumn;
      if (order_.severalPerBeam()) {
        for (std::uint32_t c = 0; c < strip_.width; ++c) returnCount[c] += order_.count(firstBeam + c);
      } else {
        const float* const range = returns_.range.data() + firstBeam;
        for (std::uint32_t c = 0; c < strip_.width; ++c) returnCount[c] += range[c] < kMiss ? 1u : 0u;
      }
    }
    for (std::uint32_t c = 0; c < strip_.width; ++c) {
      strip_.next[c] = stripRow;
      stripRow += returnCount[c];
    }
  }

  // Collects the points of a tile if there is one row per beam. Members are copied to local variables, because the
  // compiler must assume that the writes of the loop change members, and would read them again for every beam.
  void collectOnePerBeam(std::uint32_t firstRing) {
    std::size_t count = 0;
    const std::uint32_t endRing = std::min(firstRing + kTileRings, hits_.rings);
    const std::uint32_t columns = hits_.columns;
    const std::uint32_t firstColumn = strip_.firstColumn;
    const std::uint32_t width = strip_.width;
    const bool organised = layout_.organised;
    const float* const range = returns_.range.data();
    std::array<std::uint32_t, kTileColumns> next = strip_.next;
    for (std::uint32_t ring = firstRing; ring < endRing; ++ring) {
      const std::uint32_t firstBeam = ring * columns + firstColumn;
      for (std::uint32_t c = 0; c < width; ++c) {
        // Writes an entry for every beam, but increases `count` only for beams with a return: a branch would often be
        // mispredicted, because misses are irregular.
        points_.beam[count] = firstBeam + c;
        points_.scanRow[count] = organised ? firstBeam + c : next[c];
        points_.ring[count] = static_cast<std::uint16_t>(ring);
        points_.column[count] = static_cast<std::uint16_t>(firstColumn + c);
        const std::uint32_t hasReturn = range[firstBeam + c] < kMiss ? 1u : 0u;
        count += hasReturn;
        next[c] += hasReturn;
      }
    }
    strip_.next = next;
    points_.count = count;
  }

  // Collects the points of a tile that are return number `plane` of their beam, for any number of rows per beam. In a
  // dense scan the returns of a beam are consecutive. The scan's row of a return is therefore the row at which the
  // column continues, plus the number of earlier returns: earlier returns of the same beam, and all returns of the
  // column's beams in the tile's earlier rings.
  void collectReturn(std::uint32_t firstRing, std::uint32_t plane) {
    std::size_t count = 0;
    const std::uint32_t endRing = std::min(firstRing + kTileRings, hits_.rings);
    for (std::uint32_t c = 0; c < strip_.width; ++c) {
      std::uint32_t scanRow = strip_.next[c];
      for (std::uint32_t ring = firstRing; ring < endRing; ++ring) {
        const std::uint32_t beam = ring * hits_.columns + strip_.firstColumn + c;
        for (std::uint32_t number = 0; number < order_.planes() && order_.row(number, beam) != kNoRow; ++number) {
          if (number == plane) {
            const std::uint32_t row = order_.row(plane, beam);
            points_.beam[count] = beam;
            points_.set(count, row, returns_.hit(row));
            points_.scanRow[count] =
                layout_.organised ? static_cast<std::uint32_t>(plane * hits_.size()) + beam : scanRow;
            points_.ring[count] = static_cast<std::uint16_t>(ring);
            points_.column[count] = static_cast<std::uint16_t>(strip_.firstColumn + c);
            ++count;
          }
          ++scanRow;
        }
      }
      // Each tile is collected once per plane: only the last time, the column continues behind the tile.
      if (plane + 1 == order_.planes()) strip_.next[c] = scanRow;
    }
    points_.count = count;
  }

  // Writes the tile's collected points into all columns of the scan. `startFromColumn`: as for computePositions().
  void fillColumns(const Affine* startFromColumn, std::uint32_t plane) {
    computePositions(startFromColumn);
    visitTable(scan_, [&](auto key, auto& values) {
      if (!values.empty()) fill(key, plane, values);
    });
  }

  // Computes positions in the sensor's frame or, if `startFromColumn` is given (one transform per column of the strip),
  // in the sensor's frame at the start of the revolution. Not inlined: within the loop over the tiles, the pointers
  // used here would not all stay in registers.
  [[gnu::noinline]] void computePositions(const Affine* startFromColumn) {
    std::array<double, kTilePoints> x, y, z;
    const std::size_t count = points_.count;
    const std::uint32_t* const beam = points_.beam.data();
    const std::uint32_t* const row = points_.row;
    const Vec3d* const directions = beams_.direction.data();
    const float* const ranges = returns_.range.data();
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3d& direction = directions[beam[k]];
      const double range = ranges[row[k]];
      x[k] = direction.x * range;
      y[k] = direction.y * range;
      z[k] = direction.z * range;
    }
    const auto addOffsets = [&](const std::vector<Vec3f>& offsets, const std::uint32_t* indices) {
      for (std::size_t k = 0; k < count && !offsets.empty(); ++k) {
        const Vec3f& offset = offsets[indices[k]];
        x[k] += offset.x;
        y[k] += offset.y;
        z[k] += offset.z;
      }
    };
    addOffsets(beams_.origin, beam);
    addOffsets(returns_.displacement, row);
    for (std::size_t k = 0; k < count && startFromColumn != nullptr; ++k) {
      const Vec3d point = startFromColumn[points_.column[k] - strip_.firstColumn] * Vec3d{x[k], y[k], z[k]};
      x[k] = point.x;
      y[k] = point.y;
      z[k] = point.z;
    }
    const std::uint32_t* const scanRow = points_.scanRow.data();
    Vec3f* const position = scan_.position.data();
    for (std::size_t k = 0; k < count; ++k) {
      position[scanRow[k]] = {static_cast<float>(x[k]), static_cast<float>(y[k]), static_cast<float>(z[k])};
    }
  }

  // Fills one column of the scan. If a column in the table of columns is not handled here, the code does not compile.
  template <class Key, class T>
  void fill(Key key, std::uint32_t plane, std::vector<T>& values) {
    constexpr std::string_view name = Key::row.name;
    if constexpr (name == "intensity") {
      copy(returns_.intensity, points_.row, values);
    } else if constexpr (name == "label") {
      returns_.label.empty() ? copyHits(key, hits_.semantic, values) : copy(returns_.label, points_.row, values);
      if (motions_ != nullptr && motions_->haveMovingClasses()) relabel(values);
    } else if constexpr (name == "instance") {
      returns_.instance.empty() ? copyHits(key, hits_.instance, values) : copy(returns_.instance, points_.row, values);
    } else if constexpr (name == "ring") {
      put(values, [ring = points_.ring.data()](std::size_t k) { return ring[k]; });
    } else if constexpr (name == "column") {
      put(values, [column = points_.column.data()](std::size_t k) { return column[k]; });
    } else if constexpr (name == "time") {
      copy(beams_.time, points_.beam.data(), values);
    } else if constexpr (name == "range_true") {
      copyHits(key, hits_.range, values);
    } else if constexpr (name == "incidence") {
      // The angle is computed from its cosine in double, because the float versions of acos() differ between libraries.
      // A cosine of NaN gives NaN.
      putHits(key, values, [&](std::uint32_t hit) {
        return static_cast<float>(std::acos(std::clamp(double{hits_.incidence[hit]}, 0.0, 1.0)));
      });
    } else if constexpr (name == "return") {
      put(values, [&](std::size_t) { return static_cast<T>(plane + 1); });
    } else if constexpr (name == "cause") {
      put(values, [&](std::size_t k) { return static_cast<T>(returns_.cause(points_.row[k])); });
    } else if constexpr (name == "returns") {
      put(values, [&](std::size_t k) { return static_cast<T>(order_.count(points_.beam[k])); });
    } else if constexpr (name == "label_2") {
      put(values, [&](std::size_t k) { return returns_.label2.empty() ? T{0} : returns_.label2[points_.row[k]]; });
    } else if constexpr (name == "share") {
      put(values, [&](std::size_t k) { return returns_.share.empty() ? T{1} : returns_.share[points_.row[k]]; });
    } else if constexpr (name == "power") {
      copy(returns_.power, points_.row, values);
    } else if constexpr (name.starts_with("velocity_")) {
      putMotion(name.back(), values, [&](std::uint32_t hit, const Vec3d& point, double) {
        return motions_->velocity(hits_.instance[hit], point);
      });
    } else if constexpr (name.starts_with("flow_")) {
      putMotion(name.back(), values, [&](std::uint32_t hit, const Vec3d& point, double time) {
        return motions_->flow(hits_.instance[hit], hits_.primitive[hit], point, time);
      });
    } else if constexpr (name == "radial_velocity") {
      putRadialVelocities(values);
    } else if constexpr (name == "normal_oct") {
      putNormals(values);
    } else if constexpr (name == "azimuth") {
      putHits(key, values, [&](std::uint32_t hit) {
        const Vec3d p = positionOf(hit);
        return static_cast<float>(std::atan2(p.y, p.x));
      });
    } else if constexpr (name == "elevation") {
      putHits(key, values, [&](std::uint32_t hit) {
        const Vec3d p = positionOf(hit);
        return static_cast<float>(std::atan2(p.z, std::hypot(p.x, p.y)));
      });
    } else {
      static_assert(Key::index >= kColumnCount, "say here what fills the column");
    }
  }

  // Sets the class of points on moving objects to the ontology's class for moving objects of the same kind, if any.
  void relabel(std::vector<std::uint16_t>& values) {
    for (std::size_t k = 0; k < points_.count; ++k) {
      const std::uint32_t instance = returns_.instanceOf(points_.row[k], hits_);
      std::uint16_t& label = values[points_.scanRow[k]];
      if (instance != 0) label = motions_->classOf(label, instance);
    }
  }

  // Writes the velocity of the surface minus the velocity of the sensor, along the beam (m/s). The ego vehicle moves as
  // the sensor does. The value is NaN for points without a hit and for mirror images, since the mirror's normal is not
  // known here.
  void putRadialVelocities(std::vector<float>& values) {
    put(values, [&](std::size_t k) {
      const std::uint32_t hit = points_.hit[k];
      if (returns_.cause(points_.row[k]) == Reason::EgoVehicle) return 0.0f;
      if (!hitsDirectly(k)) return std::numeric_limits<float>::quiet_NaN();
      const std::size_t step = shot_.worldFromSensor.size() == 1 ? 0 : shot_.stepOf(points_.column[k]);
      const Pose& worldFromSensor = shot_.worldFromSensor[step];
      Vec3d relativeVelocity;
      if (motions_ != nullptr)
        relativeVelocity = motions_->velocity(hits_.instance[hit], worldFromSensor * positionOf(hit));
      if (!shot_.sensorVelocity.empty()) relativeVelocity = relativeVelocity - shot_.sensorVelocity[step];
      const std::uint32_t beam = hits_.beamOfRay.empty() ? hit : hits_.beamOfRay[hit];
      return static_cast<float>(dot(toMatrix(worldFromSensor.rotation) * beams_.direction[beam], relativeVelocity));
    });
  }

  // Writes the component `axis` of a vector, in the frame of the scan's points. `vectorAt(hit, point, time)` returns
  // the vector in world axes for a point (m, world) that was hit at a time (s since the start of the revolution).
  template <class VectorAt>
  void putMotion(char axis, std::vector<float>& values, const VectorAt& vectorAt) {
    put(values, [&](std::size_t k) {
      const std::uint32_t hit = points_.hit[k];
      if (motions_ == nullptr || hit == kNoHit || hits_.instance[hit] == 0) return 0.0f;
      const Pose& worldFromSensor =
          shot_.worldFromSensor[shot_.worldFromSensor.size() == 1 ? 0 : shot_.stepOf(points_.column[k])];
      const double time = shot_.duration > 0 ? double{beams_.time[points_.beam[k]]} : 0;
      const Vec3d inPointFrame = alongPoints(k, vectorAt(hit, worldFromSensor * positionOf(hit), time));
      return static_cast<float>(axis == 'x' ? inPointFrame.x : axis == 'y' ? inPointFrame.y : inPointFrame.z);
    });
  }

  // Writes the normals of the surfaces, octahedral with 16 bits a component (Cigolle et al., "A survey of efficient
  // representations for independent unit vectors", Journal of Computer Graphics Techniques 3 (2014)).
  void putNormals(std::vector<std::uint32_t>& values) {
    put(values, [&](std::size_t k) {
      if (!hitsDirectly(k)) return std::uint32_t{0};
      const Vec3d n = alongPoints(k, Vec3d(hits_.normal[points_.hit[k]]));
      const double sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
      double u = n.x / sum, v = n.y / sum;
      if (n.z < 0) {
        const double foldedU = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
        v = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
        u = foldedU;
      }
      const auto coded = [](double c) { return static_cast<std::uint32_t>(std::lround((c + 1) * 32767)) + 1; };
      return coded(u) | coded(v) << 16;
    });
  }

  // Returns true if a point lies on a surface that its beam hits without a mirror, or through glass. The normal of a
  // mirror is not known here, and the own vehicle's hits are along the vehicle's axes.
  bool hitsDirectly(std::size_t k) const {
    const Reason cause = returns_.cause(points_.row[k]);
    return points_.hit[k] != kNoHit && (cause == Reason::Surface || cause == Reason::ThroughGlass);
  }

  // Returns a vector in world axes along the axes of the frame in which a point of the tile is given.
  Vec3d alongPoints(std::size_t k, const Vec3d& worldVector) const {
    const bool isFirst = shot_.deskew || shot_.worldFromSensor.size() == 1;
    const Pose& worldFromPoints = shot_.worldFromSensor[isFirst ? 0 : shot_.stepOf(points_.column[k])];
    return transposed(toMatrix(worldFromPoints.rotation)) * worldVector;
  }

  // Returns the noise-free position of a hit (m) in the sensor's frame at the time of firing.
  Vec3d positionOf(std::uint32_t hit) const {
    const std::uint32_t beam = hits_.beamOfRay.empty() ? hit : hits_.beamOfRay[hit];
    const Vec3d along = beams_.direction[beam] * double{hits_.range[hit]};
    return along + beams_.originOf(beam);
  }

  // Writes value(k) for each point k of the tile into its row of the scan.
  template <class T, class Value>
  void put(std::vector<T>& values, const Value& value) {
    T* const target = values.data();
    const std::uint32_t* const scanRow = points_.scanRow.data();
    const std::size_t count = points_.count;
    for (std::size_t k = 0; k < count; ++k) target[scanRow[k]] = value(k);
  }

  // Writes source[indices[k]] for each point k of the tile.
  template <class T>
  void copy(const std::vector<T>& source, const std::uint32_t* indices, std::vector<T>& values) {
    put(values, [data = source.data(), indices](std::size_t k) { return data[indices[k]]; });
  }

  // Writes value(hit) for each point of the tile, computed from the point's hit. A row without a hit gets the column's
  // value for points without a hit.
  template <class Key, class T, class Value>
  void putHits(Key key, std::vector<T>& values, const Value& value) {
    static_assert(Key::row.channels != Channels() || Key::index == kRangeTrue.index, "name the channels of the column");
    const std::uint32_t* const hits = points_.hit;
    if (!order_.severalPerBeam()) return put(values, [hits, &value](std::size_t k) { return value(hits[k]); });
    const T none = static_cast<T>(key.row.none);
    put(values, [=, &value](std::size_t k) { return hits[k] == kNoHit ? none : value(hits[k]); });
  }

  template <class Key, class T>
  void copyHits(Key key, const std::vector<T>& source, std::vector<T>& values) {
    putHits(key, values, [data = source.data()](std::uint32_t hit) { return data[hit]; });
  }

  const Hits& hits_;
  const Shot& shot_;
  const BeamTable& beams_;
  const Returns& returns_;
  const ScanLayout& layout_;
  const InstanceMotions* motions_;
  Scan& scan_;
  ReturnOrder order_;
  TilePoints points_;
  Strip strip_{};
};

}  // namespace

void gather(const Hits& hits, const Shot& shot, const Returns& returns, const ScanLayout& layout,
            const InstanceMotions* motions, Scan& scan) {
  Gathering(hits, shot, returns, layout, motions, scan).run();
}

}  // namespace scanmill
