// Particles march until they are at a surface. The voxel corner nearest to the particle then gives the triangle.

#include "march.glsl"

float mixed(float a, float b, float t) {
  precise float between = a + (b - a) * t;
  return between;
}

float row(uint i, float t) {
  return mixed(distanceAt(i), distanceAt(i + 1u), t);
}

float interpolate(Voxel v) {
  precise float below = mixed(row(v.cell, v.f.x), row(v.cell + 9u, v.f.x), v.f.y);
  precise float above = mixed(row(v.cell + 81u, v.f.x), row(v.cell + 90u, v.f.x), v.f.y);
  precise float here = mixed(below, above, v.f.z) * kDistanceStep;
  return here;
}

void invoke(uint i) {
  precise vec3 o = column3(0u, i);
  precise vec3 d = column3(3u, i);
  precise float travelled = particles[6u * count + i];
  precise float end = particles[7u * count + i];
  for (uint taken = 0u; taken < steps; ++taken) {
    if (!(travelled < end)) {
      record(i, 0.0, 0u, kMiss + 4u * taken);
      return;
    }
    precise vec3 q = o + d * travelled;
    Voxel v = voxelOf(q, levelAt(q));
    precise float ahead;
    precise float near = v.full ? distanceAt(v.nearest) * kDistanceStep : uintBitsToFloat(v.brick);
    if (near > kNearestLimit) {
      Chord chord = chordOf(near, v.full ? kNearestChordFactor : kEmptyChordFactor, v.full ? v.r : v.b, d);
      ahead = chord.across - chord.along;
    } else {
      ahead = interpolate(v);
      if (ahead <= kHitDistance) {
        record(i, travelled, fetch(trianglesOrLists, v.nearest), kHit + 4u * (taken + 1u));
        return;
      }
    }
    precise float stride = ahead * v.voxelSize;
    travelled = travelled + stride;
  }
  record(i, 0.0, 0u, kExhausted + 4u * steps);
}
