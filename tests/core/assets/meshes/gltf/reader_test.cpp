#include "assets/meshes/gltf/reader.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include "base/memory.h"
#include "scene/material.h"
#include "scene/texture.h"
#include "tests/core/assets/meshes/gltf/gltf_builder.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Json = nlohmann::json;

const std::vector<float> kCorners{1, 0, 0, 0, 2, 0, 0, 0, 3};

// One node "wing" with one mesh of one primitive of these attributes.
GltfBuilder wing(GltfBuilder b, const Json& attributes, const Json& more = Json::object()) {
  b.json["scenes"] = {{{"nodes", {0}}}};
  b.json["nodes"] = {{{"name", "wing"}, {"mesh", 0}}};
  Json primitive{{"attributes", attributes}};
  primitive.update(more);
  b.json["meshes"] = {{{"primitives", {primitive}}}};
  return b;
}

GltfBuilder wing() {
  GltfBuilder b;
  const std::size_t positions = b.numbers<float>(kCorners, "VEC3", 3);
  return wing(b, {{"POSITION", positions}});
}

// A wing with texture coordinates, and with one material whose image is this file.
GltfBuilder pictured(const char* image, const Json& material) {
  GltfBuilder b;
  const std::size_t positions = b.numbers<float>(kCorners, "VEC3", 3);
  const std::size_t uvs = b.numbers<float>({0, 0, 1, 0, 0, 1}, "VEC2", 2);
  GltfBuilder w = wing(b, {{"POSITION", positions}, {"TEXCOORD_0", uvs}}, {{"material", 0}});
  w.json["images"] = {{{"uri", image}}};
  w.json["textures"] = {{{"source", 0}}};
  w.json["materials"] = Json::array({material});
  w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  return w;
}

class GltfReader : public testing::Test {
 protected:
  // As the file has it, which is y-up.
  Asset read(GltfBuilder b, AssetOptions options = {}) {
    options.up = 'z';
    return readAsset(folder_.write("a.gltf", b.text()), options);
  }

  std::string refusal(const GltfBuilder& b) {
    return messageOf([&] { read(b); });
  }

  // Returns what reading the file, whose triangle must come in, prints.
  std::string warnings(const GltfBuilder& b);

  TemporaryFolder folder_;
};

void expectWing(const Asset& asset, const Vec3d& moved = {}, double tolerance = 1e-5) {
  const std::vector<Vec3f> found = corners(asset);
  ASSERT_EQ(found.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3f wanted{kCorners[3 * i], kCorners[3 * i + 1], kCorners[3 * i + 2]};
    EXPECT_LT(length(Vec3d(found[i]) - Vec3d(wanted) - moved), tolerance) << i;
  }
}

std::string GltfReader::warnings(const GltfBuilder& b) {
  return printedBy([&] { expectWing(read(b)); });
}

TEST_F(GltfReader, ExtensionsThatAreRequiredAndUnknownAreRefused) {
  GltfBuilder b = wing();
  b.json["extensionsUsed"] = {"ACME_holes"};
  EXPECT_THAT(warnings(b), HasSubstr("a.gltf: left out: 1 unknown 'ACME_holes'\n"));
  b.json["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_unlit", "ACME_holes"};
  EXPECT_THAT(refusal(b), AllOf(HasSubstr("a.gltf"), HasSubstr("ACME_holes"), HasSubstr("export")));
  b.json["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_unlit"};
  expectWing(read(b));
}

