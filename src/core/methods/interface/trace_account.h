#pragma once

// The time that a call of a method took, and its warnings for the user. This header is installed because
// methods/interface/method.h includes it.
//
//   TraceAccount account;
//   account += makeReference(scene)->trace(shot, Channel::Range, hits);
//   const std::vector<std::string> warnings = account.warningTexts();

#include <cstdint>
#include <string>
#include <vector>

#include "base/stage_clock.h"

namespace scanmill {

// A problem of some beams of a scan, which makes these beams less accurate than the user expects.
struct BeamWarning {
  std::string sensor;       // name of the sensor
  unsigned kind = 0;        // number of the warning within its method; a sensor's warnings are reported in this order
  std::uint64_t count = 0;  // number of the scan's beams with the problem
  std::string text;         // the complete sentence for the user, with count, sensor and remedy
};

struct TraceAccount {
  StageSeconds seconds;               // seconds of each stage of the method; empty if it has only one stage
  std::vector<BeamWarning> warnings;  // at most one per sensor and kind, ordered by sensor and then kind

  // Adds a warning. Of two warnings with the same sensor and kind, only the one with more beams is kept: a user is
  // interested in the worst scan, and the order in which scans are traced must not change the report.
  void warn(BeamWarning warning);
  // Adds the seconds and the warnings of `other`.
  TraceAccount& operator+=(const TraceAccount& other);
  std::vector<std::string> warningTexts() const;
};

}  // namespace scanmill
