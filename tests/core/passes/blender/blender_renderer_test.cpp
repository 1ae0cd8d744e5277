// Blender's images against a reference that intersects every triangle in double precision.

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "assets/meshes/blender.h"
#include "base/parallel.h"
#include "passes/blender/blender_scene.h"
#include "passes/exr/exr_file.h"
#include "passes/renderer.h"
#include "scenefile/scene_file.h"
#include "tests/core/passes/ray_reference.h"
#include "tests/support/blender.h"
#include "tests/support/message_of.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

constexpr PassChoice kEverything{Channels::all(), true};

Camera uprightCamera(const Vec3d& position, double yawDeg, double pitchDeg, std::uint32_t width, std::uint32_t height,
                     double fieldDeg) {
  Camera camera = squareCamera(width, height, radians(fieldDeg));
  const Quat heading = fromYawPitchRoll(radians(yawDeg), radians(pitchDeg), 0);
  camera.worldFromCamera = {heading * vehicleFromOptical(), position};
  camera.name = "test";
  return camera;
}

// A texture of 4 x 2 texels, of which some are holes; its first row is the image's bottom.
Material leaves() {
  auto texture = std::make_shared<Texture>();
  texture->width = 4;
  texture->height = 2;
  texture->hasAlpha = true;
  for (const int alpha : {255, 0, 128, 127, 0, 255, 254, 1}) {
    texture->rgba.insert(texture->rgba.end(), {10, 200, 30, static_cast<std::uint8_t>(alpha)});
  }
  Material material;
  material.name = "leaves";
  material.alphaTested = true;
  material.alphaCutoff = 0.5f;
  material.texture = texture;
  return material;
}

// Ground, a wall, a ball, boxes that share a mesh (one mirrored, one sheared), and a card with holes.
Scene smallScene(const Vec3d& where) {
  SceneBuilder builder = testBuilder();
  const auto place = [&](std::uint32_t mesh, const Mat3& linear, const Vec3d& at, const char* name) {
    builder.place(mesh, {linear, where + at}, name);
  };
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 200, 200, 4);
  place(builder.addMesh(ground), {}, {0, 0, 0}, "ground");
  Mesh wall = meshOf(builder, "other", "dark");
  appendQuad(wall, 0, {0, 0, 0}, {60, 0, 0}, {60, 0, 8}, {0, 0, 8});
  place(builder.addMesh(wall), {}, {-10, 4, 0}, "wall");
  Mesh ball = meshOf(builder, "thing");
  appendSphere(ball, 0, {}, 1.5, 16);
  place(builder.addMesh(ball), {}, {14, -2, 1.2}, "ball");
  Mesh box = meshOf(builder, "thing");
  box.surfaces.push_back(builder.surface("other", "dark"));
  appendBox(box, 0, {}, {1, 2, 1});
  appendBox(box, 1, at(0.2, 0.5, 1), {0.6, 0.5, 1});
  const std::uint32_t boxes = builder.addMesh(box);
  place(boxes, {}, {8, 1.5, 0.5}, "box");
  place(boxes, Mat3::scale({1, -1, 1}), {8, -4, 0.5}, "mirrored box");
  place(boxes, {{1, 0.3, 0}, {0, 1.5, 0}, {0.4, 0, 2}}, {20, -6, 1}, "sheared box");
  Mesh card = meshOf(builder, "other");
  card.surfaces[0].material = builder.addMaterial(leaves());
  appendQuad(card, 0, {0, -1, 0}, {0, 1, 0}, {0, 1, 2}, {0, -1, 2});
  card.uvs = {{-0.25f, 0.1f}, {1.6f, 0.1f}, {1.6f, 1.9f}, {-0.25f, 1.9f}};
  place(builder.addMesh(card), {}, {6, -1, 0.3}, "card");
  return builder.finish();
}

std::vector<Camera> variousCameras(const Vec3d& where) {
  const Vec3d eye = where + Vec3d{0, 0, 1.7};
  std::vector<Camera> cameras;
  cameras.push_back(uprightCamera(eye, 0, 5, 160, 120, 60));
  cameras.push_back(uprightCamera(eye, -8, 2, 120, 160, 10));
  cameras.push_back(uprightCamera(eye, 20, 10, 200, 100, 150));
  cameras.push_back(uprightCamera(eye + Vec3d{0, -1, 0.5}, -30, 0, 151, 97, 90));  // the principal point far off
  cameras.back().cx += 40.25;
  cameras.back().cy -= 71.5;
  cameras.push_back(uprightCamera(eye, 5, 3, 96, 144, 80));  // pixels that are not square
  cameras.back().fy *= 1.7;
  cameras.push_back(uprightCamera(eye, 5, 3, 144, 96, 80));
  cameras.back().fy *= 0.4;
  cameras.back().cx -= 30;
  cameras.push_back(uprightCamera(eye, -15, 0, 128, 128, 120));  // rolled
  cameras.back().worldFromCamera.rotation =
      cameras.back().worldFromCamera.rotation * Quat{std::cos(0.3), 0, 0, std::sin(0.3)};
  cameras.push_back(uprightCamera(eye, 0, 0, 3, 2, 70));  // smaller than Blender's images can be
  return cameras;
}