TEST_F(GltfReader, SparseAccessorsReplaceSomeElements) {
  for (const bool based : {true, false}) {
    GltfBuilder b;
    const std::vector<float> base = based ? std::vector<float>{9, 9, 9, 0, 2, 0, 8, 8, 8} : std::vector<float>(9, 0.0f);
    const std::size_t positions = b.numbers<float>(base, "VEC3", 3);
    if (!based) b.json["accessors"][positions].erase("bufferView");
    const std::vector<std::uint16_t> which =
        based ? std::vector<std::uint16_t>{0, 2} : std::vector<std::uint16_t>{0, 1, 2};
    const std::vector<float> by = based ? std::vector<float>{1, 0, 0, 0, 0, 3} : kCorners;
    const std::size_t indices = b.view(bytesOf(which));
    const std::size_t values = b.view(bytesOf(by));
    b.json["accessors"][positions]["sparse"] = {{"count", which.size()},
                                                {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                                {"values", {{"bufferView", values}}}};
    GltfBuilder w = wing(b, {{"POSITION", positions}});
    expectWing(read(w));
    w.json["accessors"][positions]["sparse"]["count"] = 5;
    EXPECT_THAT(refusal(w), HasSubstr("sparse"));
    w.json["accessors"][positions]["sparse"]["count"] = which.size();
    w.json["accessors"][positions]["count"] = 2;
    EXPECT_THAT(refusal(w), HasSubstr(based ? "replaces the element 2 of 2" : "sparse"));
  }
}

// Steps of 1/1000 by the node's scale, or of 3/32767 of a unit cube.
TEST_F(GltfReader, QuantisedPositionsAndTextureCoordinates) {
  GltfBuilder b;
  const std::size_t plain = b.numbers<std::int16_t>({1000, 0, 0, 0, 0, 2000, 0, 0, 0, 0, 3000, 0}, "VEC3", 4, 5122);
  b.json["bufferViews"].back()["byteStride"] = 8;
  const std::size_t uvs = b.numbers<std::uint16_t>({0, 0, 65535, 0, 32768, 65535}, "VEC2", 2, 5123, true);
  GltfBuilder w = wing(b, {{"POSITION", plain}, {"TEXCOORD_0", uvs}});
  w.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  w.json["nodes"][0]["scale"] = {1e-3, 1e-3, 1e-3};
  const Asset asset = read(w);
  expectWing(asset);
  ASSERT_EQ(asset.parts[0].uvs.size(), 3u);
  EXPECT_NEAR(asset.parts[0].uvs[1].x, 1, 1e-6);
  EXPECT_NEAR(asset.parts[0].uvs[1].y, 1, 1e-6);
  EXPECT_NEAR(asset.parts[0].uvs[2].x, 0.5, 1e-4);
  EXPECT_NEAR(asset.parts[0].uvs[2].y, 0, 1e-6);

  GltfBuilder n;
  const std::size_t normalized =
      n.numbers<std::int16_t>({10922, 0, 0, 0, 0, 21845, 0, 0, 0, 0, 32767, 0}, "VEC3", 4, 5122, true);
  n.json["bufferViews"].back()["byteStride"] = 8;
  w = wing(n, {{"POSITION", normalized}});
  w.json["nodes"][0]["scale"] = {3, 3, 3};
  expectWing(read(w), {}, 1e-4);
}

// What gltfpack writes: a view whose bytes are elsewhere, compressed, and a buffer that is not there.
std::size_t compressed(GltfBuilder& b, const std::string& bytes, std::size_t stride, std::size_t count,
                       const char* mode, const char* filter = "NONE") {
  const std::size_t held = b.view(bytes);
  const std::size_t offset = b.json["bufferViews"][held]["byteOffset"];
  b.json["buffers"][0] = Json::object();
  b.json["buffers"][1] = {{"byteLength", 1 << 20}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}};
  b.json["bufferViews"].push_back({{"buffer", 1},
                                   {"byteLength", stride * count},
                                   {"extensions",
                                    {{"EXT_meshopt_compression",
                                      {{"buffer", 0},
                                       {"byteOffset", offset},
                                       {"byteLength", bytes.size()},
                                       {"byteStride", stride},
                                       {"count", count},
                                       {"mode", mode},
                                       {"filter", filter}}}}}});
  return b.json["bufferViews"].size() - 1;
}

