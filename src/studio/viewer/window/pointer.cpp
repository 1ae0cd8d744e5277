#include "viewer/window/pointer.h"

namespace scanmill {

namespace {

constexpr Rgb kMeasureColor{255, 240, 90};

constexpr double kReach = 8;  // largest distance of a picked point from the pointer (pixels)

// Returns the drawn positions of all returns of a point's beam, the nearest first; nothing if beams have one return.
std::vector<Vec3f> returnsOf(const ViewScan& viewed, std::size_t point) {
  const Scan& scan = viewed.scan;
  if (!knowsBeams(scan) || (scan.organised ? scan.planes < 2 : scan[kReturn].empty())) return {};
  const PointKey beam = keyOf(scan, point);
  std::vector<std::size_t> returns;  // indices of points
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const PointKey key = keyOf(scan, i);
    if (key.ring == beam.ring && key.column == beam.column && isFinite(scan.position[i])) returns.push_back(i);
  }
  std::ranges::sort(returns, {}, [&](std::size_t i) { return length(Vec3d(scan.position[i])); });
  std::vector<Vec3f> positions;
  positions.reserve(returns.size());
  for (const std::size_t i : returns) positions.push_back(viewed.drawnPositions()[i]);
  return positions;
}

}  // namespace

Pointer::Pointer(SessionContext& context, const ShownClouds& clouds, SceneView& sceneView)
    : context_(context), clouds_(clouds), sceneView_(sceneView) {}

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
  drag = {.button = event.button,
          .pan = event.button != 1 || event.shift,
          .downX = event.x,
          .downY = event.y,
          .x = event.x,
          .y = event.y};
}

void Pointer::moveTo(const CanvasEvent& event) {
  constexpr int kStill = 3;  // largest distance (pixels) that the pointer moves during a click
  x = event.x;
  y = event.y;
  context_.changes.hover = true;
  lastMove_ = context_.redraw.now();
  if (drag.button == 0) return;
  drag.moved = drag.moved || std::abs(event.x - drag.downX) > kStill || std::abs(event.y - drag.downY) > kStill;
  if (!drag.moved || context_.redraw.views().empty()) return;
  const int right = event.x - drag.x;  // motion since the last event (pixels)
  const int down = event.y - drag.y;
  drag.x = event.x;
  drag.y = event.y;
  const PixelRect& rect = context_.redraw.views()[viewAt(drag.downX, drag.downY).value_or(0)].rect;
  sceneView_.changeCamera([&](OrbitCamera& camera) {
    drag.pan ? camera.pan(right, down, rect.width, rect.height) : camera.orbit(right, down, rect.height);
  });
}

void Pointer::release(const CanvasEvent& event) {
  if (event.button != drag.button) return;
  const bool isClick = drag.button == 1 && !drag.moved;
  drag = {};
  x = event.x;
  y = event.y;
  context_.changes.hover = true;
  if (isClick) click();
}

