#include "viewer/window/drawing.h"

#include <algorithm>

#include "base/wall_timer.h"

namespace scanmill {

Drawing::Drawing(Canvas& canvas, std::function<double()> seconds) : canvas_(canvas), seconds_(std::move(seconds)) {
  if (!seconds_) seconds_ = [timer = WallTimer()] { return timer.seconds(); };
}

void Drawing::setViews(std::vector<CanvasView> views) {
  const bool same =
      std::ranges::equal(views, views_, [](const CanvasView& a, const CanvasView& b) { return a.rect == b.rect; });
  if (same && !changes.views && !changes.items) return;
  views_ = std::move(views);
  canvas_.setViews(views_);
  changes.views = true;
}

void Drawing::draw(bool whole, std::uint64_t points, std::size_t items, double began) {
  const bool sceneChanged = changes.views || changes.items;
  if (!sceneChanged && !changes.panels && !changes.light && !(whole && partial_)) return;
  const std::uint64_t most = whole ? 0 : sceneChanged ? pace_.mostOfEach(points, items) : lastMost_;
  const double before = now();
  canvas_.render(most);
  lastPicture_ = now();
  if (sceneChanged) lastChange_ = lastPicture_;
  if (sceneChanged || (whole && partial_)) {
    const double seconds = lastPicture_ - before;
    pace_.measured(most == 0 ? points : std::min(points, most * items), seconds * 1e3);
    if (most == 0) wholeSeconds_ = seconds;
  }
  lastMost_ = most;
  partial_ = most != 0;
  pictureSeconds_ = lastPicture_ - began;
  changes = {false, false, false, false, changes.hover};
}

bool Drawing::mayFollowPointer() const {
  constexpr double kBetweenPictures = 0.012;  // least time between pictures while the pointer moves (s)
  return now() - lastPicture_ > std::max(kBetweenPictures, pictureSeconds_);
}

bool Drawing::wholeIsDue() const {
  // Time (s) without changes after which all points are drawn. It is longer if drawing all points takes long.
  const double rest = 0.15 + 0.5 * wholeSeconds_;
  return partial_ && now() - lastChange_ > rest;
}

bool Drawing::slow() const {
  constexpr double kQuick = 0.05;  // longest time for drawing all points that does not count as slow (s)
  return wholeSeconds_ > kQuick;
}

}  // namespace scanmill
