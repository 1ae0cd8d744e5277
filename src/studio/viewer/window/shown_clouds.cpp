#include <fmt/core.h>

#include "viewer/panels/imgui_layer.h"
#include "viewer/picture.h"
#include "viewer/window/canvas_items.h"
#include "viewer/window/scene_view.h"

namespace scanmill {

namespace {

// Adds the class ids of the scan's finite points to `classes`.
void addClasses(const Scan& scan, std::set<std::uint16_t>& classes) {
  std::vector<bool> occurs(std::size_t{UINT16_MAX} + 1, false);  // the indices are class ids
  for (std::size_t i = 0; i < scan[kLabel].size(); ++i) {
    if (isFinite(scan.position[i])) occurs[scan[kLabel][i]] = true;
  }
  for (std::size_t id = 0; id < occurs.size(); ++id) {
    if (occurs[id]) classes.insert(static_cast<std::uint16_t>(id));
  }
}

}  // namespace

ShownClouds::ShownClouds(SessionContext& context) : context_(context) {
  const ViewOptions& options = context_.options;
  for (std::size_t v = 0; v < std::min(options.colors.size(), colors.size()); ++v) colors[v] = options.colors[v];
  for (std::size_t v = 0; v < scales.size(); ++v) {
    if (options.scale && v < options.colors.size() && isNumeric(options.colors[v])) scales[v] = options.scale;
  }
  if (options.scale && options.colors.size() == 1) scales.fill(options.scale);
  for (const std::uint16_t id : context_.source->classes()) presentClasses.insert(id);
  classesKnown_ = !presentClasses.empty();
}

std::size_t ShownClouds::viewCount() const {
  const std::size_t scans = context_.scanCount();
  if (context_.options.layout != ViewLayout::Split || scans == 0) return 1;
  return scans == 1 ? 2 : std::min(scans, kCanvasViews);
}

std::size_t ShownClouds::shownScan() const {
  const auto found = std::ranges::find(context_.frame->scans, scanName, &ViewScan::name);
  return found == context_.frame->scans.end() ? 0 : static_cast<std::size_t>(found - context_.frame->scans.begin());
}

const ShownCloud* ShownClouds::inView(std::size_t view) const {
  const auto found = std::ranges::find(list, view, &ShownCloud::view);
  return found == list.end() ? nullptr : &*found;
}

ColorContext ShownClouds::contextOf(const ViewScan& scan) const {
  return {.ontology = context_.source->ontology(),
          .error = scan.error,
          .errorTitle = scan.errorTitle,
          .whyNoError = scan.whyNoError,
          .closeUp = context_.filter.closeUp};
}

bool ShownClouds::hasColor(const ViewScan& viewed, const ColorBy& by) const {
  return scanmill::hasColor(viewed.scan, by, !viewed.error.empty());
}

// Returns the quantity that the view's colours show: the user's choice, otherwise the first of class, intensity and
// range that the scan has, otherwise the height. The second view of a single scan skips the first view's quantity.
ColorBy ShownClouds::colorOf(std::size_t view) const {
  if (colors[view]) return *colors[view];
  if (context_.scanCount() == 0) return kByClass;
  const bool isSecondOfScan = context_.scanCount() == 1 && view > 0;
  if (!isSecondOfScan && context_.options.colors.size() == 1) return context_.options.colors.front();
  const ViewScan& scan = context_.frame->scans[view < context_.scanCount() ? view : 0];
  for (const ColorBy& by : {kByClass, kByIntensity, kByRange}) {
    if (hasColor(scan, by) && !(isSecondOfScan && by == colorOf(0))) return by;
  }
  return kByHeight;
}

// Returns the ends of the view's scale: the user's choice or, if several scans are side by side, ends that fit all
// scans with the same colouring. Returns nothing if the ends are computed from the view's scan alone.
std::optional<ScaleRange> ShownClouds::scaleOf(std::size_t view) {
  if (scales[view]) return scales[view];
  const ColorBy by = colorOf(view);
  if (context_.options.layout != ViewLayout::Split || context_.scanCount() < 2 || !isNumeric(by)) return {};
  if (const auto found = commonScales_.find(by); found != commonScales_.end()) return found->second;
  std::optional<ScaleRange> common;
  for (std::size_t v = 0; v < viewCount(); ++v) {
    const ViewScan& scan = context_.frame->scans[v];
    if (colorOf(v) != by || !hasColor(scan, by) || scan.scan.size() == 0) continue;
    const Legend legend = colorScan(scan.scan, by, contextOf(scan)).legend;
    common = common ? ScaleRange{std::min(common->low, legend.low), std::max(common->high, legend.high)}
                    : ScaleRange{legend.low, legend.high};
  }
  if (common) commonScales_[by] = *common;
  return common;
}

// Returns the colours of a scan in its view. If the scan lacks the column, returns the default colours, and sets
// `colorProblem` and `columnMissing`.
Coloring ShownClouds::colored(const ShownCloud& cloud) {
  const ViewScan& scan = scanOf(cloud);
  if (scan.coloring) return *scan.coloring;
  ColorContext context = contextOf(scan);
  try {
    context.scale = scaleOf(cloud.view);
    Coloring coloring = colorScan(scan.scan, colorOf(cloud.view), context);
    coloring.legend.endsChosen = scales[cloud.view].has_value();
    return coloring;
  } catch (const InputError& e) {
    colorProblem = fmt::format("{}: {}", scan.name, e.what());
    if (!columnMissing) columnMissing = colorProblem;
    return colorScan(scan.scan, std::nullopt, contextOf(scan));
  }
}

void ShownClouds::arrange() {
  const std::size_t previousClouds = list.size();
  list.clear();
  colorProblem.clear();
  columnMissing.reset();
  commonScales_.clear();
  // All scans are in one view, or one scan in each view, or one scan in all views.
  const std::size_t scans = context_.scanCount();
  const bool splitsScans = context_.options.layout == ViewLayout::Split && scans > 1;
  const std::size_t clouds = scans == 0 ? 0 : overlaid() ? scans : viewCount();
  for (std::size_t k = 0; k < clouds; ++k) {
    list.push_back({.scan = overlaid() || splitsScans ? k : shownScan(), .view = overlaid() ? 0 : k});
  }
  if (activeView && *activeView >= viewCount()) activeView.reset();
  for (std::size_t k = 0; k < list.size(); ++k) {
    ShownCloud& cloud = list[k];
    const Scan& scan = scanOf(cloud).scan;
    if (overlaid()) {
      cloud.coloring.colors.assign(scan.size(), overlayColor(cloud.scan));
    } else {
      cloud.coloring = colored(cloud);
    }
    cloud.finite = static_cast<std::uint64_t>(std::ranges::count_if(scan.position, isFinite<float>));
    if (!classesKnown_) addClasses(scan, presentClasses);
    context_.canvas.set(cloudItem(k), ItemKind::Points, scanOf(cloud).drawnPositions(), cloud.coloring.colors);
  }
  for (std::size_t k = list.size(); k < previousClouds; ++k) context_.canvas.drop(cloudItem(k));
}

void ShownClouds::recolor(std::size_t view) {
  if (overlaid()) return;
  for (std::size_t k = 0; k < list.size(); ++k) {
    if (list[k].view != view) continue;
    list[k].coloring = colored(list[k]);
    context_.canvas.setColors(cloudItem(k), list[k].coloring.colors);
  }
  context_.changes.items = context_.changes.panels = true;
  makeStrip();
}

void ShownClouds::applyFilter() {
  for (std::size_t k = 0; k < list.size(); ++k) context_.canvas.show(cloudItem(k), filtered(list[k]));
  instanceProblem.clear();
  for (const std::uint32_t id : context_.filter.instances) {
    const auto hasInstance = [&](const ShownCloud& cloud) {
      const auto& instances = scanOf(cloud).scan[kInstance];
      return std::ranges::find(instances, id) != instances.end();
    };
    if (!list.empty() && std::ranges::none_of(list, hasInstance)) {
      instanceProblem += fmt::format("instance {} has no points here. ", id);
    }
  }
  context_.changes.items = context_.changes.panels = context_.changes.hover = true;
  makeStrip();
}

// Sets `shown` and `visible` of the cloud. Returns the indices of the shown points; nothing if all are shown.
std::optional<std::vector<std::uint32_t>> ShownClouds::filtered(ShownCloud& cloud) const {
  const ShownFilter& filter = context_.filter;
  const Scan& scan = scanOf(cloud).scan;
  cloud.shown.clear();
  cloud.visible = cloud.finite;
  const bool filtersClasses = !filter.classes.showsAll() && !scan[kLabel].empty();
  if (!isHidden(cloud) && !filtersClasses && filter.instances.empty() && !filter.closeUp) return {};
  std::vector<bool> classShown(std::size_t{UINT16_MAX} + 1);  // the indices are class ids
  for (std::size_t id = 0; id < classShown.size(); ++id) {
    classShown[id] = filter.classes.shows(static_cast<std::uint16_t>(id));
  }
  cloud.shown.assign(scan.size(), 0);
  cloud.visible = 0;
  std::vector<std::uint32_t> indices;
  if (isHidden(cloud)) return indices;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!scan[kLabel].empty() && !classShown[scan[kLabel][i]]) continue;
    if (!filter.showsInstance(scan[kInstance].empty() ? 0 : scan[kInstance][i])) continue;
    if (filter.closeUp && !filter.closeUp->contains(Vec3d(scan.position[i]))) continue;
    cloud.shown[i] = 1;
    indices.push_back(static_cast<std::uint32_t>(i));
    if (isFinite(scan.position[i])) ++cloud.visible;
  }
  return indices;
}

