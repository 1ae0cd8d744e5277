#pragma once

// Messages of ROS 2: their serialised bytes, and the texts that define their types.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

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

RosSchema pointCloudSchema();
RosSchema transformsSchema();
RosSchema odometrySchema();
RosSchema stringSchema();
RosSchema markersSchema();

// These functions return serialised messages. Times are in nanoseconds. They throw Error if the content exceeds a
// message's limits.
std::string transformsMessage(std::span<const RosTransform> transforms);
// `linear` (m/s) and `angular` (rad/s): velocity of the frame `pose.child` in `pose.parent`, along the axes of the
// former.
std::string odometryMessage(const RosTransform& pose, const Vec3d& linear, const Vec3d& angular);
std::string stringMessage(std::string_view text);
std::string markersMessage(std::uint64_t time, std::string_view frame, std::span<const RosMarker> markers);
// The message has the fields x, y and z, then one field for each of the scan's columns, with the column's name. The
// misses of an organised scan are kept, and the message's height is its number of rings.
std::string pointCloudMessage(std::uint64_t time, std::string_view frame, const Scan& scan);

}  // namespace scanmill