// Selects the point or triangle under the pointer or, while measuring, adds its position to `ends`.
void Pointer::click() {
  auto picked = pick(x, y);
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

void Pointer::lookAt(const Vec3d& position) {
  sceneView_.changeCamera([&](OrbitCamera& camera) { camera.lookAt(position); });
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

PickedElement Pointer::pickedPoint(std::size_t cloudIndex, std::size_t point) const {
  const ShownCloud& cloud = clouds_.list[cloudIndex];
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
  if (!picked.isPoint() || picked.scan >= context_.frame->scans.size()) return picked;
  const ViewScan& pickedScan = context_.frame->scans[picked.scan];
  std::vector<std::size_t> otherScans;
  for (const ShownCloud& cloud : clouds_.list) {
    if (cloud.scan == picked.scan || clouds_.isHidden(cloud)) continue;
    if (std::ranges::find(otherScans, cloud.scan) == otherScans.end()) otherScans.push_back(cloud.scan);
  }
  if (otherScans.empty()) return picked;
  picked.rows.insert(picked.rows.begin(), {"scan", fullName(pickedScan, context_.source->title())});
  for (const std::size_t scan : otherScans) {
    addSameBeam(picked, pickedScan.scan, context_.frame->scans[scan], context_.source->ontology());
  }
  return picked;
}

bool Pointer::isShown(const PickedElement& picked) const {
  if (!picked.isPoint()) {
    return sceneView_.meshPlaced && picked.point < sceneView_.mesh->size() &&
           (sceneView_.meshShown.empty() || sceneView_.meshShown[picked.point] != 0);
  }
  return std::ranges::any_of(clouds_.list, [&](const ShownCloud& cloud) {
    return cloud.scan == picked.scan && (cloud.shown.empty() || cloud.shown[picked.point] != 0);
  });
}

std::optional<PickedElement> Pointer::pick(int px, int py) const {
  const auto viewIndex = viewAt(px, py);
  if (!viewIndex) return {};
  const CanvasView& view = context_.redraw.views()[*viewIndex];
  const double right = px - view.rect.left + 0.5;  // position of the pixel's middle in the view
  const double down = py - view.rect.top + 0.5;
  std::vector<PickCloud> candidates(clouds_.list.size());  // without points for clouds in other views
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const ShownCloud& cloud = clouds_.list[k];
    if (cloud.view == *viewIndex)
      candidates[k] = {clouds_.scanOf(cloud).drawnPositions(), cloud.shown, cloud.canvasFromScan};
  }
  if (const auto hit = pickPoint(candidates, view.camera, right, down, sceneView_.pointSize(), kReach)) {
    return pickedPoint(hit->cloud, hit->point);
  }
  return sceneView_.pickMesh(sightLine(view.camera, right, down));
}

std::optional<PickedElement> Pointer::pickStrip(const PixelRect& rect) const {
  if (!clouds_.strip || !rect.contains(x, y)) return {};
  // Returns the row or column of the image that is `offset` pixels from the edge of the rectangle.
  const auto imagePixel = [](int offset, int imagePixels, int rectPixels) {
    return static_cast<std::size_t>(static_cast<std::int64_t>(offset) * imagePixels / rectPixels);
  };
  const Image& image = clouds_.strip->image;
  const std::size_t row = imagePixel(y - rect.top, image.height, rect.height);
  const std::size_t column = imagePixel(x - rect.left, image.width, rect.width);
  const std::uint32_t point = clouds_.strip->pointAt[row * static_cast<std::size_t>(image.width) + column];
  if (point == kNoPoint) return {};
  return pickedPoint(clouds_.stripCloud, point);
}

void Pointer::updateHover(bool isOverPanel, const std::optional<PixelRect>& strip) {
  context_.changes.hover = false;
  std::optional<PickedElement> picked;
  if (drag.button == 0 && x >= 0) {
    if (strip) {
      picked = pickStrip(*strip);
    } else if (!isOverPanel) {
      picked = pick(x, y);
    }
  }
  // True for the same point; false for triangles, since the position on a triangle changes with each move.
  const auto isSamePoint = [](const PickedElement& a, const PickedElement& b) {
    return a.isPoint() && a.scan == b.scan && a.point == b.point && a.position == b.position && a.brief == b.brief;
  };
  if (picked && hover ? isSamePoint(*picked, *hover) : !picked && !hover) return;
  hover = std::move(picked);
  context_.changes.panels = true;
}

Rgb Pointer::colorOf(const PickedElement& picked) const {
  for (const ShownCloud& cloud : clouds_.list) {
    if (cloud.scan == picked.scan && picked.point < cloud.coloring.colors.size()) {
      return cloud.coloring.colors[picked.point];
    }
  }
  if (!picked.isPoint() && sceneView_.mesh && picked.point < sceneView_.mesh->size())
    return sceneView_.meshColoring.colors[picked.point];
  return kNoValue;
}

std::optional<std::uint32_t> Pointer::instanceOf(const PickedElement& picked) const {
  std::uint32_t id = 0;
  if (!picked.isPoint()) {
    if (sceneView_.mesh && picked.point < sceneView_.mesh->size()) id = sceneView_.mesh->instance[picked.point];
  } else if (context_.frame && picked.scan < context_.frame->scans.size()) {
    const Scan& scan = context_.frame->scans[picked.scan].scan;
    if (picked.point < scan[kInstance].size()) id = scan[kInstance][picked.point];
  }
  return id == 0 ? std::nullopt : std::optional(id);
}

// Returns the instance's summary. The last summary is cached, since the pointer often stays on the same instance.
const InstanceSummary& Pointer::summaryOf(const ShownCloud& cloud, std::uint32_t instance) const {
  const InstanceRef key{cloud.scan, instance};
  if (!lastSummary_ || !(lastSummary_->first == key)) {
    const ViewScan& viewed = clouds_.scanOf(cloud);
    auto found = summarizeInstances(viewed.scan, viewed.drawnPositions(), cloud.canvasFromScan, instance);
    lastSummary_.emplace(key, found.empty() ? InstanceSummary{} : std::move(found.front()));
  }
  return lastSummary_->second;
}

// Outlines the hovered or clicked instance: draws its points again in white, larger and slightly farther away.
void Pointer::highlightInstance() {
  constexpr double kRest = 0.15;  // time without a move after which the pointer is at rest (s)
  const PickedElement* const picked = hoveredOrPinned();
  std::optional<InstanceRef> pickedInstance;
  auto cloud = clouds_.list.end();  // a cloud with the instance
  if (picked != nullptr && picked->isPoint()) {
    cloud = std::ranges::find(clouds_.list, picked->scan, &ShownCloud::scan);
    const auto id = instanceOf(*picked);
    if (cloud != clouds_.list.end() && id) pickedInstance = InstanceRef{picked->scan, *id};
  }
  if (pickedInstance == highlighted_ && !context_.changes.items) {
    if (highlighted_ && context_.changes.views) placeOutline(*cloud);
    return;
  }
  // If drawing takes long, do not draw again for every point that the moving pointer passes.
  const bool isMoving = context_.redraw.now() - lastMove_ < kRest;
  if (!context_.changes.items && context_.redraw.isSlow() && isMoving) return;
  highlighted_ = pickedInstance;
  context_.changes.highlight = true;
  if (!highlighted_) return context_.canvas.drop(kHighlightItem);
  setOutlinePoints(*cloud);
  placeOutline(*cloud);
}

// Outlines the shown points of the instance `highlighted_`.
void Pointer::setOutlinePoints(const ShownCloud& cloud) {
  std::vector<Vec3f> points;
  const std::vector<Vec3f>& positions = clouds_.scanOf(cloud).drawnPositions();
  for (const std::uint32_t i : summaryOf(cloud, highlighted_->id).points) {
    if (!cloud.shown.empty() && cloud.shown[i] == 0) continue;
    points.push_back(Vec3f(cloud.canvasFromScan * Vec3d(positions[i])));
  }
  context_.canvas.set(kHighlightItem, ItemKind::Points, points, std::vector<Rgb>(points.size(), Rgb{255, 255, 255}));
}

// Places the outline behind the points, as seen by the camera.
void Pointer::placeOutline(const ShownCloud& cloud) {
  constexpr double kEdge = 1.5;      // width of the outline (pixels)
  constexpr double kFarther = 1.03;  // distance of the outline from the eye divided by the points' distance
  constexpr double kBehind = 0.2;    // distance of the outline behind the points for an orthographic camera (m)
  if (context_.redraw.views().empty()) return;
  ItemLook look{.views = 0};
  for (const ShownCloud& shownCloud : clouds_.list) {
    if (shownCloud.scan == cloud.scan) look.views |= 1U << shownCloud.view;
  }
  look.size = sceneView_.pointSize() + 2 * kEdge;
  const ViewCamera& camera = context_.redraw.views().front().camera;  // all views have the same eye
  if (camera.orthographic) {
    look.canvasFromItem.translation = camera.forward * kBehind;
  } else {
    look.canvasFromItem.linear = {{kFarther, 0, 0}, {0, kFarther, 0}, {0, 0, kFarther}};
    look.canvasFromItem.translation = camera.eye * (1 - kFarther);
  }
  context_.canvas.setLook(kHighlightItem, look);
}

void Pointer::placeBeam() {
  constexpr Rgb kBeamColor{255, 220, 80};
  const PickedElement* const picked = hoveredOrPinned();
  std::optional<ScanPoint> point;
  if (picked != nullptr && picked->isPoint()) point = ScanPoint{picked->scan, picked->point};
  if (point == beamPoint_ && !context_.changes.items) return;  // the beam is the same; searching for returns is slow
  beamPoint_ = point;
  LineSet lines;
  const auto cloud = std::ranges::find_if(clouds_.list, [&](const auto& c) { return point && c.scan == point->scan; });
  if (cloud != clouds_.list.end()) {
    const std::vector<Vec3f> returns = returnsOf(clouds_.scanOf(*cloud), point->point);
    for (std::size_t i = 0; i + 1 < returns.size(); ++i) {
      lines.add(cloud->canvasFromScan * Vec3d(returns[i]), cloud->canvasFromScan * Vec3d(returns[i + 1]), kBeamColor);
    }
  }
  if (lines.colors.empty() && !beamDrawn_) return;
  beamDrawn_ = !lines.colors.empty();
  sceneView_.setLines(kBeamItem, lines, 2);
  context_.changes.highlight = true;
}

}  // namespace scanmill
