#pragma once

// Places the points of a dataset's scan in the world, also if the sensor moves during the revolution.

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
  WorldPositions(const Scan& scan, const ScanRecord& record, const BeamTable& beams, bool deskewed);

  // True if the points have different frames.
  bool moves() const { return moves_; }
  // Returns the position of a point in the world (m).
  Vec3d of(std::size_t point) const;

 private:
  // Returns the fraction of the sensor's motion at a time (s since the start of the revolution), from 0 at the first
  // column to 1 at the last.
  double fractionAt(double time) const;

  const Scan& scan_;
  Pose first_, last_;
  bool moves_ = false;
  double start_ = 0, end_ = 0;  // s, firing times of the first and the last column
  std::vector<Pose> poses_;     // pose at each column; empty if the scan does not assign its points to columns
};

}  // namespace scanmill
