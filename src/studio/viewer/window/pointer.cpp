#include "viewer/window/pointer.h"

namespace scanmill {

namespace {

constexpr Rgb kMeasureColor{255, 240, 90};

}  // namespace

Pointer::Pointer(SessionContext& context, const Clouds& clouds, Scenery& scenery)
    : context_(context), clouds_(clouds), scenery_(scenery), litItem_(context.canvas, kLitItem) {}

void Pointer::leaveFrame() {
  hover.reset();
  pinned.reset();
  lastSummary_.reset();
  ends.clear();
  measuring = false;
}

void Pointer::moveBy(const Affine& newFromOld) {
  for (Vec3d& end : ends) end = newFromOld * end;
  if (pinned) pinned->place = newFromOld * pinned->place;
  hover.reset();
  placeMeasure();
}

void Pointer::press(const CanvasEvent& event) {
  x = event.x;
  y = event.y;
  drag = {};
  if (!viewAt(event.x, event.y)) return;
  if (event.button == 1 && event.clicks == 2) return turnAbout();
  drag.button = event.button;
  drag.pan = event.button != 1 || event.shift;
  drag.downX = drag.x = event.x;
  drag.downY = drag.y = event.y;
}

void Pointer::moveTo(const CanvasEvent& event) {
  constexpr int kStill = 3;  // largest distance (pixels) that the pointer moves during a click
  x = event.x;
  y = event.y;
  context_.changes.hover = true;
  lastMove_ = context_.drawing.now();
  if (drag.button == 0) return;
  const int right = event.x - drag.x;
  const int down = event.y - drag.y;
  drag.moved = drag.moved || std::abs(event.x - drag.downX) > kStill || std::abs(event.y - drag.downY) > kStill;
  if (!drag.moved || context_.drawing.views().empty()) return;
  drag.x = event.x;
  drag.y = event.y;
  const PixelRect& rect = context_.drawing.views()[viewAt(drag.downX, drag.downY).value_or(0)].rect;
  OrbitCamera turned = scenery_.camera;
  if (drag.pan) {
    turned.pan(right, down, rect.width, rect.height);
  } else {
    turned.orbit(right, down, rect.height);
  }
  scenery_.setCamera(turned);
}

void Pointer::release(const CanvasEvent& event) {
  if (event.button != drag.button) return;
  const PointerDrag was = drag;
  drag = {};
  x = event.x;
  y = event.y;
  context_.changes.hover = true;
  if (was.button == 1 && !was.moved) click(event.x, event.y);
}

void Pointer::click(int px, int py) {
  auto thing = pick(px, py);
  context_.changes.panels = true;
  if (!measuring) {
    pinned.reset();
    if (thing) pinned = inFull(std::move(*thing));
    return;
  }
  if (!thing) return context_.say("nothing lies there");
  ends.push_back(thing->place);
  measuring = ends.size() < 2;
  placeMeasure();
}

void Pointer::toggleMeasuring() {
  const bool start = !measuring && ends.empty();
  ends.clear();
  measuring = start;
  if (start && pinned) ends.push_back(pinned->place);
  placeMeasure();
}

void Pointer::turnAbout() {
  auto thing = x >= 0 ? pick(x, y) : std::nullopt;
  if (!thing) thing = pinned;
  if (!thing) return context_.say("nothing lies there");
  lookAt(thing->place);
}

void Pointer::lookAt(const Vec3d& place) {
  OrbitCamera turned = scenery_.camera;
  turned.lookAt(place);
  scenery_.setCamera(turned);
}

void Pointer::placeMeasure() {
  LineSet line;
  if (ends.size() == 2) line.add(ends[0], ends[1], kMeasureColor);
  scenery_.setLines(kMeasureItem, line, 2);
  context_.changes.items = context_.changes.panels = true;
}

}  // namespace scanmill
