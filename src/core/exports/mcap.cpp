// Writes an MCAP file (mcap.dev, profile ros2) for each sequence, train/street-s1-lane.mcap, which Foxglove, the tools
// of MCAP and rosbag2 of ROS 2 read. Its topics:
//
//   /<sensor>/points  sensor_msgs/msg/PointCloud2           all columns of each revolution, in the sensor's frame
//   /tf               tf2_msgs/msg/TFMessage                map -> vehicle, at the start of each revolution
//   /tf_static        tf2_msgs/msg/TFMessage                vehicle -> sensors, once
//   /objects          visualization_msgs/msg/MarkerArray    boxes and their names in map, if the dataset lists objects
//
// The frame `map` is the dataset's world; the frames of the sensors have the sensors' names. If the sensor moves during
// the revolution and the dataset is not deskewed, each point is in the sensor's frame at the time when its column fired
// (field `time`), while /tf has the pose at the start of the revolution. The misses of organised scans are kept, as
// NaN. Classes are in the fields `label` and `label_2`; the metadata record "classes" lists their names, and the record
// "scanmill" the dataset and the sequence.
//
// Time 0 of a sequence is the start of 2020, because a time stamp of 0 has a special meaning in tf2.
//
// The messages are those of ROS 2 Humble and later: sensor_msgs/msg/PointCloud2, tf2_msgs/msg/TFMessage and
// visualization_msgs/msg/MarkerArray (github.com/ros2/common_interfaces, rcl_interfaces and geometry2, branch humble).
//
// Definitions are in the language of docs.ros.org/en/humble/Concepts/About-ROS-Interfaces.html, without comments; the
// definition of Marker omits the constants that this file does not use. Each definition is followed by the definitions
// of all types that it uses, each after a line of 80 '=' and a line with the type's name.
//
// Messages are serialised as in DDS: CDR, version 1, little-endian (OMG, "DDS for Extremely Large Scale and
// Interoperability Protocol (DDSI-RTPS)", section 10; "Extensible and Dynamic Topic Types for DDS", section 7.4.1). A
// number is aligned to its size, counted from the end of the first four bytes, which state the encoding.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "config/version.h"
#include "exports/layout.h"
#include "exports/mcap_file.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

struct RosSchema {
  std::string_view name;  // name of the type, such as "sensor_msgs/msg/PointCloud2"
  std::string text;       // the definition of the type, and of all types that it contains
};

// The pose of the frame `child` in the frame `parent`.
struct RosTransform {
  std::uint64_t time = 0;  // ns, time of the pose
  std::string parent;
  std::string child;
  Pose parentFromChild;
};

// A shape for viewers. It replaces an earlier marker with the same name space and id.
struct RosMarker {
  enum class Shape : std::int32_t { None = 0, Cube = 1, Text = 9 };
  enum class Action : std::int32_t { Add = 0, DeleteAll = 3 };
  Action action = Action::Add;
  Shape shape = Shape::None;
  std::string nameSpace;
  std::int32_t id = 0;
  Pose pose;                     // in the frame of the message
  Vec3d scale;                   // m, sides of a cube; for a text, z is the height of its letters
  std::array<float, 4> color{};  // red, green, blue and opacity, each from 0 to 1
  std::string text;
};

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
    align(sizeof(T));
    putNumber(value, bytes_);
    return *this;
  }
  // Appends the length of a list, whose items follow.
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
  void align(std::size_t size) {
    while ((bytes_.size() - kEncodingBytes) % size != 0) bytes_ += '\0';
  }

  static constexpr std::size_t kEncodingBytes = 4;
  std::string bytes_ = std::string("\0\1\0\0", kEncodingBytes);
};

void putMarker(std::uint64_t time, std::string_view frame, const RosMarker& marker, Cdr& out) {
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

// The number that PointField has for a type of the table of columns.
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

RosSchema pointCloudSchema() {
  return {"sensor_msgs/msg/PointCloud2", definitionText(kPointCloud, {kHeader, kStamp, kPointField})};
}

RosSchema transformsSchema() {
  return {"tf2_msgs/msg/TFMessage",
          definitionText(kTransforms, {kTransformStamped, kHeader, kStamp, kTransform, kVector, kQuaternion})};
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

std::string markersMessage(std::uint64_t time, std::string_view frame, std::span<const RosMarker> markers) {
  Cdr out;
  out.count(markers.size());
  for (const RosMarker& marker : markers) putMarker(time, frame, marker, out);
  return out.take();
}

// Returns a serialised scan. The fields are x, y and z, then the scan's columns with their names. An organised scan
// keeps its misses and its height. Throws Error if the scan exceeds the message's limits.
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

constexpr std::int64_t kStart = 1'577'836'800'000'000'000;  // ns since 1970: 2020-01-01 00:00:00 UTC, time 0
constexpr const char* kWorld = "map";
constexpr const char* kVehicle = "vehicle";
constexpr float kBoxOpacity = 0.4f;    // chosen by eye
constexpr double kLetterHeight = 0.5;  // m, in the text of a box
constexpr std::array<float, 4> kTextColor{1, 1, 1, 1};

// Returns the time stamp (ns) of a time since the start of the sequence.
std::uint64_t timeStamp(double seconds) {
  return static_cast<std::uint64_t>(kStart + std::llround(seconds * 1e9));
}

// Returns the topic of a sensor's points. Names in ROS consist of letters, digits and '_', and do not begin with a
// digit (design.ros2.org/articles/topic_and_service_names.html).
std::string topicOf(const SensorRecord& sensor) {
  std::string name = sensor.name;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())) != 0) name.insert(0, "sensor_");
  return "/" + name + "/points";
}

