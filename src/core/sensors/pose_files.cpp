#include "sensors/pose_files.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <string_view>

#include "base/file.h"
#include "base/format_support.h"
#include "config/text.h"
#include "sensors/text_table.h"

namespace scanmill {
namespace {

template <std::size_t N>
std::array<double, N> numbersOf(std::string_view text, const Location& where, const char* what) {
  const std::vector<std::string_view> cells = cellsOf(text);
  if (cells.size() != N) {
    throw InputError(where, fmt::format("has {} numbers, but must have {}: {}", cells.size(), N, what));
  }
  std::array<double, N> numbers;
  for (std::size_t i = 0; i < N; ++i) numbers[i] = numberOf(cells[i], where);
  return numbers;
}

// Returns the transform whose matrix has `m` as its first three rows. Throws InputError if the transform is not rigid.
Affine rigid(const std::array<double, 12>& m, const Location& where) {
  const Affine affine{{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}, {m[3], m[7], m[11]}};
  const Mat3 product = transposed(affine.linear) * affine.linear;
  double off = std::fabs(determinant(affine.linear) - 1);
  for (const Vec3d& d : {product.x - Vec3d{1, 0, 0}, product.y - Vec3d{0, 1, 0}, product.z - Vec3d{0, 0, 1}}) {
    off += std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z);
  }
  if (!(off < 1e-2)) {
    throw InputError(where,
                     fmt::format("is not a rigid transform: its first three columns must be orthogonal unit "
                                 "vectors{}",
                                 determinant(affine.linear) < 0 ? " of right-handed axes; these are left-handed" : ""));
  }
  return affine;
}

// The poses that are left out of one file.
class LostPoses {
 public:
  // True if a number of the line is NaN; counts the line then. `columns`: those that are read, from 0.
  bool has(const TextLine& line, const std::vector<std::size_t>& columns) {
    const std::vector<std::string_view> cells = cellsOf(line.text);
    const auto isNan = [&](std::size_t i) { return i < cells.size() && lowerCase(cells[i]).ends_with("nan"); };
    if (std::none_of(columns.begin(), columns.end(), isNan)) return false;
    if (count_++ == 0) first_ = line.where.line;
    return true;
  }
  void tell(const std::filesystem::path& file, LeftOut leftOut = {}) const {
    leftOut.add(fmt::format("poses with NaN, the first in line {}", first_), count_);
    leftOut.tell(file.string());
  }

 private:
  std::uint64_t count_ = 0;
  int first_ = 0;
};

// Sets each pose's rotation to the direction of travel: from the last mark before the pose to the first mark after it.
// Marks are poses at least 5 cm apart, so that a vehicle that stands still heads for its next mark.
void headAlong(std::vector<StampedPose>& poses) {
  constexpr double kMoves = 0.05;  // m, least distance from a mark to the next mark
  const auto placeOf = [&](std::size_t i) { return poses[i].pose.translation; };
  std::vector<std::size_t> marks{0};  // indices of poses at least kMoves apart
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Vec3d way = placeOf(i) - placeOf(marks.back());
    if (std::hypot(way.x, way.y) >= kMoves) marks.push_back(i);
  }
  if (marks.size() < 2) return;
  std::size_t mark = 0;  // index in `marks` of the last mark at or before the pose
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (mark + 1 < marks.size() && marks[mark + 1] <= i) ++mark;
    const std::size_t ahead = std::min(mark + 1, marks.size() - 1);
    const std::size_t from = (marks[mark] == i || ahead == mark) && mark > 0 ? mark - 1 : mark;
    const Vec3d way = placeOf(marks[ahead]) - placeOf(marks[from]);
    poses[i].pose.rotation =
        fromYawPitchRoll(std::atan2(way.y, way.x), -std::atan2(way.z, std::hypot(way.x, way.y)), 0);
  }
}

constexpr std::array<const char*, 3> kAngles{"yaw", "pitch", "roll"};
constexpr std::array<const char*, 3> kAngleUnits{"", "_deg", "_rad"};  // endings of their columns