// Meshoptimizer 0.19 and later ask which numbers share an exponent.
void encodeExponential(std::vector<float>& stored, std::size_t count, const std::vector<float>& points) {
#if MESHOPTIMIZER_VERSION >= 190
  meshopt_encodeFilterExp(stored.data(), count, 12, 15, points.data(), meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(stored.data(), count, 12, 15, points.data());
#endif
}

TEST_F(GltfReader, MeshesThatMeshoptimizerHasCompressed) {
  // A bowl of 40 x 40 squares.
  constexpr std::uint32_t kSide = 41;
  std::vector<float> points;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const auto x = static_cast<float>(i % kSide) / 4;
    const auto y = static_cast<float>(i / kSide) / 4;
    points.insert(points.end(), {x, y, (x * x + y * y) / 8});
    if (i % kSide + 1 == kSide || i / kSide + 1 == kSide) continue;
    indices.insert(indices.end(), {i, i + 1, i + kSide, i + 1, i + kSide + 1, i + kSide});
  }
  const std::size_t count = kSide * kSide;
  GltfBuilder plain;
  const std::size_t p = plain.numbers<float>(points, "VEC3", 3);
  const std::size_t t = plain.numbers<std::uint32_t>(indices, "SCALAR", 1, 5125);
  const Asset wanted = read(wing(plain, {{"POSITION", p}}, {{"indices", t}}));

  for (const bool exponential : {false, true}) {
    std::vector<float> stored = points;
    if (exponential) encodeExponential(stored, count, points);
    std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(count, 12));
    vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), stored.data(), count, 12));
    for (const bool sequence : {false, true}) {
      std::vector<unsigned char> corners(std::max(meshopt_encodeIndexBufferBound(indices.size(), count),
                                                  meshopt_encodeIndexSequenceBound(indices.size(), count)));
      corners.resize(sequence
                         ? meshopt_encodeIndexSequence(corners.data(), corners.size(), indices.data(), indices.size())
                         : meshopt_encodeIndexBuffer(corners.data(), corners.size(), indices.data(), indices.size()));
      GltfBuilder b;
      const std::size_t pv =
          compressed(b, bytesOf(vertices), 12, count, "ATTRIBUTES", exponential ? "EXPONENTIAL" : "NONE");
      const std::size_t tv = compressed(b, bytesOf(corners), 4, indices.size(), sequence ? "INDICES" : "TRIANGLES");
      b.json["accessors"] = {
          {{"bufferView", pv}, {"componentType", 5126}, {"type", "VEC3"}, {"count", count}},
          {{"bufferView", tv}, {"componentType", 5125}, {"type", "SCALAR"}, {"count", indices.size()}}};
      GltfBuilder w = wing(b, {{"POSITION", 0}}, {{"indices", 1}});
      w.json["extensionsRequired"] = {"EXT_meshopt_compression"};
      const Asset found = read(w);
      ASSERT_EQ(found.parts.size(), 1u);
      ASSERT_EQ(found.parts[0].positions.size(), wanted.parts[0].positions.size());
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3d off = Vec3d(found.parts[0].positions[i]) - Vec3d(wanted.parts[0].positions[i]);
        ASSERT_LT(length(off), exponential ? 1e-3 : 1e-12) << i;
      }
      // The codec may turn a triangle, but not over.
      ASSERT_EQ(found.parts[0].triangles.size(), wanted.parts[0].triangles.size());
      for (std::size_t i = 0; i < found.parts[0].triangles.size(); ++i) {
        Triangle a = found.parts[0].triangles[i];
        for (int turn = 0; turn < 3 && a != wanted.parts[0].triangles[i]; ++turn) a = {a[1], a[2], a[0]};
        ASSERT_EQ(a, wanted.parts[0].triangles[i]) << i;
      }
      GltfBuilder damaged = w;
      for (std::size_t i = 0; i < damaged.bytes.size(); i += 3) damaged.bytes[i] = '\x5a';
      EXPECT_THAT(refusal(damaged), HasSubstr("bufferViews["));
      w.json["bufferViews"][pv]["extensions"]["EXT_meshopt_compression"]["count"] = count + 1;
      EXPECT_THAT(refusal(w), HasSubstr("a length that differs"));
      w.json["bufferViews"][pv]["extensions"]["EXT_meshopt_compression"]["count"] = count;
      w.json["bufferViews"][pv]["extensions"]["EXT_meshopt_compression"]["mode"] = "LATER";
      EXPECT_THAT(refusal(w), HasSubstr("'LATER'"));
    }
  }
  GltfBuilder unread = wing();
  const std::size_t colours = compressed(unread, std::string(20, '\xa1'), 4, 3, "ATTRIBUTES", "COLOR");
  unread.json["accessors"].push_back(
      {{"bufferView", colours}, {"componentType", 5121}, {"normalized", true}, {"type", "VEC4"}, {"count", 3}});
  unread.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 1;
  EXPECT_THAT(warnings(unread), HasSubstr("a.gltf: left out: 3 colours of vertices (COLOR_0)"));
}

