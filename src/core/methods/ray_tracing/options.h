#pragma once

#include "config/fields.h"
#include "methods/world/world.h"

namespace scanmill {

// The map `ray_tracing: {...}` of a pipeline. All options except `simplify` give the same hits, up to float32 rounding.
struct RayTracingOptions {
  int packet = 16;      // rays per Embree call: 16, or 1 for comparison in tests
  int tileColumns = 0;  // columns of a packet's tile: 1, 2, 4, 8 or 16; 0: chosen by the angles between beams
  bool robust = true;   // watertight at edges (RTC_SCENE_FLAG_ROBUST)
  HierarchyQuality quality = HierarchyQuality::Medium;
  Instancing instancing = Instancing::Auto;
  double simplify = 1;  // fraction of each mesh's triangles that remains; 1: all
};

RayTracingOptions readRayTracingOptions(Fields& fields);

}  // namespace scanmill
