#pragma once

// The pointer: what is under it or was clicked, and what is drawn for that: the instance's outline, the beam through
// its returns, a measured distance.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "viewer/window/clouds.h"
#include "viewer/window/scenery.h"
#include "viewer/window/session_context.h"
#include "viewer/window/session_items.h"

namespace scanmill {

// An instance in a scan of the frame.
struct InstancePlace {
  std::size_t scan = 0;
  std::uint32_t id = 0;
  bool operator==(const InstancePlace&) const = default;
};

struct PointerDrag {
  int button = 0;  // 0: none
  bool pan = false;
  int downX = 0, downY = 0;  // px
  int x = 0, y = 0;
  bool moved = false;
};

struct Pointer {
  Pointer(SessionContext& context, const Clouds& clouds, Scenery& scenery);

  // Forgets everything that belongs to a frame.
  void leaveFrame();
  // Moves what is marked when positions on the canvas change.
  void moveBy(const Affine& newFromOld);

  // pointer.cpp: dragging, clicking, measuring
  void press(const CanvasEvent& event);
  void moveTo(const CanvasEvent& event);
  void release(const CanvasEvent& event);
  void toggleMeasuring();
  void turnAbout();
  void lookAt(const Vec3d& place);
  void placeMeasure();
  // Returns what is under the pointer, or else what was clicked; null: nothing.
  const PickedThing* shown() const { return hover ? &*hover : pinned ? &*pinned : nullptr; }

  // pointer_pick.cpp: the point or the triangle at a pixel
  std::optional<PickedThing> pick(int px, int py) const;
  // `rect`: px of the canvas, where the range image is drawn.
  std::optional<PickedThing> pickStrip(const PixelRect& rect, int px, int py) const;
  PickedThing pickedPoint(std::size_t cloud, std::size_t point) const;
  // Adds the returns of the same beam in the other scans that are shown.
  PickedThing inFull(PickedThing thing) const;
  // True if the point or triangle is not hidden and its scan is shown.
  bool isShown(const PickedThing& thing) const;
  // Finds what is under the pointer. `panels`: a panel is. `strip`: the rectangle of the range image, if that is.
  void updateHover(bool panels, const std::optional<PixelRect>& strip);
  Rgb colorOf(const PickedThing& thing) const;
  std::optional<std::uint32_t> instanceOf(const PickedThing& thing) const;  // none: belongs to no instance

  // pointer_light.cpp
  // Outlines the points of the instance under the pointer, or else of the clicked one.
  void lightInstance();
  // Draws a line through the returns of the beam that is under the pointer or was clicked.
  void placeBeam();

  int x = -1, y = -1;  // px of the canvas; negative: not on it
  std::optional<PickedThing> hover;
  std::optional<PickedThing> pinned;  // what was clicked
  PointerDrag drag;
  bool measuring = false;
  std::vector<Vec3d> ends;  // ends of the measured distance, canvas frame

 private:
  std::optional<std::size_t> viewAt(int px, int py) const;
  void click(int px, int py);
  const InstanceSummary& summaryOf(const ShownCloud& cloud, std::uint32_t instance) const;
  void outline(const ShownCloud& cloud, bool anew);

  SessionContext& context_;
  const Clouds& clouds_;
  Scenery& scenery_;
  double lastMove_ = 0;  // s, time of the pointer's last move
  mutable std::optional<std::pair<InstancePlace, InstanceSummary>> lastSummary_;
  std::optional<InstancePlace> lit_;  // the instance that is highlighted on the canvas
  CanvasItem litItem_;
  std::optional<std::pair<std::size_t, std::size_t>> beamOf_;  // scan and point whose beam is drawn through its returns
  bool beamDrawn_ = false;
};

}  // namespace scanmill
