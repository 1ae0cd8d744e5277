// Points on the canvas: which view shows which scans, in which colours, and which of their points.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "viewer/picture.h"
#include "viewer/window/session_items.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

// Returns colours by class, or by range if the scan has no classes.
std::vector<Rgb> stripColors(const ViewScan& viewed, const ColorContext& context) {
  return colorScan(viewed.scan, viewed.scan[kLabel].empty() ? kByRange : kByClass, context).colors;
}

ScaleRange changedScale(const Legend& legend, KeyAction change) {
  ScaleRange scale{legend.low, legend.high};
  const double span = scale.high > scale.low ? scale.high - scale.low : std::max(std::abs(scale.high), 1.0);
  switch (change) {
    case KeyAction::LowerHighEnd:
      scale.high = scale.high > 0 && scale.high / 2 > scale.low ? scale.high / 2 : scale.low + span / 2;
      break;
    case KeyAction::RaiseHighEnd:
      scale.high = scale.high > 0 ? scale.high * 2 : scale.low + 2 * span;
      break;
    case KeyAction::LowerLowEnd:  // scales that are not negative stay so
      scale.low = scale.low >= 0 ? std::max(scale.low - span / 3, 0.0) : scale.low - span / 3;
      break;
    default:
      scale.low += span / 4;
  }
  return scale;
}

bool anyFinite(const Vec3f& p) {
  return isFinite(p);
}

void notePresent(const Scan& scan, std::set<std::uint16_t>& present) {
  std::vector<bool> held(std::size_t{UINT16_MAX} + 1, false);
  for (std::size_t i = 0; i < scan[kLabel].size(); ++i) {
    if (isFinite(scan.position[i])) held[scan[kLabel][i]] = true;
  }
  for (std::size_t id = 0; id < held.size(); ++id) {
    if (held[id]) present.insert(static_cast<std::uint16_t>(id));
  }
}

}  // namespace

std::size_t ViewSession::State::viewCount() const {
  if (options.layout != ViewLayout::Split || !frame || frame->scans.empty()) return 1;
  return frame->scans.size() == 1 ? 2 : std::min(frame->scans.size(), kMostSplitViews);
}

std::size_t ViewSession::State::shownScan() const {
  for (std::size_t i = 0; i < frame->scans.size(); ++i) {
    if (frame->scans[i].name == scanName) return i;
  }
  return 0;
}

ColorContext ViewSession::State::contextOf(const ViewScan& scan) const {
  return {source->ontology(), scan.error, scan.errorTitle, scan.whyNoError, std::nullopt};
}

bool ViewSession::State::hasColor(const ViewScan& viewed, const ColorBy& by) const {
  return scanmill::hasColor(viewed.scan, by, !viewed.error.empty());
}

// Returns the quantity that the view's colours show. Without a choice it is the one that colorScan() chooses, but the
// second view of a single scan shows another quantity than the first.
ColorBy ViewSession::State::colorOf(std::size_t view) const {
  if (colors[view]) return *colors[view];
  if (!frame || frame->scans.empty()) return kByClass;
  const bool second = frame->scans.size() == 1 && view > 0;
  if (!second && options.colors.size() == 1) return options.colors.front();
  const ViewScan& scan = frame->scans[view < frame->scans.size() ? view : 0];
  for (const ColorBy& by : {kByClass, kByIntensity, kByRange}) {
    if (hasColor(scan, by) && !(second && by == colorOf(0))) return by;
  }
  return kByHeight;
}

// Returns the ends of the view's scale. Scans side by side share ends that follow from the values of all, so that they
// can be compared.
std::optional<ScaleRange> ViewSession::State::scaleOf(std::size_t view) {
  if (scales[view]) return scales[view];
  const ColorBy by = colorOf(view);
  if (options.layout != ViewLayout::Split || frame->scans.size() < 2 || !isNumeric(by)) return {};
  if (const auto found = commonScales.find(by); found != commonScales.end()) return found->second;
  std::optional<ScaleRange> common;
  for (std::size_t v = 0; v < viewCount(); ++v) {
    const ViewScan& scan = frame->scans[v];
    if (colorOf(v) != by || !hasColor(scan, by) || scan.scan.size() == 0) continue;
    const Legend own = colorScan(scan.scan, by, contextOf(scan)).legend;
    common = common ? ScaleRange{std::min(common->low, own.low), std::max(common->high, own.high)}
                    : ScaleRange{own.low, own.high};
  }
  if (common) commonScales[by] = *common;
  return common;
}

Coloring ViewSession::State::colored(std::size_t scanIndex, std::size_t view) {
  const ViewScan& scan = frame->scans[scanIndex];
  ColorContext context = contextOf(scan);
  try {
    context.scale = scaleOf(view);
    Coloring out = colorScan(scan.scan, colorOf(view), context);
    out.legend.held = scales[view].has_value();
    return out;
  } catch (const InputError& e) {
    colorProblem = fmt::format("{}: {}", scan.name, e.what());
    if (!columnMissing) columnMissing = colorProblem;
    return colorScan(scan.scan, std::nullopt, contextOf(scan));
  }
}

