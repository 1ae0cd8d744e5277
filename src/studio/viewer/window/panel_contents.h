#pragma once

// Computes positions and contents of the panels and labels on the views. The session draws them and executes clicks.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "viewer/panels/panel_rects.h"
#include "viewer/panels/widgets.h"
#include "viewer/window/playback.h"
#include "viewer/window/pointer.h"

namespace scanmill {

// One of the views that are shown side by side.
struct ViewPane {
  std::string caption;  // name of the view's scan, such as "top, ray_tracing"; drawn if there are several views
  Legend legend;
  bool active = false;  // true: keys change only this view
  std::string message;  // the reason why the view shows nothing; empty if it shows something
};

// A legend, and the views that share it.
struct LegendBlock {
  Legend legend;
  std::vector<std::size_t> views;
};

struct PanelContents {
  PanelContents(const SessionContext& context, const Playback& playback, const ShownClouds& clouds,
                const SceneView& sceneView, const Pointer& pointer);

  // Computes the contents of the panes and legends, then the rectangles of all panels, which depend on the contents.
  void arrange();
  // Returns the views in the rectangle that the panels leave free.
  std::vector<CanvasView> views() const;
  void addLabels();
  std::string title() const;
  std::string summary() const;  // returns the number of shown points or triangles, and what the filter shows
  PixelRect stripRect() const;  // returns the rectangle of the range image
  bool isHidden(const LegendEntry& entry) const;

  ImGuiLayer imgui;
  PanelRects rects;
  std::vector<ViewPane> panes;
  std::vector<LegendBlock> legends;
  std::vector<PanelLabel> labels;
  bool overStrip = false;             // true: the pointer is over the range image
  std::optional<std::string> prompt;  // the name of a frame as typed so far; absent: the user is not asked for a frame
  bool help = false;                  // true: the list of keys is shown

 private:
  void fillPanes();
  void addLabel(const Vec3d& position, const PanelLabel& label);
  void addSensorLabels();
  void completeClasses(Legend& legend) const;
  void collectLegends();
  void countActiveView(LegendBlock& block);
  void addMessages();

  const SessionContext& context_;
  const Playback& playback_;
  const ShownClouds& clouds_;
  const SceneView& sceneView_;
  const Pointer& pointer_;
};

}  // namespace scanmill
