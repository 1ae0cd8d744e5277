// The canvas without a window: where things are drawn, in which colours, and what is above what.

#include "viewer/canvas/canvas.h"

#include <limits>
#include <random>
#include <set>

#include "tests/support/blender.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

constexpr Rgb kRed{250, 10, 20};
constexpr Rgb kGreen{10, 240, 30};
constexpr Rgb kBlue{30, 60, 251};
constexpr Rgb kNight{13, 15, 20};
constexpr Rgb kBlack{0, 0, 0};
constexpr float kCanvasNan = std::numeric_limits<float>::quiet_NaN();

// Null where this machine has no OpenGL.
std::unique_ptr<Canvas> canvasOrNull(int width, int height) {
  try {
    return openOffscreen(width, height);
  } catch (const Error& e) {
    if (std::string(e.what()).find("no OpenGL") == std::string::npos) throw;
    return nullptr;
  }
}

#define CANVAS_OR_SKIP(name, width, height)                                        \
  const auto name##Owner = canvasOrNull((width), (height));                        \
  if (name##Owner == nullptr) GTEST_SKIP() << "this machine has no OpenGL by EGL"; \
  Canvas& name = *name##Owner

// Looks along x, y to the left, from the origin; 100 pixels of focal length.
CanvasView viewAt(const PixelRect& rect) {
  CanvasView view{.rect = rect};
  view.camera.focal = 100;
  view.camera.centerX = rect.width / 2.0;
  view.camera.centerY = rect.height / 2.0;
  view.camera.nearest = 0.5;
  view.background = kNight;
  view.depthEdges = false;
  return view;
}

void setView(Canvas& canvas, bool depthEdges = false) {
  CanvasView view = viewAt({0, 0, canvas.width(), canvas.height()});
  view.depthEdges = depthEdges;
  canvas.setViews({&view, 1});
}

Image drawn(Canvas& canvas, std::uint64_t maxPoints = 0) {
  canvas.render(maxPoints);
  return canvas.read();
}

std::size_t countOf(const Image& image, const Rgb& color) {
  return static_cast<std::size_t>(std::ranges::count(image.pixels, color));
}

// Two triangles that fill the square |y|, |z| <= half at that x.
std::vector<Vec3f> wall(float x, float half) {
  const Vec3f a{x, -half, -half};
  const Vec3f b{x, half, -half};
  const Vec3f c{x, half, half};
  const Vec3f d{x, -half, half};
  return {a, b, c, a, c, d};
}

void setOnePoint(Canvas& canvas, ItemId item, const Vec3f& at, const Rgb& color, const ItemLook& look) {
  canvas.set(item, ItemKind::Points, std::vector{at}, std::vector{color});
  canvas.setLook(item, look);
}

ItemLook sized(double size) {
  return {.size = size};
}

// An image over a rectangle.
Overlay overlayOf(ImageId image, const PixelRect& rect, const Rgba& tint = {255, 255, 255, 255}) {
  const auto left = static_cast<float>(rect.left);
  const auto top = static_cast<float>(rect.top);
  const auto right = static_cast<float>(rect.left + rect.width);
  const auto bottom = static_cast<float>(rect.top + rect.height);
  return {{{left, top, 0, 0, tint}, {right, top, 1, 0, tint}, {right, bottom, 1, 1, tint}, {left, bottom, 0, 1, tint}},
          {0, 1, 2, 0, 2, 3},
          {{rect, image, 0, 6}}};
}

Rgb colorOf(std::size_t k) {
  return {static_cast<std::uint8_t>(40 + k % 200), static_cast<std::uint8_t>(40 + k / 200), 77};
}

// The law: a point is drawn where the camera says, in every view, whatever the camera.
TEST(Canvas, ProjectsLikeItsCameras) {
  CANVAS_OR_SKIP(canvas, 401, 300);
  std::mt19937 random(7);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
  std::vector<Vec3f> points;
  std::vector<Rgb> colors;
  for (std::size_t k = 0; k < 150; ++k) {
    points.push_back(Vec3f(Vec3d{between(-20, 20), between(-20, 20), between(-20, 20)}));
    colors.push_back(colorOf(k));
  }
  canvas.set(3, ItemKind::Points, points, colors);
  canvas.setLook(3, {.views = 7});
  std::size_t found = 0;
  for (int round = 0; round < 12; ++round) {
    std::vector<CanvasView> views;
    for (const PixelRect& rect :
         {PixelRect{0, 0, 133, 300}, PixelRect{133, 17, 201, 99}, PixelRect{140, 150, 261, 150}}) {
      CanvasView view = viewAt(rect);
      const Mat3 turn = toMatrix(fromYawPitchRoll(between(-3, 3), between(-1.5, 1.5), between(-3, 3)));
      view.camera.orthographic = (round + static_cast<int>(views.size())) % 3 == 0;
      view.camera.forward = turn.x;
      view.camera.right = -turn.y;
      view.camera.down = -turn.z;
      view.camera.eye = {between(-9, 9), between(-9, 9), between(-9, 9)};
      view.camera.focal = view.camera.orthographic ? between(3, 9) : between(40, 300);
      view.camera.nearest = 1;
      view.farthest = 25;
      views.push_back(view);
    }
    canvas.setViews(views);
    const Image image = drawn(canvas);
    for (const CanvasView& view : views) {
      std::set<Rgb> possible{kNight};
      std::vector<std::pair<Projected, Rgb>> expected;
      for (std::size_t k = 0; k < points.size(); ++k) {
        const Projected at = view.camera.project(Vec3d(points[k]));
        if (at.depth < 0.99 || at.depth > 25.01) continue;
        possible.insert(colors[k]);
        if (at.depth > 1.01 && at.depth < 24.99) expected.emplace_back(at, colors[k]);
      }
      for (const auto& [at, color] : expected) {
        const bool inside = at.x > 2 && at.y > 2 && at.x < view.rect.width - 2 && at.y < view.rect.height - 2;
        const bool alone = std::ranges::count_if(expected, [&](const auto& other) {
                             return std::hypot(other.first.x - at.x, other.first.y - at.y) < 3;
                           }) == 1;
        if (!inside || !alone) continue;
        bool seen = false;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            seen |= image.at(view.rect.left + static_cast<int>(at.x) + dx,
                             view.rect.top + static_cast<int>(at.y) + dy) == color;
          }
        }
        EXPECT_TRUE(seen) << "round " << round << ", at " << at.x << ", " << at.y;
        ++found;
      }
      for (int y = 0; y < view.rect.height; ++y) {
        for (int x = 0; x < view.rect.width; ++x) {
          ASSERT_TRUE(possible.contains(image.at(view.rect.left + x, view.rect.top + y))) << x << ", " << y;
        }
      }
    }
    EXPECT_EQ(image.at(240, 5), kBlack);
    EXPECT_EQ(image.at(400, 10), kBlack);
  }
  EXPECT_GT(found, 300u);
}

