#pragma once

// The table of returns: what the receiver makes of the hits, one row per return. Detection starts the table from the
// hits; effects change, remove and add rows; gathering turns the remaining rows into a scan.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "scan/hits.h"
#include "scan/reasons.h"
#include "sense/echoes.h"

namespace scanmill {

// The hit of a row that an effect added: such a row comes from no hit.
constexpr std::uint32_t kNoHit = 0xFFFFFFFF;

// A row that an effect adds.
struct AddedReturn {
  std::uint32_t beam = 0;
  float range = 0;  // m along the beam
  float power = 0;  // if added before the effect `intensity`: as from the reference range; if after: as received
  float intensity = 0;
  float snr = 0;
  Cause cause = Cause::FalsePositive;
  std::uint16_t label = 0;
  std::uint32_t instance = 0;
};

// A structure of arrays. Most often every beam has one ray and at most one return: then row i is the first return of
// beam i and comes from hit i, and the arrays of beams, hits and numbers stay empty, so that they cost nothing.
class Returns {
 public:
  std::vector<float> range;      // m along the beam; kMiss: the row was removed, or its ray missed
  std::vector<float> gain;       // factor on the power, such as speckle or a laser's strength; empty: 1
  std::vector<float> power;      // before the sensor's response; empty until an effect sets it
  std::vector<float> intensity;  // the sensor's response to the power; empty until an effect sets it
  std::vector<Vec3f>
      displacement;  // m, sensor axes, added to origin + range * direction; empty until an effect needs it
  std::vector<std::uint16_t> label;     // class id; empty: that of the hits
  std::vector<std::uint32_t> instance;  // empty: that of the hits

  // These three are empty if every beam fires one ray.
  std::vector<float> spread;          // m, standard deviation of the ranges of the echo's rays
  std::vector<float> share;           // part of the echo's power that comes from surfaces of the class `label`
  std::vector<std::uint16_t> label2;  // the class that contributes most of the remaining power; 0: none

  std::vector<float> air;  // part of the power that the weather leaves; empty: all, or reasons are not recorded

  std::vector<float> snr;  // power over the receiver's noise; empty until an effect sets it

  // True if `power` of the rows that come from a hit was set at the start, as the sum over the rays of each echo.
  bool powerOfEchoes = false;

  std::size_t size() const { return range.size(); }
  bool returned(std::size_t row) const { return range[row] < kMiss; }

  // True if row i is the first return of beam i and comes from hit i.
  bool onePerBeam() const { return onePerBeam_; }
  std::uint32_t beam(std::size_t row) const { return onePerBeam() ? static_cast<std::uint32_t>(row) : beam_[row]; }
  // Returns the number of the row among its beam's rows, counted from 0. With seed, scene, frame, sensor and beam it is
  // the address of the row's random numbers, so it stays when rows are removed. The scan's column `return` numbers the
  // remaining returns anew, the nearest first.
  std::uint32_t number(std::size_t row) const { return onePerBeam() ? 0 : number_[row]; }
  // Returns an index into Hits, or kNoHit.
  std::uint32_t hit(std::size_t row) const { return onePerBeam() ? static_cast<std::uint32_t>(row) : hit_[row]; }
  // Returns the id of the object instance that the row belongs to; 0: none. Needs the channel Instance.
  std::uint32_t instanceOf(std::size_t row, const Hits& hits) const {
    if (!instance.empty()) return instance[row];
    return hit(row) == kNoHit ? 0 : hits.instance[hit(row)];
  }
  Cause cause(std::size_t row) const { return cause_.empty() ? Cause::Surface : cause_[row]; }

  void remove(std::size_t row) { range[row] = kMiss; }

  // Starts to record why rows are lost. Must be called after start().
  void tellReasons();
  bool tellsReasons() const { return tellsReasons_; }
  // Records `reason` for all rows that were lost since the last call of this or of noteFaint(). Does nothing if reasons
  // are not recorded.
  void noteLost(Reason reason);
  // Does the same for rows that the receiver did not find because they measured less than `least`. The reason is
  // LostInAir if the receiver would have found the row without the weather's loss, else TooFaint.
  void noteFaint(std::span<const float> measured, float least);
  // Returns why the row was lost; None: it was not lost, or its ray missed.
  Reason lostTo(std::size_t row) const { return row < lost_.size() ? lost_[row] : Reason::None; }
  // True if the beam has kMostReturns rows.
  bool full(std::uint32_t beam) const { return !rowsOfBeam_.empty() && rowsOfBeam_[beam] == kMostReturns; }
  // Appends a row; the other rows keep their indices. `hits`: those that the table was started from.
  void add(const AddedReturn& added, const Hits& hits);

  // Starts the table: with a row per beam if every beam fires one ray, else with a row per ray that has a hit.
  void start(const Hits& hits);
  // Starts the table with a row per echo; echoes are ordered by beam, then by range. `powered`: the echoes have the
  // power that the effect `intensity` computes, and the rows keep it.
  void start(std::span<const Echo> echoes, bool powered);

 private:
  void clear();
  template <class ReasonOf>
  void noteRemoved(const ReasonOf& reasonOf);
  void makeIndices(const Hits& hits);

  bool onePerBeam_ = true;
  std::vector<std::uint32_t> beam_;  // these three are empty if there is one row per beam
  std::vector<std::uint32_t> hit_;
  std::vector<std::uint8_t> number_;
  std::vector<Cause> cause_;              // empty: all come from surfaces
  std::vector<std::uint8_t> rowsOfBeam_;  // empty until a row is added
  bool tellsReasons_ = false;
  std::vector<Reason> lost_;   // as long as the table was when reasons were last recorded
  std::vector<bool> present_;  // as long as `lost_`; true: the row was not lost then
};

}  // namespace scanmill
