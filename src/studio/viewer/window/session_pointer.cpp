// Handles the pointer: dragging, clicking, measuring.

#include <algorithm>

#include "viewer/window/session_state.h"

namespace scanmill {

void ViewSession::State::press(const CanvasEvent& event) {
  pointerX = event.x;
  pointerY = event.y;
  drag = {};
  if (!viewAt(event.x, event.y)) return;
  if (event.button == 1 && event.clicks == 2) return turnAbout();
  drag.button = event.button;
  drag.pan = event.button != 1 || event.shift;
  drag.downX = drag.x = event.x;
  drag.downY = drag.y = event.y;
}

void ViewSession::State::moveTo(const CanvasEvent& event) {
  constexpr int kStill = 3;  // px: a press that moves no farther is a click
  pointerX = event.x;
  pointerY = event.y;
  hoverChanged = true;
  lastMove = clock.seconds();
  if (drag.button == 0) return;
  const int right = event.x - drag.x;
  const int down = event.y - drag.y;
  drag.moved = drag.moved || std::abs(event.x - drag.downX) > kStill || std::abs(event.y - drag.downY) > kStill;
  if (!drag.moved || views.empty()) return;
  drag.x = event.x;
  drag.y = event.y;
  const PixelRect& rect = views[viewAt(drag.downX, drag.downY).value_or(0)].rect;
  OrbitCamera turned = camera;
  if (drag.pan) {
    turned.pan(right, down, rect.width, rect.height);
  } else {
    turned.orbit(right, down, rect.height);
  }
  setCamera(turned);
}

void ViewSession::State::release(const CanvasEvent& event) {
  if (event.button != drag.button) return;
  const PointerDrag was = drag;
  drag = {};
  pointerX = event.x;
  pointerY = event.y;
  hoverChanged = true;
  if (was.button == 1 && !was.moved) click(event.x, event.y);
}

void ViewSession::State::click(int x, int y) {
  auto thing = pick(x, y);
  hudChanged = true;
  if (!measuring) {
    pinned.reset();
    if (thing) pinned = inFull(std::move(*thing));
    return;
  }
  if (!thing) return say("nothing lies there");
  ends.push_back(thing->place);
  measuring = ends.size() < 2;
  placeMeasure();
}

void ViewSession::State::toggleMeasuring() {
  const bool start = !measuring && ends.empty();
  ends.clear();
  measuring = start;
  if (start && pinned) ends.push_back(pinned->place);
  placeMeasure();
}

void ViewSession::State::toggleAlone() {
  if (!aloneInstances.empty()) {
    aloneInstances.clear();
    applyFilter();
    return say("all instances");
  }
  refresh();  // the last moves of the pointer may not have been drawn yet
  updateHover();
  const std::optional<PickedThing>& thing = hover ? hover : pinned;
  if (!thing) return say("nothing lies there: point at an instance");
  const auto id = instanceOf(*thing);
  if (!id) return say("what lies there is of no instance");
  aloneInstances = {*id};
  applyFilter();
}

void ViewSession::State::turnAbout() {
  auto thing = pointerX >= 0 ? pick(pointerX, pointerY) : std::nullopt;
  if (!thing) thing = pinned;
  if (!thing) return say("nothing lies there");
  OrbitCamera turned = camera;
  turned.lookAt(thing->place);
  setCamera(turned);
}

}  // namespace scanmill
