#include "scene/assets/asset.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "scene/assets/asset_alpha.h"
#include "scene/assets/asset_look.h"
#include "scene/assets/gltf.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// One triangle whose corners tell the axes apart, in every kind of file: (1,0,0), (0,2,0), (0,0,3).
constexpr const char* kObj = R"(mtllib a.mtl
o wing
v 1 0 0
v 0 2 0
v 0 0 3
vt 0.25 0.25
vt 0.75 0.25
vt 0.25 0.75
usemtl paint
f 1/1 2/2 3/3
)";
constexpr const char* kMtl = "newmtl paint\nKd 0.5 0.5 0.5\nmap_Kd colours.png\n";

constexpr const char* kPly = R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
1 0 0
0 2 0
0 0 3
3 0 1 2
)";

constexpr const char* kStl = R"(solid wing
facet normal 0 0 1
outer loop
vertex 1 0 0
vertex 0 2 0
vertex 0 0 3
endloop
endfacet
endsolid wing
)";

constexpr const char* kAc = R"(AC3Db
MATERIAL "paint" rgb 0.5 0.5 0.5 amb 0.2 0.2 0.2 emis 0 0 0 spec 0.5 0.5 0.5 shi 10 trans 0
OBJECT world
kids 1
OBJECT poly
name "wing"
texture "colours.png"
numvert 3
1 0 0
0 2 0
0 0 3
numsurf 1
SURF 0x20
mat 0
refs 3
0 0.25 0.25
1 0.75 0.25
2 0.25 0.75
kids 0
)";

std::string dae(const std::string& up, const std::string& unit) {
  return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="unit" meter=")" +
         unit + R"("/><up_axis>)" + up + R"(</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>
<source id="p"><float_array id="pa" count="9">1 0 0 0 2 0 0 0 3</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s" name="s">
<node id="n" name="wing"><translate>10 20 30</translate><node><instance_geometry url="#g"/></node></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
)";
}

std::string fbx(int upAxis, double centimetres) {
  return R"(; FBX 7.4.0 project file
FBXHeaderExtension:  {
	FBXHeaderVersion: 1003
	FBXVersion: 7400
}
GlobalSettings:  {
	Version: 1000
	Properties70:  {
		P: "UpAxis", "int", "Integer", "",)" +
         std::to_string(upAxis) + R"(
		P: "UnitScaleFactor", "double", "Number", "",)" +
         std::to_string(centimetres) + R"(
	}
}
Objects:  {
	Geometry: 1, "Geometry::tri", "Mesh" {
		Vertices: *9 {
			a: 1,0,0,0,2,0,0,0,3
		}
		PolygonVertexIndex: *3 {
			a: 0,1,-3
		}
	}
	Model: 2, "Model::wing", "Mesh" {
	}
}
Connections:  {
	C: "OO",2,0
	C: "OO",1,2
}
)";
}

std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      word = word << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : kDigits[word >> (18 - 6 * k) & 63];
  }
  return out;
}

template <class T>
std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Positions, texture coordinates (v down, as glTF has it) and indices of the triangle: 36 + 24 + 12 bytes.
std::string gltfBuffer(const std::vector<std::uint32_t>& indices = {0, 1, 2}) {
  return bytesOf<float>({1, 0, 0, 0, 2, 0, 0, 0, 3}) + bytesOf<float>({0.25f, 0.75f, 0.75f, 0.75f, 0.25f, 0.25f}) +
         bytesOf(indices);
}

struct Gltf {
  std::string buffer = R"("uri":"data:application/octet-stream;base64,)" + base64(gltfBuffer()) + "\"";
  std::string nodes = R"([{"name":"wing","mesh":0}])";
  std::string roots = "[0]";
  std::string material = R"({"name":"paint","pbrMetallicRoughness":{"metallicFactor":0}})";
  std::string extra;  // such as "textures" and "images"

  std::string text() const {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":)" + roots + R"(}],"nodes":)" + nodes +
           R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]}],)" +
           R"("materials":[)" + material + R"(],"buffers":[{"byteLength":72,)" + buffer + R"(}],"bufferViews":[)" +
           R"({"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},)" +
           R"({"buffer":0,"byteOffset":60,"byteLength":12}],"accessors":[)" +
           R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,2,3]},)" +
           R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},)" +
           R"({"bufferView":2,"componentType":5125,"count":3,"type":"SCALAR"}])" + extra + "}";
  }
};

std::string glb(std::string text, const std::string& binary) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto words = [](std::initializer_list<std::size_t> values) {
    std::vector<std::uint32_t> out;
    for (const std::size_t value : values) out.push_back(static_cast<std::uint32_t>(value));
    return bytesOf(out);
  };
  return words({0x46546C67, 2, 28 + text.size() + binary.size(), text.size(), 0x4E4F534A}) + text +
         words({binary.size(), 0x004E4942}) + binary;
}

std::string glbOfTriangle() {
  Gltf gltf;
  gltf.buffer = R"("name":"b")";
  return glb(gltf.text(), gltfBuffer());
}

// The corners of the only triangle.
std::vector<Vec3f> corners(const Asset& asset) {
  EXPECT_EQ(asset.parts.size(), 1u);
  EXPECT_EQ(asset.parts.at(0).triangles.size(), 1u);
  std::vector<Vec3f> out;
  for (const std::uint32_t i : asset.parts.at(0).triangles.at(0)) out.push_back(asset.parts[0].positions.at(i));
  return out;
}

void expectCorners(const Asset& asset, const std::vector<Vec3f>& expected, const std::string& what) {
  std::vector<Vec3f> found = corners(asset);
  ASSERT_EQ(found.size(), 3u) << what;
  const auto near = [](const Vec3f& a, const Vec3f& b) { return length(a - b) < 1e-5f; };
  // Any corner may come first, but their order round the triangle is kept.
  for (int turn = 0; turn < 3; ++turn) {
    if (near(found[0], expected[0])) break;
    std::rotate(found.begin(), found.begin() + 1, found.end());
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(near(found[i], expected[i]))
        << what << ": corner " << i << " is " << found[i].x << ' ' << found[i].y << ' ' << found[i].z;
  }
}

std::string failure(const std::filesystem::path& file, const AssetOptions& options = {}) {
  try {
    readAsset(file, options);
  } catch (const InputError& e) {
    return e.what();
  }
  ADD_FAILURE() << file << " was read";
  return {};
}

