// The viewer in a window, used as a person does: real keys and clicks, and what is on the screen.

#include <fmt/core.h>

#include <chrono>
#include <functional>
#include <thread>

#include "dataset/manifest.h"
#include "tests/commands/program.h"
#include "tests/support/x_display.h"
#include "viewer/color_map.h"

namespace scanmill {
namespace {

constexpr int kWidth = 1000;
constexpr int kHeight = 700;
constexpr std::uint16_t kBuilding = 6;
constexpr std::uint16_t kCar = 20;

struct Pixel {
  int x = 0;
  int y = 0;
};

std::vector<Pixel> pixelsOf(const Image& image, const Rgb& color) {
  std::vector<Pixel> found;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, y) == color) found.push_back({x, y});
    }
  }
  return found;
}

// Two frames of a street, whose first shows parked cars all around.
class ViewWindow : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    const Outcome made = scanmill({"generate", SCANMILL_SOURCE_DIR "/pipelines/street.yaml", "-o", street(), "-q",
                                   "--set", "scenes.0.seeds=[3]", "--set", "splits=null", "--set",
                                   "trajectories.0.frames=2", "--set", "output.formats=[pcd]"});
    ASSERT_EQ(made.code, 0) << made.error;
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string street() { return at("street"); }
  static std::string at(const std::string& name) { return (folder_->path() / name).string(); }

  static Rgb colorOf(std::uint16_t id) {
    const Manifest manifest = readManifest(street());
    return classColor(&manifest.ontology, id);
  }

  static std::unique_ptr<TemporaryFolder> folder_;
};

std::unique_ptr<TemporaryFolder> ViewWindow::folder_;

// `scanmill view` in a window that fills the screen, as the first frame stands in it.
class OpenViewer {
 public:
  OpenViewer(const XDisplay& display, const std::string& dataset, std::vector<std::string> more = {})
      : display_(display) {
    std::vector<std::string> command{testedProgram(), "view", dataset, "--size", fmt::format("{}x{}", kWidth, kHeight)};
    command.insert(command.end(), more.begin(), more.end());
    program_ = std::make_unique<RunningProgram>(command, std::vector<std::string>{"DISPLAY=" + display.name()});
  }

  // What is on the screen once `holds` holds and nothing changes any more (a picture may be taken while the window is
  // drawn), or in the end.
  Image screenWhen(const std::function<bool(const Image&)>& holds, double seconds = 30) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    Image last = display_.screen();
    for (;;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      Image screen = display_.screen();
      if (screen.pixels == last.pixels && holds(screen)) return screen;
      if (std::chrono::steady_clock::now() > end || !program_->running()) {
        ADD_FAILURE() << "the screen does not show what it should";
        return screen;
      }
      last = std::move(screen);
    }
  }

  Outcome end() { return program_->wait(20); }

 private:
  const XDisplay& display_;
  std::unique_ptr<RunningProgram> program_;
};

auto holdsColor(const Rgb& color, std::size_t atLeast) {
  return [=](const Image& screen) { return pixelsOf(screen, color).size() >= atLeast; };
}

auto lacksColor(const Rgb& color, std::size_t atMost) {
  return [=](const Image& screen) { return pixelsOf(screen, color).size() <= atMost; };
}

// The swatch of the legend: where the colour fills a square.
std::optional<Pixel> swatchOf(const Image& image, const Rgb& color) {
  constexpr int kSide = 7;
  for (const Pixel& p : pixelsOf(image, color)) {
    bool filled = p.x + kSide < image.width && p.y + kSide < image.height && p.x > image.width / 2;
    for (int y = 0; filled && y < kSide; ++y) {
      for (int x = 0; filled && x < kSide; ++x) filled = image.at(p.x + x, p.y + y) == color;
    }
    if (filled) return Pixel{p.x + kSide / 2, p.y + kSide / 2};
  }
  return {};
}

TEST_F(ViewWindow, AClassIsHiddenByAClickInTheLegend) {
  SKIP_WITHOUT_X();
  const XDisplay display(fmt::format("{}x{}", kWidth, kHeight));
  const Rgb car = colorOf(kCar);
  const Rgb building = colorOf(kBuilding);
  OpenViewer viewer(display, street(), {"--sample", "0", "--flat", "--camera", "above"});
  const Image before = viewer.screenWhen(holdsColor(car, 1000));
  const auto swatch = swatchOf(before, car);
  ASSERT_TRUE(swatch.has_value());
  act({"mousemove", std::to_string(swatch->x), std::to_string(swatch->y), "click", "1"});
  const Image hidden = viewer.screenWhen(lacksColor(car, 60));
  EXPECT_NEAR(static_cast<double>(pixelsOf(hidden, building).size()),
              static_cast<double>(pixelsOf(before, building).size()),
              0.05 * static_cast<double>(pixelsOf(before, building).size()) + 20);
  act({"click", "1"});
  viewer.screenWhen(holdsColor(car, pixelsOf(before, car).size() * 9 / 10));
  act({"key", "q"});
  const Outcome ended = viewer.end();
  EXPECT_EQ(ended.code, 0) << ended.error;
  EXPECT_EQ(ended.error, "");
}

}  // namespace
}  // namespace scanmill
