#include "dataset/world_positions.h"

#include <algorithm>

namespace scanmill {

WorldPositions::WorldPositions(const Scan& scan, const ScanRecord& record, const BeamTable& beams, bool deskewed)
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

double WorldPositions::fractionAt(double time) const {
  return end_ > start_ ? (time - start_) / (end_ - start_) : 0;
}

// If the scan has no beam numbers, the pose is derived from the point's time, which ignores offsets between the rings'
// times; without a time it is the first pose.
Vec3d WorldPositions::of(std::size_t point) const {
  const Vec3d inSensor(scan_.position[point]);
  if (!moves_ || (poses_.empty() && scan_[kTime].empty())) return first_ * inSensor;
  if (poses_.empty()) return interpolate(first_, last_, fractionAt(double{scan_[kTime][point]})) * inSensor;
  return poses_[std::min<std::size_t>(keyOf(scan_, point).column, poses_.size() - 1)] * inSensor;
}

}  // namespace scanmill
