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
#include "assets/meshes/references.h"
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

template <class Number>
Number readNumber(const char* at, const Component& component, bool normalized) {
  return visitNumberType(component.kind, component.size, [&]<class Stored>(Stored value) {
    std::memcpy(&value, at, sizeof value);
    if constexpr (std::is_floating_point_v<Number> && !std::is_floating_point_v<Stored>) {
      if (normalized) {
        return std::max(static_cast<Number>(value) / static_cast<Number>(std::numeric_limits<Stored>::max()),
                        static_cast<Number>(-1));
      }
    }
    return static_cast<Number>(value);
  });
}

DracoMesh::Values valuesOf(const draco::Mesh& mesh, const draco::PointAttribute& attribute) {
  DracoMesh::Values values;
  const std::size_t width = attribute.num_components();
  values.normalized = attribute.normalized();
  values.numbers.resize(mesh.num_points() * width);
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    if (value.value() >= attribute.size() ||
        !attribute.ConvertValue<float>(value, static_cast<std::int8_t>(width), &values.numbers[i * width])) {
      throw Error("Draco attributes are damaged");
    }
  }
  return values;
}

// Returns the name of an image for rules: its file; for an embedded image its name, or "*" and its number.
std::string labelOf(const Model& model, Index image) {
  const Image& i = model.images[image];
  if (!i.uri.empty() && !i.uri.starts_with("data:")) return i.uri;
  return i.name.empty() ? fmt::format("*{}", image) : i.name;
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

// Returns BaseColor::alphaCutoff for a material.
std::optional<float> alphaCutoffOf(const Material& material, AlphaUse use) {
  if (use == AlphaUse::Ignore || (use == AlphaUse::Auto && material.alpha == Material::Alpha::Opaque)) return {};
  if (material.alpha != Material::Alpha::Mask) return kUsualAlphaCutoff;
  // glTF compares the cutoff with the product of the colour factor's alpha and the texture's alpha.
  const double factor = fraction(material.color[3], 1.0);
  if (factor > 0 && std::isfinite(material.cutoff)) return static_cast<float>(material.cutoff / factor);
  constexpr float kAboveAllAlphas = 2;
  return material.cutoff > 0 ? kAboveAllAlphas : 0.0f;
}

// True if more than half of the image's alpha is neither near 0 nor near 1, so that a test of alpha removes or keeps
// what fades.
bool fades(const Texture& image) {
  std::size_t gradedTexels = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) gradedTexels += isGradedAlpha(image.rgba[i]) ? 1 : 0;
  return gradedTexels > image.rgba.size() / 4 / 2;
}

// Multiplies the loaded image by the hue of the factor. The factor becomes the grey of its largest channel: in 8 bits,
// images multiplied by dark factors would lose steps.
void giveHueToImage(BaseColor& color, ColorImages& images) {
  if (color.factor[1] == color.factor[0] && color.factor[2] == color.factor[0]) return;
  const float largest = std::ranges::max(color.factor);
  std::array<float, 3> hue = color.factor;
  for (float& channel : hue) channel /= largest;
  color.image = images.tinted(color.image, hue);
  color.factor = {largest, largest, largest};
}

