#pragma once

// The panels and labels over the views: where they are, and what stands in them. The session draws them and executes
// what the user clicks there.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "viewer/panels/parts.h"
#include "viewer/panels/rooms.h"
#include "viewer/panels/toolkit.h"
#include "viewer/window/clouds.h"
#include "viewer/window/playback.h"
#include "viewer/window/pointer.h"
#include "viewer/window/scenery.h"
#include "viewer/window/session_context.h"

namespace scanmill {

// One of the views side by side.
struct ViewPane {
  std::string caption;  // name of its scan: "top, ray_tracing"; drawn if there are several views
  Legend legend;
  bool active = false;  // keys act on this view
  std::string message;  // why the view shows nothing
};

// A legend, and the views that share it.
struct LegendBlock {
  Legend legend;
  std::vector<std::size_t> views;
};

struct Panels {
  Panels(const SessionContext& context, const Playback& playback, const Clouds& clouds, const Scenery& scenery,
         const Pointer& pointer);

  // Fills the panes and the legends, and then finds the rectangles of all panels, which depend on these.
  void arrange();
  // Returns the views in the rectangle that the panels leave free.
  std::vector<CanvasView> views() const;
  void addLabels();
  std::string title() const;
  std::string summary() const;
  PixelRect stripRect() const;  // px: rectangle of the range image
  bool isHidden(const LegendEntry& entry) const;

  Toolkit toolkit;
  PanelRooms rooms;
  std::vector<ViewPane> panes;
  std::vector<LegendBlock> legends;
  std::vector<PanelLabel> labels;
  bool overStrip = false;             // the pointer is over the range image
  std::optional<std::string> prompt;  // the text typed so far that names a frame; none: nothing is asked
  bool help = false;                  // the list of keys is shown

 private:
  // panels.cpp
  void fillPanes();
  void addLabel(const Vec3d& spot, const std::string& text, bool mark);
  // panels_legends.cpp
  void completeClasses(Legend& legend) const;
  void collectLegends();
  void addMessages();

  const SessionContext& context_;
  const Playback& playback_;
  const Clouds& clouds_;
  const Scenery& scenery_;
  const Pointer& pointer_;
};

}  // namespace scanmill
