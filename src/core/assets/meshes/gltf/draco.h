#pragma once

// Decodes meshes of KHR_draco_mesh_compression.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill::gltf {

struct DracoMesh {
  struct Values {
    std::size_t width = 0;
    bool normalized = false;     // true: integers were converted to the interval 0 to 1, or -1 to 1
    std::vector<float> numbers;  // vertex by vertex
  };
  std::map<std::string, Values> attributes;  // by name, see decodeDraco()
  std::vector<std::uint32_t> indices;        // three per triangle
};

// Decodes the attributes with these ids; `ids` maps each attribute's name to its id. Throws Error if the bytes are
// damaged. Damaged bytes can require any amount of memory: callers decode untrusted bytes in a child process first
// (assets/meshes/child_process.h).
DracoMesh decodeDraco(std::string_view bytes, const std::map<std::string, std::uint32_t>& ids);

}  // namespace scanmill::gltf
