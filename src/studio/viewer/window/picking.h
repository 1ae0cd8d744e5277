#pragma once

// Finds the point under the pointer, and describes points and triangles in text.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "viewer/frames/view_mesh.h"
#include "viewer/panels/widgets.h"
#include "viewer/window/session_context.h"

namespace scanmill {

// The points of one item on the canvas.
struct PickCloud {
  std::span<const Vec3f> positions;
  std::span<const std::uint8_t> shown;  // for each point, 0 if it is hidden; empty: all are shown
  Affine canvasFromItem;
};

struct PointHit {
  std::size_t cloud = 0;  // index in the list of clouds
  std::size_t point = 0;  // index in the cloud
  double distance = 0;    // distance from the pointer (pixels)
};

// Returns the point that is visible at the pixel (x, y) of the camera's picture. Points are drawn as squares of `size`
// pixels; among those that cover (x, y), the one nearest to the eye is returned. If no square covers (x, y), returns
// the point nearest to (x, y) in the picture within `reach` pixels, or nothing. Of equally near points, the first is
// returned. Uses all threads; the result does not depend on the number of threads.
std::optional<PointHit> pickPoint(std::span<const PickCloud> clouds, const ViewCamera& camera, double x, double y,
                                  double size, double reach);

// The line of sight through a pixel, given by its start (m) and its unit direction in the canvas frame.
struct SightLine {
  Vec3d origin, direction;
};
SightLine sightLine(const ViewCamera& camera, double x, double y);

constexpr std::size_t kNoScan = SIZE_MAX;

// A point, or a triangle of a scene, that is under the pointer or was clicked, described for the user.
struct PickedElement {
  std::string heading{};  // class and instance id, such as "car 4711"
  NamedValues rows{};
  NamedValues brief{};    // rows of the tooltip beside the pointer
  std::string alarm{};    // name of the row that is shown as a warning; empty: none
  std::size_t scan = 0;   // index of the scan in the frame; kNoScan: a triangle
  std::size_t point = 0;  // index of the point in the scan or the triangle in the mesh
  Vec3d position{};       // position (m, canvas frame)

  bool isPoint() const { return scan != kNoScan; }
};

// Describes a point: all its columns with their units, its class and its beam. Does not set PickedElement::position.
PickedElement describePoint(const ViewScan& scan, std::size_t scanIndex, std::size_t point, const Ontology* ontology);

// Adds the rows of the tooltip: range, ring, column, and the quantity that colours show (`shown`).
void addBrief(PickedElement& picked, const ViewScan& viewed, const ColorBy& shown);

// Adds the instance's number of points in the scan, its size, and its classes if it has several.
void addInstance(PickedElement& picked, const InstanceSummary& summary, const Ontology* ontology);

// Adds a row about the point in `otherScan` with the same beam and return number, if both scans assign points to beams
// and have the same numbers of rings and columns.
void addSameBeam(PickedElement& picked, const Scan& pickedScan, const ViewScan& otherScan, const Ontology* ontology);

// Returns the scan's name together with its dataset, sensor and method, as far as these are known.
std::string fullName(const ViewScan& scan, const std::string& dataset);

// Describes a triangle. `worldPosition`: the picked position on it (m). Does not set PickedElement::position.
PickedElement describeTriangle(const ViewMesh& mesh, std::size_t triangle, const Vec3d& worldPosition);

}  // namespace scanmill
