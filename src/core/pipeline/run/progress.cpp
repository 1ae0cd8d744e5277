#include "pipeline/run/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "base/short_text.h"
#include "base/terminal.h"

namespace scanmill {

namespace {

constexpr int kBarWidth = 30;
constexpr double kBarInterval = 0.1;   // s, between updates of the bar on a terminal
constexpr double kLineInterval = 5.0;  // s, between lines if the output is not a terminal

}  // namespace

Progress::Progress(std::string what, std::uint64_t total, std::string unit, std::string workUnit, bool quiet)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      workUnit_(std::move(workUnit)),
      total_(total),
      quiet_(quiet),
      isTerminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (!quiet_ && isTerminal_ && barShown_) std::fputc('\n', stderr);
}

void Progress::advance(std::uint64_t count, double work) {
  done_ += count;
  work_ += work;
  const double now = seconds();
  if (done_ >= total_ || now - lastShown_ >= (isTerminal_ ? kBarInterval : kLineInterval)) {
    lastShown_ = now;
    show(done_ >= total_);
  }
}

void Progress::say(const std::string& stage) {
  if (quiet_) return;
  const double now = seconds();
  const std::string text = fmt::format("{} {}/{} {}  {}", what_, done_, total_, unit_, oneLine(stage));
  if (isTerminal_) {
    fmt::print(stderr, "\r{}\033[K", text);
    std::fflush(stderr);
    barShown_ = true;
  } else if (!stageShown_ || now - lastShown_ >= kLineInterval) {
    fmt::print(stderr, "{}\n", text);
    lastShown_ = now;
    stageShown_ = true;
  }
}

void Progress::show(bool isEnd) {
  if (quiet_) return;
  const double elapsed = std::max(seconds(), 1e-9);  // s; not 0, since it is a divisor
  const double fraction = total_ == 0 ? 1.0 : static_cast<double>(done_) / static_cast<double>(total_);
  const std::string timeText = isEnd ? fmt::format("in {}", shortTime(elapsed))
                                     : fmt::format("ETA {}", shortTime(elapsed / fraction * (1 - fraction)));
  const std::string text = fmt::format("{} {}/{} {}  {} {}/s  {}", what_, done_, total_, unit_,
                                       shortNumber(work_ / elapsed), workUnit_, timeText);
  if (!isTerminal_) {
    fmt::print(stderr, "{}\n", text);
    return;
  }
  const int filledWidth = static_cast<int>(fraction * kBarWidth);
  fmt::print(stderr, "\r[{:#<{}}{:-<{}}] {}\033[K", "", filledWidth, "", kBarWidth - filledWidth, text);
  std::fflush(stderr);
  barShown_ = true;
}

}  // namespace scanmill
