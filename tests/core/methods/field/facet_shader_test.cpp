#include "methods/field/facet_shader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "base/random.h"
#include "gpu/compute.h"
#include "tests/support/gl.h"

namespace scanmill {
namespace {

constexpr std::size_t kNumbers = 200'000;

// From 1e-60 to 1e60, squares of numbers with few digits, whose roots are exact, and what lies a few units beside a
// power of two, where the distance between numbers changes.
std::vector<double> numbers() {
  std::vector<double> made(kNumbers);
  for (std::uint32_t i = 0; i < kNumbers; ++i) {
    const RandomBlock r = randomBlock({.beam = i, .purpose = Purpose::Test});
    const double x = std::pow(10.0, 120 * uniform(r[0]) - 60) * (1 + uniform(r[1]) + 0x1p-32 * uniform(r[2]));
    const double few = std::floor(1e7 * uniform(r[3])) + 1;
    const double beside = std::ldexp(1.0, static_cast<int>(r[0] % 200) - 100);
    made[i] = i % 8 == 0   ? few * few
              : i % 8 == 1 ? beside * (1 + 0x1p-52 * (r[1] % 12))
              : i % 8 == 2 ? beside * (1 - 0x1p-53 * (r[1] % 12))
                           : x;
  }
  return made;
}

// Three numbers of each: its root, from one that is up to eight units off; likewise 1 / it; and the root of its
// float32.
TEST(FacetShader, RootsAndQuotientsAreRoundedAsTheProcessorsWhateverTheDeviceDoes) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device({"the test cannot run", "there is nothing instead"});
  ComputeProgram program(device, "roots", R"(
layout(std430, binding = 0) readonly restrict buffer Numbers { double numbers[]; };
layout(std430, binding = 1) writeonly restrict buffer Made { double made[]; };
)" + facetShader() + R"(
void invoke(uint i) {
  double x = numbers[i];
  double rough = 1.0LF + 1.1102230246251565e-16LF * (double(i % 33u) - 16.0LF);
  made[3u * i] = rootOf(x, sqrt(x) * rough);
  made[3u * i + 1u] = inverseOf(x, 1.0LF / x * rough);
  made[3u * i + 2u] = double(rootOf(float(x)));
}
)");
  ComputeBuffer given(device);
  ComputeBuffer found(device);
  const std::vector<double> all = numbers();
  std::vector<double> made(3 * all.size());
  given.hold(std::span(all));
  found.reserve(made.size() * sizeof(double));
  program.run(all.size(), {&given, &found});
  const ComputeBuffer::Target target{0, std::as_writable_bytes(std::span(made))};
  found.read({&target, 1});
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(made[3 * i], std::sqrt(all[i])) << all[i];
    ASSERT_EQ(made[3 * i + 1], 1 / all[i]) << all[i];
    const auto single = static_cast<float>(all[i]);
    if (single > 1e-30f && single < 1e30f) {
      ASSERT_EQ(static_cast<float>(made[3 * i + 2]), std::sqrt(single)) << single;
    }
  }
}

}  // namespace
}  // namespace scanmill
