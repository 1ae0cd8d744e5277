#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "base/error.h"
#include "formats/little_endian.h"
#include "formats/readers.h"
#include "formats/text_rows.h"
#include "scan/scan.h"

namespace scanmill {

namespace {

// Limits of a header's numbers, since Draco allocates memory for all points that a header announces. Identical points
// take no bits, so even a small valid file may announce many points. A file may therefore always announce as many
// points as the largest known sensor has beams (2048 x 2048).
constexpr std::uint64_t kPointsWithoutBytes = std::uint64_t{1} << 22;
constexpr std::uint64_t kPointsPerByte = 64;
constexpr std::uint64_t kMostBytesPerPoint = 256;
constexpr int kDeepestMetadata = 8;

// Checks the part of the file before the values, and refuses sizes for which the decoder would need too much memory.
class HeaderCheck {
 public:
  HeaderCheck(std::string_view bytes, const std::string& what) : bytes_(bytes), where_{what, 0, 0} {}

  // Throws InputError for a damaged header and for more points or bytes per point than the limits above allow.
  void run() {
    if (!bytes_.starts_with("DRACO")) fail("not a Draco file");
    skip(7);  // the magic number and the version, which the decoder checks
    if (byte() != draco::POINT_CLOUD) fail("a Draco mesh, not a point cloud");
    const std::uint8_t method = byte();
    if (method > draco::POINT_CLOUD_KD_TREE_ENCODING) fail("unknown Draco method");
    const auto flags = number<std::uint16_t>();
    if ((flags & METADATA_FLAG_MASK) != 0) {
      const std::uint64_t attributes = varint();
      for (std::uint64_t i = 0; i < attributes; ++i) {
        varint();
        skipMetadata(0);
      }
      skipMetadata(0);
    }
    const auto points = number<std::int32_t>();
    const std::uint64_t mostPoints = std::max<std::uint64_t>(kPointsWithoutBytes, bytes_.size() * kPointsPerByte);
    if (points < 0 || static_cast<std::uint64_t>(points) > mostPoints) {
      fail(fmt::format("{} points cannot be in {} bytes", points, bytes_.size()));
    }
    checkAttributes(method);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw InputError(where_, message); }

  void skip(std::uint64_t count) {
    if (count > bytes_.size() - at_) fail("truncated in the header");
    at_ += count;
  }

  template <class T>
  T number() {
    skip(sizeof(T));
    return numberAt<T>(bytes_, at_ - sizeof(T));
  }

  std::uint8_t byte() { return number<std::uint8_t>(); }

  // Reads a number as appendVarint() writes it.
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const std::uint8_t group = byte();
      value |= std::uint64_t{group & 127u} << shift;
      if (group < 128) return value;
    }
    fail("damaged header");
  }

  // Skips a block of metadata: entries, each with a name and a value, and then nested blocks, each with a name.
  void skipMetadata(int depth) {
    if (depth > kDeepestMetadata) fail("metadata nested too deeply");
    const std::uint64_t entries = varint();
    for (std::uint64_t i = 0; i < entries; ++i) {
      skip(byte());
      skip(varint());
    }
    const std::uint64_t innerBlocks = varint();
    for (std::uint64_t i = 0; i < innerBlocks; ++i) {
      skip(byte());
      skipMetadata(depth + 1);
    }
  }

  // Checks the attributes' descriptors, and that a point has at most kMostBytesPerPoint bytes.
  void checkAttributes(std::uint8_t method) {
    const std::uint8_t groups = byte();
    std::uint64_t pointBytes = 0;
    for (int group = 0; group < groups; ++group) {
      const std::uint64_t attributes = varint();
      for (std::uint64_t i = 0; i < attributes; ++i) {
        skip(1);  // the kind
        const std::uint8_t type = byte();
        const std::uint8_t components = byte();
        skip(1);   // whether the values are normalised
        varint();  // the id
        if (type == draco::DT_INVALID || type >= draco::DT_TYPES_COUNT || components == 0) fail("damaged attributes");
        pointBytes += std::uint64_t{components} * draco::DataTypeLength(static_cast<draco::DataType>(type));
        if (pointBytes > kMostBytesPerPoint) fail("too many attributes for a scan");
      }
      if (method == draco::POINT_CLOUD_SEQUENTIAL_ENCODING) skip(attributes);
    }
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  Location where_;
};

class CloudReader {
 public:
  CloudReader(const draco::PointCloud& cloud, const std::string& what) : cloud_(cloud), where_{what, 0, 0} {}

  Cloud read() {
    Scan& scan = result_.scan;
    scan.rings = entry("rings");
    scan.columns = entry("columns");
    const draco::PointAttribute* position = cloud_.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    if (cloud_.num_points() == 0 && position == nullptr) return std::move(result_);
    if (!position || position->num_components() != 3) throw InputError(where_, "there are no positions x, y, z");
    scan.position.resize(cloud_.num_points());
    if (scan.size() > 0) readAttribute(*position, "position", &scan.position[0].x);
    visitTable(scan, [&](auto key, auto& values) {
      const draco::PointAttribute* attribute = find(key.row.name);
      if (!attribute) return;
      scan.columnsIfEmpty.add(key.index);
      values.resize(cloud_.num_points());
      readAttribute(*attribute, key.row.name, values.data());
    });
    readForeign(*position);
    adoptColumns(result_, where_);
    return std::move(result_);
  }

