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

// All functions throw an InputError that names the file. `what` names the JSON value in the message.
class JsonReader {
 protected:
  JsonReader(Model& model, const Json& json) : m_(model), json_(json) {}

  [[noreturn]] void fail(const std::string& what) const { m_.fail(what); }

  const Json& list(const char* key) const { return listIn(json_, key, key); }

  // Returns the list under a key; an empty list if the key is absent.
  const Json& listIn(const Json& object, const char* key, const std::string& what) const {
    static const Json kNone = Json::array();
    const auto found = object.find(key);
    if (found == object.end()) return kNone;
    if (!found->is_array()) fail(fmt::format("is not valid glTF: '{}' is not a list", what));
    return *found;
  }

  template <class T, class Make>
  void each(const char* key, std::vector<T>& into, const Make& make) {
    const Json& all = list(key);
    into.reserve(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::string what = fmt::format("{}[{}]", key, i);
      if (!all[i].is_object()) fail(fmt::format("is not valid glTF: {} is not an object", what));
      into.push_back(make(all[i], what));
    }
  }

  Index index(const Json& value, std::size_t count, const std::string& what) const {
    if (!value.is_number_unsigned()) fail(fmt::format("is not valid glTF: {} is not an index", what));
    const std::uint64_t i = value.get<std::uint64_t>();
    if (i >= count) fail(fmt::format("is not valid glTF: {} is {}, but only {} exist", what, i, count));
    return i;
  }

  MaybeIndex maybe(const Json& object, const char* key, std::size_t count, const std::string& what) const {
    const auto found = object.find(key);
    if (found == object.end()) return std::nullopt;
    return index(*found, count, what + "." + key);
  }

  std::uint64_t length(const Json& object, const char* key, std::uint64_t fallback, const std::string& what) const {
    const auto found = object.find(key);
    if (found == object.end()) return fallback;
    if (!found->is_number_unsigned() || found->get<std::uint64_t>() > UINT64_MAX / 4) {
      fail(fmt::format("is not valid glTF: {}.{} is not a length", what, key));
    }
    return found->get<std::uint64_t>();
  }

  template <std::size_t size>
  bool numbers(const Json& object, const char* key, const std::string& what, std::array<double, size>& into) const {
    const auto found = object.find(key);
    if (found == object.end()) return false;
    const bool fits = found->is_array() && found->size() == size &&
                      std::all_of(found->begin(), found->end(), [](const Json& n) { return n.is_number(); });
    if (!fits) fail(fmt::format("{}.{} is not {} numbers", what, key, size));
    for (std::size_t i = 0; i < size; ++i) into[i] = (*found)[i].get<double>();
    return true;
  }

  // Returns the extension with this name; null if the object does not have it.
  const Json* extensionOf(const Json& object, const char* name) const {
    const auto all = object.find("extensions");
    return all == object.end() ? nullptr : objectIn(*all, name);
  }

  const Json* objectIn(const Json& object, const char* name) const {
    const auto found = object.find(name);
    if (found == object.end()) return nullptr;
    if (!found->is_object()) fail(fmt::format("is not valid glTF: a '{}' is not an object", name));
    return &*found;
  }
  Model& m_;
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
