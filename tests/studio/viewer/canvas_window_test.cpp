// The canvas as a window, under an X server of the test's own, with real keys and clicks.

#include "tests/support/message_of.h"
#include "tests/support/x_display.h"
#include "viewer/canvas/canvas.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {
namespace {

using Kind = CanvasEvent::Kind;

constexpr Rgb kDot{250, 10, 20};
constexpr Rgb kGround{0, 40, 90};

void draw(Canvas& canvas) {
  CanvasView view{.rect = {0, 0, canvas.width(), canvas.height()},
                  .camera = presetCamera(View::Driver).camera(canvas.width(), canvas.height()),
                  .background = kGround};
  canvas.setViews({&view, 1});
  canvas.render();
}

void addDot(Canvas& canvas, double size) {
  canvas.set(1, ItemKind::Points, std::vector<Vec3f>{{10, 0, 0}}, std::vector{kDot});
  canvas.setLook(1, {.size = size});
}

// Runs the window, draws where it must, and calls `step` at every tick with its number until that returns false. Gives
// the events other than ticks.
std::vector<CanvasEvent> watch(Canvas& canvas, const std::function<bool(int)>& step) {
  std::vector<CanvasEvent> events;
  int ticks = 0;
  canvas.run(20, [&](const CanvasEvent& event) {
    if (event.kind == Kind::Resize || event.kind == Kind::Redraw) draw(canvas);
    if (event.kind != Kind::Tick) {
      events.push_back(event);
      return true;
    }
    return ticks < 500 && step(ticks++);
  });
  EXPECT_LT(ticks, 500);
  return events;
}

const CanvasEvent* find(const std::vector<CanvasEvent>& events, Kind kind, const std::string& key = {}) {
  const auto found = std::ranges::find_if(
      events, [&](const CanvasEvent& e) { return e.kind == kind && (key.empty() || e.key == key); });
  return found != events.end() ? &*found : nullptr;
}

TEST(CanvasWindow, KeysAndClicksArrive) {
  SKIP_WITHOUT_X();
  XDisplay server;
  const auto canvas = openWindow("Scanmill \xC3\xA9", 400, 300);
  addDot(*canvas, 9);
  bool ended = false;
  const std::vector<CanvasEvent> events = watch(*canvas, [&](int tick) {
    if (tick == 2) act({"mousemove", "120", "80", "click", "1"});
    if (tick == 3) act({"click", "--repeat", "2", "--delay", "20", "3", "click", "4", "click", "5"});
    if (tick == 4)
      act({"key", "e", "q", "A", "Left", "Return", "slash", "BackSpace", "ctrl+s", "3", "p", "F1", "KP_Left", "KP_Add",
           "KP_Enter", "space"});
    if (tick == 5) act({"mousemove", "33", "44", "key", "Escape"});
    ended = ended || tick > 12;
    return !ended;
  });
  ASSERT_NE(find(events, Kind::Resize), nullptr);
  EXPECT_EQ(find(events, Kind::Resize)->width, 400);
  EXPECT_EQ(find(events, Kind::Resize)->height, 300);
  std::vector<std::string> words;
  for (const CanvasEvent& event : events) {
    switch (event.kind) {
      case Kind::Key:
        words.push_back(event.key + ":" + event.text);
        break;
      case Kind::Down:
        EXPECT_EQ(event.x, 120);
        EXPECT_EQ(event.y, 80);
        words.push_back("down" + std::to_string(event.button) + "x" + std::to_string(event.clicks));
        break;
      case Kind::Up:
        words.push_back("up" + std::to_string(event.button));
        break;
      case Kind::Wheel:
        words.push_back(event.amount > 0 ? "away" : "near");
        break;
      default:
        break;
    }
  }
  EXPECT_EQ(words, (std::vector<std::string>{"down1x1", "up1",   "down3x1",    "up3",     "down3x2", "up3",
                                             "away",    "near",  "e:e",        "q:q",     "A:A",     "Left:",
                                             "Return:", "/:/",   "BackSpace:", "s:",      "3:3",     "p:p",
                                             "F1:",     "Left:", "+:+",        "Return:", " : ",     "Escape:"}));
  EXPECT_TRUE(find(events, Kind::Key, "A")->shift);
  EXPECT_FALSE(find(events, Kind::Key, "e")->shift);
  EXPECT_TRUE(find(events, Kind::Key, "s")->control);
  EXPECT_EQ(find(events, Kind::Key, "Escape")->x, 33);
  EXPECT_EQ(find(events, Kind::Key, "Escape")->y, 44);
}

TEST(CanvasWindow, ShowsWhatItReads) {
  SKIP_WITHOUT_X();
  XDisplay server;
  const auto canvas = openWindow("Scanmill", 400, 300);
  addDot(*canvas, 31);
  canvas->setImage(1, 1, 1, std::vector<Rgba>{{9, 200, 9, 255}});
  const Rgba white{255, 255, 255, 255};
  canvas->setOverlay(
      {{{0, 0, 0, 0, white}, {20, 0, 1, 0, white}, {0, 20, 0, 1, white}}, {0, 1, 2}, {{{0, 0, 20, 10}, 1, 0, 3}}});
  Image screen;
  act({"mousemove", "600", "440"});  // the pointer would be in the picture
  watch(*canvas, [&](int) {
    screen = server.screen();
    return screen.at(200, 150) != kDot;
  });
  const Image image = canvas->read();
  EXPECT_EQ(std::ranges::count(image.pixels, kDot), 31 * 31);
  EXPECT_EQ(screen.at(5, 5), (Rgb{9, 200, 9}));
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) ASSERT_EQ(screen.at(x, y), image.at(x, y)) << x << ", " << y;
  }
}

TEST(CanvasWindow, ChangesItsSize) {
  SKIP_WITHOUT_X();
  XDisplay server;
  const auto canvas = openWindow("Scanmill", 400, 300);
  addDot(*canvas, 5);
  const std::vector<CanvasEvent> events = watch(*canvas, [&](int tick) {
    if (tick == 2) act({"search", "--name", "Scanmill", "windowsize", "500", "200"});
    return canvas->width() == 400;
  });
  EXPECT_EQ(canvas->width(), 500);
  EXPECT_EQ(canvas->height(), 200);
  const Image image = canvas->read();
  EXPECT_EQ(image.width, 500);
  EXPECT_EQ(image.at(250, 100), kDot);
}

TEST(CanvasWindow, PassesOnWhatItsHandlerThrows) {
  SKIP_WITHOUT_X();
  XDisplay server;
  const auto canvas = openWindow("Scanmill", 100, 80);
  EXPECT_EQ(messageOf([&] {
              canvas->run(10, [](const CanvasEvent&) -> bool { throw InputError("thrown by the handler"); });
            }),
            "thrown by the handler");
  EXPECT_EQ(watch(*canvas, [](int) { return false; }).front().kind, Kind::Resize);  // and runs again
}

// Xlib ends the program, whose destructors then meet a window that is gone: the message is all that is seen.
TEST(CanvasWindowDeathTest, EndsWithAMessageWhenTheServerGoes) {
  SKIP_WITHOUT_X();
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto lose = [] {
    XDisplay server;
    const auto canvas = openWindow("Scanmill", 100, 80);
    canvas->run(10, [&](const CanvasEvent& event) {
      if (event.kind == Kind::Tick) server.end();
      draw(*canvas);
      return true;
    });
  };
  EXPECT_EXIT(lose(), testing::ExitedWithCode(1), "X connection to .* broken|X server");
}

}  // namespace
}  // namespace scanmill
