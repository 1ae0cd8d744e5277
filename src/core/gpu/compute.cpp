#include "gpu/compute.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <new>
#include <thread>

#include "base/error.h"
#include "base/stage_clock.h"
#include "gpu/compute_interface.h"
#include "gpu/device.h"

namespace scanmill {

struct ComputeContext {
  [[noreturn]] void fail(const std::string& why) const {
    throw Error(fmt::format("{}: {}; {}", words.cannot, why, words.instead));
  }

  // Calls `work` and returns its result. Converts exceptions of the plug-in to Error with the wording of `words`.
  template <class Work>
  decltype(auto) told(const Work& work) const {
    try {
      return work();
    } catch (const std::bad_alloc&) {
      fail(fmt::format("the memory of {} is out", name.empty() ? "the device" : name));
    } catch (const NoDevice& e) {
      fail(fmt::format("this machine has no OpenGL 4.3 by EGL ({}): {}", e.what(), kInstallOpenGl));
    } catch (const std::exception& e) {
      fail(e.what());
    }
  }

  explicit ComputeContext(ComputeErrorWords errorWords) : words(std::move(errorWords)) {
    backend = told([] { return moduleOf<ComputeModule>().open(namedDevice()); });
    name = backend->name();
    limits = backend->limits();
  }

  ComputeErrorWords words;
  std::unique_ptr<ComputeBackend> backend;
  ComputeLimits limits;
  std::string name;
};

std::vector<FoundDevice> findDevices() {
  const ComputeModule& module = moduleOf<ComputeModule>();
  std::vector<FoundDevice> found;
  for (const std::string& name : module.devices()) {
    try {
      const std::unique_ptr<ComputeBackend> device = module.open(name);
      found.push_back({name, device->name(), true, device->software()});
    } catch (const std::exception& e) {
      found.push_back({name, e.what()});
    }
  }
  return found;
}

std::uint64_t texelBytes(ComputeTable::Texel texel) {
  switch (texel) {
    case ComputeTable::Texel::Uint16:
      return 2;
    case ComputeTable::Texel::Uint32:
      return 4;
    case ComputeTable::Texel::Uint32x4:
    case ComputeTable::Texel::Float32x4:
      break;
  }
  return 16;
}

ComputeDevice::ComputeDevice(ComputeErrorWords words) : context_(std::make_shared<ComputeContext>(std::move(words))) {}

const std::string& ComputeDevice::name() const {
  return context_->name;
}

std::string ComputeDevice::nameAndPlace() const {
  return name() + (software() ? ", on the processor" : "");
}

bool ComputeDevice::software() const {
  return context_->backend->software();
}

std::uint64_t ComputeDevice::mostBufferBytes() const {
  return context_->limits.bufferBytes;
}

std::uint64_t ComputeDevice::mostTableTexels() const {
  return context_->limits.tableTexels;
}

void ComputeDevice::atOnce(const std::function<void()>& work) const {
  context_->backend->atOnce(work);
}

void ComputeDevice::fail(const std::string& why) const {
  context_->fail(why);
}

ComputeBuffer::ComputeBuffer(const ComputeDevice& device)
    : context_(device.context_), number_(context_->told([&] { return context_->backend->makeBuffer(); })) {}

ComputeBuffer::~ComputeBuffer() {
  context_->backend->dropBuffer(number_);
}

void ComputeBuffer::reserve(std::uint64_t bytes) {
  if (bytes <= bytes_) return;
  bytes_ = 0;  // size unknown until resizing has succeeded
  context_->told([&] { context_->backend->resize(number_, bytes); });
  bytes_ = bytes;
}

void ComputeBuffer::write(std::span<const Source> pieces) {
  context_->told([&] { context_->backend->write(number_, pieces); });
}

ComputeReadback::ComputeReadback(const ComputeDevice& device)
    : context_(device.context_), number_(context_->told([&] { return context_->backend->makeReadback(); })) {}

ComputeReadback::~ComputeReadback() {
  context_->backend->dropReadback(number_);
}

void ComputeReadback::start(const ComputeBuffer& buffer, std::uint64_t bytes) {
  copy_ = nullptr;
  context_->told([&] { context_->backend->startCopy(number_, buffer.number_, bytes); });
  bytes_ = bytes;
}

std::span<const std::byte> ComputeReadback::wait() {
  constexpr double kSpin = 1e-3;  // time during which the device is queried without pauses (s)
  constexpr double kMost = 120;   // longest time that a copy may take; then an error is thrown (s)
  constexpr auto kPause = std::chrono::microseconds(50);
  const std::scoped_lock lock(asking_);
  const WallTimer waiting;
  while (copy_ == nullptr) {
    copy_ = context_->told([&] { return context_->backend->copied(number_); });
    if (copy_ != nullptr) break;
    if (waiting.seconds() > kSpin) std::this_thread::sleep_for(kPause);
    if (waiting.seconds() > kMost) context_->fail(fmt::format("{} has not answered for {} s", context_->name, kMost));
  }
  return {copy_, bytes_};
}

ComputeReadbacks::ComputeReadbacks(const ComputeDevice& device, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) free_.push_back(std::make_unique<ComputeReadback>(device));
}