TEST(Canvas, ColorsAreExactAndTheNearerWins) {
  CANVAS_OR_SKIP(canvas, 64, 48);
  setView(canvas);
  for (const Rgb& color : {Rgb{0, 0, 0}, Rgb{255, 255, 255}, Rgb{1, 2, 3}, Rgb{127, 128, 129}, Rgb{254, 77, 200}}) {
    setOnePoint(canvas, 1, {10, 0, 0}, color, sized(7));
    EXPECT_EQ(countOf(drawn(canvas), color), 49u);
  }
  setOnePoint(canvas, 2, {9.99f, 0, 0}, kGreen, sized(3));
  Image image = drawn(canvas);
  EXPECT_EQ(countOf(image, kGreen), 9u);
  EXPECT_EQ(countOf(image, Rgb{254, 77, 200}), 40u);
  setOnePoint(canvas, 2, {10.01f, 0, 0}, kGreen, sized(3));
  image = drawn(canvas);
  EXPECT_EQ(countOf(image, kGreen), 0u);
  EXPECT_EQ(countOf(image, Rgb{254, 77, 200}), 49u);
  EXPECT_EQ(countOf(image, kNight), 64u * 48u - 49u);
}

TEST(Canvas, ShowsWhatIsAskedFor) {
  CANVAS_OR_SKIP(canvas, 90, 30);
  setView(canvas);
  const std::vector<Vec3f> points{{10, 2, 0}, {10, 0, 0}, {10, -2, 0}, {kCanvasNan, 0, 0}, {10, INFINITY, 0}};
  std::vector<Rgb> colors{kRed, kGreen, kBlue, kRed, kRed};
  const auto counts = [&] {
    const Image image = drawn(canvas);
    return std::array{countOf(image, kRed), countOf(image, kGreen), countOf(image, kBlue)};
  };
  using Counts = std::array<std::size_t, 3>;
  canvas.set(1, ItemKind::Points, points, colors);
  canvas.setLook(1, sized(5));
  EXPECT_EQ(counts(), (Counts{25, 25, 25}));
  canvas.show(1, std::vector<std::uint32_t>{0, 2, 3});
  EXPECT_EQ(counts(), (Counts{25, 0, 25}));
  canvas.show(1, std::vector<std::uint32_t>{});
  EXPECT_EQ(counts(), (Counts{0, 0, 0}));
  canvas.show(1, std::vector<std::uint32_t>{1});
  std::swap(colors[0], colors[1]);
  canvas.setColors(1, colors);
  EXPECT_EQ(counts(), (Counts{25, 0, 0}));
  canvas.show(1, {});
  EXPECT_EQ(counts(), (Counts{25, 25, 25}));
  canvas.set(1, ItemKind::Points, std::span(points).first(1), std::vector{kBlue});  // keeps its look, and is shown
  EXPECT_EQ(counts(), (Counts{0, 0, 25}));
  canvas.set(1, ItemKind::Points, {}, {});
  EXPECT_EQ(counts(), (Counts{0, 0, 0}));
  canvas.set(1, ItemKind::Points, std::span(points).first(3), std::span(colors).first(3));
  EXPECT_EQ(counts(), (Counts{25, 25, 25}));
  canvas.set(1, ItemKind::Triangles, wall(10, 0.5f), std::vector{kRed, kRed});  // another kind of thing
  EXPECT_EQ(counts()[1], 0u);
  canvas.drop(1);
  canvas.drop(1);
  canvas.drop(99);
  EXPECT_EQ(counts(), (Counts{0, 0, 0}));
}

