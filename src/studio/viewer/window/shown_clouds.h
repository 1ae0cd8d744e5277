#pragma once

// Shows the scans of the frame as points on the canvas: chooses the scan of each view, its colours and its visible
// points. Also draws the range image of one of the scans.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "viewer/range_strip.h"
#include "viewer/window/session_context.h"

namespace scanmill {

// A scan of the frame as an item of the canvas, in one of the views.
struct ShownCloud {
  std::size_t scan = 0;  // index in the frame
  std::size_t view = 0;
  Affine canvasFromScan{};
  Coloring coloring{};
  std::vector<std::uint8_t> shown{};  // for each point, 1 if it is shown; empty: all are shown
  std::uint64_t finite = 0;           // number of finite points
  std::uint64_t visible = 0;          // number of finite points that are shown
};

struct ShownClouds {
  explicit ShownClouds(SessionContext& context);

  // Creates the canvas items of the frame's scans for the current layout, and removes the items of other scans.
  void arrange();
  // Shows only the points that the filter does not hide.
  void applyFilter();
  // Draws the range image of one of the shown scans, if the options require one, and uploads it.
  void makeStrip();

  // True if all scans of the frame are in one view, each in a fixed colour.
  bool overlaid() const { return context_.options.layout == ViewLayout::Overlay && context_.scanCount() > 1; }
  std::size_t viewCount() const;
  std::size_t shownScan() const;  // returns the index of the scan that the layout One shows
  ColorBy colorOf(std::size_t view) const;
  bool hasColor(const ViewScan& scan, const ColorBy& by) const;
  const ShownCloud* inView(std::size_t view) const;  // returns the first cloud in the view; null if there is none
  const ViewScan& scanOf(const ShownCloud& cloud) const { return context_.frame->scans[cloud.scan]; }
  // True if the user has hidden the cloud's scan in the overlay of all scans.
  bool isHidden(const ShownCloud& cloud) const {
    return overlaid() && context_.filter.hiddenScans.contains(scanOf(cloud).name);
  }

  // chooseColor() colours by the quantity `by`; cycleColor() by the next (`step` 1) or previous (-1) quantity that the
  // scans have. Both change the active view or, if no view is active, all views. If a scan lacks `by`, chooseColor()
  // changes no colours and sets `colorProblem`.
  void chooseColor(const ColorBy& by);
  void cycleColor(int step);
  // Resets the scale of the active view, or of all views; the ends are then computed from the values again.
  void resetScales();
  // Computes the colours of a view's points again.
  void recolor(std::size_t view);

  std::vector<ShownCloud> list;
  std::array<std::optional<ColorBy>, kCanvasViews> colors{};
  // For each view, the ends of the scale that the user has chosen; absent: computed from the values.
  std::array<std::optional<ScaleRange>, kCanvasViews> scales{};
  std::optional<std::size_t> activeView;   // the view to which the user's changes of colours apply; absent: all views
  std::string scanName;                    // name of the scan that the layout One shows; empty: the first scan
  std::set<std::uint16_t> presentClasses;  // ids of classes that are known to occur in at least one frame
  std::string colorProblem, instanceProblem, stripProblem;
  std::optional<std::string> columnMissing;  // message about a column that the options name, but a scan lacks
  std::optional<RangeStrip> strip;
  std::size_t stripCloud = 0;  // index in `list` of the cloud that the range image shows

 private:
  Coloring colored(const ShownCloud& cloud);
  std::optional<std::vector<std::uint32_t>> filtered(ShownCloud& cloud) const;
  std::optional<ScaleRange> scaleOf(std::size_t view);
  ColorContext contextOf(const ViewScan& scan) const;
  bool isAffected(std::size_t view) const { return !activeView || *activeView == view; }

  SessionContext& context_;
  std::map<ColorBy, ScaleRange> commonScales_;  // ends of scales that scans side by side share
  bool classesKnown_ = false;                   // true: presentClasses contains the classes of all frames
};

}  // namespace scanmill
