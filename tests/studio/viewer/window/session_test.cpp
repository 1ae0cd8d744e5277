// The viewer's keys, frames and messages.

#include "viewer/window/session.h"

#include <chrono>
#include <map>
#include <set>
#include <sstream>

#include "tests/studio/viewer/window/session_world.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"
#include "viewer/window/canvas_items.h"
#include "viewer/window/view_options.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Kind = CanvasEvent::Kind;

const std::vector<std::string> kMethods{"ray_tracing", "depth_camera"};

class CurrentFolder {
 public:
  CurrentFolder() : before_(std::filesystem::current_path()) { std::filesystem::current_path(folder_.path()); }
  ~CurrentFolder() { std::filesystem::current_path(before_); }

 private:
  TemporaryFolder folder_;
  std::filesystem::path before_;
};

// What is on the canvas beneath the panels, by what a user would name it.
std::map<std::string, std::string> aspectsOf(const SessionWorld& world) {
  std::map<std::string, std::string> aspects;
  const auto put = [&](const char* name, const auto&... values) {
    std::ostringstream out;
    out.precision(17);
    ((out << values << ' '), ...);
    aspects[name] += out.str();
  };
  const auto text = [](const Vec3d& v) {
    return std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z);
  };
  const CanvasView& first = world.canvas.views().front();
  put("camera", text(first.camera.eye), text(first.camera.forward), first.camera.orthographic);
  put("background", int{first.background[0]});
  put("edges", first.depthEdges);
  put("views", world.canvas.views().size());
  for (const auto& [id, item] : world.canvas.items) {
    if (item.kind == ItemKind::Points && id != kHighlightItem) {
      put("clouds", id, item.look.views);
      put("size", item.look.size);
      put("frame", item.look.canvasFromItem.translation.x, item.places.front().x);
      put("shown", world.canvas.shownOf(id).size());
      for (const Rgb& c : item.colors) put("colours", int{c[0]}, int{c[1]}, int{c[2]});
    }
    const std::map<ItemId, const char*> lines{
        {kAxesItem, "axes"}, {kRangeRingsItem, "rings"}, {kTrackItem, "track"}, {kBoxesItem, "boxes"}};
    if (lines.contains(id)) put(lines.at(id), item.places.empty());
  }
  return aspects;
}

