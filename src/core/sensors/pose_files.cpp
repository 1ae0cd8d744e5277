#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "base/file.h"
#include "base/format_support.h"
#include "base/text_scan.h"
#include "config/fields.h"
#include "sensors/recorded_poses.h"
#include "sensors/text_table.h"

namespace scanmill {
namespace {

// Limit of the sum of a matrix's deviations from a rotation, and of the deviation of a quaternion's length from 1.
// Rounded numbers in files stay below this limit; larger deviations are mistakes in the file.
constexpr double kMostRotationError = 1e-2;

// Returns the N numbers of `text`, separated by blanks; throws InputError otherwise. `description` is for the message.
template <std::size_t N>
std::array<double, N> numbersOf(std::string_view text, const Location& where, const char* description) {
  const std::vector<std::string_view> words = wordsOf(text);
  if (words.size() != N) {
    throw InputError(where, "has {} numbers, but must have {}: {}", words.size(), N, description);
  }
  std::array<double, N> numbers;
  for (std::size_t i = 0; i < N; ++i) numbers[i] = numberOf(words[i], where);
  return numbers;
}

// Returns the rotation scaled to length 1. Throws InputError if the length of `q` is not about 1.
Quat checkedRotation(const Quat& q, const Location& where) {
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(std::fabs(norm - 1) < kMostRotationError)) {
    throw InputError(where, "the quaternion has the length {:.3g}, not 1: is the order of its numbers right?", norm);
  }
  return {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
}

// Returns the transform whose first three rows are the 12 numbers of a text. Throws InputError if it is not rigid.
Affine readRigidTransform(std::string_view text, const Location& where) {
  const auto m = numbersOf<12>(text, where, "a matrix of 3 rows and 4 columns");
  const Affine affine{{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}, {m[3], m[7], m[11]}};
  // The transpose of a rotation times the rotation is the identity.
  const Mat3 product = transposed(affine.linear) * affine.linear;
  double deviation = std::fabs(determinant(affine.linear) - 1);
  for (const Vec3d& d : {product.x - Vec3d{1, 0, 0}, product.y - Vec3d{0, 1, 0}, product.z - Vec3d{0, 0, 1}}) {
    deviation += std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z);
  }
  if (!(deviation < kMostRotationError)) {
    throw InputError(where, "is not a rigid transform: its first three columns must be orthogonal unit vectors{}",
                     determinant(affine.linear) < 0 ? " of right-handed axes; these are left-handed" : "");
  }
  return affine;
}

// Sets each pose's rotation to the direction of travel: from the last mark before the pose to the first mark after it.
// Marks are poses at least 5 cm apart, so that a vehicle at rest heads for its next mark.
void setHeadingsOfTravel(std::vector<StampedPose>& poses) {
  constexpr double kMarkSpacing = 0.05;  // m, least distance from a mark to the next mark
  const auto positionOf = [&](std::size_t i) { return poses[i].pose.translation; };
  std::vector<std::size_t> marks{0};  // indices of poses at least kMarkSpacing apart
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Vec3d step = positionOf(i) - positionOf(marks.back());
    if (std::hypot(step.x, step.y) >= kMarkSpacing) marks.push_back(i);
  }
  if (marks.size() < 2) return;
  std::size_t mark = 0;  // index in `marks` of the last mark at or before the pose
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (mark + 1 < marks.size() && marks[mark + 1] <= i) ++mark;
    const std::size_t markAfter = std::min(mark + 1, marks.size() - 1);
    // Take the last mark before pose i. Unless it is the first mark, it must be neither pose i itself nor markAfter.
    const std::size_t markBefore = (marks[mark] == i || markAfter == mark) && mark > 0 ? mark - 1 : mark;
    const Vec3d step = positionOf(marks[markAfter]) - positionOf(marks[markBefore]);
    poses[i].pose.rotation =
        fromYawPitchRoll(std::atan2(step.y, step.x), -std::atan2(step.z, std::hypot(step.x, step.y)), 0);
  }
}

// Renames the columns of other programs to the names that readPoseTable() reads. The ground truth of the EuRoC dataset
// may name its times, which are in ns, without a unit.
void renameColumns(TextTable& table) {
  constexpr std::pair<const char*, const char*> kEuroc[] = {
      {"timestamp", "time_ns"}, {"p_rs_r_x", "x"}, {"p_rs_r_y", "y"}, {"p_rs_r_z", "z"},
      {"q_rs_w", "qw"},         {"q_rs_x", "qx"},  {"q_rs_y", "qy"},  {"q_rs_z", "qz"}};
  if (table.has("p_rs_r_x")) {
    for (const auto& [eurocName, name] : kEuroc) table.rename(eurocName, name);
  }
  for (const char* unit : {"s", "ms", "us", "ns"}) {
    table.rename(fmt::format("timestamp_{}", unit), fmt::format("time_{}", unit).c_str());
  }
}