// Returns a material with its images. `source`: of its colour if it has no image, None for the default material of
// primitives without a material.
ReadMaterial read(const Model& model, const Data& data, const Material& material, BaseColor::Source source,
                  const AssetOptions& options, ColorImages& images) {
  ReadMaterial read;
  read.leftOut = material.leftOut;
  read.material = read.fileMaterial.name = material.name;
  read.fileMaterial.source = "base colour of " + model.file.filename().string();
  read.fileMaterial.roughness = static_cast<float>(fraction(material.roughness, 1.0));
  read.fileMaterial.metallic = static_cast<float>(fraction(material.metallic, 0.0));
  BaseColor color{.source = source, .alphaCutoff = alphaCutoffOf(material, options.alpha)};
  for (std::size_t c = 0; c < 3; ++c) color.factor[c] = static_cast<float>(fraction(material.color[c], 1.0));
  read.color = color.factor;
  if (material.texture) {
    read.placed = material.texture;
    read.texture = labelOf(model, material.texture->image);
    color.source = BaseColor::Source::Image;
    const auto need = options.textures ? ColorImages::Need::AnyImage : ColorImages::Need::ImageWithAlpha;
    if (options.textures || color.alphaCutoff) {
      color.image = load(model, data, material.texture->image, need, images);
    }
  }
  if (color.image) giveHueToImage(color, images);
  if (color.image && options.textures) read.color = color.factor;
  const bool isBlended = material.alpha == Material::Alpha::Blend;
  if (isBlended && options.alpha == AlphaUse::Auto && color.image && color.image->hasAlpha && fades(*color.image)) {
    read.leftOut.add("images that fade (beams pass where alpha is below 0.5)");
  }
  setColor(read.fileMaterial, color, model.file, options, images);
  const bool isMaskedByFactor =
      material.alpha == Material::Alpha::Mask && material.color[3] < material.cutoff && !read.fileMaterial.alphaTested;
  if ((isMaskedByFactor || (isBlended && material.color[3] < 1)) && options.alpha != AlphaUse::Ignore) {
    read.leftOut.add("opacities of materials (they are solid)");
  }
  return read;
}

}  // namespace

Data::Data(const Model& model) : model_(model), buffers_(model.buffers.size()), decoded_(model.views.size()) {}

std::string_view Data::buffer(Index index) const {
  const Buffer& described = model_.buffers[index];
  if (!described.problem.empty()) model_.fail(described.problem);
  if (described.uri.empty()) return model_.bin;
  std::optional<std::string>& bytes = buffers_[index];
  if (!bytes) {
    bytes = described.uri.starts_with("data:") ? embedded(described.uri, fmt::format("buffers[{}]", index))
                                               : readFile(model_.file.parent_path() / described.uri);
  }
  return *bytes;
}

std::string_view Data::part(Index index, std::uint64_t offset, std::uint64_t length) const {
  const std::string_view bytes = buffer(index);
  if (offset + length > bytes.size()) {
    model_.fail(fmt::format("is truncated: buffers[{}] has {} bytes", index, bytes.size()));
  }
  return bytes.substr(offset, length);
}

std::string Data::decode(const Meshopt& m, const std::string& what) const {
  if (!m.problem.empty()) model_.fail(m.problem);
  const std::string_view from = part(m.buffer, m.offset, m.length);
  if (m.count * m.stride > kMostExpansion * (m.length + 1)) {
    model_.fail(fmt::format("is damaged: {} has {} elements in {} bytes", what, m.count, m.length));
  }
  chargeBytes(static_cast<double>(m.count * m.stride), {model_.file.string()});
  std::string out(m.count * m.stride, '\0');
  if (m.decode(out.data(), m.count, m.stride, reinterpret_cast<const unsigned char*>(from.data()), from.size()) != 0) {
    model_.fail(fmt::format(
        "has {} with compressed data that is damaged or of an unknown version: export it without compression", what));
  }
  if (m.filter != nullptr) m.filter(out.data(), m.count, m.stride);
  return out;
}

