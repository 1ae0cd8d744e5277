// Shows the scene's mesh: look, colours, visible triangles, and the triangle at a pixel.

#include <fmt/core.h>

#include "viewer/color_map.h"
#include "viewer/window/picked_rows.h"
#include "viewer/window/scenery.h"

namespace scanmill {

void Scenery::takeMesh(std::shared_ptr<const ViewMesh> loaded) {
  mesh = std::move(loaded);
  meshProblem = mesh ? mesh->problem : "";
  context_.changes.panels = true;
  placeMesh();
}

void Scenery::placeMesh() {
  context_.changes.items = context_.changes.panels = true;
  if (!meshSeen()) {
    meshItem.drop();
    meshShown.clear();
    if (mesh && mesh->size() > 0 && meshOn()) context_.say("no mesh: the pose of the scan is not known");
    return;
  }
  place();
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
  tellWhatEncloses();
}

void Scenery::applyFilter() {
  meshShown.clear();
  if (!meshItem.there()) return;
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

void Scenery::placeMeshLook() {
  if (!meshItem.there()) return;
  constexpr double kFaint = 0.25;
  const ItemLook look{.canvasFromItem = canvasFromWorld * Affine{{}, mesh->origin},
                      .opacity = context_.source->isScene() ? 1 : kFaint,
                      .views = (1U << clouds_.viewCount()) - 1};
  meshItem.setLook(look);
  context_.changes.items = true;
}

void Scenery::placeVehicle() {
  const bool known = context_.frame && context_.frame->worldFromVehicle && worldFromAnchor;
  const auto file = known && context_.options.axes ? context_.source->vehicle() : std::nullopt;
  if (!file) return vehicleItem.drop();
  if (!vehicle_) vehicle_ = loadViewMesh(*file, 1, 0, {});
  if (vehicle_->size() == 0) return;
  if (!vehicleItem.there()) vehicleItem.setTriangles(vehicle_->corners, colorMesh(*vehicle_, MeshColor::Class).colors);
  vehicleItem.setLook(
      {.canvasFromItem = canvasFromWorld * toAffine(*context_.frame->worldFromVehicle) * Affine{{}, vehicle_->origin},
       .views = (1U << clouds_.viewCount()) - 1});
  context_.changes.items = true;
}

void Scenery::chooseMeshColor(MeshColor by) {
  meshColor = by;
  if (!mesh || mesh->size() == 0) return;
  meshColoring = colorMesh(*mesh, meshColor);
  meshItem.setColors(meshColoring.colors);
  context_.changes.items = context_.changes.panels = true;
}

std::optional<PickedThing> Scenery::pickMesh(const SightLine& line) const {
  if (!meshItem.there()) return {};
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
      PickedThing thing = describeTriangle(*mesh, hit->triangle, spot + mesh->origin);
      thing.place = canvasFromWorld * (spot + mesh->origin);
      return thing;
    }
    origin = spot + direction * kBeyond;
  }
  return {};
}

void Scenery::tellWhatEncloses() {
  constexpr int kAcross = 7;
  constexpr double kEnough = 0.1;  // least fraction of the lines of sight that must hit the part
  const ViewCamera view = camera.camera(context_.canvas.width(), context_.canvas.height());
  std::optional<std::size_t> first;  // triangle seen along the first line of sight that hits a triangle
  int met = 0;
  for (int line = 0; line < kAcross * kAcross; ++line) {
    const int column = line % kAcross;
    const int row = line / kAcross;
    const double x = (column + 0.5) * context_.canvas.width() / kAcross;
    const double y = (row + 0.5) * context_.canvas.height() / kAcross;
    const auto thing = pickMesh(sightLine(view, x, y));
    if (!thing) continue;
    ++met;
    if (!first) first = thing->point;
    if (mesh->surfaceOf(thing->point).part != mesh->surfaceOf(*first).part) return;
  }
  if (met < kEnough * kAcross * kAcross) return;
  const std::uint32_t part = mesh->surfaceOf(*first).part;
  Box own, others;
  for (std::size_t t = 0; t < mesh->size(); ++t) {
    if (!meshShown.empty() && meshShown[t] == 0) continue;
    Box& box = mesh->surfaceOf(t).part == part ? own : others;
    for (std::size_t corner = 3 * t; corner < 3 * t + 3; ++corner) box.add(Vec3d(mesh->corners[corner]));
  }
  const auto within = [](const Vec3d& low, const Vec3d& high) {
    return low.x <= high.x && low.y <= high.y && low.z <= high.z;
  };
  if (others.empty() || !within(own.low, others.low) || !within(others.high, own.high)) return;
  context_.hint(
      fmt::format("nothing but '{}' is seen from here, which encloses all the rest: hide its class ({}), or look from "
                  "another place",
                  mesh->parts[part], className(&mesh->ontology, mesh->semantic[*first])));
}

}  // namespace scanmill
