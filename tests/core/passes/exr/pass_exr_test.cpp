#include "passes/exr/pass_exr.h"

#include <OpenEXR/ImfInputFile.h>

#include <cstring>

#include "tests/core/passes/exr/foreign_file.h"

namespace scanmill {
namespace {

constexpr PassChoice kExrPasses{Channels::all(), true};

Camera testCamera(std::uint32_t width, std::uint32_t height) {
  Camera camera = squareCamera(width, height, radians(100));
  camera.name = "front left";
  camera.cx += 3.25;
  camera.cy -= 0.1;
  camera.worldFromCamera = {fromYawPitchRoll(0.7, -0.2, 0.05) * vehicleFromOptical(), {1e7 + 0.123456789, -33.3, 2.1}};
  return camera;
}

// Noise in every plane; every fourth pixel sees nothing.
PassImage testImage(std::uint32_t width, std::uint32_t height, PassChoice choice = kExrPasses) {
  PassImage image{testCamera(width, height), {}};
  PassPlanes& planes = image.planes;
  planes.reset(image.camera.pixels(), choice);
  const Mat3 turn = toMatrix(image.camera.worldFromCamera.rotation);
  const std::uint32_t ids[] = {0, 2049, (1u << 24) + 1, 0xFFFFFFFFu, 7};
  for (std::uint32_t i = 0; i < image.camera.pixels(); ++i) {
    const RandomBlock random = randomBlock({.seed = 2, .beam = i});
    const auto share = [&](int k) { return static_cast<float>(uniform(random[k])); };
    const bool seen = i % 4 != 0;
    const auto fill = [&](auto& plane, auto value) {
      using Value = typename std::remove_reference_t<decltype(plane)>::value_type;
      if (!plane.empty()) plane[i] = seen ? static_cast<Value>(value) : Value{};
    };
    planes.depth[i] = seen ? 0.01f + 300 * share(0) : kNoDepth;
    const Vec3d sight = turn * image.camera.ray(i % width + 0.5, i / width + 0.5);
    Vec3d normal = normalized(Vec3d{uniform(random[1]) - 0.5, uniform(random[2]) - 0.5, uniform(random[3]) - 0.5});
    if (dot(normal, sight) > 0) normal = -normal;
    fill(planes.normal, normal);
    fill(planes.instance, ids[i % 5]);
    fill(planes.semantic, i % 2 == 0 ? 65535 : 3);
    fill(planes.material, i % 9);
    fill(planes.primitive, ids[(i + 2) % 5]);
    fill(planes.reflectance, share(1));
    fill(planes.roughness, share(2));
    fill(planes.metallic, i % 2);
    fill(planes.retroreflectance, 30 * share(3));
  }
  return image;
}

void expectSame(const PassPlanes& a, const PassPlanes& b) {
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.instance, b.instance);
  EXPECT_EQ(a.semantic, b.semantic);
  EXPECT_EQ(a.material, b.material);
  EXPECT_EQ(a.primitive, b.primitive);
  EXPECT_EQ(a.reflectance, b.reflectance);
  EXPECT_EQ(a.roughness, b.roughness);
  EXPECT_EQ(a.metallic, b.metallic);
  EXPECT_EQ(a.retroreflectance, b.retroreflectance);
}

void expectSame(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.worldFromCamera, b.worldFromCamera);
}

class ForeignPasses : public ForeignFile {};
class PassExr : public OneFile {};

TEST_F(PassExr, EveryBitComesBack) {
  for (const auto& [width, height] : {std::pair{1u, 1u}, {63u, 129u}, {300u, 7u}, {5u, 700u}}) {
    const PassImage image = testImage(width, height);
    writePasses(path, image);
    const PassImage back = readPasses(path, kExrPasses);
    expectSame(image.camera, back.camera);
    expectSame(image.planes, back.planes);
  }
}

TEST_F(PassExr, OnlyWhatIsAskedForIsReadAndWritten) {
  const PassChoice choice{Channel::Range | Channel::Normal | Channel::Semantic, false};
  const PassImage image = testImage(20, 10, choice);
  writePasses(path, image);
  EXPECT_EQ(passesIn(path), choice);
  const PassChoice less{Channel::Range | Channel::Semantic, false};
  const PassImage back = readPasses(path, less);
  EXPECT_EQ(back.planes.choice(), less);
  EXPECT_EQ(back.planes.semantic, image.planes.semantic);
  expectInputError([&] { readPasses(path, {Channel::Instance, false}); }, {path.string(), "'instance'", "semantic"});
  expectInputError([&] { readPasses(path, {Channel::Range, true}); }, {path.string(), "'roughness'"});
  writePasses(path, testImage(20, 10));
  EXPECT_EQ(passesIn(path).surfaceParameters, true);
}

