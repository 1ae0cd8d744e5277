#pragma once

// How fast a device's memory is, so that a benchmark can tell what share of it a program uses.

#include <cstdint>
#include <string>
#include <vector>

#include "gpu/compute.h"
#include "tests/benchmarks/timing.h"

namespace scanmill {

// Bytes a second that a program reads and writes together, which copies a buffer.
inline double deviceBandwidth() {
  ComputeDevice device({"the device cannot be measured", "leave it out"});
  ComputeProgram copy(device, "copy", R"(
layout(std430, binding = 0) readonly restrict buffer From { uvec4 from[]; };
layout(std430, binding = 1) writeonly restrict buffer To { uvec4 to[]; };
void invoke(uint i) { to[i] = from[i]; }
)");
  constexpr std::uint64_t kWords = std::uint64_t{1} << 22;
  ComputeBuffer from(device);
  ComputeBuffer to(device);
  from.reserve(16 * kWords);
  to.reserve(16 * kWords);
  constexpr int kTimes = 20;
  const auto runs = [&] {
    for (int k = 0; k < kTimes; ++k) copy.run(kWords, {&from, &to});
    device.finish();
  };
  runs();
  return 2.0 * 16 * kWords * kTimes / secondsOf(runs);
}

}  // namespace scanmill