void ViewSession::State::arrange() {
  const std::size_t before = clouds.size();
  clouds.clear();
  colorProblem.clear();
  columnMissing.reset();
  commonScales.clear();
  if (frame) {
    const std::size_t count = frame->scans.size();
    if (overlaid()) {
      for (std::size_t s = 0; s < count; ++s) clouds.push_back({s, 0, {}, {}, {}, 0, 0});
    } else if (options.layout == ViewLayout::Split && count > 1) {
      for (std::size_t s = 0; s < viewCount(); ++s) clouds.push_back({s, s, {}, {}, {}, 0, 0});
    } else if (count > 0) {
      for (std::size_t v = 0; v < viewCount(); ++v) clouds.push_back({shownScan(), v, {}, {}, {}, 0, 0});
    }
  }
  if (activeView && *activeView >= viewCount()) activeView.reset();
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    ShownCloud& cloud = clouds[k];
    const Scan& scan = frame->scans[cloud.scan].scan;
    if (overlaid()) {
      cloud.coloring.colors.assign(scan.size(), overlayColor(cloud.scan));
    } else {
      cloud.coloring = colored(cloud.scan, cloud.view);
    }
    cloud.finite = static_cast<std::uint64_t>(std::count_if(scan.position.begin(), scan.position.end(), anyFinite));
    if (!classesKnown) notePresent(scan, presentClasses);
    canvas.setPoints(cloudItem(k), scan.position, cloud.coloring.colors);
  }
  for (std::size_t k = clouds.size(); k < before; ++k) canvas.drop(cloudItem(k));
  placeClouds();
  applyFilter();
  placeGuides();
  placeMeshLook();
}

void ViewSession::State::recolor(std::size_t view) {
  if (overlaid()) return;
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    if (clouds[k].view != view) continue;
    clouds[k].coloring = colored(clouds[k].scan, view);
    canvas.setColors(cloudItem(k), clouds[k].coloring.colors);
  }
  itemsChanged = hudChanged = true;
  makeStrip();
}

void ViewSession::State::applyFilter() {
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    ShownCloud& cloud = clouds[k];
    const ViewScan& viewed = frame->scans[cloud.scan];
    const Scan& scan = viewed.scan;
    const bool hiddenWhole = overlaid() && hiddenScans.contains(viewed.name);
    cloud.shown.clear();
    cloud.visible = cloud.finite;
    const bool all = aloneInstances.empty() && (filter.showsAll() || scan[kLabel].empty());
    if (!hiddenWhole && all) {
      canvas.showAll(cloudItem(k));
      continue;
    }
    std::vector<std::uint8_t> classShown(std::size_t{UINT16_MAX} + 1);
    for (std::size_t id = 0; id < classShown.size(); ++id) {
      classShown[id] = filter.shows(static_cast<std::uint16_t>(id)) ? 1 : 0;
    }
    cloud.shown.assign(scan.size(), 0);
    cloud.visible = 0;
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i < scan.size() && !hiddenWhole; ++i) {
      if (!scan[kLabel].empty() && classShown[scan[kLabel][i]] == 0) continue;
      if (!aloneInstances.empty() && (scan[kInstance].empty() || !aloneInstances.contains(scan[kInstance][i])))
        continue;
      cloud.shown[i] = 1;
      indices.push_back(static_cast<std::uint32_t>(i));
      if (isFinite(scan.position[i])) ++cloud.visible;
    }
    canvas.showOnly(cloudItem(k), indices);
  }
  meshShown.clear();
  if (meshItem.there()) {
    if (filter.showsAll() && aloneInstances.empty()) {
      meshItem.showAll();
    } else {
      std::vector<std::uint32_t> indices;
      meshShown.assign(mesh->size(), 0);
      for (std::size_t i = 0; i < mesh->size(); ++i) {
        if (!filter.shows(mesh->semantic[i])) continue;
        if (!aloneInstances.empty() && !aloneInstances.contains(mesh->instance[i])) continue;
        meshShown[i] = 1;
        indices.push_back(static_cast<std::uint32_t>(i));
      }
      meshItem.showOnly(indices);
    }
  }
  placeBoxes();
  instanceProblem.clear();
  for (const std::uint32_t id : aloneInstances) {
    const bool held = std::any_of(clouds.begin(), clouds.end(), [&](const ShownCloud& cloud) {
      const auto& instances = frame->scans[cloud.scan].scan[kInstance];
      return std::find(instances.begin(), instances.end(), id) != instances.end();
    });
    if (!held && !clouds.empty()) instanceProblem += fmt::format("instance {} has no points here. ", id);
  }
  hover.reset();
  itemsChanged = hudChanged = hoverChanged = true;
  makeStrip();
}

std::vector<std::size_t> ViewSession::State::actedViews() const {
  if (activeView) return {*activeView};
  std::vector<std::size_t> all;
  for (std::size_t v = 0; v < viewCount(); ++v) all.push_back(v);
  return all;
}