 private:
  // Returns a number of the geometry's metadata; 0 if it is absent.
  std::uint32_t entry(const char* name) const {
    std::int32_t value = 0;
    if (!cloud_.GetMetadata() || !cloud_.GetMetadata()->GetEntryInt(name, &value)) return 0;
    return static_cast<std::uint32_t>(value);
  }

  // Returns the attribute with this name; null if there is none.
  const draco::PointAttribute* find(std::string_view name) const {
    const int id = cloud_.GetAttributeIdByMetadataEntry("name", std::string(name));
    if (id < 0) return nullptr;
    const draco::PointAttribute* const attribute = cloud_.attribute(id);
    if (attribute->num_components() == 1) return attribute;
    throw InputError(where_, "{} has {} values a point", name, attribute->num_components());
  }

  std::string nameOf(int attribute) const {
    std::string name;
    if (!cloud_.GetMetadata()) return name;
    const draco::AttributeMetadata* metadata = cloud_.GetAttributeMetadataByAttributeId(attribute);
    if (metadata == nullptr || !metadata->GetEntryString("name", &name)) name.clear();
    return name;
  }

  // Reads attributes with one value per point and a name that the table of columns does not have.
  void readForeign(const draco::PointAttribute& position) {
    for (int i = 0; i < cloud_.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *cloud_.attribute(i);
      if (&attribute == &position) continue;
      const std::string name = nameOf(i);
      if (name.empty() || attribute.num_components() != 1) {
        const std::string kind = draco::GeometryAttribute::TypeToString(attribute.attribute_type());
        result_.leftOut.add(
            fmt::format("attributes '{}' of {} values", name.empty() ? kind : name, attribute.num_components()));
      } else if (columnIndex(name) >= kColumnCount) {
        visitStored(attribute, name, [&]<class Stored>(Stored) {
          std::vector<Stored> values(cloud_.num_points());
          convert<Stored>(attribute, name, values.data());
          result_.scan.foreign.push_back({name, std::move(values)});
        });
      }
    }
  }

  // Writes the attribute's values to `to`: point by point, with the components of a point in succession.
  template <class T>
  void readAttribute(const draco::PointAttribute& attribute, std::string_view name, T* to) const {
    visitStored(attribute, name, [&]<class Stored>(Stored) { convert<Stored>(attribute, name, to); });
  }

  // Calls visit(value), where `value` has the type in which the attribute is stored; only this type has a meaning.
  template <class Visit>
  void visitStored(const draco::PointAttribute& attribute, std::string_view name, const Visit& visit) const {
    const draco::DataType type = attribute.data_type();
    if (type == draco::DT_INVALID || type >= draco::DT_TYPES_COUNT) {
      throw InputError(where_, "{} has an unknown type", name);
    }
    const bool isFloat = type == draco::DT_FLOAT32 || type == draco::DT_FLOAT64;
    const bool isSigned =
        type == draco::DT_INT8 || type == draco::DT_INT16 || type == draco::DT_INT32 || type == draco::DT_INT64;
    const auto size = static_cast<std::uint64_t>(draco::DataTypeLength(type));
    visitNumberType(isFloat ? 'F' : isSigned ? 'I' : 'U', size, visit);
  }

  // Does the work of readAttribute() for an attribute that is stored with the type `Stored`.
  template <class Stored, class T>
  void convert(const draco::PointAttribute& attribute, std::string_view name, T* to) const {
    const auto components = static_cast<std::size_t>(attribute.num_components());
    const std::size_t values = attribute.size();
    const std::size_t bytes = attribute.buffer()->data_size();
    for (std::uint32_t i = 0; i < cloud_.num_points(); ++i) {
      const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(i));
      const auto offset = static_cast<std::size_t>(attribute.GetBytePos(index));
      if (index.value() >= values || offset + components * sizeof(Stored) > bytes) {
        throw InputError(where_, "{} has no value for point {}", name, i);
      }
      for (std::size_t c = 0; c < components; ++c) {
        Stored stored;
        std::memcpy(&stored, attribute.buffer()->data() + offset + c * sizeof(Stored), sizeof(Stored));
        *to++ = columnValue<T>(stored, name, i, where_);
      }
    }
  }

  const draco::PointCloud& cloud_;
  Location where_;
  Cloud result_;
};

}  // namespace

const FormatSupport kDracoFormat{
    "Draco", ".drc",
    "Positions; attributes of one value a point, with the metadata `name`, are the columns of point clouds",
    "attributes of several values or without a name"};

Cloud readDraco(std::string_view bytes, const std::string& what) {
  HeaderCheck(bytes, what).run();
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  draco::StatusOr<std::unique_ptr<draco::PointCloud>> cloud = decoder.DecodePointCloudFromBuffer(&buffer);
  if (!cloud.ok()) {
    const std::string reason = cloud.status().error_msg_string();
    throw InputError(Location{what, 0, 0}, "truncated or damaged Draco data" + (reason.empty() ? "" : ": " + reason));
  }
  return CloudReader(*cloud.value(), what).read();
}

}  // namespace scanmill
