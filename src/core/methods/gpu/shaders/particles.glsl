// Finds the rays of a dispatch's particles. The storage buffers 0 to 3 are as in rays.glsl.

// The block has the layout of ParticleParameters in gl_marcher.cpp.
layout(std140, binding = 0) uniform Parameters {
  double nearest, farthest;  // range limits of the sensor (m)
  uint channels, rays;
  uint rings, columns;
  uint first;          // index of the slice's first particle, counted shot after shot
  uint count;          // number of particles in the slice
  uint withOrigins;
  uint shotParticles, shotRays, shotPoses;
  uint firstAlpha;     // triangles from this index on are alpha-tested
  uint coversScene;    // 1: the box contains the complete scene
  uint last;           // 1: the CPU continues the particles that pass one more hole
  int lastLevel;
  float reach;         // FieldShape::reach
  float metres;        // voxel size of level 0 (m), like `voxel`, in float32
  double voxel;        // voxel size of level 0 (m)
  double pathLength;   // length of the particles' paths (m)
  dvec4 low, high;     // corners of the box in which particles march (m)
  dvec4 centre;        // x, y, z: the field's centre (m); w: voxels of level 0 per metre
  double rangeErrorBound;  // kRangeErrorBound of methods/world/resolve.h
  // Values of the constants with these names in march_rule.h.
  double layerLookupOffset, layerThickness, layerMinCosine;
};

#include "rays.glsl"

// Finds the ray of particle `i` of the slice. For a surplus particle (MarchJob), finds the ray of the last column and
// returns false.
bool particleRay(uint i, out uint ray, out dvec3 o, out dvec3 d) {
  uint shot = (first + i) / shotParticles;
  uint particle = (first + i) % shotParticles;
  uint tile = particle / kGroupColumns;
  uint groupColumn = tile / rings * kGroupColumns + particle % kGroupColumns;  // beyond the columns: a surplus particle
  uint column = min(groupColumn, columns - 1u);
  uint rayOfShot = tile % rings * columns + column;
  ray = shot * shotRays + rayOfShot;
  rayOf(rayOfShot, column, shot * shotPoses, withOrigins != 0u, o, d);
  return groupColumn < columns;
}