TEST(Canvas, ItemsStandAtTheirPoses) {
  CANVAS_OR_SKIP(canvas, 200, 100);
  setView(canvas);
  ItemLook look = sized(3);
  look.canvasFromItem = toAffine(Pose{fromYawPitchRoll(kPi / 2, 0, 0), {10, 1, -2}});
  setOnePoint(canvas, 1, {3, 4, 1}, kRed, look);  // (-4, 3, 1) turned, so (6, 4, -1)
  const Projected at = viewAt({0, 0, 200, 100}).camera.project({6, 4, -1});
  const Image image = drawn(canvas);
  EXPECT_EQ(countOf(image, kRed), 9u);
  EXPECT_EQ(image.at(static_cast<int>(at.x), static_cast<int>(at.y)), kRed);
}

TEST(Canvas, EveryViewHasItsItems) {
  CANVAS_OR_SKIP(canvas, 100, 40);
  const std::vector<CanvasView> views{viewAt({0, 0, 50, 40}), viewAt({50, 0, 50, 40})};
  canvas.setViews(views);
  ItemLook look = sized(3);
  look.views = 2;
  setOnePoint(canvas, 1, {10, 0, 0}, kRed, look);
  look.views = 3;
  setOnePoint(canvas, 2, {10, 1, 0}, kGreen, look);
  Image image = drawn(canvas);
  EXPECT_EQ(countOf(image, kRed), 9u);
  EXPECT_EQ(countOf(image, kGreen), 18u);
  EXPECT_EQ(image.at(75, 20), kRed);
  look.views = 1;
  canvas.setLook(1, look);
  image = drawn(canvas);
  EXPECT_EQ(image.at(25, 20), kRed);
  EXPECT_EQ(image.at(75, 20), kNight);
  look.views = 0;
  canvas.setLook(1, look);
  EXPECT_EQ(countOf(drawn(canvas), kRed), 0u);
  canvas.setViews({views.data(), 1});
  image = drawn(canvas);
  EXPECT_EQ(countOf(image, kGreen), 9u);
  EXPECT_EQ(countOf(image, kBlack), 50u * 40u);
}

TEST(Canvas, SurfacesAreLitFromTheEye) {
  CANVAS_OR_SKIP(canvas, 100, 100);
  setView(canvas);
  canvas.set(1, ItemKind::Triangles, wall(10, 20), std::vector{kGreen, kGreen});
  Image image = drawn(canvas);
  EXPECT_NEAR(image.at(50, 50)[1], kGreen[1], 2);
  EXPECT_LT(image.at(1, 1)[1], kGreen[1] - 10);  // seen from the side
  const Vec3f a{5, -1, -1};
  canvas.set(1, ItemKind::Triangles, std::vector{a, Vec3f{50, -1, -1}, Vec3f{50, 1, -1}},
             std::vector{kGreen});  // a grazing floor
  image = drawn(canvas);
  std::uint8_t brightest = 0;
  for (const Rgb& pixel : image.pixels) brightest = std::max(brightest, pixel[1]);
  EXPECT_GT(brightest, 60);
  EXPECT_LT(brightest, 140);
  const ItemLook look{.lit = false};
  canvas.set(1, ItemKind::Triangles, wall(10, 20), std::vector{kGreen, kGreen});
  canvas.setLook(1, look);
  EXPECT_EQ(countOf(drawn(canvas), kGreen), 10000u);
}

