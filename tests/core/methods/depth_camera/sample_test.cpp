#include "methods/depth_camera/sample.h"

#include "methods/depth_camera/depth_camera.h"
#include "tests/core/methods/depth_camera/worlds.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

constexpr DrawLimits kLimits{0.01, 2000};

RigBeams beamsAlong(const std::vector<Vec3d>& directions, double minRange = 0, double maxRange = 2000) {
  RigBeams beams;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    beams.direction.push_back(normalized(directions[i]));
    beams.beam.push_back(static_cast<std::uint32_t>(i));
  }
  beams.minRange = minRange;
  beams.maxRange = maxRange;
  return beams;
}

Hits sampled(const std::vector<PassImage>& images, const RigBeams& beams, const SampleOptions& options = {},
             Channels channels = Channels::all(), std::uint64_t* unseen = nullptr) {
  ImageSource source(images);
  Hits hits;
  hits.reset(1, static_cast<std::uint32_t>(beams.direction.size()), channels);
  const std::uint64_t count = samplePixels(source, {}, beams, options, hits);
  if (unseen != nullptr) *unseen = count;
  return hits;
}

std::vector<PassImage> drawn(const Scene& scene, const std::vector<Camera>& cameras) {
  EmbreePasses renderer(scene);
  const PassChoice all{Channels::all(), false};
  const auto source = renderer.draw(cameras, kLimits, all);
  return readAll(*source, all);
}

// A camera at the origin that looks along x.
Camera ahead(std::uint32_t size, double fieldDeg) {
  Camera camera = squareCamera(size, size, radians(fieldDeg));
  camera.name = "front";
  camera.worldFromCamera.rotation = vehicleFromOptical();
  return camera;
}

// Directions spread over a camera's image but for a margin, none at a pixel's centre.
std::vector<Vec3d> across(const Camera& camera, int count = 61, double margin = 0.6) {
  std::vector<Vec3d> directions;
  const Mat3 axes = toMatrix(camera.worldFromCamera.rotation);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      const double u = margin + (camera.width - 2 * margin) * (i + 0.37) / count;
      const double v = margin + (camera.height - 2 * margin) * (j + 0.61) / count;
      directions.push_back(normalized(axes * camera.ray(u, v)));
    }
  }
  return directions;
}

// An image of one depth, ids 1.
PassImage flat(std::uint32_t size, float depth) {
  PassImage image{ahead(size, 60), {}};
  image.planes.reset(image.camera.pixels(), {Channels::all(), false});
  PassPlanes& p = image.planes;
  std::fill(p.depth.begin(), p.depth.end(), depth);
  std::fill(p.normal.begin(), p.normal.end(), Vec3f{-1, 0, 0});
  std::fill(p.instance.begin(), p.instance.end(), 1u);
  std::fill(p.semantic.begin(), p.semantic.end(), std::uint16_t{2});
  std::fill(p.material.begin(), p.material.end(), std::uint16_t{1});
  std::fill(p.primitive.begin(), p.primitive.end(), 7u);
  std::fill(p.reflectance.begin(), p.reflectance.end(), 0.5f);
  return image;
}

TEST(Sample, PlaneIsExactOnFlatSurfacesInAnyField) {
  const Scene scene = room();
  for (const double field : {10.0, 30.0, 60.0, 90.0, 120.0, 150.0, 170.0}) {
    SCOPED_TRACE(field);
    const Camera camera = ahead(256, field);
    const std::vector<Vec3d> directions = across(camera);
    const Hits truth = traced(scene, shotAt(beamsOf(directions, 0, 2000)));
    const Hits hits = sampled(drawn(scene, {camera}), beamsAlong(directions));
    const std::vector<double> errors = relativeErrors(truth, hits);
    EXPECT_GT(errors.size(), directions.size() * 9 / 10);
    EXPECT_LT(largest(errors), 1e-5);
  }
}

