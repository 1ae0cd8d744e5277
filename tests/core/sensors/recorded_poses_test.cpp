#include "sensors/recorded_poses.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "sensors/trajectory.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class RecordedPosesFiles : public testing::Test {
 protected:
  Trajectory drive(const std::string& recorded, const std::string& more = "") const {
    const std::string file = (folder_.path() / "trip.yaml").string();
    return readTrajectory(parseYaml("{recorded: {" + recorded + "}" + more + "}", file), "trip", 0.1);
  }
  std::string refusal(const std::string& recorded, const std::string& more = "") const {
    return messageOf([&] { drive(recorded, more); });
  }

  TemporaryFolder folder_;
};

Vec3d headingOf(const Pose& pose) {
  return toMatrix(pose.rotation).x;
}

// A circle of 20 m, in which the vehicle heads along: in between, a cubic curve is within millimetres of it.
TEST_F(RecordedPosesFiles, PassThroughEachPoseAndCloseToTheWayInBetween) {
  std::string tum = "# time x y z qx qy qz qw\n";
  const auto place = [](double t) { return Vec3d{20 * std::cos(t / 4), 20 * std::sin(t / 4), 0.1 * t}; };
  for (int i = 0; i <= 40; ++i) {
    const double t = 0.2 * i;
    const Quat q = fromYawPitchRoll(t / 4 + kPi / 2, 0, 0);
    const Vec3d p = place(t);
    tum += fmt::format("{:.9f} {:.9f} {:.9f} {:.9f} {} {} {:.12f} {:.12f}\n", 1.6e9 + t, p.x, p.y, p.z, q.x, q.y, q.z,
                       q.w);
  }
  folder_.write("trip.txt", tum);
  const Trajectory drive = this->drive("file: trip.txt, format: tum");
  EXPECT_EQ(drive.frames(), 81u);  // 8 s, of 0.1 s each
  for (std::uint32_t frame = 0; frame < 80; ++frame) {
    for (const double dt : {0.0, 0.05}) {
      const double t = 0.1 * frame + dt;
      const bool recorded = frame % 2 == 0 && dt == 0;
      const bool end = t < 0.2 || t > 7.8;  // where no pose before or behind tells of the curve
      const Pose pose = drive.pose(frame, dt);
      EXPECT_LT(length(pose.translation - place(t)), recorded ? 1e-6 : end ? 5e-3 : 2e-4) << t;
      EXPECT_NEAR(std::atan2(headingOf(pose).y, headingOf(pose).x), std::remainder(t / 4 + kPi / 2, 2 * kPi), 1e-6);
    }
  }
  EXPECT_THAT(drive.about(), HasSubstr("41 poses in 8 s"));
  EXPECT_FALSE(drive.still());
}

// A camera that looks along KITTI's z drives 10 m ahead, 3 m to its right, and turns right by 90 degrees.
TEST_F(RecordedPosesFiles, KittiTurnsTheCamerasAxes) {
  folder_.write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 1 3 0 1 0 -1 -1 0 0 10\n");
  const Trajectory drive = this->drive("file: poses.txt, format: kitti, interval: 2", ", every_s: 2");
  ASSERT_EQ(drive.frames(), 2u);
  EXPECT_LT(length(drive.pose(1, 0).translation - Vec3d{10, -3, 1}), 1e-12);
  EXPECT_LT(length(headingOf(drive.pose(1, 0)) - Vec3d{0, -1, 0}), 1e-12);
  EXPECT_LT(length(drive.pose(0, 0).translation), 1e-12);
}

// With a calibration the poses are those of the scanner: here 0.3 m behind the camera and as high.
TEST_F(RecordedPosesFiles, KittiTakesTheScannersPlace) {
  folder_.write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 1 0 0 1 0 0 -1 0 0 10\n");
  folder_.write("calib.txt", "P0: 1 0 0 0 0 1 0 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 -0.3\n");
  folder_.write("times.txt", "0\n0.5\n");
  const Trajectory drive =
      this->drive("file: poses.txt, format: kitti, times: times.txt, calib: calib.txt", ", every_s: 0.5");
  // The camera is at 10.3 m from the scanner's first place; the scanner now stands 0.3 m to the left of it.
  const Vec3d at = drive.pose(1, 0).translation;
  EXPECT_LT(length(at - Vec3d{10.3, 0.3, 0}), 1e-12) << at.x << " " << at.y << " " << at.z;
}

