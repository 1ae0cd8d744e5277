#pragma once

// The camera that a person turns about a place.

#include <optional>
#include <string>

#include "base/vec.h"
#include "viewer/view_camera.h"

namespace scanmill {

// Metres and radians in the canvas's frame: x forward, y left, z up.
struct OrbitCamera {
  Vec3d target;
  double yaw = 0;        // of the line of sight: 0 looks along x, counter-clockwise seen from above
  double pitch = 0;      // positive looks down, -pi/2 to pi/2
  double distance = 30;  // from the eye to the target
  double focal = 1.15;   // of a pinhole, in units of the height of a view of 16 : 9; likewise how much an
                         // orthographic camera shows at that distance
  bool orthographic = false;

  // For a view of so many pixels.
  ViewCamera camera(int width, int height) const;
  Vec3d eye() const;
  // Turns about the target: pixels of a drag. The pitch stops at straight up and straight down.
  void orbit(double right, double down, int height);
  // Moves the target in the image plane, so that it follows the pointer.
  void pan(double right, double down, int width, int height);
  // Towards the target, a tenth of the way per step; the distance stays between 0.1 m and 10 km.
  void zoom(double steps);
  // Turns to a place and about it from now on; the eye stays, unless the camera is orthographic: that one moves.
  void lookAt(const Vec3d& place);
  // Shows a box whole, in the direction that it looks.
  void frame(const Box& box);
  // The same view in a frame that is turned and moved; of a turn only that about z counts.
  void moveBy(const Affine& newFromOld);
  // "yaw,pitch,distance,x,y,z" in degrees and metres (of places the millimetres), and ",focal" and ",ortho" where they
  // are not as usual: what parseCamera() reads again.
  std::string text() const;
  bool operator==(const OrbitCamera&) const = default;
};

// The cameras of makeCamera(), for the same picture; Driver turns about a place ahead.
OrbitCamera presetCamera(View view);

// What a person asks for.
struct CameraChoice {
  OrbitCamera camera = presetCamera(View::Chase);
  std::optional<View> view = View::Chase;  // by its name
  bool placed = false;                     // the target was given; else it is whatever is in the middle
};

// "chase", "driver", "above", or YAW,PITCH,DISTANCE[,X,Y,Z[,FOCAL]][,ortho] in degrees and metres. Throws InputError
// that says so.
CameraChoice parseCamera(const std::string& text);

}  // namespace scanmill
