#pragma once

// The files of glTF 2.0: .gltf, which is JSON; .glb, which contains JSON and binary data; and .b3dm of 3D Tiles 1.0,
// which contains a .glb. And checked access to the JSON, for the readers of this folder.

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

// Reads a file's JSON into a model. All functions throw an InputError that names the file. `path` names the JSON value
// in the message, such as "meshes[0].primitives[1]".
class JsonReader {
 protected:
  JsonReader(Model& model, const Json& json) : model_(model), json_(json) {}

  [[noreturn]] void fail(const std::string& problem) const { model_.fail(problem); }

  const Json& list(const char* key) const { return listIn(json_, key, key); }

  // Returns the list under a key; an empty list if the key is absent.
  const Json& listIn(const Json& object, const char* key, const std::string& path) const {
    static const Json kEmpty = Json::array();
    const auto value = object.find(key);
    if (value == object.end()) return kEmpty;
    if (!value->is_array()) fail(fmt::format("is not valid glTF: '{}' is not a list", path));
    return *value;
  }

  // Appends read(object, path) for each object of the file's list under a key.
  template <class T, class Read>
  void each(const char* key, std::vector<T>& into, const Read& read) {
    const Json& objects = list(key);
    into.reserve(objects.size());
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const std::string path = fmt::format("{}[{}]", key, i);
      if (!objects[i].is_object()) fail(fmt::format("is not valid glTF: {} is not an object", path));
      into.push_back(read(objects[i], path));
    }
  }

  // Returns a value that must be an index below `count`.
  Index readIndex(const Json& value, std::size_t count, const std::string& path) const {
    if (!value.is_number_unsigned()) fail(fmt::format("is not valid glTF: {} is not an index", path));
    const std::uint64_t i = value.get<std::uint64_t>();
    if (i >= count) fail(fmt::format("is not valid glTF: {} is {}, but only {} exist", path, i, count));
    return i;
  }

  MaybeIndex readOptionalIndex(const Json& object, const char* key, std::size_t count, const std::string& path) const {
    const auto value = object.find(key);
    return value == object.end() ? std::nullopt : MaybeIndex(readIndex(*value, count, path + "." + key));
  }

  std::uint64_t readLength(const Json& object, const char* key, std::uint64_t fallback, const std::string& path) const {
    const auto value = object.find(key);
    if (value == object.end()) return fallback;
    // Sums of a few lengths must not overflow.
    if (!value->is_number_unsigned() || value->get<std::uint64_t>() > UINT64_MAX / 4) {
      fail(fmt::format("is not valid glTF: {}.{} is not a length", path, key));
    }
    return value->get<std::uint64_t>();
  }

  // Reads a list of `size` numbers. Returns false, without a change of `into`, if the key is absent.
  template <std::size_t size>
  bool readNumbers(const Json& object, const char* key, const std::string& path, std::array<double, size>& into) const {
    const auto value = object.find(key);
    if (value == object.end()) return false;
    const bool fits = value->is_array() && value->size() == size &&
                      std::all_of(value->begin(), value->end(), [](const Json& n) { return n.is_number(); });
    if (!fits) fail(fmt::format("{}.{} is not {} numbers", path, key, size));
    into = value->get<std::array<double, size>>();
    return true;
  }

  // Returns the extension with this name; null if the object does not have it.
  const Json* extensionOf(const Json& object, const char* name) const {
    const auto extensions = object.find("extensions");
    return extensions == object.end() ? nullptr : objectIn(*extensions, name);
  }

  // Returns the object under a key; null if the key is absent.
  const Json* objectIn(const Json& object, const char* key) const {
    const auto value = object.find(key);
    if (value == object.end()) return nullptr;
    if (!value->is_object()) fail(fmt::format("is not valid glTF: a '{}' is not an object", key));
    return &*value;
  }

  Model& model_;
  const Json& json_;
};

struct Container {
  std::string json;
  std::string bin;              // the GLB's binary chunk
  std::optional<Vec3d> center;  // m, RTC_CENTER of a .b3dm, z up
  bool batchTable = false;      // true if a .b3dm has a batch table with properties
};

// Reads a file. Throws an InputError that calls the file `name` if the .b3dm or its GLB is damaged, or if the GLB is of
// glTF 1.0.
Container readContainer(const std::filesystem::path& file, const std::filesystem::path& name);

// Reads buffers, views and accessors into the model and checks them. Model::bin and Model::file must be set before.
// `allowOutside`: see AssetOptions.
void readStorage(Model& model, const Json& json, bool allowOutside);

}  // namespace scanmill::gltf
