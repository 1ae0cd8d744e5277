#include "gpu/compute.h"

#include <bit>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "base/random.h"
#include "tests/support/gl.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using Words = std::vector<std::uint32_t>;

const ComputeErrorWords kWords{"tests cannot compute", "do it by hand"};

constexpr const char* kHash = R"(
layout(std140, binding = 0) uniform Parameters { uint factor; };
layout(std430, binding = 0) readonly buffer From { uint from[]; };
layout(std430, binding = 1) buffer To { uint to[]; };
void invoke(uint i) { to[i] += from[i] * factor + i; }
)";

Words counted(std::size_t count) {
  Words words(count);
  std::iota(words.begin(), words.end(), 5u);
  return words;
}

std::uint32_t hashed(std::uint32_t before, std::uint32_t from, std::uint32_t factor, std::uint32_t i) {
  return before + from * factor + i;
}

TEST(Compute, RunsEveryInvocationOnce) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  ComputeProgram program(device, "hash", kHash);
  const std::uint32_t factor = 2654435761u;
  for (const std::size_t count : {1u, 63u, 64u, 65u, 1000u}) {
    ComputeBuffer from(device);
    ComputeBuffer to(device);
    const Words start = counted(count + 1);
    from.upload(std::span<const std::uint32_t>(start));
    to.upload(std::span<const std::uint32_t>(start));
    program.run(count, {&from, &to}, std::as_bytes(std::span(&factor, 1)));
    Words expected = start;  // what lies behind stays
    for (std::uint32_t i = 0; i < count; ++i) expected[i] = hashed(start[i], start[i], factor, i);
    EXPECT_EQ(copyOf<std::uint32_t>(device, to, count + 1), expected) << count;
    EXPECT_EQ(copyOf<std::uint32_t>(device, from, count + 1), start);
  }
}

// More than the 65535 groups of 64 that OpenGL promises for one dispatch.
TEST(Compute, RunsMoreThanOneDispatchTakes) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  if (device.limits().bufferBytes < 20'000'004) GTEST_SKIP() << "buffers are small here";
  ComputeProgram program(device, "count", R"(
layout(std430, binding = 0) buffer Counts { uint counts[]; };
void invoke(uint i) { atomicAdd(counts[i], i ^ 7u); }
)");
  ComputeBuffer counts(device);
  const std::size_t count = 5'000'000;
  counts.upload(std::span<const std::uint32_t>(Words(count + 1, 1u)));
  program.run(count, {&counts});
  const Words got = copyOf<std::uint32_t>(device, counts, count + 1);
  std::size_t wrong = 0;
  for (std::uint32_t i = 0; i < count; ++i) wrong += got[i] != 1 + (i ^ 7u);
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(got.back(), 1u);
}

TEST(Compute, RunsAfterEachOtherSeeWhatWasWritten) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  ComputeProgram program(device, "turn", R"(
layout(std430, binding = 0) readonly buffer From { uint from[]; };
layout(std430, binding = 1) writeonly buffer To { uint to[]; };
void invoke(uint i) { to[i] = from[(i + 1u) % 1000u]; }
)");
  ComputeBuffer a(device);
  ComputeBuffer b(device);
  Words expected = counted(1000);
  a.upload(std::span<const std::uint32_t>(expected));
  b.reserve(4000);
  for (int k = 0; k < 10; ++k) {
    program.run(1000, {&a, &b});
    program.run(1000, {&b, &a});
  }
  std::rotate(expected.begin(), expected.begin() + 20, expected.end());
  EXPECT_EQ(copyOf<std::uint32_t>(device, a, 1000), expected);
}

TEST(Compute, WritesPieces) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  ComputeBuffer buffer(device);
  buffer.upload(std::span<const std::uint32_t>(Words(8, 0u)));
  const Words two{1, 2};
  const Words one{9};
  buffer.write(4, std::as_bytes(std::span(two)));
  buffer.write(24, std::as_bytes(std::span(one)));
  EXPECT_EQ(copyOf<std::uint32_t>(device, buffer, 8), (Words{0, 1, 2, 0, 0, 0, 9, 0}));
  buffer.reserve(4);  // large enough: nothing is lost
  EXPECT_EQ(buffer.bytes(), 32u);
  EXPECT_EQ(copyOf<std::uint32_t>(device, buffer, 8)[6], 9u);
}