// 64 x 64 texels: the top half red and green, the bottom half blue (with an alpha) and white.
void writeColours(const std::filesystem::path& path, std::uint8_t blueAlpha = 255) {
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < 64; ++row) {
    for (int column = 0; column < 64; ++column) {
      const bool top = row < 32;
      const bool left = column < 32;
      const auto value = [](bool on) { return static_cast<std::uint8_t>(on ? 255 : 0); };
      pixels.insert(pixels.end(), {value(top == left ? top || !left : false), value(!left), value(!top),
                                   top || !left ? std::uint8_t{255} : blueAlpha});
    }
  }
  auto output = OIIO::ImageOutput::create(path.string());
  OIIO::ImageSpec spec(64, 64, 4, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  ASSERT_TRUE(output && output->open(path.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  ASSERT_TRUE(output->close());
}

const double kColoursMean = (0.2126 + 0.7152 + 0.0722 + 1) / 4;

// Corner 0 lies at (u, v) = (0.25, 0.25), the image's bottom left: blue; 1 is white, 2 is red.
void expectColours(const AssetPart& part, const std::string& what) {
  ASSERT_TRUE(part.look.texture) << what;
  ASSERT_EQ(part.uvs.size(), part.positions.size()) << what;
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    const std::uint8_t* rgb = part.look.texture->texel(part.uvs[i].x, part.uvs[i].y);
    const std::vector<int> found{(rgb[0] + 32) / 64, (rgb[1] + 32) / 64, (rgb[2] + 32) / 64};  // WebP loses a little
    const Vec3f p = part.positions[i];
    if (p.x > 0) {
      EXPECT_EQ(found, (std::vector<int>{0, 0, 4})) << what;
    } else {
      EXPECT_EQ(found, p.y > 0 ? (std::vector<int>{4, 4, 4}) : (std::vector<int>{4, 0, 0})) << what;
    }
  }
}

class AssetFiles : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, std::string_view text) { return folder_.write(name, text); }
  Asset read(const std::string& name, std::string_view text, const AssetOptions& options = {}) {
    return readAsset(write(name, text), options);
  }
  TemporaryFolder folder_;
};

TEST_F(AssetFiles, EveryKindGivesTheSameTriangle) {
  write("a.mtl", kMtl);
  writeColours(folder_.path() / "colours.png");
  const std::vector<std::pair<std::string, std::string>> files{{"a.obj", kObj},           {"a.ply", kPly},
                                                               {"a.stl", kStl},           {"a.ac", kAc},
                                                               {"a.gltf", Gltf().text()}, {"a.glb", glbOfTriangle()}};
  for (const auto& [name, text] : files) {
    const std::vector<Vec3f> asWritten{{1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
    const std::vector<Vec3f> fromYUp{{1, 0, 0}, {0, 0, 2}, {0, -3, 0}};
    const bool yUp = name == "a.gltf" || name == "a.glb" || name == "a.ac";
    expectCorners(read(name, text), yUp ? fromYUp : asWritten, name);
    EXPECT_EQ(read(name, text).up, yUp ? 'y' : 'z') << name;
    EXPECT_EQ(read(name, text, {.up = 'x'}).up, 'x') << name;
    expectCorners(read(name, text, {.up = 'z'}), asWritten, name);
    expectCorners(read(name, text, {.metresPerUnit = 0.5, .up = 'z'}), {{0.5f, 0, 0}, {0, 1, 0}, {0, 0, 1.5f}}, name);
    expectCorners(read(name, text, {.up = 'y'}), fromYUp, name);
    expectCorners(read(name, text, {.up = 'x'}), {{0, 0, 1}, {-2, 0, 0}, {0, -3, 0}}, name);
  }
}

TEST_F(AssetFiles, ColladaDeclaresItsUnitAndUpAxis) {
  const auto at = [](float x, float y, float z) {
    return std::vector<Vec3f>{{x + 1, y, z}, {x, y + 2, z}, {x, y, z + 3}};
  };
  expectCorners(read("z.dae", dae("Z_UP", "1")), at(10, 20, 30), "Z_UP");
  expectCorners(read("y.dae", dae("Y_UP", "1")), {{11, -30, 20}, {10, -30, 22}, {10, -33, 20}}, "Y_UP");
  expectCorners(read("x.dae", dae("X_UP", "1")), {{-20, -30, 11}, {-22, -30, 10}, {-20, -33, 10}}, "X_UP");
  expectCorners(read("inch.dae", dae("Z_UP", "0.5")), {{5.5f, 10, 15}, {5, 11, 15}, {5, 10, 16.5f}}, "unit");
  expectCorners(read("scaled.dae", dae("Z_UP", "0.5"), {.metresPerUnit = 2}), at(10, 20, 30), "a scale on top");
  const std::vector<Vec3f> turned{{11, -30, 20}, {10, -30, 22}, {10, -33, 20}};
  expectCorners(read("z.dae", dae("Z_UP", "1"), {.up = 'y'}), turned, "replaced");
  expectCorners(read("y.dae", dae("Y_UP", "1"), {.up = 'y'}), turned, "confirmed");
  for (const char* declared : {"X_UP", "Y_UP", "Z_UP"}) {
    expectCorners(read("any.dae", dae(declared, "1"), {.up = 'z'}), at(10, 20, 30), declared);
    expectCorners(read("any.dae", dae(declared, "1"), {.up = 'x'}), {{-20, -30, 11}, {-22, -30, 10}, {-20, -33, 10}},
                  declared);
  }
  const std::string silent = std::regex_replace(dae("Z_UP", "1"), std::regex("<up_axis>.*</up_axis>"), "");
  expectCorners(read("silent.dae", silent), turned, "COLLADA's default");
  EXPECT_EQ(read("x.dae", dae("X_UP", "1")).up, 'x');
  EXPECT_EQ(read("y.dae", dae("Y_UP", "1")).up, 'y');
  EXPECT_EQ(read("z.dae", dae("Z_UP", "1")).up, 'z');
  EXPECT_EQ(read("z.dae", dae("Z_UP", "1"), {.up = 'y'}).up, 'y');
  EXPECT_EQ(read("silent.dae", silent).up, 'y');
}

TEST_F(AssetFiles, FbxDeclaresItsUnitAndUpAxis) {
  expectCorners(read("z.fbx", fbx(2, 100)), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, "z up, metres");
  expectCorners(read("y.fbx", fbx(1, 100)), {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}}, "y up");
  expectCorners(read("cm.fbx", fbx(2, 1)), {{0.01f, 0, 0}, {0, 0.02f, 0}, {0, 0, 0.03f}}, "centimetres");
  expectCorners(read("x.fbx", fbx(0, 100)), {{0, 0, 1}, {-2, 0, 0}, {0, -3, 0}}, "x up");
  EXPECT_EQ(read("x.fbx", fbx(0, 100)).up, 'x');
  EXPECT_EQ(read("z.fbx", fbx(2, 100)).up, 'z');
  expectCorners(read("z.fbx", fbx(2, 100), {.up = 'y'}), {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}}, "replaced");
  expectCorners(read("y.fbx", fbx(1, 100), {.up = 'z'}), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, "replaced");
}