struct Agreement {
  std::size_t pixels = 0;
  std::size_t same = 0;          // instance and triangle
  std::size_t differInside = 0;  // away from edges
  std::size_t seen = 0;
  double worstDepth = 0;  // relative, where both see the same triangle
};

Agreement compare(const Scene& scene, const PassImage& image, const DrawLimits& limits) {
  const std::vector<ReferencePixel> expected = RayReference(scene).draw(image.camera, limits);
  Agreement found;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const ReferencePixel& pixel = expected[i];
    const PassPlanes& planes = image.planes;
    const bool nothing = pixel.instance == 0;
    bool same = std::isinf(planes.depth[i]) == nothing;
    if (same && !nothing) {
      const Instance& instance = scene.instances[pixel.instance - 1];
      const Mesh& mesh = scene.meshes[instance.mesh];
      const Surface& surface = mesh.surfaces[mesh.surfaceOf[pixel.triangle]];
      same = planes.primitive[i] == pixel.triangle && planes.instance[i] == instanceId(instance, surface) &&
             planes.semantic[i] == surface.semantic && planes.material[i] == surface.material;
    }
    ++found.pixels;
    found.seen += nothing ? 0 : 1;
    found.same += same ? 1 : 0;
    if (!same && isInside(expected, image.camera, i)) ++found.differInside;
    if (same && !nothing) {
      found.worstDepth = std::max(found.worstDepth, std::abs(double{planes.depth[i]} - pixel.depth) / pixel.depth);
    }
  }
  return found;
}

void expectAgreement(const Scene& scene, const PassImage& image, const DrawLimits& limits) {
  SCOPED_TRACE(image.camera.name + " " + std::to_string(image.camera.width) + " x " +
               std::to_string(image.camera.height) + ", fx " + std::to_string(image.camera.fx));
  const Agreement found = compare(scene, image, limits);
  EXPECT_EQ(found.differInside, 0u);
  EXPECT_GE(static_cast<double>(found.same), 0.998 * static_cast<double>(found.pixels));
  EXPECT_LT(found.worstDepth, 1e-5);
  EXPECT_GT(found.seen, found.pixels / 4);
}

TEST(BlenderRenderer, SeesWhatRaysMeet) {
  SKIP_WITHOUT_BLENDER();
  const Scene scene = smallScene({0, 0, 0});
  const auto renderer = makeBlenderRenderer(scene);
  const std::vector<Camera> cameras = variousCameras({0, 0, 0});
  const DrawLimits limits{0.01, 1000};
  const auto images = readAll(*renderer->draw(cameras, limits, kEverything), kEverything);
  ASSERT_EQ(images.size(), cameras.size());
  for (const PassImage& image : images) expectAgreement(scene, image, limits);

  // Limits cut what is nearer and farther; the scene stays where it is.
  const DrawLimits narrow{7, 15};
  const std::vector<Camera> some{cameras[0], cameras[3]};
  for (const PassImage& image : readAll(*renderer->draw(some, narrow, kEverything), kEverything)) {
    const Agreement found = compare(scene, image, narrow);
    EXPECT_EQ(found.differInside, 0u);
    EXPECT_GT(found.seen, 0u);
    EXPECT_LT(found.seen, found.pixels);
    for (const float depth : image.planes.depth) EXPECT_TRUE(std::isinf(depth) || (depth >= 7 && depth <= 15)) << depth;
  }
  EXPECT_THAT(renderer->device(), HasSubstr("Blender"));
}

