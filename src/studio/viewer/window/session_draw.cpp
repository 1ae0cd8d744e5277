// What is drawn when, and what lies over it.

#include <fmt/core.h>

#include <algorithm>

#include "base/grouped.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"
#include "viewer/window/guides.h"
#include "viewer/window/picked_rows.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

constexpr Rgb kLabelColor{255, 255, 255};

bool isOfClasses(const Legend& legend) {
  return !legend.entries.empty() && std::all_of(legend.entries.begin(), legend.entries.end(),
                                                [](const LegendEntry& entry) { return entry.id >= 0; });
}

bool meansTheSame(const Legend& a, const Legend& b) {
  if (a.title != b.title) return false;
  if (a.scale || b.scale) {
    return a.scale == b.scale && a.low == b.low && a.high == b.high && a.power == b.power && a.held == b.held;
  }
  return isOfClasses(a) && isOfClasses(b);
}

void sortById(Legend& legend) {
  std::sort(legend.entries.begin(), legend.entries.end(),
            [](const LegendEntry& a, const LegendEntry& b) { return a.id < b.id; });
}

}  // namespace

void ViewSession::State::hint(const std::string& text) {
  constexpr double kSeconds = 15;
  if (std::find(hints.begin(), hints.end(), text) != hints.end()) return;
  hints.push_back(text);
  say(text, kSeconds);
}

