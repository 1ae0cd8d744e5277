#pragma once

// The viewer's options, and its commands with menus, keys and help.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "viewer/coloring.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {

enum class ViewLayout {
  One,      // one scan of the sample
  Overlay,  // all scans in one view, each in a fixed colour
  Split,    // views side by side with the same camera; they show different scans, or one scan in different colours
};

// The objects whose boxes are drawn. Road users are objects of the classes that the ontology marks
// with `road_user`, or all objects if it marks none.
enum class BoxChoice { RoadUsers, All, None };
constexpr std::array<std::string_view, 3> kBoxChoiceNames{"road_users", "all", "none"};

struct ViewOptions {
  // Quantities that the views' colours show, in the order of the views; the viewer chooses missing quantities.
  std::vector<ColorBy> colors{};
  std::optional<ScaleRange> scale{};  // ends of the scale of views that show numbers; absent: computed from the values
  ViewLayout layout = ViewLayout::One;
  // A named view is fitted to a scene without scans, and to scans if it would otherwise show hardly any of their
  // points. If a scene is shown without scans, a target that the user gives is in the scene's world frame.
  CameraChoice camera{};
  std::string sample{};  // key or index of the first frame; empty: the middle frame
  double pointSize = 0;  // side of a drawn point (pixels); 0: depends on the canvas's height
  Rgb background = kBackground;
  bool depthEdges = true;
  bool legends = true;
  bool mesh = false;  // draws the scene's mesh, translucent
  bool axes = true;   // draws the axes of the sensors
  bool rangeRings = false;
  BoxChoice boxes = BoxChoice::RoadUsers;  // the objects in the samples' lists whose boxes are drawn
  bool trajectory = true;
  bool rangeImage = false;
  bool still = false;                 // true: draws a picture, without buttons, menus and fields
  bool bare = false;                  // true: draws no panels
  std::vector<std::string> hidden{};  // names or ids of the hidden classes; if `only` is true, of the shown classes
  bool only = false;
  std::vector<std::uint32_t> instances{};  // ids of the only instances that are shown; empty: all are shown
  std::optional<CloseUp> closeUp{};        // only points in this ball are shown, and the camera looks at it
};

class ViewSession;

// A command of menus and keys. If `menu` is empty, the command is in no menu and has only keys.
struct ViewCommand {
  std::string_view menu;
  std::string label;
  std::vector<std::string> keys;  // typed characters, such as "c", or names of keys, such as "Left"
  std::function<void(ViewSession&)> run;
  // Why the command does nothing for a scene without scans, which has only triangles; empty: the command works.
  std::string whyNotInScene{};
  // True if what the command switches is on; the menu then shows a check mark. Empty: the menu shows none.
  std::function<bool(const ViewSession&)> isOn{};
};

// Returns the command's keys as text for menus and help, such as "space" or "h or ?".
std::string keysText(const ViewCommand& command);

// Returns pairs of keys or gestures and their functions, for the help and the documentation.
std::vector<std::pair<std::string, std::string>> viewKeys();

}  // namespace scanmill
