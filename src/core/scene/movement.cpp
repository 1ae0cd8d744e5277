#include "scene/movement.h"

#include <algorithm>

#include "base/path.h"

namespace scanmill {

Movement::Movement(const Vec3d& velocity) : velocity_(velocity) {}

Movement::Movement(std::shared_ptr<const Path> path, double start, double speed) : path_(std::move(path)) {
  interval_ = std::max(path_->length() - start, 0.0) / speed;
  travelled_ = {start};
  if (interval_ > 0) travelled_.push_back(path_->length());
}

Movement::Movement(std::shared_ptr<const Path> path, std::vector<double> travelled, double interval)
    : path_(std::move(path)), travelled_(std::move(travelled)), interval_(interval) {}

Pose Movement::at(double time) const {
  const double t = std::max(time, 0.0);
  if (path_ == nullptr) return {{}, velocity_ * t};
  const double steps = t / interval_;
  if (!(steps < static_cast<double>(travelled_.size() - 1))) return path_->pose(travelled_.back());
  const auto step = static_cast<std::size_t>(steps);
  const double fraction = steps - static_cast<double>(step);
  return path_->pose(travelled_[step] + (travelled_[step + 1] - travelled_[step]) * fraction);
}

bool Movement::moves() const {
  return path_ == nullptr ? length(velocity_) > 0 : travelled_.back() != travelled_.front();
}

}  // namespace scanmill