// Returns the name of a column in our words: "timestamp [ns]" gives "time_ns", and the EuRoC dataset's "p_RS_R_x [m]"
// and "q_RS_w []" give "x" and "qw", as ROS's "pose.position.x" and "pose.orientation.w" do. `euroc`: true if the table
// is the EuRoC dataset's ground truth, whose times are in ns without saying so.
std::string poseColumn(std::string_view cell, bool euroc) {
  auto [name, unit] = columnName(cell);
  if (unit.empty() && ((name == "timestamp" && euroc) || name == "%time")) return "time_ns";
  if (name == "timestamp" && !unit.empty()) name = "time";
  if (name.starts_with("timestamp_")) name.replace(0, 9, "time");
  // ROS's messages, as in rostopic's "field.pose.pose.position.x" and "header.stamp.sec".
  for (const std::string_view part : {"field.", "header.stamp.", "pose.", "pose.", "transform."}) {
    if (name.starts_with(part)) name.erase(0, part.size());
  }
  for (const auto& [part, ours] : std::map<std::string, const char*>{
           {"position.", ""}, {"translation.", ""}, {"orientation.", "q"}, {"rotation.", "q"}}) {
    if (name.starts_with(part)) name.replace(0, part.size(), ours);
  }
  for (const char* unused : {"covariance", "twist"}) {
    if (name.starts_with(unused)) return unused;
  }
  if (name.starts_with("p_rs_r_")) name.erase(0, 7);
  if (name.starts_with("q_rs_")) name.replace(0, 5, "q");
  const bool usual = unit.empty() || unit == "m" || unit == "s";
  return usual || !poseFormat().has(FormatElements::Use::Read, name) ? name : name + "_" + unit;
}

