// Finds the point or the triangle under the pointer.

#include <algorithm>

#include "viewer/window/picked_rows.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

constexpr double kReach = 8;  // px, greatest distance of a picked point from the pointer

}  // namespace

std::optional<std::size_t> ViewSession::State::viewAt(int x, int y) const {
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (views[v].rect.contains(x, y)) return v;
  }
  return {};
}

PickedThing ViewSession::State::pickedPoint(std::size_t k, std::size_t point) const {
  const ShownCloud& cloud = clouds[k];
  const ViewScan& scan = frame->scans[cloud.scan];
  PickedThing thing = describePoint(scan, cloud.scan, point, source->ontology());
  thing.place = cloud.canvasFromScan * Vec3d(scan.scan.position[point]);
  addBrief(thing, colorOf(cloud.view));
  if (const auto instance = instanceOf(thing)) {
    addInstance(thing, summaryOf(cloud, *instance), source->ontology());
    addObjectRows(thing, *instance);
  }
  return thing;
}

// Adds the returns of the same beam in the other scans that are shown.
PickedThing ViewSession::State::inFull(PickedThing thing) const {
  if (thing.scan == kNoScan || thing.scan >= frame->scans.size()) return thing;
  const ViewScan& own = frame->scans[thing.scan];
  std::vector<std::size_t> others;
  for (const ShownCloud& cloud : clouds) {
    const bool hidden = overlaid() && hiddenScans.contains(frame->scans[cloud.scan].name);
    if (cloud.scan == thing.scan || hidden || std::find(others.begin(), others.end(), cloud.scan) != others.end()) {
      continue;
    }
    others.push_back(cloud.scan);
  }
  if (others.empty()) return thing;
  thing.rows.insert(thing.rows.begin(), {"scan", wholeName(own, source->title())});
  for (const std::size_t other : others) {
    addSameBeam(thing, own.scan, frame->scans[other], source->ontology());
  }
  return thing;
}

// True if the point or triangle is not hidden and its scan is shown.
bool ViewSession::State::isShown(const PickedThing& thing) const {
  if (thing.scan == kNoScan) {
    return meshItem.there() && thing.point < mesh->size() && (meshShown.empty() || meshShown[thing.point] != 0);
  }
  return std::any_of(clouds.begin(), clouds.end(), [&](const ShownCloud& cloud) {
    return cloud.scan == thing.scan && (cloud.shown.empty() || cloud.shown[thing.point] != 0);
  });
}

std::optional<PickedThing> ViewSession::State::pick(int x, int y) const {
  const auto view = viewAt(x, y);
  if (!view) return {};
  const CanvasView& in = views[*view];
  const double px = x - in.rect.left + 0.5;  // the pixel's middle
  const double py = y - in.rect.top + 0.5;
  std::vector<PickCloud> candidates;
  std::vector<std::size_t> cloudOf;
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    if (clouds[k].view != *view) continue;
    candidates.push_back({frame->scans[clouds[k].scan].scan.position, clouds[k].shown, clouds[k].canvasFromScan});
    cloudOf.push_back(k);
  }
  if (const auto hit = pickPoint(candidates, in.camera, px, py, pointSize(), kReach)) {
    return pickedPoint(cloudOf[hit->cloud], hit->point);
  }
  return pickMesh(sightLine(in.camera, px, py));
}

std::optional<PickedThing> ViewSession::State::pickMesh(const SightLine& line) const {
  if (!meshItem.there()) return {};
  const Affine meshFromCanvas = inverse(canvasFromWorld * Affine{{}, mesh->origin});
  Vec3d origin = meshFromCanvas * line.origin;
  const Vec3d direction = meshFromCanvas.linear * line.direction;
  // The line of sight passes through hidden triangles.
  constexpr int kMostLayers = 32;
  constexpr double kBeyond = 1e-4;  // m: the next search starts this far behind a hidden triangle
  for (int layer = 0; layer < kMostLayers; ++layer) {
    const auto hit = pickTriangle(*mesh, origin, direction);
    if (!hit) return {};
    const Vec3d spot = origin + direction * hit->distance;
    if (meshShown.empty() || meshShown[hit->triangle] != 0) {
      PickedThing thing = describeTriangle(*mesh, hit->triangle, spot + mesh->origin);
      thing.place = canvasFromWorld * (spot + mesh->origin);
      return thing;
    }
    origin = spot + direction * kBeyond;
  }
  return {};
}

std::optional<PickedThing> ViewSession::State::pickStrip(int x, int y) const {
  if (!strip) return {};
  const PixelRect rect = stripRect();
  if (!rect.contains(x, y)) return {};
  const auto pixelIn = [](int place, int pixels, int shown) {
    return static_cast<std::size_t>(static_cast<std::int64_t>(place) * pixels / shown);
  };
  const Image& image = strip->image;
  const std::size_t index = pixelIn(y - rect.top, image.height, rect.height) * static_cast<std::size_t>(image.width) +
                            pixelIn(x - rect.left, image.width, rect.width);
  const std::uint32_t point = strip->pointAt[index];
  if (point == kNoPoint) return {};
  return pickedPoint(stripCloud, point);
}

void ViewSession::State::updateHover() {
  hoverChanged = false;
  std::optional<PickedThing> found;
  if (drag.button == 0 && pointerX >= 0 && !help) {
    if (overStrip) {
      found = pickStrip(pointerX, pointerY);
    } else if (!toolkit.hasPointer()) {
      found = pick(pointerX, pointerY);
    }
  }
  const bool same = found.has_value() == hover.has_value() &&
                    (!found || (found->scan == hover->scan && found->point == hover->point && found->scan != kNoScan &&
                                found->place == hover->place && found->brief == hover->brief));
  if (same) return;
  hover = std::move(found);
  hudChanged = true;
}

}  // namespace scanmill
