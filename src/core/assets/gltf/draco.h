#pragma once

// Meshes that KHR_draco_mesh_compression holds.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill::gltf {

struct DracoMesh {
  struct Values {
    std::size_t width = 0;
    bool normalized = false;     // 0 to 1, or -1 to 1, of whole numbers
    std::vector<float> numbers;  // vertex after vertex
  };
  std::map<std::string, Values> attributes;  // by the names of the ids
  std::vector<std::uint32_t> indices;        // of triangles
};

// Decodes the attributes that have these ids. Throws Error where the bytes are damaged. Memory is what they ask for:
// those of strangers are tried apart first (assets/child_process.h).
DracoMesh decodeDraco(std::string_view bytes, const std::map<std::string, std::uint32_t>& ids);

}  // namespace scanmill::gltf