// A copy holds what programs had written when it was asked for, however they go on.
TEST(Compute, CopiesComeBackWhileProgramsRunOn) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  ComputeProgram program(device, "count on", R"(
layout(std430, binding = 0) buffer Counts { uint counts[]; };
void invoke(uint i) { counts[i] += i + 1u; }
)");
  constexpr std::size_t kCount = 70'000;
  ComputeBuffer counts(device);
  counts.upload(std::span<const std::uint32_t>(Words(kCount, 0u)));
  ComputeReadback first(device), second(device);
  device.atOnce([&] {
    program.run(kCount, {&counts});
    first.start(counts, 4 * kCount);
    program.run(kCount, {&counts});
    second.start(counts, 400);
    program.run(kCount, {&counts});
  });
  const auto words = [](std::span<const std::byte> bytes) {
    Words copied(bytes.size() / 4);
    std::memcpy(copied.data(), bytes.data(), bytes.size());
    return copied;
  };
  Words expected(kCount);
  std::iota(expected.begin(), expected.end(), 1u);
  EXPECT_EQ(words(first.wait()), expected);
  Words twice(100);
  for (std::uint32_t i = 0; i < 100; ++i) twice[i] = 2 * (i + 1);
  EXPECT_EQ(words(second.wait()), twice);
  second.start(counts, 4 * kCount);  // larger than before
  for (std::uint32_t& word : expected) word *= 3;
  EXPECT_EQ(words(second.wait()), expected);
}

TEST(Compute, WhatFailsAtOnceIsTold) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  ComputeBuffer buffer(device);
  EXPECT_THROW(device.atOnce([&] { buffer.reserve(~std::uint64_t{0} / 4); }), Error);
}

// `precise` forbids contraction: x * y + z is rounded twice, as on the processor.
TEST(Compute, RoundsAsTheProcessorDoes) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  ComputeProgram program(device, "rounding", R"(
layout(std430, binding = 0) buffer Numbers { float numbers[]; };
void invoke(uint i) {
  precise float x = numbers[4u * i];
  precise float y = numbers[4u * i + 1u];
  precise float z = numbers[4u * i + 2u];
  precise float sum = x * y + z - (x - y) * z * 0.1;
  numbers[4u * i + 3u] = sum;
}
)");
  const std::uint32_t count = 10000;
  std::vector<float> numbers(std::size_t{4} * count);
  for (std::uint32_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = static_cast<float>(6 * uniform(randomBlock({.seed = 7, .beam = i})[0]) - 3);
  }
  ComputeBuffer buffer(device);
  buffer.upload(std::span<const float>(numbers));
  program.run(count, {&buffer});
  const auto got = copyOf<float>(device, buffer, numbers.size());
  for (std::size_t i = 0; i < count; ++i) {
    const float* n = &numbers[4 * i];
    ASSERT_EQ(got[4 * i + 3], n[0] * n[1] + n[2] - (n[0] - n[1]) * n[2] * 0.1f) << i;
  }
}

TEST(Compute, TellsWhatTheDeviceIs) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  EXPECT_FALSE(device.name().empty());
  EXPECT_EQ(device.software(), device.name().find("llvmpipe") != std::string::npos ||
                                   device.name().find("softpipe") != std::string::npos ||
                                   device.name().find("SWR") != std::string::npos);
  EXPECT_GE(device.limits().bufferBytes, std::uint64_t{1} << 24);  // OpenGL 4.3 promises so much
  EXPECT_GE(device.limits().tableTexels, 65536u);
}

TEST(Compute, SaysWhatIsAmiss) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  const std::string compiler =
      messageOf<Error>([&] { ComputeProgram(device, "bad", "void invoke(uint i) { rubbish }"); });
  EXPECT_THAT(compiler, HasSubstr("tests cannot compute: the driver does not compile the bad shader: "));
  EXPECT_THAT(compiler, HasSubstr("; do it by hand"));
  ComputeBuffer buffer(device);
  buffer.upload(std::span<const std::uint32_t>(Words{1, 2, 3}));
  EXPECT_EQ(copyOf<std::uint32_t>(device, buffer, 3), (Words{1, 2, 3}));  // the device goes on
}