// Each key changes on the canvas what its command names, and nothing else; the others change panels alone, which are
// tested one by one.
TEST(ViewSession, EveryKeyDoesWhatItSays) {
  using Do = std::function<void(SessionWorld&)>;
  using Aspects = std::set<std::string>;
  const CurrentFolder folder;
  const auto press = [](std::vector<std::string> keys) -> Do {
    return [keys](SessionWorld& w) {
      for (const std::string& k : keys) w.key(k);
    };
  };
  const auto pointAt = [](std::size_t point) -> Do {
    return [point](SessionWorld& w) {
      const auto [x, y] = w.pixelOf(firstCloud(w), point);
      w.pointer(Kind::Move, x, y);
    };
  };
  const Do nearer = [](SessionWorld& w) { w.wheel(3); };
  // What must be so before a key has something to do.
  std::map<std::string, Do> before;
  before["1"] = press({"9"});
  before["A"] = [](SessionWorld& w) {
    const auto at = w.inOverlay(kFakeCarColor);
    ASSERT_TRUE(at);
    w.click(at->first, at->second);
  };
  for (const char* key : {"F1", "F2", "F3", "Home"}) before[key] = nearer;
  before["f"] = pointAt(3 * 72);
  before["x"] = pointAt(3 * 72 + 70);
  before["Escape"] = press({"h"});
  // The keys of this table are the first keys of the commands.
  std::map<std::string, Aspects> changes{{"a", {"axes"}},
                                         {"r", {"rings"}},
                                         {"t", {"track"}},
                                         {"e", {"edges"}},
                                         {"b", {"background"}},
                                         {"O", {"boxes"}},
                                         {"l", {"clouds", "colours", "frame", "shown", "size"}},
                                         {"s", {"clouds", "colours", "frame", "shown", "size", "views"}},
                                         {"n", {"colours", "frame"}},
                                         {"M", {"camera", "colours", "frame", "shown"}},
                                         {"w", {"camera", "frame"}}};
  const auto expect = [&](const char* aspect, const std::vector<const char*>& keys) {
    for (const char* key : keys) changes[key] = {aspect};
  };
  expect("size", {"+", "-"});
  expect("shown", {"A", "x"});
  expect("colours", {"1", "2", "3", "4", "5", "6", "7", "8", "9", "0", "c", "C", "\\"});
  expect("frame", {"Right", "Left", "Page_Down", "Page_Up", "<", ">"});
  expect("camera", {"F1", "F2", "F3", "Home", "f", "o"});
  for (const ViewCommand& command : ViewSession::commands()) {
    for (const std::string& key : command.keys) {
      SCOPED_TRACE(key + ": " + command.label);
      const bool scaled = key == "\\";
      SessionWorld world(3, kMethods,
                         scaled ? ViewOptions{.colors = {kByRange}, .scale = ScaleRange{0, 5}} : ViewOptions{});
      if (before.contains(key)) before[key](world);
      world.session->drawWhenLoaded();
      const std::string was = world.drawn();
      const auto had = aspectsOf(world);
      const bool open = world.key(key);
      const std::string now = world.drawn();
      world.session->drawWhenLoaded();  // neighbouring frames are loaded in the background
      EXPECT_TRUE(!open || now != was || world.drawn() != was);
      EXPECT_EQ(open, key != "q");
      Aspects changed;
      for (const auto& [name, value] : aspectsOf(world)) {
        if (value != had.at(name)) changed.insert(name);
      }
      EXPECT_EQ(changed, changes[command.keys.front()]);
    }
  }
}

TEST(ViewSession, EveryGestureDoesSomething) {
  std::vector<std::function<void(SessionWorld&)>> gestures{
      [](SessionWorld& w) { w.drag(300, 300, 40, 20); },
      [](SessionWorld& w) { w.drag(300, 300, 40, 20, 3); },
      [](SessionWorld& w) { w.drag(300, 300, 40, 20, 2); },
      [](SessionWorld& w) { w.drag(300, 300, 40, 20, 1, true); },
      [](SessionWorld& w) { w.wheel(1); },
      [](SessionWorld& w) { w.wheel(-2); },
  };
  for (const bool legend : {false, true}) {
    for (const auto& [shift, twice] : {std::pair(false, false), {true, false}, {false, true}}) {
      gestures.emplace_back([=](SessionWorld& w) {
        const auto [x, y] = legend ? w.inOverlay(kFakeCarColor).value() : w.pixelOf(firstCloud(w), 3 * 72);
        w.click(x, y, shift);
        if (twice) w.pointer(Kind::Down, x, y, 1, false, 2);
      });
    }
  }
  for (std::size_t i = 0; i < gestures.size(); ++i) {
    SessionWorld world(3, kMethods);
    const std::string was = world.drawn();
    gestures[i](world);
    world.session->drawWhenLoaded();
    EXPECT_NE(world.drawn(), was) << i;
  }
}

// What a menu has is what its key does.
TEST(ViewSession, MenusDoWhatKeysDo) {
  SessionWorld byKey(3);
  byKey.press("F3");
  SessionWorld byMenu(3);
  byMenu.pointer(Kind::Move, 1, 1);
  const auto press = [&](int x, int y) {
    byMenu.click(x, y);
    byMenu.session->drawWhenLoaded();
  };
  bool found = false;
  for (int x = 10; x < 500 && !found; x += 12) {
    press(x, 10);
    for (int y = 30; y < 220 && !found; y += 8) {
      press(x + 20, y);
      found = byMenu.session->camera() == byKey.session->camera();
      if (!found) press(x, 10);
    }
    byMenu.key("Escape");
  }
  EXPECT_TRUE(found) << "Camera: from above";
}