TEST(Sample, NearestErrsByHalfAPixelsFootprint) {
  const Scene scene = room();
  const Camera camera = ahead(128, 90);
  const std::vector<Vec3d> directions = across(camera, 101);
  const Hits truth = traced(scene, shotAt(beamsOf(directions, 0, 2000)));
  SampleOptions nearest;
  nearest.sampling = Sampling::Nearest;
  const Hits hits = sampled(drawn(scene, {camera}), beamsAlong(directions), nearest);
  const double pixel = 1 / camera.fx;  // rad, at most: pixels are largest at the image's centre
  std::size_t checked = 0;
  double most = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth.primitive[i] != hits.primitive[i] || truth.instance[i] != hits.instance[i]) continue;
    // The plane r(t) = r cos(i) / cos(i + t) over t of half a pixel's diagonal.
    const double incidence = std::acos(std::min(1.0, double{truth.incidence[i]}));
    const double t = pixel * std::sqrt(0.5);
    if (incidence + t > radians(89.0)) continue;
    const double bound = double{truth.range[i]} * (std::cos(incidence) / std::cos(incidence + t) - 1);
    EXPECT_LE(std::abs(hits.range[i] - truth.range[i]), bound * 1.01 + 1e-5);
    most = std::max(most, std::abs(double{hits.range[i] - truth.range[i]}) / bound);
    ++checked;
  }
  EXPECT_GT(checked, directions.size() * 8 / 10);
  EXPECT_GT(most, 0.5) << "the bound is tight";
}

TEST(Sample, RangesOutsideOfTheLimitsAreMisses) {
  const PassImage image = flat(64, 10);
  const std::vector<Vec3d> directions = {{1, 0.001, 0.001}};
  for (const Sampling sampling : {Sampling::Plane, Sampling::Nearest}) {
    SampleOptions options;
    options.sampling = sampling;
    const auto range = [&](double minimum, double maximum) {
      return sampled({image}, beamsAlong(directions, minimum, maximum), options).range[0];
    };
    EXPECT_NEAR(range(0, 2000), 10, 0.01);
    EXPECT_NEAR(range(9.9, 10.1), 10, 0.01);
    EXPECT_EQ(range(0, 9.9), kMiss);
    EXPECT_EQ(range(10.1, 2000), kMiss) << "a nearer surface blocks";
  }
  SampleOptions options;
  const Hits at10 = sampled({image}, beamsAlong({{1, 0, 0}}, 10, 10), options);
  EXPECT_EQ(at10.range[0], 10.0f) << "the limits themselves count";
}

TEST(Sample, MissesAreZeroedAndWhatNoImageSeesIsCounted) {
  PassImage image = flat(64, kNoDepth);
  std::uint64_t unseen = 0;
  const Hits hits = sampled({image}, beamsAlong({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {1, 0.57, 0}, {1, 0.58, 0}}), {},
                            Channels::all(), &unseen);
  EXPECT_EQ(unseen, 3u) << "tan(30) = 0.577";
  for (std::size_t i = 0; i < hits.size(); ++i) {
    EXPECT_EQ(hits.range[i], kMiss);
    EXPECT_EQ(hits.instance[i], 0u);
    EXPECT_EQ(hits.semantic[i], 0u);
    EXPECT_EQ(hits.material[i], 0u);
    EXPECT_EQ(hits.primitive[i], 0u);
    EXPECT_EQ(hits.reflectance[i], 0.0f);
    EXPECT_EQ(hits.incidence[i], 0.0f);
    EXPECT_EQ(hits.normal[i], Vec3f{});
  }
}

TEST(Sample, APlaneSeenEdgeOnGivesThePixelsPoint) {
  PassImage image = flat(64, 10);
  const std::vector<Vec3d> directions = {normalized(Vec3d{1, 0.004, 0.004})};
  for (const Vec3f normal : {Vec3f{0, 1, 0}, Vec3f{0, 0, 1}, Vec3f{}, Vec3f{1e-7f, 1, 0}}) {
    std::fill(image.planes.normal.begin(), image.planes.normal.end(), normal);
    const Hits hits = sampled({image}, beamsAlong(directions));
    EXPECT_NEAR(hits.range[0], 10, 0.1);
  }
}

