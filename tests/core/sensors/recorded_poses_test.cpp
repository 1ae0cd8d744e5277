#include "sensors/recorded_poses.h"

#include <fmt/format.h>

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
  for (const auto& [poses, words] : std::vector<std::pair<std::string, const char*>>{
           {"time,x,y,z,yaw_deg\n0,0,0,0,0\n1,9,0,0,0\n2,8,0,0,0\n", ""},  // it may drive back
           {"time,x,y,z,yaw_deg\n0,0,0,0,90\n1,0.1,0,0,90\n", ""},         // it hardly moves
           {"time,x,y,z,roll_deg,pitch_deg\n0,0,0,0,5,-15\n1,5,0,0,5,-15\n", ""},
           {"time,x,y,z,yaw_deg\n0,0,0,0,180\n1,5,0,0,180\n", "heads 180 degrees off its way"},
           {"time,x,y,z,yaw\n0,0,0,0,0.9\n1,5,0,0,0.9\n", "columns yaw_deg"},  // degrees that count as radians
           {"time,x,y,z,yaw_deg\n0,0,0,0,0\n0.001,5,0,0,0\n", "5000 m/s (at 0.001 s)"},
           {"time,x,y,z,roll,pitch,yaw\n0,0,0,0,0.5,1,1.57\n1,0,5,0,0.5,1,1.57\n", "tilted by 62 degrees on average"},
           {"time,x,y,z,roll_deg\n0,0,0,0,180\n1,5,0,0,180\n", "tilted by 180 degrees"}}) {
    folder_.write("d.csv", poses);
    const std::string doubt = drive("file: d.csv").warning();
    EXPECT_THAT(doubt, HasSubstr(words)) << poses;
    EXPECT_EQ(doubt.empty(), *words == '\0') << poses << doubt;
  }
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
  folder_.write("one.txt", "0\n");
  folder_.write("none.txt", "P0: 1\n");
  const std::string kitti = "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n";
  const char* const tum = ", format: tum";
  const char* const byInterval = ", format: kitti, interval: 1";
  struct Case {
    const char* name;
    std::string text, more, words;
  };
  for (const Case& c : std::vector<Case>{
           {"a.txt", "1 2 3", "", "give `format: kitti`"},
           {"a.txt", "0 0 0 0 0 0 0 1\n# note\n1 0 0 x 0 0 0 1\n", tum, "a.txt:3: 'x' is not a number"},
           {"a.txt", "0 0 0 0 0 0 0 1\n1 nan 0 0 0 0 0 1\n", tum, "a.txt:2: 'nan' is not a number"},
           {"a.txt", "0 0 0 0 0 0 0\n", tum, "a.txt:1: has 7 numbers"},
           {"a.txt", "0 0 0 0 0 0 0 1\n0 1 0 0 0 0 0 1\n", tum, "a.txt:2: pose 2 has the time"},
           {"a.txt", "0 0 0 0 1 1 0 1\n1 1 0 0 0 0 0 1\n", tum, "order of its numbers"},
           {"a.txt", "", tum, "is empty"},
           {"a.txt", "0 0 0 0 0 0 0 1\n", tum, "has 1 poses"},
           {"a.txt", "1.4e18 0 0 0 0 0 0 1\n1.5e18 0 0 0 0 0 0 1\n", tum, "a.txt:1: has the time 1.4e+18 s"},
           {"a.txt", "# timestamp tx ty tz qw qx qy qz\n0 0 0 0 1 0 0 0\n", tum, "names qw before qx"},
           {"k.txt", kitti, ", format: kitti", "either `times`"},
           {"k.txt", "2 0 0 0 0 1 0 0 0 0 1 0\n", byInterval, "k.txt:1: is not a rigid"},
           {"k.txt", "1 0 0 0 0 1 0 0 0 0 -1 0\n", byInterval, "left-handed"},
           {"k.txt", kitti, ", format: kitti, times: one.txt", "1 times for the 2 poses"},
           {"k.txt", kitti, ", format: kitti, interval: 1, calib: none.txt", "no line `Tr"},
           {"a.csv", "x,y,z\n0,0,0\n", "", "a.csv:1: the first line must name the columns time"},
           {"a.csv", "0.0,1,0.0,0.0\n1.0,2,0.0,0.0\n", "", "a.csv:1: the first line must name"},
           {"a.csv", "timestamp,x,y,z\n0,0,0,0\n1,5,0,0\n", "", "it has no time"},
           {"a.csv", "%time,field.pose.pose.position.x\n0,0\n1,5\n", "", "no column x"},
           {"a.csv", "time,x,y\n0,0,0\n", "", "no column z"},
           {"a.csv", "time,x [mm],y,z\n0,0,0,0\n1,5,0,0\n", "", "no column x"},
           {"a.csv", "time,x,y,z,qx\n0,0,0,0,0\n", "", "no column qw"},
           {"a.csv", "time,x,y,z,time_ms\n0,0,0,0,0\n", "", "a.csv:1: the table has two columns of time"},
           {"a.csv", "time,x,y,z,yaw,yaw_deg\n0,0,0,0,0,0\n", "", "states yaw by two columns"},
           {"a.csv", "time,x,y,z,yaw\n0,0,0,0,1.5\n1,0,5,0,7.85\n", "", "a.csv:3: has the yaw 7.85"},
           {"a.csv", "time,x,y,z\n0,0,0,0\n1,2e9,0,0\n", "", "farther than"},
           {"a.csv", "time,x,y,z\n0,0,0,0\n1,2,0,0\n", ", scene: x", "scene is not for"},
           {"a.csv", "time,x,y,z\n0,0,0,0\n1,1,0,0\n", ", start: {position: [1, 2, 3], pitch_deg: 4}", "pitch_deg"}}) {
    folder_.write(c.name, c.text);
    EXPECT_THAT(refusal(std::string("file: ") + c.name + c.more), HasSubstr(c.words)) << c.text;
  }
  EXPECT_THAT(refusal("file: gone.csv"), HasSubstr("gone.csv"));
  EXPECT_THAT(refusal("file: a.csv", ", speed: 4"), HasSubstr("speed is for paths that are driven: a recording"));
}