// 90,000 vertices, more than 16 bits number. The texture coordinates of a point are its place.
TEST_F(GltfReader, MeshesThatDracoHasCompressed) {
  constexpr int kSide = 300;
  constexpr int kFaces = 2 * kSide * kSide;
  draco::TriangleSoupMeshBuilder soup;
  soup.Start(kFaces);
  const int position = soup.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uv = soup.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  for (int i = 0; i < kFaces; ++i) {
    const int x = i / 2 % kSide, y = i / 2 / kSide;
    std::array<std::array<float, 3>, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const int corner = static_cast<int>(k) + i % 2;  // of the square: 0, 1 and 2, or 1, 2 and 3
      const int px = x + corner % 2, py = y + corner / 2;
      p[k] = {static_cast<float>(px), static_cast<float>(py), static_cast<float>((px * py) % 7)};
    }
    const draco::FaceIndex face(static_cast<std::uint32_t>(i));
    soup.SetAttributeValuesForFace(position, face, p[0].data(), p[1].data(), p[2].data());
    soup.SetAttributeValuesForFace(uv, face, p[0].data(), p[1].data(), p[2].data());
  }
  const std::unique_ptr<draco::Mesh> mesh = soup.Finalize();
  draco::ExpertEncoder encoder(*mesh);
  draco::EncoderBuffer encoded;
  ASSERT_TRUE(encoder.EncodeToBuffer(&encoded).ok());

  GltfBuilder b;
  const std::size_t view = b.view(std::string(encoded.data(), encoded.size()));
  b.json["accessors"] = {{{"componentType", 5126}, {"type", "VEC3"}, {"count", mesh->num_points()}},
                         {{"componentType", 5126}, {"type", "VEC2"}, {"count", mesh->num_points()}},
                         {{"componentType", 5125}, {"type", "SCALAR"}, {"count", 3 * kFaces}}};
  const Json draco{
      {"KHR_draco_mesh_compression",
       {{"bufferView", view},
        {"attributes",
         {{"POSITION", mesh->attribute(position)->unique_id()}, {"TEXCOORD_0", mesh->attribute(uv)->unique_id()}}}}}};
  GltfBuilder w = wing(b, {{"POSITION", 0}, {"TEXCOORD_0", 1}}, {{"indices", 2}, {"extensions", draco}});
  w.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const Asset asset = read(w);
  ASSERT_EQ(asset.parts.size(), 1u);
  const AssetPart& part = asset.parts[0];
  ASSERT_EQ(part.triangles.size(), static_cast<std::size_t>(kFaces));
  EXPECT_GT(part.positions.size(), 65536u);
  double area = 0;
  for (const Triangle& t : part.triangles) {
    const auto v = [&](std::size_t k) { return Vec3d(part.positions[t[k]]); };
    area += std::fabs(cross(v(1) - v(0), v(2) - v(0)).z) / 2;
  }
  EXPECT_NEAR(area, kSide * kSide, 1e-3) << "seen from above";
  for (std::size_t i = 0; i < part.positions.size(); i += 997) {
    const Vec3f p = part.positions[i];
    EXPECT_EQ(part.uvs[i], (Vec2f{p.x, 1 - p.y}));
    EXPECT_EQ(p.z, static_cast<float>(static_cast<int>(p.x * p.y) % 7));
  }

  GltfBuilder damaged = w;
  for (std::size_t i = 40; i < 400; ++i) damaged.bytes[i] = static_cast<char>(7 * i);
  EXPECT_THAT(refusal(damaged), AllOf(HasSubstr("a.gltf"), HasSubstr("damaged")));
  w.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 77;
  EXPECT_THAT(refusal(w), HasSubstr("77"));
}

TEST_F(GltfReader, StripsAndFansTurnAsTheSpecificationSays) {
  GltfBuilder b;
  const std::size_t positions = b.numbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, "VEC3", 3);
  for (const int mode : {5, 6}) {
    GltfBuilder w = wing(b, {{"POSITION", positions}}, {{"mode", mode}});
    const Asset asset = read(w);
    ASSERT_EQ(asset.parts.size(), 1u);
    const AssetPart& part = asset.parts[0];
    EXPECT_EQ(part.triangles.size(), 3u);
    for (const Triangle& t : part.triangles) {
      const auto v = [&](std::size_t k) { return Vec3d(part.positions[t[k]]); };
      const double z = cross(v(1) - v(0), v(2) - v(0)).z;
      if (mode == 5) {
        EXPECT_GT(z, 0.5) << "all look the same way";
      } else {
        EXPECT_EQ(part.positions[t[2]].x + part.positions[t[2]].y, 0) << "all share the first vertex";
      }
    }
  }
}

