#include "viewer/window/playback.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

namespace scanmill {

namespace {

// Playing speeds as multiples of the recorded speed; 0: as fast as frames load.
constexpr std::array<double, 5> kSpeeds{0.5, 1, 2, 5, 0};
constexpr std::size_t kUsualSpeed = 1;

}  // namespace

Playback::Playback(std::shared_ptr<const FrameSource> source, std::unique_ptr<FrameLoader> loader,
                   const std::string& sample)
    : source_(std::move(source)), loader_(std::move(loader)), speed_(kUsualSpeed) {
  goTo(findFrame(*source_, sample), 0);
}

void Playback::goTo(std::size_t frame, int step) {
  requested_ = std::min(frame, count() - 1);
  loader_->want(requested_, step);
}

bool Playback::stepBy(std::ptrdiff_t steps) {
  const auto last = static_cast<std::ptrdiff_t>(count()) - 1;
  const auto from = static_cast<std::ptrdiff_t>(requested_);
  const std::ptrdiff_t target = std::clamp(from + steps, std::ptrdiff_t{0}, last);
  if (target == from) return false;
  goTo(static_cast<std::size_t>(target), steps > 0 ? 1 : -1);
  return true;
}

std::shared_ptr<const ViewFrame> Playback::take(double now, bool wait) {
  if (settled()) return nullptr;
  auto loaded = wait ? loader_->wait(requested_) : loader_->frame(requested_);
  if (!loaded) return nullptr;
  const bool next = current_ && requested_ == *current_ + 1;
  const std::optional<double> time = loaded->scans.empty() ? std::nullopt : std::optional(loaded->scans.front().time);
  recordedSeconds_ = next ? time.value_or(0) - currentTime_.value_or(0) : 0;
  currentTime_ = time;
  current_ = requested_;
  shownAt_ = now;
  return loaded;
}

void Playback::togglePlaying(double now) {
  playing_ = !playing_;
  if (!playing_) return;
  shownAt_ = now;
  if (requested_ + 1 >= count()) goTo(0, 1);
}

// Returns how long each frame is shown while frames are played (s).
double Playback::frameSeconds() const {
  constexpr double kLeast = 0.1;  // least time per frame at speed 1 (s)
  constexpr double kMost = 0.2;   // largest time per frame at speed 1 (s), even if the recorded interval is longer
  const double times = kSpeeds[speed_];
  return times > 0 ? std::clamp(recordedSeconds_, kLeast, kMost) / times : 0;
}

std::string Playback::speedText() const {
  const double times = kSpeeds[speed_];
  return times > 0 ? fmt::format("{}x", times) : "as fast as it loads";
}

void Playback::changeSpeed(int step) {
  const int last = static_cast<int>(kSpeeds.size()) - 1;
  speed_ = static_cast<std::size_t>(std::clamp(static_cast<int>(speed_) + step, 0, last));
}

bool Playback::tick(double now) {
  bool changed = false;
  if (playing_ && settled() && now - shownAt_ >= frameSeconds()) {
    playing_ = requested_ + 1 < count();
    if (playing_) goTo(requested_ + 1, 1);
    changed = true;
  }
  if (std::string loading = loader_->busy(); loading != busy_) {
    busy_ = std::move(loading);
    changed = true;
  }
  return changed;
}

void Playback::readAhead() {
  if (readsAhead_) return;
  readsAhead_ = true;
  loader_->want(requested_, 1);
}

}  // namespace scanmill