template <class Number>
std::vector<Number> Data::numbers(Index index, const std::string& what) const {
  const Accessor& a = model_.accessors[index];
  const std::size_t size = a.component.size;
  if (!a.view && a.count > kMostZeroes / a.width) {
    model_.fail(fmt::format("is damaged: {} has {} elements without data", what, a.count));
  }
  // Get the bytes before the output is allocated, so that a bad view throws first.
  const std::string_view bytes = a.view ? view(*a.view).substr(a.offset) : std::string_view();
  std::vector<Number> out(a.count * a.width, 0);
  const auto take = [&](const char* at, std::size_t element) {
    for (std::size_t k = 0; k < a.width; ++k) {
      out[element * a.width + k] = readNumber<Number>(at + k * size, a.component, a.normalized);
    }
  };
  if (a.view) {
    const std::uint64_t stated = model_.views[*a.view].stride;
    const std::size_t stride = stated > 0 ? stated : size * a.width;
    for (std::size_t i = 0; i < a.count; ++i) take(bytes.data() + i * stride, i);
  }
  if (a.sparse) {
    const std::string_view elements = view(a.sparse->indicesView).substr(a.sparse->indicesOffset);
    const std::string_view values = view(a.sparse->valuesView).substr(a.sparse->valuesOffset);
    for (std::size_t i = 0; i < a.sparse->count; ++i) {
      const auto element =
          readNumber<std::uint32_t>(elements.data() + i * a.sparse->indices.size, a.sparse->indices, false);
      if (element >= a.count) {
        model_.fail(fmt::format("is not valid glTF: {} replaces the element {} of {}", what, element, a.count));
      }
      take(values.data() + i * size * a.width, element);
    }
  }
  return out;
}

std::vector<float> Data::floats(Index accessor, const std::string& what) const {
  return numbers<float>(accessor, what);
}

std::vector<float> Data::finiteFloats(Index accessor, const std::string& what) const {
  std::vector<float> out = floats(accessor, what);
  if (!std::all_of(out.begin(), out.end(), [](float v) { return std::isfinite(v); })) {
    model_.fail(fmt::format("is damaged: {} has numbers that are not finite", what));
  }
  return out;
}

std::vector<float> Data::fractions(Index accessor, const std::string& what) const {
  const Accessor& a = model_.accessors[accessor];
  if (a.component.kind != 'F' && !a.normalized) {
    model_.fail(
        fmt::format("is not valid glTF: {} must have floating-point or normalised numbers, not whole numbers", what));
  }
  return finiteFloats(accessor, what);
}

std::vector<std::uint32_t> Data::integers(Index accessor, const std::string& what) const {
  if (model_.accessors[accessor].component.kind != 'U') {
    model_.fail(fmt::format("is not valid glTF: {} must have unsigned whole numbers", what));
  }
  return numbers<std::uint32_t>(accessor, what);
}

std::string_view Data::view(Index view) const {
  const View& v = model_.views[view];
  if (!v.compressed) return part(v.buffer, v.offset, v.length);
  std::optional<std::string>& bytes = decoded_[view];
  if (!bytes) bytes = decode(*v.compressed, fmt::format("bufferViews[{}]", view));
  return *bytes;
}

std::string Data::embedded(const std::string& uri, const std::string& what) const {
  if (uri.size() > kMostBase64) {
    model_.fail(fmt::format("has more than 1 GiB of base64 in {}: put the data in a file beside it", what));
  }
  const std::size_t comma = uri.find(',');
  std::optional<std::string> bytes;
  if (comma != std::string::npos) bytes = fromBase64(std::string_view(uri).substr(comma + 1));
  if (!bytes) model_.fail(fmt::format("is not valid glTF: the data of {} are not base64", what));
  return std::move(*bytes);
}

DracoMesh decodeDraco(std::string_view bytes, const std::map<std::string, std::uint32_t>& ids) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) throw Error(fmt::format("Draco: {}", decoded.status().error_msg_string()));
  const draco::Mesh& mesh = *decoded.value();
  DracoMesh out;
  for (const auto& [name, id] : ids) {
    const draco::PointAttribute* const attribute = mesh.GetAttributeByUniqueId(id);
    if (attribute == nullptr) throw Error(fmt::format("Draco: the attribute {} ({}) is missing", id, name));
    out.attributes[name] = valuesOf(mesh, *attribute);
  }
  out.indices.reserve(mesh.num_faces() * std::size_t{3});
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(f))) out.indices.push_back(corner.value());
  }
  return out;
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