TEST(Compute, ProgramsReadTables) {
  SKIP_WITHOUT_GL();
  const ComputeDevice device(kWords);
  ComputeProgram program(device, "tables", R"(
layout(std430, binding = 0) writeonly buffer To { uint to[]; };
layout(binding = 0) uniform usamplerBuffer shorts;
layout(binding = 1) uniform usamplerBuffer words;
layout(binding = 2) uniform usamplerBuffer quads;
layout(binding = 3) uniform samplerBuffer numbers;
void invoke(uint i) {
  int k = int(i ^ 1u);  // not in the order in which they lie
  to[4u * i] = texelFetch(shorts, k).x;
  to[4u * i + 1u] = texelFetch(words, k).x;
  uvec4 quad = texelFetch(quads, k);
  to[4u * i + 2u] = quad.x ^ quad.y ^ quad.z ^ quad.w;
  vec4 number = texelFetch(numbers, k);
  to[4u * i + 3u] = floatBitsToUint(number.x) ^ floatBitsToUint(number.y) ^ floatBitsToUint(number.w);
}
)");
  constexpr std::uint32_t kCount = 1000;
  std::vector<std::uint16_t> shorts;
  Words words;
  Words quads;
  std::vector<float> numbers;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const RandomBlock block = randomBlock({.seed = 3, .beam = i});
    shorts.push_back(static_cast<std::uint16_t>(block[0]));
    words.push_back(block[1]);
    quads.insert(quads.end(), block.begin(), block.end());
    for (std::uint32_t k = 0; k < 4; ++k) numbers.push_back(static_cast<float>(18 * uniform(block[k]) - 9));
  }
  ComputeBuffer buffers[] = {ComputeBuffer(device), ComputeBuffer(device), ComputeBuffer(device), ComputeBuffer(device),
                             ComputeBuffer(device)};
  buffers[0].upload(std::span<const std::uint16_t>(shorts));
  buffers[1].upload(std::span<const std::uint32_t>(words));
  buffers[2].upload(std::span<const std::uint32_t>(quads));
  buffers[3].upload(std::span<const float>(numbers));
  buffers[4].reserve(16 * kCount);
  using enum ComputeTable::Texel;
  program.run(kCount, {&buffers[4]}, {},
              {{&buffers[0], Uint16}, {&buffers[1], Uint32}, {&buffers[2], Uint32x4}, {&buffers[3], Float32x4}});
  const Words got = copyOf<std::uint32_t>(device, buffers[4], 4 * kCount);
  const auto bits = [&](std::size_t i) { return std::bit_cast<std::uint32_t>(numbers[i]); };
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::size_t k = i ^ 1u;
    ASSERT_EQ(got[4 * i], shorts[k]);
    ASSERT_EQ(got[4 * i + 1], words[k]);
    ASSERT_EQ(got[4 * i + 2], quads[4 * k] ^ quads[4 * k + 1] ^ quads[4 * k + 2] ^ quads[4 * k + 3]);
    ASSERT_EQ(got[4 * i + 3], bits(4 * k) ^ bits(4 * k + 1) ^ bits(4 * k + 3));
  }
}

// Each name that is told opens the device that is told, and the first usable one is that which is taken.
TEST(Compute, FindsTheDevicesThatMayBeNamed) {
  SKIP_WITHOUT_GL();
  const std::vector<FoundDevice> found = findDevices();
  const auto first = std::find_if(found.begin(), found.end(), [](const FoundDevice& d) { return d.usable; });
  ASSERT_NE(first, found.end());
  EXPECT_EQ(ComputeDevice(kWords).name(), first->driver);
  for (const FoundDevice& device : found) {
    EXPECT_FALSE(device.driver.empty());
    if (!device.usable) continue;
    ::setenv("SCANMILL_GL_DEVICE", device.name.c_str(), 1);
    const ComputeDevice opened(kWords);
    ::unsetenv("SCANMILL_GL_DEVICE");
    EXPECT_EQ(opened.name(), device.driver);
    EXPECT_EQ(opened.software(), device.software);
  }
}

TEST(Compute, SaysWhichDevicesThereAre) {
  SKIP_WITHOUT_GL();
  ::setenv("SCANMILL_GL_DEVICE", "77", 1);
  const std::string message = messageOf<Error>([] { ComputeDevice device(kWords); });
  ::unsetenv("SCANMILL_GL_DEVICE");
  EXPECT_THAT(message, HasSubstr("tests cannot compute: SCANMILL_GL_DEVICE: there is no device '77'"));
}

TEST(Compute, BuffersAndProgramsMayOutliveTheDevice) {
  SKIP_WITHOUT_GL();
  std::optional<ComputeDevice> device(kWords);
  ComputeProgram program(*device, "hash", kHash);
  ComputeBuffer buffer(*device);
  ComputeBuffer to(*device);
  ComputeReadback readback(*device);
  device.reset();
  const Words start = counted(10);
  buffer.upload(std::span<const std::uint32_t>(start));
  to.upload(std::span<const std::uint32_t>(start));
  const std::uint32_t factor = 0;
  program.run(10, {&buffer, &to}, std::as_bytes(std::span(&factor, 1)));
  EXPECT_EQ(copyOf<std::uint32_t>(readback, to, 10)[9], start[9] + 9);
}

}  // namespace
}  // namespace scanmill
