#include "gpu/compute.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <new>
#include <thread>

#include "base/error.h"
#include "base/short_text.h"
#include "base/stage_clock.h"
#include "gpu/compute_interface.h"
#include "gpu/device.h"

namespace scanmill {

struct ComputeContext {
  [[noreturn]] void fail(const std::string& why) const { throw Error("{}: {}; {}", words.cannot, why, words.instead); }

  // Calls `work` and returns its result. Converts exceptions of the plug-in to Error with the wording of `words`.
  template <class Work>
  decltype(auto) withErrorWords(const Work& work) const {
    try {
      return work();
    } catch (const std::bad_alloc&) {
      fail(fmt::format("the memory of {} is out", name.empty() ? "the device" : name));
    } catch (const NoDevice& e) {
      fail(fmt::format("this machine has no OpenGL 4.3 with ARB_buffer_storage by EGL ({}): {}", e.what(),
                       kInstallOpenGl));
    } catch (const std::exception& e) {
      fail(e.what());
    }
  }

  ComputeContext(ComputeErrorWords errorWords, const ComputeLimits& extraLimits) : words(std::move(errorWords)) {
    backend = withErrorWords([] { return moduleOf<ComputeModule>().open(namedDevice()); });
    name = backend->name();
    limits = backend->limits();
    limits.bufferBytes = std::min(limits.bufferBytes, extraLimits.bufferBytes);
    limits.tableTexels = std::min(limits.tableTexels, extraLimits.tableTexels);
  }

  ComputeErrorWords words;
  std::unique_ptr<ComputeBackend> backend;
  ComputeLimits limits;
  std::string name;
};

std::vector<FoundDevice> findDevices() {
  const ComputeModule& module = moduleOf<ComputeModule>();
  std::vector<FoundDevice> devices;
  for (const std::string& name : module.devices()) {
    try {
      const std::unique_ptr<ComputeBackend> device = module.open(name);
      devices.push_back({name, device->name(), true, device->software()});
    } catch (const std::exception& e) {
      devices.push_back({name, e.what()});
    }
  }
  return devices;
}

std::uint64_t texelBytes(ComputeTable::Texel texel) {
  constexpr std::uint64_t kBytes[] = {2, 4, 16, 16};  // by ComputeTable::Texel
  return kBytes[static_cast<std::size_t>(texel)];
}

ComputeDevice::ComputeDevice(ComputeErrorWords words, const ComputeLimits& extraLimits)
    : context_(std::make_shared<ComputeContext>(std::move(words), extraLimits)) {}

const std::string& ComputeDevice::name() const {
  return context_->name;
}

bool ComputeDevice::software() const {
  return context_->backend->software();
}

const ComputeLimits& ComputeDevice::limits() const {
  return context_->limits;
}

void ComputeDevice::atOnce(const std::function<void()>& work) const {
  context_->backend->atOnce(work);
}

void ComputeDevice::fail(const std::string& why) const {
  context_->fail(why);
}

ComputeBuffer::ComputeBuffer(const ComputeDevice& device)
    : context_(device.context_), buffer_(context_->withErrorWords([&] { return context_->backend->makeBuffer(); })) {
  reserve(16);  // buffers without storage cannot be bound
}

void ComputeBuffer::reserve(std::uint64_t bytes) {
  if (bytes <= bytes_) return;
  bytes_ = 0;  // the size is unknown until resizing has succeeded
  context_->withErrorWords([&] { context_->backend->resize(*buffer_, bytes); });
  bytes_ = bytes;
}

void ComputeBuffer::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  context_->withErrorWords([&] { context_->backend->write(*buffer_, offset, bytes); });
}

ComputeReadback::ComputeReadback(const ComputeDevice& device)
    : context_(device.context_),
      readback_(context_->withErrorWords([&] { return context_->backend->makeReadback(); })) {}

