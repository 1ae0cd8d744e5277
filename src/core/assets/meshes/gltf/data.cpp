#include "assets/meshes/gltf/data.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>

#include "assets/meshes/base_color.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/input_budget.h"
#include "formats/text_rows.h"
#include "scene/texture.h"

namespace scanmill::gltf {
namespace {

// Largest number of values of an accessor without data. Its values are all zero and take no bytes of the file.
constexpr std::uint64_t kMostZeroes = std::uint64_t{1} << 24;
// Largest number of bytes that one compressed byte of a view may decode to.
constexpr std::uint64_t kMostExpansion = 4096;

// Returns one number of an accessor, read from its bytes. `normalized`: see Data::floats(); it has no effect if
// `Number` is an integer.
template <class Number>
Number readNumber(const char* bytes, const Component& component, bool normalized) {
  return visitNumberType(component.kind, component.size, [&]<class Stored>(Stored value) {
    std::memcpy(&value, bytes, sizeof value);
    if constexpr (std::is_floating_point_v<Number> && !std::is_floating_point_v<Stored>) {
      if (normalized) {
        return std::max(static_cast<Number>(value) / static_cast<Number>(std::numeric_limits<Stored>::max()),
                        static_cast<Number>(-1));
      }
    }
    return static_cast<Number>(value);
  });
}

// Returns the values of an attribute, in the order of the mesh's points. Throws Error if the values are damaged.
DracoMesh::Values valuesOf(const draco::Mesh& mesh, const draco::PointAttribute& attribute) {
  DracoMesh::Values values;
  const std::size_t width = attribute.num_components();
  values.normalized = attribute.normalized();
  values.numbers.resize(mesh.num_points() * width);
  for (std::uint32_t point = 0; point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(point));
    if (index.value() >= attribute.size() ||
        !attribute.ConvertValue<float>(index, static_cast<std::int8_t>(width), &values.numbers[point * width])) {
      throw Error("Draco attributes are damaged");
    }
  }
  return values;
}

// Returns an image's name for rules: its URI; for an embedded image, its `name` or, without a name, "*" and its index.
std::string labelOf(const Model& model, Index imageIndex) {
  const auto& [name, uri, view] = model.images[imageIndex];
  if (!uri.empty() && !uri.starts_with("data:")) return uri;
  return name.empty() ? fmt::format("*{}", imageIndex) : name;
}

// Loads the image with this index; see ColorImages::load().
std::shared_ptr<const Texture> load(const Model& model, const Data& data, Index imageIndex, ColorImages::Need need,
                                    ColorImages& images) {
  const Image& image = model.images[imageIndex];
  const std::string label = labelOf(model, imageIndex);
  std::function<std::shared_ptr<const Texture>()> embedded;
  if (image.view || image.uri.starts_with("data:")) {
    embedded = [&] {
      const std::string imageName = model.file.string() + ": " + label;
      return image.view ? decodeTexture(data.view(*image.view), imageName)
                        : decodeTexture(data.embedded(image.uri, label), imageName);
    };
  }
  return images.load(std::to_string(imageIndex), label, need, embedded);
}

std::optional<float> alphaCutoffOf(const Material& material, AlphaUse use) {
  if (use == AlphaUse::Ignore || (use == AlphaUse::Auto && material.alpha == Material::Alpha::Opaque)) return {};
  if (material.alpha != Material::Alpha::Mask) return kUsualAlphaCutoff;
  // glTF compares the cutoff with the product of the colour factor's alpha and the texture's alpha.
  const double factor = fraction(material.color[3], 1.0);
  if (factor > 0 && std::isfinite(material.cutoff)) return static_cast<float>(material.cutoff / factor);
  constexpr float kAboveAllAlphas = 2;
  return material.cutoff > 0 ? kAboveAllAlphas : 0.0f;
}

// True if the alpha of more than half of the texels is neither near 0 nor near 1. An alpha test then removes or keeps
// surfaces that should fade.
bool fades(const Texture& image) {
  std::size_t gradedTexels = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) gradedTexels += isGradedAlpha(image.rgba[i]) ? 1 : 0;
  return gradedTexels > image.rgba.size() / 4 / 2;
}

// Multiplies the loaded image by the factor's hue (the factor with its largest channel scaled to 1), and sets all
// channels of the factor to the largest: multiplied by a dark factor, the 8-bit image would lose gradations.
void giveHueToImage(BaseColor& color, ColorImages& images) {
  if (color.factor[1] == color.factor[0] && color.factor[2] == color.factor[0]) return;
  const float largest = std::ranges::max(color.factor);
  std::array<float, 3> hue = color.factor;
  for (float& channel : hue) channel /= largest;
  color.image = images.tinted(color.image, hue);
  color.factor = {largest, largest, largest};
}