constexpr std::array kQuaternion{"qw", "qx", "qy", "qz"};

enum class Rotations { None, Quaternions, Angles };

// Returns the kind of rotations that a table states. Throws InputError if a required column is missing, or if two
// columns state the same angle.
Rotations kindOfRotations(const TextTable& table) {
  if (table.timeName().empty()) {
    throw InputError(table.head(),
                     "the first line must name the columns time (s; or time_ms, time_us, time_ns), x, y, z and "
                     "optionally qw, qx, qy, qz or yaw, pitch, roll, but it has no time");
  }
  for (const char* name : {"x", "y", "z"}) table.require(name);
  Rotations rotations = Rotations::None;
  if (std::ranges::any_of(kQuaternion, [&](const char* name) { return table.has(name); })) {
    rotations = Rotations::Quaternions;
    for (const char* name : kQuaternion) table.require(name);
  }
  const int quaternions = rotations == Rotations::Quaternions ? 1 : 0;
  for (const std::string angle : {"yaw", "pitch", "roll"}) {
    const int columns = int{table.has(angle)} + int{table.has(angle + "_deg")} + int{table.has(angle + "_rad")};
    if (columns + quaternions > 1) {
      throw InputError(table.head(), "the table states {} by two columns: leave out one of them", angle);
    }
    if (columns > 0) rotations = Rotations::Angles;
  }
  return rotations;
}

// Returns an angle (rad) of a row from the column `name` (rad), name_deg or name_rad; 0 if the table has none of them.
// Throws InputError if an angle in the column `name` exceeds a turn, because it is then probably in degrees.
double angleOf(const TextTable& table, std::size_t row, const std::string& name) {
  constexpr double kTurn = 6.3;  // rad
  const double value = table.number(row, name);
  if (std::fabs(value) > kTurn) {
    throw InputError(table.where(row),
                     "has the {0} {1:g}, which in radians is more than a turn: name the column {0}_deg, "
                     "or {0}_rad if radians are meant",
                     name, value);
  }
  return value + radians(table.number(row, name + "_deg")) + table.number(row, name + "_rad");
}

using Json = nlohmann::json;
constexpr std::string_view kLidarScans = "LIDAR_TOP";  // part of the file names of scans

// Calls visit(row) for each row of a table, a list of objects. Each row is freed after the call, because the largest
// table has millions of rows.
void readTableOfNuScenes(const std::filesystem::path& file, const std::function<void(const Json&)>& visit) {
  const std::string bytes = readFile(file);
  try {
    // The parser calls this function at the end of each value; false removes the value from the result.
    const Json withoutRows = Json::parse(bytes, [&](int depth, Json::parse_event_t event, Json& row) {
      if (event != Json::parse_event_t::object_end || depth != 1) return true;
      visit(row);
      return false;
    });
    if (!withoutRows.is_array() || !withoutRows.empty()) {
      throw InputError({file.string()}, "is not a table of nuScenes: it must be a list of objects");
    }
  } catch (const nlohmann::json::exception& e) {
    throw InputError({file.string()}, "is not a table of nuScenes: {}", reasonOf(e));
  }
}

}  // namespace

const FormatSupport kPoseFormat{
    "Recorded poses",
    ".csv, .txt, .json",
    "csv: columns time (s, or time_ms, time_us, time_ns), x, y, z (m), rotation qw, qx, qy, qz, or yaw, pitch and "
    "roll (rad, or yaw_deg ...), with units in their names or behind them, as in Time/s and x [m]; EuRoC's names for "
    "them. tum: lines time x y z qx qy qz qw, times in s. kitti: lines of 12 numbers, with the line Tr of calib.txt. "
    "nuscenes: ego_pose.json, beside scene.json, sample.json and sample_data.json",
    "other columns",
    {.read = {"time time_s time_ms time_us time_ns x y z qw qx qy qz yaw pitch roll yaw_deg pitch_deg roll_deg",
              "yaw_rad pitch_rad roll_rad"},
     .unused = {"v_rs_r_x_ms1 v_rs_r_y_ms1 v_rs_r_z_ms1 b_w_rs_s_x_rads1 b_w_rs_s_y_rads1 b_w_rs_s_z_rads1",
                "b_a_rs_s_x_ms2 b_a_rs_s_y_ms2 b_a_rs_s_z_ms2"}}};

std::vector<Affine> readKittiPoses(const std::filesystem::path& file) {
  const std::string bytes = readFile(file);
  std::vector<Affine> poses;
  for (const TextLine& line : linesOf(bytes, file)) poses.push_back(readRigidTransform(line.text, line.where));
  return poses;
}

