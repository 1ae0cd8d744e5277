#include "viewer/window/pointer.h"

#include <algorithm>

#include "viewer/color_map.h"
#include "viewer/window/picking.h"

namespace scanmill {

namespace {

constexpr Rgb kMeasureColor{255, 240, 90};

constexpr double kReach = 8;  // largest distance of a picked point from the pointer (pixels)

// Returns the points of a point's beam, the nearest first; nothing if no beam of the scan can have several points.
std::vector<Vec3f> returnsOf(const ViewScan& viewed, std::size_t point) {
  const Scan& scan = viewed.scan;
  if (!knowsBeams(scan) || (scan.organised ? scan.planes < 2 : scan[kReturn].empty())) return {};
  const PointKey own = keyOf(scan, point);
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const PointKey key = keyOf(scan, i);
    if (key.ring == own.ring && key.column == own.column && isFinite(scan.position[i])) {
      all.push_back(i);
    }
  }
  std::ranges::sort(all, {}, [&](std::size_t i) { return length(Vec3d(scan.position[i])); });
  std::vector<Vec3f> places;
  for (const std::size_t i : all) places.push_back(viewed.drawnPositions()[i]);
  return places;
}

}  // namespace

Pointer::Pointer(SessionContext& context, const ShownClouds& clouds, SceneView& sceneView)
    : context_(context), clouds_(clouds), sceneView_(sceneView), highlightItem_(context.canvas, kHighlightItem) {}

void Pointer::leaveFrame() {
  hover.reset();
  pinned.reset();
  lastSummary_.reset();
  ends.clear();
  measuring = false;
}

void Pointer::moveBy(const Affine& newFromOld) {
  for (Vec3d& end : ends) end = newFromOld * end;
  if (pinned) pinned->position = newFromOld * pinned->position;
  hover.reset();
  placeMeasure();
}

void Pointer::press(const CanvasEvent& event) {
  x = event.x;
  y = event.y;
  drag = {};
  if (!viewAt(event.x, event.y)) return;
  if (event.button == 1 && event.clicks == 2) return turnAbout();
  drag.button = event.button;
  drag.pan = event.button != 1 || event.shift;
  drag.downX = drag.x = event.x;
  drag.downY = drag.y = event.y;
}

void Pointer::moveTo(const CanvasEvent& event) {
  constexpr int kStill = 3;  // largest distance (pixels) that the pointer moves during a click
  x = event.x;
  y = event.y;
  context_.changes.hover = true;
  lastMove_ = context_.redraw.now();
  if (drag.button == 0) return;
  const int right = event.x - drag.x;
  const int down = event.y - drag.y;
  drag.moved = drag.moved || std::abs(event.x - drag.downX) > kStill || std::abs(event.y - drag.downY) > kStill;
  if (!drag.moved || context_.redraw.views().empty()) return;
  drag.x = event.x;
  drag.y = event.y;
  const PixelRect& rect = context_.redraw.views()[viewAt(drag.downX, drag.downY).value_or(0)].rect;
  OrbitCamera turned = sceneView_.camera;
  if (drag.pan) {
    turned.pan(right, down, rect.width, rect.height);
  } else {
    turned.orbit(right, down, rect.height);
  }
  sceneView_.setCamera(turned);
}

void Pointer::release(const CanvasEvent& event) {
  if (event.button != drag.button) return;
  const PointerDrag was = drag;
  drag = {};
  x = event.x;
  y = event.y;
  context_.changes.hover = true;
  if (was.button == 1 && !was.moved) click(event.x, event.y);
}

void Pointer::click(int px, int py) {
  auto picked = pick(px, py);
  context_.changes.panels = true;
  if (!measuring) {
    pinned.reset();
    if (picked) pinned = withOtherScans(std::move(*picked));
    return;
  }
  if (!picked) return context_.notify("nothing lies there");
  ends.push_back(picked->position);
  measuring = ends.size() < 2;
  placeMeasure();
}

void Pointer::toggleMeasuring() {
  const bool start = !measuring && ends.empty();
  ends.clear();
  measuring = start;
  if (start && pinned) ends.push_back(pinned->position);
  placeMeasure();
}

void Pointer::turnAbout() {
  auto picked = x >= 0 ? pick(x, y) : std::nullopt;
  if (!picked) picked = pinned;
  if (!picked) return context_.notify("nothing lies there");
  lookAt(picked->position);
}

void Pointer::lookAt(const Vec3d& place) {
  OrbitCamera turned = sceneView_.camera;
  turned.lookAt(place);
  sceneView_.setCamera(turned);
}

void Pointer::placeMeasure() {
  LineSet line;
  if (ends.size() == 2) line.add(ends[0], ends[1], kMeasureColor);
  sceneView_.setLines(kMeasureItem, line, 2);
  context_.changes.items = context_.changes.panels = true;
}