// The importer turns these kinds to y-up.
TEST_F(AssetFiles, KindsThatAreZUpStandUpright) {
  const std::string dxf =
      "0\nSECTION\n2\nENTITIES\n0\n3DFACE\n8\n0\n10\n1\n20\n0\n30\n0\n11\n0\n21\n2\n31\n0\n"
      "12\n0\n22\n0\n32\n3\n13\n0\n23\n0\n33\n3\n0\nENDSEC\n0\nEOF\n";
  const auto chunk = [](std::uint16_t id, const std::string& content) {
    return bytesOf<std::uint16_t>({id}) + bytesOf<std::uint32_t>({static_cast<std::uint32_t>(6 + content.size())}) +
           content;
  };
  const std::string vertices = chunk(0x4110, bytesOf<std::uint16_t>({3}) + bytesOf<float>({1, 0, 0, 0, 2, 0, 0, 0, 3}));
  const std::string faces = chunk(0x4120, bytesOf<std::uint16_t>({1, 0, 1, 2, 7}));
  const std::string object = std::string("wing") + '\0' + chunk(0x4100, vertices + faces);
  const std::string studio = chunk(0x4D4D, chunk(0x3D3D, chunk(0x4000, object)));
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{{"a.dxf", dxf}, {"a.3ds", studio}}) {
    expectCorners(read(name, text), {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, name);
    expectCorners(read(name, text, {.up = 'y'}), {{1, 0, 0}, {0, 0, 2}, {0, -3, 0}}, name);
  }
}

TEST_F(AssetFiles, NamesAreTheFiles) {
  write("a.mtl", kMtl);
  writeColours(folder_.path() / "colours.png");
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{{"a.obj", kObj},
                                                                                   {"a.stl", kStl},
                                                                                   {"a.ac", kAc},
                                                                                   {"a.gltf", Gltf().text()},
                                                                                   {"a.dae", dae("Z_UP", "1")},
                                                                                   {"a.fbx", fbx(2, 100)}}) {
    EXPECT_EQ(read(name, text).parts.at(0).node, "wing") << name;
  }
  EXPECT_EQ(read("a.obj", kObj).parts.at(0).material, "paint");
  EXPECT_EQ(read("a.gltf", Gltf().text()).parts.at(0).material, "paint");
  EXPECT_EQ(read("a.ply", kPly).parts.at(0).material, "");
  EXPECT_EQ(read("a.ply", kPly).parts.at(0).node, "");
  Gltf unnamed;
  unnamed.nodes = R"([{"mesh":0}])";
  EXPECT_EQ(read("unnamed.gltf", unnamed.text()).parts.at(0).node, "");
}

TEST_F(AssetFiles, TransformsOfNodesAreAppliedInDoublePrecisionAndMirroringKeepsTheOutside) {
  Gltf gltf;
  gltf.nodes = R"([{"name":"far","translation":[1e7,0,0],"children":[1]},
                   {"name":"back","translation":[-1e7,0.25,0],"children":[2]},
                   {"name":"wing","scale":[-1,1,1],"mesh":0}])";
  const Asset asset = read("a.gltf", gltf.text());
  EXPECT_EQ(asset.parts.at(0).nodeIndex, 2u);
  expectCorners(asset, {{-1, 0, 0.25f}, {0, -3, 0.25f}, {0, 0, 2.25f}}, "mirrored");
}

TEST_F(AssetFiles, EveryPlacementOfAMeshIsAPart) {
  Gltf gltf;
  gltf.nodes = R"([{"name":"a","mesh":0},{"name":"empty"},{"name":"b","mesh":0,"translation":[0,0,5]}])";
  gltf.roots = "[0,1,2]";
  const Asset asset = read("a.gltf", gltf.text());
  ASSERT_EQ(asset.parts.size(), 2u);
  EXPECT_EQ(asset.parts[0].node, "a");
  EXPECT_EQ(asset.parts[1].node, "b");
  EXPECT_LT(asset.parts[0].nodeIndex, asset.parts[1].nodeIndex);
  EXPECT_EQ(asset.parts[1].positions[0].y - asset.parts[0].positions[0].y, -5);
}

TEST_F(AssetFiles, TexturesAreUprightInEveryKind) {
  write("a.mtl", kMtl);
  writeColours(folder_.path() / "colours.png");
  Gltf gltf;
  gltf.material = R"({"name":"paint","pbrMetallicRoughness":{"baseColorTexture":{"index":0},
                      "baseColorFactor":[0.5,0.5,0.5,1],"roughnessFactor":0.25,"metallicFactor":1}})";
  gltf.extra = R"(,"textures":[{"source":0}],"images":[{"uri":"colours.png"}])";
  for (const auto& [name, text] :
       std::vector<std::pair<std::string, std::string>>{{"a.obj", kObj}, {"a.ac", kAc}, {"a.gltf", gltf.text()}}) {
    const Asset asset = read(name, text, {.up = 'z'});
    const AssetPart& part = asset.parts.at(0);
    expectColours(part, name);
    EXPECT_EQ(part.texture, "colours.png") << name;
    EXPECT_TRUE(part.look.textured);
    EXPECT_FALSE(part.look.alphaTested);
    EXPECT_NEAR(part.look.textureMean, kColoursMean, 1e-5);
    EXPECT_NEAR(part.look.reflectance, name == "a.gltf" ? 0.5 * kColoursMean : kColoursMean, 1e-5) << name;
    const Asset plain = read(name, text, {.textures = false});
    EXPECT_FALSE(plain.parts.at(0).look.textured);
    EXPECT_FALSE(plain.parts.at(0).look.texture);
    EXPECT_EQ(plain.parts.at(0).texture, "colours.png");
  }
  const Asset asset = read("a.gltf", gltf.text());
  EXPECT_EQ(asset.parts[0].look.roughness, 0.25f);
  EXPECT_EQ(asset.parts[0].look.metallic, 1.0f);
}

TEST_F(AssetFiles, WebpAndEmbeddedTexturesOfGltfAreFound) {
  std::filesystem::create_directories(folder_.path() / "my textures");
  writeColours(folder_.path() / "my textures" / "colours.webp");
  const std::string image = readFile(folder_.path() / "my textures" / "colours.webp");
  Gltf gltf;
  gltf.material = R"({"name":"paint","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  const std::string texture = R"(,"textures":[{"extensions":{"EXT_texture_webp":{"source":0}}}],"images":[)";
  for (const std::string& source :
       {std::string(R"({"uri":"my%20textures%2Fcolours.webp"})"),
        R"({"mimeType":"image/webp","uri":"data:image/webp;base64,)" + base64(image) + "\"}"}) {
    gltf.extra = texture + source + "]";
    const Asset asset = read("a.gltf", gltf.text(), {.up = 'z'});
    expectColours(asset.parts.at(0), source.substr(0, 30));
    EXPECT_NEAR(asset.parts[0].look.reflectance, kColoursMean, 0.02);
  }
  gltf.extra = texture + R"({"uri":"my%20textures%2Fcolours.webp"}])";
  EXPECT_EQ(read("a.gltf", gltf.text()).parts.at(0).texture, "my textures/colours.webp");
}

