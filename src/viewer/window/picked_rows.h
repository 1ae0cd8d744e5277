#pragma once

// A point or a triangle in words.

#include <cstddef>

#include "viewer/frames/frame_source.h"
#include "viewer/frames/view_mesh.h"
#include "viewer/window/session.h"

namespace scanmill {

// All columns of a point with their units, its class, its beam. `place` is left as it is.
PickedThing describePoint(const ViewScan& scan, std::size_t scanIndex, std::size_t point, const Ontology* ontology);

PickedThing describeTriangle(const ViewMesh& mesh, std::size_t triangle, const Vec3d& worldPlace);

// 1234567 as "1,234,567".
std::string groupedCount(std::uint64_t count);

}  // namespace scanmill
