#pragma once

// Computes the world positions of a scan's points, also if the sensor moves during the revolution.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/vec.h"
#include "dataset/manifest.h"
#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// Points of a deskewed scan are in the sensor's frame at the start of the revolution, points of other scans in the
// sensor's frame when their column fired. The record has the poses at the first and the last column; in between, the
// motion of the sensor is interpolated linearly.
class WorldPositions {
 public:
  // `record` must have a pose. `deskewed`: see Manifest::deskewed. The scan must outlive this object.
  WorldPositions(const Scan& scan, const ScanRecord& record, const BeamTable& beams, bool deskewed)
      : scan_(scan),
        first_(record.worldFromSensor.front()),
        last_(record.worldFromSensor.back()),
        moves_(record.worldFromSensor.size() > 1 && !deskewed) {
    if (!moves_) return;
    std::vector<double> columnTimes;  // firing time of each column (s since the start of the revolution)
    if (const auto listed = beams.listed()) {
      columnTimes = listed->columnStarts(beams.columns);
    } else {
      for (std::uint32_t column = 0; column < beams.columns; ++column) columnTimes.push_back(beams.columnTime(column));
    }
    if (columnTimes.empty()) return;
    start_ = columnTimes.front();
    end_ = columnTimes.back();
    if (!knowsBeams(scan)) return;
    for (const double time : columnTimes) poses_.push_back(interpolate(first_, last_, fractionAt(time)));
  }

  // True if the points are not all in the same frame.
  bool moves() const { return moves_; }
  // Returns the position of a point in the world (m).
  Vec3d inWorld(std::size_t point) const { return poseOf(point) * Vec3d(scan_.position[point]); }
  // Returns the transform from the frame of a point to the world. If the scan has no beam numbers, uses the pose at the
  // time of the point, which ignores offsets between the rings' times; if the scan has no times either, the first pose.
  Pose poseOf(std::size_t point) const {
    if (!moves_ || (poses_.empty() && scan_[kTime].empty())) return first_;
    if (poses_.empty()) return interpolate(first_, last_, fractionAt(double{scan_[kTime][point]}));
    return poses_[std::min<std::size_t>(keyOf(scan_, point).column, poses_.size() - 1)];
  }

 private:
  // Returns the fraction of the sensor's motion at a time (s since the start of the revolution), from 0 at the first
  // column to 1 at the last.
  double fractionAt(double time) const { return end_ > start_ ? (time - start_) / (end_ - start_) : 0; }

  const Scan& scan_;
  Pose first_, last_;
  bool moves_ = false;
  double start_ = 0, end_ = 0;  // s, firing times of the first and the last column
  std::vector<Pose> poses_;     // pose at each column; empty if the scan does not assign its points to columns
};

}  // namespace scanmill
