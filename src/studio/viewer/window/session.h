#pragma once

// The viewer: its content, and its response to keys and the pointer. It draws on a canvas and knows no window system,
// so the same code serves windows and pictures, and tests can press its keys without a display.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/canvas/canvas.h"
#include "viewer/coloring.h"
#include "viewer/frames/frame_loader.h"
#include "viewer/frames/frame_source.h"
#include "viewer/range_strip.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {

enum class ViewLayout {
  One,      // one scan of the sample
  Overlay,  // all scans in one view, in fixed colours
  Split,    // views side by side with one camera: each shows another scan, or the same scan in other colours
};

struct ViewOptions {
  std::vector<ColorBy> colors{};      // colours of the views; if one is missing, colorScan() chooses
  std::optional<ScaleRange> scale{};  // scale of the views that show numbers; absent: follows from the values
  ViewLayout layout = ViewLayout::One;
  CameraChoice camera{};  // for a scene without scans: a named view frames the scene, a target is in its coordinates
  std::string sample{};   // key or index; empty: the middle one, or the first that can be read
  double pointSize = 0;   // px; 0: chosen for the canvas
  Rgb background{13, 15, 20};
  bool depthEdges = true;
  bool legends = true;
  bool mesh = false;  // the scene's mesh, translucent
  bool axes = true;   // axes of the sensors
  bool rangeRings = false;
  bool boxes = true;  // boxes of the objects that samples list
  bool trajectory = true;
  bool rangeImage = false;
  bool still = false;                 // for pictures: no buttons, menus or fields
  bool bare = false;                  // no panels: the points alone
  std::vector<std::string> hidden{};  // hidden classes by name or id; with `only`, all others are hidden
  bool only = false;
  std::vector<std::uint32_t> instances{};  // only these instances are shown; empty: all
  std::optional<CloseUp> closeUp{};        // only points in this ball are shown, and the camera looks at it
};

constexpr std::size_t kNoScan = SIZE_MAX;

// A point, or a triangle of a scene, under the pointer or clicked: its names, values and units for the user.
struct PickedThing {
  std::string heading;  // "car 4711"
  std::vector<std::pair<std::string, std::string>> rows;
  std::vector<std::pair<std::string, std::string>> brief;  // rows that are shown while the pointer is over it
  std::string alarm;                                       // name of the row that is a warning; empty: none
  std::size_t scan = 0;                                    // index in the frame; kNoScan: a triangle
  std::size_t point = 0;                                   // index of the point in the scan or the triangle in the mesh
  Vec3d place;                                             // m, canvas's frame
};

class ViewSession {
 public:
  // Throws InputError if an option names a sample, a class or a column that does not exist.
  ViewSession(const std::shared_ptr<const FrameSource>& source, Canvas& canvas, const ViewOptions& options);
  // Takes over a loader that was started before the canvas existed. Throws as above.
  ViewSession(std::shared_ptr<const FrameSource> source, std::unique_ptr<FrameLoader> loader, Canvas& canvas,
              const ViewOptions& options);
  ~ViewSession();
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  // Handles an event. False if the session is to be closed.
  bool handle(const CanvasEvent& event);
  // Waits until everything is loaded, and draws it with all points.
  void settle();
  // After settle(): throws InputError if the scans lack a column that the options name, Error if nothing of the frame
  // could be loaded.
  void check() const;
  // Returns the picture that settle() has drawn.
  Image picture();

  const OrbitCamera& camera() const;
  void setCamera(const OrbitCamera& camera);
  // Returns the point or the triangle at a pixel of the canvas.
  std::optional<PickedThing> pick(int x, int y) const;
  // Selects a point or a triangle as a click does.
  void pin(const PickedThing& thing);
  // Returns what could not be loaded or coloured in the frame that is shown.
  std::vector<std::string> problems() const;
  // Returns hints for the user, each of which is shown once.
  const std::vector<std::string>& hints() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Returns the keys and what they do, as the help and the documentation list them.
std::vector<std::pair<std::string, std::string>> viewKeys();

}  // namespace scanmill