TEST_F(RecordedPosesFiles, TablesNameTheirColumns) {
  folder_.write("a.csv", "x;y;z;yaw_deg;time_ms\n0;0;1;90;1000\n0;5;1;90;2000\n");
  const Pose degrees = drive("file: a.csv").pose(5, 0);
  EXPECT_LT(length(degrees.translation - Vec3d{0, 2.5, 1}), 1e-12);
  EXPECT_LT(length(headingOf(degrees) - Vec3d{0, 1, 0}), 1e-12);

  folder_.write("b.csv", "time,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,5,0,0,0.5,0.5,0.5,0.5\n");
  EXPECT_LT(length(headingOf(drive("file: b.csv").pose(10, 0)) - Vec3d{0, 1, 0}), 1e-9);

  // Without a heading: along the way, also before it begins to move and while it waits.
  folder_.write("c.csv", "time,x,y,z\n0,0,0,0\n1,0,0,0\n2,0,0,0\n3,0,4,0\n4,0,8,0\n5,0,8,0\n6,0,8,0\n7,0,8,0\n");
  for (const std::uint32_t frame : {0u, 10u, 35u, 60u, 70u}) {
    EXPECT_LT(length(headingOf(drive("file: c.csv").pose(frame, 0)) - Vec3d{0, 1, 0}), 1e-9) << frame;
  }
}

// Angles without a unit that are more than a turn are degrees, or radians that nobody wrapped.
TEST_F(RecordedPosesFiles, AnglesBeyondATurnNeedAUnit) {
  const auto write = [&](const std::string& name) {
    folder_.write("a.csv", "time,x,y,z," + name + "\n0,0,0,0,1.5\n1,0,5,0,7.85\n");
  };
  write("yaw");
  EXPECT_THAT(refusal("file: a.csv"),
              AllOf(HasSubstr("a.csv:3"), HasSubstr("the yaw 7.85"), HasSubstr("yaw_deg"), HasSubstr("yaw_rad")));
  for (const char* name : {"yaw_rad", "yaw [rad]"}) {
    write(name);
    EXPECT_LT(length(headingOf(drive("file: a.csv").pose(10, 0)) - Vec3d{0, 1, 0}), 0.01) << name;
  }
}

