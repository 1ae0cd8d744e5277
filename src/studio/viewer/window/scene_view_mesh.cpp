// Shows the scene's mesh: look, colours, visible triangles, and the triangle at a pixel.

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <functional>

#include "base/short_text.h"
#include "config/resources.h"
#include "config/text.h"
#include "exports/class_map.h"
#include "viewer/color_map.h"
#include "viewer/window/picking.h"
#include "viewer/window/scene_view.h"
#include "viewer/window/session_context.h"

namespace scanmill {

void SceneView::takeMesh(std::shared_ptr<const ViewMesh> loaded) {
  mesh = std::move(loaded);
  meshProblem = mesh ? mesh->problem : "";
  context_.changes.panels = true;
  placeMesh();
}

void SceneView::placeMesh() {
  context_.changes.items = context_.changes.panels = true;
  if (!meshSeen()) {
    meshItem.drop();
    meshShown.clear();
    if (mesh && mesh->size() > 0 && meshOn()) context_.notify("no mesh: the pose of the scan is not known");
    return;
  }
  computeCanvasFrame();
  meshColoring = colorMesh(*mesh, meshColor);
  meshItem.setTriangles(mesh->corners, meshColoring.colors);
  placeMeshLook();
  applyFilter();
  if (!context_.source->isScene()) return;
  placeGuides();
  if (framed_) return;
  framed_ = true;
  setCamera(firstCamera());
  for (const std::string& warning : mesh->warnings) context_.hint(warning);
}

void SceneView::applyFilter() {
  meshShown.clear();
  if (!meshItem.exists()) return;
  const ShownFilter& filter = context_.filter;
  if (filter.classes.showsAll() && filter.instances.empty()) return meshItem.showAll();
  std::vector<std::uint32_t> indices;
  meshShown.assign(mesh->size(), 0);
  for (std::size_t i = 0; i < mesh->size(); ++i) {
    if (!filter.classes.shows(mesh->semantic[i]) || !filter.showsInstance(mesh->instance[i])) continue;
    meshShown[i] = 1;
    indices.push_back(static_cast<std::uint32_t>(i));
  }
  meshItem.showOnly(indices);
}

void SceneView::placeMeshLook() {
  if (!meshItem.exists()) return;
  constexpr double kFaint = 0.25;
  const ItemLook look{.canvasFromItem = canvasFromWorld * Affine{{}, mesh->origin},
                      .opacity = context_.source->isScene() ? 1 : kFaint,
                      .views = (1U << clouds_.viewCount()) - 1};
  meshItem.setLook(look);
  context_.changes.items = true;
}

void SceneView::placeVehicle() {
  const bool known = context_.frame && context_.frame->worldFromVehicle && worldFromAnchor;
  const auto file = known && context_.options.axes ? context_.source->vehicle() : std::nullopt;
  if (!file) return vehicleItem.drop();
  if (!vehicle_) vehicle_ = loadViewMesh(*file, 1, 0, {});
  if (vehicle_->size() == 0) return;
  if (!vehicleItem.exists()) vehicleItem.setTriangles(vehicle_->corners, colorMesh(*vehicle_, MeshColor::Class).colors);
  vehicleItem.setLook(
      {.canvasFromItem = canvasFromWorld * toAffine(*context_.frame->worldFromVehicle) * Affine{{}, vehicle_->origin},
       .views = (1U << clouds_.viewCount()) - 1});
  context_.changes.items = true;
}

void SceneView::chooseMeshColor(MeshColor by) {
  meshColor = by;
  if (!mesh || mesh->size() == 0) return;
  meshColoring = colorMesh(*mesh, meshColor);
  meshItem.setColors(meshColoring.colors);
  context_.changes.items = context_.changes.panels = true;
}

std::optional<PickedElement> SceneView::pickMesh(const SightLine& line) const {
  if (!meshItem.exists()) return {};
  const Affine meshFromCanvas = inverse(canvasFromWorld * Affine{{}, mesh->origin});
  Vec3d origin = meshFromCanvas * line.origin;
  const Vec3d direction = meshFromCanvas.linear * line.direction;
  // Hidden triangles are skipped: the search continues behind them.
  constexpr int kMostLayers = 32;
  constexpr double kBeyond = 1e-4;  // distance behind a hidden triangle at which the search continues (m)
  for (int layer = 0; layer < kMostLayers; ++layer) {
    const auto hit = pickTriangle(*mesh, origin, direction);
    if (!hit) return {};
    const Vec3d spot = origin + direction * hit->distance;
    if (meshShown.empty() || meshShown[hit->triangle] != 0) {
      PickedElement picked = describeTriangle(*mesh, hit->triangle, spot + mesh->origin);
      picked.position = canvasFromWorld * (spot + mesh->origin);
      return picked;
    }
    origin = spot + direction * kBeyond;
  }
  return {};
}

namespace {

constexpr Rgb kUnknownClass{200, 200, 200};
constexpr double kFaint = 0.75;  // fraction of the background in the colour of objects that the sensor does not see
constexpr double kUnseenWithin = 40;    // largest distance (m) of drawn objects that the sensor does not see
constexpr std::size_t kMostNames = 30;  // largest number of objects with a label

}  // namespace

const ObjectView* SceneView::viewOfShownSensor(const ObjectRecord& object) const {
  if (clouds_.list.empty()) return nullptr;
  const std::string sensor = lowerCase(clouds_.scanOf(clouds_.list.front()).sensor);
  for (const ObjectView& view : object.views) {
    if (lowerCase(view.sensor) == sensor) return &view;
  }
  return nullptr;
}

// Returns the pose of the object's box on the canvas. If the sensor has a view of the object, the box is where it was
// when the sensor saw it, so that it fits the points. The view's pose is in the frame of the points of the sensor's
// first revolution. If the points are placed on the canvas, or are those of a later revolution, the pose is computed
// from the object's velocity.
Affine SceneView::canvasFromBox(const ObjectRecord& object) const {
  const ObjectView* const view = viewOfShownSensor(object);
  const ViewScan& scan = clouds_.scanOf(clouds_.list.front());
  if (view != nullptr && scan.placed.empty() && scan.revolution == 0) {
    return clouds_.list.front().canvasFromScan * toAffine(view->sensorFromBox);
  }
  Pose worldFromBox = object.worldFromBox;
  if (view != nullptr) {
    const double time = scan.revolution == 0 ? view->time : scan.time;
    worldFromBox.translation += object.velocity * (time - context_.frame->objectTime);
  }
  return canvasFromWorld * toAffine(worldFromBox);
}

void SceneView::findRoadUsers() {
  roadUsers_.clear();
  const Ontology* const ontology = context_.source->ontology();
  if (ontology == nullptr) return;
  const ClassMap kitti(*ontology, readOntology(namedResource("kitti", "labels")));
  for (const SemanticClass& c : ontology->classes) {
    if (kitti.targetId(c.id) != 0) roadUsers_.insert(c.id);
  }
}

bool SceneView::isBoxShown(const ObjectRecord& object) const {
  if (context_.options.boxes == BoxChoice::None) return false;
  // Instances that the user names are drawn whatever their class.
  const bool roadUsers =
      context_.options.boxes == BoxChoice::RoadUsers && !roadUsers_.empty() && context_.filter.instances.empty();
  if (roadUsers && !roadUsers_.contains(object.semantic)) return false;
  if (const auto& closeUp = context_.filter.closeUp) {
    // The point of the box that is nearest to the middle of the close-up, both in the frame of the box.
    const Vec3d middle = inverse(canvasFromBox(object)) * (clouds_.list.front().canvasFromScan * closeUp->at);
    const Vec3d half = object.size * 0.5;
    const Vec3d nearest{std::clamp(middle.x, -half.x, half.x), std::clamp(middle.y, -half.y, half.y),
                        std::clamp(middle.z, -half.z, half.z)};
    if (length(middle - nearest) > closeUp->within) return false;
  }
  return context_.filter.showsInstance(object.id) && context_.filter.classes.shows(object.semantic);
}

void SceneView::placeBoxes() {
  LineSet lines;
  if (context_.frame && worldFromAnchor && !clouds_.list.empty()) {
    for (const ObjectRecord& object : context_.frame->objects) {
      if (!isBoxShown(object)) continue;
      const SemanticClass* const known =
          context_.source->ontology() == nullptr ? nullptr : context_.source->ontology()->find(object.semantic);
      const Rgb color = known == nullptr ? kUnknownClass : known->color;
      const ObjectView* const view = viewOfShownSensor(object);
      const bool seen = view != nullptr && view->points > 0;
      const Affine place = canvasFromBox(object);
      if (!seen && length(place.translation - clouds_.list.front().canvasFromScan.translation) > kUnseenWithin)
        continue;
      addBox(lines, place, object.size, object.headingKnown,
             seen ? color : mix(color, context_.options.background, kFaint));
      constexpr double kSeconds = 1;  // a moving object gets a line to where its centre is after this time
      if (object.moves) {
        const Vec3d& center = place.translation;
        lines.add(center, center + canvasFromWorld.linear * (object.velocity * kSeconds), color);
      }
    }
  }
  placeInstanceBoxes(lines);
  setLines(kBoxesItem, lines, 1);
  context_.changes.items = context_.changes.panels = true;
}

std::vector<std::pair<const ObjectRecord*, const ObjectView*>> SceneView::nearestSeenObjects() const {
  std::vector<std::pair<const ObjectRecord*, const ObjectView*>> seen;
  if (!context_.frame || !worldFromAnchor || clouds_.list.empty()) return seen;
  for (const ObjectRecord& object : context_.frame->objects) {
    const ObjectView* const view = viewOfShownSensor(object);
    if (view != nullptr && view->points > 0 && isBoxShown(object)) seen.emplace_back(&object, view);
  }
  std::ranges::sort(seen, {}, [](const auto& one) { return length(one.second->sensorFromBox.translation); });
  if (seen.size() > kMostNames) seen.resize(kMostNames);
  return seen;
}

void SceneView::addObjectRows(PickedElement& picked, std::uint32_t instance) const {
  const auto found = std::ranges::find(context_.frame->objects, instance, &ObjectRecord::id);
  if (found == context_.frame->objects.end()) return;
  const ObjectRecord& object = *found;
  const auto add = [&](const char* what, const std::string& value) { picked.rows.emplace_back(what, value); };
  add("object", object.name);
  add("box", fmt::format("{:.2f} x {:.2f} x {:.2f} m{}", object.size.x, object.size.y, object.size.z,
                         object.headingKnown ? "" : ", heading unknown"));
  if (object.moves) add("speed", fmt::format("{:.2f} m/s", length(object.velocity)));
  const std::string& sensor = context_.frame->scans[picked.scan].sensor;
  for (const ObjectView& view : object.views) {
    if (lowerCase(view.sensor) != lowerCase(sensor)) continue;
    add("visible",
        fmt::format("{:.0f} % ({} of {} beams)", 100 * view.visibility().value_or(0), view.beams, view.beamsAlone));
    if (view.truncation > 0) add("out of view", fmt::format("{:.0f} %", 100 * view.truncation));
  }
}

std::uint16_t classOf(const InstanceSummary& instance) {
  return instance.classes.empty() ? std::uint16_t{0} : instance.classes.front().first;
}

const std::vector<InstanceSummary>& SceneView::instances() {
  const ShownCloud& cloud = clouds_.list.front();
  const std::pair<const ViewFrame*, std::size_t> of{context_.frame.get(), cloud.scan};
  if (instancesOf_ != of) {
    const ViewScan& viewed = clouds_.scanOf(cloud);
    instances_ = summarizeInstances(viewed.scan, viewed.drawnPositions(), cloud.canvasFromScan);
    instancesOf_ = of;
  }
  return instances_;
}

// Adds the smallest upright box around each instance's points, in the colour of the instance's most frequent class.
void SceneView::placeInstanceBoxes(LineSet& lines) {
  if (!instanceBoxes || clouds_.list.empty() || !context_.frame->objects.empty()) return;
  for (const InstanceSummary& instance : instances()) {
    const std::uint16_t semantic = classOf(instance);
    if (!context_.filter.showsInstance(instance.id) || !context_.filter.classes.shows(semantic)) continue;
    addBox(lines, instance.levelFromBox, instance.size, false, classColor(context_.source->ontology(), semantic));
  }
}

Coloring colorMesh(const ViewMesh& mesh, MeshColor by) {
  Coloring out;
  const auto painted = [&](const auto& idOf, const auto& colorOf) {
    return paint(
        mesh.size(), idOf, colorOf, [](std::size_t) { return true; }, out.colors);
  };
  // Colours by the names that surfaces refer to by `which`; names[i] has the colour instanceColor(first + i). The most
  // frequent name comes first in the legend; rules keep their order.
  const auto byName = [&](const std::vector<std::string>& names, std::uint32_t ViewSurface::*which,
                          std::uint32_t first) {
    const auto id = [&](std::size_t t) { return mesh.surfaceOf(t).*which; };
    for (const auto& [i, held] : painted(id, [&](std::uint32_t name) { return instanceColor(first + name); })) {
      out.legend.entries.push_back({names[i], held.color, -1, held.count});
    }
    if (by != MeshColor::Rule) std::ranges::stable_sort(out.legend.entries, std::greater<>(), &LegendEntry::points);
  };
  switch (by) {
    case MeshColor::Class: {
      const auto color = [&](std::uint32_t id) { return classColor(&mesh.ontology, static_cast<std::uint16_t>(id)); };
      out.legend = classLegend(painted([&](std::size_t t) { return mesh.semantic[t]; }, color), &mesh.ontology);
      break;
    }
    case MeshColor::Instance:
      out.legend = instanceLegend(painted([&](std::size_t t) { return mesh.instance[t]; }, instanceColor));
      break;
    case MeshColor::Object:
      painted([&](std::size_t t) { return mesh.surfaceOf(t).part + 1; }, instanceColor);
      if (mesh.parts.empty()) break;
      out.legend.entries.push_back(
          {pluralOf(mesh.parts.size(), "object") + ", a colour each", instanceColor(1), -1, mesh.size()});
      break;
    case MeshColor::Material:
      byName(mesh.materials, &ViewSurface::material, 1);
      break;
    case MeshColor::Texture:
      byName(mesh.textures, &ViewSurface::texture, 0);
      break;
    case MeshColor::Rule:
      byName(mesh.rules, &ViewSurface::rule, 0);
      break;
    case MeshColor::Reflectance:
      for (std::size_t t = 0; t < mesh.size(); ++t) {
        out.colors.push_back(viridis(double{mesh.reflectance[mesh.surfaceOf(t).material]}));
      }
      out.legend.scale = true;
      out.legend.high = 1;
      break;
  }
  out.legend.title = std::string(kMeshColorNames[static_cast<std::size_t>(by)]);
  return out;
}

}  // namespace scanmill
