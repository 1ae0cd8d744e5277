// Draws the outline of the instance and the line of the beam to which the point under the pointer belongs.

#include <algorithm>

#include "viewer/window/guides.h"
#include "viewer/window/pointer.h"

namespace scanmill {

namespace {

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
  for (const std::size_t i : all) places.push_back(viewed.places()[i]);
  return places;
}

}  // namespace

// Outlines the instance under the pointer: draws its points again in white, larger and slightly farther away.
void Pointer::lightInstance() {
  constexpr double kRest = 0.15;  // time without a move after which the pointer is at rest (s)
  const PickedThing* const thing = shown();
  std::optional<InstancePlace> wanted;
  const ShownCloud* cloud = nullptr;
  if (thing != nullptr && thing->scan != kNoScan) {
    const auto found = std::ranges::find(clouds_.list, thing->scan, &ShownCloud::scan);
    const auto id = instanceOf(*thing);
    if (found != clouds_.list.end() && id) {
      cloud = &*found;
      wanted = InstancePlace{thing->scan, *id};
    }
  }
  if (wanted == lit_ && !context_.changes.items) {
    if (lit_ && context_.changes.views) outline(*cloud, false);
    return;
  }
  // If drawing takes long, do not draw again for every point that the moving pointer passes.
  const bool moves = context_.drawing.now() - lastMove_ < kRest;
  if (!context_.changes.items && context_.drawing.slow() && moves) return;
  lit_ = wanted;
  context_.changes.light = true;
  if (!lit_) return litItem_.drop();
  outline(*cloud, true);
}

// Places the outline of the instance `lit_` behind its points. `anew`: the points have changed.
void Pointer::outline(const ShownCloud& cloud, bool anew) {
  constexpr double kEdge = 1.5;      // width of the outline (pixels)
  constexpr double kFarther = 1.03;  // distance of the outline from the eye divided by the points' distance
  constexpr double kBehind = 0.2;    // distance of the outline behind the points for an orthographic camera (m)
  if (context_.drawing.views().empty()) return;
  if (anew) {
    std::vector<Vec3f> places;
    const std::vector<Vec3f>& all = context_.frame->scans[cloud.scan].places();
    for (const std::uint32_t i : summaryOf(cloud, lit_->id).points) {
      if (!cloud.shown.empty() && cloud.shown[i] == 0) continue;
      places.push_back(Vec3f(cloud.canvasFromScan * Vec3d(all[i])));
    }
    litItem_.setPoints(places, std::vector<Rgb>(places.size(), Rgb{255, 255, 255}));
  }
  ItemLook look{.views = 0};
  for (const ShownCloud& same : clouds_.list) {
    if (same.scan == cloud.scan) look.views |= 1U << same.view;
  }
  look.size = scenery_.pointSize() + 2 * kEdge;
  const ViewCamera& seenBy = context_.drawing.views().front().camera;  // all views have the same eye
  if (seenBy.orthographic) {
    look.canvasFromItem.translation = seenBy.forward * kBehind;
  } else {
    look.canvasFromItem.linear = {{kFarther, 0, 0}, {0, kFarther, 0}, {0, 0, kFarther}};
    look.canvasFromItem.translation = seenBy.eye * (1 - kFarther);
  }
  litItem_.setLook(look);
}

void Pointer::placeBeam() {
  const PickedThing* const thing = shown();
  std::optional<std::pair<std::size_t, std::size_t>> beam;
  if (thing != nullptr && thing->scan != kNoScan) beam.emplace(thing->scan, thing->point);
  if (beam == beamOf_ && !context_.changes.items) return;  // the beam is the same; searching for returns is slow
  beamOf_ = beam;
  constexpr Rgb kBeam{255, 220, 80};
  LineSet lines;
  for (const ShownCloud& cloud : clouds_.list) {
    if (!beam || cloud.scan != beam->first) continue;
    const std::vector<Vec3f> places = returnsOf(context_.frame->scans[cloud.scan], beam->second);
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      lines.add(cloud.canvasFromScan * Vec3d(places[i]), cloud.canvasFromScan * Vec3d(places[i + 1]), kBeam);
    }
    break;
  }
  if (lines.colors.empty() && !beamDrawn_) return;
  beamDrawn_ = !lines.colors.empty();
  scenery_.setLines(kBeamItem, lines, 2);
  context_.changes.light = true;
}

}  // namespace scanmill
