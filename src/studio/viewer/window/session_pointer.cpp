// What the pointer does.

#include <algorithm>

#include "viewer/window/session_state.h"

namespace scanmill {

void ViewSession::State::press(const CanvasEvent& event) {
  pointerX = event.x;
  pointerY = event.y;
  drag = {};
  if (const HudRegion* const region = regionAt(hud, event.x, event.y)) {
    if (event.button == 1) pressRegion(HudRegion(*region), event);
    return;
  }
  if (!viewAt(event.x, event.y)) return;
  if (event.button == 1 && event.clicks == 2) return turnAbout();
  drag.button = event.button;
  drag.pan = event.button != 1 || event.shift;
  drag.downX = drag.x = event.x;
  drag.downY = drag.y = event.y;
}

void ViewSession::State::pressRegion(const HudRegion& region, const CanvasEvent& event) {
  switch (region.part) {
    case HudPart::Legend: {
      if (region.pane >= hudState.panes.size() || !hudState.panes[region.pane].clickable) return;
      const auto& entries = hudState.panes[region.pane].legend.entries;
      if (region.entry >= entries.size() || entries[region.entry].id < 0) return;
      const bool alone = event.shift || event.clicks == 2;
      if (overlaid()) {
        const auto chosen = static_cast<std::size_t>(entries[region.entry].id);
        if (alone) {
          hiddenScans.clear();
          for (std::size_t s = 0; s < frame->scans.size(); ++s) {
            if (s != chosen) hiddenScans.insert(frame->scans[s].name);
          }
        } else if (hiddenScans.erase(frame->scans[chosen].name) == 0) {
          hiddenScans.insert(frame->scans[chosen].name);
        }
      } else if (const auto id = static_cast<std::uint16_t>(entries[region.entry].id); alone) {
        filter.showOnly(id);
      } else {
        filter.toggle(id);
      }
      return applyFilter();
    }
    case HudPart::LegendAll:
      return act({KeyAction::ShowAllClasses});
    case HudPart::Slider:
      playing = false;
      drag.button = event.button;
      drag.slider = region;
      return goTo(sliderFrame(region.rect, source->keys().size(), event.x), 1);
    case HudPart::PlayButton:
      return togglePlaying();
    case HudPart::Strip:
      if (auto thing = pickStrip(event.x, event.y)) {
        OrbitCamera turned = camera;
        turned.lookAt(thing->place);
        setCamera(turned);
        pinned = inFull(std::move(*thing));
        hudChanged = true;
      }
      return;
    case HudPart::Help:
      help = !help;
      hudChanged = true;
      return;
    case HudPart::Problem:  // read; those of the frame stay
      colorProblem.clear();
      meshProblem.clear();
      stripProblem.clear();
      instanceProblem.clear();
      hudChanged = true;
      return;
    case HudPart::Picture:
    case HudPart::Panel:
      return;
  }
}

void ViewSession::State::moveTo(const CanvasEvent& event) {
  constexpr int kStill = 3;  // px
  pointerX = event.x;
  pointerY = event.y;
  hoverChanged = true;
  lastMove = clock.seconds();
  if (drag.button == 0) return;
  if (drag.slider) {
    const std::size_t target = sliderFrame(drag.slider->rect, source->keys().size(), event.x);
    if (target != wanted) goTo(target, target > wanted ? 1 : -1);
    return;
  }
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
  if (was.button == 1 && !was.moved && !was.slider) click(event.x, event.y);
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
  refresh();  // moves may not have been drawn yet
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
