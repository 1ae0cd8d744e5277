#include "viewer/contact_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "base/short_text.h"
#include "scene/primitives.h"
#include "viewer/canvas/canvas.h"
#include "viewer/panels/board.h"
#include "viewer/panels/parts.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {
namespace {

constexpr double kPerson = 1.8;  // height of a person (m)
constexpr Rgb kPersonColor{250, 220, 60};
constexpr Rgb kArrowColor{255, 70, 60};
constexpr Rgb kNoClass{255, 0, 255};
constexpr Rgb kCell{30, 33, 42};
constexpr int kTextHeight = 66;   // height of the three lines of text below a model (pixels)
constexpr int kTitleHeight = 34;  // height of the title in pixels
constexpr double kLetter = 15;    // height of letters in pixels

struct Model {
  std::string name;
  std::vector<const Instance*> instances;
};

// The parts of an instance's name, as written by ObjectPlacer. For instance, the object of "house", "house#3",
// "house/wall 2" and "house#3/wall 2" is "house".
struct InstanceName {
  std::string object;
  bool first = true;   // true: the instance belongs to the object's first copy
  bool whole = false;  // true: the name is only the object's name
};

InstanceName nameOf(const std::string& instance) {
  static const std::regex form("((?:.*?[^ #])?)(?:#([0-9]+))?(?:/[^/]* [0-9]+)?",
                               std::regex::ECMAScript | std::regex::optimize);
  constexpr std::size_t kLongest = 4096;  // longest name to match (characters); std::regex recurses for each character
  std::smatch match;
  if (instance.size() > kLongest || !std::regex_match(instance, match, form)) return {instance, true, true};
  return {match[1].str(), !match[2].matched || match[2] == "1", match[1].length() == match[0].length()};
}

// Returns a name without its numbers, which identifies a series: "house 12 plinth" and "house 3 plinth" are of the same
// series.
std::string seriesOf(std::string name) {
  std::erase_if(name, [](unsigned char c) { return std::isdigit(c) != 0; });
  return name;
}

// Returns the objects in the order of the scene.
std::vector<Model> modelsOf(const Scene& scene) {
  std::vector<Model> models;
  std::map<std::string, std::size_t> known;  // name -> index of the last model with this name
  for (const Instance& instance : scene.instances) {
    const InstanceName name = nameOf(instance.name);
    const bool again = known.contains(name.object) && name.whole;  // another object with the same name starts
    if (again || !known.contains(name.object)) {
      known[name.object] = models.size();
      models.push_back({name.object, {}});
    }
    Model& model = models[known[name.object]];
    // The first copy of an object may be missing, since copies may be left out at random. Then its first existing copy
    // is shown.
    if (name.first || model.instances.empty()) model.instances.push_back(&instance);
  }
  return models;
}

// Removes models until at most kMostSheetCells remain: keeps the first of each series, then the second of each series,
// and so on. The remaining models keep their order.
void keepSome(std::vector<Model>& models) {
  if (models.size() <= kMostSheetCells) return;
  std::map<std::string, std::size_t> seen;
  std::vector<std::pair<std::size_t, std::size_t>> order;  // pairs of position in the series and index of the model
  for (std::size_t i = 0; i < models.size(); ++i) order.emplace_back(seen[seriesOf(models[i].name)]++, i);
  std::ranges::sort(order);
  order.resize(kMostSheetCells);
  std::ranges::sort(order, {}, &std::pair<std::size_t, std::size_t>::second);
  std::vector<Model> kept;
  kept.reserve(order.size());
  for (const auto& [place, index] : order) kept.push_back(std::move(models[index]));
  models = std::move(kept);
}

struct Shape {
  std::vector<Vec3f> corners;  // corners of triangles (m), transformed by upright() of the first instance
  std::vector<Rgb> colors;
  Box box;
  std::vector<std::pair<std::string, Rgb>> classes;  // name and colour of each class, the most frequent first
};

// Returns the transform that undoes an object's heading and position in the world, but not its scale and tilt.
Affine upright(const Affine& worldFromMesh) {
  const Vec3d x = worldFromMesh.linear.x;
  const double heading = std::hypot(x.x, x.y) > 0 ? std::atan2(x.y, x.x) : 0;
  const Mat3 turn = toMatrix(fromYawPitchRoll(-heading, 0, 0));
  return {turn, turn * worldFromMesh.translation * -1.0};
}

Shape shapeOf(const Scene& scene, const Model& model) {
  static const SemanticClass kNone{.name = "no class", .color = kNoClass, .aliases = {}};
  const auto classOf = [&](std::uint16_t id) -> const SemanticClass& {
    const SemanticClass* const known = id == 0 ? nullptr : scene.ontology.find(id);
    return known == nullptr ? kNone : *known;
  };
  Shape shape;
  const Affine own = upright(model.instances.front()->worldFromMesh);
  std::map<std::uint16_t, std::size_t> triangles;
  for (const Instance* instance : model.instances) {
    const Mesh& mesh = scene.meshes[instance->mesh];
    const Affine place = own * instance->worldFromMesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const std::uint32_t corner : mesh.triangles[t]) {
        shape.corners.emplace_back(place * Vec3d(mesh.positions[corner]));
        shape.box.add(Vec3d(shape.corners.back()));
      }
      const std::uint16_t semantic = mesh.surfaces[mesh.surfaceOf[t]].semantic;
      ++triangles[semantic];
      shape.colors.push_back(classOf(semantic).color);
    }
  }
  std::vector<std::pair<std::uint16_t, std::size_t>> order(triangles.begin(), triangles.end());
  std::ranges::stable_sort(order, std::greater<>(), &std::pair<std::uint16_t, std::size_t>::second);
  for (const auto& [semantic, count] : order)
    shape.classes.emplace_back(classOf(semantic).name, classOf(semantic).color);
  return shape;
}