// The subscribers that get a message: those at the time of publishing, or (for static transforms) also later ones.
enum class Subscribers { OfTheMoment, Later };

// Returns the metadata that make rosbag2, when it plays the file, publish a topic reliably to the given
// subscribers. The numbers are from ROS 2's middleware interface (rmw/types.h); the durations mean infinity.
McapMap publishing(Subscribers subscribers) {
  const bool keepsForLater = subscribers == Subscribers::Later;
  constexpr const char* kEndless = "{sec: 9223372036, nsec: 854775807}";
  return {{"offered_qos_profiles",
           fmt::format("- history: 1\n  depth: {}\n  reliability: 1\n  durability: {}\n  deadline: {}\n  lifespan: {}\n"
                       "  liveliness: 1\n  liveliness_lease_duration: {}\n  avoid_ros_namespace_conventions: false\n",
                       keepsForLater ? 1 : 10, keepsForLater ? 1 : 2, kEndless, kEndless, kEndless)}};
}

// Writes the MCAP file of a sequence: the constructor writes what all samples share, add() the messages of a sample.
class Bag {
 public:
  Bag(const ExportPlan& plan, std::size_t sequence, const std::filesystem::path& path)
      : plan_(plan), sequence_(plan.sequences[sequence]), file_(path, "ros2", fmt::format("scanmill {}", kVersion)) {
    // This record, which Humble writes, makes later versions of rosbag2 interpret the numbers of publishing() as Humble
    // does.
    file_.addMetadata("rosbag2", {{"ROS_DISTRO", "humble"}});
    file_.addMetadata("scanmill", {{"dataset", plan.manifest.name},
                                   {"sequence", sequence_.name},
                                   {"split", sequence_.split},
                                   {"deskewed", plan.manifest.deskewed ? "true" : "false"}});
    McapMap classes;
    for (const SemanticClass& c : plan.classes.target().classes) classes[std::to_string(c.id)] = c.name;
    file_.addMetadata("classes", classes);
    const std::uint16_t transforms = addSchema(transformsSchema());
    mounts_ = addChannel(transforms, "/tf_static", Subscribers::Later);
    poses_ = addChannel(transforms, "/tf");
    const std::uint16_t clouds = addSchema(pointCloudSchema());
    for (const SensorRecord* sensor : plan.sensors) clouds_.push_back(addChannel(clouds, topicOf(*sensor)));
    addMounts();
  }

  // Adds the messages of a sample.
  void add(ExportSample sample) {
    for (ExportScan& scan : sample.scans) {
      const std::uint64_t time = timeStamp(scan.record->time);
      const Pose vehicle = scan.record->worldFromSensor.front() * inverse(mountOf(*scan.sensor, *scan.record));
      if (poseTimes_.insert(time).second) {
        const RosTransform pose{time, kWorld, kVehicle, vehicle};
        file_.addMessage(poses_, time, transformsMessage({&pose, 1}));
      }
      visitTable(scan.scan, [&](auto key, auto& values) {
        if constexpr (key.row.display.colors == ColumnColors::Classes) {
          for (auto& id : values) id = plan_.classes.targetId(id);
        }
      });
      file_.addMessage(clouds_.at(scan.sensorNumber), time, pointCloudMessage(time, scan.sensor->name, scan.scan));
    }
    if (sample.objects) addObjects(*sample.objects);
  }

  void commit() { file_.commit(); }

 private:
  std::uint16_t addSchema(const RosSchema& schema) { return file_.addSchema(schema.name, "ros2msg", schema.text); }

  std::uint16_t addChannel(std::uint16_t schema, const std::string& topic,
                           Subscribers subscribers = Subscribers::OfTheMoment) {
    return file_.addChannel(schema, topic, "cdr", publishing(subscribers));
  }

