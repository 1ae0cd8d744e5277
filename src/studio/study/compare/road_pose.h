#pragma once

// Measures how a sensor stands on the road: its pose over the ground near by, and its place between the road's edges.

#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "study/compare/patches.h"

namespace scanmill {

// Returns those of the points that are on the ground; none if they are too few. A plane is fitted to the lowest point
// in each cell of 4 m, then twice to all points within 0.5 m of the previous plane; points within 0.5 m of the last
// plane are the ground. The limits were chosen by eye. `points`: in the sensor's frame; ignored unless 0.3 m below the
// sensor.
std::vector<Vec3d> groundAmong(std::vector<Vec3d> points);

// Pitch and roll are those of fromYawPitchRoll() (base/vec.h), so that they can be written into a mount.
inline constexpr auto kRoadFigures = std::to_array<ComparedFigure>({
    {"pitch", "pitch", "deg", 1,
     "by how much the sensor looks down on the ground within 12 m: the road, or without labels what is level",
     "the sensor's mount (pitch_deg)", false, false, "farther down", "less down", 0.05},
    {"roll", "roll", "deg", 1, "by how much its left side is raised over the same ground",
     "the road's cross fall; the sensor's mount (roll_deg)", false, false, "higher on the left", "lower on the left",
     0.05},
    {"height", "height", "m", 1, "distance from the same ground", "the sensor's mount (position)", false, false,
     "higher", "lower", 0.01},
    {"lane_slope", "slope across the own lane", "deg", 1,
     "by how much the ground less than 1.3 m beside the sensor rises to the left",
     "the sensor's mount (roll_deg); the trajectory's ground", false, false, "steeper up to the left",
     "steeper down to the left", 0.05},
    {"left_edge", "left edge of the road", "m", 1,
     "distance of the nearest strip of 0.25 m in which most of the ground is of other classes",
     "where the vehicle drives, how wide roads are", false, false, "farther", "nearer", 0.25},
    {"right_edge", "right edge of the road", "m", 1, "the same to the right",
     "where the vehicle drives, how wide roads are", false, false, "farther", "nearer", 0.25},
});
inline constexpr std::size_t kRoadFigureCount = kRoadFigures.size();
enum RoadFigure : std::size_t { kPitch, kRoll, kHeight, kLaneSlope, kLeftEdge, kRightEdge };  // indices in kRoadFigures

// Values of the figures in one scan, in degrees and m; NaN if the scan does not show a figure.
using RoadPose = std::array<double, kRoadFigureCount>;

// Measures a scan. `ontology`: classes of the scan's labels, by which the road is found; null: the ground is found by
// its shape, and edges are unknown. `heading`: azimuth (rad) of the vehicle's heading in the scan.
RoadPose roadPoseOf(const Scan& scan, const Ontology* ontology, double heading = 0);

// The distribution of a figure over the scans of a set; NaN if no scan shows the figure.
struct FigureSpread {
  double median = std::numeric_limits<double>::quiet_NaN();
  double low = median, high = median;  // percentiles 16 and 84
  double overSequences = median;  // standard deviation of the sequences' medians; NaN for fewer than three sequences
};
using RoadPoses = std::array<FigureSpread, kRoadFigureCount>;

using PosesBySequence = std::map<std::string, std::vector<RoadPose>>;  // poses of the scans, by the sequence's name
RoadPoses spreadsOf(const PosesBySequence& poses);

// Returns how the simulated sensor differs, such as "0.71 deg less down"; empty if the medians differ by no more than
// half of the distance between the real set's percentiles.
std::string differenceText(std::size_t figure, const RoadPoses& real, const RoadPoses& simulated);

}  // namespace scanmill