void ViewSession::State::say(const std::string& text, double seconds) {
  // A key's newer words replace its older ones.
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

// So that rows stay where they are from frame to frame.
void ViewSession::State::completeClasses(Legend& legend) const {
  if (!isOfClasses(legend)) return;
  for (const std::uint16_t id : presentClasses) {
    const bool known = std::any_of(legend.entries.begin(), legend.entries.end(),
                                   [&](const LegendEntry& entry) { return entry.id == id; });
    if (!known) {
      legend.entries.push_back({className(source->ontology(), id), classColor(source->ontology(), id), id, 0});
    }
  }
  sortById(legend);
}

// What means the same in all panes is said in the last one alone; counts are those of the view that keys act on.
void ViewSession::State::joinLegends() {
  if (hudState.panes.size() < 2) return;
  Legend joined;
  for (const HudPane& pane : hudState.panes) {
    const Legend& own = pane.legend;
    if (!own.scale && own.entries.empty()) continue;
    if (!joined.scale && joined.entries.empty()) {
      joined = own;
      if (!activeView) {
        for (LegendEntry& entry : joined.entries) entry.points = 0;
      }
      continue;
    }
    if (!meansTheSame(joined, own)) return;
    joined.unknown += own.unknown;
    for (const LegendEntry& entry : own.entries) {
      const bool known = std::any_of(joined.entries.begin(), joined.entries.end(),
                                     [&](const LegendEntry& other) { return other.id == entry.id; });
      if (!known) joined.entries.push_back(entry);
    }
  }
  if (activeView) {
    const Legend& active = hudState.panes[*activeView].legend;
    joined.unknown = active.unknown;
    for (LegendEntry& entry : joined.entries) {
      const auto own = std::find_if(active.entries.begin(), active.entries.end(),
                                    [&](const LegendEntry& other) { return other.id == entry.id; });
      entry.points = own == active.entries.end() ? 0 : own->points;
    }
  }
  if (!joined.scale) sortById(joined);
  for (HudPane& pane : hudState.panes) {
    pane.legend = {};
    pane.hidden.clear();
    pane.clickable = false;
  }
  HudPane& last = hudState.panes.back();
  last.legend = std::move(joined);
  for (LegendEntry& entry : last.legend.entries) {
    if (!activeView) entry.points = 0;
    last.hidden.push_back(!filter.shows(static_cast<std::uint16_t>(entry.id)));
  }
  last.clickable = !last.legend.scale;
}

// Why nothing is to be seen.
void ViewSession::State::addMessages() {
  if (!frame || source->isScene()) return;
  if (frame->scans.empty()) {
    std::string& message = hudState.panes.front().message;
    message = frame->key + " cannot be shown";
    for (const std::string& problem : frame->problems) message += "\n" + problem;
    return;
  }
  for (std::size_t v = 0; v < hudState.panes.size(); ++v) {
    std::uint64_t finite = 0;
    std::uint64_t visible = 0;
    for (const ShownCloud& cloud : clouds) {
      if (cloud.view != v) continue;
      finite += cloud.finite;
      visible += cloud.visible;
    }
    if (visible > 0) continue;
    std::string& message = hudState.panes[v].message;
    message = finite == 0 ? "no points: the scan is empty"
                          : fmt::format("no point is shown: the filter hides all {}", grouped(finite));
    if (finite > 0 && !options.still) message += "\nA shows them";
  }
}

// Panes, with their legends: what the layout follows from, and the views with it.
void ViewSession::State::refresh() {
  hudState.width = canvas.width();
  hudState.height = canvas.height();
  hudState.bare = options.bare;
  hudState.still = options.still;
  hudState.panes.assign(viewCount(), {});
  bool differ = false;
  for (std::size_t v = 1; v < viewCount(); ++v) differ = differ || colorOf(v) != colorOf(0);
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
    pane.active = activeView == cloud.view && viewCount() > 1;
    pane.caption = name;
    if (differ) {
      pane.caption += fmt::format("{}{}", name.empty() ? "" : ": ", colorOf(cloud.view).name());
    }
    if (cloud.finite == 0) continue;
    pane.legend = cloud.coloring.legend;
    completeClasses(pane.legend);
    for (const LegendEntry& entry : pane.legend.entries) {
      pane.hidden.push_back(entry.id >= 0 && !filter.shows(static_cast<std::uint16_t>(entry.id)));
      pane.clickable = pane.clickable || entry.id >= 0;
    }
  }
  if (source->isScene() && mesh) {
    HudPane& pane = hudState.panes.front();
    pane.legend = meshColoring.legend;
    for (const LegendEntry& entry : pane.legend.entries) {
      pane.hidden.push_back(entry.id >= 0 && !filter.shows(static_cast<std::uint16_t>(entry.id)));
      pane.clickable = pane.clickable || entry.id >= 0;
    }
  }
  joinLegends();
  addMessages();
  if (!options.legends) {
    for (HudPane& pane : hudState.panes) pane = {pane.caption, {}, {}, false, pane.active, pane.message};
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

void ViewSession::State::composeHud() {
  constexpr std::size_t kMostHints = 8;
  hudState.title = source->title();
  if (options.still && hudState.frames > 1) hudState.title += ", " + hudState.key;
  if (frame && options.layout == ViewLayout::One && frame->scans.size() > 1) {
    hudState.title += ": " + frame->scans[shownScan()].name;
  } else if (frame && frame->scans.size() == 1 && !frame->scans.front().name.empty() && hudState.frames > 1) {
    hudState.title += ": " + frame->scans.front().name;
  }
  hudState.summary = summary();
  hudState.playing = playing;
  hudState.speed = speedText();
  hudState.busy = busy;
  hudState.problems = problems();
  hudState.notices.clear();
  for (const ViewNotice& notice : notices) hudState.notices.push_back(notice.text);
  hudState.help = help;
  if (help && hudState.keys.empty()) hudState.keys = viewKeys();
  hudState.prompt = prompt;
  hudState.promptCaption = "go to sample (key, or #index from 0):";
  hudState.promptHints.clear();
  if (prompt) {
    std::size_t found = 0;
    for (const std::string& key : source->keys()) {
      if (key.find(*prompt) == std::string::npos) continue;
      if (found++ < kMostHints) hudState.promptHints.push_back(key);
    }
    if (found > kMostHints) hudState.promptHints.push_back(fmt::format("and {} more", grouped(found - kMostHints)));
    if (found == 0) hudState.promptHints.push_back("no key holds this; an index counts from 0");
  }
  if (strip) {
    const auto& viewed = frame->scans[clouds[stripCloud].scan];
    hudState.strip->caption = viewed.name + ": " + describeStrip(*strip, options.stripOrder);
    if (!options.still) {
      hudState.strip->caption +=
          options.stripOrder == StripOrder::Outward ? " (I: as the sensor orders it)" : " (I: looking outward)";
    }
  }
  addLabels();
  addTips();
}

void ViewSession::State::flush(bool whole) {
  const double began = clock.seconds();
  if (viewsChanged || itemsChanged || hudChanged) refresh();
  if (itemsChanged && pinned && !isShown(*pinned)) pinned.reset();
  // What lies under a pointer at rest is another thing when the picture moves.
  if (hoverChanged || viewsChanged || itemsChanged) updateHover();
  lightInstance();
  const bool sceneChanged = viewsChanged || itemsChanged;
  const bool overlayChanged = sceneChanged || hudChanged || lightChanged;
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
  viewsChanged = itemsChanged = hudChanged = lightChanged = false;
}

}  // namespace scanmill
