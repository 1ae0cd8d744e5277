#pragma once

// The ids of the viewer's items and images on its canvas.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "viewer/canvas/canvas.h"
#include "viewer/image.h"

namespace scanmill {

constexpr ItemId kMeshItem = 1;
constexpr ItemId kAxesItem = 2;
constexpr ItemId kRangeRingsItem = 3;
constexpr ItemId kTrackItem = 4;
constexpr ItemId kMeasureItem = 5;
constexpr ItemId kBoxesItem = 6;
constexpr ItemId kBeamItem = 7;
constexpr ItemId kVehicleItem = 8;
constexpr ItemId cloudItem(std::size_t cloud) {
  return static_cast<ItemId>(100 + cloud);
}
constexpr ImageId kStripImage = 2;
constexpr ItemId kHighlightItem = 1'000'000;  // outline of the instance that is under the pointer or was clicked

// A canvas item, which may not exist yet. The canvas refuses to change a missing item; here, changes do nothing until
// setPoints() or setTriangles() has created the item.
class CanvasItem {
 public:
  CanvasItem(Canvas& canvas, ItemId id) : canvas_(canvas), id_(id) {}

  bool exists() const { return exists_; }
  void setPoints(std::span<const Vec3f> positions, std::span<const Rgb> colors) {
    canvas_.setPoints(id_, positions, colors);
    exists_ = true;
  }
  void setTriangles(std::span<const Vec3f> corners, std::span<const Rgb> colors) {
    canvas_.setTriangles(id_, corners, colors);
    exists_ = true;
  }
  void setColors(std::span<const Rgb> colors) {
    if (exists_) canvas_.setColors(id_, colors);
  }
  void setLook(const ItemLook& look) {
    if (exists_) canvas_.setLook(id_, look);
  }
  void showAll() {
    if (exists_) canvas_.showAll(id_);
  }
  void showOnly(std::span<const std::uint32_t> indices) {
    if (exists_) canvas_.showOnly(id_, indices);
  }
  void drop() {
    canvas_.drop(id_);
    exists_ = false;
  }

 private:
  Canvas& canvas_;
  ItemId id_;
  bool exists_ = false;
};

// Line segments: two ends (m) and one colour per segment.
struct LineSet {
  std::vector<Vec3f> ends;
  std::vector<Rgb> colors;

  void add(const Vec3d& from, const Vec3d& to, const Rgb& color);
};

constexpr std::array<double, 4> kRingRadii{10, 20, 50, 100};  // radii of the range rings (m)

// Adds the axes of a frame, each `length` m long: x red, y green, z blue.
void addAxes(LineSet& lines, const Affine& pose, double length);
// Adds horizontal circles with the radii kRingRadii.
void addRangeRings(LineSet& lines, const Vec3d& center, const Rgb& color);
// Adds lines from place to place, darker before the place `places[current]`, and a small circle around that place.
void addTrack(LineSet& lines, std::span<const Vec3d> places, std::size_t current, const Rgb& color);

// Adds the edges of a box and, if `front` is true, a line that sticks out of its front. `pose`: pose of its centre.
void addBox(LineSet& lines, const Affine& pose, const Vec3d& size, bool front, const Rgb& color);

// Returns the height (m) of the ground around a sensor: the 5th percentile of z over the finite points, transformed by
// `pose`; 0 if no point is finite.
double groundHeight(std::span<const Vec3f> points, const Affine& pose);

}  // namespace scanmill
