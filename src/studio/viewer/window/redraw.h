#pragma once

// Decides when the canvas is drawn, and with how many points: with few points, to be fast, while something moves; with
// all points when nothing has changed for a while.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "viewer/canvas/canvas.h"

namespace scanmill {

// The changes since the last picture.
struct Changes {
  bool views = true;       // cameras or rectangles of views
  bool items = true;       // points, lines or triangles
  bool panels = true;      // text and panels over the views
  bool highlight = false;  // points that are highlighted
  bool hover = false;      // the pointer, or what is under it
};

enum class Detail { Fast, AllPoints };  // Fast: as many points as can be drawn while something moves

class RedrawScheduler {
 public:
  // `seconds`: a clock (s) that never goes back; empty: uses a clock that starts now.
  explicit RedrawScheduler(Canvas& canvas, std::function<double()> seconds = {});

  double now() const { return seconds_(); }  // returns the clock's time (s)
  const std::vector<CanvasView>& views() const { return views_; }

  // Passes the views to the canvas if a camera, an item or a rectangle has changed.
  void setViews(std::vector<CanvasView> views);
  // Draws a picture if something has changed or, with AllPoints, if the last picture lacks points. `points`: number of
  // points that the items show together; `items`: number of items with points. `began`: the time at which the work for
  // this picture began.
  void draw(Detail detail, std::uint64_t points, std::size_t items, double began);

  // True if enough time has passed since the last picture to draw a new one after a move of the pointer.
  bool mayFollowPointer() const;
  // True if the last picture lacks points, and nothing has changed for so long that all points should be drawn.
  bool allPointsDue() const;
  // True if a picture of all points takes so long that highlighting waits until the pointer rests.
  bool isSlow() const;
  bool drawnOnce() const { return lastPicture_ > 0; }

  Changes changes;

 private:
  std::uint64_t pointsPerItem(std::uint64_t total, std::size_t items) const;
  void updateSpeed(std::uint64_t points, double ms);

  Canvas& canvas_;
  std::function<double()> seconds_;
  std::vector<CanvasView> views_;
  double pointsPerMs_ = 20'000;      // drawing speed, estimated from the time that previous pictures took
  bool partial_ = false;             // true: the last picture did not show all points
  std::uint64_t lastMaxPoints_ = 0;  // maximum number of points per item in the last picture; 0: no limit
  double lastChange_ = 0;            // time of the last change of cameras, views or items (s)
  double allPointsSeconds_ = 0;      // duration of drawing the last picture of all points (s)
  double lastPicture_ = 0;           // time of the last picture (s)
  double pictureSeconds_ = 0;        // duration of the last picture, including the work before drawing (s)
};

}  // namespace scanmill