// Returns a material with its images. `source`: the source of its colour if the material has no image; None for the
// default material, which primitives without a material get.
ReadMaterial read(const Model& model, const Data& data, const Material& material, BaseColor::Source source,
                  const AssetOptions& options, ColorImages& images) {
  ReadMaterial result;
  result.leftOut = material.leftOut;
  result.material = result.fileMaterial.name = material.name;
  result.fileMaterial.source = "base colour of " + model.file.filename().string();
  result.fileMaterial.roughness = static_cast<float>(fraction(material.roughness, 1.0));
  result.fileMaterial.metallic = static_cast<float>(fraction(material.metallic, 0.0));
  BaseColor color{.source = source, .alphaCutoff = alphaCutoffOf(material, options.alpha)};
  for (std::size_t c = 0; c < 3; ++c) color.factor[c] = static_cast<float>(fraction(material.color[c], 1.0));
  result.color = color.factor;
  if (material.texture) {
    result.placed = material.texture;
    result.texture = labelOf(model, material.texture->image);
    color.source = BaseColor::Source::Image;
    const auto need = options.textures ? ColorImages::Need::AnyImage : ColorImages::Need::ImageWithAlpha;
    if (options.textures || color.alphaCutoff) {
      color.image = load(model, data, material.texture->image, need, images);
    }
  }
  if (color.image) giveHueToImage(color, images);
  // Without textures, parts lack the image to which giveHueToImage() has moved the hue: they keep the original factor.
  if (color.image && options.textures) result.color = color.factor;
  const bool isBlended = material.alpha == Material::Alpha::Blend;
  if (isBlended && options.alpha == AlphaUse::Auto && color.image && color.image->hasAlpha && fades(*color.image)) {
    result.leftOut.add("images that fade (beams pass where alpha is below 0.5)");
  }
  setColor(result.fileMaterial, color, model.file, options, images);
  const bool isMaskedByFactor = material.alpha == Material::Alpha::Mask && material.color[3] < material.cutoff &&
                                !result.fileMaterial.alphaTested;
  if ((isMaskedByFactor || (isBlended && material.color[3] < 1)) && options.alpha != AlphaUse::Ignore) {
    result.leftOut.add("opacities of materials (they are solid)");
  }
  return result;
}

}  // namespace

Data::Data(const Model& model) : model_(model), buffers_(model.buffers.size()), decoded_(model.views.size()) {}

std::string_view Data::buffer(Index index) const {
  const Buffer& described = model_.buffers[index];
  if (!described.problem.empty()) model_.fail("{}", described.problem);
  if (described.uri.empty()) return model_.bin;
  std::optional<std::string>& bytes = buffers_[index];
  if (!bytes) {
    bytes = described.uri.starts_with("data:") ? embedded(described.uri, fmt::format("buffers[{}]", index))
                                               : readFile(model_.file.parent_path() / described.uri);
  }
  return *bytes;
}

std::string_view Data::bytesOf(Index index, std::uint64_t offset, std::uint64_t length) const {
  const std::string_view bytes = buffer(index);
  if (offset + length > bytes.size()) model_.fail("is truncated: buffers[{}] has {} bytes", index, bytes.size());
  return bytes.substr(offset, length);
}

std::string Data::decode(const Meshopt& meshopt, const std::string& what) const {
  if (!meshopt.problem.empty()) model_.fail("{}", meshopt.problem);
  const std::string_view compressed = bytesOf(meshopt.buffer, meshopt.offset, meshopt.length);
  const std::uint64_t size = meshopt.count * meshopt.stride;
  if (size > kMostExpansion * (meshopt.length + 1)) {
    model_.fail("is damaged: {} has {} elements in {} bytes", what, meshopt.count, meshopt.length);
  }
  chargeBytes(static_cast<double>(size), {model_.file.string()});
  std::string decoded(size, '\0');
  const auto* const bytes = reinterpret_cast<const unsigned char*>(compressed.data());
  if (meshopt.decode(decoded.data(), meshopt.count, meshopt.stride, bytes, compressed.size()) != 0) {
    model_.fail("has {} with compressed data that is damaged or of an unknown version: export it without compression",
                what);
  }
  if (meshopt.filter != nullptr) meshopt.filter(decoded.data(), meshopt.count, meshopt.stride);
  return decoded;
}

