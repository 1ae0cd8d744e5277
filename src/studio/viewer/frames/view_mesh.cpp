#include "viewer/frames/view_mesh.h"

#include <fmt/format.h>

#include <ranges>

#include "base/parallel.h"
#include "pipeline/checks/warnings.h"
#include "scenefile/scene_file.h"

namespace scanmill {

namespace {

// Numbers of triangles and of boxes that a thread handles at a time.
constexpr std::size_t kTriangleGrain = 16384;
constexpr std::size_t kBoxGrain = 64;

// Returns the name of a part from the names of object and node, such as "hall: Wall.003"; only the object's name if the
// node has no name, or if the names differ at most by the object's number ("car" and "car#3").
std::string partName(const std::string& object, const std::string& node) {
  const bool isSameName = object.starts_with(node) && (object.size() == node.size() || object[node.size()] == '#');
  return node.empty() || isSameName ? object : object + ": " + node;
}

// Appends names to a list, one name for each distinct key.
class NameList {
 public:
  explicit NameList(std::vector<std::string>& names) : names_(names) {}
  // Returns the index of the key's name in the list; appends `name` if the key is new.
  std::uint32_t indexOf(const std::string& key, const std::string& name) {
    const auto [entry, isNew] = indices_.emplace(key, static_cast<std::uint32_t>(names_.size()));
    if (isNew) names_.push_back(name);
    return entry->second;
  }