// Finds the columns of a table of poses by their names.
class PoseColumns {
 public:
  // `rows`: the lines below the names.
  PoseColumns(const TextLine& head, std::span<const TextLine> rows) : where_(head.where) {
    const std::vector<std::string_view> names = cellsOf(head.text);
    count_ = names.size();
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string name = poseColumn(names[i], lowerCase(head.text).find("p_rs_r_x") != std::string::npos);
      if (!columns_.emplace(name, i).second && poseFormat().has(FormatElements::Use::Read, name))
        throw InputError(where_, fmt::format("the column {} is listed twice", name));
      if (!name.empty()) leftOut_.addKeyword(poseFormat(), name);
    }
    static const std::map<std::string, double> kTimes{
        {"time", 1}, {"time_s", 1}, {"time_ms", 1e-3}, {"time_us", 1e-6}, {"time_ns", 1e-9}};
    for (const auto& [name, unit] : kTimes) {
      if (!columns_.contains(name)) continue;
      if (time_)
        throw InputError(where_, fmt::format("the table has two columns of time: leave out {} or the other", name));
      time_ = columns_.at(name);
      second_ = unit;
    }
    if (!time_) findStamps(rows);
    if (!time_ && has("timestamp")) {
      throw InputError(where_,
                       "the column timestamp does not show its unit, as it has neither decimals (s) nor 10, 13, 16 or "
                       "19 digits: name it time (s), time_ms, time_us or time_ns");
    }
    if (!time_) {
      throw InputError(where_,
                       fmt::format("the first line must name the columns time (s; or time_ms, time_us, time_ns), x, y, "
                                   "z and optionally qw, qx, qy, qz or yaw, pitch, roll, but it has no time: {}",
                                   quotedForMessage(head.text)));
    }
    for (const auto& [name, i] : columns_) {
      if (i != time_ && i != nanoseconds_ && poseFormat().find(name) == poseFormat().find("timestamp")) {
        leftOut_.add(fmt::format("further columns of times ('{}')", name));
      } else if (poseFormat().has(FormatElements::Use::Read, name)) {
        read_.push_back(i);
      }
    }
    for (const char* name : {"x", "y", "z"}) require(name);
    constexpr std::array<const char*, 4> kQuaternion{"qw", "qx", "qy", "qz"};
    const auto hasName = [&](const char* name) { return has(name); };
    const bool quaternion = std::any_of(kQuaternion.begin(), kQuaternion.end(), hasName);
    if (quaternion) std::for_each(kQuaternion.begin(), kQuaternion.end(), [&](const char* name) { require(name); });
    for (const std::string angle : kAngles) {
      const auto hasUnit = [&](const char* unit) { return has(angle + unit); };
      if (std::count_if(kAngleUnits.begin(), kAngleUnits.end(), hasUnit) > (quaternion ? 0 : 1)) {
        throw InputError(where_, fmt::format("the table states {} by two columns: leave out one of them", angle));
      }
    }
    for (const char* name : {"heading", "heading_deg", "bearing", "azimuth"}) {
      if (!headed() && has(name)) {
        throw InputError(where_,
                         fmt::format("the column {} is ambiguous: name it yaw or yaw_deg if angles increase from x "
                                     "(east) to y (north); those of a compass increase from north to east",
                                     name));
      }
    }
  }

  bool has(const std::string& name) const { return columns_.contains(name); }
  const LeftOut& leftOut() const { return leftOut_; }
  const std::vector<std::size_t>& read() const { return read_; }
  bool headed() const {
    return has("qw") || std::any_of(kAngles.begin(), kAngles.end(), [&](const std::string& angle) {
             return std::any_of(kAngleUnits.begin(), kAngleUnits.end(),
                                [&](const char* unit) { return has(angle + unit); });
           });
  }

  StampedPose poseOf(const TextLine& line) const {
    const std::vector<std::string_view> cells = cellsOf(line.text);
    if (cells.size() != count_) {
      throw InputError(line.where, fmt::format("has {} cells, but the first line has {}", cells.size(), count_));
    }
    const auto number = [&](const std::string& name) { return numberOf(cells[columns_.at(name)], line.where); };
    const auto angle = [&](const std::string& name) {
      if (has(name + "_deg")) return radians(number(name + "_deg"));
      if (has(name + "_rad")) return number(name + "_rad");
      if (!has(name)) return 0.0;
      const double value = number(name);
      if (std::fabs(value) > 6.3) {
        throw InputError(line.where, fmt::format("has the {0} {1:g}, which in radians is more than a turn: name the "
                                                 "column {0}_deg, or {0}_rad if radians are meant",
                                                 name, value));
      }
      return value;
    };
    StampedPose p{timeOf(cells[*time_], line.where), {{}, {number("x"), number("y"), number("z")}}, line.where.line};
    if (nanoseconds_) p.time += numberOf(cells[*nanoseconds_], line.where) * 1e-9;
    if (has("qw")) {
      p.pose.rotation = checkedRotation({number("qw"), number("qx"), number("qy"), number("qz")}, line.where);
    } else {
      p.pose.rotation = fromYawPitchRoll(angle("yaw"), angle("pitch"), angle("roll"));
    }
    return p;
  }

 private:
  void require(const std::string& name) const {
    if (!has(name)) throw InputError(where_, fmt::format("the table has no column {}", name));
  }
  // Finds columns of time without a unit in their names: a timestamp, whose unit follows from the digits of times since
  // 1970 (2001 to 2286) or, for the clock of a simulator, from decimals, which mean seconds; or ROS's seconds and
  // nanoseconds.
  void findStamps(std::span<const TextLine> rows) {
    static const std::map<std::size_t, double> kUnits{{10, 1}, {13, 1e-3}, {16, 1e-6}, {19, 1e-9}};
    if (const auto stamp = columns_.find("timestamp"); stamp != columns_.end()) {
      const auto cellOf = [&](const TextLine& line) {
        const std::vector<std::string_view> cells = cellsOf(line.text);
        return stamp->second < cells.size() ? cells[stamp->second] : std::string_view();
      };
      const std::string_view cell = rows.empty() ? "" : cellOf(rows.front());
      const auto unit = kUnits.find(std::min(cell.find_first_not_of("0123456789"), cell.size()));
      const auto hasDecimals = [&](const TextLine& line) { return cellOf(line).find_first_of(".eE") != cell.npos; };
      if (unit != kUnits.end() || std::any_of(rows.begin(), rows.end(), hasDecimals)) {
        time_ = stamp->second;
        second_ = unit == kUnits.end() ? 1 : unit->second;
      }
    }
    for (const auto& [seconds, rest] : {std::pair{"sec", "nanosec"}, {"sec", "nsec"}, {"secs", "nsecs"}}) {
      if (time_ || !has(seconds) || !has(rest)) continue;
      time_ = columns_.at(seconds);
      nanoseconds_ = columns_.at(rest);
    }
  }
  double timeOf(std::string_view cell, const Location& where) const { return numberOf(cell, where) * second_; }

  Location where_;
  std::size_t count_ = 0;
  std::map<std::string, std::size_t> columns_;
  std::optional<std::size_t> time_;
  double second_ = 1;
  std::optional<std::size_t> nanoseconds_;  // column of what is added to the time
  LeftOut leftOut_;                         // columns that are not read
  std::vector<std::size_t> read_;           // indices of the columns that are
};

}  // namespace

