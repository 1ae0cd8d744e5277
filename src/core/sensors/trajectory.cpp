#include "sensors/trajectory.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/path.h"
#include "config/fields.h"

namespace scanmill {

namespace {

constexpr Range kInterval{1e-9, 1e9};  // limits of every_s (s) and every_m (m)
constexpr double kAtGround = 0.5;      // m; waypoints at most this far from the ground, on average, are on the ground
constexpr double kLastTurn = 1;        // s; the path must be known until at least this long after the last frame's
                                       // start; most revolutions are shorter

// Reads a list of poses, such as [{position: [0, 0, 2], yaw_deg: 90}].
std::vector<Pose> readPoseList(const Value& value) {
  if (value.kind != Value::Kind::Sequence || value.items.empty()) {
    throw InputError(value.where, "poses must be a list such as [{position: [0, 0, 2], yaw_deg: 90}]");
  }
  std::vector<Pose> poses;
  poses.reserve(value.items.size());
  for (const Value& item : value.items) {
    Fields fields(item, "pose");
    poses.push_back(fields.pose());
    fields.finish();
    checkedPosition(poses.back().translation, item.where);
  }
  return poses;
}

const std::initializer_list<std::string_view> kKeysOfDrives = {"speed", "every_m",  "acceleration", "stops", "sway",
                                                               "path",  "rounding", "keep",         "from",  "to"};

// Reads the key `stops` of a drive along a path of `length` m. Returns no stops if the key is absent.
std::vector<DriveStop> readStops(Fields& fields, double length) {
  constexpr double kApart = 1;  // m, least distance of a stop from other stops and from the path's ends
  std::vector<DriveStop> stops;
  const Value* list = fields.find("stops");
  if (list == nullptr) return stops;
  if (!fields.has("acceleration")) {
    throw InputError(list->where,
                     "stops need the key `acceleration` (m/s^2), with which the vehicle brakes and starts");
  }
  if (list->kind != Value::Kind::Sequence) {
    throw InputError(list->where, "stops must be a list such as [{at: 60, wait: 4}]");
  }
  for (const Value& item : list->items) {
    Fields f(item, "stop");
    f.also({"at", "wait"}).finish();
    stops.push_back({.position = f.number("at", {kApart, std::max(kApart, length - kApart)}),
                     .duration = f.number("wait", {0, 3600}, 3)});
    if (stops.size() > 1 && stops.back().position < stops[stops.size() - 2].position + kApart) {
      throw InputError(item.where, "stops must be in their order along the path and at least 1 m apart");
    }
  }
  return stops;
}

// Returns the number of frames in a drive of `duration` s, `interval` s apart and at most `limit`. Throws InputError
// for more than kMaxFrames frames; only its message uses `length` (m) and `speed` (m/s).
std::uint32_t countFrames(double duration, double interval, double limit, double length, double speed,
                          const Location& where) {
  // A frame that falls exactly on the end of the path counts; the terms 1e-12 and 1e-9 absorb rounding errors.
  const double count = std::min(std::floor(duration / interval * (1 + 1e-12) + 1e-9) + 1, limit);
  if (count > Trajectory::kMaxFrames) {
    throw InputError(where,
                     "{:.6g} m of path / {:.6g} m/s / {:.6g} s per frame = {:.6g} frames, more than {}: "
                     "give every_s or frames, or, unless the drive is recorded, every_m or speed",
                     length, speed, interval, count, Trajectory::kMaxFrames);
  }
  return static_cast<std::uint32_t>(count);
}

// Returns the mean distance (m) of a path from the ground under it, above or below it, at positions from 0 to `end`;
// infinite if none of these has ground.
double meanClearance(const GroundProfile::PoseOnPath& poseOnPath, double end, const Ground& ground) {
  constexpr int kPositions = 64;
  double sum = 0;
  int count = 0;
  for (int k = 0; k < kPositions; ++k) {
    const Vec3d point = poseOnPath(end * k / (kPositions - 1)).translation;
    const std::optional<double> height = ground.under(point);
    sum += height ? std::fabs(point.z - *height) : 0;
    count += height ? 1 : 0;
  }
  return count == 0 ? std::numeric_limits<double>::infinity() : sum / count;
}

}  // namespace

double Trajectory::frameTime(std::uint32_t frame) const {
  if (everyMetres_ <= 0) return frame * interval_;
  if (!profile_) throw Error("the path of {} is not known yet", name_);
  return profile_->timeAt(std::min(frame * everyMetres_, path_->length()));
}

Pose Trajectory::pose(std::uint32_t frame, double dt) const {
  if (frame >= frames_) throw Error("frame {} of a trajectory of {} frames", frame, frames_);
  if (still()) return poses_[frame];
  const double time = frameTime(frame) + dt;
  const double position = positionAt(time);
  Pose pose = poseOnPath(position);
  if (profileOfGround_) pose = profileOfGround_->place(pose, position);
  return profile_ ? pose * sway_.at(time, profile_->speed(time) / speed_) : pose;
}

double Trajectory::positionAt(double time) const {
  if (recorded_) return time;
  if (!profile_) throw Error("the path of {} is not known yet", name_);
  return profile_->distance(time);
}

Pose Trajectory::poseOnPath(double position) const {
  if (recorded_) return recorded_->at(position);
  return path_->pose(position);
}

std::string Trajectory::about() const {
  if (recorded_) return "recorded: " + recorded_->about();
  if (random_ == std::nullopt) return {};
  return fmt::format("a random drive of {:.4g} m on {}", random_->length, fmt::join(random_->classes, ", "));
}

Trajectory Trajectory::along(const std::vector<Vec3d>& waypoints) const {
  Trajectory driven = *this;
  driven.setPath(Path(levelled(waypoints)));
  return driven;
}

// Returns the waypoints, at equal heights if their heights do not count, so that lengths are horizontal.
std::vector<Vec3d> Trajectory::levelled(std::vector<Vec3d> waypoints) const {
  if (!groundOptions_ || groundOptions_->onlyIfAtGround) return waypoints;
  for (Vec3d& p : waypoints) p.z = waypoints.front().z;
  return waypoints;
}

void Trajectory::setPath(Path path) {
  path_ = std::make_shared<const Path>(std::move(path));
  setProfile();
}

void Trajectory::setProfile() {
  if (acceleration_ > 0) {
    profile_.emplace(*path_, speed_, acceleration_, stops_);
  } else {
    profile_.emplace(path_->length(), speed_);
  }
}

Trajectory Trajectory::onGround(const Ground& ground) const {
  Trajectory placed = *this;
  if (still()) {
    for (Pose& pose : placed.poses_) pose = scanmill::onGround(*groundOptions_, pose, ground);
    return placed;
  }
  // All positions below are positions on the path: in s if it is recorded, otherwise in m (see positionAt()).
  const double end =
      std::min(positionAt(frameTime(frames_ - 1) + lastTurn_), recorded_ ? recorded_->duration() : path_->length());
  const GroundProfile::PoseOnPath onPath = [this](double position) { return poseOnPath(position); };
  if (groundOptions_->onlyIfAtGround) {
    placed.clearanceByDefault_ = meanClearance(onPath, end, ground);
    if (placed.clearanceByDefault_ > kAtGround) {
      placed.groundOptions_.reset();
      return placed;
    }
  }
  std::vector<double> knots{0};
  if (recorded_) {
    for (const double time : recorded_->times()) {
      if (time > knots.back() && time < end) knots.push_back(time);
    }
  } else {
    constexpr double kAboutStraight = 1;  // m, largest distance between knots; a path this short counts as straight
    constexpr double kMostSteps = 1e8;    // fits into an integer; samplePositions() refuses so many
    const auto steps = static_cast<std::size_t>(std::min(std::ceil(end / kAboutStraight), kMostSteps));
    for (std::size_t k = 1; k < steps; ++k) knots.push_back(end * static_cast<double>(k) / static_cast<double>(steps));
  }
  if (end > 0) knots.push_back(end);
  const auto profile = std::make_shared<const GroundProfile>(
      *groundOptions_, onPath, GroundProfile::samplePositions(onPath, knots, groundOptions_->where), ground);
  if (profile->bareFraction() < 1) {
    placed.profileOfGround_ = profile;
  } else {  // less than three wheels have ground, and the ground is not asked for
    placed.groundOptions_.reset();
  }
  return placed;
}

void Trajectory::readPoses(Fields& fields, double period, double limit) {
  fields.refuse(kKeysOfDrives,
                "is for paths that are driven: the vehicle stands still in each of `poses`, which are every_s apart");
  poses_ = readPoseList(fields.require("poses"));
  interval_ = fields.number("every_s", kInterval, period);
  frames_ = static_cast<std::uint32_t>(std::min(static_cast<double>(poses_.size()), limit));
  poses_.resize(frames_);
}

void Trajectory::readRecorded(Fields& fields, double period, double limit) {
  fields.refuse(kKeysOfDrives, "is for paths that are driven: a recording states the pose of the vehicle at each time");
  const Value& value = fields.require("recorded");
  recorded_ = std::make_shared<const RecordedPoses>(readRecordedPoses(value));
  interval_ = fields.number("every_s", kInterval, period);
  const double length = recorded_->length();
  frames_ = countFrames(recorded_->duration(), interval_, limit, length, length / recorded_->duration(), value.where);
}

void Trajectory::readPath(Fields& fields, const SceneLanes* lanes) {
  const bool waypoints = fields.has("waypoints");
  const bool lines = fields.choice("path", {"spline", "line"}, "spline") == "line";
  if (!waypoints) fields.refuse({"path", "rounding"}, "is for waypoints");
  if (!lines) fields.refuse({"rounding"}, "is for `path: line`, whose corners it rounds");
  if (waypoints) {
    const std::vector<Vec3d> points = readWaypoints(
        fields.require("waypoints"), groundOptions_ && !groundOptions_->onlyIfAtGround ? Climbs::No : Climbs::Yes);
    setPath(lines ? Path::lines(points, fields.number("rounding", {0.01, 1000}, 0.5)) : Path(points));
    return;
  }
  const bool turns = fields.choice("along", {"lane", "turns"}, "lane") == "turns";
  if (lanes == nullptr) {
    throw InputError(fields.require("along").where,
                     "`along` follows the lanes of a town, but here is no town: give waypoints");
  }
  setPath(Path(levelled(turns ? lanes->turns : lanes->lane)));
  if (turns) turns_ = lanes->turnCount;
}

void Trajectory::readDrive(Fields& fields, double period, double limit, std::uint64_t seed, const SceneLanes* lanes) {
  speed_ = fields.number("speed", {0, 100});
  if (speed_ <= 0) {
    throw InputError(fields.require("speed").where,
                     "speed must be above 0 m/s: for a vehicle that stands still, give poses");
  }
  if (fields.has("every_s") && fields.has("every_m")) {
    throw InputError(fields.require("every_m").where, "give either every_s or every_m, not both");
  }
  interval_ = fields.has("every_m") ? fields.number("every_m", kInterval) / speed_
                                    : fields.number("every_s", kInterval, period);
  if (fields.has("acceleration")) {
    acceleration_ = fields.number("acceleration", {0.01, 20});
    if (fields.has("every_m")) everyMetres_ = fields.number("every_m", kInterval);
  }
  if (const Value* sway = fields.find("sway")) sway_ = Sway(*sway, seed);

  if (const Value* on = fields.find("on")) {
    readRandomDrive(fields, limit, on->where);
  } else {
    readPathDrive(fields, limit, lanes);
  }
}

void Trajectory::readRandomDrive(Fields& fields, double limit, const Location& where) {
  if (!std::isfinite(limit)) {
    throw InputError(where,
                     "the length of a drive with `on` is known when its scene is loaded: give the number of `frames`");
  }
  RandomPath random{.classes = fields.texts("on"), .where = where};
  if (random.classes.empty()) throw InputError(where, "on must name classes, such as [road]");
  fields.refuse({"path", "rounding"}, "is for waypoints: a random drive chooses its own path");
  random.keep = readRoadSide(fields);
  random.length = ((limit - 1) * interval_ + lastTurn_) * speed_;
  random.perFrame = interval_ * speed_;
  if (fields.has("from") || fields.has("to")) random.trip = readRoadTrip(fields);
  stops_ = readStops(fields, random.length);
  random_ = std::move(random);
  frames_ = static_cast<std::uint32_t>(limit);
}

void Trajectory::readPathDrive(Fields& fields, double limit, const SceneLanes* lanes) {
  fields.refuse({"keep", "from", "to"}, "is for drives that have `on`, such as `on: road`");
  readPath(fields, lanes);
  const double length = path_->length();
  stops_ = readStops(fields, length);
  if (!stops_.empty()) setProfile();
  // A drive with every_m has as many frames with acceleration as at constant speed.
  const double duration = acceleration_ > 0 && everyMetres_ <= 0 ? profile_->duration() : length / speed_;
  frames_ = countFrames(duration, interval_, limit, length, speed_,
                        fields.require(fields.has("along") ? "along" : "waypoints").where);
}

std::uint32_t countDrives(const Value& value) {
  const Value* const drives = value.find("drives");
  if (drives == nullptr || drives->kind == Value::Kind::Null) return 1;
  if (value.find("on") == nullptr || value.find("to") != nullptr) {
    throw InputError(drives->where,
                     "drives is for random drives, which have `on`: several other drives would be the same");
  }
  return static_cast<std::uint32_t>(readInteger(*drives, "drives", 1, 10'000));
}

Trajectory readTrajectory(const Value& value, const std::string& name, double period, const SceneLanes* lanes,
                          std::uint64_t seed, std::uint32_t drive) {
  constexpr std::array<const char*, 5> kKinds{"poses", "waypoints", "along", "on", "recorded"};
  Fields fields(value, "trajectory");
  fields.also(kKeysOfDrives)
      .also({"name", "poses", "waypoints", "along", "on", "recorded", "drives", "ground", "every_s", "frames"})
      .finish();
  Trajectory result;
  result.name_ = fields.text("name", name);
  result.lastTurn_ = std::max(kLastTurn, period);
  if (countDrives(value) > 1) result.name_ += fmt::format("-{}", drive);
  const double limit =
      fields.has("frames") ? static_cast<double>(fields.integer("frames", 1, Trajectory::kMaxFrames)) : INFINITY;
  std::vector<std::string> kinds;
  for (const char* kind : kKinds) {
    if (fields.has(kind)) kinds.emplace_back(kind);
  }
  if (kinds.size() != 1) {
    throw InputError(kinds.empty() ? value.where : fields.require(kinds[1]).where,
                     "trajectory {} has {}: give exactly one of poses, waypoints, along, on and recorded", result.name_,
                     kinds.empty() ? "none of these keys" : fmt::format("{}", fmt::join(kinds, " and ")));
  }
  const std::string& kind = kinds.front();
  if (const Value* ground = fields.find("ground")) {
    result.groundOptions_ = readGround(*ground);
  } else if (kind == "waypoints" || kind == "along" || kind == "on") {
    result.groundOptions_.emplace();
    result.groundOptions_->onlyIfAtGround = kind != "along";
    result.groundOptions_->where = fields.require(kind).where;
  }
  if (kind == "poses") {
    result.readPoses(fields, period, limit);
  } else if (kind == "recorded") {
    result.readRecorded(fields, period, limit);
  } else {
    result.readDrive(fields, period, limit, seed, lanes);
  }
  return result;
}

}  // namespace scanmill