TEST_F(RecordedPosesFiles, OfACameraAreTurned) {
  // Looks along world y with its x axis along world x: the vehicle heads along y, and up is up.
  const Mat3 worldFromCamera{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
  const Quat q = fromMatrix(worldFromCamera);
  std::string tum;
  for (const double t : {0.0, 1.0}) tum += fmt::format("{} 0 {} 0 {} {} {} {}\n", t, t, q.x, q.y, q.z, q.w);
  folder_.write("cam.txt", tum);
  const Pose pose = drive("file: cam.txt, format: tum, frame: camera").pose(3, 0);
  EXPECT_LT(length(headingOf(pose) - Vec3d{0, 1, 0}), 1e-9);
  EXPECT_LT(length(toMatrix(pose.rotation).z - Vec3d{0, 0, 1}), 1e-9);
}

TEST_F(RecordedPosesFiles, StartWhereTheyAreWanted) {
  folder_.write("a.csv",
                "time,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,500000,4000000,100,30,2,1\n1,500010,4000000,101,30,2,1\n");
  const Trajectory drive = this->drive("file: a.csv, start: {position: [1, 2, 3], yaw_deg: 120}");
  const Pose first = drive.pose(0, 0);
  EXPECT_LT(length(first.translation - Vec3d{1, 2, 3}), 1e-9);
  EXPECT_NEAR(std::atan2(headingOf(first).y, headingOf(first).x), radians(120), 1e-9);
  EXPECT_NEAR(headingOf(first).z, -std::sin(radians(2)), 1e-9);  // up is still up
  EXPECT_LT(length(drive.pose(10, 0).translation - Vec3d{1, 12, 4}), 1e-6);
}

TEST_F(RecordedPosesFiles, DoubtsWhatCanHardlyBeMeant) {
  const auto doubt = [&](const std::string& poses) {
    folder_.write("d.csv", poses);
    return drive("file: d.csv").doubt();
  };
  EXPECT_EQ(doubt("time,x,y,z,yaw_deg\n0,0,0,0,0\n1,5,0,0,0\n"), "");
  EXPECT_EQ(doubt("time,x,y,z,yaw_deg\n0,0,0,0,0\n1,9,0,0,0\n2,8,0,0,0\n"), "") << "it may drive back";
  EXPECT_THAT(doubt("time,x,y,z,yaw_deg\n0,0,0,0,180\n1,5,0,0,180\n"), HasSubstr("drives backwards"));
  // Degrees that count as radians.
  EXPECT_THAT(doubt("time,x,y,z,roll,pitch,yaw\n0,0,0,0,0,0.5,0\n1,5,0,0,0,0.5,0\n"), HasSubstr("tilted by 29"));
  EXPECT_THAT(doubt("time,x,y,z,yaw\n0,0,0,0,0.9\n1,5,0,0,0.9\n"), HasSubstr("column yaw_deg"));
  EXPECT_EQ(doubt("time,x,y,z,yaw_deg\n0,0,0,0,90\n1,0.1,0,0,90\n"), "") << "it hardly moves";
  EXPECT_THAT(doubt("time,x,y,z,yaw_deg\n0,0,0,0,0\n0.001,5,0,0,0\n"), HasSubstr("5000 m/s"));
  EXPECT_THAT(doubt("time,x,y,z,yaw_deg\n0,0,0,0,90\n1,5,0,0,90\n"), HasSubstr("differs from its direction of travel"));
  EXPECT_THAT(doubt("time,x,y,z\n0,0,0,0\n100,5,0,0\n"), HasSubstr("100 s apart: are their times in seconds"));
  EXPECT_THAT(doubt("time,x,y,z,roll,pitch,yaw\n0,0,0,0,0.5,1,1.57\n1,0,5,0,0.5,1,1.57\n"),
              HasSubstr("tilted by 62 degrees on average: are roll and pitch in degrees"));
  EXPECT_EQ(doubt("time,x,y,z,roll_deg,pitch_deg\n0,0,0,0,5,-15\n1,5,0,0,5,-15\n"), "") << "it may climb";
  EXPECT_THAT(doubt("time,x,y,z,roll_deg\n0,0,0,0,180\n1,5,0,0,180\n"), HasSubstr("upside down"));
}

constexpr const char* kScenes = R"([{"token": "s1", "name": "scene-0061"}, {"token": "s2", "name": "scene-0103"}])";
constexpr const char* kSamples = R"([{"token": "a", "scene_token": "s1"}, {"token": "b", "scene_token": "s2"}])";
constexpr const char* kData =
    R"([{"token": "1", "sample_token": "a", "ego_pose_token": "p2", "filename": "sweeps/LIDAR_TOP/x.bin", "calibrated": {"a": [{}]}},
        {"token": "2", "sample_token": "a", "ego_pose_token": "p1", "filename": "samples/LIDAR_TOP/y.bin"},
        {"token": "3", "sample_token": "a", "ego_pose_token": "p3", "filename": "samples/CAM_FRONT/z.jpg"},
        {"token": "4", "sample_token": "b", "ego_pose_token": "p4", "filename": "samples/LIDAR_TOP/w.bin"}])";
constexpr const char* kPoses =
    R"([{"token": "p2", "timestamp": 1532402928000000, "rotation": [0, 0, 0, 1], "translation": [410, 1181, 0]},
        {"token": "p3", "timestamp": 1532402927800000, "rotation": [1, 0, 0, 0], "translation": [0, 0, 0]},
        {"token": "p1", "timestamp": 1532402927500000, "rotation": [0, 0, 0, 1], "translation": [411, 1180, 0]},
        {"token": "p4", "timestamp": 1532402927600000, "rotation": [1, 0, 0, 0], "translation": [9, 9, 9]}])";

