// The plug-in libscanmill_passes.so: VTK with its own OpenGL context, with the interface of passes/vtk/vtk_interface.h.

#include <vtkAutoInit.h>
#include <vtkNew.h>
#include <vtk_glew.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "gpu/device.h"
#include "gpu/opengl_module/egl_context.h"
#include "gpu/opengl_module/gl_thread.h"
#include "gpu/opengl_module/gl_window.h"
#include "passes/vtk/vtk_interface.h"
#include "passes/vtk_module/image_pass.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)

namespace scanmill {

namespace {

constexpr std::uint32_t kGroup = 64;                              // local_size_x of kGather
constexpr std::size_t kMostAtOnce = std::size_t{kGroup} * 65535;  // most addresses per dispatch; OpenGL guarantees
                                                                  // 65535 groups

// Reads pixels from several images. The shader loops over all images, because the index of a sampler must be the same
// for all invocations.
constexpr const char* kGather = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Addresses { uint addresses[]; };
layout(std430, binding = 1) writeonly buffer Numbers { uint numbers[]; };
uniform usampler2D images[8];
uniform uint firsts[9];
uniform uint widths[8];
uniform uint imageCount;
uniform uint count;
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  uint address = addresses[i];
  uint number = 0u;
  for (uint k = 0u; k < imageCount; ++k) {
    if (address >= firsts[k] && address < firsts[k + 1u]) {
      uint pixel = address - firsts[k];
      number = texelFetch(images[k], ivec2(pixel % widths[k], pixel / widths[k]), 0).r;
    }
  }
  numbers[i] = number;
}
)";

// Reads pixels of images back.
class GlPixelReader {
 public:
  GlPixelReader() : program_("gather", {{GL_COMPUTE_SHADER, kGather}}) {}

  // Implements VtkDevice::gather(). `images`: the textures of all slots.
  void gather(const std::array<vtkTextureObject*, kVtkImages>& images, const VtkPixels& pixels,
              std::span<const std::uint32_t> addresses, std::uint32_t* numbers) {
    std::array<GLint, kVtkImages> units{};
    GLuint imageCount = 0;
    for (std::size_t k = 0; k < kVtkImages; ++k) {
      if (images[k]->GetHandle() == 0 || pixels.firsts[k] == pixels.firsts[k + 1]) continue;
      images[k]->Activate();
      units[k] = images[k]->GetTextureUnit();
      imageCount = static_cast<GLuint>(k + 1);
    }
    program_.use();
    glUniform1iv(program_.uniform("images"), kVtkImages, units.data());
    glUniform1uiv(program_.uniform("firsts"), kVtkImages + 1, pixels.firsts);
    glUniform1uiv(program_.uniform("widths"), kVtkImages, pixels.widths);
    glUniform1ui(program_.uniform("imageCount"), imageCount);
    while (!addresses.empty()) {
      const std::size_t count = std::min(addresses.size(), kMostAtOnce);
      const std::size_t bytes = count * sizeof(std::uint32_t);
      addresses_.fill(addresses.data(), bytes, GL_STREAM_DRAW);
      numbers_.reserve(bytes, GL_STREAM_READ);
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, addresses_.name());
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, numbers_.name());
      glUniform1ui(program_.uniform("count"), static_cast<GLuint>(count));
      glDispatchCompute(static_cast<GLuint>((count + kGroup - 1) / kGroup), 1, 1);
      glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      glBindBuffer(GL_COPY_READ_BUFFER, numbers_.name());
      glGetBufferSubData(GL_COPY_READ_BUFFER, 0, static_cast<GLsizeiptr>(bytes), numbers);
      addresses = addresses.subspan(count);
      numbers += count;
    }
    glUseProgram(0);
    for (vtkTextureObject* image : images) {
      if (image->GetHandle() != 0) image->Deactivate();
    }
    checkGl("pixels cannot be read back");
  }

 private:
  GlProgram program_;
  GlBuffer addresses_;
  GlBuffer numbers_;
};

// An OpenGL context and the objects that render in it. They are created and used while the context is current.
struct ContextState {
  explicit ContextState(const std::string& device) : context(device) {
    window->start(8, 8);  // nothing is drawn to the window itself
    if (!GLEW_VERSION_4_3) throw NoDevice("VTK does not find OpenGL 4.3");
    reader = std::make_unique<GlPixelReader>();
  }
  ~ContextState() {
    triangles.reset();
    reader.reset();
    pass.releaseGraphicsResources(window);
    window->Finalize();
  }
  ContextState(const ContextState&) = delete;
  ContextState& operator=(const ContextState&) = delete;

  EglContext context;
  vtkNew<GlWindow> window;
  ImagePass pass;
  std::unique_ptr<TriangleStore> triangles;
  std::unique_ptr<GlPixelReader> reader;
};

class GlDevice final : public VtkDevice {
 public:
  explicit GlDevice(const std::string& device) {
    thread_->run([&] {
      Quiet quiet;
      auto state = std::make_unique<ContextState>(device);
      GLint size = 0;
      glGetIntegerv(GL_MAX_TEXTURE_SIZE, &size);
      limits_ = {.imageSize = static_cast<std::uint32_t>(size),
                 .trianglesPerBatch = 0x7FFFFFFFu / 3};  // OpenGL's vertex indices are signed
      name_ = describeGl();
      state_ = std::move(state);
    });
  }

  ~GlDevice() override {
    thread_->run([&]() noexcept {
      Quiet quiet;
      state_->context.tryMakeCurrent();
      state_.reset();
    });
  }
  GlDevice(const GlDevice&) = delete;
  GlDevice& operator=(const GlDevice&) = delete;

  std::string name() const override { return name_; }
  VtkLimits limits() const override { return limits_; }

  void upload(const ViewGeometry& scene) override {
    withContext([&](ContextState& state) { state.triangles = std::make_unique<TriangleStore>(scene); });
  }

  void draw(std::uint32_t slot, const VtkImage& image) override {
    withContext([&](ContextState& state) { state.pass.draw(state.window, *state.triangles, image, slot); });
  }

  void finish() override {
    withContext([](ContextState&) { glFinish(); });
  }

  void gather(const VtkPixels& pixels, std::span<const std::uint32_t> addresses, std::uint32_t* numbers) override {
    withContext([&](ContextState& state) {
      std::array<vtkTextureObject*, kVtkImages> images{};
      for (std::uint32_t slot = 0; slot < kVtkImages; ++slot) images[slot] = state.pass.numbers(slot);
      state.reader->gather(images, pixels, addresses, numbers);
    });
  }

 private:
  // Calls `work` on the OpenGL thread, with the context current and without VTK's messages.
  template <class Work>
  void withContext(const Work& work) {
    thread_->run([&] {
      Quiet quiet;
      state_->context.makeCurrent();
      work(*state_);
      quiet.check();
    });
  }

  std::shared_ptr<GlThread> thread_ = GlThread::shared();
  std::unique_ptr<ContextState> state_;
  std::string name_;
  VtkLimits limits_;
};

class GlVtkModule final : public VtkModule {
 public:
  std::unique_ptr<VtkDevice> open(const std::string& device) const override {
    return std::make_unique<GlDevice>(device);
  }
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(VtkModule, GlVtkModule)
