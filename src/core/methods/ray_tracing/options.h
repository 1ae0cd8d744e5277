#pragma once

#include "config/fields.h"
#include "methods/backend_choice.h"
#include "methods/world/world.h"

namespace scanmill {

// The map `ray_tracing: {...}` of a pipeline. All but `simplify` give the same hits, up to what float32
// rounds.
struct RayTracingOptions {
  // Where rays meet triangles: on the processor, on a device of OpenGL, or wherever the first scan is traced faster.
  BackendChoice::Asked backend = BackendChoice::Asked::Auto;
  int packet = 16;      // rays per Embree call: 16, or 1 as the reference for tests
  int tileColumns = 0;  // columns of a packet's tile: 1, 2, 4, 8 or 16; 0 picks by the beams' spacing
  bool robust = true;   // watertight at edges (RTC_SCENE_FLAG_ROBUST)
  HierarchyQuality quality = HierarchyQuality::Medium;
  Instancing instancing = Instancing::Auto;
  double simplify = 1;  // share of each mesh's triangles that is kept; 1: all
};

RayTracingOptions readRayTracingOptions(Fields& fields);

}  // namespace scanmill
