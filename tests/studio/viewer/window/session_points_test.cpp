// What is shown of scans: filters, colours, views, what lies under the pointer.

#include <cstdlib>
#include <random>
#include <set>

#include "tests/studio/viewer/window/session_world.h"
#include "tests/support/message_of.h"
#include "viewer/picture.h"
#include "viewer/window/session.h"

namespace scanmill {
namespace {

using Kind = CanvasEvent::Kind;

std::set<Rgb> colorsOf(const Image& image) {
  return {image.pixels.begin(), image.pixels.end()};
}

std::set<std::uint16_t> shownClasses(const SessionWorld& world, std::size_t frame) {
  std::set<std::uint16_t> classes;
  for (const std::uint32_t i : world.canvas.shownOf(firstCloud(world))) {
    classes.insert(world.frames->frames[frame].scans[0].scan[kLabel][i]);
  }
  return classes;
}

double numberOf(const PickedElement& picked, const std::string& name) {
  return std::strtod(rowOf(picked, name).c_str(), nullptr);
}

TEST(SessionFilter, AClickInTheLegendHidesAClass) {
  SessionWorld world(3);
  const auto at = world.inOverlay(kFakeCarColor);
  ASSERT_TRUE(at);
  world.click(at->first, at->second);
  world.pointer(Kind::Move, 5, 100);
  world.session->drawWhenLoaded();
  EXPECT_EQ(shownClasses(world, 1), (std::set<std::uint16_t>{kFakeRoad, kFakeTree}));
  // Whatever the colours and the frame.
  world.key("4");
  EXPECT_EQ(shownClasses(world, 1), (std::set<std::uint16_t>{kFakeRoad, kFakeTree}));
  world.press("Right");
  EXPECT_EQ(shownClasses(world, 2), (std::set<std::uint16_t>{kFakeRoad, kFakeTree}));
  world.key("1");
  world.click(at->first, at->second);
  EXPECT_EQ(shownClasses(world, 2).size(), 3u);
  world.click(at->first, at->second, true);  // alone
  EXPECT_EQ(shownClasses(world, 2), (std::set<std::uint16_t>{kFakeCar}));
  world.key("A");
  EXPECT_EQ(shownClasses(world, 2).size(), 3u);
}

TEST(SessionFilter, OptionsHideOrShowAlone) {
  const SessionWorld hidden(1, {"ray_tracing"}, {.hidden = {"road", "20"}});
  EXPECT_EQ(shownClasses(hidden, 0), (std::set<std::uint16_t>{kFakeTree}));
  const SessionWorld alone(1, {"ray_tracing"}, {.hidden = {"road", "20"}, .only = true});
  EXPECT_EQ(shownClasses(alone, 0), (std::set<std::uint16_t>{kFakeRoad, kFakeCar}));
}

// A close-up shows the points in its ball alone, from the direction that was chosen, until all points are asked for.
TEST(SessionCloseUp, ShowsTheBallAndFillsThePictureWithIt) {
  const Scan scan = fakeScan(8, 72, 1.001);
  const Vec3d at(scan.position[3 * 72 + 5]);
  for (const char* const view : {"chase", "driver", "above"}) {
    for (const double within : {1.0, 4.0}) {
      SCOPED_TRACE(std::string(view) + " " + std::to_string(within));
      SessionWorld world(3, {"ray_tracing"}, {.camera = parseCamera(view), .closeUp = CloseUp{at, within}});
      const auto& item = world.canvas.items.at(firstCloud(world));
      const CanvasView& seen = world.canvas.views().front();
      std::set<std::uint32_t> expected;
      double farthest = 0;
      for (std::uint32_t i = 0; i < scan.size(); ++i) {
        if (length(Vec3d(scan.position[i]) - at) > within) continue;
        expected.insert(i);
        const Projected p = seen.camera.project(item.look.canvasFromItem * Vec3d(scan.position[i]));
        farthest = std::max({farthest, std::abs(p.x - seen.rect.width / 2.0), std::abs(p.y - seen.rect.height / 2.0)});
      }
      const auto shown = world.canvas.shownOf(firstCloud(world));
      EXPECT_EQ(std::set<std::uint32_t>(shown.begin(), shown.end()), expected);
      EXPECT_LT(farthest, seen.rect.height / 2.0) << "all of it is seen";
      EXPECT_NEAR(length(world.session->camera().target - item.look.canvasFromItem * at), 0, 1e-5);
      EXPECT_EQ(world.session->camera().yaw, parseCamera(view).camera.yaw);
      EXPECT_EQ(world.session->camera().pitch, parseCamera(view).camera.pitch);
      EXPECT_NO_THROW(world.session->check());
      world.press("Right");
      EXPECT_LT(world.canvas.shownOf(firstCloud(world)).size(), scan.size()) << "it stays in other frames";
      world.key("A");
      EXPECT_EQ(world.canvas.shownOf(firstCloud(world)).size(), scan.size());
    }
  }
}

TEST(SessionCloseUp, IsSeenFromTheDirectionAndDistanceThatAreGiven) {
  const Vec3d at(fakeScan(8, 72, 1.001).position[3 * 72 + 5]);
  const SessionWorld world(3, {"ray_tracing"}, {.camera = parseCamera("30,20,25"), .closeUp = CloseUp{at, 2}});
  const OrbitCamera camera = world.session->camera();
  EXPECT_NEAR(camera.yaw, radians(30), 1e-12);
  EXPECT_NEAR(camera.pitch, radians(20), 1e-12);
  EXPECT_EQ(camera.distance, 25);
  EXPECT_NEAR(length(camera.target - world.canvas.items.at(firstCloud(world)).look.canvasFromItem * at), 0, 1e-5);
}

TEST(SessionCloseUp, OfNothingSaysWhereThePointsAre) {
  SessionWorld world(1, {"ray_tracing"}, {.closeUp = CloseUp{{0, 0, 50}, 2}});
  EXPECT_THAT(messageOf<InputError>([&] { world.session->check(); }),
              testing::AllOf(testing::HasSubstr("within 2 m of 0,0,50"), testing::HasSubstr("m from there, at "),
                             testing::HasSubstr("--within")));
}

// The tip's values are the scan's, for points all over the picture and from random places.
TEST(SessionPicking, ATipHoldsTheColumnsOfItsPoint) {
  SessionWorld world(3);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  const ViewScan& viewed = world.frames->frames[1].scans[0];
  const Scan& scan = viewed.scan;
  int pickedPoints = 0;
  for (int round = 0; round < 40; ++round) {
    OrbitCamera camera = presetCamera(View::Chase);
    camera.yaw = kPi * unit(random);
    camera.pitch = 0.7 + 0.6 * unit(random);
    camera.orthographic = round % 4 == 0;
    world.session->setCamera(camera);
    world.session->drawWhenLoaded();
    for (std::size_t i = 0; i < scan.size(); i += 31) {
      const auto [x, y] = world.pixelOf(firstCloud(world), i);
      const auto picked = world.session->pick(x, y);
      const PixelRect& rect = world.canvas.views().front().rect;
      const Projected own = world.canvas.views().front().camera.project(Vec3d(scan.position[i]));
      if (!rect.contains(x, y) || own.depth < 0.5) continue;
      ASSERT_TRUE(picked);
      const std::size_t p = picked->point;
      const Projected found = world.canvas.views().front().camera.project(Vec3d(scan.position[p]));
      EXPECT_LE(found.depth, own.depth + 1e-3);
      EXPECT_EQ(picked->scan, 0u);
      EXPECT_NEAR(length(picked->position - Vec3d(scan.position[p])), 0, 1e-9);
      const Vec3d at(scan.position[p]);
      for (const auto& [row, value, within] :
           std::initializer_list<std::tuple<const char*, double, double>>{{"x", at.x, 6e-4},
                                                                          {"y", at.y, 6e-4},
                                                                          {"z", at.z, 6e-4},
                                                                          {"range", length(at), 6e-4},
                                                                          {"intensity", scan[kIntensity][p], 1e-4},
                                                                          {"range_true", scan[kRangeTrue][p], 1e-4},
                                                                          {"time", scan[kTime][p] * 1e3, 1e-3},
                                                                          {"incidence", degrees(0.5), 1e-2},
                                                                          {"range error", 0.01, 1e-4},
                                                                          {"ring", scan[kRing][p], 0},
                                                                          {"column", scan[kColumn][p], 0},
                                                                          {"point", p, 0}}) {
        EXPECT_NEAR(numberOf(*picked, row), value, within) << row;
      }
      EXPECT_NEAR(std::remainder(radians(numberOf(*picked, "azimuth")) - std::atan2(at.y, at.x), 2 * kPi), 0, 1e-4);
      EXPECT_EQ(rowOf(*picked, "sensor"), "top");
      EXPECT_EQ(rowOf(*picked, "method"), "ray_tracing");
      const bool car = scan[kLabel][p] == kFakeCar;
      EXPECT_EQ(rowOf(*picked, "class"), car ? "car (20)" : scan[kLabel][p] == kFakeTree ? "tree (2)" : "road (1)");
      EXPECT_EQ(rowOf(*picked, "instance"), car ? "4711" : "none");
      EXPECT_EQ(picked->heading, car ? "car 4711" : scan[kLabel][p] == kFakeTree ? "tree" : "road");
      ++pickedPoints;
    }
  }
  EXPECT_GT(pickedPoints, 200);
}

TEST(SessionPicking, ItsBeamIsTheSensors) {
  auto frames = std::make_shared<FakeFrames>(1);
  auto beams = std::make_shared<BeamTable>();
  beams->rings = 8;
  beams->columns = 72;
  for (std::uint32_t i = 0; i < 8 * 72; ++i) {
    const double azimuth = 2 * kPi * (i % 72) / 72 + 0.01;  // not where the point is
    beams->direction.push_back(normalized(Vec3d{std::cos(azimuth), std::sin(azimuth), -0.1}));
    beams->time.push_back(static_cast<float>(i) * 1e-5F);
  }
  frames->frames[0].scans[0].beams = beams;
  SessionWorld world(frames);
  const auto [x, y] = world.pixelOf(firstCloud(world), 4 * 72 + 3);
  const auto picked = world.session->pick(x, y);
  ASSERT_TRUE(picked);
  const auto beam = static_cast<std::size_t>(numberOf(*picked, "ring") * 72 + numberOf(*picked, "column"));
  const Vec3d d = beams->direction[beam];
  EXPECT_NEAR(numberOf(*picked, "beam azimuth"), degrees(std::atan2(d.y, d.x)), 1e-3);
  EXPECT_NEAR(numberOf(*picked, "beam elevation"), degrees(std::asin(d.z)), 1e-3);
  EXPECT_NEAR(numberOf(*picked, "beam fires at"), beams->time[beam] * 1e3, 1e-4);
}

// Beams that several scans have: joined by ring and column.
TEST(SessionPicking, TheSameBeamOfTheOtherScans) {
  for (const ViewLayout layout : {ViewLayout::Split, ViewLayout::Overlay}) {
    auto frames = std::make_shared<FakeFrames>(1, std::vector<std::string>{"ray_tracing", "depth_camera", "particle"});
    auto& scans = frames->frames[0].scans;
    Scan& other = scans[1].scan;
    other.position[3 * 72 + 70] = {1, 2, 2};
    other[kRing][3 * 72] = 99;  // no return of that beam
    scans[2].scan.columns = 360;
    const SessionWorld world(frames, {.layout = layout});
    for (const bool returned : {true, false}) {
      const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72 + (returned ? 70 : 0));
      const auto picked = world.session->pick(x, y);
      ASSERT_TRUE(picked);
      if (picked->scan != 0 || picked->point != 3u * 72 + (returned ? 70 : 0)) continue;
      EXPECT_EQ(rowOf(*picked, "scan"), "fake: top, ray_tracing");
      EXPECT_EQ(rowOf(*picked, "top, depth_camera"), returned ? "3.00 m, car" : "no return");
      EXPECT_EQ(rowOf(*picked, "top, particle"), "") << "another sensor";
    }
  }
}

// The pointer rests, and something else comes to lie below it.
TEST(SessionPicking, IsRenewedUnderAPointerAtRest) {
  SessionWorld world(3);
  const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72 + 70);
  const auto settled = [&] {
    world.session->drawWhenLoaded();
    return world.canvas.overlay();
  };
  world.pointer(Kind::Move, x, y);
  const auto before = settled();
  world.wheel(4);
  world.pointer(Kind::Move, x, y);
  const auto moved = settled();
  EXPECT_NE(moved, before);
  for (const char* key : {"Home", "s", "s", "w", "Right", "F3"}) {
    world.key(key);
    const auto rested = settled();
    world.pointer(Kind::Move, x, y);  // says nothing new
    EXPECT_EQ(settled(), rested) << key;
  }
}

