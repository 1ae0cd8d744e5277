#pragma once

// A camera that the user rotates around a target.

#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "viewer/view_camera.h"

namespace scanmill {

// Fraction of a scan's points that a named view should show. View::Chase shows more of a car's scan (0.4 and more), and
// less of a drone's whose beams go all around (0.2).
constexpr double kLeastSeen = 0.3;

// Positions are in the canvas frame (m): x forward, y left, z up. Angles are in radians.
struct OrbitCamera {
  Vec3d target{};
  double yaw = 0;        // heading of the line of sight, counter-clockwise; at 0 the camera looks along x
  double pitch = 0;      // angle by which the camera looks down, from -pi/2 to pi/2
  double distance = 30;  // distance from the eye to the target
  // Focal length divided by the height of a 16 : 9 picture. An orthographic camera shows the same part of the target
  // plane as a pinhole camera would.
  double focal = 1.15;
  bool orthographic = false;

  // Returns the camera for a view of this size (pixels).
  ViewCamera camera(int width, int height) const;
  Vec3d eye() const;
  // Rotates around the target for a drag by `right` and `down` pixels in a view of `height` pixels; stops at vertical.
  void orbit(double right, double down, int height);
  // Moves camera and target parallel to the image plane for a drag by these pixels; the picture follows the pointer.
  void pan(double right, double down, int width, int height);
  // Moves towards the target by a tenth of the distance per step; the distance stays between 0.1 m and 10 km.
  void zoom(double steps);
  // Makes `position` the target. A pinhole camera keeps its position and turns; an orthographic camera only moves.
  void lookAt(const Vec3d& position);
  // Moves the camera, without turning it, so that the points are centred and nearly fill a picture of this size
  // (pixels). The camera of View::Chase also looks down more steeply, up to 45 degrees, until the points fill the
  // picture's height. The target gets the depth of the point `middle`.
  void fillWith(const std::vector<Vec3d>& points, const Vec3d& middle, View view, int width, int height);
  // Returns this camera or, if a picture of this size would show less than the fraction `least` of the points, a moved
  // camera that shows nearly all of them. This camera must be that of `view`; the camera of View::Driver is never
  // moved.
  [[nodiscard]] OrbitCamera seeing(const std::vector<Vec3d>& points, View view, int width, int height,
                                   double least = kLeastSeen) const;
  // Transforms the camera to a new frame, so that the view stays the same. `newFromOld` may rotate only about z.
  void moveBy(const Affine& newFromOld);
  // Returns "yaw,pitch,distance,x,y,z" in degrees and metres (x, y and z to the millimetre), followed by ",focal" and
  // ",ortho" if they differ from the default; parseCamera() reads this text.
  std::string text() const;
  bool operator==(const OrbitCamera&) const = default;
};

// Returns the camera of a named view. The target of View::Driver is 10 m ahead.
OrbitCamera presetCamera(View view);

// The user's choice of a camera.
struct CameraChoice {
  OrbitCamera camera = presetCamera(View::Chase);
  std::optional<View> view = View::Chase;  // the view if the camera was chosen by a view's name; otherwise absent
  bool placed = false;                     // true: the user has given the target; false: the viewer chooses it
};

// Parses "chase", "driver", "above", or YAW,PITCH,DISTANCE[,X,Y,Z[,FOCAL]][,ortho] in degrees and metres. Throws
// InputError, with an explanation of this form, for other texts.
CameraChoice parseCamera(const std::string& text);

}  // namespace scanmill
