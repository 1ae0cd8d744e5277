// What is drawn when, and what lies over it.

#include <fmt/core.h>

#include <algorithm>

#include "viewer/color_map.h"
#include "viewer/picture.h"
#include "viewer/window/guides.h"
#include "viewer/window/picked_rows.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

constexpr Rgb kLabelColor{255, 255, 255};

Legend meshLegend(const ViewMesh& mesh) {
  std::vector<std::uint64_t> triangles(std::size_t{UINT16_MAX} + 1, 0);
  for (const std::uint16_t id : mesh.semantic) ++triangles[id];
  Legend legend;
  legend.title = "class";
  for (std::size_t id = 0; id < triangles.size(); ++id) {
    if (triangles[id] == 0) continue;
    const auto semantic = static_cast<std::uint16_t>(id);
    legend.entries.push_back({className(&mesh.ontology, semantic), classColor(&mesh.ontology, semantic),
                              static_cast<std::int64_t>(id), triangles[id]});
  }
  return legend;
}

}  // namespace

void ViewSession::State::say(const std::string& text) {
  constexpr double kSeconds = 4;
  for (ViewNotice& notice : notices) {
    if (notice.text == text) notice.until = 0;
  }
  notices.push_back({text, clock.seconds() + kSeconds});
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
    if (mesh) out = fmt::format("{} triangles", groupedCount(mesh->size()));
  } else if (visible == finite) {
    out = fmt::format("{} point{}", groupedCount(finite), finite == 1 ? "" : "s");
  } else {
    out = fmt::format("{} of {} points", groupedCount(visible), groupedCount(finite));
  }
  if (const std::string filtered = filter.text(source->isScene() && mesh ? &mesh->ontology : source->ontology());
      !filtered.empty()) {
    out += ", " + filtered;
  }
  if (measuring) out += fmt::format(", distance: click the {} end", ends.empty() ? "first" : "second");
  return out;
}

// Panes, with their legends: what the layout follows from, and the views with it.
void ViewSession::State::refresh() {
  hudState.width = canvas.width();
  hudState.height = canvas.height();
  hudState.bare = options.bare;
  hudState.panes.assign(viewCount(), {});
  for (const ShownCloud& cloud : clouds) {
    HudPane& pane = hudState.panes[cloud.view];
    const std::string& name = frame->scans[cloud.scan].name;
    if (overlaid()) {
      const bool hidden = hiddenScans.contains(name);
      pane.legend.title = "scan";
      pane.legend.entries.push_back(
          {name, overlayColor(cloud.scan), static_cast<std::int64_t>(cloud.scan), cloud.finite});
      pane.hidden.push_back(hidden);
      pane.clickable = true;
      continue;
    }
    pane.caption = activeView == cloud.view && viewCount() > 1 ? "> " + name : name;
    if (cloud.finite == 0) continue;
    pane.legend = cloud.coloring.legend;
    for (const LegendEntry& entry : pane.legend.entries) {
      pane.hidden.push_back(entry.id >= 0 && !filter.shows(static_cast<std::uint16_t>(entry.id)));
      pane.clickable = pane.clickable || entry.id >= 0;
    }
  }
  if (source->isScene() && mesh) {
    HudPane& pane = hudState.panes.front();
    pane.legend = meshLegend(*mesh);
    for (const LegendEntry& entry : pane.legend.entries) {
      pane.hidden.push_back(!filter.shows(static_cast<std::uint16_t>(entry.id)));
    }
    pane.clickable = true;
  }
  if (!options.legends) {
    for (HudPane& pane : hudState.panes) pane = {pane.caption, {}, {}, false};
  }
  hudState.frames = source->keys().size();
  hudState.frame = hudState.frames > 1 ? std::optional(wanted) : std::nullopt;
  hudState.key = hudState.frames > 0 ? source->keys()[wanted] : "";

  layout = layoutHud(hudState);
  std::vector<CanvasView> placed;
  for (const PixelRect& rect : layout.panes) {
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
    hudState.labels.push_back({view.rect.left + p.x, view.rect.top + p.y, text, kLabelColor, mark});
  }
}

