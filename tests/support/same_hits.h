#pragma once

#include <gtest/gtest.h>

#include "scan/hits.h"

namespace scanmill {

// To the bit.
inline void expectSameHits(const Hits& a, const Hits& b) {
  EXPECT_EQ(a.rings, b.rings);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.channels, b.channels);
  EXPECT_EQ(a.range, b.range);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.instance, b.instance);
  EXPECT_EQ(a.semantic, b.semantic);
  EXPECT_EQ(a.material, b.material);
  EXPECT_EQ(a.primitive, b.primitive);
  EXPECT_EQ(a.reflectance, b.reflectance);
  EXPECT_EQ(a.incidence, b.incidence);
  EXPECT_EQ(a.roughness, b.roughness);
  EXPECT_EQ(a.metallic, b.metallic);
  EXPECT_EQ(a.retroreflectance, b.retroreflectance);
  EXPECT_EQ(a.unresolved, b.unresolved);
}

}  // namespace scanmill
