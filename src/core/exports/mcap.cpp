// Writes an MCAP file (mcap.dev, profile ros2) for each sequence, train/street-s1-lane.mcap, which Foxglove, the tools
// of MCAP and rosbag2 of ROS 2 read. Its topics:
//
//   /<sensor>/points  sensor_msgs/msg/PointCloud2           all columns of each revolution, in the sensor's frame
//   /tf               tf2_msgs/msg/TFMessage                map -> base_link, at start and end of each revolution
//   /odom             nav_msgs/msg/Odometry                 the same poses, with velocities
//   /tf_static        tf2_msgs/msg/TFMessage                base_link -> sensors, once
//   /objects          visualization_msgs/msg/MarkerArray    boxes and their names in map, if the dataset lists objects
//   /robot_description  std_msgs/msg/String                 the text of the URDF file that the option --robot names
//
// The frame `map` is the dataset's world and `base_link` the vehicle's; --frames names others. The frames of the
// sensors have the sensors' names. If the sensor moves during the revolution and the dataset is not deskewed, each
// point is in the sensor's frame at the time when its column fired (field `time`). The velocity is the difference to
// the next pose, divided by the time between them; in the last pose, to the pose before. The misses of organised scans
// are kept, as NaN. Classes are in the fields `label` and `label_2`; the metadata record "classes" lists their names,
// and the record "scanmill" the dataset and the sequence.
//
// Time 0 of a sequence is the start of 2020, because a time stamp of 0 has a special meaning in tf2.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "config/version.h"
#include "exports/layout.h"
#include "exports/mcap_file.h"
#include "exports/ros_messages.h"

namespace scanmill {

namespace {

constexpr std::int64_t kStart = 1'577'836'800'000'000'000;  // ns since 1970: 2020-01-01 00:00:00 UTC, time 0
constexpr float kBoxOpacity = 0.4f;                         // chosen by eye
constexpr double kLetterHeight = 0.5;                       // m, in the text of a box
constexpr std::array<float, 4> kTextColor{1, 1, 1, 1};

// Returns the time stamp (ns). `seconds`: time since the start of the sequence.
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

// The subscribers that a message reaches. Later: also those that join after its publication (static transforms).
enum class Subscribers { OfTheMoment, Later };

// Returns a channel's metadata, which make rosbag2 publish the topic reliably to the given subscribers when it plays
// the file. The numbers are from ROS 2's middleware interface (rmw/types.h); the durations mean infinity.
McapMap publishing(Subscribers subscribers) {
  const bool keepsForLater = subscribers == Subscribers::Later;
  constexpr const char* kEndless = "{sec: 9223372036, nsec: 854775807}";
  return {{"offered_qos_profiles",
           fmt::format("- history: 1\n  depth: {}\n  reliability: 1\n  durability: {}\n  deadline: {}\n  lifespan: {}\n"
                       "  liveliness: 1\n  liveliness_lease_duration: {}\n  avoid_ros_namespace_conventions: false\n",
                       keepsForLater ? 1 : 10, keepsForLater ? 1 : 2, kEndless, kEndless, kEndless)}};
}

// Returns the vehicle's pose at the start and the end of each revolution, by time stamp (ns).
std::map<std::uint64_t, Pose> driveOf(const ExportPlan& plan, const ExportSequence& sequence) {
  std::map<std::uint64_t, Pose> drive;
  for (const std::size_t sample : sequence.samples) {
    for (std::size_t s = 0; s < plan.sensors.size(); ++s) {
      for (const ScanRecord* scan : revolutionsOf(plan, plan.manifest.samples[sample], s)) {
        const Pose sensorFromVehicle = inverse(mountOf(*plan.sensors[s], *scan));
        drive.try_emplace(timeStamp(scan->time), scan->worldFromSensor.front() * sensorFromVehicle);
        if (scan->worldFromSensor.size() == 1) continue;
        const BeamTable& beams = plan.sensors[s]->beams;
        drive.try_emplace(timeStamp(scan->time + (beams.columns - 1) * beams.columnPeriod()),
                          scan->worldFromSensor.back() * sensorFromVehicle);
      }
    }
  }
  return drive;
}

// Writes the MCAP file of a sequence: the constructor writes what all samples share, add() the messages of a sample.
class Bag {
 public:
  Bag(const ExportPlan& plan, std::size_t sequence, const std::filesystem::path& path)
      : plan_(plan),
        sequence_(plan.sequences[sequence]),
        file_(path, "ros2", fmt::format("scanmill {}", kVersion)),
        drive_(driveOf(plan, sequence_)) {
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
    odometry_ = addChannel(addSchema(odometrySchema()), "/odom");
    const std::uint16_t clouds = addSchema(pointCloudSchema());
    for (const SensorRecord* sensor : plan.sensors) clouds_.push_back(addChannel(clouds, topicOf(*sensor)));
    addMounts();
    if (plan.ros.robot.empty() || drive_.empty()) return;
    const std::uint16_t robot = addChannel(addSchema(stringSchema()), "/robot_description", Subscribers::Later);
    file_.addMessage(robot, drive_.begin()->first, stringMessage(readFile(plan.ros.robot)));
  }

