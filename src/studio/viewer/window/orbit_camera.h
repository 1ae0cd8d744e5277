#pragma once

// The camera that the user turns about a target.

#include <optional>
#include <string>

#include "base/vec.h"
#include "viewer/view_camera.h"

namespace scanmill {

// Metres and radians in the canvas's frame: x forward, y left, z up.
struct OrbitCamera {
  Vec3d target{};
  double yaw = 0;        // direction of the line of sight: 0 looks along x, counter-clockwise seen from above
  double pitch = 0;      // positive looks down, -pi/2 to pi/2
  double distance = 30;  // from the eye to the target
  double focal = 1.15;   // focal length over the height of a view of 16 : 9; an orthographic camera shows as
                         // much as a pinhole does at `distance`
  bool orthographic = false;

  // Returns the camera for a view of this size (px).
  ViewCamera camera(int width, int height) const;
  Vec3d eye() const;
  // Turns about the target by a drag of the pointer (px). The pitch stops at straight up and straight down.
  void orbit(double right, double down, int height);
  // Moves the target in the image plane by a drag of the pointer (px), so that the picture follows the pointer.
  void pan(double right, double down, int width, int height);
  // Moves towards the target, a tenth of the distance per step; the distance stays between 0.1 m and 10 km.
  void zoom(double steps);
  // Makes `place` the target. A pinhole camera turns and keeps its eye; an orthographic camera moves.
  void lookAt(const Vec3d& place);
  // Moves so that the whole box is seen, without turning.
  void frame(const Box& box);
  // Transforms the camera to a new frame, so that the view stays the same; only rotation about z is applied.
  void moveBy(const Affine& newFromOld);
  // Returns "yaw,pitch,distance,x,y,z" in degrees and metres (x, y and z to the millimetre), followed by ",focal" and
  // ",ortho" if they differ from the default; parseCamera() reads this text.
  std::string text() const;
  bool operator==(const OrbitCamera&) const = default;
};

// Returns the camera that shows the same picture as makeCamera() does; the target of Driver is a place ahead.
OrbitCamera presetCamera(View view);

// The user's choice of a camera.
struct CameraChoice {
  OrbitCamera camera = presetCamera(View::Chase);
  std::optional<View> view = View::Chase;  // present if the camera was chosen by the name of a view
  bool placed = false;                     // the target was given; else the viewer chooses it
};

// Parses "chase", "driver", "above", or YAW,PITCH,DISTANCE[,X,Y,Z[,FOCAL]][,ortho] in degrees and metres. Throws
// InputError that explains this form.
CameraChoice parseCamera(const std::string& text);

}  // namespace scanmill
