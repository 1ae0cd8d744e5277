// Shows the scene's mesh: look, colours, visible triangles, and the triangle at a pixel.

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "base/short_text.h"
#include "config/resources.h"
#include "config/text.h"
#include "viewer/window/scene_view.h"

namespace scanmill {

void SceneView::takeMesh(std::shared_ptr<const ViewMesh> loaded) {
  mesh = std::move(loaded);
  meshProblem = mesh ? mesh->problem : "";
  placeMesh();
}

void SceneView::placeMesh() {
  context_.changes.items = context_.changes.panels = true;
  meshPlaced = isMeshVisible();
  if (!meshPlaced) {
    context_.canvas.drop(kMeshItem);
    meshShown.clear();
    if (mesh && mesh->size() > 0 && isMeshOn()) context_.notify("no mesh: the pose of the scan is not known");
    return;
  }
  computeCanvasFrame();
  meshColoring = colorMesh(*mesh, meshColor);
  context_.canvas.set(kMeshItem, ItemKind::Triangles, mesh->corners, meshColoring.colors);
  placeMeshLook();
  applyFilter();
  if (!context_.source->isScene()) return;
  placeGuides();
  if (isFitted) return;
  isFitted = true;
  setCamera(firstCamera());
  for (const std::string& warning : mesh->warnings) context_.hint(warning);
}

void SceneView::applyFilter() {
  meshShown.clear();
  if (!meshPlaced) return;
  const ShownFilter& filter = context_.filter;
  if (filter.classes.showsAll() && filter.instances.empty()) return context_.canvas.show(kMeshItem, {});
  std::vector<std::uint32_t> indices;
  meshShown.assign(mesh->size(), 0);
  for (std::size_t i = 0; i < mesh->size(); ++i) {
    if (!filter.classes.shows(mesh->semantic[i]) || !filter.showsInstance(mesh->instance[i])) continue;
    meshShown[i] = 1;
    indices.push_back(static_cast<std::uint32_t>(i));
  }
  context_.canvas.show(kMeshItem, std::move(indices));
}

void SceneView::placeMeshLook() {
  if (!meshPlaced) return;
  constexpr double kOpacityWithScans = 0.25;
  context_.canvas.setLook(kMeshItem, {.canvasFromItem = canvasFromWorld * Affine{{}, mesh->origin},
                                      .opacity = context_.source->isScene() ? 1 : kOpacityWithScans,
                                      .views = allViews()});
  context_.changes.items = true;
}

void SceneView::placeVehicle() {
  Canvas& canvas = context_.canvas;
  const bool isPoseKnown = context_.frame && context_.frame->worldFromVehicle && worldFromAnchor;
  const auto file = isPoseKnown && context_.options.axes ? context_.source->vehicle() : std::nullopt;
  if (file && !vehicle_) vehicle_ = loadViewMesh({.file = *file});
  const bool places = file && vehicle_->size() > 0;
  if (places && !vehiclePlaced_) {
    canvas.set(kVehicleItem, ItemKind::Triangles, vehicle_->corners, colorMesh(*vehicle_, MeshColor::Class).colors);
  }
  vehiclePlaced_ = places;
  if (!places) return canvas.drop(kVehicleItem);
  const Affine canvasFromVehicle = canvasFromWorld * toAffine(*context_.frame->worldFromVehicle);
  canvas.setLook(kVehicleItem,
                 {.canvasFromItem = canvasFromVehicle * Affine{{}, vehicle_->origin}, .views = allViews()});
  context_.changes.items = true;
}

void SceneView::chooseMeshColor(MeshColor by) {
  meshColor = by;
  if (!mesh || mesh->size() == 0) return;
  meshColoring = colorMesh(*mesh, meshColor);
  if (meshPlaced) context_.canvas.setColors(kMeshItem, meshColoring.colors);
  context_.changes.items = context_.changes.panels = true;
}

std::optional<PickedElement> SceneView::pickMesh(const SightLine& line) const {
  if (!meshPlaced) return {};
  const Affine meshFromCanvas = inverse(canvasFromWorld * Affine{{}, mesh->origin});
  Vec3d origin = meshFromCanvas * line.origin;
  const Vec3d direction = meshFromCanvas.linear * line.direction;
  // Hidden triangles are skipped: the search continues behind them.
  constexpr int kMostLayers = 32;
  constexpr double kBeyond = 1e-4;  // distance behind a hidden triangle at which the search continues (m)
  for (int layer = 0; layer < kMostLayers; ++layer) {
    const auto hit = pickTriangle(*mesh, origin, direction);
    if (!hit) return {};
    const Vec3d position = origin + direction * hit->distance;  // relative to mesh->origin
    if (meshShown.empty() || meshShown[hit->triangle] != 0) {
      PickedElement picked = describeTriangle(*mesh, hit->triangle, position + mesh->origin);
      picked.position = canvasFromWorld * (position + mesh->origin);
      return picked;
    }
    origin = position + direction * kBeyond;
  }
  return {};
}

namespace {

constexpr Rgb kUnknownClass{200, 200, 200};
// The sensor sees no point of an unseen object.
constexpr double kUnseenShare = 0.75;   // fraction of the background in the colour of unseen objects
constexpr double kUnseenWithin = 40;    // largest distance (m) of drawn unseen objects
constexpr std::size_t kMostNames = 30;  // largest number of objects with a label

// Returns the object's view from a sensor; null if there is none.
const ObjectView* viewOf(const ObjectRecord& object, const std::string& sensor) {
  const auto found = std::ranges::find_if(
      object.views, [&](const ObjectView& view) { return lowerCase(view.sensor) == lowerCase(sensor); });
  return found == object.views.end() ? nullptr : &*found;
}

}  // namespace

const ObjectView* SceneView::viewOfShownSensor(const ObjectRecord& object) const {
  if (clouds_.list.empty()) return nullptr;
  return viewOf(object, clouds_.scanOf(clouds_.list.front()).sensor);
}

// Returns the pose of the object's box on the canvas. If the sensor has a view of the object, the box is where the
// object was when the sensor saw it, so that the box fits the points; otherwise it has the recorded pose. At least one
// cloud must be shown.
Affine SceneView::canvasFromBox(const ObjectRecord& object) const {
  Pose worldFromBox = object.worldFromBox;
  if (const ObjectView* const view = viewOfShownSensor(object)) {
    const ShownCloud& cloud = clouds_.list.front();
    const ViewScan& scan = clouds_.scanOf(cloud);
    // The view's pose is in the frame of Scan::position of the first revolution. Points that are drawn at
    // ViewScan::placed or are of a later revolution are in other frames, so the recorded pose is extrapolated.
    if (scan.placed.empty() && scan.revolution == 0) return cloud.canvasFromScan * toAffine(view->sensorFromBox);
    const double time = scan.revolution == 0 ? view->time : scan.time;
    worldFromBox.translation += object.velocity * (time - context_.frame->objectTime);
  }
  return canvasFromWorld * toAffine(worldFromBox);
}

// Sets `roadUsers_`: the ontology's classes of road users.
void SceneView::findRoadUsers() {
  const Ontology* const ontology = context_.source->ontology();
  if (ontology == nullptr) return;
  for (const SemanticClass& c : ontology->classes) {
    if (c.roadUser) roadUsers_.insert(c.id);
  }
}

// True if the options and the filter show the object's box.
bool SceneView::isBoxShown(const ObjectRecord& object) const {
  if (context_.options.boxes == BoxChoice::None) return false;
  // Instances that the user names are drawn even if they are no road users.
  const bool onlyRoadUsers =
      context_.options.boxes == BoxChoice::RoadUsers && !roadUsers_.empty() && context_.filter.instances.empty();
  if (onlyRoadUsers && !roadUsers_.contains(object.semantic)) return false;
  if (const auto& closeUp = context_.filter.closeUp) {
    const Affine boxFromScan = inverse(canvasFromBox(object)) * clouds_.list.front().canvasFromScan;
    const Box box{object.size * -0.5, object.size * 0.5};  // in its own frame
    if (box.distanceTo(boxFromScan * closeUp->center) > closeUp->radius) return false;
  }
  return context_.filter.showsInstance(object.id) && context_.filter.classes.shows(object.semantic);
}

void SceneView::placeBoxes() {
  LineSet lines;
  if (context_.frame && worldFromAnchor && !clouds_.list.empty()) {
    for (const ObjectRecord& object : context_.frame->objects) {
      if (isBoxShown(object)) addObjectBox(lines, object);
    }
  }
  if (instanceBoxes && !clouds_.list.empty() && context_.frame->objects.empty()) {
    // The smallest upright box around each instance's points, in the colour of the instance's most frequent class.
    for (const InstanceSummary& instance : instances()) {
      const std::uint16_t semantic = classOf(instance);
      if (!context_.filter.showsInstance(instance.id) || !context_.filter.classes.shows(semantic)) continue;
      addBox(lines, instance.levelFromBox, instance.size, classColor(context_.source->ontology(), semantic));
    }
  }
  setLines(kBoxesItem, lines, 1);
  context_.changes.items = context_.changes.panels = true;
}

// Adds the box of an object: paler if the sensor does not see the object; no box if the object is also far away.
void SceneView::addObjectBox(LineSet& lines, const ObjectRecord& object) const {
  const Ontology* const ontology = context_.source->ontology();
  const SemanticClass* const found = ontology == nullptr ? nullptr : ontology->find(object.semantic);
  const Rgb fullColor = found == nullptr ? kUnknownClass : found->color;
  const ObjectView* const view = viewOfShownSensor(object);
  const bool isSeen = view != nullptr && view->points > 0;
  const Affine box = canvasFromBox(object);
  if (!isSeen && length(box.translation - clouds_.list.front().canvasFromScan.translation) > kUnseenWithin) return;
  const Rgb color = isSeen ? fullColor : mix(fullColor, context_.options.background, kUnseenShare);
  addBox(lines, box, object.size, color);
  if (object.headingKnown) {  // a line ahead from the middle of the front's lower edge
    const Vec3d start{object.size.x / 2, 0, -object.size.z / 2};
    lines.add(box * start, box * (start + Vec3d{std::max(0.5, object.size.x / 4), 0, 0}), color);
  }
  constexpr double kSeconds = 1;  // a moving object gets a line to its centre's position after this time (s)
  if (!object.moves) return;
  const Vec3d& center = box.translation;
  lines.add(center, center + canvasFromWorld.linear * (object.velocity * kSeconds), fullColor);
}

std::vector<std::pair<const ObjectRecord*, const ObjectView*>> SceneView::nearestSeenObjects() const {
  std::vector<std::pair<const ObjectRecord*, const ObjectView*>> seen;
  if (!context_.frame || !worldFromAnchor || clouds_.list.empty()) return seen;
  for (const ObjectRecord& object : context_.frame->objects) {
    const ObjectView* const view = viewOfShownSensor(object);
    if (view != nullptr && view->points > 0 && isBoxShown(object)) seen.emplace_back(&object, view);
  }
  std::ranges::sort(seen, {}, [](const auto& entry) { return length(entry.second->sensorFromBox.translation); });
  if (seen.size() > kMostNames) seen.resize(kMostNames);
  return seen;
}

void SceneView::addObjectRows(PickedElement& picked, std::uint32_t instance) const {
  const auto object = std::ranges::find(context_.frame->objects, instance, &ObjectRecord::id);
  if (object == context_.frame->objects.end()) return;
  NamedValues& rows = picked.rows;
  rows.emplace_back("object", object->name);
  rows.emplace_back("box", fmt::format("{:.2f} x {:.2f} x {:.2f} m{}", object->size.x, object->size.y, object->size.z,
                                       object->headingKnown ? "" : ", heading unknown"));
  if (object->moves) rows.emplace_back("speed", fmt::format("{:.2f} m/s", length(object->velocity)));
  const ObjectView* const view = viewOf(*object, context_.frame->scans[picked.scan].sensor);
  if (view == nullptr) return;
  rows.emplace_back("visible", fmt::format("{:.0f} % ({} of {} beams)", 100 * view->visibility().value_or(0),
                                           view->beams, view->beamsAlone));
  if (view->truncation > 0) rows.emplace_back("out of view", fmt::format("{:.0f} %", 100 * view->truncation));
}

std::uint16_t classOf(const InstanceSummary& instance) {
  return instance.classes.empty() ? std::uint16_t{0} : instance.classes.front().first;
}

const std::vector<InstanceSummary>& SceneView::instances() {
  const ShownCloud& cloud = clouds_.list.front();
  const std::pair<const ViewFrame*, std::size_t> frameAndScan{context_.frame.get(), cloud.scan};
  if (summarized_ != frameAndScan) {
    const ViewScan& viewed = clouds_.scanOf(cloud);
    instances_ = summarizeInstances(viewed.scan, viewed.drawnPositions(), cloud.canvasFromScan);
    summarized_ = frameAndScan;
  }
  return instances_;
}

std::string whyNoMeshColor(const ColorBy& by) {
  if (std::ranges::find(kMeshColorNames, by.name()) != kMeshColorNames.end()) return {};
  return fmt::format("a scene has no {}: it is coloured by {}", by.name(), fmt::join(kMeshColorNames, ", "));
}

Coloring colorMesh(const ViewMesh& mesh, MeshColor by) {
  Coloring out;
  // Adds the colours of all triangles. idOf(triangle) returns the triangle's id, colorOf(id) the id's colour.
  const auto addColors = [&](const auto& idOf, const auto& colorOf) {
    return paint(
        mesh.size(), idOf, colorOf, [](std::size_t) { return true; }, out.colors);
  };
  // Colours triangles by name and fills the legend. `index`: member of ViewSurface with the index of the triangle's
  // name in `names`; names[i] has the colour instanceColor(firstColor + i). The most frequent name comes first in the
  // legend; rules keep their order.
  const auto addByName = [&](const std::vector<std::string>& names, std::uint32_t ViewSurface::*index,
                             std::uint32_t firstColor) {
    const auto nameOf = [&](std::size_t triangle) { return mesh.surfaceOf(triangle).*index; };
    const auto colorOf = [&](std::uint32_t name) { return instanceColor(firstColor + name); };
    for (const auto& [name, triangles] : addColors(nameOf, colorOf)) {
      out.legend.entries.push_back({.name = names[name], .color = triangles.color, .points = triangles.count});
    }
    if (by != MeshColor::Rule) std::ranges::stable_sort(out.legend.entries, std::greater<>(), &LegendEntry::points);
  };
  switch (by) {
    case MeshColor::Class: {
      const auto color = [&](std::uint32_t id) { return classColor(&mesh.ontology, static_cast<std::uint16_t>(id)); };
      out.legend = classLegend(addColors([&](std::size_t t) { return mesh.semantic[t]; }, color), &mesh.ontology);
      break;
    }
    case MeshColor::Instance:
      out.legend = instanceLegend(addColors([&](std::size_t t) { return mesh.instance[t]; }, instanceColor));
      break;
    case MeshColor::Object:
      addColors([&](std::size_t t) { return mesh.surfaceOf(t).part + 1; }, instanceColor);
      if (mesh.parts.empty()) break;
      out.legend.entries.push_back({.name = pluralOf(mesh.parts.size(), "object") + ", a colour each",
                                    .color = instanceColor(1),
                                    .points = mesh.size()});
      break;
    case MeshColor::Material:
      addByName(mesh.materials, &ViewSurface::material, 1);
      break;
    case MeshColor::Texture:
      addByName(mesh.textures, &ViewSurface::texture, 0);  // the first entry, no texture, is grey
      break;
    case MeshColor::Rule:
      addByName(mesh.rules, &ViewSurface::rule, 0);
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