// z^2 (f - n) / (f n 2^b) is the step of a b-bit z-buffer; what is stored lies within half of it.
TEST(Sample, DepthFormatsErrByTheirClosedForms) {
  const double n = 0.1;
  const double f = 500;
  for (const auto& [format, bits] : {std::pair{DepthFormat::Unorm24, 24}, std::pair{DepthFormat::Unorm16, 16}}) {
    for (const double z : {0.5, 3.0, 20.0, 90.0}) {
      const double step = z * z * (f - n) / (f * n * std::ldexp(1.0, bits));
      double most = 0;
      for (int i = 0; i < 2000; ++i) {
        const auto depth = static_cast<float>(z + step * 3 * (i / 2000.0));
        most = std::max(most, std::abs(double{storedDepth(depth, format, n, f)} - double{depth}));
      }
      EXPECT_GT(most, step / 4) << bits << " bits at " << z;
      EXPECT_LT(most, step) << bits << " bits at " << z;
    }
  }
  // Halves between 2^k and 2^(k + 1) are 2^(k - 10) apart: 0.25 m below 512 - 500 m, 0.5 m beyond.
  for (const auto& [z, step] : {std::pair{5.0, 0.25}, {50.0, 0.5}, {400.0, 0.5}, {600.0, 1.0}}) {
    double most = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto depth = static_cast<float>(z + 0.002 * i);
      most = std::max(most, std::abs(double{storedDepth(depth, DepthFormat::Half500, n, f)} - double{depth}));
    }
    EXPECT_NEAR(most, step / 2, step / 100) << z;
  }
  EXPECT_EQ(storedDepth(12.25f, DepthFormat::Half500, n, f), 12.0f)
      << "ties to even: 512.25 lies between 512 and 512.5";
  EXPECT_EQ(storedDepth(12.75f, DepthFormat::Half500, n, f), 13.0f);
  EXPECT_EQ(storedDepth(1e6f, DepthFormat::Half500, n, f), 65004.0f) << "beyond the largest half";
  for (const DepthFormat format :
       {DepthFormat::Float32, DepthFormat::Unorm24, DepthFormat::Unorm16, DepthFormat::Half500}) {
    EXPECT_EQ(storedDepth(kNoDepth, format, n, f), kNoDepth);
  }
  EXPECT_EQ(storedDepth(3.3f, DepthFormat::Float32, n, f), 3.3f);
}

TEST(Sample, StoredDepthsReachTheBeams) {
  const double n = 0.1;
  const double f = 500;
  const Scene scene = room();
  const Camera camera = ahead(256, 90);
  const std::vector<Vec3d> directions = across(camera);
  const std::vector<PassImage> images = drawn(scene, {camera});
  const auto zBuffer = [&](int bits) {
    return [=](double z) { return z * z * (f - n) / (f * n * std::ldexp(1.0, bits)); };
  };
  for (const Sampling sampling : {Sampling::Nearest, Sampling::Plane}) {
    SampleOptions options{sampling, DepthFormat::Float32, n, f};
    const Hits exact = sampled(images, beamsAlong(directions), options);
    // Mean error over what an error uniform over half a step to either side gives along the line of sight.
    const auto ofExpected = [&](DepthFormat format, const auto& step) {
      options.depth = format;
      const Hits hits = sampled(images, beamsAlong(directions), options);
      double sum = 0;
      double expected = 0;
      for (std::size_t i = 0; i < hits.size(); ++i) {
        sum += std::abs(double{hits.range[i]} - double{exact.range[i]});
        expected += step(double{exact.range[i]} * directions[i].x) / 4 / directions[i].x;
      }
      return sum / expected;
    };
    EXPECT_NEAR(std::log2(ofExpected(DepthFormat::Unorm16, zBuffer(16))), 0, 1);
    EXPECT_NEAR(std::log2(ofExpected(DepthFormat::Unorm24, zBuffer(24))), 0, 1);
    EXPECT_NEAR(std::log2(ofExpected(DepthFormat::Half500, [](double z) { return z < 12 ? 0.25 : 0.5; })), 0, 1);
  }
}

// An object that straddles the seam of two images, and every place on the seam itself.
TEST(Sample, SeamsDoNotShow) {
  const Scene scene = room();
  for (const CameraLayout layout : {CameraLayout::Three120, CameraLayout::Four90, CameraLayout::Cube6}) {
    const double seam = radians(layout == CameraLayout::Three120 ? 60.0 : 45.0);
    std::vector<Vec3d> directions;
    for (int i = -200; i <= 200; ++i) {
      for (int j = -10; j <= 10; ++j) {
        directions.push_back(normalized(Vec3d{std::cos(seam + 1e-3 * i), std::sin(seam + 1e-3 * i), 0.03 * j}));
      }
    }
    for (int j = -10; j <= 10; ++j) {  // to the last bit, and from both sides
      for (const double nudge : {-1e-16, 0.0, 1e-16}) {
        directions.push_back(normalized(Vec3d{std::cos(seam) + nudge, std::sin(seam), 0.03 * j}));
      }
    }
    const std::vector<Camera> cameras = layOutCameras(directions, {layout, 512});
    ASSERT_EQ(cameras.size(), 2u);
    std::uint64_t unseen = 0;
    const Hits hits = sampled(drawn(scene, cameras), beamsAlong(directions), {}, Channels::all(), &unseen);
    const Hits truth = traced(scene, shotAt(beamsOf(directions, 0, 2000)));
    EXPECT_EQ(unseen, 0u);
    const std::vector<double> errors = relativeErrors(truth, hits);
    EXPECT_GT(errors.size(), directions.size() * 97 / 100);
    EXPECT_LT(largest(errors), 1e-5);
  }
}