TEST_F(PassExr, OtherReadersSeeTheSame) {
  const PassImage image = testImage(37, 50);
  writePasses(path, image);
  std::vector<float> depth(image.planes.size());
  std::vector<Vec3f> normal(depth.size());
  std::vector<std::uint32_t> instance(depth.size());
  Imf::InputFile file(path.c_str(), 0);
  const Imath::Box2i window = file.header().dataWindow();
  Imf::FrameBuffer frame;
  frame.insert("Z", Imf::Slice::Make(Imf::FLOAT, depth.data(), window));
  frame.insert("N.Y", Imf::Slice::Make(Imf::FLOAT, &normal[0].y, window, sizeof(Vec3f)));
  frame.insert("instance", Imf::Slice::Make(Imf::UINT, instance.data(), window));
  file.setFrameBuffer(frame);
  file.readPixels(window.min.y, window.max.y);
  EXPECT_EQ(instance, image.planes.instance);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    EXPECT_EQ(depth[i], image.planes.depth[i] < kNoDepth ? image.planes.depth[i] : 1e10f);
    EXPECT_EQ(normal[i].y, image.planes.normal[i].y);
  }
}

TEST_F(PassExr, TheSameImageGivesTheSameBytes) {
  writePasses(folder.path() / "a.exr", testImage(50, 40));
  writePasses(folder.path() / "b.exr", testImage(50, 40));
  EXPECT_EQ(readFile(folder.path() / "a.exr"), readFile(folder.path() / "b.exr"));
}

