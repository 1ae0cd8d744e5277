#pragma once

// Counter-based random numbers: a value is computed from an address instead of the state of a shared stream. The same
// address gives the same value on any thread and any machine. Philox4x32-10: Salmon, Moraes, Dror, Shaw, "Parallel
// random numbers: as easy as 1, 2, 3", SC 2011.

#include <array>
#include <cstdint>

namespace scanmill {

// The purpose of a random number. Different purposes get independent numbers. A dataset depends on these values: append
// new purposes, never renumber.
enum class Purpose : std::uint16_t {
  RangeNoise = 1,
  AngularJitter = 2,
  ShellNoise = 3,
  DropOut = 4,
  Street = 5,
  Bootstrap = 6,
  RingBias = 7,
  Footprint = 8,
  Detection = 9,
  FalsePositives = 10,
  ReflectanceVariation = 11,
  Weather = 12,
  Fog = 13,
  WetGround = 14,
  Interference = 15,
  Relief = 16,
  Sway = 17,
  RandomPath = 18,
  Placement = 19,
  Shuffle = 20,
  Distribution = 21,
  LostRings = 22,
  IntensityNoise = 23,
  Reflectance = 24,
  Stratum = 25,
  Speckle = 256,  // 256 to 263: each value gives the words of four looks of speckle
  Test = 99,
};

// The address of a random number. Two different addresses give independent numbers.
struct RandomAddress {
  std::uint64_t seed = 0;
  std::uint32_t scene = 0;  // index of the sequence (scene, scene seed, trajectory) in the pipeline
  std::uint32_t frame = 0;
  std::uint32_t sensor = 0;  // index of the sensor, below 4096
  std::uint32_t beam = 0;    // index of the beam: ring * columns + column
  std::uint32_t number = 0;  // index of the return, 0 to 15
  Purpose purpose = Purpose::Test;
};

// Four words, each uniform over all 32-bit values.
using RandomBlock = std::array<std::uint32_t, 4>;

// Returns the random words that Philox4x32-10 computes from a counter and a key.
constexpr RandomBlock philox4x32(RandomBlock counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53} * counter[0];
    const std::uint64_t p1 = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(p1),
               static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(p0)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

// Returns the random words of an address.
constexpr RandomBlock randomBlock(const RandomAddress& a) {
  const std::uint32_t tail = (a.sensor << 20) | ((a.number & 15) << 16) | static_cast<std::uint32_t>(a.purpose);
  return philox4x32({a.beam, a.frame, a.scene, tail},
                    {static_cast<std::uint32_t>(a.seed), static_cast<std::uint32_t>(a.seed >> 32)});
}

// Turns a random word into a uniform number in the open interval (0, 1): never 0, so that its logarithm is finite.
constexpr double uniform(std::uint32_t bits) {
  return (bits + 0.5) * (1.0 / 4294967296.0);
}

}  // namespace scanmill
