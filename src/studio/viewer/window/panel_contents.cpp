#include "viewer/window/panel_contents.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/short_text.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"
#include "viewer/window/canvas_items.h"

namespace scanmill {

PanelContents::PanelContents(const SessionContext& context, const Playback& playback, const ShownClouds& clouds,
                             const SceneView& sceneView, const Pointer& pointer)
    : imgui(context.canvas, lineHeightOf(context.canvas, context.options.still)),
      context_(context),
      playback_(playback),
      clouds_(clouds),
      sceneView_(sceneView),
      pointer_(pointer) {}

void PanelContents::arrange() {
  fillPanes();
  collectLegends();
  addMessages();
  PanelNeeds needs{.lineHeight = imgui.lineHeight(),
                   .row = imgui.row(),
                   .title = !context_.options.bare,
                   .bar = !context_.options.bare && !context_.options.still};
  needs.side = !context_.options.bare && (needs.bar || pointer_.pinned || !legends.empty());
  if (clouds_.strip && !context_.options.bare)
    needs.stripHeight = stripHeight(clouds_.strip->image.height, context_.canvas.width(), context_.canvas.height());
  rects = panelRects(context_.canvas.width(), context_.canvas.height(), needs);
}

void PanelContents::fillPanes() {
  panes.assign(clouds_.viewCount(), {});
  bool differ = false;
  for (std::size_t v = 1; v < clouds_.viewCount(); ++v) differ = differ || clouds_.colorOf(v) != clouds_.colorOf(0);
  for (const ShownCloud& cloud : clouds_.list) {
    ViewPane& pane = panes[cloud.view];
    const std::string& name = clouds_.scanOf(cloud).name;
    if (clouds_.overlaid()) {
      pane.legend.title = "scan";
      pane.legend.entries.push_back(
          {name, overlayColor(cloud.scan), static_cast<std::int64_t>(cloud.scan), cloud.finite});
      continue;
    }
    pane.active = clouds_.activeView == cloud.view && clouds_.viewCount() > 1;
    pane.caption = name;
    if (differ) pane.caption += fmt::format("{}{}", name.empty() ? "" : ": ", clouds_.colorOf(cloud.view).name());
    if (cloud.finite == 0) continue;
    pane.legend = cloud.coloring.legend;
    completeClasses(pane.legend);
  }
  if (context_.source->isScene() && sceneView_.mesh) panes.front().legend = sceneView_.meshColoring.legend;
}

std::vector<CanvasView> PanelContents::views() const {
  std::vector<CanvasView> placed;
  for (const PixelRect& rect : gridRects(rects.body, panes.size(), 1)) {
    CanvasView view{.rect = rect, .camera = sceneView_.camera.camera(rect.width, rect.height)};
    view.farthest = std::max(sceneView_.farthest(view.camera.eye), 2 * view.camera.nearest);
    view.background = context_.options.background;
    view.depthEdges = context_.options.depthEdges;
    placed.push_back(view);
  }
  return placed;
}

void PanelContents::addLabel(const Vec3d& spot, const std::string& text, bool mark, bool optional) {
  for (const CanvasView& view : context_.redraw.views()) {
    const Projected p = view.camera.project(spot);
    if (!(p.depth >= view.camera.nearest)) continue;
    if (!(p.x >= 0 && p.y >= 0 && p.x < view.rect.width && p.y < view.rect.height)) continue;
    labels.push_back({view.rect.left + p.x, view.rect.top + p.y, text, view.rect, mark, optional});
  }
}

void PanelContents::addLabels() {
  labels.clear();
  if (context_.options.rangeRings && !clouds_.list.empty()) {
    // Put the labels of the rings in the direction of the camera, where they are visible.
    const Vec3d ahead{std::cos(sceneView_.camera.yaw), std::sin(sceneView_.camera.yaw), 0};
    for (const double radius : kRingRadii)
      addLabel(sceneView_.ground + ahead * radius, fmt::format("{} m", radius), false);
  }
  if (context_.options.axes) {
    // If the scans are from sensors at different places, label each place with a sensor's name.
    std::vector<Vec3d> named;
    for (const ShownCloud& cloud : clouds_.list) {
      const Vec3d& stands = cloud.canvasFromScan.translation;
      const bool near = std::ranges::any_of(named, [&](const Vec3d& n) { return length(n - stands) < 0.05; });
      if (near) continue;
      if (named.size() == 1) addLabel(named.front(), clouds_.scanOf(clouds_.list.front()).sensor, false);
      named.push_back(stands);
      if (named.size() > 1) addLabel(stands, clouds_.scanOf(cloud).sensor, false);
    }
  }
  // Label the nearest objects with class, id and the fraction (%) of the object that is not occluded.
  for (const auto& [object, view] : sceneView_.nearestSeenObjects()) {
    addLabel(sceneView_.canvasFromBox(*object) * Vec3d{0, 0, object->size.z / 2},
             fmt::format("{} {}, {:.0f} % visible", className(context_.source->ontology(), object->semantic),
                         object->id, 100 * view->visibility().value_or(0)),
             false, true);
  }
  for (const Vec3d& end : pointer_.ends) addLabel(end, "", true);
  if (!pointer_.ends.empty() && (pointer_.ends.size() == 2 || (pointer_.measuring && pointer_.hover))) {
    const Vec3d to = pointer_.ends.size() == 2 ? pointer_.ends[1] : pointer_.hover->position;
    const Vec3d line = to - pointer_.ends[0];
    addLabel(pointer_.ends[0] + line * 0.5,
             fmt::format("{:.3f} m (dx {:.3f}, dy {:.3f}, dz {:.3f})", length(line), line.x, line.y, line.z), false);
  }
  if (pointer_.pinned) addLabel(pointer_.pinned->position, "", true);
  if (pointer_.hover) addLabel(pointer_.hover->position, "", true);
}

std::string PanelContents::title() const {
  const std::size_t frames = context_.source->keys().size();
  std::string text = context_.source->title();
  if (context_.options.still && frames > 1) text += ", " + context_.source->keys()[playback_.requested()];
  if (context_.frame && context_.options.layout == ViewLayout::One && context_.frame->scans.size() > 1) {
    text += ": " + context_.frame->scans[clouds_.shownScan()].name;
  } else if (context_.frame && context_.frame->scans.size() == 1 && !context_.frame->scans.front().name.empty() &&
             frames > 1) {
    text += ": " + context_.frame->scans.front().name;
  }
  return text;
}

std::string PanelContents::summary() const {
  if (!context_.frame) return {};
  std::uint64_t visible = 0, finite = 0;
  for (const ShownCloud& cloud : clouds_.list) {
    if (context_.options.layout == ViewLayout::Split && context_.frame->scans.size() == 1 && cloud.view > 0) continue;
    visible += cloud.visible;
    finite += cloud.finite;
  }
  std::string out;
  if (context_.source->isScene()) {
    if (sceneView_.mesh) out = fmt::format("{} triangles", grouped(sceneView_.mesh->size()));
  } else if (visible == finite) {
    out = pluralOf(finite, "point");
  } else {
    out = fmt::format("{} of {} points", grouped(visible), grouped(finite));
  }
  if (const std::string filtered = context_.filter.classes.text(
          context_.source->isScene() && sceneView_.mesh ? &sceneView_.mesh->ontology : context_.source->ontology());
      !filtered.empty()) {
    out += ", " + filtered;
  }
  if (context_.filter.instances.size() == 1)
    out += fmt::format(", only instance {}", *context_.filter.instances.begin());
  if (context_.filter.instances.size() > 1) out += fmt::format(", only {} instances", context_.filter.instances.size());
  if (const auto& closeUp = context_.filter.closeUp) {
    out += fmt::format(", {:.4g} m about {:.4g},{:.4g},{:.4g}", closeUp->within, closeUp->at.x, closeUp->at.y,
                       closeUp->at.z);
  }
  if (pointer_.measuring)
    out += fmt::format(", distance: click the {} end", pointer_.ends.empty() ? "first" : "second");
  return out;
}

PixelRect PanelContents::stripRect() const {
  const int caption = static_cast<int>(std::lround(imgui.lineHeight() * 1.5));
  PixelRect rect = rects.strip;
  if (rect.height > 2 * caption) {
    rect.top += caption;
    rect.height -= caption;
  }
  return rect;
}

namespace {

bool isOfClasses(const Legend& legend) {
  return !legend.entries.empty() &&
         std::ranges::all_of(legend.entries, [](const LegendEntry& entry) { return entry.id >= 0; });
}

bool meansTheSame(const Legend& a, const Legend& b) {
  if (a.title != b.title) return false;
  if (a.scale || b.scale) {
    return a.scale == b.scale && a.low == b.low && a.high == b.high && a.power == b.power && a.endsChosen == b.endsChosen;
  }
  return isOfClasses(a) && isOfClasses(b);
}

LegendEntry* entryOf(Legend& legend, std::int64_t id) {
  const auto found = std::ranges::find(legend.entries, id, &LegendEntry::id);
  return found == legend.entries.end() ? nullptr : &*found;
}

}  // namespace

// Adds the classes that occur in other frames to a legend, so that its rows are the same in all frames.
void PanelContents::completeClasses(Legend& legend) const {
  if (!isOfClasses(legend)) return;
  for (const std::uint16_t id : clouds_.presentClasses) {
    if (entryOf(legend, id) != nullptr) continue;
    legend.entries.push_back(
        {className(context_.source->ontology(), id), classColor(context_.source->ontology(), id), id, 0});
  }
  std::ranges::sort(legend.entries, {}, &LegendEntry::id);
}

// Collects the legends of all views. Views whose colours have the same meaning share one legend, which has the numbers
// of points in the active view; they are 0 if none of these views is active.
void PanelContents::collectLegends() {
  legends.clear();
  for (std::size_t v = 0; v < panes.size() && context_.options.legends; ++v) {
    const Legend& own = panes[v].legend;
    if (!own.scale && own.entries.empty()) continue;
    const auto same =
        std::ranges::find_if(legends, [&](const LegendBlock& block) { return meansTheSame(block.legend, own); });
    if (same == legends.end()) {
      legends.push_back({own, {v}});
      continue;
    }
    same->views.push_back(v);
    same->legend.unknown += own.unknown;
    for (const LegendEntry& entry : own.entries) {
      if (entryOf(same->legend, entry.id) == nullptr) same->legend.entries.push_back(entry);
    }
  }
  for (auto& [legend, shownIn] : legends) {
    if (shownIn.size() < 2) continue;
    Legend active;
    if (clouds_.activeView && std::ranges::find(shownIn, *clouds_.activeView) != shownIn.end()) {
      active = panes[*clouds_.activeView].legend;
      legend.unknown = active.unknown;
    }
    for (LegendEntry& entry : legend.entries) {
      const LegendEntry* const counted = entryOf(active, entry.id);
      entry.points = counted == nullptr ? 0 : counted->points;
    }
    if (!legend.scale) std::ranges::sort(legend.entries, {}, &LegendEntry::id);
  }
}

bool PanelContents::isHidden(const LegendEntry& entry) const {
  if (entry.id < 0) return false;
  if (clouds_.overlaid())
    return context_.filter.hiddenScans.contains(context_.frame->scans[static_cast<std::size_t>(entry.id)].name);
  return !context_.filter.classes.shows(static_cast<std::uint16_t>(entry.id));
}

// Sets the messages of views that show nothing.
void PanelContents::addMessages() {
  if (!context_.frame || context_.source->isScene()) return;
  if (context_.frame->scans.empty()) {
    std::string& message = panes.front().message;
    message = context_.frame->key + " cannot be shown";
    for (const std::string& problem : context_.frame->problems) message += "\n" + problem;
    return;
  }
  for (std::size_t v = 0; v < panes.size(); ++v) {
    std::uint64_t finite = 0, visible = 0;
    for (const ShownCloud& cloud : clouds_.list) {
      if (cloud.view != v) continue;
      finite += cloud.finite;
      visible += cloud.visible;
    }
    if (visible > 0) continue;
    std::string& message = panes[v].message;
    message = finite == 0 ? "no points: the scan is empty"
                          : fmt::format("no point is shown: the filter hides all {}", grouped(finite));
    if (finite > 0 && !context_.options.still) message += "\nA shows them";
  }
}

}  // namespace scanmill
