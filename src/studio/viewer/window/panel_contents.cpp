#include "viewer/window/panel_contents.h"

#include <fmt/core.h>

#include "base/short_text.h"
#include "viewer/picture.h"

namespace scanmill {

PanelContents::PanelContents(const SessionContext& context, const Playback& playback, const ShownClouds& clouds,
                             const SceneView& sceneView, const Pointer& pointer)
    : imgui(context.canvas, context.options.still ? pictureLineHeight(context.canvas.width(), context.canvas.height())
                                                  : windowLineHeight(context.canvas.scale())),
      context_(context),
      playback_(playback),
      clouds_(clouds),
      sceneView_(sceneView),
      pointer_(pointer) {}

void PanelContents::arrange() {
  fillPanes();
  collectLegends();
  addMessages();
  const int width = context_.canvas.width(), height = context_.canvas.height();
  const bool hasPanels = !context_.options.bare;
  const bool hasBar = hasPanels && !context_.options.still;
  rects = panelRects(
      width, height,
      {.lineHeight = imgui.lineHeight(),
       .row = imgui.row(),
       .title = hasPanels,
       .side = hasPanels && (hasBar || pointer_.pinned || !legends.empty()),
       .bar = hasBar,
       .stripHeight = hasPanels && clouds_.strip ? stripHeight(clouds_.strip->image.height, width, height) : 0});
}

// Sets captions and legends of the views. In the overlay, the legend lists the scans.
void PanelContents::fillPanes() {
  panes.assign(clouds_.viewCount(), {});
  bool colorsDiffer = false;  // true: the views show different quantities
  for (std::size_t v = 1; v < clouds_.viewCount(); ++v) {
    colorsDiffer = colorsDiffer || clouds_.colorOf(v) != clouds_.colorOf(0);
  }
  for (const ShownCloud& cloud : clouds_.list) {
    ViewPane& pane = panes[cloud.view];
    const std::string& name = clouds_.scanOf(cloud).name;
    if (clouds_.overlaid()) {
      pane.legend.title = "scan";
      pane.legend.entries.push_back({.name = name,
                                     .color = overlayColor(cloud.scan),
                                     .id = static_cast<std::int64_t>(cloud.scan),
                                     .points = cloud.finite});
      continue;
    }
    pane.active = clouds_.activeView == cloud.view && clouds_.viewCount() > 1;
    pane.caption = name;
    if (colorsDiffer) pane.caption += fmt::format("{}{}", name.empty() ? "" : ": ", clouds_.colorOf(cloud.view).name());
    if (cloud.finite == 0) continue;
    pane.legend = cloud.coloring.legend;
    completeClasses(pane.legend);
  }
  if (context_.source->isScene() && sceneView_.mesh) panes.front().legend = sceneView_.meshColoring.legend;
}

std::vector<CanvasView> PanelContents::views() const {
  std::vector<CanvasView> views;
  for (const PixelRect& rect : gridRects(rects.body, panes.size())) {
    const ViewCamera camera = sceneView_.camera.camera(rect.width, rect.height);
    views.push_back({.rect = rect,
                     .camera = camera,
                     .farthest = std::max(sceneView_.farthest(camera.eye), 2 * camera.nearest),
                     .background = context_.options.background,
                     .depthEdges = context_.options.depthEdges});
  }
  return views;
}

// Adds a label at a position (canvas frame) in each view that shows the position.
void PanelContents::addLabel(const Vec3d& position, const PanelLabel& label) {
  for (const CanvasView& view : context_.redraw.views()) {
    const Projected p = view.camera.project(position);
    if (!(p.depth >= view.camera.nearest)) continue;
    if (!(p.x >= 0 && p.y >= 0 && p.x < view.rect.width && p.y < view.rect.height)) continue;
    PanelLabel& added = labels.emplace_back(label);
    added.x = view.rect.left + p.x;
    added.y = view.rect.top + p.y;
    added.within = view.rect;
  }
}

void PanelContents::addLabels() {
  labels.clear();
  if (context_.options.rangeRings && !clouds_.list.empty()) {
    // Put the labels of the range rings in the direction in which the camera looks, where they are visible.
    const Vec3d ahead{std::cos(sceneView_.camera.yaw), std::sin(sceneView_.camera.yaw), 0};
    for (const double radius : kRingRadii) {
      addLabel(sceneView_.ground + ahead * radius, {.text = fmt::format("{} m", radius), .mark = false});
    }
  }
  if (context_.options.axes) addSensorLabels();
  // Label the nearest objects with class, id and the fraction (%) of the object that is not occluded.
  for (const auto& [object, view] : sceneView_.nearestSeenObjects()) {
    const std::string name = className(context_.source->ontology(), object->semantic);
    const double visible = 100 * view->visibility().value_or(0);
    addLabel(
        sceneView_.canvasFromBox(*object) * Vec3d{0, 0, object->size.z / 2},
        {.text = fmt::format("{} {}, {:.0f} % visible", name, object->id, visible), .mark = false, .optional = true});
  }
  const std::vector<Vec3d>& ends = pointer_.ends;
  for (const Vec3d& end : ends) addLabel(end, {});
  if (!ends.empty() && (ends.size() == 2 || (pointer_.measuring && pointer_.hover))) {
    const Vec3d end = ends.size() == 2 ? ends[1] : pointer_.hover->position;
    const Vec3d line = end - ends[0];
    addLabel(ends[0] + line * 0.5,
             {.text = fmt::format("{:.3f} m (dx {:.3f}, dy {:.3f}, dz {:.3f})", length(line), line.x, line.y, line.z),
              .mark = false});
  }
  if (pointer_.pinned) addLabel(pointer_.pinned->position, {});
  if (pointer_.hover) addLabel(pointer_.hover->position, {});
}

// If the scans are from sensors at different positions, labels each position with the name of a sensor that is there.
void PanelContents::addSensorLabels() {
  constexpr double kSamePosition = 0.05;  // m
  std::vector<const ShownCloud*> distinct;
  for (const ShownCloud& cloud : clouds_.list) {
    const auto isNear = [&](const ShownCloud* other) {
      return length(other->canvasFromScan.translation - cloud.canvasFromScan.translation) < kSamePosition;
    };
    if (std::ranges::none_of(distinct, isNear)) distinct.push_back(&cloud);
  }
  if (distinct.size() < 2) return;
  for (const ShownCloud* cloud : distinct) {
    addLabel(cloud->canvasFromScan.translation, {.text = clouds_.scanOf(*cloud).sensor, .mark = false});
  }
}

std::string PanelContents::title() const {
  const std::size_t frames = context_.source->keys().size();
  std::string text = context_.source->title();
  if (context_.options.still && frames > 1) text += ", " + context_.source->keys()[playback_.requested()];
  if (context_.scanCount() == 0) return text;
  const std::string& name = context_.frame->scans[clouds_.shownScan()].name;
  const bool hasName =
      context_.scanCount() > 1 ? context_.options.layout == ViewLayout::One : frames > 1 && !name.empty();
  return hasName ? text + ": " + name : text;
}

std::string PanelContents::summary() const {
  if (!context_.frame) return {};
  std::uint64_t visible = 0, finite = 0;
  for (const ShownCloud& cloud : clouds_.list) {
    if (context_.options.layout == ViewLayout::Split && context_.scanCount() == 1 && cloud.view > 0) continue;
    visible += cloud.visible;
    finite += cloud.finite;
  }
  const bool isScene = context_.source->isScene();
  const ShownFilter& filter = context_.filter;
  std::string text;
  if (isScene) {
    if (sceneView_.mesh) text = fmt::format("{} triangles", grouped(sceneView_.mesh->size()));
  } else if (visible == finite) {
    text = pluralOf(finite, "point");
  } else {
    text = fmt::format("{} of {} points", grouped(visible), grouped(finite));
  }
  const Ontology* const ontology =
      isScene && sceneView_.mesh ? &sceneView_.mesh->ontology : context_.source->ontology();
  if (const std::string classes = filter.classes.text(ontology); !classes.empty()) text += ", " + classes;
  if (filter.instances.size() == 1) text += fmt::format(", only instance {}", *filter.instances.begin());
  if (filter.instances.size() > 1) text += fmt::format(", only {} instances", filter.instances.size());
  if (const auto& closeUp = filter.closeUp) {
    text += fmt::format(", {:.4g} m about {:.4g},{:.4g},{:.4g}", closeUp->radius, closeUp->center.x, closeUp->center.y,
                        closeUp->center.z);
  }
  if (pointer_.measuring) {
    text += fmt::format(", distance: click the {} end", pointer_.ends.empty() ? "first" : "second");
  }
  return text;
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

// True if there are entries, and all are classes (or scans, in the overlay).
bool listsIds(const Legend& legend) {
  return !legend.entries.empty() &&
         std::ranges::all_of(legend.entries, [](const LegendEntry& entry) { return entry.id >= 0; });
}

// True if the colours of both legends have the same meaning.
bool meansTheSame(const Legend& a, const Legend& b) {
  if (a.title != b.title) return false;
  if (a.scale || b.scale) {
    return a.scale == b.scale && a.low == b.low && a.high == b.high && a.power == b.power &&
           a.endsChosen == b.endsChosen;
  }
  return listsIds(a) && listsIds(b);
}

LegendEntry* entryOf(Legend& legend, std::int64_t id) {
  const auto found = std::ranges::find(legend.entries, id, &LegendEntry::id);
  return found == legend.entries.end() ? nullptr : &*found;
}

}  // namespace

// Adds the classes of other frames to a legend of classes, so that its rows are the same in all frames.
void PanelContents::completeClasses(Legend& legend) const {
  if (!listsIds(legend)) return;
  for (const std::uint16_t id : clouds_.presentClasses) {
    if (entryOf(legend, id) != nullptr) continue;
    const Ontology* const ontology = context_.source->ontology();
    legend.entries.push_back({.name = className(ontology, id), .color = classColor(ontology, id), .id = id});
  }
  std::ranges::sort(legend.entries, {}, &LegendEntry::id);
}

// Collects the legends of all views. Views whose colours have the same meaning share one legend, with the numbers of
// points of the active view. If none of these views is active, the numbers of the entries are 0, and `unknown`, whose
// row explains the colour of points without a value, is the sum over the views.
void PanelContents::collectLegends() {
  legends.clear();
  for (std::size_t v = 0; v < panes.size() && context_.options.legends; ++v) {
    const Legend& legend = panes[v].legend;
    if (!legend.scale && legend.entries.empty()) continue;
    const auto shared =
        std::ranges::find_if(legends, [&](const LegendBlock& block) { return meansTheSame(block.legend, legend); });
    if (shared == legends.end()) {
      legends.push_back({.legend = legend, .views = {v}});
      continue;
    }
    shared->views.push_back(v);
    shared->legend.unknown += legend.unknown;
    for (const LegendEntry& entry : legend.entries) {
      if (entryOf(shared->legend, entry.id) == nullptr) shared->legend.entries.push_back(entry);
    }
  }
  for (LegendBlock& block : legends) {
    if (block.views.size() > 1) countActiveView(block);
  }
}

// Copies the numbers of points of the active view to a legend that several views share, see collectLegends().
void PanelContents::countActiveView(LegendBlock& block) {
  Legend active;  // without entries unless the active view is one of the block's views
  if (clouds_.activeView && std::ranges::count(block.views, *clouds_.activeView) > 0) {
    active = panes[*clouds_.activeView].legend;
    block.legend.unknown = active.unknown;
  }
  for (LegendEntry& entry : block.legend.entries) {
    const LegendEntry* const activeEntry = entryOf(active, entry.id);
    entry.points = activeEntry == nullptr ? 0 : activeEntry->points;
  }
  if (!block.legend.scale) std::ranges::sort(block.legend.entries, {}, &LegendEntry::id);
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