// A quarter turn counter-clockwise, as one sees it, takes what is right to what is above; v counts down in the file and
// up in the asset.
TEST_F(GltfReader, TextureCoordinatesAreTransformed) {
  GltfBuilder b;
  const std::size_t positions = b.numbers<float>(kCorners, "VEC3", 3);
  const std::size_t zero = b.numbers<float>({0, 0, 0, 0, 0, 0}, "VEC2", 2);
  const std::size_t uvs = b.numbers<float>({0, 0, 1, 0, 0, 1}, "VEC2", 2);
  GltfBuilder w = wing(b, {{"POSITION", positions}, {"TEXCOORD_0", zero}, {"TEXCOORD_1", uvs}}, {{"material", 0}});
  writeColours(folder_.path() / "colours.png");
  w.json["images"] = {{{"uri", "colours.png"}}};
  w.json["textures"] = {{{"source", 0}}};
  w.json["materials"] = {
      {{"pbrMetallicRoughness",
        {{"baseColorTexture",
          {{"index", 0},
           {"texCoord", 0},
           {"extensions",
            {{"KHR_texture_transform",
              {{"offset", {0.25, 0.5}}, {"rotation", kPi / 2}, {"scale", {0.5, 0.25}}, {"texCoord", 1}}}}}}}}}}};
  const Asset asset = read(w);
  const std::vector<Vec2f>& found = asset.parts.at(0).uvs;
  ASSERT_EQ(found.size(), 3u);
  const std::vector<Vec2d> wanted{{0.25, 0.5}, {0.25, 0.5 + 0.5}, {0.25 + 0.25, 0.5}};  // up
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(found[i].x, wanted[i].x, 1e-6) << i;
    EXPECT_NEAR(found[i].y, wanted[i].y, 1e-6) << i;
  }
}

TEST_F(GltfReader, WhatIsHiddenIsLeftOutWithWhatIsBelowIt) {
  GltfBuilder b = wing();
  b.json["nodes"] = {
      {{"name", "shown"}, {"mesh", 0}, {"translation", {5, 0, 0}}},
      {{"name", "hidden"}, {"children", {2}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}},
      {{"name", "below"}, {"mesh", 0}}};
  b.json["scenes"][0]["nodes"] = {0, 1};
  Asset asset;
  EXPECT_THAT(printedBy([&] { asset = read(b); }), HasSubstr("a.gltf: left out: 1 hidden nodes\n"));
  EXPECT_EQ(asset.parts.at(0).node, "shown");
  expectWing(asset, {5, 0, 0});
}

