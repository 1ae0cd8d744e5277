#pragma once

// The time that a call of a method took, and its warnings for the user.

#include <cstdint>
#include <string>
#include <vector>

#include "base/stage_clock.h"

namespace scanmill {

// A problem with some beams of a scan, which makes them worse than the user expects.
struct BeamWarning {
  std::string sensor;       // the sensor's name
  unsigned kind = 0;        // number of the warning in its method; warnings are reported in this order
  std::uint64_t count = 0;  // how many of the scan's beams are affected
  std::string text;         // the complete sentence, with the count, the sensor and the remedy
};

struct TraceAccount {
  StageSeconds seconds;               // by the method's stages; empty if it has only one
  std::vector<BeamWarning> warnings;  // at most one for each sensor and kind, in the order of sensor and kind

  // Adds a warning. Of two warnings of the same sensor and kind only the one with more beams is kept: a user wants to
  // know the worst scan, and the order in which scans are traced must not change what is reported.
  void warn(BeamWarning warning);
  // Adds the seconds and the warnings of `other`.
  TraceAccount& operator+=(const TraceAccount& other);
  std::vector<std::string> warningTexts() const;
};

}  // namespace scanmill