TEST_F(RecordedPosesFiles, NuScenesGivesThePosesOfTheScansOfAScene) {
  folder_.write("scene.json", kScenes);
  folder_.write("sample.json", kSamples);
  folder_.write("sample_data.json", kData);
  folder_.write("ego_pose.json", kPoses);
  const Trajectory drive = this->drive("file: ego_pose.json, scene: scene-0061");
  EXPECT_EQ(drive.frames(), 6u);
  EXPECT_LT(length(drive.pose(0, 0).translation - Vec3d{411, 1180, 0}), 1e-9);
  EXPECT_LT(length(drive.pose(5, 0).translation - Vec3d{410, 1181, 0}), 1e-6);
  EXPECT_LT(length(headingOf(drive.pose(2, 0)) - Vec3d{-1, 0, 0}), 1e-9);
  EXPECT_THAT(refusal("file: ego_pose.json, scene: scene-0062"), HasSubstr("did you mean 'scene-0061'"));
  EXPECT_THAT(refusal("file: ego_pose.json, scene: scene-0103"), HasSubstr("has 1 poses"));
  folder_.write("sample.json", "[{\"token\": \"a\"");
  EXPECT_THAT(refusal("file: ego_pose.json, scene: scene-0061"),
              AllOf(HasSubstr("sample.json"), HasSubstr("not a table")));
  folder_.write("sample.json", "{\"token\": \"a\"}");
  EXPECT_THAT(refusal("file: ego_pose.json, scene: scene-0061"),
              AllOf(HasSubstr("sample.json"), HasSubstr("not a table")));
}

TEST_F(RecordedPosesFiles, MistakesAreNamedWithTheirLine) {
  const auto refused = [&](const std::string& name, const std::string& text, const std::string& more = "") {
    folder_.write(name, text);
    return refusal("file: " + name + more);
  };
  EXPECT_THAT(refused("a.txt", "1 2 3"), HasSubstr("give `format: kitti`"));
  EXPECT_THAT(refused("a.txt", "0 0 0 0 0 0 0 1\n# note\n1 0 0 x 0 0 0 1\n", ", format: tum"),
              AllOf(HasSubstr("a.txt:3"), HasSubstr("not a number")));
  EXPECT_THAT(refused("a.txt", "0 0 0 0 0 0 0\n", ", format: tum"),
              AllOf(HasSubstr("a.txt:1"), HasSubstr("7 numbers")));
  EXPECT_THAT(refused("a.txt", "0 0 0 0 0 0 0 1\n0 1 0 0 0 0 0 1\n", ", format: tum"),
              AllOf(HasSubstr("a.txt:2"), HasSubstr("not after that of the pose before it")));
  EXPECT_THAT(refused("a.txt", "0 0 0 0 1 1 0 1\n1 1 0 0 0 0 0 1\n", ", format: tum"),
              HasSubstr("order of its numbers"));
  EXPECT_THAT(refused("a.txt", "", ", format: tum"), HasSubstr("is empty"));
  EXPECT_THAT(refused("a.txt", "0 0 0 0 0 0 0 1\n", ", format: tum"), HasSubstr("has 1 poses"));
  EXPECT_THAT(refused("a.txt", "1.4e18 0 0 0 0 0 0 1\n1.5e18 0 0 0 0 0 0 1\n", ", format: tum"),
              AllOf(HasSubstr("a.txt:1"), HasSubstr("times must be in seconds")));
  EXPECT_THAT(refused("a.txt", "# timestamp tx ty tz qw qx qy qz\n0 0 0 0 1 0 0 0\n", ", format: tum"),
              HasSubstr("names qw before qx"));
  const std::string kitti = "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n";
  EXPECT_THAT(refused("k.txt", kitti, ", format: kitti"), HasSubstr("either `times`"));
  EXPECT_THAT(refused("k.txt", "2 0 0 0 0 1 0 0 0 0 1 0\n", ", format: kitti, interval: 1"),
              AllOf(HasSubstr("k.txt:1"), HasSubstr("rigid")));
  EXPECT_THAT(refused("k.txt", "1 0 0 0 0 1 0 0 0 0 -1 0\n", ", format: kitti, interval: 1"), HasSubstr("left-handed"));
  EXPECT_THAT(refused("k.txt", kitti + "nan 0 0 0 0 1 0 0 0 0 1 0\n", ", format: kitti, interval: 1"),
              AllOf(HasSubstr("k.txt:3"), HasSubstr("not a number")));
  folder_.write("t.txt", "0\n");
  EXPECT_THAT(refused("k.txt", kitti, ", format: kitti, times: t.txt"), HasSubstr("1 times for the 2 poses"));
  folder_.write("c.txt", "P0: 1\n");
  EXPECT_THAT(refused("k.txt", kitti, ", format: kitti, interval: 1, calib: c.txt"), HasSubstr("no line `Tr"));
  EXPECT_THAT(refused("a.csv", "x,y,z\n0,0,0\n"), AllOf(HasSubstr("a.csv:1"), HasSubstr("no time")));
  EXPECT_THAT(refused("a.csv", "time,x,y\n0,0,0\n"), HasSubstr("no column z"));
  EXPECT_THAT(refused("a.csv", "time,x,y,z,qx\n0,0,0,0,0\n"), HasSubstr("no column qw"));
  EXPECT_THAT(refused("a.csv", "time,x,y,z,x\n0,0,0,0,0\n"), HasSubstr("is listed twice"));
  EXPECT_THAT(refused("a.csv", "time,x,y,z\n0,0,0,0\n1,0,0\n"), AllOf(HasSubstr("a.csv:3"), HasSubstr("3 cells")));
  EXPECT_THAT(refused("a.csv", "time,x,y,z\n0,0,0,0\n1,2e9,0,0\n"), HasSubstr("farther than"));
  EXPECT_THAT(refused("a.csv", "time,x,y,z\n0,0,0,0\n1,2,0,0\n", ", scene: x"), HasSubstr("scene is not for"));
  EXPECT_THAT(refusal("file: gone.csv"), HasSubstr("gone.csv"));
  EXPECT_THAT(refusal("file: a.csv", ", speed: 4"), HasSubstr("speed is for paths that are driven: a recording"));
}