std::optional<std::size_t> Pointer::viewAt(int px, int py) const {
  for (std::size_t v = 0; v < context_.redraw.views().size(); ++v) {
    if (context_.redraw.views()[v].rect.contains(px, py)) return v;
  }
  return {};
}

PickedElement Pointer::pickedPoint(std::size_t k, std::size_t point) const {
  const ShownCloud& cloud = clouds_.list[k];
  const ViewScan& scan = clouds_.scanOf(cloud);
  PickedElement picked = describePoint(scan, cloud.scan, point, context_.source->ontology());
  picked.position = cloud.canvasFromScan * Vec3d(scan.drawnPositions()[point]);
  addBrief(picked, scan, clouds_.colorOf(cloud.view));
  if (const auto instance = instanceOf(picked)) {
    addInstance(picked, summaryOf(cloud, *instance), context_.source->ontology());
    sceneView_.addObjectRows(picked, *instance);
  }
  return picked;
}

PickedElement Pointer::withOtherScans(PickedElement picked) const {
  if (picked.scan == kNoScan || picked.scan >= context_.frame->scans.size()) return picked;
  const ViewScan& own = context_.frame->scans[picked.scan];
  std::vector<std::size_t> others;
  for (const ShownCloud& cloud : clouds_.list) {
    if (cloud.scan == picked.scan || clouds_.isHidden(cloud)) continue;
    if (std::ranges::find(others, cloud.scan) == others.end()) others.push_back(cloud.scan);
  }
  if (others.empty()) return picked;
  picked.rows.insert(picked.rows.begin(), {"scan", fullName(own, context_.source->title())});
  for (const std::size_t other : others) {
    addSameBeam(picked, own.scan, context_.frame->scans[other], context_.source->ontology());
  }
  return picked;
}

bool Pointer::isShown(const PickedElement& picked) const {
  if (picked.scan == kNoScan) {
    return sceneView_.meshItem.exists() && picked.point < sceneView_.mesh->size() &&
           (sceneView_.meshShown.empty() || sceneView_.meshShown[picked.point] != 0);
  }
  return std::ranges::any_of(clouds_.list, [&](const ShownCloud& cloud) {
    return cloud.scan == picked.scan && (cloud.shown.empty() || cloud.shown[picked.point] != 0);
  });
}

std::optional<PickedElement> Pointer::pick(int px, int py) const {
  const auto view = viewAt(px, py);
  if (!view) return {};
  const CanvasView& in = context_.redraw.views()[*view];
  const double right = px - in.rect.left + 0.5;  // position of the pixel's middle in the view
  const double down = py - in.rect.top + 0.5;
  std::vector<PickCloud> candidates;
  std::vector<std::size_t> cloudOf;
  for (std::size_t k = 0; k < clouds_.list.size(); ++k) {
    const ShownCloud& cloud = clouds_.list[k];
    if (cloud.view != *view) continue;
    candidates.push_back({clouds_.scanOf(cloud).drawnPositions(), cloud.shown, cloud.canvasFromScan});
    cloudOf.push_back(k);
  }
  if (const auto hit = pickPoint(candidates, in.camera, right, down, sceneView_.pointSize(), kReach)) {
    return pickedPoint(cloudOf[hit->cloud], hit->point);
  }
  return sceneView_.pickMesh(sightLine(in.camera, right, down));
}

std::optional<PickedElement> Pointer::pickStrip(const PixelRect& rect, int px, int py) const {
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
  std::optional<PickedElement> found;
  if (drag.button == 0 && x >= 0) {
    if (strip) {
      found = pickStrip(*strip, x, y);
    } else if (!panels) {
      found = pick(x, y);
    }
  }
  const bool same = found.has_value() == hover.has_value() &&
                    (!found || (found->scan == hover->scan && found->point == hover->point && found->scan != kNoScan &&
                                found->position == hover->position && found->brief == hover->brief));
  if (same) return;
  hover = std::move(found);
  context_.changes.panels = true;
}

Rgb Pointer::colorOf(const PickedElement& picked) const {
  for (const ShownCloud& cloud : clouds_.list) {
    if (cloud.scan == picked.scan && picked.point < cloud.coloring.colors.size()) {
      return cloud.coloring.colors[picked.point];
    }
  }
  if (picked.scan == kNoScan && sceneView_.mesh && picked.point < sceneView_.mesh->size())
    return sceneView_.meshColoring.colors[picked.point];
  return kNoValue;
}

std::optional<std::uint32_t> Pointer::instanceOf(const PickedElement& picked) const {
  std::uint32_t id = 0;
  if (picked.scan == kNoScan) {
    if (sceneView_.mesh && picked.point < sceneView_.mesh->size()) id = sceneView_.mesh->instance[picked.point];
  } else if (context_.frame && picked.scan < context_.frame->scans.size()) {
    const Scan& scan = context_.frame->scans[picked.scan].scan;
    if (picked.point < scan[kInstance].size()) id = scan[kInstance][picked.point];
  }
  return id == 0 ? std::nullopt : std::optional(id);
}