const FormatSupport& poseFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "Recorded poses",
      ".csv, .txt, .json",
      {{Read, "time time_s time_ms time_us time_ns x y z qw qx qy qz"},
       {Read, "%time timestamp sec secs nsec nsecs nanosec"},
       {Read, "yaw pitch roll yaw_deg pitch_deg roll_deg yaw_rad pitch_rad roll_rad"},
       {LeftOut, "header.stamp",
        "columns of times in messages (header.stamp), as those of their receipt (%time) count"},
       {Unused, "header.seq header.frame_id frame_id child_frame_id covariance twist"},
       {Unused, "v_rs_r_x v_rs_r_y v_rs_r_z b_w_rs_s_x b_w_rs_s_y b_w_rs_s_z b_a_rs_s_x b_a_rs_s_y b_a_rs_s_z"}},
      "Table: time, in s without a unit, also as Time/s, time (ms) or timestamp [ns]; else %time or a timestamp of "
      "ROS, of 10, 13, 16 or 19 digits in s, ms, us or ns; position x, y, z (m), rotation qw, qx, qy, qz, or yaw, "
      "pitch and roll (rad without a unit); EuRoC's and ROS's names for them. tum: lines time x y z qx qy qz qw, times "
      "in s. kitti: lines of 12 numbers, with the line Tr of calib.txt. nuscenes: ego_pose.json, beside scene.json, "
      "sample.json and sample_data.json",
      "further columns of times, and other columns; poses with NaN of table and tum (kitti may have none, as its times "
      "are counted by lines)"};
  return format;
}

Quat checkedRotation(const Quat& q, const Location& where) {
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(std::fabs(norm - 1) < 1e-2)) {
    throw InputError(where, fmt::format("the quaternion has the length {:.3g}, not 1: is the order of its numbers "
                                        "right?",
                                        norm));
  }
  return {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
}

std::vector<Affine> readKittiPoses(const std::filesystem::path& file) {
  const std::string bytes = readFile(file);
  std::vector<Affine> poses;
  for (const TextLine& line : linesOf(bytes, file)) {
    poses.push_back(rigid(numbersOf<12>(line.text, line.where, "a matrix of 3 rows and 4 columns"), line.where));
  }
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
    return rigid(numbersOf<12>(line.text.substr(colon + 1), line.where, "a matrix of 3 rows and 4 columns"),
                 line.where);
  }
  throw InputError({file.string()}, "has no line `Tr: 12 numbers`, the transform from the scanner to the camera");
}

std::vector<StampedPose> readTumPoses(const std::filesystem::path& file) {
  const std::string bytes = readFile(file);
  // A comment may name the columns.
  if (bytes.find("qw") < bytes.find("qx") && bytes.find("qx") != std::string::npos) {
    throw InputError({file.string()},
                     "names qw before qx, but a line must be time x y z qx qy qz qw: make it a .csv table, whose first "
                     "line names the columns (time, x, y, z, qw, qx, qy, qz)");
  }
  std::vector<StampedPose> poses;
  LostPoses lost;
  for (const TextLine& line : linesOf(bytes, file)) {
    if (lost.has(line, {0, 1, 2, 3, 4, 5, 6, 7})) continue;
    const auto n = numbersOf<8>(line.text, line.where, "time x y z qx qy qz qw");
    poses.push_back(
        {n[0], {checkedRotation({n[7], n[4], n[5], n[6]}, line.where), {n[1], n[2], n[3]}}, line.where.line});
  }
  lost.tell(file);
  return poses;
}

std::vector<StampedPose> readPoseTable(const std::filesystem::path& file) {
  std::string bytes = readFile(file);
  std::vector<TextLine> lines = linesOf(bytes, file);
  const std::size_t comment = bytes.find('#');
  if (comment < bytes.find('\n') && lines.front().text.find_first_of("+-.0123456789") == 0) {
    bytes[comment] = ' ';  // the names are behind a #
    lines = linesOf(bytes, file);
  }
  const PoseColumns columns(lines.front(), std::span(lines).subspan(1));
  std::vector<StampedPose> poses;
  LostPoses lost;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (!lost.has(lines[i], columns.read())) poses.push_back(columns.poseOf(lines[i]));
  }
  lost.tell(file, columns.leftOut());
  if (!columns.headed()) headAlong(poses);
  return poses;
}

}  // namespace scanmill