TEST(BlenderRenderer, FarFromTheOriginAndFarFromTheFirstImage) {
  SKIP_WITHOUT_BLENDER();
  const Vec3d far{1e7, -2e7, 500};
  const Scene scene = smallScene(far);
  const auto renderer = makeBlenderRenderer(scene);
  const DrawLimits limits{0.01, 1000};
  // The first looks from 5 km away: the scene is then handed over again, relative to another place.
  const auto elsewhere = readAll(
      *renderer->draw({uprightCamera(far + Vec3d{5000, 0, 2}, 0, 0, 16, 16, 60)}, limits, kEverything), kEverything);
  for (const float depth : elsewhere[0].planes.depth) EXPECT_TRUE(std::isinf(depth));
  const std::vector<Camera> all = variousCameras(far);
  const std::vector<Camera> cameras(all.begin(), all.begin() + 5);
  for (const PassImage& image : readAll(*renderer->draw(cameras, limits, kEverything), kEverything)) {
    expectAgreement(scene, image, limits);
  }
}

// On surfaces seen at a slant, the depth tells where in the image it was taken: Blender's own depth, as it writes it.
// Their triangles have numbers beyond what 16 bits and HALF hold.
TEST(BlenderRenderer, TakesThePixelsCentre) {
  SKIP_WITHOUT_BLENDER();
  SceneBuilder builder = testBuilder();
  Mesh corner = meshOf(builder, "ground");
  corner.surfaces.push_back(builder.surface("other", "dark"));
  appendPlane(corner, 0, at(0, 0, -2), 100, 100, 200);                                     // 2 m below
  appendPlane(corner, 1, {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {0, 3, 0}}, 100, 100, 200);  // 3 m to the left
  builder.place(builder.addMesh(corner), {}, "corner");
  const Scene scene = builder.finish();
  const TemporaryFolder folder;
  writeBlenderScene(scene, {0, 0, 0}, threadCount(), folder.path());
  BlenderJob job("render", folder.path(), {});
  job.answer();
  job.ask(nlohmann::json{{"scene", folder.path().string()}}.dump());
  job.answer();
  for (const double field : {10, 30, 60, 90, 120, 140, 150}) {
    Camera camera = squareCamera(512, 400, radians(field));
    camera.cx += 17.3 * field / 60;
    camera.cy -= 31.7 * field / 60;
    const auto file = folder.path() / "image.exr";
    job.ask(nlohmann::json{{"file", file.string()},
                           {"width", camera.width},
                           {"height", camera.height},
                           {"fx", camera.fx},
                           {"fy", camera.fy},
                           {"cx", camera.cx},
                           {"cy", camera.cy},
                           {"near", 0.01},
                           {"far", 1000},
                           {"pose", {0, 0, 1, 0, -1, 0, 0, 0, 0, -1, 0, 0}}}
                .dump());
    job.answer();
    const ExrReader reader(file);
    std::vector<float> depth(reader.pixels());
    std::vector<float> triangle(reader.pixels());
    for (const ExrChannel& channel : reader.channels()) {
      EXPECT_EQ(channel.type, ExrType::Float32) << channel.name;
      float* plane = channel.name.ends_with("Depth.Z") ? depth.data() : triangle.data();
      if (!channel.name.ends_with("Depth.Z") && !channel.name.ends_with("ids.B")) continue;
      reader.read(std::vector<ExrTarget>{{&channel, plane, 4}});
    }
    double sum[2] = {0, 0};
    std::size_t count[2] = {0, 0};
    for (std::size_t i = 0; i < reader.pixels(); ++i) {
      const double z = depth[i];
      if (!(z < 40)) continue;
      const double u = static_cast<double>(i % camera.width) + 0.5;
      const double v = static_cast<double>(i / camera.width) + 0.5;
      // z = fy 2 / (v - cy) on the ground and z = fx 3 / (cx - u) on the wall.
      const int wall = triangle[i] < 80000 ? 0 : 1;
      const double offset = wall == 0 ? camera.cy + camera.fy * 2 / z - v : camera.cx - camera.fx * 3 / z - u;
      sum[wall] += offset;
      ++count[wall];
      EXPECT_LT(std::abs(offset), 1e-3) << "field " << field << ", pixel " << u << ", " << v;
    }
    for (const int wall : {0, 1}) {
      ASSERT_GT(count[wall], 1000u) << field;
      EXPECT_LT(std::abs(sum[wall] / static_cast<double>(count[wall])), 1e-4) << "field " << field;
    }
  }
}