 private:
  std::vector<std::string>& names_;
  std::map<std::string, std::uint32_t> indices_;
};

// Returns a position in a scene file as "line 9"; for a file that the scene includes, "walls.yaml, line 9".
std::string shortLocation(const Scene& scene, const Location& where) {
  const std::filesystem::path file = std::filesystem::path(where.file).filename();
  return file == scene.file.filename() ? fmt::format("line {}", where.line)
                                       : fmt::format("{}, line {}", file.string(), where.line);
}

// Returns a surface's key in the list of rules: the position of the rule or object that gives the class. Without such a
// position, returns "none" if the surface has no class, otherwise "own".
std::string ruleKey(const Surface& surface) {
  if (!surface.labelledBy.file.empty()) return surface.labelledBy.text();
  return surface.semantic == 0 ? "none" : "own";
}

// Returns the text for a surface that has the class of its object: the object's line in the scene file, and the class.
std::string objectRuleText(const Scene& scene, const Surface& surface) {
  const SemanticClass* const found = scene.ontology.find(surface.semantic);
  return fmt::format("{}: {} (of the object)", shortLocation(scene, surface.labelledBy),
                     found == nullptr ? std::to_string(surface.semantic) : found->name);
}

// Adds the surfaces of the scene to `view`, with the lists of parts, textures and rules; skips objects without
// triangles. Returns the index of each instance's first surface.
std::vector<std::uint32_t> listSurfaces(const Scene& scene, ViewMesh& view) {
  NameList textures(view.textures);
  NameList rules(view.rules);
  textures.indexOf("", "no texture");
  rules.indexOf("none", "none: no rule matches");
  rules.indexOf("own", "the object itself");
  for (const RuleUse& use : scene.rules) {
    rules.indexOf(use.where.text(), fmt::format("{}: {} ({})", shortLocation(scene, use.where),
                                                use.gives.substr(0, use.gives.find(", material ")), use.match));
  }
  std::vector<std::uint32_t> firstSurfaces;
  firstSurfaces.reserve(scene.instances.size());
  for (const Instance& instance : scene.instances) {
    firstSurfaces.push_back(static_cast<std::uint32_t>(view.surfaces.size()));
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.triangles.empty()) continue;
    NameList parts(view.parts);  // a new list, since each instance's nodes are separate parts
    for (const Surface& surface : mesh.surfaces) {
      view.surfaces.push_back({.part = parts.indexOf(surface.node, partName(instance.name, surface.node)),
                               .material = surface.material,
                               .texture = textures.indexOf(surface.texture, surface.texture),
                               .rule = rules.indexOf(ruleKey(surface), objectRuleText(scene, surface))});
    }
  }
  return firstSurfaces;
}

// Sets the corners, class, instance and surface of each triangle. Triangles are in the order of instances, and in each
// instance in the order of its mesh. Threads fill ranges of triangles, which may begin and end within an instance.
void fillTriangles(const Scene& scene, ViewMesh& view) {
  std::vector<std::size_t> firstTriangle{0};  // index of each instance's first triangle; last entry: the end
  for (const Instance& instance : scene.instances) {
    firstTriangle.push_back(firstTriangle.back() + scene.meshes[instance.mesh].triangles.size());
  }
  const std::vector<std::uint32_t> firstSurface = listSurfaces(scene, view);
  const std::size_t count = firstTriangle.back();
  view.corners.resize(3 * count);
  view.semantic.resize(count);
  view.instance.resize(count);
  view.surface.resize(count);
  parallelFor(count, kTriangleGrain, [&](std::size_t first, std::size_t last) {
    auto index = static_cast<std::size_t>(std::ranges::upper_bound(firstTriangle, first) - firstTriangle.begin()) - 1;
    for (std::size_t t = first; t < last; ++index) {
      const Instance& instance = scene.instances[index];
      const Mesh& mesh = scene.meshes[instance.mesh];
      // Subtract the large world coordinates in double precision, before the result is rounded to float.
      const Affine fromMesh{instance.worldFromMesh.linear, instance.worldFromMesh.translation - view.origin};
      for (const std::size_t end = std::min(last, firstTriangle[index + 1]); t < end; ++t) {
        const std::size_t inMesh = t - firstTriangle[index];  // index of the triangle in the mesh
        for (std::size_t corner = 0; corner < 3; ++corner) {
          view.corners[3 * t + corner] = Vec3f(fromMesh * Vec3d(mesh.positions[mesh.triangles[inMesh][corner]]));
        }
        const Surface& surface = mesh.surfaces[mesh.surfaceOf[inMesh]];
        view.semantic[t] = surface.semantic;
        view.instance[t] = instanceId(instance, surface);
        view.surface[t] = firstSurface[index] + mesh.surfaceOf[inMesh];
      }
    }
  });
}

// Computes the bounding boxes of groups of triangles, of parts and of the mesh.
void fillBoxes(ViewMesh& view) {
  constexpr std::size_t kCorners = 3 * ViewMesh::kTrianglesPerBox;
  view.boxes.resize((view.size() + ViewMesh::kTrianglesPerBox - 1) / ViewMesh::kTrianglesPerBox);
  parallelForEach(view.boxes.size(), kBoxGrain, [&](std::size_t b) {
    const std::size_t end = std::min((b + 1) * kCorners, view.corners.size());
    for (std::size_t c = b * kCorners; c < end; ++c) view.boxes[b].add(Vec3d(view.corners[c]));
  });
  for (const Box& box : view.boxes) view.bounds.add(box);
  view.partBoxes.resize(view.parts.size());
  for (std::size_t t = 0; t < view.size(); ++t) {
    for (std::size_t c = 3 * t; c < 3 * t + 3; ++c) view.partBoxes[view.surfaceOf(t).part].add(Vec3d(view.corners[c]));
  }
}

// Clips `boxes` to the cells of a horizontal grid. Returns, for each cell that boxes overlap, the bounding box of the
// clipped boxes. `origin`: corner of the grid with the least x and y. `side`: side of a cell (m).
std::vector<Box> occupiedCells(const std::vector<Box>& boxes, const Vec3d& origin, double side) {
  std::map<std::pair<int, int>, Box> occupied;  // the keys are indices of cells along x and y
  for (const Box& box : boxes) {
    const auto firstCell = [&](double Vec3d::*axis) { return static_cast<int>((box.low.*axis - origin.*axis) / side); };
    const auto endCell = [&](double Vec3d::*axis) {
      return std::max(static_cast<int>(std::ceil((box.high.*axis - origin.*axis) / side)), firstCell(axis) + 1);
    };
    for (int i = firstCell(&Vec3d::x); i < endCell(&Vec3d::x); ++i) {
      for (int j = firstCell(&Vec3d::y); j < endCell(&Vec3d::y); ++j) {
        const Vec3d low = origin + Vec3d{i * side, j * side, 0};
        occupied[{i, j}].add(Box{{std::max(low.x, box.low.x), std::max(low.y, box.low.y), box.low.z},
                                 {std::min(low.x + side, box.high.x), std::min(low.y + side, box.high.y), box.high.z}});
      }
    }
  }
  const auto cells = std::views::values(occupied);
  return {cells.begin(), cells.end()};
}

// Returns a box that contains most of a scene. The scene is divided into grid cells; at each side of the box, about the
// fraction kOmitted of the occupied cells (or of the parts, if they are fewer) is left outside. Large parts, such as
// ground, are ignored unless the other parts reach nearly as far. The constants are chosen by eye.
Box coreOf(const ViewMesh& view) {
  constexpr double kLarge = 0.5;      // fraction of the scene's longest side from which a part counts as large
  constexpr double kReaching = 0.85;  // the other parts reach nearly as far if their extent is more than this fraction
  constexpr double kOmitted = 0.03;
  constexpr int kCells = 64;  // along the longest side
  const auto longestSide = [](const Box& box) {
    return box.empty() ? 0 : std::max(box.high.x - box.low.x, box.high.y - box.low.y);
  };
  const double sceneSide = longestSide(view.bounds);
  std::vector<Box> parts;
  std::ranges::copy_if(view.partBoxes, std::back_inserter(parts),
                       [&](const Box& part) { return longestSide(part) < kLarge * sceneSide; });
  Box bounds;
  for (const Box& part : parts) bounds.add(part);
  if (bounds.empty() || longestSide(bounds) > kReaching * sceneSide) parts = view.partBoxes, bounds = view.bounds;
  Box core;
  if (bounds.empty()) return core;
  std::erase_if(parts, [](const Box& part) { return part.empty(); });
  std::vector<Box> cells = occupiedCells(parts, bounds.low, std::max(longestSide(bounds) / kCells, 1e-6));
  const std::size_t counted = std::min(cells.size(), view.partBoxes.size());
  const auto omitted = static_cast<std::ptrdiff_t>(kOmitted * static_cast<double>(counted));
  // Returns the coordinate of a side of the box that excludes the first `omitted` cells in `order`. Reorders the cells.
  const auto sideWithoutOmitted = [&](Vec3d Box::*corner, double Vec3d::*axis, auto order) {
    const auto coordinate = [&](const Box& cell) { return cell.*corner.*axis; };
    std::ranges::nth_element(cells, cells.begin() + omitted, order, coordinate);
    return coordinate(cells[static_cast<std::size_t>(omitted)]);
  };
  for (double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    core.low.*axis = sideWithoutOmitted(&Box::low, axis, std::less<>());
    core.high.*axis = sideWithoutOmitted(&Box::high, axis, std::greater<>());
  }
  return core;
}

// Removes moving objects that are far from all static objects, such as a town's vehicles that have not arrived yet.
void removeDistantMovers(Scene& scene, double time) {
  Box staticBounds;
  for (const Instance& i : scene.instances) {
    if (!i.moves()) staticBounds.add(boxAround(i.worldFromMesh, scene.meshes[i.mesh].bounds()));
  }
  if (staticBounds.empty()) return;
  // Largest distance (m) along each axis from the box of all static objects to the middle of a shown moving object.
  constexpr double kNear = 40;
  std::erase_if(scene.instances, [&](const Instance& i) {
    if (!i.moves()) return false;
    const Vec3d middle = i.worldFromMeshAt(time) * scene.meshes[i.meshAt(time)].bounds().center();
    const Vec3d below = staticBounds.low - middle, above = middle - staticBounds.high;
    return std::max({below.x, below.y, below.z, above.x, above.y, above.z}) > kNear;
  });
}

constexpr double kMissed = std::numeric_limits<double>::infinity();
// Length (m) by which boxes are enlarged, so that rounding errors cannot cause rays to miss flat boxes.
constexpr double kBoxSlack = 1e-6;

// Returns the distance (m) at which a ray enters a box; 0 if it starts inside; infinity if it misses. Slab method of T.
// Kay and J. Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986.
double distanceToBox(const Box& box, const Vec3d& origin, const Vec3d& direction) {
  double enter = 0, leave = kMissed;
  for (double Vec3d::*const axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    const double low = box.low.*axis - kBoxSlack - origin.*axis;
    const double high = box.high.*axis + kBoxSlack - origin.*axis;
    if (direction.*axis == 0) {
      if (low > 0 || high < 0) return kMissed;
      continue;
    }
    const auto [near, far] = std::minmax({low / direction.*axis, high / direction.*axis});
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  return enter <= leave ? enter : kMissed;
}

// Returns the distance (m) at which a ray hits either side of a triangle; infinity if it misses. u and v are
// barycentric coordinates (T. Moeller and B. Trumbore, "Fast, minimum storage ray-triangle intersection", 1997).
double distanceToTriangle(std::span<const Vec3f, 3> corners, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d a(corners[0]);
  const Vec3d ab = Vec3d(corners[1]) - a;
  const Vec3d ac = Vec3d(corners[2]) - a;
  const Vec3d p = cross(direction, ac);
  const double det = dot(ab, p);
  if (det == 0) return kMissed;  // the ray is parallel to the triangle
  const Vec3d fromA = origin - a;
  const double u = dot(fromA, p) / det;
  if (!(u >= 0 && u <= 1)) return kMissed;
  const Vec3d q = cross(fromA, ab);
  const double v = dot(direction, q) / det;
  if (!(v >= 0 && u + v <= 1)) return kMissed;
  const double t = dot(ac, q) / det;
  return t >= 0 ? t : kMissed;
}

}  // namespace

ViewMesh makeViewMesh(const Scene& scene) {
  ViewMesh view;
  const std::uint64_t triangles = scene.placedTriangles();
  if (triangles > kMostViewTriangles) {
    view.problem = fmt::format(
        "{}: {} triangles are placed, and the viewer draws at most {}; a coarser scene can be "
        "shown in its place by --scene FILE (a town has the key `detail`)",
        scene.name, triangles, kMostViewTriangles);
    return view;
  }
  if (const Box bounds = scene.bounds(); !bounds.empty()) view.origin = bounds.center();
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

ViewMesh loadViewMesh(const SceneChoice& choice) {
  try {
    Scene scene = readScene(choice.file, {.seed = choice.seed, .ontology = choice.ontology, .textures = false});
    const bool moves = scene.moves();
    if (moves) {
      removeDistantMovers(scene, choice.time);
      standStill(scene, choice.time);
    }
    ViewMesh view = makeViewMesh(scene);
    view.moves = moves;
    view.warnings = ruleWarnings(scene);
    return view;
  } catch (const std::exception& e) {
    ViewMesh failed;
    failed.problem = reasonOf(e);
    return failed;
  }
}

std::optional<MeshHit> pickTriangle(const ViewMesh& mesh, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d unitDirection = normalized(direction);
  if (!isFinite(origin) || !isFinite(unitDirection) || unitDirection == Vec3d{}) return std::nullopt;
  MeshHit nearest{.distance = kMissed};
  for (std::size_t b = 0; b < mesh.boxes.size(); ++b) {
    if (!(distanceToBox(mesh.boxes[b], origin, unitDirection) < nearest.distance)) continue;
    const std::size_t first = b * ViewMesh::kTrianglesPerBox;
    const std::size_t last = std::min(first + ViewMesh::kTrianglesPerBox, mesh.size());
    for (std::size_t t = first; t < last; ++t) {
      const std::span<const Vec3f, 3> corners(&mesh.corners[3 * t], 3);
      const double distance = distanceToTriangle(corners, origin, unitDirection);
      if (distance < nearest.distance) nearest = {t, distance};
    }
  }
  if (nearest.distance == kMissed) return std::nullopt;
  return nearest;
}

}  // namespace scanmill
