#pragma once

// Finds the point or triangle that is under the pointer or was clicked, and draws its instance's outline, a line
// through the returns of its beam, and measured distances. Also turns the camera while the user drags.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "viewer/window/scene_view.h"

namespace scanmill {

// An instance in a scan of the frame.
struct InstanceRef {
  std::size_t scan = 0;
  std::uint32_t id = 0;
  bool operator==(const InstanceRef&) const = default;
};

// A point of the frame: indices of the scan in the frame and of the point in the scan.
struct ScanPoint {
  std::size_t scan = 0, point = 0;
  bool operator==(const ScanPoint&) const = default;
};

struct PointerDrag {
  int button = 0;            // button that is pressed, see CanvasEvent; 0: none
  bool pan = false;          // true: the drag moves the camera; false: the drag turns it
  int downX = 0, downY = 0;  // pixel at which the button was pressed
  int x = 0, y = 0;          // pixel of the last move
  bool moved = false;        // true: the pointer has moved so far that the release is no click
};

struct Pointer {
  Pointer(SessionContext& context, const ShownClouds& clouds, SceneView& sceneView);

  // Resets the hovered and the selected element and the measured positions, which belong to the current frame.
  void leaveFrame();
  // Transforms the marked positions when the canvas frame changes.
  void moveBy(const Affine& newFromOld);

  // Events of the pointer: a press starts a drag, which moves or turns the camera; a release without a drag is a click.
  void press(const CanvasEvent& event);
  void moveTo(const CanvasEvent& event);
  void release(const CanvasEvent& event);
  void toggleMeasuring();
  void turnAbout();  // turns the camera to what is under the pointer, otherwise to what was clicked
  void lookAt(const Vec3d& position);
  void placeMeasure();  // draws the line between the measured ends
  // Returns what is under the pointer, otherwise what was clicked; null if there is neither.
  const PickedElement* hoveredOrPinned() const { return hover ? &*hover : pinned ? &*pinned : nullptr; }

  // Returns the point or triangle at a pixel of the canvas; nothing if there is none.
  std::optional<PickedElement> pick(int px, int py) const;
  // Returns the point of the range image, drawn in `rect`, that is under the pointer; nothing if there is none.
  std::optional<PickedElement> pickStrip(const PixelRect& rect) const;
  // Describes a point. `cloudIndex`: index of its cloud in ShownClouds::list.
  PickedElement pickedPoint(std::size_t cloudIndex, std::size_t point) const;
  // Returns `picked`; with several shown scans, adds the name of its scan and the other scans' points of the same beam.
  PickedElement withOtherScans(PickedElement picked) const;
  // True if the point or triangle is not hidden and its scan is shown.
  bool isShown(const PickedElement& picked) const;
  // Sets `hover` to the point or triangle under the pointer. `isOverPanel`: the pointer is over a panel. `strip`:
  // rectangle of the range image if the pointer is over this image.
  void updateHover(bool isOverPanel, const std::optional<PixelRect>& strip);
  Rgb colorOf(const PickedElement& picked) const;
  // Returns the instance id; nothing if the point or triangle belongs to no instance.
  std::optional<std::uint32_t> instanceOf(const PickedElement& picked) const;

  // Outlines the points of the instance under the pointer, otherwise those of the clicked instance.
  void highlightInstance();
  // Draws a line through the returns of the beam that is under the pointer or was clicked.
  void placeBeam();

  int x = -1, y = -1;  // pixel of the canvas; negative: the pointer is not on the canvas
  std::optional<PickedElement> hover;
  std::optional<PickedElement> pinned;  // the point or triangle that was clicked
  PointerDrag drag;
  bool measuring = false;
  std::vector<Vec3d> ends;  // ends of the measured distance (canvas frame)

 private:
  std::optional<std::size_t> viewAt(int px, int py) const;
  void click();
  const InstanceSummary& summaryOf(const ShownCloud& cloud, std::uint32_t instance) const;
  void setOutlinePoints(const ShownCloud& cloud);
  void placeOutline(const ShownCloud& cloud);

  SessionContext& context_;
  const ShownClouds& clouds_;
  SceneView& sceneView_;
  double lastMove_ = 0;  // time of the pointer's last move (s)
  mutable std::optional<std::pair<InstanceRef, InstanceSummary>> lastSummary_;
  std::optional<InstanceRef> highlighted_;  // the instance that is highlighted on the canvas; absent: there is none
  std::optional<ScanPoint> beamPoint_;      // the point whose beam is drawn
  bool beamDrawn_ = false;
};

}  // namespace scanmill
