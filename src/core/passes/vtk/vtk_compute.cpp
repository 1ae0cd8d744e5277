// Computing by the module of the VTK renderer, which is where OpenGL is.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "base/error.h"
#include "passes/compute.h"
#include "passes/vtk/vtk_loader.h"

namespace scanmill {

struct ComputeContext {
  explicit ComputeContext(ComputeErrorWords errorWords) : words(std::move(errorWords)) {
    try {
      functions = vtkModule().compute;
    } catch (const Error& e) {
      fail(e.what());
    }
    ScanmillVtkText described{};
    ScanmillVtkText error{};
    require(functions->open(std::getenv("SCANMILL_GL_DEVICE"), &compute, &limits, &described, &error), error);
    name = described.text;
  }
  ~ComputeContext() { functions->close(compute); }
  ComputeContext(const ComputeContext&) = delete;
  ComputeContext& operator=(const ComputeContext&) = delete;

  [[noreturn]] void fail(const std::string& why) const {
    throw Error(fmt::format("{}: {}; {}", words.cannot, why, words.instead));
  }

  void require(ScanmillVtkStatus status, const ScanmillVtkText& error) const {
    switch (status) {
      case kScanmillVtkDone:
        return;
      case kScanmillVtkNoDevice:
        fail(
            fmt::format("this machine has no OpenGL 4.3 by EGL ({}): install Mesa (on Debian the packages libegl-mesa0 "
                        "and libgl1-mesa-dri) or the graphics card's driver with its EGL library",
                        error.text));
      case kScanmillVtkOutOfMemory:
        fail(fmt::format("the memory of {} is out", name.empty() ? "the device" : name));
      case kScanmillVtkFailed:
        break;
    }
    fail(error.text);
  }

  ComputeErrorWords words;
  const ScanmillComputeFunctions* functions = nullptr;
  ScanmillCompute* compute = nullptr;
  ScanmillComputeLimits limits{};
  std::string name;
};

namespace {

ScanmillComputeTexel texelOf(ComputeTable::Texel texel) {
  switch (texel) {
    case ComputeTable::Texel::Uint16:
      return kScanmillUint16;
    case ComputeTable::Texel::Uint32:
      return kScanmillUint32;
    case ComputeTable::Texel::Uint32x4:
      return kScanmillUint32x4;
    case ComputeTable::Texel::Float32x4:
      break;
  }
  return kScanmillFloat32x4;
}

}  // namespace

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

bool ComputeDevice::software() const {
  return context_->limits.software != 0;
}

std::uint64_t ComputeDevice::mostBufferBytes() const {
  return context_->limits.bufferBytes;
}

std::uint64_t ComputeDevice::mostTableTexels() const {
  return context_->limits.tableTexels;
}

std::uint32_t ComputeDevice::mostBuffers() const {
  return context_->limits.buffers;
}

std::uint32_t ComputeDevice::mostTables() const {
  return context_->limits.tables;
}

void ComputeDevice::finish() {
  ScanmillVtkText error{};
  context_->require(context_->functions->finish(context_->compute, &error), error);
}

void ComputeDevice::fail(const std::string& why) const {
  context_->fail(why);
}

ComputeBuffer::ComputeBuffer(const ComputeDevice& device) : context_(device.context_) {
  ScanmillVtkText error{};
  context_->require(context_->functions->makeBuffer(context_->compute, &number_, &error), error);
}

ComputeBuffer::~ComputeBuffer() {
  context_->functions->dropBuffer(context_->compute, number_);
}

void ComputeBuffer::reserve(std::uint64_t bytes) {
  if (bytes <= bytes_) return;
  bytes_ = 0;  // what the buffer has where it cannot grow is not known
  ScanmillVtkText error{};
  context_->require(context_->functions->resize(context_->compute, number_, bytes, &error), error);
  bytes_ = bytes;
}

void ComputeBuffer::write(std::span<const Source> pieces) {
  std::vector<ScanmillComputeSource> sent;
  for (const Source& p : pieces) sent.push_back({p.offset, p.bytes.size(), p.bytes.data()});
  ScanmillVtkText error{};
  context_->require(context_->functions->write(context_->compute, number_, sent.data(), sent.size(), &error), error);
}

void ComputeBuffer::read(std::span<const Target> pieces) const {
  std::vector<ScanmillComputeTarget> wanted;
  for (const Target& p : pieces) wanted.push_back({p.offset, p.bytes.size(), p.bytes.data()});
  ScanmillVtkText error{};
  context_->require(context_->functions->read(context_->compute, number_, wanted.data(), wanted.size(), &error), error);
}

ComputeProgram::ComputeProgram(const ComputeDevice& device, const std::string& name, const std::string& text)
    : context_(device.context_) {
  ScanmillVtkText error{};
  context_->require(context_->functions->makeProgram(context_->compute, name.c_str(), text.c_str(), &number_, &error),
                    error);
}

ComputeProgram::~ComputeProgram() {
  context_->functions->dropProgram(context_->compute, number_);
}

void ComputeProgram::run(std::uint64_t invocations, std::initializer_list<const ComputeBuffer*> buffers,
                         std::span<const std::byte> parameters, std::initializer_list<ComputeTable> tables) {
  const ComputeContext& context = *context_;
  const ScanmillComputeLimits& limits = context.limits;
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
  std::vector<ScanmillComputeTable> shown;
  for (const ComputeTable& table : tables) {
    const std::uint64_t texels = table.buffer->bytes_ / texelBytes(table.texel);
    if (texels > limits.tableTexels) {
      context.fail(
          fmt::format("a table has {} texels, and at most {} on {}", texels, limits.tableTexels, context.name));
    }
    shown.push_back({table.buffer->number_, texelOf(table.texel)});
  }
  const ScanmillComputeRun run{number_,           static_cast<std::uint32_t>(numbers.size()),
                               numbers.data(),    shown.size(),
                               shown.data(),      parameters.data(),
                               parameters.size(), invocations};
  ScanmillVtkText error{};
  context.require(context.functions->run(context.compute, &run, &error), error);
}

}  // namespace scanmill
