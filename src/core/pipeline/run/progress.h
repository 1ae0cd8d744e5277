#pragma once

// Shows the progress of long work on standard error: as a bar on a terminal, otherwise as a line every few seconds.

#include <cstdint>
#include <string>

#include "base/stage_clock.h"

namespace scanmill {

class Progress {
 public:
  // `what`: name of the work. `total`: count at which the work is done. `unit`: unit of the count, such as "frames".
  // `workUnit`: unit of the work, such as "rays", which is shown per second. `quiet`: shows nothing.
  Progress(std::string what, std::uint64_t total, std::string unit, std::string workUnit, bool quiet);
  ~Progress();
  Progress& operator=(Progress&&) = delete;  // neither copied nor moved

  void setTotal(std::uint64_t total) { total_ = total; }  // for a total that was unknown at the start of the work
  void advance(std::uint64_t count, double work);
  // Shows the current stage of the work while the count does not advance: on a terminal in place of the bar,
  // otherwise as a line at most every few seconds.
  void say(const std::string& stage);
  double seconds() const { return timer_.seconds(); }
  std::uint64_t done() const { return done_; }
  std::uint64_t total() const { return total_; }

 private:
  // Shows the count and the estimated time left, or, at the end of the work, the time that it took.
  void show(bool isEnd);

  std::string what_, unit_, workUnit_;
  std::uint64_t total_ = 0;
  std::uint64_t done_ = 0;
  double work_ = 0;
  bool quiet_ = false;
  bool isTerminal_ = false;
  bool barShown_ = false;    // on a terminal
  bool stageShown_ = false;  // as a line
  WallTimer timer_;
  double lastShown_ = 0;  // time of the last output (s since the start)
};

}  // namespace scanmill
