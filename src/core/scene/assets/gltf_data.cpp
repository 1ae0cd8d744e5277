#include "scene/assets/gltf_data.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <type_traits>

#include "base/base64.h"
#include "base/error.h"
#include "base/file.h"
#include "config/fields.h"

namespace scanmill {
namespace {

using Json = nlohmann::json;

std::size_t componentsOf(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "MAT4") return 16;
  if (type == "MAT3") return 9;
  return type == "VEC2" ? 2 : type == "VEC3" ? 3 : 4;
}

// An integer as a float, as glTF 2.0 has it in 3.6.2.2.
template <class T>
float numberAt(const char* at, bool normalised) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  const auto number = static_cast<float>(value);
  if constexpr (std::is_floating_point_v<T>) return number;
  return normalised ? std::max(number / static_cast<float>(std::numeric_limits<T>::max()), -1.0f) : number;
}

}  // namespace

struct GltfData::State {
  const GltfContainer& container;
  std::filesystem::path file;
  Json json;
  std::vector<std::optional<std::string>> loaded;  // by buffer

  [[noreturn]] void fail(const std::string& what) const { throw InputError({file.string()}, what); }

  std::string_view bytesOf(std::size_t buffer) {
    const Json& described = json["buffers"][buffer];
    if (!described.contains("uri")) return container.bin;
    if (loaded.size() <= buffer) loaded.resize(buffer + 1);
    std::optional<std::string>& bytes = loaded[buffer];
    if (!bytes) {
      const std::string uri = described["uri"].get<std::string>();
      if (uri.starts_with("data:")) {
        bytes = fromBase64(std::string_view(uri).substr(uri.find(',') + 1));
        if (!bytes) fail(fmt::format("is not valid glTF: the data of buffers[{}] are not base64", buffer));
      } else {
        bytes = readFile(file.parent_path() / uri);
      }
    }
    return *bytes;
  }

  std::vector<float> numbers(std::size_t index, const std::string& what, bool whole) {
    if (index >= json["accessors"].size()) {
      fail(fmt::format("is not valid glTF: {} names an accessor that is not there", what));
    }
    const Json& accessor = json["accessors"][index];
    const std::size_t width = componentsOf(accessor["type"].get<std::string>());
    const auto count = accessor.value("count", std::size_t{0});
    constexpr std::size_t kMostZeroes = std::size_t{1} << 24;  // that a file may have without a byte for them
    const bool zeroes = !accessor.contains("bufferView");
    if (zeroes && count > kMostZeroes / width) {
      fail(fmt::format("is damaged: {} has {} elements without data", what, count));
    }
    std::vector<float> out(count * width, 0);
    if (zeroes) return out;
    const int kind = accessor["componentType"].get<int>();
    const bool normalised = !whole && accessor.value("normalized", false);
    if (whole && kind != 5121 && kind != 5123) {
      fail(fmt::format("is not valid glTF: {} has joints that are no whole numbers of 8 or 16 bits", what));
    }
    if (!whole && kind != 5126 && !normalised) {
      fail(fmt::format("is not valid glTF: {} has whole numbers where there should be others", what));
    }
    const std::size_t size = kind == 5120 || kind == 5121 ? 1 : kind == 5122 || kind == 5123 ? 2 : 4;
    const Json& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::string_view bytes = bytesOf(view["buffer"].get<std::size_t>());
    const std::size_t start = view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
    const std::size_t stride = view.value("byteStride", size * width);
    if (count > 0 && start + (count - 1) * stride + size * width > bytes.size()) {
      fail(fmt::format("is truncated: {} reaches beyond its buffer", what));
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < width; ++k) {
        const char* const at = bytes.data() + start + i * stride + k * size;
        float& number = out[i * width + k];
        switch (kind) {
          case 5120:
            number = numberAt<std::int8_t>(at, normalised);
            break;
          case 5121:
            number = numberAt<std::uint8_t>(at, normalised);
            break;
          case 5122:
            number = numberAt<std::int16_t>(at, normalised);
            break;
          case 5123:
            number = numberAt<std::uint16_t>(at, normalised);
            break;
          case 5125:
            number = numberAt<std::uint32_t>(at, normalised);
            break;
          default:
            number = numberAt<float>(at, false);
        }
      }
    }
    if (!std::all_of(out.begin(), out.end(), [](float v) { return std::isfinite(v); })) {
      fail(fmt::format("is damaged: {} has numbers that are not finite", what));
    }
    return out;
  }
};

GltfData::GltfData(const GltfContainer& container, const std::filesystem::path& file)
    : state_(std::make_unique<State>(State{container, file, Json::parse(container.json), {}})) {}
GltfData::~GltfData() = default;

std::vector<float> GltfData::floats(std::size_t accessor, const std::string& what) {
  return state_->numbers(accessor, what, false);
}

std::vector<float> GltfData::indices(std::size_t accessor, const std::string& what) {
  return state_->numbers(accessor, what, true);
}

std::vector<std::string> GltfData::clips() const {
  std::vector<std::string> names;
  const auto animations = state_->json.find("animations");
  const std::size_t count = animations != state_->json.end() && animations->is_array() ? animations->size() : 0;
  for (std::size_t i = 0; i < count; ++i) names.push_back((*animations)[i].value("name", std::to_string(i)));
  return names;
}

std::size_t GltfData::clip(const std::string& name) const {
  const std::vector<std::string> names = clips();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return i;
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::to_string(i) == name) return i;
  }
  state_->fail(names.empty() ? "has no animation"
                             : fmt::format("has no animation '{}'{}", name, suggestion(name, names)));
}

std::pair<double, double> GltfData::spanOf(std::size_t clip) {
  const Json& animation = state_->json["animations"][clip];
  double first = std::numeric_limits<double>::infinity();
  double last = 0;
  for (const Json& sampler : animation.at("samplers")) {
    const Json& input = sampler.at("input");
    const std::size_t accessor = input.is_number_unsigned() ? input.get<std::size_t>() : SIZE_MAX;
    for (const float time : floats(accessor, fmt::format("animations[{}]", clip))) {
      first = std::min(first, static_cast<double>(time));
      last = std::max(last, static_cast<double>(time));
    }
  }
  if (!(first <= last)) state_->fail(fmt::format("is not valid glTF: animations[{}] has no key frames", clip));
  return {first, last};
}

}  // namespace scanmill
