#include "assets/meshes/gltf/draco.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include "base/error.h"

namespace scanmill::gltf {
namespace {

DracoMesh::Values valuesOf(const draco::Mesh& mesh, const draco::PointAttribute& attribute) {
  DracoMesh::Values values;
  const std::uint8_t width = attribute.num_components();
  values.width = width;
  values.normalized = attribute.normalized();
  values.numbers.resize(mesh.num_points() * values.width);
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    if (value.value() >= attribute.size() ||
        !attribute.ConvertValue<float>(value, static_cast<std::int8_t>(width), &values.numbers[i * values.width])) {
      throw Error("Draco attributes are damaged");
    }
  }
  return values;
}

}  // namespace

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

}  // namespace scanmill::gltf