// The line that joins two clicks is as long as the two points are apart.
TEST(SessionMeasure, JoinsTwoClicks) {
  SessionWorld world(2);
  const auto linesOf = [&] {
    std::vector<std::vector<Vec3f>> all;
    for (const auto& [id, item] : world.canvas.items) {
      if (item.kind == ItemKind::Segments && item.places.size() == 2) all.push_back(item.places);
    }
    return all;
  };
  const Scan& scan = world.frames->frames[1].scans[0].scan;
  const auto a = world.pixelOf(firstCloud(world), 3 * 72 + 2);
  const auto b = world.pixelOf(firstCloud(world), 5 * 72 + 70);
  const auto first = world.session->pick(a.first, a.second);
  const auto second = world.session->pick(b.first, b.second);
  ASSERT_TRUE(first && second && first->point != second->point);
  const double wanted = length(Vec3d(scan.position[first->point]) - Vec3d(scan.position[second->point]));
  EXPECT_TRUE(linesOf().empty());
  world.key("d");
  world.click(a.first, a.second);
  EXPECT_TRUE(linesOf().empty());
  world.click(b.first, b.second);
  ASSERT_EQ(linesOf().size(), 1u);
  EXPECT_NEAR(length(Vec3d(linesOf()[0][0]) - Vec3d(linesOf()[0][1])), wanted, 1e-5);
  world.key("d");
  EXPECT_TRUE(linesOf().empty());
  // From the pinned point: one click is enough.
  world.click(a.first, a.second);
  world.key("d");
  world.click(b.first, b.second);
  ASSERT_EQ(linesOf().size(), 1u);
  EXPECT_NEAR(length(Vec3d(linesOf()[0][0]) - Vec3d(linesOf()[0][1])), wanted, 1e-5);
  world.key("Escape");
  EXPECT_TRUE(linesOf().empty());
}