// Each place is translation, rotation and scale on top of the node's own.
TEST_F(GltfReader, InstancesShareTheirMesh) {
  GltfBuilder b = wing();
  const std::size_t translations = b.numbers<float>({0, 0, 0, 10, 0, 0, 0, 20, 0, 0, 0, 9}, "VEC3", 3);
  const float half = std::sqrt(0.5f);
  const std::size_t rotations = b.numbers<float>({0, 0, 0, 1, 0, 0, half, half, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC4", 4);
  const std::size_t scales = b.numbers<float>({1, 1, 1, 1, 1, 1, 2, 2, 2, 0, 0, 0}, "VEC3", 3);
  b.json["nodes"][0]["translation"] = {100, 0, 0};
  b.json["nodes"][0]["extensions"] = {
      {"EXT_mesh_gpu_instancing",
       {{"attributes", {{"TRANSLATION", translations}, {"ROTATION", rotations}, {"SCALE", scales}}}}}};
  for (const char up : {'y', 'z'}) {
    const Asset asset = readAsset(folder_.write("a.gltf", b.text()), {.metresPerUnit = 0.5, .up = up});
    EXPECT_TRUE(asset.parts.empty());
    ASSERT_EQ(asset.instanced.size(), 1u);
    const InstancedParts& shared = asset.instanced[0];
    ASSERT_EQ(shared.parts.size(), 1u);
    EXPECT_EQ(shared.parts[0].node, "wing");
    ASSERT_EQ(shared.assetFromParts.size(), 3u) << "what has no size is left out";
    const auto inAsset = [&](Vec3d p) {
      p = p * 0.5;
      return up == 'z' ? p : Vec3d{p.x, -p.z, p.y};
    };
    const std::array<Vec3d, 3> second{Vec3d{110, 1, 0}, {108, 0, 0}, {110, 0, 3}};
    const std::array<Vec3d, 3> third{Vec3d{102, 20, 0}, {100, 24, 0}, {100, 20, 6}};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d corner(shared.parts[0].positions[shared.parts[0].triangles[0][k]]);
      const Vec3d own{kCorners[3 * k], kCorners[3 * k + 1], kCorners[3 * k + 2]};
      EXPECT_LT(length(shared.assetFromParts[0] * corner - inAsset(own + Vec3d{100, 0, 0})), 1e-4);
      EXPECT_LT(length(shared.assetFromParts[1] * corner - inAsset(second[k])), 1e-4);
      EXPECT_LT(length(shared.assetFromParts[2] * corner - inAsset(third[k])), 1e-4);
    }
  }
  b.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = 0;
  EXPECT_THAT(refusal(b), HasSubstr("EXT_mesh_gpu_instancing"));
}

// Each of these few bytes once took a process down, or gigabytes.
TEST_F(GltfReader, SmallFilesAskForLittle) {
  std::string deep = wing().text();
  const std::string kind = "\"componentType\":5126";
  deep.replace(deep.find(kind), kind.size(),
               "\"componentType\":" + std::string(200000, '[') + std::string(200000, ']'));
  EXPECT_THAT(messageOf([&] { readAsset(folder_.write("a.gltf", deep), {}); }), HasSubstr("unknown type"));

  GltfBuilder many = wing();
  many.json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", std::uint64_t{1} << 31}});
  many.json["nodes"][0]["extensions"] = {{"EXT_mesh_gpu_instancing", {{"attributes", {{"_X", 1}}}}}};
  EXPECT_THAT(refusal(many), HasSubstr("no triangle"));
  many.json["nodes"][0]["extensions"] = {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", 1}}}}}};
  EXPECT_THAT(refusal(many), HasSubstr("without data"));

  GltfBuilder absent = wing();
  absent.json["buffers"][0] = Json::object();
  absent.json["buffers"][1] = {{"byteLength", std::uint64_t{1} << 40}};
  absent.json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", std::uint64_t{12} << 30}});
  absent.json["accessors"].push_back(
      {{"bufferView", 1}, {"componentType", 5126}, {"type", "VEC3"}, {"count", std::uint64_t{1} << 27}});
  absent.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 1;
  EXPECT_THAT(refusal(absent), HasSubstr("truncated"));
  absent.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 0;
  expectWing(read(absent));  // what nobody reads may be missing

  GltfBuilder beyond = wing();
  beyond.json["accessors"][0]["count"] = 0;
  beyond.json["accessors"][0]["byteOffset"] = 1000;
  EXPECT_THAT(refusal(beyond), HasSubstr("beyond its bufferView"));

  GltfBuilder zeroes = wing();
  zeroes.json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 3000}});
  zeroes.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 1;
  const MemoryLimit little(10'000);
  EXPECT_THAT(refusal(zeroes), HasSubstr("more than the memory: split it"));
}

TEST_F(GltfReader, WithoutAScene) {
  GltfBuilder b = wing();
  b.json["nodes"] = {{{"children", {1}}}, {{"name", "wing"}, {"mesh", 0}}};
  b.json.erase("scene");
  b.json.erase("scenes");
  EXPECT_EQ(warnings(b), "");
  b.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {2}}}};
  b.json["nodes"].push_back({{"name", "elsewhere"}, {"mesh", 0}});
  EXPECT_THAT(warnings(b), HasSubstr("a.gltf: left out: 1 nodes outside of the scene\n"));
  b.json["extensionsUsed"] = {"MSFT_lod"};
  EXPECT_THAT(warnings(b), HasSubstr("1 levels of detail (MSFT_lod"));
}