// Trackers write NaN where they lost the vehicle.
TEST_F(RecordedPosesFiles, PosesWithNanAreLeftOutAndTold) {
  const auto warnings = [&](const std::string& recorded) {
    testing::internal::CaptureStderr();
    EXPECT_LT(length(drive(recorded).pose(10, 0).translation - Vec3d{5, 0, 0}), 1e-9);
    return testing::internal::GetCapturedStderr();
  };
  folder_.write("a.txt", "0 0 0 0 0 0 0 1\r\n0.5 nan nan nan 0 0 0 1\r\n0.6 1 NaN 1 0 0 0 1\r\n2 10 0 0 0 0 0 1");
  EXPECT_THAT(warnings("file: a.txt, format: tum"),
              HasSubstr("a.txt: left out: 2 poses with NaN, the first in line 2"));
  folder_.write("a.csv", "\xEF\xBB\xBFtime,x,y,z,speed,\n0,0,0,0,nan,\n1,nan,0,0,1,\n2,10,0,0,1,\n");
  EXPECT_THAT(warnings("file: a.csv"),
              AllOf(HasSubstr("1 poses with NaN, the first in line 3"), HasSubstr("1 unknown 'speed'")));
}

// The ground truth of the EuRoC dataset: names behind a #, times in ns, w first.
TEST_F(RecordedPosesFiles, EurocsTablesAreRead) {
  folder_.write(
      "data.csv",
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v_RS_R_x "
      "[m s^-1]\n1403636580838555648,1,2,3,0.5,0.5,0.5,0.5,0\n1403636581838555648,1,7,3,0.5,0.5,0.5,0.5,5\n");
  const Pose pose = drive("file: data.csv").pose(10, 0);
  EXPECT_LT(length(pose.translation - Vec3d{1, 7, 3}), 1e-6);
  EXPECT_LT(length(headingOf(pose) - Vec3d{0, 1, 0}), 1e-9);
  folder_.write("t.csv", "timestamp [ms],x [m],y [m],z [m],yaw [deg]\n0,0,0,0,90\n1000,0,5,0,90\n");
  EXPECT_LT(length(headingOf(drive("file: t.csv").pose(5, 0)) - Vec3d{0, 1, 0}), 1e-9);
  for (const char* x : {"x [mm]", "p_RS_R_x [mm]"}) {
    folder_.write("t.csv", std::string("time,") + x + ",y,z\n0,0,0,0\n1,5,0,0\n");
    EXPECT_THAT(refusal("file: t.csv"), HasSubstr("no column x"));
  }
  folder_.write("t.csv", "timestamp,x,y,z\n0,0,0,0\n1,5,0,0\n");
  EXPECT_THAT(refusal("file: t.csv"), HasSubstr("the column timestamp does not show its unit"));
}

