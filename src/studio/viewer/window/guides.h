#pragma once

// Lines that help to find one's way: axes, rings of equal distance, the way that the sensor goes.

#include <array>
#include <span>
#include <vector>

#include "base/vec.h"
#include "viewer/image.h"

namespace scanmill {

// Two ends and a colour per segment; metres.
struct LineSet {
  std::vector<Vec3f> ends;
  std::vector<Rgb> colors;

  void add(const Vec3d& from, const Vec3d& to, const Rgb& color);
};

constexpr std::array<double, 4> kRingRadii{10, 20, 50, 100};  // m

// x red, y green, z blue.
void addAxes(LineSet& lines, const Affine& pose, double length);
// Level circles in kRingRadii.
void addRangeRings(LineSet& lines, const Vec3d& center, const Rgb& color);
// Through the places, what lies behind place `current` darker; a small circle about that.
void addTrack(LineSet& lines, std::span<const Vec3d> places, std::size_t current, const Rgb& color);

// The edges of a box, whose frame has its origin in the box's middle, and a line that stands out of its front.
void addBox(LineSet& lines, const Affine& pose, const Vec3d& size, bool front, const Rgb& color);

// Height of the ground about a sensor: the 5th percentile of the finite points' z after `pose` (m); 0 without any.
double groundHeight(std::span<const Vec3f> points, const Affine& pose);

}  // namespace scanmill