TEST(Sample, BeamsThatStartElsewhereLookAtThePointTheyMeet) {
  const Scene scene = room();
  const Camera camera = ahead(512, 100);
  const std::vector<Vec3d> directions = across(ahead(512, 60));
  RigBeams beams = beamsAlong(directions);
  auto table = beamsOf(directions, 0, 2000);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    table->origin.push_back(Vec3f{0.1f, 0.02f * static_cast<float>(i % 11) - 0.1f, 0.05f});
    beams.origin.emplace_back(table->origin.back());
  }
  const Hits truth = traced(scene, shotAt(table));
  const std::vector<PassImage> images = drawn(scene, {camera});
  const Hits hits = sampled(images, beams);
  const std::vector<double> errors = relativeErrors(truth, hits);
  EXPECT_GT(errors.size(), directions.size() * 95 / 100);
  EXPECT_LT(largest(errors), 1e-5);
  // What the first round gives would be a decimetre off in many places; nearest after three rounds is within a pixel.
  SampleOptions nearest;
  nearest.sampling = Sampling::Nearest;
  EXPECT_LT(meanError(truth, sampled(images, beams, nearest)), 0.05);
}

TEST(Sample, LookOfOthersMaterialsIsKept) {
  PassImage image = flat(8, 4);
  image.planes.roughness.assign(64, 0.25f);
  image.planes.metallic.assign(64, 1.0f);
  image.planes.retroreflectance.assign(64, 30.0f);
  const Hits hits = sampled({image}, beamsAlong({{1, 0, 0}, {-1, 0, 0}}));
  ASSERT_EQ(hits.roughness.size(), 2u);
  EXPECT_EQ(hits.roughness[0], 0.25f);
  EXPECT_EQ(hits.metallic[0], 1.0f);
  EXPECT_EQ(hits.retroreflectance[0], 30.0f);
  EXPECT_EQ(hits.retroreflectance[1], 0.0f);
  EXPECT_TRUE(sampled({flat(8, 4)}, beamsAlong({{1, 0, 0}})).roughness.empty());
}

TEST(Sample, NormalsFaceTheBeamAndPassesThatLackAreNamed) {
  PassImage image = flat(8, 4);
  std::fill(image.planes.normal.begin(), image.planes.normal.end(), Vec3f{0.6f, 0, 0.8f});
  const Hits hits = sampled({image}, beamsAlong({{1, 0, 0}}));
  EXPECT_EQ(hits.normal[0], (Vec3f{-0.6f, 0, -0.8f}));
  EXPECT_NEAR(hits.incidence[0], 0.6, 1e-6);
  image.planes.reset(64, {Channel::Range | Channel::Instance, false});
  std::fill(image.planes.depth.begin(), image.planes.depth.end(), 4.0f);
  expectInputError([&] { sampled({image}, beamsAlong({{1, 0, 0}}), {}, Channel::Range); }, {"front", "normal"});
  SampleOptions nearest;
  nearest.sampling = Sampling::Nearest;
  EXPECT_NEAR(sampled({image}, beamsAlong({{1, 0, 0}}), nearest, Channel::Range).range[0], 4, 0.1);
}

// LiDAR-GEIL, equation (1): x = (u - 0.5) z / (0.5 tan(FOV)), u from 0 to 1 across the image.
double paperEq1(double u, double z, double field) {
  return (u - 0.5) * z / (0.5 * std::tan(field));
}

TEST(PaperEq1, IsRightAt60DegreesCollapsesAt90AndMirrorsAt120) {
  const auto pinhole = [](double u, double z, double field) {
    const Camera camera = squareCamera(1000, 1000, field);
    return camera.ray(1000 * u, 500).x * z;
  };
  for (const double u : {0.05, 0.3, 0.8, 1.0}) {
    for (const double z : {1.0, 25.0}) {
      EXPECT_NEAR(pinhole(u, z, radians(120.0)), (u - 0.5) * z * 2 * std::tan(radians(60.0)), 1e-9);
      EXPECT_NEAR(paperEq1(u, z, radians(60.0)), pinhole(u, z, radians(60.0)), 1e-9);
      EXPECT_NEAR(paperEq1(u, z, radians(90.0)), 0, 1e-9) << "everything on the axis";
      EXPECT_NEAR(paperEq1(u, z, radians(120.0)), -pinhole(u, z, radians(120.0)) / 3, 1e-9) << "left is right";
    }
  }
}

}  // namespace
}  // namespace scanmill
