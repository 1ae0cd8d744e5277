#pragma once

// Reads the numbers, the compressed meshes and the materials of a glTF file.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/gltf/model.h"

namespace scanmill::gltf {

// Reads accessors. Loads buffers and decodes compressed views when they are first needed; throws an InputError that
// names the file if this fails. `what`: the part of the file to which the numbers belong, for messages.
class Data {
 public:
  explicit Data(const Model& model);  // stores a reference to the model
  Data(const Data&) = delete;

  // Returns all numbers of an accessor, element by element; zeroes if the accessor has no data. Normalized integers
  // become 0 to 1, or -1 to 1 (glTF 2.0, 3.6.2.2); other integers keep their value. Floats may be infinite or NaN.
  std::vector<float> floats(Index accessor, const std::string& what) const;
  // Returns the same as floats(). Throws if a number is not finite.
  std::vector<float> finiteFloats(Index accessor, const std::string& what) const;
  // Returns the same as finiteFloats(). Throws if the numbers are integers that are not normalized.
  std::vector<float> fractions(Index accessor, const std::string& what) const;
  // Returns all numbers of an accessor of unsigned integers. Throws if they are of another type.
  std::vector<std::uint32_t> integers(Index accessor, const std::string& what) const;

  // Returns the bytes of a buffer view, decoded if they are compressed.
  std::string_view view(Index index) const;
  // Returns the decoded bytes of a data: URI.
  std::string embedded(const std::string& uri, const std::string& what) const;

 private:
  std::string_view buffer(Index index) const;
  // Returns `length` bytes of a buffer. Checks its size again, since the file may have shrunk after readModel().
  std::string_view bytesOf(Index buffer, std::uint64_t offset, std::uint64_t length) const;
  std::string decode(const Meshopt& meshopt, const std::string& what) const;
  template <class Number>
  std::vector<Number> numbers(Index index, const std::string& what) const;

  const Model& model_;
  mutable std::vector<std::optional<std::string>> buffers_;  // bytes of the files and URIs that were needed so far
  mutable std::vector<std::optional<std::string>> decoded_;  // decoded bytes of compressed views, by view
};

struct DracoMesh {
  struct Values {
    bool normalized = false;     // true: integers were converted to the interval 0 to 1, or -1 to 1
    std::vector<float> numbers;  // vertex by vertex
  };
  std::map<std::string, Values> attributes;  // by name, see decodeDraco()
  std::vector<std::uint32_t> indices;        // vertex indices, three per triangle
};

// Decodes the attributes with these ids; `ids` maps each attribute's name to its id. Throws Error if the bytes are
// damaged. Damaged bytes can require any amount of memory: callers decode untrusted bytes in a child process first
// (assets/meshes/child_process.h).
DracoMesh decodeDraco(std::string_view bytes, const std::map<std::string, std::uint32_t>& ids);

struct ReadMaterial : Look {
  std::optional<TextureUse> placed;  // how the base colour uses its texture
  LeftOut leftOut;                   // properties of the material that are not modelled
};

// Returns the materials in the file's order, and after them the default material of primitives without a material.
// Warns of missing and broken textures.
std::vector<ReadMaterial> readMaterials(const Model& model, const Data& data, const AssetOptions& options);

}  // namespace scanmill::gltf