// Clocks of simulators begin at 0: times with decimals are in seconds, and units stand where others write them.
TEST_F(RecordedPosesFiles, ClocksOfSimulatorsAreRead) {
  for (const auto& [name, times] :
       std::map<std::string, std::vector<const char*>>{{"timestamp", {"0.0", "1.0"}},
                                                       {"timestamp ", {"0", "1.000"}},
                                                       {"Time/s", {"0", "1"}},
                                                       {"time (sec)", {"0", "1"}},
                                                       {"time_s", {"0", "1"}},
                                                       {"Time [\u00b5s]", {"0", "1000000"}},
                                                       {"timestamp_ns", {"0", "1000000000"}},
                                                       {"timestamp/ms", {"0", "1000"}}}) {
    folder_.write("t.csv", fmt::format("{},x (m),Y/m,z,yaw/deg\n{},0,0,0,90\n{},0,5,0,90\n", name, times[0], times[1]));
    const Trajectory drive = this->drive("file: t.csv");
    EXPECT_EQ(drive.frames(), 11u) << name;
    EXPECT_LT(length(drive.pose(5, 0).translation - Vec3d{0, 2.5, 0}), 1e-9) << name;
    EXPECT_LT(length(headingOf(drive.pose(5, 0)) - Vec3d{0, 1, 0}), 1e-9) << name;
  }
}

TEST_F(RecordedPosesFiles, RossTablesAreRead) {
  const auto ends = [&](const std::string& table, const std::string& leftOut = "") {
    folder_.write("t.csv", table);
    testing::internal::CaptureStderr();
    const Pose pose = drive("file: t.csv").pose(10, 0);
    const std::string warned = testing::internal::GetCapturedStderr();
    EXPECT_EQ(warned.empty(), leftOut.empty()) << warned;
    EXPECT_THAT(warned, HasSubstr(leftOut));
    EXPECT_LT(length(pose.translation - Vec3d{1, 7, 3}), 1e-6) << table;
    EXPECT_LT(length(headingOf(pose) - Vec3d{0, 1, 0}), 1e-9) << table;
  };
  const std::string first = ",1,2,3,0.5,0.5,0.5,0.5", last = ",1,7,3,0.5,0.5,0.5,0.5";
  std::string names;
  for (const char* axis : {"x", "y", "z"}) names += std::string(",field.pose.pose.position.") + axis;
  for (const char* axis : {"x", "y", "z", "w"}) names += std::string(",field.pose.pose.orientation.") + axis;
  ends("%time,field.header.seq,field.header.stamp,field.header.frame_id" + names +
           ",field.pose.covariance0,field.pose.covariance1,field.twist.twist.linear.x\n"
           "1700000000123456789,0,1700000000123456789,odom" +
           first +
           ",0,0,0\n"
           "1700000001123456789,1,1700000001123456789,odom" +
           last + ",0,0,0\n",
       "left out: 1 columns of times in messages (header.stamp)");
  ends("time,timestamp,secs,x,y,z,qx,qy,qz,qw\n5,0,nan" + first + "\n6,9,8" + last + "\n",
       "left out: 1 further columns of times ('secs'), 1 further columns of times ('timestamp')\n");
  ends(
      "header.stamp.sec,header.stamp.nanosec,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,"
      "pose.orientation.y,pose.orientation.z,pose.orientation.w\n1700000000,900000000" +
      first + "\n1700000001,900000000" + last + "\n");
  ends("sec,nanosec,x,y,z,qx,qy,qz,qw\n1700000000,900000000" + first + "\n1700000001,900000000" + last + "\n");
  for (const auto& [from, to] : {std::pair{"1700000000123456789", "1700000001123456789"},
                                 {"1700000000123456", "1700000001123456"},
                                 {"1700000000123", "1700000001123"},
                                 {"1700000000.5", "1700000001.5"}}) {
    ends("timestamp,x,y,z,qx,qy,qz,qw\n" + (from + first) + "\n" + to + last + "\n");
  }
  folder_.write("t.csv", "0.0,1,0.0,0.0\n1.0,2,0.0,0.0\n");
  EXPECT_THAT(refusal("file: t.csv"), HasSubstr("t.csv:1: the first line must name the columns time"));
}