void ViewSession::State::chooseColor(const ColorBy& by) {
  if (source->isScene()) {
    const auto name = std::find(kMeshColorNames.begin(), kMeshColorNames.end(), by.name());
    if (name != kMeshColorNames.end()) chooseMeshColor(static_cast<MeshColor>(name - kMeshColorNames.begin()));
    return;
  }
  if (clouds.empty()) return;
  if (overlaid()) return say("the overlay has fixed colours: l closes it");
  const auto acted = actedViews();
  for (const std::size_t view : acted) {
    for (const ShownCloud& cloud : clouds) {
      if (cloud.view != view) continue;
      const ViewScan& scan = frame->scans[cloud.scan];
      if (hasColor(scan, by) || scan.scan.size() == 0) continue;
      // colorScan() throws a message that says which column is missing and what to do.
      try {
        colorScan(scan.scan, by, contextOf(scan));
      } catch (const InputError& e) {
        colorProblem = e.what();
      }
      hudChanged = true;
      return;
    }
  }
  colorProblem.clear();
  for (const std::size_t view : acted) {
    if (colorOf(view) != by) scales[view].reset();
    colors[view] = by;
  }
  commonScales.clear();
  const bool common = options.layout == ViewLayout::Split && frame->scans.size() > 1;
  for (std::size_t view = 0; view < viewCount(); ++view) {
    const bool changed = std::find(acted.begin(), acted.end(), view) != acted.end();
    if (changed || (common && isNumeric(colorOf(view)))) recolor(view);
  }
}

void ViewSession::State::changeScale(KeyAction change) {
  if (clouds.empty()) return;
  if (overlaid()) return say("the overlay has fixed colours: l closes it");
  std::string said;
  for (const std::size_t view : actedViews()) {
    const auto cloud = std::find_if(clouds.begin(), clouds.end(), [&](const ShownCloud& c) { return c.view == view; });
    if (cloud == clouds.end() || !cloud->coloring.legend.scale) continue;
    if (change == KeyAction::AutomaticScale) {
      scales[view].reset();
    } else {
      scales[view] = changedScale(cloud->coloring.legend, change);
    }
    recolor(view);
    const Legend& now = cloud->coloring.legend;
    said = fmt::format("{}: {:.3g} to {:.3g}", now.title, now.low, now.high);
  }
  if (said.empty()) return say("these colours have no scale; numbers have one, such as range (4)");
  say(change == KeyAction::AutomaticScale ? said : said + "; \\ takes what the values give");
}

void ViewSession::State::cycleColor(int step) {
  if (source->isScene()) {
    constexpr auto kMeshColors = static_cast<int>(kMeshColorNames.size());
    return chooseMeshColor(static_cast<MeshColor>((static_cast<int>(meshColor) + step + kMeshColors) % kMeshColors));
  }
  if (clouds.empty()) return;
  const std::size_t view = activeView.value_or(0);
  const auto shown = std::find_if(clouds.begin(), clouds.end(), [&](const ShownCloud& c) { return c.view == view; });
  const std::vector<ColorBy> all = colorsOf(frame->scans[shown == clouds.end() ? 0 : shown->scan].scan);
  const auto count = static_cast<std::ptrdiff_t>(all.size());
  std::ptrdiff_t place = std::find(all.begin(), all.end(), colorOf(view)) - all.begin();
  for (std::ptrdiff_t tried = 0; tried < count; ++tried) {
    place = (place + step + count) % count;
    const ColorBy& candidate = all[static_cast<std::size_t>(place)];
    const bool everywhere = std::all_of(clouds.begin(), clouds.end(), [&](const ShownCloud& cloud) {
      return (activeView && cloud.view != *activeView) || hasColor(frame->scans[cloud.scan], candidate);
    });
    if (everywhere) return chooseColor(candidate);
  }
}

void ViewSession::State::makeStrip() {
  strip.reset();
  stripProblem.clear();
  hudChanged = true;
  if (!options.rangeImage || clouds.empty()) return;
  stripCloud = 0;
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    const bool hidden = overlaid() && hiddenScans.contains(frame->scans[clouds[k].scan].name);
    if (hidden && stripCloud == k && k + 1 < clouds.size()) stripCloud = k + 1;
    if (activeView && clouds[k].view == *activeView) stripCloud = k;
  }
  const ShownCloud& cloud = clouds[stripCloud];
  const std::vector<bool> shown(cloud.shown.begin(), cloud.shown.end());
  try {
    const ViewScan& viewed = frame->scans[cloud.scan];
    // In the overlay a scan has a single colour, in which a range image would show nothing.
    const std::vector<Rgb> colored = overlaid() ? stripColors(viewed, contextOf(viewed)) : std::vector<Rgb>{};
    strip = makeRangeStrip(viewed.scan, overlaid() ? colored : cloud.coloring.colors, shown, options.stripOrder,
                           viewed.beams.get());
    toolkit.setImage(kStripImage, strip->image);
  } catch (const InputError& e) {
    stripProblem = e.what();
  }
}

}  // namespace scanmill
