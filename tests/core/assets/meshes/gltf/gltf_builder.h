#pragma once

// glTF files under construction, their numbers in one buffer.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/hash.h"
#include "tests/core/assets/meshes/triangle_files.h"

namespace scanmill {

struct GltfBuilder {
  nlohmann::json json{{"asset", {{"version", "2.0"}}},
                      {"scene", 0},
                      {"bufferViews", nlohmann::json::array()},
                      {"accessors", nlohmann::json::array()}};
  std::string bytes;

  std::size_t view(const std::string& data) {
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", data.size()}});
    bytes += data;
    return json["bufferViews"].size() - 1;
  }

  template <class T>
  std::size_t numbers(const std::vector<T>& values, const char* type, std::size_t width, int kind = 5126,
                      bool normalized = false) {
    json["accessors"].push_back({{"bufferView", view(bytesOf(values))},
                                 {"componentType", kind},
                                 {"type", type},
                                 {"count", values.size() / width}});
    if (normalized) json["accessors"].back()["normalized"] = true;
    return json["accessors"].size() - 1;
  }

  std::string text() {
    json["buffers"][0] = {{"byteLength", bytes.size()},
                          {"uri", "data:application/octet-stream;base64," + base64(bytes)}};
    return json.dump();
  }
};

}  // namespace scanmill