std::vector<double> readTimes(const std::filesystem::path& file) {
  const std::string bytes = readFile(file);
  std::vector<double> times;
  for (const TextLine& line : linesOf(bytes, file)) times.push_back(numbersOf<1>(line.text, line.where, "a time")[0]);
  return times;
}

Affine readKittiCalibration(const std::filesystem::path& file) {
  const std::string bytes = readFile(file);
  for (const TextLine& line : linesOf(bytes, file)) {
    const std::size_t colon = line.text.find(':');
    if (line.text.substr(0, colon) != "Tr" && line.text.substr(0, colon) != "Tr_velo_to_cam") continue;
    return readRigidTransform(line.text.substr(colon + 1), line.where);
  }
  throw InputError({file.string()}, "has no line `Tr: 12 numbers`, the transform from the scanner to the camera");
}

std::vector<StampedPose> readTumPoses(const std::filesystem::path& file) {
  const std::string bytes = readFile(file);
  // Refuse a file with a comment that names the columns with qw before qx.
  if (bytes.find("qw") < bytes.find("qx") && bytes.find("qx") != std::string::npos) {
    throw InputError({file.string()},
                     "names qw before qx, but a line must be time x y z qx qy qz qw: make it a .csv table, whose first "
                     "line names the columns (time, x, y, z, qw, qx, qy, qz)");
  }
  std::vector<StampedPose> poses;
  for (const TextLine& line : linesOf(bytes, file)) {
    const auto [time, x, y, z, qx, qy, qz, qw] = numbersOf<8>(line.text, line.where, "time x y z qx qy qz qw");
    poses.push_back({time, {checkedRotation({qw, qx, qy, qz}, line.where), {x, y, z}}, line.where.line});
  }
  return poses;
}

std::vector<StampedPose> readPoseTable(const std::filesystem::path& file) {
  TextTable table(file);
  renameColumns(table);
  LeftOut leftOut;
  for (const std::string& name : table.names()) leftOut.addKeyword(kPoseFormat, name);
  leftOut.warn(file.string());
  const Rotations rotations = kindOfRotations(table);
  std::vector<StampedPose> poses;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const auto number = [&](const char* name) { return table.number(row, name); };
    const auto angle = [&](const char* name) { return angleOf(table, row, name); };
    const Quat rotation =
        rotations == Rotations::Quaternions
            ? checkedRotation({number("qw"), number("qx"), number("qy"), number("qz")}, table.where(row))
            : fromYawPitchRoll(angle("yaw"), angle("pitch"), angle("roll"));
    poses.push_back({table.time(row), {rotation, {number("x"), number("y"), number("z")}}, table.where(row).line});
  }
  if (rotations == Rotations::None) setHeadingsOfTravel(poses);
  return poses;
}

std::vector<StampedPose> readNuScenesPoses(const std::filesystem::path& file, const std::string& scene) {
  const std::filesystem::path folder = file.parent_path();
  std::string sceneToken;
  std::vector<std::string> sceneNames;
  readTableOfNuScenes(folder / "scene.json", [&](const Json& row) {
    sceneNames.push_back(row.at("name").get<std::string>());
    if (sceneNames.back() == scene) sceneToken = row.at("token").get<std::string>();
  });
  if (sceneToken.empty()) {
    throw InputError({(folder / "scene.json").string()}, "has no scene '{}'{}", scene, suggestion(scene, sceneNames));
  }
  std::set<std::string> sampleTokens;
  readTableOfNuScenes(folder / "sample.json", [&](const Json& row) {
    if (row.at("scene_token") == sceneToken) sampleTokens.insert(row.at("token").get<std::string>());
  });
  std::set<std::string> poseTokens;
  readTableOfNuScenes(folder / "sample_data.json", [&](const Json& row) {
    if (row.at("filename").get_ref<const std::string&>().find(kLidarScans) == std::string::npos) return;
    if (sampleTokens.contains(row.at("sample_token").get_ref<const std::string&>())) {
      poseTokens.insert(row.at("ego_pose_token").get<std::string>());
    }
  });
  std::vector<StampedPose> poses;
  readTableOfNuScenes(file, [&](const Json& row) {
    if (!poseTokens.contains(row.at("token").get_ref<const std::string&>())) return;
    const auto q = row.at("rotation").get<std::array<double, 4>>();
    const auto t = row.at("translation").get<std::array<double, 3>>();
    const Location where{fmt::format("{}: the pose {}", file.string(), row.at("token").get<std::string>())};
    poses.push_back({row.at("timestamp").get<double>() * 1e-6,
                     {checkedRotation({q[0], q[1], q[2], q[3]}, where), {t[0], t[1], t[2]}}});
  });
  std::ranges::sort(poses, {}, &StampedPose::time);
  return poses;
}

}  // namespace scanmill