TEST(Canvas, WhatIsTranslucentHidesNothing) {
  CANVAS_OR_SKIP(canvas, 100, 100);
  setView(canvas);
  ItemLook faint{.opacity = 0.25, .lit = false};
  canvas.set(1, ItemKind::Triangles, wall(5, 20), std::vector{kGreen, kGreen});
  canvas.setLook(1, faint);
  setOnePoint(canvas, 2, {10, 1, 0}, kRed, sized(5));      // behind it
  setOnePoint(canvas, 3, {4, -0.4f, 0}, kBlue, sized(5));  // before it
  Image image = drawn(canvas);
  const auto through = [&](const Rgb& behind) {
    Rgb out{};
    for (std::size_t k = 0; k < 3; ++k) out[k] = static_cast<std::uint8_t>(0.75 * behind[k] + 0.25 * kGreen[k]);
    return out;
  };
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(image.at(40, 50)[k], through(kRed)[k], 2);
    EXPECT_NEAR(image.at(10, 10)[k], through(kNight)[k], 2);
  }
  EXPECT_EQ(image.at(60, 50), kBlue);
  faint.opacity = 0;
  canvas.setLook(1, faint);
  image = drawn(canvas);
  EXPECT_EQ(image.at(40, 50), kRed);
  EXPECT_EQ(image.at(10, 10), kNight);
}

TEST(Canvas, LinesHaveTheirColorsAndWidths) {
  CANVAS_OR_SKIP(canvas, 100, 60);
  setView(canvas);
  canvas.set(1, ItemKind::Segments, std::vector<Vec3f>{{10, 3, 0}, {10, -3, 0}, {10, 3, 2}, {10, -3, 2}},
             std::vector{kRed, kBlue});
  Image image = drawn(canvas);
  EXPECT_NEAR(static_cast<double>(countOf(image, kRed)), 60, 2);
  EXPECT_NEAR(static_cast<double>(countOf(image, kBlue)), 60, 2);
  canvas.setLook(1, sized(4));
  canvas.show(1, std::vector<std::uint32_t>{1});
  image = drawn(canvas);
  EXPECT_EQ(countOf(image, kRed), 0u);
  EXPECT_NEAR(static_cast<double>(countOf(image, kBlue)), 240, 8);
}

TEST(Canvas, AnImageOfTheOverlayIsExactAndCutOff) {
  CANVAS_OR_SKIP(canvas, 70, 50);
  setView(canvas);
  setOnePoint(canvas, 1, {10, 0, 0}, kRed, sized(9));
  std::vector<Rgba> pixels(80 * 90);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto value = static_cast<std::uint8_t>(i * 37 % 251);
    pixels[i] = {value, static_cast<std::uint8_t>(255 - value), 9, static_cast<std::uint8_t>(i % 3 == 0 ? 255 : 0)};
  }
  pixels[0] = {200, 100, 0, 128};
  const Image before = drawn(canvas);
  canvas.setImage(4, 80, 90, pixels);
  canvas.setOverlay(overlayOf(4, {0, 0, 80, 90}));
  Image image = drawn(canvas);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 70; ++x) {
      if (x == 0 && y == 0) continue;
      const Rgba& p = pixels[static_cast<std::size_t>(y * 80 + x)];
      ASSERT_EQ(image.at(x, y), (p[3] == 255 ? Rgb{p[0], p[1], p[2]} : before.at(x, y))) << x << ", " << y;
    }
  }
  EXPECT_NEAR(image.at(0, 0)[0], 200 * 0.5 + 13 * 0.5, 2);
  canvas.setOverlay({});
  EXPECT_EQ(drawn(canvas).pixels, before.pixels);
}

