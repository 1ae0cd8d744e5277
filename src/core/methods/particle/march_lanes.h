// SIMD lanes of particles, by Google Highway. Included only by march_cpu.cpp and the files that it includes, so that no
// other file uses Highway's types. Included once for each instruction set: see march_cpu.cpp.
#if defined(SCANMILL_MARCH_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SCANMILL_MARCH_LANES_H
#undef SCANMILL_MARCH_LANES_H
#else
#define SCANMILL_MARCH_LANES_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstdint>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace scanmill::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::ScalableTag<float> kFloats;
constexpr hn::ScalableTag<std::uint32_t> kWords;
constexpr hn::ScalableTag<std::int32_t> kInts;
using Floats = hn::Vec<decltype(kFloats)>;
using Words = hn::Vec<decltype(kWords)>;
using Ints = hn::Vec<decltype(kInts)>;
using Mask = hn::Mask<decltype(kFloats)>;
using WordMask = hn::Mask<decltype(kWords)>;

constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
static_assert(kLanes <= 16);
using LaneFloats = float[kLanes];
using LaneWords = std::uint32_t[kLanes];

// A set of lanes, one bit per lane, for loops over lanes.
using LaneBits = std::uint32_t;

inline LaneBits bitsOf(Mask mask) {
  std::uint8_t bytes[8] = {};  // Highway may write up to 8 bytes
  hn::StoreMaskBits(kFloats, mask, bytes);
  std::uint16_t bits = 0;
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

inline std::size_t firstOf(LaneBits lanes) {
  return static_cast<std::size_t>(std::countr_zero(lanes));
}

inline Floats dotOf(const Floats (&a)[3], const Floats (&b)[3]) {
  return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
}

}  // namespace scanmill::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