TEST(ViewSession, EscapeClosesWhatIsOpenAndNeverTheViewer) {
  SessionWorld world(3);
  const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72);
  world.click(x, y);
  world.key("h");
  world.key("g");
  EXPECT_TRUE(world.key("Escape"));  // the prompt
  EXPECT_TRUE(world.key("Escape"));  // the help
  EXPECT_TRUE(world.key("Escape"));  // the pin
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(world.key("Escape"));
  EXPECT_FALSE(world.key("q"));
  EXPECT_FALSE(world.send({.kind = Kind::Close}));
}

// A scene that cannot be read is said; nothing else changes.
TEST(ViewSession, AMeshThatFailsIsNoItem) {
  const TemporaryFolder folder;
  auto frames = std::make_shared<FakeFrames>(3, kMethods);
  frames->scenes = {folder.path() / "absent.yaml", folder.write("wall.yaml", kWallScene),
                    folder.write("bad.yaml", "objects: 3\n")};
  frames->frames[2].scans[0].worldFromSensor.reset();
  frames->frames[2].scans[1].worldFromSensor.reset();
  const auto triangles = [](const SessionWorld& w) {
    std::size_t count = 0;
    for (const auto& [id, item] : w.canvas.items) {
      if (item.kind == ItemKind::Triangles) count += item.colors.size();
    }
    return count;
  };
  SessionWorld world(frames);
  world.press("m");
  EXPECT_EQ(triangles(world), 24u);
  for (const char* key : {"<", ">"}) {
    world.press(key);
    EXPECT_EQ(triangles(world), 0u);
    EXPECT_THAT(world.session->problems(), testing::Contains(HasSubstr(".yaml")));
    const auto [x, y] = world.pixelOf(firstCloud(world), 3 * 72);
    for (const char* pressed : {"n", "l", "c", "s", "A", "w", "2", "x"}) {
      world.pointer(Kind::Move, x, y);
      EXPECT_NO_THROW(world.key(pressed));
      world.session->drawWhenLoaded();
    }
  }
  // Back to a frame that has one, from one whose place in the world is not known.
  world.key("<");
  world.press("Right");
  EXPECT_EQ(triangles(world), 24u);
}

// The frame on the canvas, by the positions of its points.
std::size_t frameOn(const SessionWorld& world) {
  const auto& places = world.canvas.items.at(firstCloud(world)).places;
  for (std::size_t f = 0; f < world.frames->frames.size(); ++f) {
    if (world.frames->frames[f].scans.front().scan.position == places) return f;
  }
  return SIZE_MAX;
}

TEST(ViewSession, TheSliderGoesToEveryFrame) {
  SessionWorld world(12);
  const int low = SessionWorld::kHeight - 18;  // within the bar at the bottom
  std::set<std::size_t> seen;
  world.pointer(CanvasEvent::Kind::Move, 200, low);
  world.pointer(CanvasEvent::Kind::Down, 200, low);
  for (int x = 60; x < SessionWorld::kWidth; x += 4) {
    world.pointer(CanvasEvent::Kind::Move, x, low);
    world.session->drawWhenLoaded();
    seen.insert(frameOn(world));
  }
  world.pointer(CanvasEvent::Kind::Up, SessionWorld::kWidth - 1, low);
  EXPECT_EQ(seen.size(), 12u);
  EXPECT_EQ(frameOn(world), 11u);
}

TEST(ViewSession, StepsThroughFrames) {
  SessionWorld world(25);
  EXPECT_EQ(frameOn(world), 12u);  // the middle one
  const auto goes = [&](const char* key, std::size_t to) {
    world.press(key);
    EXPECT_EQ(frameOn(world), to) << key;
  };
  goes("Right", 13);
  goes("Left", 12);
  goes("Left", 11);
  goes("Page_Down", 21);
  goes("Page_Down", 24);  // no further than the last
  goes("Right", 24);
  goes("<", 0);
  goes("Left", 0);
  goes("Page_Up", 0);
  goes("End", 24);
  goes("<", 0);
  goes(">", 24);
}

