#include "scene/movement.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/path.h"
#include "config/fields.h"
#include "config/waypoints.h"

namespace scanmill {

Movement::Movement(const Vec3d& velocity) : velocity_(velocity) {}

Movement::Movement(std::shared_ptr<const Path> path, double start, double speed) : path_(std::move(path)) {
  interval_ = std::max(path_->length() - start, 0.0) / speed;
  travelled_ = {start, path_->length()};
  if (interval_ <= 0) travelled_.pop_back();
}

Movement::Movement(std::shared_ptr<const Path> path, std::vector<double> travelled, double interval)
    : path_(std::move(path)), travelled_(std::move(travelled)), interval_(interval) {}

Pose Movement::at(double time) const {
  const double t = std::max(time, 0.0);
  if (path_ == nullptr) return {{}, velocity_ * t};
  const double steps = t / interval_;
  if (!(steps < static_cast<double>(travelled_.size() - 1))) return path_->pose(travelled_.back());
  const auto k = static_cast<std::size_t>(steps);
  const double part = steps - static_cast<double>(k);
  return path_->pose(travelled_[k] + (travelled_[k + 1] - travelled_[k]) * part);
}

bool Movement::moves() const {
  return path_ == nullptr ? length(velocity_) > 0 : travelled_.back() != travelled_.front();
}

std::shared_ptr<const Movement> readMovement(const Value& value) {
  Fields f(value, "moving");
  f.also({"velocity", "waypoints", "speed", "start"}).finish();
  if (f.has("velocity") && f.has("waypoints")) {
    throw InputError(f.require("velocity").where,
                     "moving has either a velocity or waypoints with a speed, not both: take one out");
  }
  if (!f.has("velocity") && !f.has("waypoints")) {
    throw InputError(value.where, "moving needs velocity, such as [8, 0, 0] in m/s, or waypoints with a speed");
  }
  if (const Value* velocity = f.find("velocity")) {
    for (const char* key : {"speed", "start"}) {
      if (const Value* other = f.find(key)) {
        throw InputError(other->where, std::string(key) + " is for waypoints: a velocity says how fast and where to");
      }
    }
    const Vec3d v = readVec3(*velocity, "velocity");
    if (!(length(v) <= kFastestObject)) throw InputError(velocity->where, "velocity is above 300 m/s");
    return std::make_shared<Movement>(v);
  }
  const auto path = std::make_shared<const Path>(readWaypoints(f.require("waypoints")));
  const double speed = f.number("speed", {0.001, kFastestObject});
  const double start = std::min(f.number("start", {0, path->length() * (1 + 1e-9)}, 0), path->length());
  return std::make_shared<Movement>(path, start, speed);
}

}  // namespace scanmill