// Enlarged pixels are squares, colours multiply, clips cut, and later parts lie over earlier ones.
TEST(Canvas, PartsOfTheOverlayAreTintedClippedAndInOrder) {
  CANVAS_OR_SKIP(canvas, 70, 50);
  setView(canvas);
  canvas.setImage(1, 2, 1, std::vector<Rgba>{{250, 10, 20, 255}, {30, 60, 251, 255}});
  canvas.setImage(2, 1, 1, std::vector<Rgba>{{255, 255, 255, 255}});
  Overlay overlay = overlayOf(1, {10, 5, 40, 20});
  overlay.parts[0].clip = {10, 5, 40, 10};
  const Overlay tinted = overlayOf(2, {12, 6, 3, 3}, {10, 240, 30, 255});
  const auto before = static_cast<std::uint32_t>(overlay.vertices.size());
  overlay.vertices.insert(overlay.vertices.end(), tinted.vertices.begin(), tinted.vertices.end());
  for (const std::uint32_t corner : tinted.corners) overlay.corners.push_back(before + corner);
  overlay.parts.push_back({tinted.parts[0].clip, 2, 6, 6});
  canvas.setOverlay(overlay);
  const Image image = drawn(canvas);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 70; ++x) {
      const bool over = x >= 12 && x < 15 && y >= 6 && y < 9;
      const bool within = x >= 10 && x < 50 && y >= 5 && y < 15;
      const Rgb expected = over ? kGreen : within ? (x < 30 ? kRed : kBlue) : kNight;
      ASSERT_EQ(image.at(x, y), expected) << x << ", " << y;
    }
  }
}

TEST(Canvas, DepthEdgesDarkenWhatLiesBehindAndNothingElse) {
  CANVAS_OR_SKIP(canvas, 200, 100);
  std::vector<CanvasView> views{viewAt({0, 0, 100, 100}), viewAt({100, 0, 100, 100})};
  views[0].depthEdges = true;
  for (const bool orthographic : {false, true}) {
    for (CanvasView& view : views) {
      view.camera.orthographic = orthographic;
      view.camera.focal = orthographic ? 10 : 100;
    }
    canvas.setViews(views);
    const ItemLook look{.views = 3, .lit = false};
    canvas.set(1, ItemKind::Triangles, wall(20, 4), std::vector{kGreen, kGreen});
    canvas.set(2, ItemKind::Triangles, wall(10, 1), std::vector{kRed, kRed});
    canvas.setLook(1, look);
    canvas.setLook(2, look);
    const Image image = drawn(canvas);
    std::size_t darker = 0;
    for (int y = 0; y < 100; ++y) {
      for (int x = 0; x < 100; ++x) {
        const Rgb& with = image.at(x, y);
        const Rgb& without = image.at(x + 100, y);
        if (with == without) continue;
        EXPECT_EQ(without, kGreen) << "only the wall behind has an edge";
        EXPECT_LT(with[1], without[1]);
        ++darker;
      }
    }
    EXPECT_GT(darker, 80u);
    EXPECT_LT(darker, 400u);
  }
}

// A floor that falls away from the eye has no edges inside.
TEST(Canvas, SlopesAreNotDarkened) {
  CANVAS_OR_SKIP(canvas, 200, 200);
  setView(canvas, true);
  const ItemLook look{.lit = false};
  canvas.set(1, ItemKind::Triangles, std::vector<Vec3f>{{2, -90, -1}, {2, 90, -1}, {90, 0, -1}}, std::vector{kGreen});
  canvas.setLook(1, look);
  const Image image = drawn(canvas);
  const auto isFloor = [&](int x, int y) { return image.at(x, y) != kNight; };
  std::size_t inner = 0;
  for (int y = 2; y < 198; ++y) {
    for (int x = 2; x < 198; ++x) {
      if (!isFloor(x, y) || !isFloor(x, y - 2) || !isFloor(x, y + 2) || !isFloor(x - 2, y) || !isFloor(x + 2, y))
        continue;
      ASSERT_EQ(image.at(x, y), kGreen) << x << ", " << y;
      ++inner;
    }
  }
  EXPECT_GT(inner, 5000u);
}

