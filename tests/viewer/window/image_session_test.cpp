#include "viewer/window/image_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "passes/exr/pass_exr.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/window/fake_canvas.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// Depth and class tell the pixel: 10 m + column, class = row.
class ImageViewer : public testing::Test {
 protected:
  ImageViewer() {
    PassImage image;
    image.camera = squareCamera(kColumns, kRows, radians(90));
    image.camera.name = "front";
    image.planes.reset(image.camera.pixels(), {Channel::Range | Channel::Semantic, false});
    for (std::size_t i = 0; i < image.planes.size(); ++i) {
      image.planes.depth[i] = static_cast<float>(10 + i % kColumns);
      image.planes.semantic[i] = static_cast<std::uint16_t>(i / kColumns);
    }
    writePasses(file(), image);
  }
  std::filesystem::path file() const { return folder_.path() / "a.exr"; }

  static bool key(ImageSession& session, const std::string& name) {
    CanvasEvent event;
    event.kind = CanvasEvent::Kind::Key;
    event.key = name;
    return session.handle(event);
  }
  static std::string value(const ImageSession& session, int x, int y, const std::string& name) {
    const auto rows = session.pick(x, y);
    if (!rows) return "";
    for (const auto& [key, text] : *rows) {
      if (key == name) return text;
    }
    return "";
  }

  static constexpr int kColumns = 24;
  static constexpr int kRows = 16;
  TemporaryFolder folder_;
  FakeCanvas canvas_{640, 480};
};

TEST_F(ImageViewer, StepsThroughPlanesInARing) {
  ImageSession session(file(), nullptr, canvas_, "", false);
  session.settle();
  const Image first = session.picture();
  EXPECT_TRUE(key(session, "Right"));
  EXPECT_NE(session.picture().pixels, first.pixels);
  key(session, "Left");
  EXPECT_EQ(session.picture().pixels, first.pixels);
  key(session, "bracketleft");
  key(session, "bracketright");
  EXPECT_EQ(session.picture().pixels, first.pixels);
  EXPECT_TRUE(key(session, "h"));
  EXPECT_TRUE(key(session, "Escape"));
  EXPECT_FALSE(key(session, "q"));
}

// Every pixel of the file is found somewhere, in its place, and enlarged it is still the same.
TEST_F(ImageViewer, ValuesAreThoseOfThePixel) {
  ImageSession session(file(), nullptr, canvas_, "semantic", false);
  for (const double zoom : {0.0, 3.0}) {
    CanvasEvent wheel;
    wheel.kind = CanvasEvent::Kind::Wheel;
    wheel.amount = zoom;
    session.handle(wheel);
    session.settle();
    std::set<std::string> seen;
    for (int y = 0; y < 480; y += 3) {
      for (int x = 0; x < 640; x += 3) {
        const std::string pixel = value(session, x, y, "pixel");
        if (pixel.empty()) continue;
        const int column = std::atoi(pixel.c_str());
        const int row = std::atoi(pixel.substr(pixel.find(',') + 1).c_str());
        EXPECT_DOUBLE_EQ(std::atof(value(session, x, y, "depth").c_str()), 10 + column);
        EXPECT_THAT(value(session, x, y, "semantic"), HasSubstr(std::to_string(row)));
        seen.insert(pixel);
      }
    }
    EXPECT_EQ(seen.size() == kColumns * kRows, zoom == 0) << seen.size();
    EXPECT_GT(seen.size(), 20u);
  }
  EXPECT_FALSE(session.pick(-1, 5));
}

TEST_F(ImageViewer, WrongFilesAndPlanesAreRefused) {
  EXPECT_THAT(messageOf([&] { ImageSession(file(), nullptr, canvas_, "colour", false); }), HasSubstr("semantic"));
  EXPECT_THAT(messageOf([&] { ImageSession(folder_.path() / "no.exr", nullptr, canvas_, "", false); }),
              HasSubstr("no.exr"));
}

TEST_F(ImageViewer, NothingStopsIt) {
  std::mt19937 random(1);
  const char* const keys[] = {"Right", "Left", "Home", "h", "bracketleft", "x", "Tab"};
  ImageSession session(file(), nullptr, canvas_, "", false);
  for (int i = 0; i < 2000; ++i) {
    CanvasEvent event;
    event.kind = static_cast<CanvasEvent::Kind>(random() % 8);
    event.key = keys[random() % std::size(keys)];
    event.x = static_cast<int>(random() % 900) - 100;
    event.y = static_cast<int>(random() % 700) - 100;
    event.amount = static_cast<double>(random() % 7) - 3;
    if (event.kind == CanvasEvent::Kind::Resize) {
      canvas_.resize(64 + static_cast<int>(random() % 500), 64 + static_cast<int>(random() % 500));
    }
    ASSERT_NO_THROW(ASSERT_TRUE(session.handle(event)));
  }
}

}  // namespace
}  // namespace scanmill
