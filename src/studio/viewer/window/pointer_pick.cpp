// Finds the point or the triangle at a pixel, and describes it.

#include <algorithm>

#include "viewer/color_map.h"
#include "viewer/window/picked_rows.h"
#include "viewer/window/pointer.h"

namespace scanmill {

namespace {

constexpr double kReach = 8;  // largest distance of a picked point from the pointer (pixels)

}  // namespace

std::optional<std::size_t> Pointer::viewAt(int px, int py) const {
  for (std::size_t v = 0; v < context_.drawing.views().size(); ++v) {
    if (context_.drawing.views()[v].rect.contains(px, py)) return v;
  }
  return {};
}

PickedThing Pointer::pickedPoint(std::size_t k, std::size_t point) const {
  const ShownCloud& cloud = clouds_.list[k];
  const ViewScan& scan = context_.frame->scans[cloud.scan];
  PickedThing thing = describePoint(scan, cloud.scan, point, context_.source->ontology());
  thing.place = cloud.canvasFromScan * Vec3d(scan.places()[point]);
  addBrief(thing, clouds_.colorOf(cloud.view));
  if (const auto instance = instanceOf(thing)) {
    addInstance(thing, summaryOf(cloud, *instance), context_.source->ontology());
    scenery_.addObjectRows(thing, *instance);
  }
  return thing;
}

PickedThing Pointer::inFull(PickedThing thing) const {
  if (thing.scan == kNoScan || thing.scan >= context_.frame->scans.size()) return thing;
  const ViewScan& own = context_.frame->scans[thing.scan];
  std::vector<std::size_t> others;
  for (const ShownCloud& cloud : clouds_.list) {
    if (cloud.scan == thing.scan || clouds_.isHidden(cloud)) continue;
    if (std::ranges::find(others, cloud.scan) == others.end()) others.push_back(cloud.scan);
  }
  if (others.empty()) return thing;
  thing.rows.insert(thing.rows.begin(), {"scan", wholeName(own, context_.source->title())});
  for (const std::size_t other : others) {
    addSameBeam(thing, own.scan, context_.frame->scans[other], context_.source->ontology());
  }
  return thing;
}

bool Pointer::isShown(const PickedThing& thing) const {
  if (thing.scan == kNoScan) {
    return scenery_.meshItem.there() && thing.point < scenery_.mesh->size() &&
           (scenery_.meshShown.empty() || scenery_.meshShown[thing.point] != 0);
  }
  return std::ranges::any_of(clouds_.list, [&](const ShownCloud& cloud) {
    return cloud.scan == thing.scan && (cloud.shown.empty() || cloud.shown[thing.point] != 0);
  });
}

std::optional<PickedThing> Pointer::pick(int px, int py) const {
  const auto view = viewAt(px, py);
  if (!view) return {};
  const CanvasView& in = context_.drawing.views()[*view];
  const double right = px - in.rect.left + 0.5;  // position of the pixel's middle in the view
  const double down = py - in.rect.top + 0.5;
  std::vector<PickCloud> candidates;
  std::vector<std::size_t> cloudOf;
  for (std::size_t k = 0; k < clouds_.list.size(); ++k) {
    const ShownCloud& cloud = clouds_.list[k];
    if (cloud.view != *view) continue;
    candidates.push_back({context_.frame->scans[cloud.scan].places(), cloud.shown, cloud.canvasFromScan});
    cloudOf.push_back(k);
  }
  if (const auto hit = pickPoint(candidates, in.camera, right, down, scenery_.pointSize(), kReach)) {
    return pickedPoint(cloudOf[hit->cloud], hit->point);
  }
  return scenery_.pickMesh(sightLine(in.camera, right, down));
}

std::optional<PickedThing> Pointer::pickStrip(const PixelRect& rect, int px, int py) const {
  if (!clouds_.strip || !rect.contains(px, py)) return {};
  const auto pixelIn = [](int place, int pixels, int shown) {
    return static_cast<std::size_t>(static_cast<std::int64_t>(place) * pixels / shown);
  };
  const Image& image = clouds_.strip->image;
  const std::size_t index = pixelIn(py - rect.top, image.height, rect.height) * static_cast<std::size_t>(image.width) +
                            pixelIn(px - rect.left, image.width, rect.width);
  const std::uint32_t point = clouds_.strip->pointAt[index];
  if (point == kNoPoint) return {};
  return pickedPoint(clouds_.stripCloud, point);
}

void Pointer::updateHover(bool panels, const std::optional<PixelRect>& strip) {
  context_.changes.hover = false;
  std::optional<PickedThing> found;
  if (drag.button == 0 && x >= 0) {
    if (strip) {
      found = pickStrip(*strip, x, y);
    } else if (!panels) {
      found = pick(x, y);
    }
  }
  const bool same = found.has_value() == hover.has_value() &&
                    (!found || (found->scan == hover->scan && found->point == hover->point && found->scan != kNoScan &&
                                found->place == hover->place && found->brief == hover->brief));
  if (same) return;
  hover = std::move(found);
  context_.changes.panels = true;
}

Rgb Pointer::colorOf(const PickedThing& thing) const {
  for (const ShownCloud& cloud : clouds_.list) {
    if (cloud.scan == thing.scan && thing.point < cloud.coloring.colors.size()) {
      return cloud.coloring.colors[thing.point];
    }
  }
  if (thing.scan == kNoScan && scenery_.mesh && thing.point < scenery_.mesh->size())
    return scenery_.meshColoring.colors[thing.point];
  return kNoValue;
}

std::optional<std::uint32_t> Pointer::instanceOf(const PickedThing& thing) const {
  std::uint32_t id = 0;
  if (thing.scan == kNoScan) {
    if (scenery_.mesh && thing.point < scenery_.mesh->size()) id = scenery_.mesh->instance[thing.point];
  } else if (context_.frame && thing.scan < context_.frame->scans.size()) {
    const Scan& scan = context_.frame->scans[thing.scan].scan;
    if (thing.point < scan[kInstance].size()) id = scan[kInstance][thing.point];
  }
  return id == 0 ? std::nullopt : std::optional(id);
}

// Returns the instance's summary. The last summary is cached, since the pointer often stays on the same instance.
const InstanceSummary& Pointer::summaryOf(const ShownCloud& cloud, std::uint32_t instance) const {
  const InstancePlace place{cloud.scan, instance};
  if (!lastSummary_ || !(lastSummary_->first == place)) {
    const ViewScan& viewed = context_.frame->scans[cloud.scan];
    lastSummary_.emplace(place, summarizeInstance(viewed.scan, viewed.places(), instance, cloud.canvasFromScan));
  }
  return lastSummary_->second;
}

}  // namespace scanmill
