#pragma once

// A glTF 2.0 file, read and checked. Terms are those of the glTF specification, chapters 3 to 5.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/format_support.h"
#include "base/vec.h"

namespace scanmill::gltf {

using Index = std::size_t;
using MaybeIndex = std::optional<Index>;

struct Buffer {
  std::string uri;  // a file's name, with escapes decoded, or a data: URI; empty: the GLB's binary chunk
  std::uint64_t length = 0;
  std::string problem = {};  // why the buffer cannot be read, reported only if it is used; empty: it can be read
};

// Location of a view's compressed bytes (EXT_meshopt_compression or KHR_meshopt_compression), and the functions of
// meshoptimizer that decode them.
struct Meshopt {
  Index buffer = 0;
  std::uint64_t offset = 0, length = 0, stride = 0, count = 0;
  int (*decode)(void* to, std::size_t count, std::size_t stride, const unsigned char* from,
                std::size_t bytes) = nullptr;
  void (*filter)(void* decoded, std::size_t count, std::size_t stride) = nullptr;  // null: none
  std::string problem;  // why the bytes cannot be decoded, reported only if they are used; empty: they can be decoded
};

struct View {
  Index buffer = 0;
  std::uint64_t offset = 0, length = 0;
  std::uint64_t stride = 0;  // bytes from element to element; 0: tightly packed
  std::optional<Meshopt> compressed;
};

// The type of an accessor's numbers: U (unsigned), I (signed) or F (floating-point), and bytes per number.
struct Component {
  char kind = 'F';
  std::size_t size = 4;
};

struct Accessor {
  struct Sparse {
    std::uint64_t count = 0;
    Index indicesView = 0, valuesView = 0;
    std::uint64_t indicesOffset = 0, valuesOffset = 0;
    Component indices;
  };
  MaybeIndex view;  // not set: elements outside of `sparse` are zero, or the data are Draco-compressed
  std::uint64_t offset = 0, count = 0;
  Component component;
  std::size_t width = 1;  // components per element
  bool normalized = false;
  std::optional<Sparse> sparse;
};

using Attributes = std::map<std::string, Index>;  // index of an accessor, by attribute name such as POSITION

struct Primitive {
  enum class Mode { Triangles = 4, Strip = 5, Fan = 6 };
  struct Draco {
    Index view = 0;
    std::map<std::string, std::uint32_t> attributes = {};  // id in the compressed data, by attribute name
  };
  Mode mode = Mode::Triangles;
  Attributes attributes;
  MaybeIndex indices, material;
  std::vector<Attributes> targets;
  std::optional<Draco> draco;
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives = {};
  std::vector<double> weights = {};
};

struct Node {
  std::string name;
  std::vector<Index> children = {};
  MaybeIndex mesh = {}, skin = {};
  std::vector<double> weights = {};
  std::array<double, 3> translation{0, 0, 0}, scale{1, 1, 1};
  std::array<double, 4> rotation{0, 0, 0, 1};  // x, y, z, w
  std::optional<std::array<double, 16>> matrix =
      {};                                    // column by column; if set, replaces translation, rotation and scale
  std::optional<Attributes> instances = {};  // accessors of EXT_mesh_gpu_instancing
  bool visible = true;                       // KHR_node_visibility; false also hides all descendants
};

struct Skin {
  std::vector<Index> joints;
  MaybeIndex inverseBindMatrices;
};

struct Animation {
  enum class Interpolation { Linear, Step, CubicSpline };
  enum class Path { Translation, Rotation, Scale, Weights };
  struct Sampler {
    Index input = 0, output = 0;
    Interpolation interpolation = Interpolation::Linear;
  };
  struct Channel {
    Index sampler = 0, node = 0;
    Path path = Path::Translation;
  };
  std::string name;
  std::vector<Sampler> samplers = {};
  std::vector<Channel> channels = {};
  std::uint64_t pointers = 0;  // number of channels of KHR_animation_pointer, which are not read
};

struct Image {
  std::string name;
  std::string uri = {};  // see Buffer::uri
  MaybeIndex view = {};
};

// Describes how a material uses a texture: only the properties that affect beams.
struct TextureUse {
  Index image = 0;
  unsigned coordinates = 0;                         // the n of attribute TEXCOORD_n
  std::array<double, 2> offset{0, 0}, scale{1, 1};  // KHR_texture_transform
  double rotation = 0;                              // rad, counter-clockwise when v points down
  bool repeats = true;                              // false: the sampler clamps or mirrors the image outside of 0 to 1
};

struct Material {
  enum class Alpha { Opaque, Mask, Blend };
  std::string name;
  std::array<double, 4> color{1, 1, 1, 1};  // base colour and alpha, in linear space
  std::optional<TextureUse> texture = {};   // texture of the base colour
  double metallic = 1, roughness = 1;
  Alpha alpha = Alpha::Opaque;
  double cutoff = 0.5;
  LeftOut leftOut = {};  // properties of the material that are not read
};

struct Model {
  std::filesystem::path file;   // the file's name in messages
  std::string bin;              // the GLB's binary chunk
  std::optional<Vec3d> center;  // m, z up: origin of all coordinates, from CESIUM_RTC or a .b3dm's RTC_CENTER
  std::vector<Buffer> buffers;
  std::vector<View> views;
  std::vector<Accessor> accessors;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Index> roots;  // root nodes of the scene
  std::vector<Skin> skins;
  std::vector<Animation> animations;
  std::vector<Image> images;
  std::vector<Material> materials;
  LeftOut leftOut;

  // Throws an InputError that names the file.
  template <class... Values>
  [[noreturn]] void fail(fmt::format_string<Values...> problem, Values&&... values) const {
    throw InputError({file.string()}, fmt::format(problem, std::forward<Values>(values)...));
  }
};

extern const FormatSupport kGltfFormat;

// Reads a .gltf, .glb or .b3dm. Points and lines are counted in Model::leftOut. In the result every index, range and
// length has been checked against the files, and the nodes of the scene form a tree. Throws an InputError with the file
// and the problem, such as an unknown extension that the file requires. Messages call the file `name`; other files are
// searched for relative to the folder of `name`. `allowOutside`: see AssetOptions.
Model readModel(const std::filesystem::path& file, const std::filesystem::path& name, bool allowOutside);

}  // namespace scanmill::gltf