TEST(Canvas, FewerPointsAreASpreadSubset) {
  CANVAS_OR_SKIP(canvas, 200, 200);
  setView(canvas);
  std::vector<Vec3f> points;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      points.push_back({10, 9.95f - 0.2f * static_cast<float>(x), 9.95f - 0.2f * static_cast<float>(y)});
    }
  }
  canvas.set(1, ItemKind::Points, points, std::vector<Rgb>(points.size(), kRed));
  const Image all = drawn(canvas);
  EXPECT_EQ(countOf(all, kRed), 10000u);
  const Image few = drawn(canvas, 1000);
  EXPECT_EQ(countOf(few, kRed), 1000u);
  std::size_t quarter = 0;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) quarter += few.at(x, y) == kRed;
  }
  EXPECT_NEAR(static_cast<double>(quarter), 250, 60);
  for (std::size_t i = 0; i < few.pixels.size(); ++i) EXPECT_TRUE(few.pixels[i] == kNight || all.pixels[i] == kRed);
  EXPECT_EQ(drawn(canvas, 1000).pixels, few.pixels);
  EXPECT_EQ(drawn(canvas, 10000).pixels, all.pixels);
  EXPECT_EQ(drawn(canvas).pixels, all.pixels);
  std::vector<std::uint32_t> upper(5000);
  for (std::uint32_t k = 0; k < upper.size(); ++k) upper[k] = k;
  canvas.show(1, upper);
  EXPECT_EQ(countOf(drawn(canvas, 1000), kRed), 1000u);
  EXPECT_EQ(countOf(drawn(canvas, 1000), kNight), 39000u);
}

TEST(Canvas, TheSameCallsGiveTheSamePicture) {
  const auto picture = [](Canvas& canvas) {
    setView(canvas, true);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> any(-5, 5);
    std::vector<Vec3f> points(3000);
    for (Vec3f& point : points) point = {12 + any(random), any(random), any(random)};
    canvas.set(1, ItemKind::Points, points, std::vector<Rgb>(points.size(), kRed));
    canvas.setLook(1, sized(4));
    const ItemLook faint{.opacity = 0.3};
    canvas.set(2, ItemKind::Triangles, wall(11, 3), std::vector{kGreen, kBlue});
    canvas.setLook(2, faint);
    canvas.setImage(1, 1, 1, std::vector<Rgba>{{1, 2, 3, 99}});
    canvas.setOverlay(overlayOf(1, {0, 0, 3, 2}));
    return drawn(canvas);
  };
  CANVAS_OR_SKIP(canvas, 160, 120);
  const Image first = picture(canvas);
  EXPECT_EQ(picture(canvas).pixels, first.pixels);
  EXPECT_EQ(picture(*openOffscreen(160, 120)).pixels, first.pixels);
  canvas.render();
  EXPECT_EQ(canvas.read().pixels, first.pixels);
}

TEST(Canvas, ManyCanOpenAndClose) {
  CANVAS_OR_SKIP(lasting, 32, 32);
  setView(lasting);
  setOnePoint(lasting, 1, {10, 0, 0}, kRed, sized(3));
  for (int k = 0; k < 20; ++k) {
    const auto canvas = openOffscreen(40, 30);
    setView(*canvas);
    setOnePoint(*canvas, 1, {10, 0, 0}, kGreen, sized(3));
    EXPECT_EQ(countOf(drawn(*canvas), kGreen), 9u);
    EXPECT_EQ(countOf(drawn(lasting), kRed), 9u);
  }
}

TEST(Canvas, WrongUseIsTold) {
  CANVAS_OR_SKIP(canvas, 40, 30);
  EXPECT_THAT(messageOf<Error>([&] { canvas.setColors(5, {}); }), HasSubstr("no item 5"));
  const std::vector<Vec3f> three(3);
  EXPECT_THAT(messageOf<Error>([&] { canvas.set(1, ItemKind::Points, three, std::vector{kRed}); }),
              HasSubstr("3 corners"));
  canvas.set(1, ItemKind::Points, three, std::vector(3, kRed));
  EXPECT_THAT(messageOf<Error>([&] { canvas.setColors(1, std::vector{kRed}); }), HasSubstr("3 elements"));
  EXPECT_THAT(messageOf<Error>([&] { canvas.run(10, [](const CanvasEvent&) { return true; }); }),
              HasSubstr("without a window"));
  EXPECT_THAT(messageOf<Error>([&] { canvas.read(); }), HasSubstr("nothing has been drawn"));
  EXPECT_THAT(messageOf<Error>([] { openOffscreen(0, 10); }), HasSubstr("0 x 10"));
  EXPECT_THAT(messageOf<Error>([] { openOffscreen(1000000, 10); }), HasSubstr("1000000 x 10"));
}

TEST(CanvasModule, TakesTheDeviceThatIsNamed) {
  if (canvasOrNull(8, 8) == nullptr) GTEST_SKIP() << "this machine has no OpenGL by EGL";
  const ScopedVariable wrong("SCANMILL_GL_DEVICE", "toaster");
  EXPECT_THAT(messageOf<Error>([] { openOffscreen(8, 8); }), HasSubstr("there is no device 'toaster'"));
}

}  // namespace
}  // namespace scanmill