TEST_F(GltfReader, ANodeWithoutANameIsNamedByAnAncestorOrItsMesh) {
  GltfBuilder b = wing();
  b.json["meshes"][0]["name"] = "mesh";
  EXPECT_EQ(read(b).parts.at(0).node, "wing");
  b.json["nodes"][0].erase("name");
  EXPECT_EQ(read(b).parts.at(0).node, "mesh");
  b.json["nodes"].push_back({{"name", "above"}, {"children", {0}}});
  b.json["scenes"] = {{{"nodes", {1}}}};
  EXPECT_EQ(read(b).parts.at(0).node, "above");
}

// Values with names of their own may be labels, such as _BATCHID, or looks.
TEST_F(GltfReader, WhatIsLeftOutIsCountedInOneWarning) {
  GltfBuilder w =
      pictured("colours.png", {{"alphaMode", "BLEND"},
                               {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}},
                               {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.25}}}}});
  writeColours(folder_.path() / "colours.png");
  w.json["samplers"] = {{{"wrapS", 33071}}};
  w.json["textures"][0]["sampler"] = 0;
  Json& attributes = w.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_0"] = w.numbers<float>({0, 0, 2, 0, 0, 2}, "VEC2", 2);
  attributes["_BATCHID"] = w.numbers<float>({1, 2, 3}, "SCALAR", 1);
  attributes["NORMAL"] = attributes["COLOR_0"] = 0;
  for (const int mode : {0, 1, 3}) {
    w.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
  }
  w.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", w.numbers<float>({0, 0, 0}, "VEC3", 3)}, {"_FEATURE_ID_0", w.numbers<float>({7}, "SCALAR", 1)}};
  w.json["extensionsUsed"] = {"EXT_instance_features"};
  EXPECT_THAT(warnings(w),
              HasSubstr("a.gltf: left out: 1 clamped or mirrored textures (they repeat), 3 colours of vertices "
                        "(COLOR_0), 1 opacities of materials (they are solid), 2 primitives of lines, 1 primitives of "
                        "points, 1 transmissions of materials (they are solid), 1 unknown 'EXT_instance_features', 1 "
                        "values of instances (_FEATURE_ID_0), 3 values of vertices (_BATCHID)\n"));
}

TEST_F(GltfReader, MaterialsWithoutTrianglesAreNotToldAndEmissiveImagesAre) {
  GltfBuilder w = wing();
  w.json["images"] = {{{"uri", "colours.png"}}};
  w.json["textures"] = {{{"source", 0}}};
  const Json black{{"emissiveTexture", {{"index", 0}}}, {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}};
  const Json glass{{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.5}}}}};
  w.json["materials"] = {black, glass};
  EXPECT_EQ(warnings(w), "");
  w.json["nodes"].push_back({{"mesh", 0}, {"translation", {1e6, 0, 0}}});
  w.json["scenes"][0]["nodes"] = {0, 1};
  const auto told = [&](int material) {
    w.json["meshes"][0]["primitives"][0]["material"] = material;
    return printedBy([&] { read(w); });
  };
  EXPECT_THAT(told(0), HasSubstr("left out: 1 emissive images of materials with a black base colour\n"));
  EXPECT_THAT(told(1), HasSubstr("left out: 1 opacities of materials (they are solid)\n"));
}

// Primitives without texture coordinates are a part of their own, so that no texture shows on them.
TEST_F(GltfReader, PrimitivesWithoutTextureCoordinatesAreAPartOfTheirOwn) {
  GltfBuilder w = pictured("colours.png", Json::object());
  w.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"material", 0}});
  writeColours(folder_.path() / "colours.png");
  Asset asset;
  EXPECT_THAT(printedBy([&] { asset = readAsset(folder_.write("mixed.gltf", w.text()), {}); }),
              HasSubstr("mixed.gltf: left out: 1 textures of parts without texture coordinates\n"));
  ASSERT_EQ(asset.parts.size(), 2u);
  EXPECT_EQ(asset.parts[0].nodeIndex, asset.parts[1].nodeIndex);
  EXPECT_TRUE(asset.parts[0].fileMaterial.textured);
  EXPECT_FALSE(asset.parts[1].fileMaterial.textured);
  EXPECT_NEAR(asset.parts[1].fileMaterial.reflectance, kColoursMean, 1e-5);
  w.json["materials"][0]["pbrMetallicRoughness"].erase("baseColorTexture");
  EXPECT_EQ(read(w).parts.size(), 1u) << "without an image they are one part";
}