TEST_F(AssetFiles, AlphaIsTestedWhereTheFileAndItsTextureSaySo) {
  writeColours(folder_.path() / "opaque.png");
  writeColours(folder_.path() / "holes.png", 0);
  const auto look = [&](const std::string& mode, const std::string& image, bool textures) {
    Gltf gltf;
    gltf.material = R"({"name":"leaf",)" + mode + R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
    gltf.extra = R"(,"textures":[{"source":0}],"images":[{"uri":")" + image + R"("}])";
    return read("a.gltf", gltf.text(), {.textures = textures}).parts.at(0).look;
  };
  for (const bool textures : {true, false}) {
    EXPECT_FALSE(look("", "holes.png", textures).alphaTested);
    EXPECT_FALSE(look(R"("alphaMode":"MASK",)", "opaque.png", textures).alphaTested);
    EXPECT_EQ(look(R"("alphaMode":"MASK",)", "opaque.png", textures).texture != nullptr, textures);
    const Material mask = look(R"("alphaMode":"MASK","alphaCutoff":0.25,)", "holes.png", textures);
    EXPECT_TRUE(mask.alphaTested);
    EXPECT_EQ(mask.alphaCutoff, 0.25f);
    EXPECT_TRUE(mask.texture);
    EXPECT_EQ(mask.textured, textures);
    // What a beam meets has no part in the hole, which is blue.
    EXPECT_NEAR(mask.reflectance, (0.2126 + 0.7152 + 1) / 3, 1e-5);
    EXPECT_TRUE(look(R"("alphaMode":"BLEND",)", "holes.png", textures).alphaTested);
  }
}

TEST_F(AssetFiles, OpacityMapsOfObjMakeHoles) {
  writeColours(folder_.path() / "colours.png");
  writeColours(folder_.path() / "holes.png", 0);
  write("a.mtl", std::string(kMtl) + "map_d holes.png\n");
  const Material look = read("a.obj", kObj).parts.at(0).look;
  EXPECT_TRUE(look.alphaTested);
  EXPECT_EQ(look.texture->texel(0.25f, 0.25f)[3], 0);
  EXPECT_EQ(look.texture->texel(0.25f, 0.75f)[3], 255);
  write("a.mtl", "newmtl paint\nKd 0.5 0.5 0.5\nmap_d holes.png\n");
  const Material plain = read("a.obj", kObj).parts.at(0).look;
  EXPECT_TRUE(plain.alphaTested);
  EXPECT_FALSE(plain.textured);
  EXPECT_NEAR(plain.reflectance, 0.5, 1e-6);
}

// Squares of the picture of writeColours(), whose blue quarter has no alpha: `squares` of the whole picture, of white
// alone and of blue alone, of equal size.
std::string squares(int whole, int white, int blue) {
  std::string text =
      "mtllib a.mtl\nusemtl paint\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.6 0.1\nvt 0.9 0.1\nvt 0.9 0.4\nvt 0.6 0.4\n"
      "vt 0.1 0.1\nvt 0.4 0.1\nvt 0.4 0.4\nvt 0.1 0.4\n";
  for (int i = 0; i < whole + white + blue; ++i) {
    const int uv = i < whole ? 1 : i < whole + white ? 5 : 9;
    for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(i) + "\n";
    }
    text += "f";
    for (int k = 0; k < 4; ++k) text += " " + std::to_string(4 * i + k + 1) + "/" + std::to_string(uv + k);
    text += "\n";
  }
  return text;
}

TEST_F(AssetFiles, AlphaThatNobodyDeclaresCountsWhereItLooksLikeCutOuts) {
  const std::string plain = "newmtl paint\nKd 0.5 0.5 0.5\nmap_Kd holes.png\n";
  const auto tested = [&](const std::string& mtl, const std::string& obj, const AssetOptions& options = {}) {
    write("a.mtl", mtl);
    const Material look = read("a.obj", obj, options).parts.at(0).look;
    EXPECT_EQ(look.texture != nullptr, look.alphaTested || options.textures);
    EXPECT_EQ(look.textured, options.textures);
    return look.alphaTested;
  };
  writeColours(folder_.path() / "holes.png", 0);
  for (const bool textures : {true, false}) {
    const AssetOptions options{.textures = textures};
    EXPECT_TRUE(tested(plain, squares(10, 0, 0), options)) << "every card has a hole";
    EXPECT_TRUE(tested(plain, squares(5, 4, 1), options)) << "a tenth would vanish";
    EXPECT_FALSE(tested(plain, squares(5, 2, 3), options)) << "three tenths would vanish";
    EXPECT_FALSE(tested(plain, squares(0, 10, 0), options)) << "nothing is cut away";
    // Whatever it looks like, the material's word counts; `d 0` is no word, for the material would not be there.
    for (const char* word : {"map_d holes.png\n", "d 0.9\n", "Tr 0.1\n"}) {
      EXPECT_TRUE(tested(plain + word, squares(5, 2, 3), options)) << word;
    }
    for (const char* word : {"d 1\n", "d 0\n", "Tr 0\n", "illum 2\n"}) {
      EXPECT_FALSE(tested(plain + word, squares(5, 2, 3), options)) << word;
      EXPECT_TRUE(tested(plain + word, squares(10, 0, 0), options)) << word;
    }
    // And the caller's word before that.
    EXPECT_TRUE(tested(plain, squares(5, 2, 3), {.alpha = AlphaUse::Test, .textures = textures}));
    EXPECT_FALSE(tested(plain, squares(10, 0, 0), {.alpha = AlphaUse::Ignore, .textures = textures}));
    EXPECT_FALSE(
        tested(plain + "map_d holes.png\n", squares(10, 0, 0), {.alpha = AlphaUse::Ignore, .textures = textures}));
  }
  EXPECT_TRUE(tested(plain, squares(18, 0, 2)));
  writeColours(folder_.path() / "holes.png", 100);
  EXPECT_TRUE(tested(plain, squares(10, 0, 0)));
  EXPECT_FALSE(tested(plain, squares(18, 0, 2))) << "a third of the surface is neither on nor off";
}

