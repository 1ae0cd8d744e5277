// Describes the point that is under the pointer or was clicked, and highlights its instance.

#include <algorithm>

#include "viewer/color_map.h"
#include "viewer/window/session_state.h"

namespace scanmill {

Rgb ViewSession::State::colorOf(const PickedThing& thing) const {
  for (const ShownCloud& cloud : clouds) {
    if (cloud.scan == thing.scan && thing.point < cloud.coloring.colors.size()) {
      return cloud.coloring.colors[thing.point];
    }
  }
  if (thing.scan == kNoScan && mesh && thing.point < mesh->size()) return meshColoring.colors[thing.point];
  return kNoValue;
}

std::optional<std::uint32_t> ViewSession::State::instanceOf(const PickedThing& thing) const {
  std::uint32_t id = 0;
  if (thing.scan == kNoScan) {
    if (mesh && thing.point < mesh->size()) id = mesh->instance[thing.point];
  } else if (frame && thing.scan < frame->scans.size()) {
    const Scan& scan = frame->scans[thing.scan].scan;
    if (thing.point < scan[kInstance].size()) id = scan[kInstance][thing.point];
  }
  return id == 0 ? std::nullopt : std::optional(id);
}

// Returns the instance's summary. The last summary is cached, since the pointer mostly stays on an instance for a
// while.
const InstanceSummary& ViewSession::State::summaryOf(const ShownCloud& cloud, std::uint32_t instance) const {
  const InstancePlace place{cloud.scan, instance};
  if (!lastSummary || !(lastSummary->first == place)) {
    lastSummary.emplace(place, summarizeInstance(frame->scans[cloud.scan].scan, instance, cloud.canvasFromScan));
  }
  return lastSummary->second;
}

// Highlights the instance under the pointer, or else the clicked one: draws its points once more in white, larger and a
// little farther away, as an outline.
void ViewSession::State::lightInstance() {
  constexpr double kQuick = 0.05;  // s: if a picture of all points takes longer, highlighting waits for the pointer
  constexpr double kRest = 0.15;   // s: the pointer rests if it has not moved for so long
  const std::optional<PickedThing>& thing = hover ? hover : pinned;
  std::optional<InstancePlace> wantedLight;
  const ShownCloud* cloud = nullptr;
  if (thing && thing->scan != kNoScan) {
    const auto shown = std::find_if(clouds.begin(), clouds.end(),
                                    [&](const ShownCloud& candidate) { return candidate.scan == thing->scan; });
    const auto id = instanceOf(*thing);
    if (shown != clouds.end() && id) {
      cloud = &*shown;
      wantedLight = InstancePlace{thing->scan, *id};
    }
  }
  if (wantedLight == lit && !itemsChanged) {
    if (lit && viewsChanged) edge(litItem, litPoints, false);
    return;
  }
  // Do not draw a large scan again for every point that the pointer passes.
  const bool moves = clock.seconds() - lastMove < kRest;
  if (!itemsChanged && wholeSeconds > kQuick && moves) return;
  lit = wantedLight;
  lightChanged = true;
  litPoints.clear();
  if (!lit) return litItem.drop();
  std::vector<std::uint32_t>& points = litPoints[lit->scan];
  points = summaryOf(*cloud, lit->id).points;
  std::erase_if(points, [&](std::uint32_t i) { return !cloud->shown.empty() && cloud->shown[i] == 0; });
  edge(litItem, litPoints, true);
}

// Draws the points once more, larger and a little farther away.
void ViewSession::State::edge(CanvasItem& item, const PointsOfScans& points, bool anew) {
  constexpr double kEdge = 1.5;      // px, width of the outline
  constexpr double kFarther = 1.03;  // factor of the distance from the eye
  constexpr double kBehind = 0.2;    // m, distance behind the points for an orthographic camera
  if (views.empty()) return;
  std::vector<Vec3f> places;
  ItemLook look;
  look.views = 0;
  look.size = pointSize() + 2 * kEdge;
  for (const auto& [scan, own] : points) {
    const ShownCloud* placed = nullptr;
    for (const ShownCloud& cloud : clouds) {
      if (cloud.scan != scan) continue;
      placed = &cloud;
      look.views |= 1U << cloud.view;
    }
    if (placed == nullptr || !anew) continue;
    const std::vector<Vec3f>& all = frame->scans[scan].scan.position;
    for (const std::uint32_t i : own) places.push_back(Vec3f(placed->canvasFromScan * Vec3d(all[i])));
  }
  if (anew) item.setPoints(places, std::vector<Rgb>(places.size(), Rgb{255, 255, 255}));
  const ViewCamera& seenBy = views.front().camera;  // all views have the same eye
  if (seenBy.orthographic) {
    look.canvasFromItem.translation = seenBy.forward * kBehind;
  } else {
    look.canvasFromItem.linear = {{kFarther, 0, 0}, {0, kFarther, 0}, {0, 0, kFarther}};
    look.canvasFromItem.translation = seenBy.eye * (1 - kFarther);
  }
  item.setLook(look);
}

}  // namespace scanmill