// Poses that are closer than 5 cm have a heading too: here a circle, at 100 Hz.
TEST_F(RecordedPosesFiles, TablesWithoutAHeadingHeadAlongAtAnyRate) {
  for (const double rate : {5.0, 100.0, 1000.0}) {
    std::string table = "\"time\",x,y,z\n";
    const int count = static_cast<int>(10 * rate);
    for (int i = 0; i <= count; ++i) {
      const double angle = 0.2 * i / rate;  // 2 m/s on a radius of 10 m
      table += fmt::format("{},{},{},0\n", i / rate, 10 * std::sin(angle), -10 * std::cos(angle));
    }
    folder_.write("circle.csv", table);
    const Trajectory drive = this->drive("file: circle.csv");
    for (double t = 0.5; t < 9.5; t += 0.1) {
      const Vec3d ahead = headingOf(drive.pose(0, t));
      EXPECT_NEAR(std::remainder(std::atan2(ahead.y, ahead.x) - 0.2 * t, 2 * kPi), 0, 0.01) << rate << " Hz, " << t;
    }
    EXPECT_EQ(drive.doubt(), "");
  }
}

// It stands, and then goes: it never backs up before, nor is it ever beyond where it goes.
TEST_F(RecordedPosesFiles, NeverOvershoot) {
  folder_.write("p.csv", "time,x,y,z\n0,0,0,0\n10,0,0,0\n10.1,1,0,0\n10.2,2,0,0\n12,2,0,0\n13,2,0,0\n");
  const Trajectory drive = this->drive("file: p.csv");
  double before = 0;
  for (double t = 0; t < 13; t += 0.01) {
    const double x = drive.pose(0, t).translation.x;
    EXPECT_GE(x, before - 1e-12) << t;
    EXPECT_LE(x, 2 + 1e-12) << t;
    before = x;
  }
}

TEST_F(RecordedPosesFiles, ColumnsThatSayTheSameTwiceAreRefused) {
  const auto head = [&](const std::string& names) {
    folder_.write("t.csv", names + "\n0,0,0,0,0,0\n1,1,0,0,0,0\n");
    return refusal("file: t.csv");
  };
  EXPECT_THAT(head("time,x,y,z,time_ms,a"), AllOf(HasSubstr("t.csv:1"), HasSubstr("two columns of time")));
  EXPECT_THAT(head("time,x,y,z,yaw,yaw_deg"), HasSubstr("states yaw by two columns"));
  EXPECT_THAT(head("time,x,y,z,qy,qz"), HasSubstr("no column qw"));
  EXPECT_THAT(head("time,x,y,z,heading_deg,a"), HasSubstr("name it yaw"));
  folder_.write("u.csv", "time,x,y,z\n0,0,0,0\n1,1,0,0\n");
  EXPECT_THAT(refusal("file: u.csv, start: {position: [1, 2, 3], pitch_deg: 4}"), HasSubstr("pitch_deg"));
}

}  // namespace
}  // namespace scanmill