TEST_F(PassExr, PlanesThatDoNotFitAreNotWritten) {
  PassImage image = testImage(5, 5);
  image.planes.metallic.pop_back();
  const auto write = [&] { writePasses(path, image); };
  EXPECT_THAT(messageOf<Error>(write), testing::HasSubstr("metallic"));
  image.planes.depth.clear();
  EXPECT_THAT(messageOf<Error>(write), testing::HasSubstr("depth"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  image = testImage(5, 5);
  EXPECT_THAT(messageOf<Error>([&] { writePasses(folder.path() / "none" / "passes.exr", image); }),
              testing::HasSubstr("cannot be written"));
}

TEST_F(PassExr, DamageIsAnErrorAndNeverACrash) {
  writePasses(path, testImage(40, 50));
  expectDamageIsRefused([&] { readPasses(path, kExrPasses); });
  folder.write("file.exr", "not an image at all");
  expectInputError([&] { readPasses(path, {}); }, {path.string(), "not an OpenEXR file"});
  expectInputError([&] { readPasses(folder.path() / "absent.exr", {}); }, {"absent.exr"});
}

TEST_F(PassExr, ClaimsThatTheFileCannotHoldAreRefused) {
  writePasses(path, testImage(40, 50));
  const std::string bytes = readFile(path);
  const auto claiming = [&](std::int32_t width, std::int32_t height) {
    std::string huge = bytes;
    for (const char* name : {"dataWindow", "displayWindow"}) {
      const std::size_t place = huge.find(std::string(name) + '\0' + "box2i") + std::string(name).size() + 11;
      const std::int32_t corners[] = {0, 0, width - 1, height - 1};
      std::memcpy(&huge[place], corners, sizeof corners);
    }
    folder.write("huge.exr", huge);
    return messageOf([&] { readPasses(folder.path() / "huge.exr", kExrPasses); });
  };
  EXPECT_EQ(claiming(40, 50), "accepted");
  EXPECT_THAT(claiming(100000, 100000), testing::HasSubstr("huge.exr"));
  EXPECT_THAT(claiming(60000, 60000), testing::HasSubstr("huge.exr"));
  EXPECT_THAT(claiming(16000, 16000), testing::HasSubstr("huge.exr"));
  EXPECT_THAT(claiming(2147483647, 2147483647), testing::HasSubstr("huge.exr"));
  EXPECT_THAT(claiming(2147483647, 1), testing::HasSubstr("huge.exr"));
  EXPECT_THAT(claiming(0, 50), testing::HasSubstr("huge.exr"));
}

TEST_F(ForeignPasses, ChannelsInLayersAreFound) {
  add("ViewLayer.Depth.Z", Imf::FLOAT, 5, 1e10f);
  add("ViewLayer.Mist.Z", Imf::FLOAT, 0.5f);
  addNormal("ViewLayer.Normal.");
  addNormal("ViewLayer.Position.");
  add("ViewLayer.Combined.R", Imf::HALF, 0.5f);
  add("ViewLayer.IndexOB.X", Imf::FLOAT, 7, 0);
  add("ViewLayer.IndexMA.X", Imf::FLOAT, 3, 0);
  add("ViewLayer.semantic.X", Imf::FLOAT, 2, 0);
  const PassChoice choice{Channel::Range | Channel::Normal | Channel::Instance | Channel::Material | Channel::Semantic,
                          false};
  EXPECT_EQ(passesIn(write()), choice);
  const PassImage image = read(choice);
  EXPECT_EQ(image.camera.name, "foreign");
  EXPECT_EQ(image.camera.worldFromCamera.translation, (Vec3d{10, 20, 30}));
  EXPECT_EQ(image.planes.depth.front(), 5);
  EXPECT_EQ(image.planes.normal.front(), (Vec3f{-1, 0, 0}));
  EXPECT_EQ(image.planes.instance.front(), 7u);
  EXPECT_EQ(image.planes.material.front(), 3u);
  EXPECT_EQ(image.planes.semantic.front(), 2u);
  // Where nothing is seen, everything is zero, whatever the file says.
  EXPECT_EQ(image.planes.depth.back(), kNoDepth);
  EXPECT_EQ(image.planes.normal.back(), Vec3f{});
}

TEST_F(ForeignPasses, ALayersZIsTheDepthUnlessItIsPartOfAVector) {
  add("beauty.Z", Imf::FLOAT, 4);
  addNormal("N.");
  addNormal("P.");
  EXPECT_EQ(read({Channel::Normal, false}).planes.depth[0], 4);
}

TEST_F(ForeignPasses, AVectorIsNoDepth) {
  addNormal("N.");
  expectRefused({"'Z'", "N.X"});
}

TEST_F(ForeignPasses, TwoLayersAreNotGuessedBetween) {
  add("a.Depth.Z", Imf::FLOAT, 4);
  add("b.Depth.Z", Imf::FLOAT, 5);
  expectRefused({"a.Depth.Z", "b.Depth.Z"});
}

TEST_F(ForeignPasses, InfiniteAndVeryFarDepthSeesNothing) {
  for (const float nothing : {INFINITY, 1e9f, 1e10f, 3e38f}) {
    add("Z", Imf::FLOAT, 5, nothing);
    add("reflectance", Imf::FLOAT, 0.5f, NAN);
    const PassImage image = read({Channel::Reflectance, false});
    EXPECT_EQ(image.planes.depth.back(), kNoDepth);
    EXPECT_EQ(image.planes.reflectance.back(), 0);
    EXPECT_EQ(image.planes.reflectance.front(), 0.5f);
  }
}

TEST_F(ForeignPasses, SenselessDepthIsRefusedWithItsPlace) {
  for (const float bad : {NAN, -INFINITY, -1.0f, 0.0f, -0.0f}) {
    add("Z", Imf::FLOAT, 5, bad);
    expectRefused({"'Z'", "column 7, row 5"});
  }
}

TEST_F(ForeignPasses, DepthMustBeFloat) {
  add("Z", Imf::HALF, 5);
  expectRefused({"'Z'", "HALF", "32 bit FLOAT"});
  add("Z", Imf::UINT, 5);
  expectRefused({"'Z'", "UINT", "32 bit FLOAT"});
}

TEST_F(ForeignPasses, IdsMustBeWholeAndExact) {
  add("Z", Imf::FLOAT, 5);
  add("instance", Imf::HALF, 7);
  expectRefused({"'instance'", "HALF", "UINT"}, {Channel::Instance, false});
  for (const float bad : {0.5f, -1.0f, 16777216.0f, INFINITY, NAN}) {
    add("instance", Imf::FLOAT, 7, bad);
    expectRefused({"'instance'", "column 7, row 5", "UINT"}, {Channel::Instance, false});
  }
  add("instance", Imf::FLOAT, 7, 16777215);
  EXPECT_EQ(read({Channel::Instance, false}).planes.instance.back(), 16777215u);
  for (const Imf::PixelType type : {Imf::FLOAT, Imf::UINT}) {
    add("semantic", type, 7, 65536);
    expectRefused({"'semantic'", "65536", "column 7, row 5"}, {Channel::Semantic, false});
    add("semantic", type, 7, 65535);
    EXPECT_EQ(read({Channel::Semantic, false}).planes.semantic.back(), 65535u);
  }
}

TEST_F(ForeignPasses, NormalsAreUnitVectorsTurnedToTheCamera) {
  const PassChoice asked{Channel::Normal, false};
  add("Z", Imf::FLOAT, 5);
  addNormal("N.", Imf::HALF);
  EXPECT_EQ(read(asked).planes.normal[0], (Vec3f{-1, 0, 0}));
  // The camera looks along x.
  add("N.X", Imf::FLOAT, -1, 1);
  EXPECT_EQ(read(asked).planes.normal.back(), (Vec3f{-1, 0, 0}));
  add("N.X", Imf::FLOAT, -1.005f);
  EXPECT_FLOAT_EQ(read(asked).planes.normal[0].x, -1);
  for (const float bad : {0.0f, 0.5f, -2.0f, NAN, INFINITY}) {
    add("N.X", Imf::FLOAT, -1, bad);
    expectRefused({"'N.X'", "unit", "column 7, row 5"}, asked);
  }
  add("N.X", Imf::UINT, 1);
  expectRefused({"'N.X'", "UINT", "FLOAT"}, asked);
}

TEST_F(ForeignPasses, CameraAxesOfOpenGlAreTold) {
  const PassChoice asked{Channel::Normal, false};
  add("Z", Imf::FLOAT, 5);
  addNormal("N.");
  EXPECT_EQ(read(asked).planes.normal[0], (Vec3f{-1, 0, 0}));
  setPose({0, 0, -1, 10, -1, 0, 0, 20, 0, 1, 0, 30, 0, 0, 0, 1});  // the same camera, y up and z backward
  expectRefused({"'N.X'", "48 of 48", "worldFromCamera", "x right, y down, z forward", "OpenGL", "Blender",
                 "negate its second and third column"},
                asked);
  EXPECT_EQ(read({}).planes.depth[0], 5);  // whoever needs no normals cannot know
  // Half of the pixels that see something are still turned; one more is not.
  setPose({0, 0, 1, 10, -1, 0, 0, 20, 0, -1, 0, 30, 0, 0, 0, 1});
  const auto facingAway = [&](std::size_t count) {
    PassImage image = testImage(8, 8, asked);  // sees 48 pixels
    for (std::size_t i = 0, turned = 0; turned < count; ++i) {
      if (i % 4 == 0) continue;
      image.planes.normal[i] = -image.planes.normal[i];
      ++turned;
    }
    writePasses(path, image);
    return messageOf([&] { readPasses(path, asked); });
  };
  EXPECT_EQ(facingAway(24), "accepted");
  EXPECT_THAT(facingAway(25), testing::HasSubstr("25 of 48"));
}

TEST_F(ForeignPasses, WhatDoesInPlaceOfAPassIsTold) {
  add("Z", Imf::FLOAT, 5);
  expectRefused({"'material'", "roughness, metallic and retroreflectance in its place"}, {Channel::Material, false});
  expectRefused({"'N.X, N.Y, N.Z'", "`sampling: nearest` does without"}, {Channel::Normal, false});
  EXPECT_THAT(messageOf([&] { read({Channel::Semantic, false}); }), testing::Not(testing::HasSubstr("(")));
}

TEST_F(ForeignPasses, LooksLieInTheirBounds) {
  add("Z", Imf::FLOAT, 5);
  for (const float bad : {-0.1f, 1.5f, NAN, INFINITY}) {
    add("reflectance", Imf::FLOAT, 0.5f, bad);
    expectRefused({"'reflectance'", "column 7, row 5"}, {Channel::Reflectance, false});
  }
  for (const char* name : {"roughness", "metallic", "retroreflectance"}) add(name, Imf::HALF, 0.5f);
  EXPECT_EQ(read({Channel::Range, true}).planes.metallic[0], 0.5f);
  add("retroreflectance", Imf::FLOAT, 40);
  EXPECT_EQ(read({Channel::Range, true}).planes.retroreflectance[0], 40);
  add("metallic", Imf::FLOAT, -1);
  expectRefused({"'metallic'"}, {Channel::Range, true});
}

}  // namespace
}  // namespace scanmill
