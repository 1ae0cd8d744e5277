#pragma once

// What a call of a method took, and what its user should know of it.

#include <cstdint>
#include <string>
#include <vector>

#include "base/stage_clock.h"

namespace scanmill {

// Something that happened to some beams of a scan and makes them worse than the user expects.
struct BeamWarning {
  std::string sensor;       // its name
  unsigned kind = 0;        // which of the method's warnings it is; they are told in this order
  std::uint64_t count = 0;  // how many of the scan's beams it happened to
  std::string text;         // the whole sentence, with the count, the sensor and what helps
};

struct TraceAccount {
  StageSeconds seconds;               // by the method's own stages; empty where it has but one
  std::vector<BeamWarning> warnings;  // at most one for each sensor and kind, in the order of sensor and kind

  // Adds a warning. Of two of the same sensor and kind the one with more beams stays: a user wants to know the worst
  // scan, and the order in which scans are traced must not change what is told.
  void warn(BeamWarning warning);
  // Adds up the seconds, and adds the warnings.
  TraceAccount& operator+=(const TraceAccount& other);
  std::vector<std::string> warningTexts() const;
};

}  // namespace scanmill