  // Adds the mounts of the sensors at the time of the sequence's first scan. The first sample may have no scan of a
  // sensor that turns slowly.
  void addMounts() {
    std::vector<RosTransform> mounts;
    double firstTime = INFINITY;  // s
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      for (const std::size_t sample : sequence_.samples) {
        const std::vector<const ScanRecord*> scans = revolutionsOf(plan_, plan_.manifest.samples[sample], s);
        if (scans.empty()) continue;
        firstTime = std::min(firstTime, scans.front()->time);
        mounts.push_back({.parent = kVehicle,
                          .child = plan_.sensors[s]->name,
                          .parentFromChild = mountOf(*plan_.sensors[s], *scans.front())});
        break;
      }
    }
    for (RosTransform& mount : mounts) mount.time = timeStamp(firstTime);
    if (!mounts.empty()) file_.addMessage(mounts_, timeStamp(firstTime), transformsMessage(mounts));
  }

  // Adds markers for the box and the name of each object, and deletes the markers of the previous sample.
  void addObjects(const SampleObjects& objects) {
    if (!objects_) objects_ = addChannel(addSchema(markersSchema()), "/objects");
    std::vector<RosMarker> markers(1);
    markers.front().action = RosMarker::Action::DeleteAll;
    for (const ObjectRecord& object : objects.objects) {
      const SemanticClass& semantic = plan_.classes.classOf(object.semantic);
      const auto id = static_cast<std::int32_t>(object.id);  // ids from 2^31 on become negative, but stay unique
      std::array<float, 4> color{0, 0, 0, kBoxOpacity};
      for (std::size_t i = 0; i < 3; ++i) color[i] = static_cast<float>(semantic.color[i]) / 255;
      markers.push_back({.shape = RosMarker::Shape::Cube,
                         .nameSpace = semantic.name,
                         .id = id,
                         .pose = object.worldFromBox,
                         .scale = object.size,
                         .color = color,
                         .text = {}});
      const Vec3d aboveBox = object.worldFromBox.translation + Vec3d{0, 0, object.size.z / 2 + kLetterHeight};
      markers.push_back({.shape = RosMarker::Shape::Text,
                         .nameSpace = "name",
                         .id = id,
                         .pose = {{}, aboveBox},
                         .scale = {0, 0, kLetterHeight},
                         .color = kTextColor,
                         .text = nameOf(object, semantic)});
    }
    const std::uint64_t time = timeStamp(objects.time);
    file_.addMessage(*objects_, time, markersMessage(time, kWorld, markers));
  }

  // Returns the text for an object, such as "car 7, 72 %": class, id, and the object's highest visibility over all
  // exported sensors.
  std::string nameOf(const ObjectRecord& object, const SemanticClass& semantic) const {
    std::optional<double> visibility;
    for (const ObjectView& view : object.views) {
      const bool isExported =
          std::ranges::any_of(plan_.sensors, [&](const SensorRecord* sensor) { return sensor->name == view.sensor; });
      if (isExported) visibility = std::max(visibility, view.visibility());
    }
    const std::string name = fmt::format("{} {}", semantic.name, object.id);
    return visibility ? fmt::format("{}, {:.0f} %", name, 100 * *visibility) : name;
  }

  const ExportPlan& plan_;
  const ExportSequence& sequence_;
  McapFile file_;
  std::uint16_t mounts_ = 0;
  std::uint16_t poses_ = 0;
  std::vector<std::uint16_t> clouds_;       // channel of each sensor's points
  std::set<std::uint64_t> poseTimes_;       // time stamps that /tf has already
  std::optional<std::uint16_t> objects_{};  // channel of the objects; set when the first objects are added
};

class Mcap : public ExportLayout {
 public:
  void check(const ExportPlan& plan) const override {
    for (const SensorRecord* sensor : plan.sensors) {
      if (sensor->name == kWorld || sensor->name == kVehicle) {
        refuse(plan,
               "the sensor '{0}' has a reserved name: in MCAP files the frame of the world is "
               "'{1}' and that of the vehicle '{2}'. Select other sensors with --sensor",
               sensor->name, kWorld, kVehicle);
      }
    }
    requireDistinct(plan, "topic", [&](std::size_t sensor) { return topicOf(*plan.sensors[sensor]); });
  }

  bool bySequence() const override { return true; }

  void write(const ExportPlan& plan, std::size_t sequence, std::size_t, const ReadSample& read,
             const ExportFolder& folder) const override {
    const ExportSequence& recorded = plan.sequences[sequence];
    Bag bag(plan, sequence, folder.prepareFile(std::filesystem::path(recorded.split) / (recorded.name + ".mcap")));
    for (std::size_t f = 0; f < recorded.samples.size(); ++f) bag.add(read(sequence, f));
    bag.commit();
  }
};

}  // namespace

std::unique_ptr<ExportLayout> makeMcap() {
  return std::make_unique<Mcap>();
}

}  // namespace scanmill
