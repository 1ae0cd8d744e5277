#pragma once

// A point or a triangle in words.

#include <cstddef>

#include "viewer/frames/frame_source.h"
#include "viewer/frames/view_mesh.h"
#include "viewer/window/instance_summary.h"
#include "viewer/window/session.h"

namespace scanmill {

// All columns of a point with their units, its class, its beam. `place` is left as it is.
PickedThing describePoint(const ViewScan& scan, std::size_t scanIndex, std::size_t point, const Ontology* ontology);

// What is told while it is only pointed at: range, ring and column, and the column that is coloured.
void addBrief(PickedThing& thing, const ColorBy& shown);

// How many points of the scan the instance has, how large it is, and which classes, where there is more than one.
void addInstance(PickedThing& thing, const InstanceSummary& summary, const Ontology* ontology);

// What another scan has of the point's beam, where both know their beams and the sensors are alike: the return of the
// same number, as that scan counts its own.
void addSameBeam(PickedThing& thing, const Scan& own, const ViewScan& other, const Ontology* ontology);

// Dataset, sensor and method, as far as known.
std::string wholeName(const ViewScan& scan, const std::string& dataset);

PickedThing describeTriangle(const ViewMesh& mesh, std::size_t triangle, const Vec3d& worldPlace);

}  // namespace scanmill