// A triangle wholly in the quarter without alpha: not how cut-outs look, so the declaration alone decides.
TEST_F(AssetFiles, TransparencyOfColladaAndAc3dIsADeclaration) {
  writeColours(folder_.path() / "holes.png", 0);
  const auto replaced = [](std::string text, const std::string& mark, const std::string& by) {
    const std::size_t at = text.find(mark);
    EXPECT_NE(at, std::string::npos) << mark;
    return text.replace(at, mark.size(), by);
  };
  const auto tested = [&](const std::string& name, const std::string& text) {
    const Material look = read(name, text).parts.at(0).look;
    EXPECT_TRUE(look.texture) << name;
    return look.alphaTested;
  };
  std::string ac = replaced(kAc, "colours.png", "holes.png");
  ac = replaced(replaced(ac, "1 0.75 0.25", "1 0.4 0.25"), "2 0.25 0.75", "2 0.25 0.4");
  EXPECT_FALSE(tested("a.ac", ac));
  EXPECT_TRUE(tested("a.ac", replaced(ac, "trans 0", "trans 0.25")));

  std::string collada = dae("Z_UP", "1");
  collada = replaced(collada, "<library_geometries>",
                     R"(<library_images><image id="i"><init_from>holes.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="common"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse><!--alpha--></lambert></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="paint"><instance_effect url="#e"/></material></library_materials>
<library_geometries>)");
  collada = replaced(collada, "<vertices ",
                     R"(<source id="u"><float_array id="ua" count="6">0.1 0.1 0.4 0.1 0.1 0.4</float_array>
<technique_common><accessor source="#ua" count="3" stride="2"><param name="S" type="float"/><param name="T" type="float"/>
</accessor></technique_common></source><vertices )");
  collada = replaced(collada, R"(<triangles count="1">)", R"(<triangles count="1" material="p">)");
  collada = replaced(collada, "<p>0 1 2</p>",
                     R"(<input semantic="TEXCOORD" source="#u" offset="1" set="0"/><p>0 0 1 1 2 2</p>)");
  collada = replaced(collada, R"(<instance_geometry url="#g"/>)",
                     R"(<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="p" target="#m"/></technique_common></bind_material></instance_geometry>)");
  const auto with = [&](const std::string& alpha) { return tested("a.dae", replaced(collada, "<!--alpha-->", alpha)); };
  EXPECT_FALSE(with(""));
  EXPECT_FALSE(with(R"(<transparent opaque="A_ONE"><color>1 1 1 1</color></transparent>
                       <transparency><float>1</float></transparency>)"));
  EXPECT_TRUE(with(R"(<transparent opaque="A_ONE"><color>1 1 1 1</color></transparent>
                      <transparency><float>0.5</float></transparency>)"));
  EXPECT_TRUE(with(R"(<transparent opaque="A_ONE"><texture texture="t" texcoord="UV"/></transparent>)"));
}

TEST_F(AssetFiles, ScenesOverrideTheUpAxisAndTheAlpha) {
  writeColours(folder_.path() / "holes.png", 0);
  write("a.mtl", "newmtl paint\nKd 0.5 0.5 0.5\nmap_Kd holes.png\n");
  write("leaves.obj", squares(10, 0, 0));
  write("z.dae", dae("Z_UP", "1"));
  const std::string labels = std::string(SCANMILL_SOURCE_DIR) + "/labels/";
  const auto scene = [&](const std::string& object) {
    return readScene(write("scene.yaml", "ontology: " + labels + "scanmill.yaml\nmaterials: " + labels +
                                             "materials.yaml\nobjects:\n  - {" + object + "class: tree}\n"),
                     {});
  };
  const auto tested = [&](const std::string& alpha) {
    const Scene s = scene("file: leaves.obj, " + alpha);
    return std::any_of(s.materials.begin(), s.materials.end(), [](const Material& m) { return m.alphaTested; });
  };
  EXPECT_TRUE(tested(""));
  EXPECT_TRUE(tested("alpha: auto, "));
  EXPECT_TRUE(tested("alpha: test, "));
  EXPECT_FALSE(tested("alpha: ignore, "));
  EXPECT_THROW(tested("alpha: perhaps, "), InputError);
  EXPECT_EQ(scene("file: z.dae, ").bounds().low, (Vec3d{10, 20, 30}));
  EXPECT_EQ(scene("file: z.dae, up: z, ").bounds().low, (Vec3d{10, 20, 30}));
  EXPECT_EQ(scene("file: z.dae, up: y, ").bounds().low, (Vec3d{10, -33, 20}));
}

TEST_F(AssetFiles, AlphaUseOverridesTheModeOfGltf) {
  writeColours(folder_.path() / "holes.png", 0);
  const auto look = [&](const std::string& mode, AlphaUse alpha) {
    Gltf gltf;
    gltf.material = R"({"name":"leaf",)" + mode + R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
    gltf.extra = R"(,"textures":[{"source":0}],"images":[{"uri":"holes.png"}])";
    return read("a.gltf", gltf.text(), {.alpha = alpha}).parts.at(0).look;
  };
  const std::string mask = R"("alphaMode":"MASK","alphaCutoff":0.25,)";
  EXPECT_FALSE(look(mask, AlphaUse::Ignore).alphaTested);
  EXPECT_TRUE(look(mask, AlphaUse::Ignore).textured);
  EXPECT_TRUE(look(mask, AlphaUse::Test).alphaTested);
  EXPECT_EQ(look(mask, AlphaUse::Test).alphaCutoff, 0.25f);
  EXPECT_TRUE(look("", AlphaUse::Test).alphaTested);
  EXPECT_EQ(look("", AlphaUse::Test).alphaCutoff, 0.5f);
}

TEST(AlphaShares, LimitsAreOnTheSideOfCutOuts) {
  EXPECT_TRUE(isCutOut({.low = 0.5, .graded = 0.1, .gone = 0.1}));
  EXPECT_FALSE(isCutOut({.low = 0.001, .graded = 0, .gone = 0}));
  EXPECT_FALSE(isCutOut({.low = 0.5, .graded = 0.5, .gone = 0}));
  EXPECT_FALSE(isCutOut({.low = 0.5, .graded = 0, .gone = 0.2}));
  EXPECT_FALSE(isCutOut({}));
}

TEST_F(AssetFiles, AMissingTextureIsOneWarningAndThePlainColour) {
  write("a.mtl", kMtl);
  testing::internal::CaptureStderr();
  const Asset asset = read("a.obj", kObj);
  readAsset(folder_.path() / "a.obj", {});
  const std::string printed = testing::internal::GetCapturedStderr();
  EXPECT_THAT(printed, HasSubstr("a.obj"));
  EXPECT_THAT(printed, HasSubstr("colours.png"));
  EXPECT_EQ(std::count(printed.begin(), printed.end(), '\n'), 1) << printed;
  EXPECT_NEAR(asset.parts.at(0).look.reflectance, 0.5, 1e-6);
  EXPECT_FALSE(asset.parts[0].look.textured);
  EXPECT_EQ(asset.parts[0].texture, "colours.png");
}

TEST_F(AssetFiles, TexturesAreFoundWherePeoplePutThem) {
  const auto asset = folder_.path() / "car" / "meshes" / "car.dae";
  const auto expectFound = [&](const std::string& file, const std::string& name) {
    write(file, "image");
    const auto found = findTexture(asset, name);
    std::error_code error;
    EXPECT_TRUE(!found.empty() && std::filesystem::equivalent(found, folder_.path() / file, error)) << name;
    std::filesystem::remove(folder_.path() / file);
  };
  std::filesystem::create_directories(asset.parent_path());
  expectFound("car/meshes/a.png", "a.png");
  expectFound("car/meshes/a b.png", "a%20b.png");
  expectFound("car/meshes/a.png", "C:\\Users\\me\\a.png");
  expectFound("car/meshes/a.png", "../elsewhere/a.png");
  expectFound("car/meshes/textures/a.png", "a.png");
  expectFound("car/materials/textures/a.png", "a.png");
  expectFound("wheels/materials/textures/a.png", "model://wheels/materials/textures/a.png");
  expectFound("car/meshes/A.PNG", "a.png");
  expectFound("abs.png", (folder_.path() / "abs.png").string());
  EXPECT_TRUE(findTexture(asset, "a.png").empty());
  EXPECT_TRUE(findTexture(asset, "").empty());
}

TEST_F(AssetFiles, CornersOfTheSamePlaceAreSharedAndPolygonsAreCut) {
  std::string text = "solid fan\n";
  for (int i = 0; i < 60; ++i) {
    text += "facet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
    for (const int k : {i, (i + 1) % 60}) {
      text += "vertex " + std::to_string(k) + " " + std::to_string(k * k) + " 0\n";
    }
    text += "endloop\nendfacet\n";
  }
  const Asset fan = read("fan.stl", text + "endsolid fan\n");
  EXPECT_EQ(fan.parts.at(0).triangles.size(), 60u);
  EXPECT_LE(fan.parts[0].positions.size(), 60u);
  const Asset quad = read("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nl 1 2\nf 1 2 3 4\n");
  std::size_t triangles = 0;
  for (const AssetPart& part : quad.parts) triangles += part.triangles.size();
  EXPECT_EQ(triangles, 2u);
}

TEST_F(AssetFiles, IndicesOutOfRangeAreDroppedAndCounted) {
  Gltf gltf;
  gltf.buffer = R"("uri":"a.bin")";
  gltf.nodes = R"([{"name":"wing","mesh":0}])";
  write("a.bin", gltfBuffer({0, 1, 4000000000u}));
  EXPECT_THAT(failure(write("a.gltf", gltf.text())), HasSubstr("a.gltf"));

  std::string ply = kPly;
  ply.replace(ply.find("element face 1"), 14, "element face 3");
  const Asset asset = read("a.ply", ply + "3 0 1 77\n4 0 1 2 9\n");
  EXPECT_EQ(asset.parts.at(0).triangles.size(), 1u);
  EXPECT_EQ(asset.dropped.outOfRange, 3u);
}

TEST_F(AssetFiles, VerticesThatAreNotNumbersAreKeptForCleaning) {
  Gltf gltf;
  gltf.buffer = R"("uri":"a.bin")";
  std::string bytes = gltfBuffer();
  const float bad = NAN;
  std::memcpy(bytes.data(), &bad, sizeof bad);
  write("a.bin", bytes);
  const Asset asset = read("a.gltf", gltf.text());
  EXPECT_EQ(asset.parts.at(0).triangles.size(), 1u);
  EXPECT_FALSE(isFinite(asset.parts[0].positions[0]));
}

TEST_F(AssetFiles, BadRequestsAreNamed) {
  EXPECT_THAT(failure(folder_.path() / "absent.obj"), HasSubstr("absent.obj: there is no such file"));
  EXPECT_THAT(failure(folder_.path()), HasSubstr("is not a file"));
  EXPECT_THAT(failure(write("empty.ply", "")), HasSubstr("empty.ply: is empty"));
  EXPECT_THAT(failure(write("a.docx", "text")), HasSubstr("unknown kind"));
  EXPECT_THAT(failure(write("noname", "text")), HasSubstr("unknown kind"));
  EXPECT_THAT(failure(write("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n")), HasSubstr("points.obj"));
  for (const double scale : {0.0, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    EXPECT_THAT(failure(write("a.ply", kPly), {.metresPerUnit = scale}), HasSubstr("metresPerUnit"));
  }
  EXPECT_THAT(failure(write("a.ply", kPly), {.up = 'q'}), HasSubstr("up axis"));
}

TEST_F(AssetFiles, GltfIsCheckedBeforeItIsRead) {
  const auto fails = [&](const Gltf& gltf) { return failure(write("bad.gltf", gltf.text())); };
  Gltf gltf;
  gltf.buffer = R"("uri":"absent.bin")";
  EXPECT_THAT(fails(gltf), HasSubstr("'absent.bin', which is missing"));
  write("short.bin", gltfBuffer().substr(0, 71));
  gltf.buffer = R"("uri":"short.bin")";
  EXPECT_THAT(fails(gltf), HasSubstr("holds 71"));
  gltf = {};
  gltf.nodes = R"([{"children":[1]},{"children":[0]}])";
  EXPECT_THAT(fails(gltf), HasSubstr("ancestor"));
  gltf.nodes = R"([{"mesh":7}])";
  EXPECT_THAT(fails(gltf), HasSubstr("nodes[0].mesh is 7"));
  gltf.nodes = R"([{"mesh":-1}])";
  EXPECT_THAT(fails(gltf), HasSubstr("nodes[0].mesh"));
  gltf.nodes = R"([{"mesh":0,"scale":[1,1]}])";
  EXPECT_THAT(fails(gltf), HasSubstr("scale is not 3 numbers"));
  gltf = {};
  gltf.extra = R"(,"extensionsRequired":["KHR_mesh_quantization"])";
  EXPECT_THAT(fails(gltf), HasSubstr("without compression or quantisation"));
  std::string beyond = Gltf().text();
  beyond.replace(beyond.find(R"("count":3)"), 9, R"("count":4)");
  EXPECT_THAT(failure(write("beyond.gltf", beyond)), HasSubstr("accessors[0] reaches beyond"));
  EXPECT_THAT(failure(write("one.gltf", R"({"asset":{"version":"1.0"}})")), HasSubstr("glTF 1.0"));
  EXPECT_THAT(failure(write("json.gltf", "[1, 2")), HasSubstr("not valid glTF"));
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "[";
  EXPECT_THAT(failure(write("deep.gltf", deep)), HasSubstr("not valid glTF"));
  EXPECT_THAT(failure(write("other.glb", "not a GLB at all, although it is named like one")), HasSubstr("other.glb"));
}

TEST_F(AssetFiles, TheMessageNamesTheReasonAndARemedy) {
  const std::string message = failure(write("a.ac", "AC3Db\nOBJECT world\nkids 0\n"));
  EXPECT_THAT(message, HasSubstr("a.ac"));
  EXPECT_THAT(failure(write("a.dae", "<COLLADA>")), HasSubstr("or convert it to glTF"));
}

TEST_F(AssetFiles, TruncatedAndGarbledFilesNeverCrash) {
  write("a.mtl", kMtl);
  writeColours(folder_.path() / "colours.png");
  std::string binaryPly =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
      bytesOf<float>({1, 0, 0, 0, 2, 0, 0, 0, 3}) + "\3" + bytesOf<std::int32_t>({0, 1, 2});
  std::string binaryStl = std::string(80, ' ') + bytesOf<std::uint32_t>({1}) +
                          bytesOf<float>({0, 0, 1, 1, 0, 0, 0, 2, 0, 0, 0, 3}) + std::string(2, '\0');
  const std::vector<std::pair<std::string, std::string>> files{{"a.obj", kObj},
                                                               {"a.ply", kPly},
                                                               {"b.ply", binaryPly},
                                                               {"a.stl", kStl},
                                                               {"b.stl", binaryStl},
                                                               {"a.gltf", Gltf().text()},
                                                               {"a.glb", glbOfTriangle()},
                                                               {"a.ac", kAc},
                                                               {"a.dae", dae("Z_UP", "1")},
                                                               {"a.fbx", fbx(2, 1)}};
  for (const auto& [name, whole] : files) {
    EXPECT_EQ(read(name, whole).parts.at(0).triangles.size(), 1u) << name;
    for (std::size_t k = 0; k < 50; ++k) {
      std::string text = whole.substr(0, whole.size() * k / 50);
      try {
        read(name, text);
      } catch (const InputError& e) {
        EXPECT_THAT(e.what(), HasSubstr(name));
      }
      text = whole;
      text[whole.size() * k / 50] = static_cast<char>(k % 2 == 0 ? 0xFF : '9');
      try {
        read(name, text);
      } catch (const InputError& e) {
        EXPECT_THAT(e.what(), HasSubstr(name));
      }
    }
  }
}

TEST_F(AssetFiles, AbsurdCountsAreRefusedWithoutAskingForTheMemory) {
  for (const char* count : {"4000000000", "2000000000", "-1", "99999999999999999999"}) {
    for (const char* format : {"ascii", "binary_little_endian"}) {
      failure(write("a.ply", std::string("ply\nformat ") + format + " 1.0\nelement vertex " + count +
                                 "\nproperty float x\nproperty float y\nproperty float z\nelement face " + count +
                                 "\nproperty list uchar int vertex_indices\nend_header\n1 2 3\n"));
    }
    failure(write("a.off", std::string("OFF\n") + count + " " + count + " 0\n0 0 0\n"));
  }
  failure(write("a.stl", std::string(80, ' ') + bytesOf<std::uint32_t>({4000000000u}) + std::string(50, '\0')));
}

TEST(DecodeUri, DecodesEscapesOnly) {
  EXPECT_EQ(decodeUri("textures%2Fa%20b.webp"), "textures/a b.webp");
  EXPECT_EQ(decodeUri("100%"), "100%");
  EXPECT_EQ(decodeUri("%zz%4"), "%zz%4");
  EXPECT_EQ(decodeUri("%41"), "A");
}

bool hasKind(const std::filesystem::path& file, std::initializer_list<const char*> kinds) {
  std::string kind = file.extension().string();
  std::transform(kind.begin(), kind.end(), kind.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

std::size_t countTriangles(const Asset& asset) {
  std::size_t count = 0;
  for (const AssetPart& part : asset.parts) count += part.triangles.size();
  return count;
}

Box bounds(const Asset& asset) {
  Box box;
  for (const AssetPart& part : asset.parts) {
    for (const Vec3f& p : part.positions) box.add(static_cast<Vec3d>(p));
  }
  return box;
}

TEST(SharedAssets, EveryFileLoadsOrIsRefused) {
  SKIP_WITHOUT_SHARED_DATA("scenes");
  int loaded = 0;
  int trees = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(sharedData() / "scenes")) {
    const std::filesystem::path& file = entry.path();
    if (!hasKind(file, {".gltf", ".glb", ".obj", ".dae", ".stl", ".ac"})) continue;
    if (file.parent_path().filename() == "tree1" && ++trees > 5) continue;  // hundreds of leaves of one tree
    try {
      const Asset asset = readAsset(file, {.textures = false});
      ++loaded;
      for (const AssetPart& part : asset.parts) {
        EXPECT_FALSE(part.triangles.empty());
        EXPECT_TRUE(part.uvs.empty() || part.uvs.size() == part.positions.size()) << file;
        for (const Triangle& t : part.triangles) {
          ASSERT_LT(std::max({t[0], t[1], t[2]}), part.positions.size()) << file;
        }
      }
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr(file.filename().string()));
    }
  }
  EXPECT_GT(loaded, 60);
}

TEST(SharedAssets, TheTownHasItsTrianglesNodesAndTextures) {
  SKIP_WITHOUT_SHARED_DATA("scenes/truck_town");
  const Asset town = readAsset(sharedData() / "scenes/truck_town/model/town_model.gltf", {});
  EXPECT_EQ(countTriangles(town), 30477u);  // the sum over the nodes; collision shapes have no node with a mesh
  const Box box = bounds(town);
  EXPECT_NEAR(box.high.x - box.low.x, 2048, 16);
  EXPECT_NEAR(box.high.y - box.low.y, 2048, 16);
  EXPECT_LT(box.high.z - box.low.z, 60);
  int found = 0;
  for (const AssetPart& part : town.parts) {
    if (part.node == "RoadMesh") {
      ++found;
      EXPECT_EQ(part.texture, "textures/cement_lossy.webp");
      EXPECT_TRUE(part.look.textured);
    }
    if (part.node == "GrassMesh") {
      ++found;
      EXPECT_EQ(part.texture, "textures/grass_lossy.webp");
      EXPECT_TRUE(part.look.texture);
      EXPECT_FALSE(part.look.alphaTested);
    }
  }
  EXPECT_EQ(found, 2);
}

TEST(SharedAssets, OnlyTheLeavesOfTheTreeAreAlphaTested) {
  SKIP_WITHOUT_SHARED_DATA("scenes/truck_town/tree");
  const Asset tree = readAsset(sharedData() / "scenes/truck_town/tree/scene.gltf", {.textures = false});
  ASSERT_EQ(tree.parts.size(), 2u);
  for (const AssetPart& part : tree.parts) {
    EXPECT_EQ(part.look.alphaTested, part.material == "Leav_material");
    EXPECT_EQ(part.look.texture != nullptr, part.look.alphaTested);
  }
  const Box box = bounds(tree);
  EXPECT_NEAR(box.low.z, 0, 1);  // it stands upright on the ground, in centimetres
  EXPECT_NEAR(box.high.z, 2470, 10);
}

TEST(SharedAssets, GazeboModelsHaveTheirRealSizes) {
  SKIP_WITHOUT_SHARED_DATA("scenes/gazebo");
  struct Case {
    const char* file;
    double scale;      // of the model's SDF
    double low, high;  // what the height may be, m
  };
  for (const Case& each : {Case{"suv/meshes/suv.obj", 0.06, 1.5, 2.5},
                           {"bus/meshes/bus.obj", 0.01, 2.5, 4.5},
                           {"ambulance/meshes/ambulance.obj", 0.0254, 2, 3.5},
                           {"pickup/meshes/pickup.dae", 1, 1.5, 2.2},
                           {"hatchback/meshes/hatchback.obj", 0.0254, 1.2, 1.8},
                           {"stop_sign/meshes/stop_sign.dae", 1, 1.5, 3},
                           {"dumpster/meshes/dumpster.dae", 1.5, 1, 2.5},
                           {"fire_hydrant/meshes/fire_hydrant.dae", 1, 0.5, 1.2},
                           {"telephone_pole/meshes/telephone_pole.dae", 1, 6, 12},
                           {"lamp_post/meshes/lamp_post.dae", 3, 6, 12},
                           {"oak_tree/meshes/oak_tree.dae", 1, 6, 7},
                           {"pine_tree/meshes/pine_tree.dae", 1, 5, 5.2},
                           {"mailbox/meshes/mailbox.dae", 1, 1, 1.1},
                           {"jersey_barrier/meshes/jersey_barrier.dae", 1, 1.1, 1.2},
                           {"house_2/meshes/house_2.dae", 1, 4.5, 5},
                           {"house_1/meshes/house_1.dae", 1, 5, 5.25}}) {
    const Box box =
        bounds(readAsset(sharedData() / "scenes/gazebo" / each.file, {.metresPerUnit = each.scale, .textures = false}));
    EXPECT_GT(box.high.z - box.low.z, each.low) << each.file;
    EXPECT_LT(box.high.z - box.low.z, each.high) << each.file;
    EXPECT_NEAR(box.low.z, 0, 0.15) << each.file;  // upright, standing on the ground
  }
}

// The same through a scene file, with no word of an axis.
TEST(SharedAssets, GazeboModelsStandUprightInAScene) {
  SKIP_WITHOUT_SHARED_DATA("scenes/gazebo");
  const TemporaryFolder folder;
  const std::string labels = std::string(SCANMILL_SOURCE_DIR) + "/labels/";
  for (const auto& [model, height] : {std::pair("house_1", 5.124),
                                      {"oak_tree", 6.598},
                                      {"pickup", 1.865},
                                      {"mailbox", 1.067},
                                      {"fire_hydrant", 0.931},
                                      {"lamp_post", 3.091},
                                      {"telephone_pole", 9.223}}) {
    const Scene scene = readScene(
        folder.write("scene.yaml", "ontology: " + labels + "scanmill.yaml\nmaterials: " + labels + "materials.yaml\n" +
                                       "assets: " + (sharedData() / "scenes/gazebo").string() +
                                       "\nobjects:\n  - {file: " + model + "/meshes/" + model +
                                       ".dae, class: object, material: wood}\n"),
        {});
    EXPECT_NEAR(scene.bounds().low.z, 0, 0.08) << model;
    EXPECT_NEAR(scene.bounds().high.z - scene.bounds().low.z, height, 0.002) << model;
  }
}

// Their bodies are 42 to 64 % without alpha, where the paint goes; the post's alpha is all outside its surface.
TEST(SharedAssets, BodiesOfGazeboCarsAreSolid) {
  SKIP_WITHOUT_SHARED_DATA("scenes/gazebo");
  for (const char* file : {"bus/meshes/bus.obj", "suv/meshes/suv.obj", "hatchback/meshes/hatchback.obj",
                           "hatchback_blue/meshes/hatchback.obj", "ambulance/meshes/ambulance.obj",
                           "pickup/meshes/pickup.dae", "lamp_post/meshes/lamp_post.dae"}) {
    const std::filesystem::path path = sharedData() / "scenes/gazebo" / file;
    int textured = 0;
    for (const AssetPart& part : readAsset(path, {}).parts) {
      EXPECT_FALSE(part.look.alphaTested) << file << ' ' << part.material;
      textured += part.look.textured ? 1 : 0;
    }
    EXPECT_GT(textured, 0) << file;
  }
  bool tested = false;
  for (const AssetPart& part :
       readAsset(sharedData() / "scenes/gazebo/suv/meshes/suv.obj", {.alpha = AlphaUse::Test}).parts) {
    tested = tested || part.look.alphaTested;
  }
  EXPECT_TRUE(tested);
}

// The trees name no texture themselves (scripts of Gazebo's renderer do): here they get those of the scripts.
TEST(SharedAssets, BranchesOfGazeboTreesAreCutOut) {
  SKIP_WITHOUT_SHARED_DATA("scenes/gazebo/pine_tree");
  const TemporaryFolder folder;
  for (const auto& [tree, image] :
       {std::pair("oak_tree", "branch_diffuse.png"), {"pine_tree", "branch_2_diffuse.png"}}) {
    const std::filesystem::path model = sharedData() / "scenes/gazebo" / tree;
    std::string text = readFile(model / "meshes" / (std::string(tree) + ".dae"));
    const auto insert = [&](const std::string& mark, const std::string& replacement) {
      const std::size_t at = text.find(mark);
      ASSERT_NE(at, std::string::npos) << mark;
      text.replace(at, mark.size(), replacement);
    };
    insert("<library_images/>", "<library_images><image id=\"i\"><init_from>" +
                                    (model / "materials/textures" / image).string() +
                                    "</init_from></image></library_images>");
    insert("<profile_COMMON>",
           "<profile_COMMON><newparam sid=\"s\"><surface type=\"2D\"><init_from>i</init_from></surface></newparam>"
           "<newparam sid=\"t\"><sampler2D><source>s</source></sampler2D></newparam>");
    insert("<color sid=\"diffuse\">0.64 0.64 0.64 1</color>", "<texture texture=\"t\" texcoord=\"UVMap\"/>");
    int leafy = 0;
    for (const AssetPart& part : readAsset(folder.write("tree.dae", text), {.textures = false}).parts) {
      EXPECT_EQ(part.look.alphaTested, part.material.starts_with("Branch")) << tree << ' ' << part.material;
      leafy += part.look.alphaTested ? 1 : 0;
    }
    EXPECT_EQ(leafy, 1) << tree;
  }
}

TEST(SharedAssets, TruncatedFilesNeverCrash) {
  SKIP_WITHOUT_SHARED_DATA("scenes");
  const std::filesystem::path scenes = sharedData() / "scenes";
  const TemporaryFolder folder;
  for (const char* name :
       {"truck_town/tree/scene.gltf", "kenney_city/vehicle-truck-red.glb", "helios/toyblocks/sphere.obj",
        "gazebo/bus_stop/meshes/glass.STL", "gazebo/stop_sign/meshes/stop_sign.dae"}) {
    const std::string whole = readFile(scenes / name);
    const std::string file = "cut" + std::filesystem::path(name).extension().string();
    for (std::size_t k = 0; k < 50; ++k) {
      try {
        readAsset(folder.write(file, std::string_view(whole).substr(0, whole.size() * k / 50)), {.textures = false});
      } catch (const InputError& e) {
        EXPECT_THAT(e.what(), HasSubstr(file));
      }
    }
  }
}

// Debian's assimp-testmodels: hundreds of files of every kind, some broken on purpose.
TEST(TestModels, NoneCrashes) {
  const std::filesystem::path models = "/usr/share/assimp/models";
  if (!std::filesystem::exists(models)) GTEST_SKIP() << "the package assimp-testmodels is not installed";
  int loaded = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(models)) {
    const std::filesystem::path& file = entry.path();
    if (!hasKind(file, {".gltf", ".glb", ".obj", ".ply", ".stl", ".dae", ".fbx", ".ac", ".3ds", ".raw", ".off"}))
      continue;
    try {
      readAsset(file, {.textures = false});
      ++loaded;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr(file.filename().string()));
    }
  }
  EXPECT_GT(loaded, 80);
}

}  // namespace
}  // namespace scanmill
