#pragma once

// The table of returns: the receiver's measurements, one row per return. Detection starts the table from the hits;
// effects change, remove and add rows; gathering turns the remaining rows into a scan.
//
//   Returns returns;
//   detect(hits, shot, {}, scene.materials, returns);
//   for (std::size_t row = 0; row < returns.size(); ++row) {
//     if (returns.range[row] > 100) returns.remove(row);
//   }

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "scan/hits.h"
#include "scan/reasons.h"

namespace scanmill {

// Returns the value of the column `cause` for a return whose ray took this path.
Reason causeOf(RayPath path);

// Rays of one beam whose ranges are too similar for the receiver to separate them.
struct Echo {
  std::uint32_t beam = 0;
  std::uint32_t hit = 0;     // index in Hits of the strongest ray of the class with the most power
  float range = 0;           // m, mean range in the interval of one pulse length with the most power
  float power = 0;           // sum of the powers of the echo's rays
  float spread = 0;          // m, standard deviation of the rays' ranges, weighted by power
  float share = 1;           // fraction of the power that comes from surfaces of the class of `hit`
  std::uint16_t label2 = 0;  // class with the second largest part of the power; 0: none
  Reason cause = Reason::Surface;
};

// Largest number of rows of a beam in the table of returns. Each beam has random numbers for this many rows. If a beam
// has more echoes, the strongest are kept.
constexpr std::uint32_t kMostReturns = 16;

// Returns the echoes of all beams, ordered by beam and then by range. Rays without a hit give no echo. Neighbouring
// rays of a beam, sorted by range, belong to the same echo if their ranges differ by at most `pulseLength` (m); if
// `pulseLength` is 0, each ray is an echo. The range of an echo is the mean of its rays' ranges, weighted by power. If
// an echo is longer than the pulse, the mean is only over the interval of one pulse length that contains most power,
// because a receiver finds the peak. `power`: power of each ray, in any unit; if it is empty, the rays' weights are
// used. Classes are read only if the hits have the channel Semantic.
std::vector<Echo> findEchoes(const Hits& hits, std::span<const float> power, double pulseLength);

// Value of Returns::hit() for a row that an effect has added and that has no hit.
constexpr std::uint32_t kNoHit = 0xFFFFFFFF;

// A row that an effect adds: without an intensity, and on no instance.
struct AddedReturn {
  std::uint32_t beam = 0;
  float range = 0;  // m along the beam
  float power = 0;  // received power; if added before the effect `intensity`, as if received from the reference range
  float snr = 0;
  Reason cause = Reason::FalsePositive;
  std::uint16_t label = 0;
};

// How the power of an echo depends on its range.
struct Falloff {
  double reference = 10;      // m, range at which a white target has the power 1
  double near = 1;            // m; echoes from nearer than this are as strong as from this range
  bool inverseSquare = true;  // false: the power does not depend on the range

  // Returns the square root of the factor by which an echo from `range` (m) is fainter than from the reference range.
  double amplitudeLoss(double range) const { return inverseSquare ? std::max(range, near) / reference : 1; }
};

// A structure of arrays. In most scans every beam has one ray and at most one return: row i then belongs to beam i and
// hit i, and the arrays of beams, hits and numbers stay empty, which saves time and memory.
class Returns {
 public:
  std::vector<float> range;      // m along the beam; kMiss: the row was removed, or its ray missed
  std::vector<float> gain;       // factor on the power, such as speckle or a laser's strength; empty: all 1
  std::vector<float> power;      // power before the sensor's response; empty until an effect sets it
  std::vector<float> intensity;  // the sensor's response to the power; empty until an effect sets it
  std::vector<Vec3f>
      displacement;  // m, sensor axes, added to origin + range * direction; empty until an effect needs it
  std::vector<std::uint16_t> label;     // class id; empty: as in the hits
  std::vector<std::uint32_t> instance;  // instance id; empty: as in the hits

  // The next three columns are empty if every beam fires one ray.
  std::vector<float> spread;          // m, standard deviation of the ranges of the echo's rays
  std::vector<float> share;           // fraction of the echo's power that comes from surfaces of the class `label`
  std::vector<std::uint16_t> label2;  // class with the second largest part of the power; 0: none

  std::vector<float> air;  // fraction of power that the weather transmits; empty: all 1, or reasons are not recorded

