// A scene shown by itself, help that does not fit, and the range image of an overlay.

#include <fmt/format.h>

#include <set>
#include <string>

#include "tests/studio/viewer/window/session_world.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"
#include "viewer/frames/view_mesh.h"
#include "viewer/image.h"
#include "viewer/window/canvas_items.h"
#include "viewer/window/picking.h"
#include "viewer/window/scene_view.h"

namespace scanmill {
namespace {

class SceneViewer : public testing::Test {
 protected:
  SceneViewer() : source_(openFrames({.path = folder_.write("wall.yaml", kWallScene)})) {}

  std::unique_ptr<ViewSession> open(const ViewOptions& options = {}) {
    auto session = std::make_unique<ViewSession>(source_, canvas_, options);
    session->drawWhenLoaded();
    return session;
  }
  static void key(ViewSession& session, const std::string& name) {
    session.handle({.kind = CanvasEvent::Kind::Key, .key = name});
  }
  std::vector<Rgb> colors() const { return canvas_.items.at(kMeshItem).colors; }

  TemporaryFolder folder_;
  std::shared_ptr<const FrameSource> source_;
  FakeCanvas canvas_{800, 600};
};

TEST_F(SceneViewer, ColoursGoInARing) {
  const auto session = open();
  const std::vector<Rgb> byClass = colors();
  const auto overlay = [&] {
    return std::string(reinterpret_cast<const char*>(canvas_.overlay().data()),
                       canvas_.overlay().size() * sizeof(Rgba));
  };
  std::set<std::string> seen{overlay()};
  for (std::size_t i = 1; i < kMeshColorNames.size(); ++i) {
    key(*session, "c");
    EXPECT_TRUE(seen.insert(overlay()).second) << "the legend says what colours mean";
  }
  key(*session, "c");
  EXPECT_EQ(colors(), byClass);
  key(*session, "3");
  const std::vector<Rgb> byInstance = colors();
  key(*session, "1");
  EXPECT_EQ(colors(), byClass);
  for (std::size_t i = 1; i < kMeshColorNames.size(); ++i) key(*session, "C");
  EXPECT_EQ(colors(), byInstance);
  open({.colors = {ColorBy("instance")}});
  EXPECT_EQ(colors(), byInstance);
  open({.colors = {ColorBy("object")}});
  const std::vector<Rgb> byObject = colors();
  EXPECT_EQ(std::set<Rgb>(byObject.begin(), byObject.end()).size(), 2u) << "the road and the car";
  EXPECT_THAT(messageOf([&] { open({.colors = {ColorBy("time")}}); }), testing::HasSubstr("a scene has no time"));
}

// What names a surface in its file, and what labelled it.
TEST_F(SceneViewer, APickNamesTextureAndRule) {
  folder_.write("own.mtl", "newmtl plaster\nmap_Kd wall.png\nnewmtl steel\n");
  folder_.write("wall.png", encodePng(Image(2, 2, {200, 190, 180})));
  folder_.write("own.obj",
                "mtllib own.mtl\nv 0 -4 0\nv 0 4 0\nv 0 4 4\nv 0 -4 4\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                "o left\nusemtl plaster\nf 1/1 2/2 3/3\no right\nusemtl steel\nf 1 3 4\n");
  const std::filesystem::path file = folder_.write(
      "own.yaml",
      "name: own\n" + kSceneHead +
          "  - file: own.obj\n    up: z\n    rules:\n"
          "      - {match: {texture: wall*}, class: building}\n"
          "      - {match: {node: right}, class: fence}\n"
          "  - {primitive: box, size: [1, 1, 1], class: car, material: metal_bare, position: [-3, 0, 0]}\n");
  const ViewMesh mesh = loadViewMesh({file, 1});
  ASSERT_EQ(mesh.problem, "");
  std::set<std::string> texturesAndRules;
  for (std::size_t t = 0; t < mesh.size(); ++t) {
    const PickedElement picked = describeTriangle(mesh, t, {});
    texturesAndRules.insert(rowOf(picked, "object") + " | " + rowOf(picked, "texture") + " | " +
                            rowOf(picked, "class by"));
  }
  EXPECT_THAT(texturesAndRules,
              testing::UnorderedElementsAre("own: left | wall.png | line 8: building (texture: wall*)",
                                            "own: right | none | line 9: fence (node: right)",
                                            "box | none | line 10: car (of the object)"));
  for (const auto& [by, colorsExpected] : {std::pair(MeshColor::Texture, 2), {MeshColor::Rule, 3}}) {
    const Coloring coloring = colorMesh(mesh, by);
    std::uint64_t counted = 0;
    for (const LegendEntry& entry : coloring.legend.entries) counted += entry.points;
    EXPECT_EQ(counted, mesh.size());
    EXPECT_EQ(coloring.legend.entries.size(), static_cast<std::size_t>(colorsExpected));
    EXPECT_EQ(std::set(coloring.colors.begin(), coloring.colors.end()).size(),
              static_cast<std::size_t>(colorsExpected));
  }
}

TEST_F(SceneViewer, WarnsOfRulesThatGiveNothing) {
  folder_.write("own.obj", "v 0 -4 0\nv 0 4 0\nv 0 4 4\no left\nf 1 2 3\n");
  const std::filesystem::path file = folder_.write("own.yaml", kWallScene +
                                                                   "  - file: own.obj\n    up: z\n    rules:\n"
                                                                   "      - {match: {node: l*}, class: building}\n"
                                                                   "      - {match: {node: left}, class: fence}\n"
                                                                   "      - {match: {node: rigth}, class: wall}\n");
  ViewSession session(openFrames({.path = file}), canvas_, {});
  session.drawWhenLoaded();
  EXPECT_THAT(session.hints(),
              testing::ElementsAre(testing::HasSubstr("own.yaml:10:9"), testing::HasSubstr("own.yaml:11:9")));
}

// However large it is, in a row or along a diagonal, whose bounding box is mostly empty: all of what the most of it is
// in is in the picture, which it nearly fills.
TEST_F(SceneViewer, NamedViewsShowAllOfIt) {
  for (const auto& [view, houses, aside] : {std::tuple("above", 1, 7), {"above", 30, 7}, {"chase", 40, 20}}) {
    SCOPED_TRACE(fmt::format("{} {}", view, houses));
    std::string scene = kWallScene;
    for (int i = 0; i < houses; ++i) {
      scene += fmt::format(
          "  - {{primitive: box, size: [9, 12, 7], class: building, material: brick, position: [{}, {}, 3]}}\n", 31 * i,
          100 + aside * i);
    }
    const std::filesystem::path file = folder_.write("houses.yaml", scene);
    ViewSession session(openFrames({.path = file}), canvas_, {.camera = parseCamera(view)});
    session.drawWhenLoaded();
    const ViewCamera& camera = canvas_.views().at(0).camera;
    const PixelRect& rect = canvas_.views().at(0).rect;
    const ViewMesh mesh = loadViewMesh({file, 1, 0});
    Box shown;
    for (const Vec3f& corner : mesh.corners) {
      const Vec3d p(corner);
      const bool beyond =
          p.x < mesh.core.low.x || p.y < mesh.core.low.y || p.x > mesh.core.high.x || p.y > mesh.core.high.y;
      if (beyond && aside == 7) continue;  // the ends of a row
      const Projected at = camera.project(p);
      shown.add(Vec3d{at.x, at.y, 0});
    }
    EXPECT_GE(std::min(shown.low.x, shown.low.y), 0);
    EXPECT_LE(shown.high.x, rect.width);
    EXPECT_LE(shown.high.y, rect.height);
    EXPECT_GT(std::max((shown.high.x - shown.low.x) / rect.width, (shown.high.y - shown.low.y) / rect.height), 0.7);
  }
}

// What a pick says of a place, a camera takes: that place is in the middle then.
TEST_F(SceneViewer, CamerasAimAtThePlacesOfPicks) {
  const auto session = open({.camera = parseCamera("10,40,15,15,100,1.75")});  // the middle of the car's roof
  const PixelRect& rect = canvas_.views().at(0).rect;
  const auto picked = session->pick(rect.left + rect.width / 2, rect.top + rect.height / 2);
  ASSERT_TRUE(picked.has_value());
  EXPECT_THAT(picked->heading, testing::HasSubstr("car"));
  const ViewCamera camera = canvas_.views().at(0).camera;
  const double middle = rect.width / 2 + 0.5;  // of the pixel
  EXPECT_NEAR(camera.project(picked->position).x, middle, 0.1);
  for (const auto& [row, expected] : {std::pair("world x", 15.0), {"world y", 100.0}, {"world z", 1.75}}) {
    EXPECT_NEAR(std::stod(rowOf(*picked, row)), expected, 0.03) << row;  // half a pixel
  }
  key(*session, "F1");
  EXPECT_GT(std::abs(canvas_.views().at(0).camera.project(picked->position).y - rect.height / 2), 1);
  key(*session, "Home");
  EXPECT_NEAR(canvas_.views().at(0).camera.project(picked->position).x, camera.project(picked->position).x, 1e-6);
}

TEST_F(SceneViewer, SaysWhatMeansNothing) {
  for (const char* name :
       {"4", "+", "-", "r", "t", "m", "Right", "Page_Up", ">", " ", "g", "l", "s", "Tab", "n", "w", "i"}) {
    const auto session = open();
    const std::vector<Rgba> before = canvas_.overlay();
    const std::size_t items = canvas_.items.size();
    key(*session, name);
    EXPECT_NE(canvas_.overlay(), before) << name;
    EXPECT_EQ(canvas_.items.size(), items) << name;
    session->drawWhenLoaded();
    EXPECT_EQ(canvas_.overlay(), before) << name << ": it was a notice";
  }
}

TEST(SessionHelp, IsPagedByTheWheel) {
  SessionWorld world(1);
  world.canvas.resize(400, 300);
  world.send({.kind = CanvasEvent::Kind::Resize});
  const OrbitCamera before = world.session->camera();
  world.key("h");
  const auto first = world.canvas.overlay();
  world.wheel(-1);
  world.session->drawWhenLoaded();
  const auto second = world.canvas.overlay();
  EXPECT_NE(second, first);
  for (int i = 0; i < 20; ++i) world.wheel(-1);
  world.session->drawWhenLoaded();
  EXPECT_NE(world.canvas.overlay(), second);
  for (int i = 0; i < 40; ++i) world.wheel(1);
  world.session->drawWhenLoaded();
  EXPECT_EQ(world.canvas.overlay(), first);
  EXPECT_EQ(world.session->camera(), before) << "the wheel turned pages only";
}

TEST(SessionStrip, OfAnOverlayHasTheColoursOfClasses) {
  SessionWorld world(1, {"ray_tracing", "depth_camera"}, {.layout = ViewLayout::Overlay, .rangeImage = true});
  EXPECT_TRUE(world.inOverlay(kFakeRoadColor));
  EXPECT_TRUE(world.inOverlay(kFakeCarColor));
  world.key("i");
  EXPECT_FALSE(world.inOverlay(kFakeRoadColor));
}

}  // namespace
}  // namespace scanmill