// A third-party .blend, read as a scene and drawn by the program that it is for.
TEST(BlenderRenderer, DrawsABlendThatASceneNames) {
  SKIP_WITHOUT_BLENDER();
  SKIP_WITHOUT_SHARED_DATA("scenes/blender");
  const std::filesystem::path source = SCANMILL_SOURCE_DIR;
  const TemporaryFolder folder;
  const auto file = folder.write(
      "scene.yaml", "ontology: " + (source / "labels/scanmill.yaml").string() +
                        "\nmaterials: " + (source / "labels/materials.yaml").string() +
                        "\nobjects:\n  - file: " + (sharedData() / "scenes/blender/mirror.blend").string() +
                        "\n    rules:\n      - {match: {node: Plane2}, class: car}\n"
                        "      - {match: {material: Material}, class: wall}\n"
                        "      - {match: any, class: object}\n");
  const Scene scene = readScene(file, {});
  // As the file's own camera stands.
  const auto images = readAll(
      *makeBlenderRenderer(scene)->draw({uprightCamera({-1, 3, 2}, 20, 0, 200, 120, 80)}, {0.1, 100}, kEverything),
      kEverything);
  const Agreement found = compare(scene, images[0], {0.1, 100});
  EXPECT_EQ(found.differInside, 0u);
  EXPECT_GT(found.seen, 200u);
  EXPECT_LT(found.worstDepth, 1e-5);
  std::set<std::uint16_t> classes(images[0].planes.semantic.begin(), images[0].planes.semantic.end());
  EXPECT_TRUE(classes.contains(8)) << "wall, by its material";
}

TEST(BlenderScene, LargeMeshesComeInParts) {
  const Scene scene = smallScene({0, 0, 0});
  const TemporaryFolder folder;
  const auto whole = writeBlenderScene(scene, {1, 2, 3}, 2, folder.path());
  EXPECT_EQ(whole.size(), scene.instances.size());
  constexpr std::uint32_t kLimit = 7;
  const auto parts = writeBlenderScene(scene, {1, 2, 3}, 2, folder.path(), kLimit);
  std::map<std::uint32_t, std::vector<std::uint32_t>> firsts;
  for (const BlenderObject& part : parts) firsts[part.instance].push_back(part.firstTriangle);
  EXPECT_EQ(firsts.size(), scene.instances.size());
  for (const auto& [instance, first] : firsts) {
    const std::size_t triangles = scene.meshes[scene.instances[instance - 1].mesh].triangles.size();
    ASSERT_EQ(first.size(), (triangles + kLimit - 1) / kLimit);
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i], i * kLimit);
  }
  std::ifstream in(folder.path() / "scene.json");
  const auto index = nlohmann::json::parse(in);
  EXPECT_EQ(index["objects"], parts.size());
  for (const auto& mesh : index["meshes"]) EXPECT_LE(mesh["triangles"]["shape"][0], kLimit);
}

// Stand-ins for Blender: programs that fail in their own ways.
TEST(BlenderRenderer, FailuresQuoteTheProgram) {
  const Scene scene = smallScene({0, 0, 0});
  const TemporaryFolder folder;
  const auto failing = [&](const std::string& script) {
    const auto program = folder.write("blender", "#!/bin/sh\n" + script);
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    const ScopedVariable named("SCANMILL_BLENDER", program.string());
    return messageOf<Error>([&] { makeBlenderRenderer(scene); });
  };
  EXPECT_THAT(failing("echo 'no memory left' >&2; exit 11"),
              testing::AllOf(HasSubstr("exit code 11"), HasSubstr("no memory left")));
  EXPECT_THAT(failing("kill -ABRT $$"), HasSubstr("signal 6"));
  EXPECT_THAT(failing("echo '{\"what\": 5}'; sleep 10"), HasSubstr("not understood"));
  {
    const ScopedVariable patience("SCANMILL_BLENDER_SECONDS", "0.2");
    EXPECT_THAT(failing("echo starting >&2; sleep 1000"),
                testing::AllOf(HasSubstr("0.2 s"), HasSubstr("SCANMILL_BLENDER_SECONDS"), HasSubstr("starting")));
  }
  const ScopedVariable patience("SCANMILL_BLENDER_SECONDS", "soon");
  EXPECT_THAT(failing("exit 0"), HasSubstr("SCANMILL_BLENDER_SECONDS"));
}

TEST(BlenderRenderer, SaysHowToInstallIt) {
  const Scene scene = smallScene({0, 0, 0});
  {
    const ScopedVariable named("SCANMILL_BLENDER", "/no/such/blender");
    EXPECT_THAT(messageOf<Error>([&] { makeBlenderRenderer(scene); }),
                testing::AllOf(HasSubstr("SCANMILL_BLENDER"), HasSubstr("/no/such/blender")));
  }
  const ScopedVariable none("SCANMILL_BLENDER", "");
  const ScopedVariable path("PATH", "/no/such/folder");
  EXPECT_THAT(messageOf<Error>([&] { makeBlenderRenderer(scene); }),
              testing::AllOf(HasSubstr("apt-get install blender"), HasSubstr("SCANMILL_BLENDER")));
}

}  // namespace
}  // namespace scanmill