  std::vector<float> snr;  // signal to noise ratio of the power; empty until an effect sets it

  // Properties of the receiver that the effects `intensity` and `detection` state; detect() sets them.
  Falloff falloff;
  double threshold = 0;  // power that is detected with a probability of one half; 0: any power is detected

  // True if start() has set `power`, for rows with a hit, to the sum of the powers of the echo's rays.
  bool powerOfEchoes = false;

  std::size_t size() const { return range.size(); }
  bool returned(std::size_t row) const { return range[row] < kMiss; }

  // Returns true if each beam has exactly one row, and row i belongs to beam i and hit i.
  bool onePerBeam() const { return onePerBeam_; }
  std::uint32_t beam(std::size_t row) const { return onePerBeam() ? static_cast<std::uint32_t>(row) : beam_[row]; }
  // Returns the index of the row among its beam's rows, from 0. It does not change when rows are removed, since the
  // address of the row's random numbers consists of seed, scene, frame, sensor, beam and this index. The scan's column
  // `return` counts the remaining returns anew, the nearest first.
  std::uint32_t number(std::size_t row) const { return onePerBeam() ? 0 : number_[row]; }
  // Returns the index of the row's hit in Hits, or kNoHit.
  std::uint32_t hit(std::size_t row) const { return onePerBeam() ? static_cast<std::uint32_t>(row) : hit_[row]; }
  // Returns the id of the object instance that the row belongs to; 0: none. Requires the channel Instance.
  std::uint32_t instanceOf(std::size_t row, const Hits& hits) const {
    if (!instance.empty()) return instance[row];
    return hit(row) == kNoHit ? 0 : hits.instance[hit(row)];
  }
  Reason cause(std::size_t row) const { return cause_.empty() ? Reason::Surface : cause_[row]; }

  void remove(std::size_t row) { range[row] = kMiss; }

  // Starts recording why rows are lost. Must be called after start().
  void recordReasons();
  bool recordsReasons() const { return recordsReasons_; }
  // Records `reason` for all rows that were lost since the last call of recordLost() or recordFaint(). Does nothing if
  // reasons are not recorded.
  void recordLost(Reason reason);
  // Records the reason for rows that the receiver has not detected because their measured power is less than `least`.
  // The reason is LostInAir if the receiver would have detected the row without the weather's loss, otherwise TooFaint.
  // Considers only rows lost since the last call of recordLost() or recordFaint().
  void recordFaint(std::span<const float> measured, float least);
  // Returns why the row was lost. Reason::None: the row was not lost, or its ray missed.
  Reason reasonLost(std::size_t row) const { return row < lost_.size() ? lost_[row] : Reason::None; }
  // Returns true if the beam has kMostReturns rows, so that no further row can be added.
  bool full(std::uint32_t beam) const { return !rowsOfBeam_.empty() && rowsOfBeam_[beam] == kMostReturns; }
  // Appends a row; the indices of other rows do not change. `hits`: the hits from which the table was started.
  void add(const AddedReturn& added, const Hits& hits);

  // Starts the table: with a row per beam if every beam fires one ray, otherwise with a row per ray that has a hit.
  void start(const Hits& hits);
  // Starts the table with a row per echo; echoes are ordered by beam, then by range. `powered`: true if the echoes have
  // the power that the effect `intensity` computes; it is then copied into the rows.
  void start(std::span<const Echo> echoes, bool powered);

 private:
  void clear();
  template <class ReasonOf>
  void recordRemoved(const ReasonOf& reasonOf);
  void startIndices(const Hits& hits);

  bool onePerBeam_ = true;
  std::vector<std::uint32_t> beam_;  // beam_, hit_ and number_ are empty if there is one row per beam
  std::vector<std::uint32_t> hit_;
  std::vector<std::uint8_t> number_;
  std::vector<Reason> cause_;             // empty: all returns come from surfaces
  std::vector<std::uint8_t> rowsOfBeam_;  // number of rows of each beam; empty until a row is added
  bool recordsReasons_ = false;
  std::vector<Reason> lost_;   // reasons of the rows that existed when reasons were last recorded
  std::vector<bool> present_;  // for the rows of lost_: true if the row was not lost at that time
};

}  // namespace scanmill
