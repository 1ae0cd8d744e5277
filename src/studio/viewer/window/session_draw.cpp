// Decides when pictures are drawn, and draws the labels and panels over them.

#include <fmt/core.h>

#include <algorithm>

#include "base/grouped.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"
#include "viewer/window/guides.h"
#include "viewer/window/picked_rows.h"
#include "viewer/window/session_state.h"

namespace scanmill {

void ViewSession::State::hint(const std::string& text) {
  constexpr double kSeconds = 15;
  if (std::find(hints.begin(), hints.end(), text) != hints.end()) return;
  hints.push_back(text);
  say(text, kSeconds);
}

void ViewSession::State::say(const std::string& text, double seconds) {
  // A notice of a key replaces the older notices of the same key.
  std::erase_if(notices, [&](const ViewNotice& n) { return n.text == text || (acting && n.of == acting); });
  notices.push_back({text, clock.seconds() + seconds, acting});
  hudChanged = true;
}

std::string ViewSession::State::summary() const {
  if (!frame) return {};
  std::uint64_t visible = 0;
  std::uint64_t finite = 0;
  for (const ShownCloud& cloud : clouds) {
    if (options.layout == ViewLayout::Split && frame->scans.size() == 1 && cloud.view > 0) continue;
    visible += cloud.visible;
    finite += cloud.finite;
  }
  std::string out;
  if (source->isScene()) {
    if (mesh) out = fmt::format("{} triangles", grouped(mesh->size()));
  } else if (visible == finite) {
    out = fmt::format("{} point{}", grouped(finite), finite == 1 ? "" : "s");
  } else {
    out = fmt::format("{} of {} points", grouped(visible), grouped(finite));
  }
  if (const std::string filtered = filter.text(source->isScene() && mesh ? &mesh->ontology : source->ontology());
      !filtered.empty()) {
    out += ", " + filtered;
  }
  if (aloneInstances.size() == 1) out += fmt::format(", only instance {}", *aloneInstances.begin());
  if (aloneInstances.size() > 1) out += fmt::format(", only {} instances", aloneInstances.size());
  if (measuring) out += fmt::format(", distance: click the {} end", ends.empty() ? "first" : "second");
  return out;
}

// Updates the panes, their legends, and then the views, whose rectangles depend on these.
void ViewSession::State::refresh() {
  panes.assign(viewCount(), {});
  bool differ = false;
  for (std::size_t v = 1; v < viewCount(); ++v) differ = differ || colorOf(v) != colorOf(0);
  for (const ShownCloud& cloud : clouds) {
    ViewPane& pane = panes[cloud.view];
    const std::string& name = frame->scans[cloud.scan].name;
    if (overlaid()) {
      pane.legend.title = "scan";
      pane.legend.entries.push_back(
          {name, overlayColor(cloud.scan), static_cast<std::int64_t>(cloud.scan), cloud.finite});
      continue;
    }
    pane.active = activeView == cloud.view && viewCount() > 1;
    pane.caption = name;
    if (differ) pane.caption += fmt::format("{}{}", name.empty() ? "" : ": ", colorOf(cloud.view).name());
    if (cloud.finite == 0) continue;
    pane.legend = cloud.coloring.legend;
    completeClasses(pane.legend);
  }
  if (source->isScene() && mesh) panes.front().legend = meshColoring.legend;
  collectLegends();
  addMessages();

  PanelNeeds needs;
  needs.letter = toolkit.letter();
  needs.row = toolkit.row();
  needs.title = !options.bare;
  needs.bar = !options.bare && !options.still;
  needs.side = !options.bare && (needs.bar || pinned || !legends.empty());
  if (strip && !options.bare) needs.stripHeight = stripHeight(strip->image.height, canvas.width(), canvas.height());
  rooms = roomsOf(canvas.width(), canvas.height(), needs);
  std::vector<CanvasView> placed;
  for (const PixelRect& rect : partsOf(rooms.body, panes.size(), 1)) {
    CanvasView view;
    view.rect = rect;
    view.camera = camera.camera(rect.width, rect.height);
    view.farthest = std::max(farthest(view.camera.eye), 2 * view.camera.nearest);
    view.background = options.background;
    view.depthEdges = options.depthEdges;
    placed.push_back(view);
  }
  const bool moved = placed.size() != views.size() ||
                     !std::equal(placed.begin(), placed.end(), views.begin(),
                                 [](const CanvasView& a, const CanvasView& b) { return a.rect == b.rect; });
  if (!viewsChanged && !moved && !itemsChanged) return;
  views = std::move(placed);
  canvas.setViews(views);
  viewsChanged = true;
}

void ViewSession::State::addLabel(const Vec3d& spot, const std::string& text, bool mark) {
  for (const CanvasView& view : views) {
    const Projected p = view.camera.project(spot);
    if (!(p.depth >= view.camera.nearest)) continue;
    if (!(p.x >= 0 && p.y >= 0 && p.x < view.rect.width && p.y < view.rect.height)) continue;
    labels.push_back({view.rect.left + p.x, view.rect.top + p.y, text, mark});
  }
}

void ViewSession::State::addLabels() {
  labels.clear();
  if (options.rangeRings && !clouds.empty()) {
    // The labels of the rings are ahead of the camera, where they are seen.
    const Vec3d ahead{std::cos(camera.yaw), std::sin(camera.yaw), 0};
    for (const double radius : kRingRadii) addLabel(ground + ahead * radius, fmt::format("{} m", radius), false);
  }
  if (options.axes) {
    // Name the sensors that are at different places.
    std::vector<Vec3d> named;
    for (const ShownCloud& cloud : clouds) {
      const Vec3d& stands = cloud.canvasFromScan.translation;
      const bool near =
          std::any_of(named.begin(), named.end(), [&](const Vec3d& n) { return length(n - stands) < 0.05; });
      if (near) continue;
      if (named.size() == 1) addLabel(named.front(), frame->scans[clouds.front().scan].sensor, false);
      named.push_back(stands);
      if (named.size() > 1) addLabel(stands, frame->scans[cloud.scan].sensor, false);
    }
  }
  addBoxLabels();
  for (const Vec3d& end : ends) addLabel(end, "", true);
  if (!ends.empty() && (ends.size() == 2 || (measuring && hover))) {
    const Vec3d to = ends.size() == 2 ? ends[1] : hover->place;
    const Vec3d line = to - ends[0];
    addLabel(ends[0] + line * 0.5,
             fmt::format("{:.3f} m (dx {:.3f}, dy {:.3f}, dz {:.3f})", length(line), line.x, line.y, line.z), false);
  }
  if (pinned) addLabel(pinned->place, "", true);
  if (hover) addLabel(hover->place, "", true);
}

std::string ViewSession::State::title() const {
  const std::size_t frames = source->keys().size();
  std::string text = source->title();
  if (options.still && frames > 1) text += ", " + source->keys()[wanted];
  if (frame && options.layout == ViewLayout::One && frame->scans.size() > 1) {
    text += ": " + frame->scans[shownScan()].name;
  } else if (frame && frame->scans.size() == 1 && !frame->scans.front().name.empty() && frames > 1) {
    text += ": " + frame->scans.front().name;
  }
  return text;
}

void ViewSession::State::flush(bool whole) {
  const double began = clock.seconds();
  if (viewsChanged || itemsChanged || hudChanged) refresh();
  if (itemsChanged && pinned && !isShown(*pinned)) pinned.reset();
  // When the picture changes, another point may be under the pointer, even if the pointer rests.
  if (hoverChanged || viewsChanged || itemsChanged) {
    const bool held = toolkit.hasPointer();
    runPanels();
    if (held || toolkit.hasPointer()) hudChanged = true;  // a panel highlights what is under the pointer
    updateHover();
  }
  lightInstance();
  placeBeam();
  const bool sceneChanged = viewsChanged || itemsChanged;
  const bool overlayChanged = sceneChanged || hudChanged || lightChanged;
  if (overlayChanged) {
    addLabels();
    runPanels();
    runPanels();  // in the second run all sizes are known
  }
  if (!overlayChanged && !(whole && partial)) return;
  std::uint64_t total = 0;
  for (const ShownCloud& cloud : clouds) total += cloud.visible;
  // Draw few points quickly at first; all points when nothing has changed for a while.
  const std::uint64_t most = whole ? 0 : sceneChanged ? pace.mostOfEach(total, clouds.size()) : lastMost;
  const double before = clock.seconds();
  canvas.render(most);
  lastPicture = clock.seconds();
  if (sceneChanged) lastChange = lastPicture;
  if (sceneChanged || (whole && partial)) {
    const double seconds = lastPicture - before;
    pace.measured(most == 0 ? total : std::min(total, most * clouds.size()), seconds * 1e3);
    if (most == 0) wholeSeconds = seconds;
  }
  lastMost = most;
  partial = most != 0;
  pictureSeconds = lastPicture - began;
  viewsChanged = itemsChanged = hudChanged = lightChanged = false;
}

}  // namespace scanmill
