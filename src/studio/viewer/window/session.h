#pragma once

// The viewer: what is shown, and what keys and pointers do. It draws on a canvas and knows no toolkit, so the same code
// makes windows and pictures, and tests press its keys without a display.

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
  Split,    // views side by side, each with a scan of its own, or with the same scan in other colours; linked cameras
};

struct ViewOptions {
  std::vector<ColorBy> colors{};      // of the views; absent: what colorScan() takes
  std::optional<ScaleRange> scale{};  // of the views whose colours are numbers; absent: follows from the values
  ViewLayout layout = ViewLayout::One;
  CameraChoice camera{};  // of a scene by itself a view by its name is framed, and a target is in its coordinates
  std::string sample{};   // key or index; empty: the middle one, or the first that can be read
  double pointSize = 0;   // px; 0: what suits the canvas
  Rgb background{13, 15, 20};
  bool depthEdges = true;
  bool legends = true;
  bool mesh = false;  // of the scene, faintly
  bool axes = true;   // of the sensors
  bool rangeRings = false;
  bool boxes = true;  // of the objects that samples list
  bool trajectory = true;
  bool rangeImage = false;
  StripOrder stripOrder = StripOrder::Outward;  // of the range image
  bool still = false;                           // for pictures: nothing that is there to be pressed
  bool bare = false;                            // no panels: the points alone
  std::vector<std::string> hidden{};            // classes by name or id; or, with `only`, all others
  bool only = false;
  std::vector<std::uint32_t> instances{};  // that alone are shown; empty: all
};

constexpr std::size_t kNoScan = SIZE_MAX;

// A point, or a triangle of a scene, that was pointed at: names, values and units, for people.
struct PickedThing {
  std::string heading;  // "car 4711"
  std::vector<std::pair<std::string, std::string>> rows;
  std::vector<std::pair<std::string, std::string>> brief;  // what is told while it is only pointed at
  std::string alarm;                                       // name of a row that warns; empty: none does
  std::size_t scan = 0;                                    // of the frame; kNoScan: a triangle
  std::size_t point = 0;                                   // of the scan, or triangle of the mesh
  Vec3d place;                                             // m, canvas's frame
};

class ViewSession {
 public:
  // Throws InputError where an option names what there is not (a sample, a class, a column of no scan).
  ViewSession(const std::shared_ptr<const FrameSource>& source, Canvas& canvas, const ViewOptions& options);
  // The same, by a loader that has begun before there was a canvas.
  ViewSession(std::shared_ptr<const FrameSource> source, std::unique_ptr<FrameLoader> loader, Canvas& canvas,
              const ViewOptions& options);
  ~ViewSession();
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  // False: it wants to be closed.
  bool handle(const CanvasEvent& event);
  // Waits for all that is being loaded, and draws it whole.
  void settle();
  // After settle(): throws InputError where the scans lack a column that the options name, Error where nothing of the
  // frame could be loaded.
  void check() const;
  // What settle() has drawn.
  Image picture();

  const OrbitCamera& camera() const;
  void setCamera(const OrbitCamera& camera);
  // What lies at a pixel of the canvas.
  std::optional<PickedThing> pick(int x, int y) const;
  // As a click does.
  void pin(const PickedThing& thing);
  // Of the frame that is shown: what could not be loaded or coloured.
  std::vector<std::string> problems() const;
  // What is good to know, said once.
  const std::vector<std::string>& hints() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The keys and what they do, as the help shows them and the documentation lists them.
std::vector<std::pair<std::string, std::string>> viewKeys();

}  // namespace scanmill
