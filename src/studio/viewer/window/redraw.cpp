#include "base/stage_clock.h"
#include "viewer/window/session_context.h"

namespace scanmill {

namespace {

constexpr std::uint64_t kLeastPoints = 150'000;  // least limit for the points of all items together; about one scan

}  // namespace

RedrawScheduler::RedrawScheduler(Canvas& canvas, std::function<double()> seconds)
    : canvas_(canvas), seconds_(std::move(seconds)) {
  if (!seconds_) seconds_ = [timer = WallTimer()] { return timer.seconds(); };
}

void RedrawScheduler::setViews(std::vector<CanvasView> views) {
  const bool sameRects = std::ranges::equal(views, views_, {}, &CanvasView::rect, &CanvasView::rect);
  if (sameRects && !changes.views && !changes.items) return;
  views_ = std::move(views);
  canvas_.setViews(views_);
  changes.views = true;
}

// Returns the maximum number of points to draw per item (0: all), for `items` items with `total` points together.
std::uint64_t RedrawScheduler::pointsPerItem(std::uint64_t total, std::size_t items) const {
  constexpr double kPictureMs = 30;  // intended time for drawing a picture during motion
  const auto limit = std::max(static_cast<std::uint64_t>(pointsPerMs_ * kPictureMs), kLeastPoints);
  return total <= limit || items == 0 ? 0 : limit / items;
}

// Updates the estimated drawing speed after a picture of `points` points, which took `ms` milliseconds to draw. Ignores
// pictures of few points, which say little about the speed.
void RedrawScheduler::updateSpeed(std::uint64_t points, double ms) {
  if (points < kLeastPoints / 2 || !(ms > 0)) return;
  constexpr double kSlowest = 500, kFastest = 1e6;  // plausible speeds (points per ms)
  constexpr double kNewShare = 0.5;                 // weight of the new measurement
  pointsPerMs_ += kNewShare * (std::clamp(static_cast<double>(points) / ms, kSlowest, kFastest) - pointsPerMs_);
}

void RedrawScheduler::draw(Detail detail, std::uint64_t points, std::size_t items, double began) {
  const bool drawsAll = detail == Detail::AllPoints;
  const bool sceneChanged = changes.views || changes.items;
  if (!sceneChanged && !changes.panels && !changes.highlight && !(drawsAll && partial_)) return;
  const std::uint64_t maxPoints = drawsAll ? 0 : sceneChanged ? pointsPerItem(points, items) : lastMaxPoints_;
  const double renderBegan = now();
  canvas_.render(maxPoints);
  lastPicture_ = now();
  if (sceneChanged) lastChange_ = lastPicture_;
  if (sceneChanged || (drawsAll && partial_)) {
    const double seconds = lastPicture_ - renderBegan;
    updateSpeed(maxPoints == 0 ? points : std::min(points, maxPoints * items), seconds * 1e3);
    if (maxPoints == 0) allPointsSeconds_ = seconds;
  }
  lastMaxPoints_ = maxPoints;
  partial_ = maxPoints != 0;
  pictureSeconds_ = lastPicture_ - began;
  changes = {.views = false, .items = false, .panels = false, .highlight = false, .hover = changes.hover};
}

bool RedrawScheduler::mayFollowPointer() const {
  constexpr double kBetweenPictures = 0.012;  // least time between pictures while the pointer moves (s)
  return now() - lastPicture_ > std::max(kBetweenPictures, pictureSeconds_);
}

bool RedrawScheduler::allPointsDue() const {
  // Time (s) without changes after which all points are drawn. It is longer if drawing all points takes long.
  const double pause = 0.15 + 0.5 * allPointsSeconds_;
  return partial_ && now() - lastChange_ > pause;
}

bool RedrawScheduler::isSlow() const {
  constexpr double kQuick = 0.05;  // longest time for drawing all points that does not count as slow (s)
  return allPointsSeconds_ > kQuick;
}

}  // namespace scanmill