// Returns the instance's summary. The last summary is cached, since the pointer often stays on the same instance.
const InstanceSummary& Pointer::summaryOf(const ShownCloud& cloud, std::uint32_t instance) const {
  const InstanceRef place{cloud.scan, instance};
  if (!lastSummary_ || !(lastSummary_->first == place)) {
    const ViewScan& viewed = clouds_.scanOf(cloud);
    lastSummary_.emplace(place,
                         summarizeInstance(viewed.scan, viewed.drawnPositions(), instance, cloud.canvasFromScan));
  }
  return lastSummary_->second;
}

// Outlines the instance under the pointer: draws its points again in white, larger and slightly farther away.
void Pointer::highlightInstance() {
  constexpr double kRest = 0.15;  // time without a move after which the pointer is at rest (s)
  const PickedElement* const picked = shown();
  std::optional<InstanceRef> wanted;
  const ShownCloud* cloud = nullptr;
  if (picked != nullptr && picked->scan != kNoScan) {
    const auto found = std::ranges::find(clouds_.list, picked->scan, &ShownCloud::scan);
    const auto id = instanceOf(*picked);
    if (found != clouds_.list.end() && id) {
      cloud = &*found;
      wanted = InstanceRef{picked->scan, *id};
    }
  }
  if (wanted == highlighted_ && !context_.changes.items) {
    if (highlighted_ && context_.changes.views) placeOutline(*cloud);
    return;
  }
  // If drawing takes long, do not draw again for every point that the moving pointer passes.
  const bool moves = context_.redraw.now() - lastMove_ < kRest;
  if (!context_.changes.items && context_.redraw.slow() && moves) return;
  highlighted_ = wanted;
  context_.changes.highlight = true;
  if (!highlighted_) return highlightItem_.drop();
  setOutlinePoints(*cloud);
  placeOutline(*cloud);
}

// Outlines the shown points of the instance `highlighted_`.
void Pointer::setOutlinePoints(const ShownCloud& cloud) {
  std::vector<Vec3f> points;
  const std::vector<Vec3f>& all = clouds_.scanOf(cloud).drawnPositions();
  for (const std::uint32_t i : summaryOf(cloud, highlighted_->id).points) {
    if (!cloud.shown.empty() && cloud.shown[i] == 0) continue;
    points.push_back(Vec3f(cloud.canvasFromScan * Vec3d(all[i])));
  }
  highlightItem_.setPoints(points, std::vector<Rgb>(points.size(), Rgb{255, 255, 255}));
}

// Places the outline behind the points, as seen by the camera.
void Pointer::placeOutline(const ShownCloud& cloud) {
  constexpr double kEdge = 1.5;      // width of the outline (pixels)
  constexpr double kFarther = 1.03;  // distance of the outline from the eye divided by the points' distance
  constexpr double kBehind = 0.2;    // distance of the outline behind the points for an orthographic camera (m)
  if (context_.redraw.views().empty()) return;
  ItemLook look{.views = 0};
  for (const ShownCloud& same : clouds_.list) {
    if (same.scan == cloud.scan) look.views |= 1U << same.view;
  }
  look.size = sceneView_.pointSize() + 2 * kEdge;
  const ViewCamera& seenBy = context_.redraw.views().front().camera;  // all views have the same eye
  if (seenBy.orthographic) {
    look.canvasFromItem.translation = seenBy.forward * kBehind;
  } else {
    look.canvasFromItem.linear = {{kFarther, 0, 0}, {0, kFarther, 0}, {0, 0, kFarther}};
    look.canvasFromItem.translation = seenBy.eye * (1 - kFarther);
  }
  highlightItem_.setLook(look);
}

void Pointer::placeBeam() {
  const PickedElement* const picked = shown();
  std::optional<std::pair<std::size_t, std::size_t>> beam;
  if (picked != nullptr && picked->scan != kNoScan) beam.emplace(picked->scan, picked->point);
  if (beam == beamOf_ && !context_.changes.items) return;  // the beam is the same; searching for returns is slow
  beamOf_ = beam;
  constexpr Rgb kBeam{255, 220, 80};
  LineSet lines;
  for (const ShownCloud& cloud : clouds_.list) {
    if (!beam || cloud.scan != beam->first) continue;
    const std::vector<Vec3f> places = returnsOf(clouds_.scanOf(cloud), beam->second);
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      lines.add(cloud.canvasFromScan * Vec3d(places[i]), cloud.canvasFromScan * Vec3d(places[i + 1]), kBeam);
    }
    break;
  }
  if (lines.colors.empty() && !beamDrawn_) return;
  beamDrawn_ = !lines.colors.empty();
  sceneView_.setLines(kBeamItem, lines, 2);
  context_.changes.highlight = true;
}

}  // namespace scanmill
