#pragma once

// Reads the files of glTF 2.0: .gltf, which is JSON; .glb, which contains JSON and binary data; and .b3dm of 3D Tiles
// 1.0, which contains a .glb. Checks each access to the JSON.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "assets/meshes/gltf/model.h"

namespace scanmill::gltf {

using Json = nlohmann::json;

// An object of a file's JSON with its path in the file for messages, such as "meshes[0].primitives[1]". All functions
// throw an InputError that names the file.
struct JsonObject {
  const Model& model;
  const Json& json;
  std::string path;

  [[noreturn]] void fail(const std::string& problem) const { model.fail("{} {}", path, problem); }
  template <class... Values>
  [[noreturn]] void failInvalid(fmt::format_string<Values...> problem, Values&&... values) const {
    model.fail("is not valid glTF: {} {}", path, fmt::format(problem, std::forward<Values>(values)...));
  }
  std::string pathOf(const char* key) const { return path.empty() ? key : path + "." + key; }

  // Returns the list under a key; an empty list if the key is absent. `name`: the list's name in messages.
  const Json& list(const char* key, const std::string& name) const {
    static const Json kEmpty = Json::array();
    const auto value = json.find(key);
    if (value == json.end()) return kEmpty;
    if (!value->is_array()) model.fail("is not valid glTF: '{}' is not a list", name);
    return *value;
  }
  const Json& list(const char* key) const { return list(key, pathOf(key)); }

  // Returns `value` as an index. Throws unless it is an index below `count`. `name`: the value's name in messages.
  Index index(const Json& value, std::size_t count, const std::string& name) const {
    const JsonObject named{model, value, name};
    if (!value.is_number_unsigned()) named.failInvalid("is not an index");
    const std::uint64_t i = value.get<std::uint64_t>();
    if (i >= count) named.failInvalid("is {}, but only {} exist", i, count);
    return i;
  }
  Index index(const char* key, std::size_t count) const { return index(json.at(key), count, pathOf(key)); }
  MaybeIndex maybeIndex(const char* key, std::size_t count) const {
    return json.contains(key) ? MaybeIndex(index(key, count)) : std::nullopt;
  }

  // Returns the number of bytes or elements under a key; the fallback if the key is absent.
  std::uint64_t length(const char* key, std::uint64_t fallback = 0) const {
    const auto value = json.find(key);
    if (value == json.end()) return fallback;
    // Larger lengths are refused, so that sums of a few lengths do not overflow.
    if (!value->is_number_unsigned() || value->get<std::uint64_t>() > UINT64_MAX / 4) {
      model.fail("is not valid glTF: {} is not a length", pathOf(key));
    }
    return value->get<std::uint64_t>();
  }

  // Reads a list of `size` numbers into `into`. Returns false and leaves `into` unchanged if the key is absent.
  template <std::size_t size>
  bool numbers(const char* key, std::array<double, size>& into) const {
    const auto value = json.find(key);
    if (value == json.end()) return false;
    const bool fits = value->is_array() && value->size() == size &&
                      std::all_of(value->begin(), value->end(), [](const Json& n) { return n.is_number(); });
    if (!fits) model.fail("{} is not {} numbers", pathOf(key), size);
    into = value->get<std::array<double, size>>();
    return true;
  }

  // Returns the object under a key; nullopt if the key is absent. Messages call it by the path of *this.
  std::optional<JsonObject> object(const char* key) const {
    const auto value = json.find(key);
    if (value == json.end()) return std::nullopt;
    if (!value->is_object()) model.fail("is not valid glTF: a '{}' is not an object", key);
    return JsonObject{model, *value, path};
  }
  std::optional<JsonObject> extension(const char* name) const {
    const auto extensions = json.find("extensions");
    return extensions == json.end() ? std::nullopt : JsonObject{model, *extensions, path}.object(name);
  }
};

// Appends read(object) to `into` for each object of the list that `file` has under a key.
template <class T, class Read>
void readEach(const JsonObject& file, const char* key, std::vector<T>& into, const Read& read) {
  const Json& objects = file.list(key);
  into.reserve(objects.size());
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const JsonObject object{file.model, objects[i], fmt::format("{}[{}]", key, i)};
    if (!objects[i].is_object()) object.failInvalid("is not an object");
    into.push_back(read(object));
  }
}

// Reads a file and returns its JSON. Sets Model::bin, and Model::center to the RTC_CENTER of a .b3dm. Messages call the
// file Model::file. Throws an InputError if the .b3dm or its GLB is damaged, or if the GLB is of glTF 1.0.
std::string readContainer(const std::filesystem::path& file, Model& model);

// Reads the buffers, views and accessors of `file` into `model`, the model of the same file, and checks them.
// Model::bin and Model::file must be set before. `allowOutside`: see AssetOptions.
void readStorage(Model& model, const JsonObject& file, bool allowOutside);

}  // namespace scanmill::gltf
