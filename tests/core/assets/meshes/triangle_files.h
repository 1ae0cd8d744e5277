#pragma once

// A triangle in every kind of file, and what tests ask of it.

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "assets/asset.h"
#include "base/error.h"
#include "base/hash.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

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

// Returns the text with `by` in place of the first `mark`.
inline std::string replaced(std::string text, const std::string& mark, const std::string& by) {
  const std::size_t at = text.find(mark);
  EXPECT_NE(at, std::string::npos) << mark;
  return at == std::string::npos ? text : text.replace(at, mark.size(), by);
}

inline std::string dae(const std::string& up, const std::string& unit) {
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

template <class T>
inline std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Positions, texture coordinates (v down, as glTF has it) and indices of the triangle: 36 + 24 + 12 bytes.
inline std::string gltfBuffer(const std::vector<std::uint32_t>& indices = {0, 1, 2}) {
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

inline std::string glb(std::string text, const std::string& binary = "") {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto words = [](std::initializer_list<std::size_t> values) {
    std::vector<std::uint32_t> out;
    for (const std::size_t value : values) out.push_back(static_cast<std::uint32_t>(value));
    return bytesOf(out);
  };
  return words({0x46546C67, 2, 28 + text.size() + binary.size(), text.size(), 0x4E4F534A}) + text +
         words({binary.size(), 0x004E4942}) + binary;
}

inline std::string glbOfTriangle() {
  Gltf gltf;
  gltf.buffer = R"("name":"b")";
  return glb(gltf.text(), gltfBuffer());
}

// The corners of the only triangle.
inline std::vector<Vec3f> corners(const Asset& asset) {
  EXPECT_EQ(asset.parts.size(), 1u);
  EXPECT_EQ(asset.parts.at(0).triangles.size(), 1u);
  std::vector<Vec3f> out;
  for (const std::uint32_t i : asset.parts.at(0).triangles.at(0)) out.push_back(asset.parts[0].positions.at(i));
  return out;
}

inline void expectCorners(const Asset& asset, const std::vector<Vec3f>& expected, const std::string& what) {
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

inline std::string failure(const std::filesystem::path& file, const AssetOptions& options = {}) {
  const std::string message = messageOf([&] { readAsset(file, options); });
  EXPECT_NE(message, "accepted") << file << " was read";
  return message;
}

// 64 x 64 texels: the top half red and green, the bottom half blue (with an alpha) and white.
inline void writeColours(const std::filesystem::path& path, std::uint8_t blueAlpha = 255) {
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

inline const double kColoursMean = (0.2126 + 0.7152 + 0.0722 + 1) / 4;

// Corner 0 lies at (u, v) = (0.25, 0.25), the image's bottom left: blue; 1 is white, 2 is red.
inline void expectColours(const AssetPart& part, const std::string& what) {
  ASSERT_TRUE(part.fileMaterial.texture) << what;
  ASSERT_EQ(part.uvs.size(), part.positions.size()) << what;
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    const std::uint8_t* rgb = part.fileMaterial.texture->texel(part.uvs[i].x, part.uvs[i].y);
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

}  // namespace scanmill
