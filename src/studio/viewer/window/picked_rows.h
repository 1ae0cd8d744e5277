#pragma once

// Describes a point or a triangle in text.

#include <cstddef>

#include "viewer/frames/frame_source.h"
#include "viewer/frames/view_mesh.h"
#include "viewer/window/instance_summary.h"
#include "viewer/window/session.h"

namespace scanmill {

// Describes a point: all its columns with their units, its class, its beam. `place` is not set.
PickedThing describePoint(const ViewScan& scan, std::size_t scanIndex, std::size_t point, const Ontology* ontology);

// Adds the rows that are shown while the pointer is over the point: range, ring and column, and the quantity that
// colours show.
void addBrief(PickedThing& thing, const ColorBy& shown);

// Adds the instance's number of points in the scan, its size, and its classes if it has several.
void addInstance(PickedThing& thing, const InstanceSummary& summary, const Ontology* ontology);

// Adds the other scan's return of the same beam and return number, if both scans know their beams and have equally many
// rings and columns. Each scan numbers its own returns.
void addSameBeam(PickedThing& thing, const Scan& own, const ViewScan& other, const Ontology* ontology);

// Returns dataset, sensor and method, as far as known.
std::string wholeName(const ViewScan& scan, const std::string& dataset);

PickedThing describeTriangle(const ViewMesh& mesh, std::size_t triangle, const Vec3d& worldPlace);

}  // namespace scanmill