void ShownClouds::chooseColor(const ColorBy& by) {
  if (list.empty()) return;
  if (overlaid()) return context_.notify("the overlay has fixed colours: l closes it");
  for (const ShownCloud& cloud : list) {
    const ViewScan& scan = scanOf(cloud);
    if (!isAffected(cloud.view) || hasColor(scan, by) || scan.scan.size() == 0) continue;
    // colorScan() throws a message that says which column is missing and what to do.
    try {
      colorScan(scan.scan, by, contextOf(scan));
    } catch (const InputError& e) {
      colorProblem = e.what();
    }
    context_.changes.panels = true;
    return;
  }
  colorProblem.clear();
  for (std::size_t view = 0; view < viewCount(); ++view) {
    if (!isAffected(view)) continue;
    if (colorOf(view) != by) scales[view].reset();
    colors[view] = by;
  }
  commonScales_.clear();
  const bool sharesScales = context_.options.layout == ViewLayout::Split && context_.scanCount() > 1;
  for (std::size_t view = 0; view < viewCount(); ++view) {
    if (isAffected(view) || (sharesScales && isNumeric(colorOf(view)))) recolor(view);
  }
}

void ShownClouds::resetScales() {
  if (list.empty()) return;
  if (overlaid()) return context_.notify("the overlay has fixed colours: l closes it");
  const bool hasScale = std::ranges::any_of(
      list, [&](const ShownCloud& cloud) { return isAffected(cloud.view) && isNumeric(colorOf(cloud.view)); });
  if (!hasScale) return context_.notify("these colours have no scale");
  for (std::size_t view = 0; view < viewCount(); ++view) {
    if (!isAffected(view)) continue;
    scales[view].reset();
    recolor(view);
  }
}

