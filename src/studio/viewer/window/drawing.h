#pragma once

// Drawing decides when the canvas is drawn, and with how many points: quickly with few points while something moves,
// with all points when nothing has changed for a while.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "viewer/canvas/canvas.h"
#include "viewer/window/draw_pace.h"

namespace scanmill {

// What has changed since the last picture.
struct Changes {
  bool views = true;   // cameras or rectangles of views
  bool items = true;   // points, lines or triangles
  bool panels = true;  // text and panels over the views
  bool light = false;  // points that are highlighted
  bool hover = false;  // the pointer, or what is under it
};

class Drawing {
 public:
  // `seconds`: a clock that never goes back; empty: the time since now.
  explicit Drawing(Canvas& canvas, std::function<double()> seconds = {});

  double now() const { return seconds_(); }  // s
  const std::vector<CanvasView>& views() const { return views_; }

  // Gives the canvas these views if a camera, an item or a rectangle has changed.
  void setViews(std::vector<CanvasView> views);
  // Draws a picture if something has changed or, with `whole`, if the last picture lacks points. `points`: number of
  // points that the items show together; `items`: number of items with points. `began`: the time at which the work for
  // this picture began.
  void draw(bool whole, std::uint64_t points, std::size_t items, double began);

  // True if so much time has passed since the last picture that moves of the pointer are drawn.
  bool mayFollowPointer() const;
  // True if the last picture lacks points, and nothing has changed for so long that all of them should be drawn.
  bool wholeIsDue() const;
  // True if a picture of all points takes so long that highlighting waits until the pointer rests.
  bool slow() const;
  bool drawnOnce() const { return lastPicture_ > 0; }

  Changes changes;

 private:
  Canvas& canvas_;
  std::function<double()> seconds_;
  DrawPace pace_;
  std::vector<CanvasView> views_;
  bool partial_ = false;        // the last picture did not show all points
  std::uint64_t lastMost_ = 0;  // the limit of points per item in the last picture; 0: none
  double lastChange_ = 0;       // s, time of the last change of anything except the overlay
  double wholeSeconds_ = 0;     // time that the last picture of all points took
  double lastPicture_ = 0;      // s, time of the last picture
  double pictureSeconds_ = 0;   // time that the last picture took, with the work before it
};

}  // namespace scanmill
