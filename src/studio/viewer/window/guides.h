#pragma once

// Lines for orientation: axes, range rings, the sensor's trajectory, boxes.

#include <array>
#include <span>
#include <vector>

#include "base/vec.h"
#include "viewer/image.h"

namespace scanmill {

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
