#include "viewer/frames/view_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "base/parallel.h"
#include "pipeline/checks/warnings.h"
#include "scenefile/scene_file.h"

namespace scanmill {

namespace {

constexpr std::size_t kTriangleGrain = 16384;
constexpr std::size_t kBoxGrain = 64;

// Returns the index of each instance's first triangle in the view mesh, followed by the total number of triangles.
std::vector<std::size_t> firstTriangles(const Scene& scene) {
  std::vector<std::size_t> first{0};
  first.reserve(scene.instances.size() + 1);
  for (const Instance& instance : scene.instances) {
    first.push_back(first.back() + scene.meshes[instance.mesh].triangles.size());
  }
  return first;
}

// Returns the name of a part from the names of object and node, such as "hall: Wall.003"; only the object's name if the
// node has the same name ("car" in "car#3") or none.
std::string partName(const std::string& object, const std::string& node) {
  const bool same = object.starts_with(node) && (object.size() == node.size() || object[node.size()] == '#');
  return node.empty() || same ? object : object + ": " + node;
}

// Assigns numbers to names in the order of their first use.
class NameList {
 public:
  explicit NameList(std::vector<std::string>& names) : names_(names) {}
  std::uint32_t number(const std::string& key, const std::string& name) {
    const auto [known, added] = numbers_.emplace(key, static_cast<std::uint32_t>(names_.size()));
    if (added) names_.push_back(name);
    return known->second;
  }
  std::uint32_t number(const std::string& name) { return number(name, name); }

 private:
  std::vector<std::string>& names_;
  std::map<std::string, std::uint32_t> numbers_;
};

// Returns a position in a scene file as "line 9"; for a file that the scene includes, "walls.yaml, line 9".
std::string shortLocation(const Scene& scene, const Location& where) {
  const std::filesystem::path file = std::filesystem::path(where.file).filename();
  return file == scene.file.filename() ? fmt::format("line {}", where.line)
                                       : fmt::format("{}, line {}", file.string(), where.line);
}

std::string ruleKey(const Surface& surface) {
  if (!surface.labelledBy.file.empty()) return surface.labelledBy.text();
  return surface.semantic == 0 ? "none" : "own";
}

// Returns the text for a surface that has its class from the object, not from a rule: the object's position in the
// scene file, and the class.
std::string ofTheObject(const Scene& scene, const Surface& surface) {
  const SemanticClass* const known = scene.ontology.find(surface.semantic);
  return fmt::format("{}: {} (of the object)", shortLocation(scene, surface.labelledBy),
                     known == nullptr ? std::to_string(surface.semantic) : known->name);
}

// Adds the surfaces of the scene to `view`, with the lists of parts, textures and rules; skips objects without
// triangles. Returns the index of each instance's first surface.
std::vector<std::uint32_t> listSurfaces(const Scene& scene, ViewMesh& view) {
  NameList textures(view.textures);
  NameList rules(view.rules);
  textures.number("", "no texture");
  rules.number("none", "none: no rule matches");
  rules.number("own", "the object itself");
  for (const RuleUse& use : scene.rules) {
    rules.number(use.where.text(), fmt::format("{}: {} ({})", shortLocation(scene, use.where),
                                               use.gives.substr(0, use.gives.find(", material ")), use.match));
  }
  std::vector<std::uint32_t> first;
  first.reserve(scene.instances.size());
  for (const Instance& instance : scene.instances) {
    first.push_back(static_cast<std::uint32_t>(view.surfaces.size()));
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.triangles.empty()) continue;
    std::map<std::string_view, std::uint32_t> partOf;  // node name -> index of its part
    for (const Surface& surface : mesh.surfaces) {
      const auto [part, added] = partOf.emplace(surface.node, static_cast<std::uint32_t>(view.parts.size()));
      if (added) view.parts.push_back(partName(instance.name, surface.node));
      view.surfaces.push_back({part->second, surface.material, textures.number(surface.texture),
                               rules.number(ruleKey(surface), ofTheObject(scene, surface))});
    }
  }
  return first;
}

void fillTriangles(const Scene& scene, ViewMesh& view) {
  const std::vector<std::size_t> firstOf = firstTriangles(scene);
  const std::vector<std::uint32_t> firstSurface = listSurfaces(scene, view);
  const std::size_t count = firstOf.back();
  view.corners.resize(3 * count);
  view.semantic.resize(count);
  view.instance.resize(count);
  view.surface.resize(count);
  parallelFor(count, kTriangleGrain, [&](std::size_t first, std::size_t last) {
    auto owner =
        static_cast<std::size_t>(std::upper_bound(firstOf.begin(), firstOf.end(), first) - firstOf.begin()) - 1;
    for (std::size_t t = first; t < last; ++owner) {
      const Instance& instance = scene.instances[owner];
      const Mesh& mesh = scene.meshes[instance.mesh];
      // Subtract the large world coordinates in double precision, before the result is rounded to float.
      const Affine fromMesh{instance.worldFromMesh.linear, instance.worldFromMesh.translation - view.origin};
      for (const std::size_t end = std::min(last, firstOf[owner + 1]); t < end; ++t) {
        const std::size_t own = t - firstOf[owner];
        for (std::size_t corner = 0; corner < 3; ++corner) {
          view.corners[3 * t + corner] = Vec3f(fromMesh * Vec3d(mesh.positions[mesh.triangles[own][corner]]));
        }
        const Surface& surface = mesh.surfaces[mesh.surfaceOf[own]];
        view.semantic[t] = surface.semantic;
        view.instance[t] = instanceId(instance, surface);
        view.surface[t] = firstSurface[owner] + mesh.surfaceOf[own];
      }
    }
  });
}

void fillBoxes(ViewMesh& view) {
  constexpr std::size_t kCorners = 3 * ViewMesh::kTrianglesPerBox;
  view.boxes.resize((view.size() + ViewMesh::kTrianglesPerBox - 1) / ViewMesh::kTrianglesPerBox);
  parallelFor(view.boxes.size(), kBoxGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t b = first; b < last; ++b) {
      const std::size_t end = std::min((b + 1) * kCorners, view.corners.size());
      for (std::size_t c = b * kCorners; c < end; ++c) view.boxes[b].add(Vec3d(view.corners[c]));
    }
  });
  for (const Box& box : view.boxes) view.bounds.add(box);
  view.partBoxes.resize(view.parts.size());
  for (std::size_t t = 0; t < view.size(); ++t) {
    for (std::size_t c = 3 * t; c < 3 * t + 3; ++c) view.partBoxes[view.surfaceOf(t).part].add(Vec3d(view.corners[c]));
  }
}