TEST(SessionViews, AnOverlayHasThePapersColours) {
  SessionWorld world(1, {"ray_tracing", "depth_camera", "particle"}, {.layout = ViewLayout::Overlay});
  const auto items = world.canvas.pointItems();
  ASSERT_EQ(items.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    for (const Rgb& c : world.canvas.items.at(items[k]).colors) ASSERT_EQ(c, overlayColor(k));
    EXPECT_EQ(world.canvas.items.at(items[k]).look.views, 1u);
  }
  const auto at = world.inOverlay(overlayColor(1));
  ASSERT_TRUE(at);
  world.click(at->first, at->second);
  EXPECT_FALSE(world.canvas.shownOf(items[0]).empty());
  EXPECT_TRUE(world.canvas.shownOf(items[1]).empty());
  world.click(at->first, at->second, true);
  EXPECT_TRUE(world.canvas.shownOf(items[0]).empty());
  EXPECT_FALSE(world.canvas.shownOf(items[1]).empty());
  EXPECT_TRUE(world.canvas.shownOf(items[2]).empty());
  // What is picked is of the scan that is left.
  const auto [x, y] = world.pixelOf(items[1], 3 * 72);
  const auto picked = world.session->pick(x, y);
  ASSERT_TRUE(picked);
  EXPECT_EQ(picked->scan, 1u);
  world.key("l");
  EXPECT_EQ(world.canvas.pointItems().size(), 1u);
}

