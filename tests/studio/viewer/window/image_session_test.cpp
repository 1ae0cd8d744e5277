#include "viewer/window/image_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "passes/exr/pass_exr.h"
#include "tests/studio/viewer/window/fake_canvas.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

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
  ImageList images() const { return openImages(file(), "", {}); }

  static bool key(ImageSession& session, const std::string& name) {
    return session.handle({.kind = CanvasEvent::Kind::Key, .key = name});
  }
  static void wheel(ImageSession& session, double amount, int x, int y) {
    session.handle({.kind = CanvasEvent::Kind::Wheel, .x = x, .y = y, .amount = amount});
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
  ImageSession session(images(), canvas_, "", false);
  session.settle();
  const Image first = session.picture();
  EXPECT_TRUE(key(session, "Right"));
  EXPECT_NE(session.picture().pixels, first.pixels);
  key(session, "Left");
  EXPECT_EQ(session.picture().pixels, first.pixels);
  key(session, "[");
  key(session, "]");
  EXPECT_EQ(session.picture().pixels, first.pixels);
  EXPECT_TRUE(key(session, "h"));
  EXPECT_TRUE(key(session, "Escape"));
  EXPECT_FALSE(key(session, "q"));
}

// Every pixel of the file is found somewhere, in its place, and enlarged it is still the same.
TEST_F(ImageViewer, ValuesAreThoseOfThePixel) {
  ImageSession session(images(), canvas_, "semantic", false);
  for (const double zoom : {0.0, 3.0}) {
    session.handle({.kind = CanvasEvent::Kind::Wheel, .x = 320, .y = 240, .amount = zoom});
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

// The pixel that is pointed at stays there, wherever that is, and the pane fills.
TEST_F(ImageViewer, ZoomsAboutThePointerInTheWholePane) {
  for (const auto& [x, y] : {std::pair(320, 240), std::pair(150, 120), std::pair(500, 380), std::pair(205, 300)}) {
    ImageSession session(images(), canvas_, "", false);
    session.settle();
    const std::string before = value(session, x, y, "pixel");
    ASSERT_NE(before, "");
    for (int step = 1; step <= 8; ++step) {
      wheel(session, 1, x, y);
      session.settle();
      EXPECT_EQ(value(session, x, y, "pixel"), before) << step;
    }
    wheel(session, -20, x, y);
    session.settle();
    EXPECT_EQ(value(session, x, y, "pixel"), before) << "whole again";
  }
  ImageSession session(images(), canvas_, "", false);
  session.settle();
  EXPECT_EQ(value(session, 5, 240, "pixel"), "") << "beside the whole image";
  wheel(session, 4, 320, 240);
  session.settle();
  for (const int x : {2, 320, 637}) {
    for (const int y : {60, 240, 440}) EXPECT_NE(value(session, x, y, "pixel"), "") << x << ' ' << y;
  }
}

TEST_F(ImageViewer, StepsThroughARecordingsImages) {
  for (const char* name : {"a-s1-x-000000.top.10.front.exr", "a-s1-x-000000.top.9.front.exr", "b.exr"}) {
    std::filesystem::copy_file(file(), folder_.path() / name);
  }
  folder_.write("c.exr", "damaged");
  const ImageList all = openImages(folder_.path(), "", {});
  EXPECT_THAT(all.names,
              testing::ElementsAre("a", "a-s1-x-000000.top.9.front", "a-s1-x-000000.top.10.front", "b", "c"));
  EXPECT_EQ(openImages(folder_.path(), "top.10", {}).first, 2u);
  EXPECT_EQ(openImages(folder_.path(), "3", {}).first, 3u);
  EXPECT_THAT(messageOf([&] { openImages(folder_.path(), "nowhere", {}); }), HasSubstr("nowhere"));
  ImageSession session(all, canvas_, "semantic", false);
  session.settle();
  std::vector<std::string> seen{session.name()};
  for (int i = 0; i < 5; ++i) {
    key(session, i % 2 ? "." : "Page_Down");
    seen.push_back(session.name());
  }
  EXPECT_THAT(seen, testing::ElementsAre(all.names[0], all.names[1], all.names[2], all.names[3], "c", "c"));
  key(session, "Page_Up");
  EXPECT_EQ(session.name(), "b");
  EXPECT_NE(value(session, 320, 240, "semantic"), "");
  key(session, "<");
  EXPECT_EQ(session.name(), "a");
}

TEST_F(ImageViewer, MaterialsHaveTheNamesOfTheirRecording) {
  ImageList list = images();
  list.names = {"town-s1-old-s2-lane-000003.top"};
  list.recording.emplace();
  for (const char* name : {"grass", "steel"}) {
    Material material;
    material.name = name;
    list.recording->materials.push_back({material});
  }
  list.recording->sequences = {{"town", 1, "lane", 1, 0}, {"town-s1-old", 2, "lane", 1, 1}};
  EXPECT_EQ(list.materials(0), std::vector<std::string>{"steel"});
  list.names = {"town-s1-lane-000003.top"};
  EXPECT_EQ(list.materials(0), std::vector<std::string>{"grass"});
  list.names = {"village-s1-lane-000003.top"};
  EXPECT_THAT(list.materials(0), testing::IsEmpty());
}

TEST_F(ImageViewer, WrongFilesAndPlanesAreRefused) {
  EXPECT_THAT(messageOf([&] { ImageSession(images(), canvas_, "colour", false); }), HasSubstr("semantic"));
  EXPECT_THAT(messageOf([&] { ImageSession(openImages(folder_.path() / "no.exr", "", {}), canvas_, "", false); }),
              HasSubstr("no.exr"));
}

TEST_F(ImageViewer, NothingStopsIt) {
  std::mt19937 random(1);
  const char* const keys[] = {"Right", "Left", "Home", "h", "[", "x", "Tab", "k", "Escape", "Down"};
  ImageSession session(images(), canvas_, "", false);
  for (int i = 0; i < 2000; ++i) {
    const CanvasEvent event{.kind = static_cast<CanvasEvent::Kind>(random() % 8),
                            .key = keys[random() % std::size(keys)],
                            .x = static_cast<int>(random() % 900) - 100,
                            .y = static_cast<int>(random() % 700) - 100,
                            .amount = static_cast<double>(random() % 7) - 3};
    if (event.kind == CanvasEvent::Kind::Resize) {
      canvas_.resize(64 + static_cast<int>(random() % 500), 64 + static_cast<int>(random() % 500));
    }
    ASSERT_NO_THROW(ASSERT_TRUE(session.handle(event)));
  }
}

}  // namespace
}  // namespace scanmill
