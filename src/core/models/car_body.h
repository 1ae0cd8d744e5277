#pragma once

// The lofted body of a car, van, bus or cab.

#include <vector>

#include "models/models.h"

namespace scanmill::models {

// All lengths in metres, x measured from the middle of the vehicle, forward.
struct BodyForm {
  const char* className = "car";
  double length = 4.3, width = 1.78;
  double floor = 0.2;
  double belt = 0.92, beltRise = 0.02;  // height of the windows' lower edge in the middle; rise per metre to the rear
  double roofHalf = 0.56;               // half width of the roof
  double noseTaper = 0.13, tailTaper = 0.1;  // share of the width lost at the ends in plan
  double bulge = 0.09;                       // m, how far the bumpers bulge
  std::vector<Point2> profile;               // (x, z) of the upper edge, from the tail to the nose
  Span windscreen, rearWindow;               // along x; empty where there is none
  std::vector<Span> sideWindows;             // along x
  std::vector<double> axles;                 // along x
  double wheelRadius = 0.31, wheelWidth = 0.2;
  Span bed;                         // the bed of a pickup, which is covered
  bool mirrors = true;              // and door handles
  const char* paint = "car_paint";  // material
};

// Appends the body, its wheels, lights and plates.
void appendBody(Shape& shape, const BodyForm& form);

}  // namespace scanmill::models
