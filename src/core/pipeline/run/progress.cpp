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
constexpr double kBarInterval = 0.1;   // time between updates of the bar on a terminal (s)
constexpr double kLineInterval = 5.0;  // time between lines if the output is not a terminal (s)

}  // namespace

Progress::Progress(std::string what, std::uint64_t total, std::string unit, std::string workUnit, bool quiet)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      workUnit_(std::move(workUnit)),
      total_(total),
      quiet_(quiet),
      terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (!quiet_ && terminal_ && shown_) std::fputc('\n', stderr);
}

void Progress::advance(std::uint64_t count, double work) {
  done_ += count;
  work_ += work;
  const double now = seconds();
  if (done_ >= total_ || now - lastShown_ >= (terminal_ ? kBarInterval : kLineInterval)) {
    lastShown_ = now;
    show(done_ >= total_);
  }
}

void Progress::say(const std::string& doing) {
  if (quiet_) return;
  const double now = seconds();
  const std::string text = fmt::format("{} {}/{} {}  {}", what_, done_, total_, unit_, oneLine(doing));
  if (terminal_) {
    fmt::print(stderr, "\r{}\033[K", text);
    std::fflush(stderr);
    shown_ = true;
  } else if (!said_ || now - lastShown_ >= kLineInterval) {
    fmt::print(stderr, "{}\n", text);
    lastShown_ = now;
    said_ = true;
  }
}

void Progress::show(bool last) {
  if (quiet_) return;
  const double elapsed = std::max(seconds(), 1e-9);
  const double share = total_ == 0 ? 1.0 : static_cast<double>(done_) / static_cast<double>(total_);
  const std::string rest =
      last ? fmt::format("in {}", shortTime(elapsed)) : fmt::format("ETA {}", shortTime(elapsed / share * (1 - share)));
  const std::string text = fmt::format("{} {}/{} {}  {} {}/s  {}", what_, done_, total_, unit_,
                                       shortNumber(work_ / elapsed), workUnit_, rest);
  if (!terminal_) {
    fmt::print(stderr, "{}\n", text);
    return;
  }
  const int filled = static_cast<int>(share * kBarWidth);
  fmt::print(stderr, "\r[{:#<{}}{:-<{}}] {}\033[K", "", filled, "", kBarWidth - filled, text);
  std::fflush(stderr);
  shown_ = true;
}

}  // namespace scanmill
