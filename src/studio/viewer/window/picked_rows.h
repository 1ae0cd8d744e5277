#pragma once

// Describes a point or a triangle in text.

#include <cstddef>

#include "viewer/frames/frame_source.h"
#include "viewer/frames/view_mesh.h"
#include "viewer/window/session_context.h"
#include "viewer/window/view_options.h"

namespace scanmill {

// Describes a point: all its columns with their units, its class and its beam. Does not set PickedThing::place.
PickedThing describePoint(const ViewScan& scan, std::size_t scanIndex, std::size_t point, const Ontology* ontology);

// Adds the rows that are shown while the pointer is over the point: range, ring and column, and `shown`, the quantity
// that colours show.
void addBrief(PickedThing& thing, const ViewScan& viewed, const ColorBy& shown);

// Adds the instance's number of points in the scan, its size, and its classes if it has several.
void addInstance(PickedThing& thing, const InstanceSummary& summary, const Ontology* ontology);

// Adds a row about the point in `other` with the same beam and return number, if both scans assign points to beams and
// have the same numbers of rings and columns.
void addSameBeam(PickedThing& thing, const Scan& own, const ViewScan& other, const Ontology* ontology);

// Returns the scan's name together with its dataset, sensor and method, as far as these are known.
std::string fullName(const ViewScan& scan, const std::string& dataset);

PickedThing describeTriangle(const ViewMesh& mesh, std::size_t triangle, const Vec3d& worldPlace);

}  // namespace scanmill