template <class Number>
std::vector<Number> Data::numbers(Index index, const std::string& what) const {
  const Accessor& accessor = model_.accessors[index];
  const std::size_t width = accessor.width;
  const std::uint64_t count = accessor.count;
  if (!accessor.view && count > kMostZeroes / width) {
    model_.fail("is damaged: {} has {} elements without data", what, count);
  }
  // Gets the bytes before the output is allocated, so that a bad view throws first.
  const std::string_view bytes = accessor.view ? view(*accessor.view).substr(accessor.offset) : std::string_view();
  std::vector<Number> numbers(count * width, 0);
  const auto readElement = [&](const char* elementBytes, std::size_t element) {
    for (std::size_t k = 0; k < width; ++k) {
      numbers[element * width + k] =
          readNumber<Number>(elementBytes + k * accessor.component.size, accessor.component, accessor.normalized);
    }
  };
  if (accessor.view) {
    const std::uint64_t statedStride = model_.views[*accessor.view].stride;
    const std::size_t stride = statedStride > 0 ? statedStride : accessor.component.size * width;
    for (std::size_t i = 0; i < count; ++i) readElement(bytes.data() + i * stride, i);
  }
  if (accessor.sparse) {
    const std::string_view indices = view(accessor.sparse->indicesView).substr(accessor.sparse->indicesOffset);
    const std::string_view values = view(accessor.sparse->valuesView).substr(accessor.sparse->valuesOffset);
    for (std::size_t i = 0; i < accessor.sparse->count; ++i) {
      const auto element = readNumber<std::uint32_t>(indices.data() + i * accessor.sparse->indices.size,
                                                     accessor.sparse->indices, false);
      if (element >= count) model_.fail("is not valid glTF: {} replaces the element {} of {}", what, element, count);
      readElement(values.data() + i * accessor.component.size * width, element);
    }
  }
  return numbers;
}

std::vector<float> Data::floats(Index accessor, const std::string& what) const {
  return numbers<float>(accessor, what);
}

std::vector<float> Data::finiteFloats(Index accessor, const std::string& what) const {
  std::vector<float> numbers = floats(accessor, what);
  if (!std::ranges::all_of(numbers, [](float number) { return std::isfinite(number); })) {
    model_.fail("is damaged: {} has numbers that are not finite", what);
  }
  return numbers;
}

std::vector<float> Data::fractions(Index accessor, const std::string& what) const {
  const Accessor& described = model_.accessors[accessor];
  if (described.component.kind != 'F' && !described.normalized) {
    model_.fail("is not valid glTF: {} must have floating-point or normalised numbers, not whole numbers", what);
  }
  return finiteFloats(accessor, what);
}

std::vector<std::uint32_t> Data::integers(Index accessor, const std::string& what) const {
  if (model_.accessors[accessor].component.kind != 'U') {
    model_.fail("is not valid glTF: {} must have unsigned whole numbers", what);
  }
  return numbers<std::uint32_t>(accessor, what);
}

std::string_view Data::view(Index index) const {
  const View& view = model_.views[index];
  if (!view.compressed) return bytesOf(view.buffer, view.offset, view.length);
  std::optional<std::string>& bytes = decoded_[index];
  if (!bytes) bytes = decode(*view.compressed, fmt::format("bufferViews[{}]", index));
  return *bytes;
}

std::string Data::embedded(const std::string& uri, const std::string& what) const {
  if (uri.size() > kMostBase64) {
    model_.fail("has more than 1 GiB of base64 in {}: put the data in a file beside it", what);
  }
  const std::size_t comma = uri.find(',');
  std::optional<std::string> bytes;
  if (comma != std::string::npos) bytes = fromBase64(std::string_view(uri).substr(comma + 1));
  if (!bytes) model_.fail("is not valid glTF: the data of {} are not base64", what);
  return std::move(*bytes);
}

DracoMesh decodeDraco(std::string_view bytes, const std::map<std::string, std::uint32_t>& ids) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) throw Error("Draco: {}", decoded.status().error_msg_string());
  const draco::Mesh& mesh = *decoded.value();
  DracoMesh decodedMesh;
  for (const auto& [name, id] : ids) {
    const draco::PointAttribute* const attribute = mesh.GetAttributeByUniqueId(id);
    if (attribute == nullptr) throw Error("Draco: the attribute {} ({}) is missing", id, name);
    decodedMesh.attributes[name] = valuesOf(mesh, *attribute);
  }
  decodedMesh.indices.reserve(mesh.num_faces() * std::size_t{3});
  for (std::uint32_t face = 0; face < mesh.num_faces(); ++face) {
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(face))) {
      decodedMesh.indices.push_back(corner.value());
    }
  }
  return decodedMesh;
}

std::vector<ReadMaterial> readMaterials(const Model& model, const Data& data, const AssetOptions& options) {
  ColorImages images(model.file, options.allowOutside, options.textureFolders);
  std::vector<ReadMaterial> materials;
  materials.reserve(model.materials.size() + 1);
  using enum BaseColor::Source;
  for (const Material& material : model.materials) {
    materials.push_back(read(model, data, material, Factor, options, images));
  }
  materials.push_back(read(model, data, Material(), None, options, images));
  return materials;
}

}  // namespace scanmill::gltf
