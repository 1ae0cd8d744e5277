#include "viewer/window/playback.h"

namespace scanmill {

Playback::Playback(std::shared_ptr<const FrameSource> source, std::unique_ptr<FrameLoader> loader,
                   const std::string& sample)
    : source_(std::move(source)), loader_(std::move(loader)) {
  goTo(source_->find(sample), 0);
}

void Playback::goTo(std::size_t frame, int step) {
  requested_ = std::min(frame, count() - 1);
  loader_->want(requested_, step);
}

bool Playback::stepBy(std::ptrdiff_t steps) {
  const auto last = static_cast<std::ptrdiff_t>(count()) - 1;
  const auto current = static_cast<std::ptrdiff_t>(requested_);
  const std::ptrdiff_t target = std::clamp(current + steps, std::ptrdiff_t{0}, last);
  if (target == current) return false;
  goTo(static_cast<std::size_t>(target), steps > 0 ? 1 : -1);
  return true;
}

std::shared_ptr<const ViewFrame> Playback::take(double now) {
  if (isUpToDate()) return nullptr;
  auto loaded = loader_->frame(requested_);
  if (!loaded) return nullptr;
  const bool followsCurrent = current_ && requested_ == *current_ + 1;
  const std::optional<double> time = loaded->scans.empty() ? std::nullopt : std::optional(loaded->scans.front().time);
  recordedSeconds_ = followsCurrent ? time.value_or(0) - currentTime_.value_or(0) : 0;
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

bool Playback::tick(double now) {
  bool changed = false;
  const double shownSeconds = std::clamp(recordedSeconds_, 0.1, 0.2);  // time per frame while playing (s)
  if (playing_ && isUpToDate() && now - shownAt_ >= shownSeconds) {
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