TEST(SessionViews, SplitCamerasAreLinked) {
  SessionWorld world(1, {"ray_tracing", "depth_camera", "particle"}, {.layout = ViewLayout::Split});
  ASSERT_EQ(world.canvas.views().size(), 3u);
  const auto items = world.canvas.pointItems();
  ASSERT_EQ(items.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(world.canvas.items.at(items[k]).look.views, 1u << k);
  const Vec3d before = world.canvas.views()[2].camera.eye;
  const PixelRect second = world.canvas.views()[1].rect;
  world.drag(second.left + second.width / 2, second.top + second.height / 2, 60, 25);
  world.wheel(2);
  world.tick();
  const auto& views = world.canvas.views();
  EXPECT_GT(length(views[2].camera.eye - before), 0.1);
  for (const CanvasView& view : views) {
    EXPECT_EQ(view.camera.eye, views[0].camera.eye);
    EXPECT_EQ(view.camera.forward, views[0].camera.forward);
  }
}

TEST(SessionViews, OneScanSplitsIntoTwoColours) {
  SessionWorld world(1);
  world.key("s");
  const auto items = world.canvas.pointItems();
  ASSERT_EQ(items.size(), 2u);
  ASSERT_EQ(world.canvas.views().size(), 2u);
  const auto colors = [&](std::size_t k) { return world.canvas.items.at(items[k]).colors; };
  EXPECT_EQ(world.canvas.items.at(items[0]).places, world.canvas.items.at(items[1]).places);
  EXPECT_NE(colors(0), colors(1));
  const auto left = colors(0);
  const auto right = colors(1);
  world.key("c");  // of the right one
  EXPECT_EQ(colors(0), left);
  EXPECT_NE(colors(1), right);
  const auto now = colors(1);
  world.key("Tab");
  world.key("c");
  EXPECT_NE(colors(0), left);
  EXPECT_EQ(colors(1), now);
}

TEST(SessionViews, TheNextScanIsChosenByName) {
  SessionWorld world(3, {"ray_tracing", "depth_camera"});
  const auto scanOn = [&](std::size_t frame) {
    const auto& places = world.canvas.items.at(firstCloud(world)).places;
    return places == world.frames->frames[frame].scans[0].scan.position ? 0 : 1;
  };
  EXPECT_EQ(scanOn(1), 0);
  world.key("n");
  EXPECT_EQ(scanOn(1), 1);
  world.press("Right");
  EXPECT_EQ(scanOn(2), 1);
  world.key("n");
  EXPECT_EQ(scanOn(2), 0);
}

TEST(SessionStrip, IsLinkedBothWays) {
  SessionWorld world(1, {"ray_tracing"}, {.rangeImage = true});
  const Scan& scan = world.frames->frames[0].scans[0].scan;
  const PixelRect& view = world.canvas.views().front().rect;
  // A click in the strip turns the camera to the point of that pixel: the ring from its row, the column from its place.
  std::set<std::uint16_t> columns;
  std::set<std::uint16_t> rings;
  double lastAzimuth = 4;  // rad; from left to right it falls
  std::pair<int, int> inStrip{-1, -1};
  for (int y = view.top + view.height; y < SessionWorld::kHeight; y += 5) {
    lastAzimuth = 4;
    for (int x = 2; x < SessionWorld::kWidth; x += 13) {
      const OrbitCamera before = world.session->camera();
      world.click(x, y);
      const OrbitCamera after = world.session->camera();
      if (after == before) continue;
      for (std::size_t i = 0; i < scan.size(); ++i) {
        if (Vec3d(scan.position[i]) != after.target) continue;
        double azimuth = std::atan2(double{scan.position[i].y}, double{scan.position[i].x});
        if (azimuth < -3.1 && lastAzimuth == 4) azimuth += 2 * kPi;  // straight behind
        EXPECT_LE(azimuth, lastAzimuth);
        lastAzimuth = azimuth;
        columns.insert(scan[kColumn][i]);
        rings.insert(scan[kRing][i]);
        if (scan.position[i].x > 3 * std::abs(scan.position[i].y)) inStrip = {x, y};  // ahead: it is seen
      }
    }
  }
  EXPECT_GT(columns.size(), 60u);
  EXPECT_EQ(rings.size(), 8u);
  // Pointing at a point in space marks a pixel of the strip, and the other way round.
  world.key("Escape");
  world.key("Home");
  world.pointer(Kind::Move, 3, view.top + 3);
  world.session->drawWhenLoaded();
  const auto partOf = [&](bool below) {
    const auto edge =
        world.canvas.overlay().begin() + static_cast<std::ptrdiff_t>(view.top + view.height) * SessionWorld::kWidth;
    return below ? std::vector<Rgba>(edge, world.canvas.overlay().end())
                 : std::vector<Rgba>(world.canvas.overlay().begin(), edge);
  };
  const auto strip = partOf(true);
  const auto space = partOf(false);
  const auto [x, y] = world.pixelOf(firstCloud(world), 4 * 72);
  world.pointer(Kind::Move, x, y);
  world.tick();
  EXPECT_NE(partOf(true), strip);
  world.pointer(Kind::Move, 3, view.top + 3);
  world.tick();
  EXPECT_EQ(partOf(true), strip);
  world.pointer(Kind::Move, inStrip.first, inStrip.second);
  world.tick();
  EXPECT_NE(partOf(false), space);
}

// By OpenGL, where there is one: the picture's colours are those of the classes that are shown, and of what is picked.
TEST(SessionOffscreen, PicturesHoldWhatIsShown) {
  std::unique_ptr<Canvas> canvas;
  try {
    canvas = openOffscreen(640, 480);
  } catch (const Error& e) {
    if (std::string(e.what()).find("no OpenGL") == std::string::npos) throw;
    GTEST_SKIP() << e.what();
  }
  const auto frames = std::make_shared<FakeFrames>(1);
  const auto classColors = [&](const ViewOptions& options) {
    ViewSession session(frames, *canvas, options);
    session.drawWhenLoaded();
    const std::set<Rgb> all = colorsOf(session.picture());
    std::set<Rgb> found;
    for (const Rgb& c : {kFakeRoadColor, kFakeTreeColor, kFakeCarColor}) {
      if (all.contains(c)) found.insert(c);
    }
    return found;
  };
  EXPECT_EQ(classColors({.depthEdges = false}), (std::set<Rgb>{kFakeRoadColor, kFakeTreeColor, kFakeCarColor}));
  EXPECT_EQ(classColors({.depthEdges = false, .hidden = {"car"}}), (std::set<Rgb>{kFakeRoadColor, kFakeTreeColor}));
  ViewSession session(frames, *canvas, {.pointSize = 4, .depthEdges = false, .axes = false, .bare = true});
  session.drawWhenLoaded();
  const Image picture = session.picture();
  int same = 0;
  for (int y = 0; y < picture.height; y += 3) {
    for (int x = 0; x < picture.width; x += 3) {
      for (const auto& [color, name] : {std::pair{kFakeRoadColor, "road"}, std::pair{kFakeTreeColor, "tree"},
                                        std::pair{kFakeCarColor, "car 4711"}}) {
        if (picture.at(x, y) != color) continue;
        const auto picked = session.pick(x, y);
        ASSERT_TRUE(picked) << x << "," << y;
        EXPECT_EQ(picked->heading, name);
        ++same;
      }
    }
  }
  EXPECT_GT(same, 30);
}

}  // namespace
}  // namespace scanmill