void ShownClouds::cycleColor(int step) {
  if (list.empty()) return;
  const std::size_t view = activeView.value_or(0);
  const ShownCloud* const cloud = inView(view);
  const std::vector<ColorBy> quantities = colorsOf(context_.frame->scans[cloud == nullptr ? 0 : cloud->scan].scan);
  const auto count = static_cast<std::ptrdiff_t>(quantities.size());
  std::ptrdiff_t index = std::ranges::find(quantities, colorOf(view)) - quantities.begin();
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    index = (index + step + count) % count;
    const ColorBy& candidate = quantities[static_cast<std::size_t>(index)];
    const bool canShow = std::ranges::all_of(list, [&](const ShownCloud& shown) {
      return !isAffected(shown.view) || hasColor(context_.frame->scans[shown.scan], candidate);
    });
    if (canShow) return chooseColor(candidate);
  }
}

void ShownClouds::makeStrip() {
  strip.reset();
  stripProblem.clear();
  context_.changes.panels = true;
  if (!context_.options.rangeImage || list.empty()) return;
  if (context_.source->samples()) {
    stripProblem = "a map has no range image: M shows the sample, which has one";
    return;
  }
  // Choose the last cloud of the active view, otherwise the first cloud that is not hidden, otherwise the last cloud.
  stripCloud = 0;
  for (std::size_t k = 0; k < list.size(); ++k) {
    if (isHidden(list[k]) && stripCloud == k && k + 1 < list.size()) stripCloud = k + 1;
    if (activeView && list[k].view == *activeView) stripCloud = k;
  }
  const ShownCloud& cloud = list[stripCloud];
  const std::vector<bool> shown(cloud.shown.begin(), cloud.shown.end());
  try {
    const ViewScan& viewed = scanOf(cloud);
    // In the overlay, all points of a scan have the same colour, so the range image shows classes or ranges.
    std::vector<Rgb> overlayColors;
    if (overlaid()) {
      const ColorBy by = viewed.scan[kLabel].empty() ? kByRange : kByClass;
      overlayColors = colorScan(viewed.scan, by, contextOf(viewed)).colors;
    }
    strip = makeRangeStrip(viewed.scan, overlaid() ? overlayColors : cloud.coloring.colors, shown, viewed.beams.get());
    setImage(context_.canvas, kStripImage, strip->image);
  } catch (const InputError& e) {
    stripProblem = e.what();
  }
}

}  // namespace scanmill
