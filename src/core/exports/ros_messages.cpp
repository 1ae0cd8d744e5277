// The messages are those of ROS 2 Humble and later: sensor_msgs/msg/PointCloud2, tf2_msgs/msg/TFMessage,
// nav_msgs/msg/Odometry, std_msgs/msg/String and visualization_msgs/msg/MarkerArray (github.com/ros2/common_interfaces,
// rcl_interfaces and geometry2, branch humble).
//
// Definitions are in the language of docs.ros.org/en/humble/Concepts/About-ROS-Interfaces.html, without comments; the
// definition of Marker omits the constants that this file does not use. Each definition is followed by the definitions
// of all types that it uses, each after a line of 80 '=' and a line with the type's name.
//
// Messages are serialised as in DDS: CDR, version 1, little-endian (OMG, "DDS for Extremely Large Scale and
// Interoperability Protocol (DDSI-RTPS)", section 10; "Extensible and Dynamic Topic Types for DDS", section 7.4.1). A
// number is aligned to its size, counted from the end of the first four bytes, which state the encoding.

#include "exports/ros_messages.h"

#include <fmt/core.h>

#include <bit>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

struct Definition {
  std::string_view type;
  std::string_view fields;
};

constexpr Definition kStamp{"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"};
constexpr Definition kDuration{"builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"};
constexpr Definition kHeader{"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"};
constexpr Definition kColor{"std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"};
constexpr Definition kPoint{"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"};
constexpr Definition kVector{"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"};
constexpr Definition kQuaternion{"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"};
constexpr Definition kPose{"geometry_msgs/Pose",
                           "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"};
constexpr Definition kTransform{"geometry_msgs/Transform",
                                "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"};
constexpr Definition kTransformStamped{
    "geometry_msgs/TransformStamped",
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"};
constexpr Definition kPointField{"sensor_msgs/PointField", R"(uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
)"};
constexpr Definition kPointCloud{"sensor_msgs/PointCloud2", R"(std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
)"};
constexpr Definition kImage{"sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"};
constexpr Definition kTexturePoint{"visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"};
constexpr Definition kMeshFile{"visualization_msgs/MeshFile", "string filename\nuint8[] data\n"};
constexpr Definition kMarker{"visualization_msgs/Marker", R"(int32 CUBE=1
int32 TEXT_VIEW_FACING=9
int32 ADD=0
int32 DELETEALL=3
std_msgs/Header header
string ns
int32 id
int32 type
int32 action
geometry_msgs/Pose pose
geometry_msgs/Vector3 scale
std_msgs/ColorRGBA color
builtin_interfaces/Duration lifetime
bool frame_locked
geometry_msgs/Point[] points
std_msgs/ColorRGBA[] colors
string texture_resource
sensor_msgs/CompressedImage texture
visualization_msgs/UVCoordinate[] uv_coordinates
string text
string mesh_resource
visualization_msgs/MeshFile mesh_file
bool mesh_use_embedded_materials
)"};
constexpr Definition kTransforms{"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"};
constexpr Definition kPoseCovariance{"geometry_msgs/PoseWithCovariance",
                                     "geometry_msgs/Pose pose\nfloat64[36] covariance\n"};
constexpr Definition kTwist{"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"};
constexpr Definition kTwistCovariance{"geometry_msgs/TwistWithCovariance",
                                      "geometry_msgs/Twist twist\nfloat64[36] covariance\n"};
constexpr Definition kOdometry{"nav_msgs/Odometry", R"(std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
)"};
constexpr Definition kString{"std_msgs/String", "string data\n"};
constexpr Definition kMarkers{"visualization_msgs/MarkerArray", "visualization_msgs/Marker[] markers\n"};

// Returns the definition of a message's type, followed by the definitions of the types that it uses.
std::string definitionText(const Definition& message, std::initializer_list<Definition> usedTypes) {
  std::string text(message.fields);
  for (const Definition& used : usedTypes) text += fmt::format("{:=<80}\nMSG: {}\n{}", "", used.type, used.fields);
  return text;
}

// Serialises the fields of a message, in the order of their definition.
class Cdr {
 public:
  template <class T>
  Cdr& number(T value) {
    while ((bytes_.size() - kEncodingBytes) % sizeof(T) != 0) bytes_ += '\0';
    putNumber(value, bytes_);
    return *this;
  }
  // Appends the length of a list; the caller then appends the items. Throws Error if the length exceeds 32 bits.
  Cdr& count(std::size_t count) {
    if (count > std::numeric_limits<std::uint32_t>::max()) {
      throw Error("a list in a ROS message cannot have {} entries or bytes", count);
    }
    return number(static_cast<std::uint32_t>(count));
  }
  Cdr& text(std::string_view text) {
    count(text.size() + 1);
    bytes_ += text;
    bytes_ += '\0';
    return *this;
  }
  Cdr& time(std::uint64_t nanoseconds) {
    constexpr std::uint64_t kSecond = 1'000'000'000;
    return number(static_cast<std::int32_t>(nanoseconds / kSecond))
        .number(static_cast<std::uint32_t>(nanoseconds % kSecond));
  }
  Cdr& header(std::uint64_t nanoseconds, std::string_view frame) { return time(nanoseconds).text(frame); }
  Cdr& vector(const Vec3d& v) { return number(v.x).number(v.y).number(v.z); }
  // In ROS a quaternion has w last.
  Cdr& pose(const Pose& pose) {
    const Quat& q = pose.rotation;
    return vector(pose.translation).number(q.x).number(q.y).number(q.z).number(q.w);
  }
  // Appends `size` bytes and returns a pointer to them, which the caller must fill before the next call.
  char* appendUninitialised(std::size_t size) {
    bytes_.resize(bytes_.size() + size);
    return bytes_.data() + bytes_.size() - size;
  }
  std::string take() { return std::move(bytes_); }

 private:
  static constexpr std::size_t kEncodingBytes = 4;
  std::string bytes_ = std::string("\0\1\0\0", kEncodingBytes);
};

// PointField's number for T, the type of a column.
template <class T>
constexpr std::uint8_t kDatatype = std::is_floating_point_v<T> ? 7
                                   : sizeof(T) == 1            ? 2
                                   : sizeof(T) == 2            ? 4
                                                               : 6;

constexpr std::size_t roundedUp(std::size_t value, std::size_t multiple) {
  return (value + multiple - 1) / multiple * multiple;
}

// Calls visit(name, values, offset in the point) for each column, and returns the size of a point in bytes. Each column
// is aligned to the size of its type, because readers cast pointers.
template <class Visit>
std::size_t visitFields(const Scan& scan, Visit&& visit) {
  std::size_t offset = sizeof(Vec3f);
  visitTable(scan, [&]<class T>(auto key, const std::vector<T>& values) {
    if (!scan.has(key)) return;
    offset = roundedUp(offset, sizeof(T));
    visit(key.row.name, values, offset);
    offset += sizeof(T);
  });
  return roundedUp(offset, sizeof(float));
}

}  // namespace

