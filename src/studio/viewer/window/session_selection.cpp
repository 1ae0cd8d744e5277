// Selects points by a box or a lasso, counts them by class, and saves them to files.

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/file.h"
#include "base/grouped.h"
#include "formats/format.h"
#include "viewer/window/free_file.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

// True if (x, y) is in the outline: a line from it to the right crosses the outline an odd number of times.
bool isWithin(const std::vector<Vec2d>& outline, double x, double y) {
  bool within = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2d& a = outline[i];
    const Vec2d& b = outline[(i + 1) % outline.size()];
    if ((a.y > y) != (b.y > y) && x < a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x)) within = !within;
  }
  return within;
}

Scan partOf(const Scan& scan, const std::vector<std::uint32_t>& points) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  Scan part = scan;
  std::fill(part.position.begin(), part.position.end(), Vec3f{kNaN, kNaN, kNaN});
  for (const std::uint32_t i : points) part.position[i] = scan.position[i];
  return withoutMisses(part);
}

}  // namespace

void ViewSession::State::startSelecting(Selecting how) {
  clearSelection();
  if (clouds.empty()) return say("there are no points to select");
  selecting = how;
  say(how == Selecting::Box ? "drag a box about the points" : "drag a line around the points");
}

void ViewSession::State::clearSelection() {
  selecting = Selecting::None;
  outline.clear();
  selected.clear();
  itemsChanged = hudChanged = true;
}

void ViewSession::State::addToOutline(int x, int y) {
  constexpr double kApart = 3;  // px, least distance of a lasso's corners
  const Vec2d corner{static_cast<double>(x), static_cast<double>(y)};
  if (selecting == Selecting::Box) {
    const Vec2d from{static_cast<double>(drag.downX), static_cast<double>(drag.downY)};
    outline = {from, {corner.x, from.y}, corner, {from.x, corner.y}};
  } else if (outline.empty() || std::hypot(corner.x - outline.back().x, corner.y - outline.back().y) >= kApart) {
    outline.push_back(corner);
  }
  hudChanged = true;
}

// Selects the points in the outline that are shown in the view where the outline began.
void ViewSession::State::select() {
  const std::vector<Vec2d> around = std::move(outline);
  const auto view = viewAt(static_cast<int>(around.front().x), static_cast<int>(around.front().y));
  clearSelection();
  notices.clear();  // the instructions are no longer needed
  if (!view) return;
  const CanvasView& in = views[*view];
  std::size_t count = 0;
  for (const ShownCloud& cloud : clouds) {
    if (cloud.view != *view) continue;
    const Scan& scan = frame->scans[cloud.scan].scan;
    std::vector<std::uint32_t> points;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (!isFinite(scan.position[i]) || (!cloud.shown.empty() && cloud.shown[i] == 0)) continue;
      const Projected p = in.camera.project(cloud.canvasFromScan * Vec3d(scan.position[i]));
      if (!(p.depth >= in.camera.nearest) || !isWithin(around, in.rect.left + p.x, in.rect.top + p.y)) continue;
      points.push_back(static_cast<std::uint32_t>(i));
    }
    count += points.size();
    if (!points.empty()) selected[cloud.scan] = std::move(points);
  }
  if (count == 0) say("no point lies within");
}

void ViewSession::State::placeSelection() {
  if (selected.empty()) {
    if (selectedItem.there()) selectedItem.drop();
    return;
  }
  if (itemsChanged || viewsChanged) edge(selectedItem, selected, itemsChanged);
}

void ViewSession::State::drawSelection() {
  Legend legend;
  std::map<std::uint16_t, std::uint64_t> counts;
  std::uint64_t count = 0;
  for (const auto& [s, points] : selected) {
    const auto& classes = frame->scans[s].scan[kLabel];
    count += points.size();
    for (const std::uint32_t i : points) {
      if (!classes.empty()) ++counts[classes[i]];
    }
  }
  for (const auto& [id, points] : counts) {
    legend.entries.push_back({className(source->ontology(), id), classColor(source->ontology(), id), id, points});
  }
  valueRows("selection", {{"points", grouped(count)}});
  legendRows(legend, {}, false, options.still);
  if (options.still) return;
  if (ImGui::Button("Save as PCD")) saveSelection();
  ImGui::SameLine();
  if (ImGui::Button("Clear")) clearSelection();
}

// Writes the selected points to a file for each scan, with all of the scan's columns.
void ViewSession::State::saveSelection() {
  const FormatEntry* const pcd = formatBySuffix("pcd");
  if (pcd == nullptr) return;
  Fields none(Value{}, "pcd");
  const std::unique_ptr<Format> format = pcd->make(none);
  std::vector<std::string> files;
  try {
    for (const auto& [s, points] : selected) {
      const std::filesystem::path file = freeFile("scanmill_selection", ".pcd");
      writeFile(file, format->encode(partOf(frame->scans[s].scan, points)));
      files.push_back(file.string());
    }
    say(fmt::format("saved {}", fmt::join(files, ", ")));
  } catch (const Error& e) {
    say(e.what());
    warn(e.what());
  }
}

}  // namespace scanmill
