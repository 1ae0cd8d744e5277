#pragma once

// The scans of the frame as points on the canvas: which view shows which scan, in which colours, and which of its
// points; and the range image of one of them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "viewer/coloring.h"
#include "viewer/range_strip.h"
#include "viewer/window/session_context.h"

namespace scanmill {

constexpr std::size_t kMostSplitViews = 4;

// A scan of the frame as an item of the canvas, in one of the views.
struct ShownCloud {
  std::size_t scan = 0;  // index in the frame
  std::size_t view = 0;
  Affine canvasFromScan{};
  Coloring coloring{};
  std::vector<std::uint8_t> shown{};  // per point; empty: all
  std::uint64_t finite = 0;           // number of finite points
  std::uint64_t visible = 0;          // number of finite points that are shown
};

struct Clouds {
  explicit Clouds(SessionContext& context);

  // Makes the items of the frame's scans for the current layout, and drops all others.
  void arrange();
  // Shows the points that the filter lets through.
  void applyFilter();
  void makeStrip();

  bool overlaid() const {
    return context_.options.layout == ViewLayout::Overlay && context_.frame && context_.frame->scans.size() > 1;
  }
  std::size_t viewCount() const;
  std::size_t shownScan() const;  // index of the scan in layout One
  ColorBy colorOf(std::size_t view) const;
  bool hasColor(const ViewScan& scan, const ColorBy& by) const;
  const ShownCloud* inView(std::size_t view) const;  // the first cloud in the view; null: none
  bool isHidden(
      const ShownCloud& cloud) const;  // true if the cloud's scan is hidden among scans that lie over one another

  void chooseColor(const ColorBy& by);
  void cycleColor(int step);
  void changeScale(KeyAction change);
  // Colours the points of a view anew.
  void recolor(std::size_t view);

  std::vector<ShownCloud> list;
  std::array<std::optional<ColorBy>, kMostSplitViews> colors{};
  std::array<std::optional<ScaleRange>, kMostSplitViews> scales{};  // chosen ones; absent: follow from the values
  std::optional<std::size_t> activeView;                            // the view whose colours change; none: all
  std::string scanName;                                             // the scan shown in layout One; empty: the first
  std::set<std::uint16_t> presentClasses;                           // classes known to occur in a frame
  std::string colorProblem, instanceProblem, stripProblem;
  std::optional<std::string> columnMissing;  // message about a column in the options' colours
  std::optional<RangeStrip> strip;
  std::size_t stripCloud = 0;  // the index in `list` of the cloud that the range image shows

 private:
  Coloring colored(std::size_t scan, std::size_t view);
  std::optional<ScaleRange> scaleOf(std::size_t view);
  ColorContext contextOf(const ViewScan& scan) const;
  std::vector<std::size_t> actedViews() const;

  SessionContext& context_;
  std::map<ColorBy, ScaleRange> commonScales_;  // shared by the frame's scans side by side
  bool classesKnown_ = false;                   // presentClasses covers all frames
};

}  // namespace scanmill