void ComputeReadback::start(const ComputeBuffer& buffer, std::uint64_t bytes) {
  copy_ = nullptr;
  context_->withErrorWords([&] { context_->backend->startCopy(*readback_, *buffer.buffer_, bytes); });
  bytes_ = bytes;
}

std::span<const std::byte> ComputeReadback::wait() {
  constexpr double kSpin = 1e-3;      // s, time during which the device is queried without pauses
  constexpr double kTimeLimit = 120;  // s, longest time to wait for a copy: the driver probably hangs then
  constexpr auto kPause = std::chrono::microseconds(50);
  const std::scoped_lock lock(waiting_);
  const WallTimer timer;
  while (copy_ == nullptr) {
    copy_ = context_->withErrorWords([&] { return context_->backend->copied(*readback_); });
    if (copy_ != nullptr) break;
    if (timer.seconds() > kSpin) std::this_thread::sleep_for(kPause);
    if (timer.seconds() <= kTimeLimit) continue;
    context_->fail(fmt::format("{} has not answered for {} s", context_->name, kTimeLimit));
  }
  return {copy_, bytes_};
}

// The shader compares an invocation's index in the dispatch with the number of remaining invocations, because
// firstInvocation plus the index could overflow.
std::string computeShaderText(std::string_view text) {
  return fmt::format(R"(#version 430 core
layout(local_size_x = {}) in;
layout(location = {}) uniform uint firstInvocation;
layout(location = {}) uniform uint endInvocation;
{}
void main() {{
  if (gl_GlobalInvocationID.x < endInvocation - firstInvocation) invoke(firstInvocation + gl_GlobalInvocationID.x);
}}
)",
                     kComputeGroup, kFirstInvocation, kEndInvocation, text);
}

ComputeProgram::ComputeProgram(const ComputeDevice& device, const std::string& name, const std::string& text)
    : context_(device.context_),
      program_(
          context_->withErrorWords([&] { return context_->backend->makeProgram(name, computeShaderText(text)); })) {}

void ComputeProgram::run(std::uint64_t invocations, std::initializer_list<const ComputeBuffer*> buffers,
                         std::span<const std::byte> parameters, std::initializer_list<ComputeTable> tables) {
  std::vector<const GlBuffer*> storageBuffers;
  for (const ComputeBuffer* buffer : buffers) storageBuffers.push_back(buffer->buffer_.get());
  std::vector<ComputeRun::Table> textures;
  for (const ComputeTable& table : tables) textures.push_back({table.buffer->buffer_.get(), table.texel});
  context_->withErrorWords([&] {
    context_->backend->run({*program_, storageBuffers, textures, parameters, invocations});
  });
}

void checkTable(const ComputeDevice& device, ComputeTable::Texel texel, std::uint64_t bytes,
                const std::string& contents, const std::string& remedy) {
  const std::uint64_t tableBytes = device.limits().tableTexels * texelBytes(texel);
  if (bytes / texelBytes(texel) <= device.limits().tableTexels) return;
  device.fail(fmt::format("the {} take {}, of which a table on {} holds {}{}", contents, shortBytes(bytes),
                          device.name(), shortBytes(tableBytes), remedy));
}

void uploadTable(const ComputeDevice& device, ComputeBuffer& buffer, ComputeTable::Texel texel,
                 std::span<const std::byte> array, const std::string& contents, const std::string& remedy) {
  checkTable(device, texel, array.size(), contents, remedy);
  if (!array.empty()) buffer.upload(array);
}

std::string glslConstant(const char* name, float value) {
  // A macro and not a `const float`: some shader compilers do not treat uintBitsToFloat() as a constant expression.
  return fmt::format("#define {} uintBitsToFloat({:#x}u)\n", name, std::bit_cast<std::uint32_t>(value));
}

std::string glslConstant(const char* name, std::uint32_t value) {
  return fmt::format("const uint {} = {:#x}u;\n", name, value);
}

}  // namespace scanmill