void addPerson(Shape& shape) {
  Mesh block;
  block.surfaces.emplace_back();
  const Vec3d beside{shape.box.center().x, shape.box.high.y + 0.6, shape.box.low.z + kPerson / 2};
  appendBox(block, 0, {{}, beside}, {0.3, 0.5, kPerson});
  for (const Triangle& t : block.triangles) {
    for (const std::uint32_t corner : t) {
      shape.corners.push_back(block.positions[corner]);
      shape.box.add(Vec3d(block.positions[corner]));
    }
    shape.colors.push_back(kPersonColor);
  }
}

// Returns the ends of the segments of an arrow. It points along x, lies on the ground and starts at the middle of the
// box's front side. Extends `box` to contain the arrow.
std::vector<Vec3f> arrowOf(Box& box) {
  const Vec3d size = box.high - box.low;
  const double length = 0.25 * std::max({size.x, size.y, size.z});
  const Vec3d from{box.high.x, box.center().y, box.low.z};
  const Vec3d tip = from + Vec3d{length, 0, 0};
  const double barb = 0.3 * length;
  box.add(tip);
  return {Vec3f(from), Vec3f(tip),
          Vec3f(tip),  Vec3f(tip + Vec3d{-barb, barb, 0}),
          Vec3f(tip),  Vec3f(tip + Vec3d{-barb, -barb, 0})};
}

// Draws a model in its cell. Scales the model, so that models of any size fill their cells.
Image drawModel(Canvas& canvas, Shape shape, int width, int height) {
  addPerson(shape);
  std::vector<Vec3f> arrow = arrowOf(shape.box);
  const Vec3d size = shape.box.high - shape.box.low;
  const double perMetre = 10 / std::max({size.x, size.y, size.z, 1e-9});
  const Vec3d middle = shape.box.center();
  for (std::vector<Vec3f>* points : {&shape.corners, &arrow}) {
    for (Vec3f& p : *points) p = Vec3f((Vec3d(p) - middle) * perMetre);
  }
  OrbitCamera camera;
  camera.yaw = radians(218);  // shows the front and the left side
  camera.pitch = radians(22);
  camera.frame({(shape.box.low - middle) * perMetre, (shape.box.high - middle) * perMetre});
  // frame() leaves much space above and below flat models, so the camera is moved nearer for these.
  camera.distance *= size.z < 0.7 * std::max(size.x, size.y) ? 0.75 : 1;
  const CanvasView view{{0, 0, width, height}, camera.camera(width, height), 1000, kCell, true};
  canvas.setViews(std::array{view});
  canvas.setTriangles(1, shape.corners, shape.colors);
  canvas.setLines(2, arrow, std::vector<Rgb>(arrow.size() / 2, kArrowColor));
  canvas.setLook(2, {.size = 3});
  canvas.render();
  return canvas.read();
}

void drawCaption(int x, int y, int width, const Model& model, const Shape& shape) {
  const double margin = 8;
  const double room = width - 2 * margin;
  wordsAt(x + margin, y + 6, room, model.name);
  wordsAt(x + margin, y + 25, room, extentText(shape.box), true);
  double at = x + margin;
  for (const auto& [name, color] : shape.classes) {
    const double left = x + width - margin - at;
    if (left < 4 * kLetter) break;
    at += namedColorAt(at, y + 44, left, name, color) + 12;
  }
}

}  // namespace

Image drawContactSheet(const Scene& scene) {
  std::vector<Model> models = modelsOf(scene);
  const std::size_t all = models.size();
  keepSome(models);
  const int width = models.size() == 1 ? 960 : models.size() <= 4 ? 640 : 320;
  const int height = width * 2 / 3;
  const auto columns = static_cast<int>(
      std::min<std::size_t>(5, static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(models.size()))))));
  const int rows = (static_cast<int>(models.size()) + columns - 1) / columns;
  constexpr int kBetween = 2;
  const int cellHeight = height + kTextHeight + kBetween;
  const int whole = columns * (width + kBetween) - kBetween;
  const int high = kTitleHeight + rows * cellHeight;
  const std::string title =
      fmt::format("{}: {} object{}{}; yellow: {} m, arrow: +x", scene.name, all, all == 1 ? "" : "s",
                  models.size() == all ? "" : fmt::format(", {} of them here", models.size()), kPerson);
  PictureBoard sheet(whole, high, kLetter);
  std::vector<Shape> shapes;
  const std::unique_ptr<Canvas> canvas = openOffscreen(width, height);
  for (std::size_t i = 0; i < models.size(); ++i) {
    shapes.push_back(shapeOf(scene, models[i]));
    sheet.setImage(static_cast<ImageId>(i), drawModel(*canvas, shapes.back(), width, height));
  }
  return sheet.draw([&] {
    titleRow({0, 0, whole, kTitleHeight}, title, "");
    panelAt("##sheet", {0, kTitleHeight, whole, high - kTitleHeight}, false, [&] {
      for (std::size_t i = 0; i < models.size(); ++i) {
        const int x = static_cast<int>(i) % columns * (width + kBetween);
        const int y = kTitleHeight + static_cast<int>(i) / columns * cellHeight;
        imageAt(static_cast<ImageId>(i), {x, y, width, height});
        drawCaption(x, y + height, width, models[i], shapes[i]);
      }
    });
  });
}

}  // namespace scanmill