// glTF 2.0, 3.9.2: the factor multiplies each channel. The image is red, green, blue and white.
TEST_F(GltfReader, ColouredFactorsMultiplyTheChannelsOfImages) {
  writeColours(folder_.path() / "colours.png");
  const GltfBuilder w = pictured("colours.png", {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 0, 1}}}}});
  const AssetPart part = read(w).parts.at(0);
  const Material& m = part.fileMaterial;
  EXPECT_NEAR(m.reflectance, (0.2126 * 0.5 + 0.7152 * 0.25) / 2, 1e-3);
  // Returns the reflectance that a beam sees: that of the material times the texel's share of the mean.
  const auto seen = [&](float u, float v) { return m.reflectance * luminance(m.texture->texel(u, v)) / m.textureMean; };
  EXPECT_NEAR(seen(0.25f, 0.75f), 0.2126 * 0.5, 2e-3) << "red";
  EXPECT_NEAR(seen(0.75f, 0.75f), 0.7152 * 0.25, 2e-3) << "green";
  EXPECT_NEAR(seen(0.25f, 0.25f), 0, 2e-3) << "blue";
  EXPECT_EQ(part.color, (std::array<float, 3>{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(read(w, {.textures = false}).parts.at(0).color, (std::array<float, 3>{0.5f, 0.25f, 0}));
}

TEST_F(GltfReader, ImagesThatFadeAreCountedAndAFactorOfZeroMasksAll) {
  GltfBuilder w = pictured("fade.png", {{"alphaMode", "BLEND"}});
  writeColours(folder_.path() / "fade.png", 100);
  EXPECT_EQ(warnings(w), "") << "a quarter";
  auto output = OIIO::ImageOutput::create("fade.png");
  OIIO::ImageSpec spec(2, 2, 4, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  ASSERT_TRUE(output->open((folder_.path() / "fade.png").string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, std::string(16, 77).data()));
  ASSERT_TRUE(output->close());
  EXPECT_THAT(warnings(w), HasSubstr("left out: 1 images that fade (beams pass where alpha is below 0.5)\n"));
  w.json["materials"][0]["alphaMode"] = "MASK";
  w.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0};
  EXPECT_GT(read(w).parts.at(0).fileMaterial.alphaCutoff, 1);
  w.json["materials"][0]["alphaCutoff"] = 0;
  EXPECT_EQ(read(w).parts.at(0).fileMaterial.alphaCutoff, 0);
}

// Primitives often share one list of vertices, of which each needs some.
TEST_F(GltfReader, VerticesOfOtherPrimitivesAreLeftOut) {
  GltfBuilder b;
  std::vector<float> points(3000, -99.0f);
  std::copy(kCorners.begin(), kCorners.end(), points.begin() + 300);
  const std::size_t positions = b.numbers<float>(points, "VEC3", 3);
  const std::size_t indices = b.numbers<std::uint16_t>({100, 101, 102}, "SCALAR", 1, 5123);
  const Asset asset = read(wing(b, {{"POSITION", positions}}, {{"indices", indices}}));
  expectWing(asset);
  EXPECT_EQ(asset.parts[0].positions.size(), 3u);
}

TEST_F(GltfReader, MaterialsOfTheOldExtensionAreNoMetals) {
  GltfBuilder b = wing();
  b.json["meshes"][0]["primitives"][0]["material"] = 0;
  b.json["materials"] = {{{"name", "old"},
                          {"extensions",
                           {{"KHR_materials_pbrSpecularGlossiness",
                             {{"diffuseFactor", {0.5, 0.5, 0.5, 1}}, {"glossinessFactor", 0.25}}}}}}};
  const Material m = read(b).parts.at(0).fileMaterial;
  EXPECT_FLOAT_EQ(m.reflectance, 0.5f);
  EXPECT_FLOAT_EQ(m.metallic, 0);
  EXPECT_FLOAT_EQ(m.roughness, 0.75f);
}

}  // namespace
}  // namespace scanmill