  void add(ExportSample sample) {
    for (ExportScan& scan : sample.scans) {
      const std::uint64_t time = timeStamp(scan.record->time);
      addPosesUntil(timeStamp(scan.record->time + scan.sensor->beams.period));
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

  // Adds the poses of the vehicle that are not added yet, up to a time stamp (ns).
  void addPosesUntil(std::uint64_t time) {
    for (; nextPose_ != drive_.end() && nextPose_->first <= time; ++nextPose_) {
      const auto& [stamp, pose] = *nextPose_;
      const RosTransform transform{stamp, plan_.ros.world, plan_.ros.vehicle, pose};
      file_.addMessage(poses_, stamp, transformsMessage({&transform, 1}));
      Vec3d linear, angular;
      if (drive_.size() > 1) {
        const bool last = std::next(nextPose_) == drive_.end();
        const auto other = last ? std::prev(nextPose_) : std::next(nextPose_);
        const double seconds =
            (last ? -1e-9 : 1e-9) * static_cast<double>(last ? stamp - other->first : other->first - stamp);
        const Pose moved = inverse(pose) * other->second;
        linear = moved.translation * (1 / seconds);
        const Quat& q = moved.rotation;
        const Vec3d imaginary = Vec3d{q.x, q.y, q.z} * (q.w < 0 ? -1.0 : 1.0);
        const double sine = length(imaginary);
        if (sine > 0) angular = imaginary * (2 * std::atan2(sine, std::abs(q.w)) / sine / seconds);
      }
      file_.addMessage(odometry_, stamp, odometryMessage(transform, linear, angular));
    }
  }

  // Adds the mounts of the sensors with the time of the sequence's first scan. Each mount is read from the sensor's
  // first scan, which may be in a later sample if the sensor turns slowly.
  void addMounts() {
    std::vector<RosTransform> mounts;
    double firstTime = INFINITY;  // s
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      for (const std::size_t sample : sequence_.samples) {
        const std::vector<const ScanRecord*> scans = revolutionsOf(plan_, plan_.manifest.samples[sample], s);
        if (scans.empty()) continue;
        firstTime = std::min(firstTime, scans.front()->time);
        mounts.push_back({.parent = plan_.ros.vehicle,
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
    file_.addMessage(*objects_, time, markersMessage(time, plan_.ros.world, markers));
  }

  // Returns the text for an object, such as "car 7, 72 %": class, id, and the object's highest visibility over all
  // exported sensors.
  std::string nameOf(const ObjectRecord& object, const SemanticClass& semantic) const {
    std::optional<double> visibility;
    for (const ObjectView& view : object.views) {
      if (std::ranges::find(plan_.sensors, view.sensor, &SensorRecord::name) == plan_.sensors.end()) continue;
      visibility = std::max(visibility, view.visibility());
    }
    const std::string name = fmt::format("{} {}", semantic.name, object.id);
    return visibility ? fmt::format("{}, {:.0f} %", name, 100 * *visibility) : name;
  }

  const ExportPlan& plan_;
  const ExportSequence& sequence_;
  McapFile file_;
  std::uint16_t mounts_ = 0;
  std::uint16_t poses_ = 0, odometry_ = 0;
  std::vector<std::uint16_t> clouds_;    // channel of each sensor's points
  std::map<std::uint64_t, Pose> drive_;  // world from vehicle, by time stamp (ns)
  std::map<std::uint64_t, Pose>::const_iterator nextPose_ = drive_.begin();
  std::optional<std::uint16_t> objects_{};  // channel of the objects; set when the first objects are added
};

// Throws InputError if frames of the robot's URDF would have two parents.
void checkRobot(const ExportPlan& plan) {
  const std::vector<std::string>& links = plan.ros.links;
  if (!links.empty() && links.front() != plan.ros.vehicle) {
    throw InputError({plan.ros.robot.string()},
                     "the root link is '{1}', but the frame of the vehicle is '{2}': give --frames {0},{1}",
                     plan.ros.world, links.front(), plan.ros.vehicle);
  }
  for (const SensorRecord* const sensor : plan.sensors) {
    if (std::ranges::find(links, sensor->name) == links.end()) continue;
    throw InputError({plan.ros.robot.string()},
                     "has a link '{}', and so is the frame of a sensor named: give the sensor another name in the "
                     "pipeline, or leave out --robot",
                     sensor->name);
  }
}

class Mcap : public ExportLayout {
 public:
  void check(const ExportPlan& plan) const override {
    for (const SensorRecord* sensor : plan.sensors) {
      if (sensor->name == plan.ros.world || sensor->name == plan.ros.vehicle) {
        refuse(plan,
               "the sensor '{0}' has the name of a frame: that of the world is '{1}' and that of the vehicle '{2}'. "
               "Name other frames with --frames, or select other sensors with --sensor",
               sensor->name, plan.ros.world, plan.ros.vehicle);
      }
    }
    checkRobot(plan);
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
