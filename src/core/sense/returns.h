#pragma once

// The table of returns: what the receiver makes of what the rays meet, one row per return. Detection starts it from the
// hits; effects change, remove and add rows; gathering makes a scan of what is left.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "scan/hits.h"
#include "scan/reasons.h"
#include "sense/echoes.h"

namespace scanmill {

// The row comes from no hit: an effect added it.
constexpr std::uint32_t kNoHit = 0xFFFFFFFF;

// A row that an effect adds.
struct AddedReturn {
  std::uint32_t beam = 0;
  float range = 0;  // m along the beam
  float power = 0;  // of the return, as the effect `intensity` has it
  float intensity = 0;
  float snr = 0;
  Cause cause = Cause::FalsePositive;
  std::uint16_t label = 0;
  std::uint32_t instance = 0;
};

// A structure of arrays. Most often every beam has one ray and one return at most: then row i is the first return of
// beam i and comes from hit i, and the columns that say so stay empty, so that nothing is spent on them.
class Returns {
 public:
  std::vector<float> range;      // m along the beam; kMiss: the row was removed, or never was
  std::vector<float> gain;       // factor of the power: speckle, the strength of a laser; empty: 1
  std::vector<float> power;      // before the sensor's response; empty until an effect sets it
  std::vector<float> intensity;  // what the sensor makes of the power; empty until an effect sets it
  std::vector<Vec3f>
      displacement;  // m, sensor axes, added to origin + range * direction; empty until an effect needs it
  std::vector<std::uint16_t> label;     // class id; empty: the hits'
  std::vector<std::uint32_t> instance;  // empty: the hits'

  // Of beams that fire several rays; empty where each ray is a return of its own.
  std::vector<float> spread;          // m, standard deviation of the ranges that the echo is made of
  std::vector<float> share;           // of the echo's power, that comes from the class of its label
  std::vector<std::uint16_t> label2;  // the class that gives most of the rest; 0: none

  std::vector<float> air;  // part of the power that the weather leaves; empty: all, or nobody wants to know

  std::vector<float> snr;  // power over the receiver's noise; empty until an effect sets it

  // The power of the rows that come from a hit is known from detection: the echoes of several rays.
  bool powerOfEchoes = false;

  std::size_t size() const { return range.size(); }
  bool returned(std::size_t row) const { return range[row] < kMiss; }

  // Whether row i is the first return of beam i and comes from hit i.
  bool onePerBeam() const { return onePerBeam_; }
  std::uint32_t beam(std::size_t row) const { return onePerBeam() ? static_cast<std::uint32_t>(row) : beam_[row]; }
  // Of the beam's rows, counted from 0: with seed, scene, frame, sensor and beam the address of the row's randomness.
  // Removed rows keep theirs. The scan's column `return` counts anew what is left, the nearest first.
  std::uint32_t number(std::size_t row) const { return onePerBeam() ? 0 : number_[row]; }
  // Index into Hits, or kNoHit.
  std::uint32_t hit(std::size_t row) const { return onePerBeam() ? static_cast<std::uint32_t>(row) : hit_[row]; }
  // Of the thing that a row is of; 0: none. Needs the channel Instance.
  std::uint32_t instanceOf(std::size_t row, const Hits& hits) const {
    if (!instance.empty()) return instance[row];
    return hit(row) == kNoHit ? 0 : hits.instance[hit(row)];
  }
  Cause cause(std::size_t row) const { return cause_.empty() ? Cause::Surface : cause_[row]; }

  void remove(std::size_t row) { range[row] = kMiss; }

  // From now on the table keeps why rows are lost. To be called once it is started.
  void tellReasons();
  bool tellsReasons() const { return tellsReasons_; }
  // Says why the rows were lost that have been since this was last called; nothing where nobody wants to know.
  void noteLost(Reason reason);
  // The same of rows that the receiver did not find, being measured as less than `least`: the air has them where they
  // would have been found without what it took.
  void noteFaint(std::span<const float> measured, float least);
  // None: the row is not lost, or there has never been one.
  Reason lostTo(std::size_t row) const { return row < lost_.size() ? lost_[row] : Reason::None; }
  // Whether the beam has as many rows as it may.
  bool full(std::uint32_t beam) const { return !rowsOfBeam_.empty() && rowsOfBeam_[beam] == kMostReturns; }
  // Rows before it stay where they are. `hits`: those that the table was started from.
  void add(const AddedReturn& added, const Hits& hits);

  // Starts the table: of beams that fire one ray a row per beam, of others one for each ray that meets something.
  void start(const Hits& hits);
  // Starts it with a row per echo, by beam and then by range. `powered`: their power is what the effect `intensity`
  // makes of it, and is kept.
  void start(std::span<const Echo> echoes, bool powered);

 private:
  void clear();
  template <class ReasonOf>
  void noteRemoved(const ReasonOf& reasonOf);
  void makeIndices(const Hits& hits);

  bool onePerBeam_ = true;
  std::vector<std::uint32_t> beam_;  // these three are empty where there is one row per beam
  std::vector<std::uint32_t> hit_;
  std::vector<std::uint8_t> number_;
  std::vector<Cause> cause_;              // empty: all come from surfaces
  std::vector<std::uint8_t> rowsOfBeam_;  // once rows are added
  bool tellsReasons_ = false;
  std::vector<Reason> lost_;   // as long as the table was when it was last looked at
  std::vector<bool> present_;  // likewise: the row was there
};

}  // namespace scanmill
