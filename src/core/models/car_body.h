#pragma once

// The lofted body of a car, van, bus or cab.

#include <vector>

#include "models/models.h"

namespace scanmill::models {

// All lengths are in metres; x is measured forward from the middle of the vehicle.
struct BodyForm {
  const char* className = "car";
  double length = 4.3, width = 1.78;
  double floor = 0.2;
  double belt = 0.92, beltRise = 0.02;       // lower edge of the windows at x = 0; its rise per metre to the rear
  double roofHalf = 0.56;                    // half of the roof's width
  double noseTaper = 0.13, tailTaper = 0.1;  // fraction of the width lost at the nose and at the tail
  double bulge = 0.09;                       // how far the bumpers protrude
  std::vector<Point2> profile;               // (x, z) of the upper edge, from the tail to the nose
  Span windscreen, rearWindow;               // extents along x; empty: no such window
  std::vector<Span> sideWindows;             // extents along x
  std::vector<double> axles;                 // positions along x
  double wheelRadius = 0.31, wheelWidth = 0.2;
  Span bed;                         // extent along x of a pickup's covered bed
  bool mirrors = true;              // true: the body has mirrors and door handles
  const char* paint = "car_paint";  // material of the body
};

// Appends the body, its wheels, lights and plates.
void appendBody(Shape& shape, const BodyForm& form);

}  // namespace scanmill::models