// Returns the part of each cell of a horizontal grid that the boxes fill, for all cells that are not empty. `origin`:
// corner of the grid. `side`: side of a cell (m).
std::vector<Box> occupiedCells(const std::vector<Box>& boxes, const Vec3d& origin, double side) {
  std::map<std::pair<int, int>, Box> occupied;
  for (const Box& box : boxes) {
    const auto first = [&](double Vec3d::*axis) { return static_cast<int>((box.low.*axis - origin.*axis) / side); };
    const auto end = [&](double Vec3d::*axis) {
      return std::max(static_cast<int>(std::ceil((box.high.*axis - origin.*axis) / side)), first(axis) + 1);
    };
    for (int i = first(&Vec3d::x); i < end(&Vec3d::x); ++i) {
      for (int j = first(&Vec3d::y); j < end(&Vec3d::y); ++j) {
        const Vec3d low = origin + Vec3d{i * side, j * side, 0};
        occupied[{i, j}].add(Box{{std::max(low.x, box.low.x), std::max(low.y, box.low.y), box.low.z},
                                 {std::min(low.x + side, box.high.x), std::min(low.y + side, box.high.y), box.high.z}});
      }
    }
  }
  std::vector<Box> cells;
  cells.reserve(occupied.size());
  for (const auto& [cell, box] : occupied) cells.push_back(box);
  return cells;
}

// Returns a box that contains most of a scene: the occupied cells of a grid, without kLeftOut of them at each side, but
// at most as many as kLeftOut of the parts. How many parts a cell has does not count. Large parts, such as surrounding
// ground, are left out unless the others reach nearly as far.
Box coreOf(const ViewMesh& view) {
  constexpr double kLarge = 0.5;      // fraction of the scene's longest side from which a part counts as large
  constexpr double kReaching = 0.85;  // largest such fraction for the parts that are not large
  constexpr double kLeftOut = 0.03;
  constexpr int kCells = 64;  // along the longest side
  const auto longest = [](const Box& box) {
    return box.empty() ? 0 : std::max(box.high.x - box.low.x, box.high.y - box.low.y);
  };
  const double sceneSide = longest(view.bounds);
  std::vector<Box> parts;
  std::ranges::copy_if(view.partBoxes, std::back_inserter(parts),
                       [&](const Box& part) { return longest(part) < kLarge * sceneSide; });
  Box bounds;
  for (const Box& part : parts) bounds.add(part);
  if (bounds.empty() || longest(bounds) > kReaching * sceneSide) parts = view.partBoxes, bounds = view.bounds;
  Box core;
  if (bounds.empty()) return core;
  std::erase_if(parts, [](const Box& part) { return part.empty(); });
  std::vector<Box> cells = occupiedCells(parts, bounds.low, std::max(longest(bounds) / kCells, 1e-6));
  const std::size_t most = std::min(cells.size(), view.partBoxes.size());
  const auto omitted = static_cast<std::ptrdiff_t>(kLeftOut * static_cast<double>(most));
  const auto edge = [&](Vec3d Box::*end, double Vec3d::*axis, auto order) {
    std::ranges::nth_element(cells, cells.begin() + omitted, order, [&](const Box& cell) { return cell.*end.*axis; });
    return cells[static_cast<std::size_t>(omitted)].*end.*axis;
  };
  for (double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    core.low.*axis = edge(&Box::low, axis, std::less<>());
    core.high.*axis = edge(&Box::high, axis, std::greater<>());
  }
  return core;
}

