#pragma once

// The ids of the viewer's items and images on its canvas, and functions that make lines for the canvas.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "base/vec.h"
#include "viewer/canvas/canvas.h"

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

// Line segments: two ends (m) and one colour per segment.
struct LineSet {
  std::vector<Vec3f> ends;
  std::vector<Rgb> colors;

  void add(const Vec3d& from, const Vec3d& to, const Rgb& color) {
    ends.insert(ends.end(), {Vec3f(from), Vec3f(to)});
    colors.push_back(color);
  }
};

constexpr std::array<double, 4> kRingRadii{10, 20, 50, 100};  // radii of the range rings (m)

// Adds the axes of a frame, each `length` m long: x red, y green, z blue.
void addAxes(LineSet& lines, const Affine& pose, double length);
// Adds horizontal circles with the radii kRingRadii.
void addRangeRings(LineSet& lines, const Vec3d& center, const Rgb& color);
// Adds lines from position to position, darker up to `positions[current]`, and a small circle around this position.
void addTrack(LineSet& lines, std::span<const Vec3d> positions, std::size_t current, const Rgb& color);

// Adds the edges of a box. `pose`: pose of its centre. `size`: lengths along x, y and z (m).
void addBox(LineSet& lines, const Affine& pose, const Vec3d& size, const Rgb& color);

// Returns the height (m) of the ground around a sensor: the 5th percentile of z over the finite points, transformed by
// `pose`; 0 if no point is finite.
double groundHeight(std::span<const Vec3f> points, const Affine& pose);

}  // namespace scanmill