void ViewSession::State::addLabels() {
  hudState.labels.clear();
  if (options.rangeRings && !clouds.empty()) {
    // Ahead of the camera, where they are seen.
    const Vec3d ahead{std::cos(camera.yaw), std::sin(camera.yaw), 0};
    for (const double radius : kRingRadii) addLabel(ground + ahead * radius, fmt::format("{} m", radius), false);
  }
  if (options.axes) {
    // Sensors that stand apart.
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
  for (const Vec3d& end : ends) addLabel(end, "", true);
  if (!ends.empty() && (ends.size() == 2 || (measuring && hover))) {
    const Vec3d to = ends.size() == 2 ? ends[1] : hover->place;
    const Vec3d line = to - ends[0];
    addLabel(ends[0] + line * 0.5,
             fmt::format("{:.3f} m (dx {:.3f}, dy {:.3f}, dz {:.3f})", length(line), line.x, line.y, line.z), false);
  }
  if (pinned) addLabel(pinned->place, "", true);
  if (hover) addLabel(hover->place, "", true);
  for (const ShownCloud& cloud : clouds) {
    if (cloud.finite > 0 || overlaid()) continue;
    const PixelRect& rect = views[cloud.view].rect;
    hudState.labels.push_back({rect.left + rect.width * 0.5, rect.top + rect.height * 0.5,
                               "no points: the scan is empty", kLabelColor, false});
  }
}

void ViewSession::State::addTip() {
  hudState.tip.reset();
  const std::optional<PickedThing>& thing = hover ? hover : pinned;
  if (hudState.strip) hudState.strip->mark.reset();
  if (!thing || help) return;
  HudTip tip;
  tip.heading = thing->heading;
  tip.rows = thing->rows;
  tip.x = pointerX;
  tip.y = pointerY;
  const std::size_t view = viewAt(pointerX, pointerY).value_or(strip ? clouds[stripCloud].view : 0);
  if (view < views.size()) {
    const Projected p = views[view].camera.project(thing->place);
    const PixelRect& rect = views[view].rect;
    if (p.depth >= views[view].camera.nearest && p.x >= 0 && p.y >= 0 && p.x < rect.width && p.y < rect.height) {
      tip.x = rect.left + static_cast<int>(p.x);
      tip.y = rect.top + static_cast<int>(p.y);
    }
  }
  for (const ShownCloud& cloud : clouds) {
    if (cloud.scan == thing->scan && thing->point < cloud.coloring.colors.size()) {
      tip.color = cloud.coloring.colors[thing->point];
    }
  }
  if (thing->scan == kNoScan && mesh && thing->point < mesh->size()) {
    tip.color = classColor(&mesh->ontology, mesh->semantic[thing->point]);
  }
  if (strip && thing->scan == clouds[stripCloud].scan) {
    hudState.strip->mark = strip->place(thing->point);
  }
  hudState.tip = std::move(tip);
}

void ViewSession::State::composeHud() {
  constexpr std::size_t kMostHints = 8;
  hudState.title = source->title();
  if (frame && options.layout == ViewLayout::One && frame->scans.size() > 1) {
    hudState.title += ": " + frame->scans[shownScan()].name;
  } else if (frame && frame->scans.size() == 1 && !frame->scans.front().name.empty() && hudState.frames > 1) {
    hudState.title += ": " + frame->scans.front().name;
  }
  hudState.summary = summary();
  hudState.playing = playing;
  hudState.busy = busy;
  hudState.problems = problems();
  hudState.notices.clear();
  for (const ViewNotice& notice : notices) hudState.notices.push_back(notice.text);
  hudState.help = help;
  if (help && hudState.keys.empty()) hudState.keys = viewKeys();
  hudState.prompt = prompt;
  hudState.promptCaption = "go to sample (key or index):";
  hudState.promptHints.clear();
  if (prompt) {
    std::size_t found = 0;
    for (const std::string& key : source->keys()) {
      if (key.find(*prompt) == std::string::npos) continue;
      if (found++ < kMostHints) hudState.promptHints.push_back(key);
    }
    if (found > kMostHints)
      hudState.promptHints.push_back(fmt::format("and {} more", groupedCount(found - kMostHints)));
    if (found == 0) hudState.promptHints.push_back("no key holds this; an index counts from 0");
  }
  if (strip) {
    const auto& viewed = frame->scans[clouds[stripCloud].scan];
    hudState.strip->caption =
        fmt::format("{}: {} rings x {} columns", viewed.name, strip->image.height, strip->image.width);
  }
  addLabels();
  addTip();
}

void ViewSession::State::flush(bool whole) {
  const double began = clock.seconds();
  if (viewsChanged || itemsChanged || hudChanged) refresh();
  if (hoverChanged) updateHover();
  const bool sceneChanged = viewsChanged || itemsChanged;
  const bool overlayChanged = sceneChanged || hudChanged;
  if (overlayChanged) {
    composeHud();
    hud = drawHud(hudState);
    canvas.setOverlay(hudState.width, hudState.height, hud.pixels);
  }
  if (!overlayChanged && !(whole && partial)) return;
  std::uint64_t total = 0;
  for (const ShownCloud& cloud : clouds) total += cloud.visible;
  // Quickly first; all points when nothing has changed for a while.
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
  viewsChanged = itemsChanged = hudChanged = false;
}

}  // namespace scanmill