// Removes moving objects that are far from all static objects at this time, such as a town's vehicles that have not
// arrived yet.
void removeDistantMovers(Scene& scene, double time) {
  Box standing;
  for (const Instance& i : scene.instances) {
    if (i.moves()) continue;
    standing.add(boxAround(i.worldFromMesh, scene.meshes[i.mesh].bounds()));
  }
  if (standing.empty()) return;
  // Moving objects are shown if their middle is at most this far outside of the bounding box of all static objects
  // along each axis (m).
  constexpr double kNear = 40;
  std::erase_if(scene.instances, [&](const Instance& i) {
    if (!i.moves()) return false;
    const Vec3d p = i.worldFromMeshAt(time) * scene.meshes[i.meshAt(time)].bounds().center();
    const double away = std::max({standing.low.x - p.x, p.x - standing.high.x, standing.low.y - p.y,
                                  p.y - standing.high.y, standing.low.z - p.z, p.z - standing.high.z});
    return away > kNear;
  });
}

constexpr double kNever = std::numeric_limits<double>::infinity();
// Length (m) by which boxes are enlarged, so that rounding errors cannot cause rays to miss flat boxes.
constexpr double kBoxSlack = 1e-6;

// Returns the distance (m) at which a ray enters a box; 0 if it starts inside; infinity if it misses. Slab method of T.
// Kay and J. Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986.
double entry(const Box& box, const Vec3d& origin, const Vec3d& direction) {
  double enter = 0, leave = kNever;
  for (double Vec3d::*const axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    const double low = box.low.*axis - kBoxSlack - origin.*axis;
    const double high = box.high.*axis + kBoxSlack - origin.*axis;
    if (direction.*axis == 0) {
      if (low > 0 || high < 0) return kNever;
      continue;
    }
    const auto [near, far] = std::minmax({low / direction.*axis, high / direction.*axis});
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  return enter <= leave ? enter : kNever;
}

// Returns the distance (m) at which a ray hits a triangle from either side; infinity if it misses. T. Moeller and B.
// Trumbore, "Fast, minimum storage ray-triangle intersection", 1997.
double distanceTo(const Vec3f* corners, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d a(corners[0]);
  const Vec3d ab = Vec3d(corners[1]) - a;
  const Vec3d ac = Vec3d(corners[2]) - a;
  const Vec3d p = cross(direction, ac);
  const double det = dot(ab, p);
  if (det == 0) return kNever;
  const Vec3d fromA = origin - a;
  const double u = dot(fromA, p) / det;
  if (!(u >= 0 && u <= 1)) return kNever;
  const Vec3d q = cross(fromA, ab);
  const double v = dot(direction, q) / det;
  if (!(v >= 0 && u + v <= 1)) return kNever;
  const double t = dot(ac, q) / det;
  return t >= 0 ? t : kNever;
}

}  // namespace

ViewMesh makeViewMesh(const Scene& scene) {
  ViewMesh view;
  view.name = scene.name;
  const std::uint64_t placed = scene.placedTriangles();
  if (placed > kMostViewTriangles) {
    view.problem = fmt::format(
        "{}: {} triangles are placed, and the viewer draws at most {}; a coarser scene can be "
        "shown in its place by --scene FILE (a town has the key `detail`)",
        scene.name, placed, kMostViewTriangles);
    return view;
  }
  const Box world = scene.bounds();
  if (!world.empty()) view.origin = world.center();
  view.ontology = scene.ontology;
  for (const Material& material : scene.materials) {
    view.materials.push_back(material.name);
    view.reflectance.push_back(material.reflectance);
  }
  fillTriangles(scene, view);
  fillBoxes(view);
  view.core = coreOf(view);
  return view;
}

ViewMesh loadViewMesh(const std::filesystem::path& file, std::uint64_t seed, double time,
                      const std::filesystem::path& ontology) {
  try {
    Scene scene = readScene(file, {.seed = seed, .ontology = ontology, .textures = false});
    const bool moves = scene.moves();
    if (moves) {
      removeDistantMovers(scene, time);
      standStill(scene, time);
    }
    ViewMesh view = makeViewMesh(scene);
    view.moves = moves;
    view.warnings = ruleWarnings(scene);
    return view;
  } catch (const std::exception& e) {
    ViewMesh none;
    none.name = file.stem().string();
    none.problem = reasonOf(e);
    return none;
  }
}

std::optional<MeshHit> pickTriangle(const ViewMesh& mesh, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d along = normalized(direction);
  if (!isFinite(origin) || !isFinite(along) || along == Vec3d{}) return std::nullopt;
  MeshHit best{0, kNever};
  for (std::size_t b = 0; b < mesh.boxes.size(); ++b) {
    if (!(entry(mesh.boxes[b], origin, along) < best.distance)) continue;
    const std::size_t first = b * ViewMesh::kTrianglesPerBox;
    const std::size_t last = std::min(first + ViewMesh::kTrianglesPerBox, mesh.size());
    for (std::size_t t = first; t < last; ++t) {
      const double distance = distanceTo(&mesh.corners[3 * t], origin, along);
      if (distance < best.distance) best = {t, distance};
    }
  }
  if (best.distance == kNever) return std::nullopt;
  return best;
}

}  // namespace scanmill
