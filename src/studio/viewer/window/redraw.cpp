#include "viewer/window/redraw.h"

#include <algorithm>

#include "base/stage_clock.h"

namespace scanmill {

namespace {

constexpr std::uint64_t kLeast = 150'000;  // least limit for the points of all items together; about one scan

}  // namespace

RedrawScheduler::RedrawScheduler(Canvas& canvas, std::function<double()> seconds)
    : canvas_(canvas), seconds_(std::move(seconds)) {
  if (!seconds_) seconds_ = [timer = WallTimer()] { return timer.seconds(); };
}

void RedrawScheduler::setViews(std::vector<CanvasView> views) {
  const bool same =
      std::ranges::equal(views, views_, [](const CanvasView& a, const CanvasView& b) { return a.rect == b.rect; });
  if (same && !changes.views && !changes.items) return;
  views_ = std::move(views);
  canvas_.setViews(views_);
  changes.views = true;
}

// Returns how many points of each item to draw at most (0: all), for `items` items with `total` points together.
std::uint64_t RedrawScheduler::mostOfEach(std::uint64_t total, std::size_t items) const {
  constexpr double kWantedMs = 30;
  const auto all = std::max(static_cast<std::uint64_t>(pointsPerMs_ * kWantedMs), kLeast);
  return total <= all || items == 0 ? 0 : all / items;
}

void RedrawScheduler::measured(std::uint64_t points, double ms) {
  if (points < kLeast / 2 || !(ms > 0)) return;
  pointsPerMs_ += 0.5 * (std::clamp(static_cast<double>(points) / ms, 500.0, 1e6) - pointsPerMs_);
}

void RedrawScheduler::draw(Detail detail, std::uint64_t points, std::size_t items, double began) {
  const bool whole = detail == Detail::AllPoints;
  const bool sceneChanged = changes.views || changes.items;
  if (!sceneChanged && !changes.panels && !changes.highlight && !(whole && partial_)) return;
  const std::uint64_t most = whole ? 0 : sceneChanged ? mostOfEach(points, items) : lastMost_;
  const double before = now();
  canvas_.render(most);
  lastPicture_ = now();
  if (sceneChanged) lastChange_ = lastPicture_;
  if (sceneChanged || (whole && partial_)) {
    const double seconds = lastPicture_ - before;
    measured(most == 0 ? points : std::min(points, most * items), seconds * 1e3);
    if (most == 0) allPointsSeconds_ = seconds;
  }
  lastMost_ = most;
  partial_ = most != 0;
  pictureSeconds_ = lastPicture_ - began;
  changes = {false, false, false, false, changes.hover};
}

bool RedrawScheduler::mayFollowPointer() const {
  constexpr double kBetweenPictures = 0.012;  // least time between pictures while the pointer moves (s)
  return now() - lastPicture_ > std::max(kBetweenPictures, pictureSeconds_);
}

bool RedrawScheduler::allPointsDue() const {
  // Time (s) without changes after which all points are drawn. It is longer if drawing all points takes long.
  const double rest = 0.15 + 0.5 * allPointsSeconds_;
  return partial_ && now() - lastChange_ > rest;
}

bool RedrawScheduler::slow() const {
  constexpr double kQuick = 0.05;  // longest time for drawing all points that does not count as slow (s)
  return allPointsSeconds_ > kQuick;
}

}  // namespace scanmill