RosSchema pointCloudSchema() {
  return {"sensor_msgs/msg/PointCloud2", definitionText(kPointCloud, {kHeader, kStamp, kPointField})};
}

RosSchema transformsSchema() {
  return {"tf2_msgs/msg/TFMessage",
          definitionText(kTransforms, {kTransformStamped, kHeader, kStamp, kTransform, kVector, kQuaternion})};
}

RosSchema odometrySchema() {
  return {"nav_msgs/msg/Odometry", definitionText(kOdometry, {kHeader, kStamp, kPoseCovariance, kPose, kPoint,
                                                              kQuaternion, kTwistCovariance, kTwist, kVector})};
}

RosSchema stringSchema() {
  return {"std_msgs/msg/String", std::string(kString.fields)};
}

RosSchema markersSchema() {
  return {"visualization_msgs/msg/MarkerArray",
          definitionText(kMarkers, {kMarker, kHeader, kStamp, kPose, kPoint, kQuaternion, kVector, kColor, kDuration,
                                    kImage, kTexturePoint, kMeshFile})};
}

std::string transformsMessage(std::span<const RosTransform> transforms) {
  Cdr out;
  out.count(transforms.size());
  for (const RosTransform& t : transforms) out.header(t.time, t.parent).text(t.child).pose(t.parentFromChild);
  return out.take();
}

std::string odometryMessage(const RosTransform& pose, const Vec3d& linear, const Vec3d& angular) {
  Cdr out;
  const auto covariance = [&] {  // zeros: the values are exact
    for (int i = 0; i < 36; ++i) out.number(0.0);
  };
  out.header(pose.time, pose.parent).text(pose.child).pose(pose.parentFromChild);
  covariance();
  out.vector(linear).vector(angular);
  covariance();
  return out.take();
}

std::string stringMessage(std::string_view text) {
  return Cdr().text(text).take();
}

std::string markersMessage(std::uint64_t time, std::string_view frame, std::span<const RosMarker> markers) {
  Cdr out;
  out.count(markers.size());
  for (const RosMarker& marker : markers) {
    out.header(time, frame).text(marker.nameSpace).number(marker.id);
    out.number(static_cast<std::int32_t>(marker.shape)).number(static_cast<std::int32_t>(marker.action));
    out.pose(marker.pose).vector(marker.scale);
    for (const float channel : marker.color) out.number(channel);
    out.time(0).number(false);            // lifetime (0: infinite); frame_locked
    out.count(0).count(0);                // points, colors
    out.text("").header(0, "").text("");  // texture_resource; texture: header, format
    out.count(0).count(0);                // texture: data; uv_coordinates
    out.text(marker.text).text("");       // mesh_resource
    out.text("").count(0).number(false);  // mesh_file: filename, data; mesh_use_embedded_materials
  }
  return out.take();
}

std::string pointCloudMessage(std::uint64_t time, std::string_view frame, const Scan& scan) {
  requireConsistent(scan);
  Cdr out;
  out.header(time, frame).number(scan.height()).number(scan.width());
  std::size_t fields = 3;  // x, y and z
  visitFields(scan, [&](std::string_view, const auto&, std::size_t) { ++fields; });
  const auto putField = [&](std::string_view name, std::size_t offset, std::uint8_t datatype) {
    out.text(name).number(static_cast<std::uint32_t>(offset)).number(datatype).number(std::uint32_t{1});
  };
  out.count(fields);
  putField("x", offsetof(Vec3f, x), kDatatype<float>);
  putField("y", offsetof(Vec3f, y), kDatatype<float>);
  putField("z", offsetof(Vec3f, z), kDatatype<float>);
  const std::size_t step =
      visitFields(scan, [&]<class T>(std::string_view name, const std::vector<T>&, std::size_t offset) {
        putField(name, offset, kDatatype<T>);
      });
  out.number(std::endian::native == std::endian::big).number(static_cast<std::uint32_t>(step));
  out.count(step * scan.width()).count(step * scan.size());  // bytes of a row, bytes of all rows
  char* const points = out.appendUninitialised(step * scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) std::memcpy(points + i * step, &scan.position[i], sizeof(Vec3f));
  visitFields(scan, [&]<class T>(std::string_view, const std::vector<T>& values, std::size_t offset) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::memcpy(points + i * step + offset, &values[i], sizeof(T));
    }
  });
  out.number(!scan.organised);  // is_dense: true if no point is invalid
  return out.take();
}

}  // namespace scanmill