TEST(ViewSession, GoesToAKeyOrAnIndex) {
  SessionWorld world(25);
  const auto goes = [&](const std::string& text, std::size_t to) {
    world.key("g");
    world.type(text);
    world.press("Return");
    EXPECT_EQ(frameOn(world), to) << text;
  };
  goes("3", 3);
  goes("sample-117", 17);
  world.key("g");
  world.type("4z");
  world.key("BackSpace");
  world.press("Return");
  EXPECT_EQ(frameOn(world), 4u);
  // Keys are typed, not obeyed; a wrong one keeps the prompt open.
  world.key("g");
  world.type("nq");
  EXPECT_TRUE(world.key("Return"));
  EXPECT_EQ(frameOn(world), 4u);
  EXPECT_TRUE(world.key("Escape"));
  EXPECT_TRUE(world.key("h"));
  goes("7", 7);  // from the help too
  goes("", 7);
}

TEST(ViewSession, TypesNothingWhereThereAreNoPanels) {
  SessionWorld world(25, {"ray_tracing"}, {.bare = true});
  world.key("g");
  EXPECT_FALSE(world.key("q"));
}

TEST(ViewSession, ProblemsOfAFrameAreShownAndTheOthersStayGood) {
  auto frames = std::make_shared<FakeFrames>(3);
  frames->frames[1].scans.clear();
  frames->frames[1].problems = {"train-000000.tar: is damaged"};
  SessionWorld world(frames, {.sample = "1"});
  EXPECT_THAT(world.session->problems(), testing::ElementsAre("train-000000.tar: is damaged"));
  EXPECT_THAT(messageOf<Error>([&] { world.session->check(); }), testing::Not(HasSubstr("--sample")));
  EXPECT_THAT(messageOf<Error>([&] { SessionWorld(frames, {}).session->check(); }), HasSubstr("--sample"));
  EXPECT_TRUE(world.canvas.pointItems().empty());
  for (const char* key : {"c", "s", "l", "i", "m", "w", "d", "n", "Tab", "f", "A", "F3", "r"}) world.key(key);
  world.click(400, 300);
  world.press("Right");
  EXPECT_THAT(world.session->problems(), testing::ElementsAre("no mesh: there is no scene here"));
  world.press("m");
  EXPECT_THAT(world.session->problems(), IsEmpty());
  EXPECT_NO_THROW(world.session->check());
  EXPECT_FALSE(world.canvas.pointItems().empty());
}

// The first frame with points determines the camera.
TEST(ViewSession, AFirstFrameWithoutPointsLeavesTheCameraToTheNext) {
  const auto frames = std::make_shared<FakeFrames>(2);
  frames->frames[1].scans = frames->frames[0].scans;
  for (Vec3f& place : frames->frames[0].scans[0].scan.position) place.x = NAN;
  SessionWorld late(frames, {.sample = "0"});
  late.press("Right");
  const SessionWorld early(frames, {.sample = "1"});
  EXPECT_TRUE(late.session->camera() == early.session->camera());
}

TEST(ViewSession, AColumnThatIsNotThereKeepsTheColoursAndMessagesSpeakOfNoOptions) {
  auto frames = std::make_shared<FakeFrames>(1);
  ViewScan& scan = frames->frames[0].scans[0];
  scan.scan[kIncidence].clear();
  scan.scan[kRangeTrue].clear();
  scan.error.clear();
  SessionWorld world(frames);
  for (const char* key : {"9", "0"}) {
    const auto before = world.canvas.items.at(firstCloud(world)).colors;
    world.key(key);
    EXPECT_EQ(world.canvas.items.at(firstCloud(world)).colors, before);
    EXPECT_THAT(world.session->problems(), testing::ElementsAre(testing::Not(HasSubstr("--"))));
  }
  EXPECT_THAT(world.session->problems().front(), HasSubstr("noise-free reference"));
  world.key("4");
  EXPECT_THAT(world.session->problems(), IsEmpty());
}

