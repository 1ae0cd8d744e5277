// Boxes and tracks of the objects that a sample lists.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "dataset/sample_names.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

constexpr Rgb kUnknownClass{200, 200, 200};
constexpr double kFaint = 0.75;         // share of the background in the colour of objects that the sensor does not see
constexpr double kUnseenWithin = 40;    // m, from the sensor: boxes of unseen objects farther away are left out
constexpr std::size_t kMostNames = 30;  // greatest number of labels

}  // namespace

const ObjectView* ViewSession::State::shownView(const ObjectRecord& object) const {
  if (clouds.empty()) return nullptr;
  const std::string sensor = lowerCase(frame->scans[clouds.front().scan].sensor);
  for (const ObjectView& view : object.views) {
    if (lowerCase(view.sensor) == sensor) return &view;
  }
  return nullptr;
}

// Returns the pose of the object's box: relative to the scan if its sensor has a view of the object, so that the box
// fits the points; else in the world.
Affine ViewSession::State::canvasFromBox(const ObjectRecord& object) const {
  const ObjectView* const view = shownView(object);
  if (view != nullptr) return clouds.front().canvasFromScan * toAffine(view->sensorFromBox);
  return canvasFromWorld * toAffine(object.worldFromBox);
}

bool ViewSession::State::boxShown(const ObjectRecord& object) const {
  if (!aloneInstances.empty() && !aloneInstances.contains(object.id)) return false;
  return filter.shows(object.semantic);
}

void ViewSession::State::placeBoxes() {
  LineSet lines;
  if (options.boxes && frame && worldFromAnchor && !clouds.empty()) {
    for (const auto& [object, track] : frame->objects) {
      if (!boxShown(object)) continue;
      const SemanticClass* const known =
          source->ontology() == nullptr ? nullptr : source->ontology()->find(object.semantic);
      const Rgb color = known == nullptr ? kUnknownClass : Rgb{known->color[0], known->color[1], known->color[2]};
      const ObjectView* const view = shownView(object);
      const bool seen = view != nullptr && view->points > 0;
      const Affine place = canvasFromBox(object);
      if (!seen && length(place.translation - clouds.front().canvasFromScan.translation) > kUnseenWithin) continue;
      addBox(lines, place, object.size, object.headingKnown, seen ? color : mix(color, options.background, kFaint));
      for (std::size_t i = 0; i + 1 < track.size(); ++i) {
        lines.add(canvasFromWorld * track[i], canvasFromWorld * track[i + 1], color);
      }
    }
  }
  placeInstanceBoxes(lines);
  setLines(kBoxesItem, lines, 1);
  itemsChanged = hudChanged = true;
}

// Labels the nearest objects that the sensor sees with class, id and the share (%) that is not occluded.
void ViewSession::State::addBoxLabels() {
  if (!options.boxes || !frame || !worldFromAnchor || clouds.empty()) return;
  std::vector<std::tuple<double, const ObjectRecord*, const ObjectView*>> seen;
  for (const auto& [object, track] : frame->objects) {
    const ObjectView* const view = shownView(object);
    if (view == nullptr || view->points == 0 || !boxShown(object)) continue;
    seen.emplace_back(length(view->sensorFromBox.translation), &object, view);
  }
  std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return std::get<0>(a) < std::get<0>(b); });
  if (seen.size() > kMostNames) seen.resize(kMostNames);
  for (const auto& [distance, object, view] : seen) {
    addLabel(canvasFromBox(*object) * Vec3d{0, 0, object->size.z / 2},
             fmt::format("{} {}, {:.0f} %", className(source->ontology(), object->semantic), object->id,
                         100 * view->visibility().value_or(0)),
             false);
  }
}

void ViewSession::State::addObjectRows(PickedThing& thing, std::uint32_t instance) const {
  const auto found = std::find_if(frame->objects.begin(), frame->objects.end(),
                                  [&](const ViewObject& o) { return o.record.id == instance; });
  if (found == frame->objects.end()) return;
  const ObjectRecord& object = found->record;
  const auto add = [&](const char* what, const std::string& value) { thing.rows.emplace_back(what, value); };
  add("object", object.name);
  add("box", fmt::format("{:.2f} x {:.2f} x {:.2f} m{}", object.size.x, object.size.y, object.size.z,
                         object.headingKnown ? "" : ", heading unknown"));
  if (object.moves) add("speed", fmt::format("{:.2f} m/s", length(object.velocity)));
  const std::string& sensor = frame->scans[thing.scan].sensor;
  for (const ObjectView& view : object.views) {
    if (lowerCase(view.sensor) != lowerCase(sensor)) continue;
    add("visible",
        fmt::format("{:.0f} % ({} of {} beams)", 100 * view.visibility().value_or(0), view.beams, view.beamsAlone));
    if (view.truncation > 0) add("out of view", fmt::format("{:.0f} %", 100 * view.truncation));
  }
}

}  // namespace scanmill