ComputeReadbacks::Lease::Lease(ComputeReadbacks& all) : all_(all) {
  std::unique_lock lock(all_.mutex_);
  all_.freed_.wait(lock, [&] { return !all_.free_.empty(); });
  one_ = std::move(all_.free_.back());
  all_.free_.pop_back();
}

ComputeReadbacks::Lease::~Lease() {
  {
    const std::scoped_lock lock(all_.mutex_);
    all_.free_.push_back(std::move(one_));
  }
  all_.freed_.notify_one();
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
      number_(context_->told([&] { return context_->backend->makeProgram(name, computeShaderText(text)); })) {}

ComputeProgram::~ComputeProgram() {
  context_->backend->dropProgram(number_);
}

void ComputeProgram::run(std::uint64_t invocations, std::initializer_list<const ComputeBuffer*> buffers,
                         std::span<const std::byte> parameters, std::initializer_list<ComputeTable> tables) {
  const ComputeContext& context = *context_;
  const ComputeLimits& limits = context.limits;
  if (invocations > 0xFFFFFFFFu || buffers.size() > limits.buffers || tables.size() > limits.tables ||
      parameters.size() > limits.parameterBytes) {
    context.fail(fmt::format("{} invocations with {} buffers, {} tables and {} bytes of parameters are too many for {}",
                             invocations, buffers.size(), tables.size(), parameters.size(), context.name));
  }
  std::vector<std::uint32_t> numbers;
  for (const ComputeBuffer* buffer : buffers) {
    if (buffer->bytes_ > limits.bufferBytes) {
      context.fail(
          fmt::format("a buffer has {} bytes, and at most {} on {}", buffer->bytes_, limits.bufferBytes, context.name));
    }
    numbers.push_back(buffer->number_);
  }
  std::vector<ComputeRun::Table> shown;
  for (const ComputeTable& table : tables) {
    const std::uint64_t texels = table.buffer->bytes_ / texelBytes(table.texel);
    if (texels > limits.tableTexels) {
      context.fail(
          fmt::format("a table has {} texels, and at most {} on {}", texels, limits.tableTexels, context.name));
    }
    shown.push_back({table.buffer->number_, table.texel});
  }
  context.told([&] { context.backend->run({number_, numbers, shown, parameters, invocations}); });
}

std::uint64_t mostTableBytes(const ComputeDevice& device, ComputeTable::Texel texel, std::uint64_t most) {
  return std::min(most, device.mostTableTexels() * texelBytes(texel));
}

void checkTable(const ComputeDevice& device, ComputeTable::Texel texel, std::uint64_t bytes, std::uint64_t most,
                const std::string& what, const std::string& mend) {
  const std::uint64_t held = mostTableBytes(device, texel, most);
  if (bytes <= held) return;
  constexpr double kMebi = 1 << 20;
  device.fail(fmt::format("the {} take {:.1f} MiB, of which a table on {} holds {:.1f} MiB{}", what,
                          static_cast<double>(bytes) / kMebi, device.name(), static_cast<double>(held) / kMebi, mend));
}

void holdTable(const ComputeDevice& device, ComputeBuffer& buffer, ComputeTable::Texel texel,
               std::span<const std::byte> array, std::uint64_t most, const std::string& what, const std::string& mend) {
  checkTable(device, texel, array.size(), most, what, mend);
  if (!array.empty()) buffer.hold(array);
}

std::string glslConstant(const char* name, float value) {
  // This is a macro and not a `const float`, since some shader compilers do not accept the call as a constant
  // expression.
  return fmt::format("#define {} uintBitsToFloat({:#x}u)\n", name, std::bit_cast<std::uint32_t>(value));
}

std::string glslConstant(const char* name, std::uint32_t value) {
  return fmt::format("const uint {} = {:#x}u;\n", name, value);
}

}  // namespace scanmill
