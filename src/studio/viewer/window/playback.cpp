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
    : source_(std::move(source)),
      loader_(std::move(loader)),
      speed_(kUsualSpeed),
      seeking_(sample.empty() && !source_->isScene()),
      sought_(findFrame(*source_, sample)) {
  request(sought_, 0);
}

void Playback::request(std::size_t frame, int step) {
  requested_ = std::min(frame, count() - 1);
  loader_->want(requested_, step);
}

void Playback::goTo(std::size_t frame, int step) {
  seeking_ = false;
  request(frame, step);
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
  while (!settled()) {
    auto loaded = wait ? loader_->wait(requested_) : loader_->frame(requested_);
    if (!loaded || accept(loaded, now)) return loaded;
  }
  return nullptr;
}

// Makes the loaded frame the current one. Returns false if the frame could not be read and another frame has been
// requested instead.
bool Playback::accept(const std::shared_ptr<const ViewFrame>& loaded, double now) {
  const bool next = current_ && requested_ == *current_ + 1;
  const std::optional<double> time = loaded->scans.empty() ? std::nullopt : std::optional(loaded->scans.front().time);
  recordedSeconds_ = next ? time.value_or(0) - currentTime_.value_or(0) : 0;
  currentTime_ = time;
  current_ = requested_;
  shownAt_ = now;
  substituted_.clear();
  if (loaded->scans.empty() && !source_->isScene()) {
    unreadable_.insert(*current_);
    if (seeking_) {
      requestNextReadable();
      if (!settled()) return false;
    }
  } else {
    unreadable_.erase(*current_);
    if (seeking_ && *current_ != sought_) {
      substituted_ = fmt::format("{} cannot be read: {} is the first that can", source_->keys()[sought_], loaded->key);
    }
  }
  seeking_ = false;
  return true;
}

// Requests the next frame that is not known to be unreadable. If there is none, requests the frame with which the
// search began.
void Playback::requestNextReadable() {
  const auto known = source_->damaged();
  while (nextTried_ < count() &&
         (unreadable_.contains(nextTried_) || std::binary_search(known.begin(), known.end(), nextTried_))) {
    ++nextTried_;
  }
  if (nextTried_ < count()) return request(nextTried_++, 1);
  goTo(sought_, 1);
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

std::vector<std::size_t> Playback::damaged() const {
  std::set<std::size_t> all = unreadable_;
  for (const std::size_t frame : source_->damaged()) all.insert(frame);
  return {all.begin(), all.end()};
}

}  // namespace scanmill