TEST_F(RecordedPosesFiles, OtherColumnsAreTold) {
  folder_.write("a.csv", "\xEF\xBB\xBFtime,x,y,z,speed,\n0,0,0,0,nan,\n2,10,0,0,1,\n");
  EXPECT_THAT(printedBy([&] { EXPECT_NEAR(drive("file: a.csv").pose(10, 0).translation.x, 5, 1e-9); }),
              HasSubstr("left out: 1 unknown 'speed'"));
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
}

TEST_F(RecordedPosesFiles, TablesStateTheirUnits) {
  for (const auto& [name, second] : std::map<std::string, const char*>{{"Time/s", "1"},
                                                                       {"time (sec)", "1"},
                                                                       {"time_s", "1"},
                                                                       {"Time [\u00b5s]", "1000000"},
                                                                       {"timestamp_ns", "1000000000"},
                                                                       {"timestamp/ms", "1000"}}) {
    folder_.write("t.csv", fmt::format("{},x (m),Y/m,z,yaw/deg\n0,0,0,0,90\n{},0,5,0,90\n", name, second));
    const Trajectory drive = this->drive("file: t.csv");
    EXPECT_EQ(drive.frames(), 11u) << name;
    EXPECT_LT(length(drive.pose(5, 0).translation - Vec3d{0, 2.5, 0}), 1e-9) << name;
    EXPECT_LT(length(headingOf(drive.pose(5, 0)) - Vec3d{0, 1, 0}), 1e-9) << name;
  }
  // Radians that nobody wrapped are read if their column says that they are radians.
  folder_.write("t.csv", "time,x,y,z,yaw [rad]\n0,0,0,0,1.5\n1,0,5,0,7.85\n");
  EXPECT_LT(length(headingOf(drive("file: t.csv").pose(10, 0)) - Vec3d{0, 1, 0}), 0.01);
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
    EXPECT_EQ(drive.warning(), "");
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

}  // namespace
}  // namespace scanmill