TEST(ViewSession, OptionsThatNameWhatThereIsNot) {
  const auto frames = std::make_shared<FakeFrames>(3);
  FakeCanvas canvas(300, 200);
  const auto refused = [&](const ViewOptions& options, const char* says) {
    EXPECT_THAT(messageOf([&] { ViewSession(frames, canvas, options); }), HasSubstr(says));
  };
  refused({.sample = "sample-9"}, "sample-9");
  refused({.sample = "3"}, "3");
  refused({.hidden = {"lorry"}}, "lorry");
  frames->frames[1].scans[0].scan[kIncidence].clear();
  ViewSession session(frames, canvas, {.colors = {ColorBy("incidence")}});
  session.drawWhenLoaded();
  EXPECT_THAT(messageOf([&] { session.check(); }), HasSubstr("incidence"));
}

TEST(ViewSession, AnEmptyScanSaysSo) {
  auto frames = std::make_shared<FakeFrames>(1);
  frames->frames[0].scans[0].scan = Scan{};
  frames->frames[0].scans[0].error.clear();
  SessionWorld world(frames);
  EXPECT_NO_THROW(world.session->check());
  const CanvasView& view = world.canvas.views().front();
  int written = 0;
  for (int y = view.rect.height / 2 - 30; y < view.rect.height / 2 + 30; ++y) {
    for (int x = 300; x < SessionWorld::kWidth - 100; ++x) {
      if (world.canvas.overlayAt(x, view.rect.top + y)[3] > 0) ++written;
    }
  }
  EXPECT_GT(written, 200);
  for (const ViewCommand& command : ViewSession::commands()) world.key(command.keys.front());
}

TEST(ViewSession, StandsInTheWorldOrFollowsTheSensor) {
  SessionWorld world(5);
  const auto placeOf = [&] { return world.canvas.items.at(firstCloud(world)).look.canvasFromItem.translation; };
  EXPECT_EQ(placeOf(), (Vec3d{0, 0, 0}));
  const auto pixel = world.pixelOf(firstCloud(world), 80);
  world.key("w");
  EXPECT_EQ(world.pixelOf(firstCloud(world), 80), pixel);  // nothing jumps
  EXPECT_NEAR(length(placeOf() - Vec3d{4, 0, 0}), 0, 1e-9);
  const OrbitCamera camera = world.session->camera();
  world.press("Right");
  EXPECT_EQ(world.session->camera(), camera);
  EXPECT_NEAR(length(placeOf() - Vec3d{6, 0, 0}), 0, 1e-9);
  world.key("w");
  EXPECT_NEAR(length(placeOf()), 0, 1e-9);
}

TEST(ViewSession, SavesPicturesThatNeverReplaceOthers) {
  const CurrentFolder folder;
  SessionWorld world(1);
  world.key("P");
  world.key("P");
  EXPECT_TRUE(std::filesystem::exists("scanmill_view_000.png"));
  EXPECT_TRUE(std::filesystem::exists("scanmill_view_001.png"));
  EXPECT_FALSE(std::filesystem::exists("scanmill_view_002.png"));
}

TEST(ViewSession, OnlyMovesLeaveOutPoints) {
  auto frames = std::make_shared<FakeFrames>(1);
  frames->frames[0].scans[0].scan = fakeScan(64, 16000);
  frames->frames[0].scans[0].error.clear();
  SessionWorld world(frames);
  EXPECT_EQ(world.canvas.lastMost, 0u);
  const int before = world.canvas.renders;
  world.pointer(Kind::Down, 300, 300);
  world.pointer(Kind::Move, 340, 320);
  world.tick();
  EXPECT_GT(world.canvas.renders, before);
  const std::uint64_t moving = world.canvas.lastMost;
  world.pointer(Kind::Up, 340, 320);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (world.canvas.lastMost != 0 && std::chrono::steady_clock::now() < end) world.tick();
  EXPECT_EQ(world.canvas.lastMost, 0u) << moving;
}

}  // namespace
}  // namespace scanmill
