// Whatever a person does in whatever order, the viewer goes on.

#include <random>

#include "tests/studio/viewer/window/session_world.h"
#include "tests/support/temporary_folder.h"
#include "viewer/window/session.h"

namespace scanmill {
namespace {

constexpr const char* kNames[] = {
    "c", "C",    "1",     "2",    "3",         "4",       "5",      "6",      "7",         "8", "9",       "0",  "+",
    "-", "b",    "a",     "A",    "r",         "m",       "t",      "e",      "k",         "o", "F1",      "F2", "F3",
    "f", "Home", "Right", "Left", "Page_Down", "Page_Up", "<",      ">",      " ",         "g", "l",       "s",  "Tab",
    "n", "w",    "d",     "i",    "x",         "h",       "Escape", "Return", "BackSpace", "z", "Shift_L", "End"};

CanvasEvent randomEvent(std::mt19937& random, FakeCanvas& canvas) {
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  CanvasEvent event;
  const int kind = below(20);
  event.x = below(canvas.width() + 200) - 100;
  event.y = below(canvas.height() + 200) - 100;
  event.button = 1 + below(3);
  event.clicks = 1 + below(2);
  event.shift = below(4) == 0;
  if (kind < 7) {
    event.kind = CanvasEvent::Kind::Key;
    event.key = kNames[below(static_cast<int>(std::size(kNames)))];
    if (event.key.size() == 1) event.text = event.key;
    if (below(40) == 0) event.text = "\xc3\xa4";
  } else if (kind < 10) {
    event.kind = CanvasEvent::Kind::Down;
  } else if (kind < 13) {
    event.kind = CanvasEvent::Kind::Up;
  } else if (kind < 17) {
    event.kind = CanvasEvent::Kind::Move;
  } else if (kind == 17) {
    event.kind = CanvasEvent::Kind::Wheel;
    event.amount = below(9) - 4;
  } else if (kind == 18 && below(8) == 0) {
    event.kind = CanvasEvent::Kind::Resize;
    canvas.resize(64 + below(600), 64 + below(400));
    event.width = canvas.width();
    event.height = canvas.height();
  } else {
    event.kind = CanvasEvent::Kind::Tick;
  }
  return event;
}

std::shared_ptr<FakeFrames> manyKindsOfFrames() {
  auto frames = std::make_shared<FakeFrames>(8, std::vector<std::string>{"ray_tracing", "depth_camera", "particle"});
  auto& all = frames->frames;
  all[1].scans.clear();
  all[1].problems = {"shard.tar: is damaged"};
  all[2].scans.resize(1);
  all[3].scans[0].scan = Scan{};
  all[3].scans[0].error.clear();
  Scan bare;
  bare.position = all[4].scans[0].scan.position;
  bare.position[5] = {NAN, NAN, NAN};
  bare.position[6] = {1e30F, 0, 0};
  ViewScan unknown;
  unknown.name = "bare";
  unknown.scan = bare;
  all[4].scans = {unknown};
  all[5].scans[1].worldFromSensor.reset();
  all[6].scans[2].scan[kLabel].clear();
  for (Vec3f& p : all[7].scans[0].scan.position) p = {NAN, NAN, NAN};
  return frames;
}

// Some have a scene, some one that cannot be read, some none.
void addScenes(FakeFrames& frames, const TemporaryFolder& folder) {
  const auto good = folder.write("wall.yaml", kWallScene);
  const auto bad = folder.write("bad.yaml", "objects: 3\n");
  frames.scenes = {good, folder.path() / "absent.yaml", bad, good, good, {}, bad, good};
}

class SessionFuzz : public testing::TestWithParam<unsigned> {};

TEST_P(SessionFuzz, NothingStopsIt) {
  std::mt19937 random(GetParam());
  const TemporaryFolder folder;
  const auto frames = manyKindsOfFrames();
  addScenes(*frames, folder);
  frames->named = GetParam() % 2 == 0;
  FakeCanvas canvas(320, 240);
  frames->setOpen(GetParam() % 3 != 0);  // some begin before anything is loaded
  auto session = std::make_unique<ViewSession>(frames, canvas, ViewOptions{});
  for (int i = 0; i < 2500; ++i) {
    if (i % 300 == 100) frames->setOpen(true);
    if (i % 300 == 250) frames->setOpen(false);
    const CanvasEvent event = randomEvent(random, canvas);
    bool open = true;
    ASSERT_NO_THROW(open = session->handle(event)) << "event " << i << " key " << event.key;
    if (!open) {
      frames->setOpen(true);
      session.reset();
      session = std::make_unique<ViewSession>(frames, canvas, ViewOptions{});
    }
  }
  frames->setOpen(true);
  ASSERT_NO_THROW(session->drawWhenLoaded());
  const Image picture = session->picture();
  EXPECT_EQ(picture.width, canvas.width());
}

INSTANTIATE_TEST_SUITE_P(Seeds, SessionFuzz, testing::Range(1U, 9U));

}  // namespace
}  // namespace scanmill
