// The plug-in libscanmill_passes.so: VTK with its own OpenGL context, with the interface of passes/vtk/vtk_interface.h.

#include <vtkAutoInit.h>
#include <vtkNew.h>
#include <vtkRenderState.h>
#include <vtkRenderer.h>
#include <vtk_glew.h>

#include <array>
#include <memory>
#include <string>

#include "gpu/device.h"
#include "gpu/opengl_module/egl_context.h"
#include "gpu/opengl_module/gl_thread.h"
#include "gpu/opengl_module/gl_window.h"
#include "passes/vtk/vtk_interface.h"
#include "passes/vtk_module/image_pass.h"
#include "passes/vtk_module/pixel_reader.h"
#include "passes/vtk_module/triangle_store.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)

namespace scanmill {

namespace {

// An OpenGL context and the objects that render in it. They are created and used while the context is current.
struct ContextState {
  explicit ContextState(const std::string& device) : context(device) {
    window->start(8, 8);  // nothing is drawn to the window itself
    if (!GLEW_VERSION_4_3) throw NoDevice("VTK does not find OpenGL 4.3");
    window->AddRenderer(renderer);
    reader = std::make_unique<GlPixelReader>();
  }
  ~ContextState() {
    triangles.reset();
    reader.reset();
    pass->ReleaseGraphicsResources(window);
    window->Finalize();
  }
  ContextState(const ContextState&) = delete;
  ContextState& operator=(const ContextState&) = delete;

  EglContext context;
  vtkNew<GlWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<ImagePass> pass;
  std::unique_ptr<TriangleStore> triangles;
  std::unique_ptr<GlPixelReader> reader;
};

class GlDevice final : public VtkDevice {
 public:
  explicit GlDevice(const std::string& device) {
    thread_->run([&] {
      Quiet quiet;
      auto made = std::make_unique<ContextState>(device);
      GLint size = 0;
      glGetIntegerv(GL_MAX_TEXTURE_SIZE, &size);
      limits_ = {static_cast<std::uint32_t>(size), 0x7FFFFFFFu / 3};  // OpenGL's vertex indices are signed
      name_ = describeGl();
      state_ = std::move(made);
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

  void upload(const VtkScene& scene) override {
    withContext([&](ContextState& state) { state.triangles = std::make_unique<TriangleStore>(scene); });
  }

  void draw(std::uint32_t slot, const VtkImage& image) override {
    withContext([&](ContextState& state) {
      state.pass->next(state.triangles.get(), &image, slot);
      // Render without the window, which would copy the result to a default framebuffer that does not exist.
      const vtkRenderState renderState(state.renderer);
      state.pass->Render(&renderState);
    });
  }

  void finish() override {
    withContext([](ContextState&) { glFinish(); });
  }

  void gather(const VtkPixels& pixels, std::span<const std::uint32_t> addresses, std::uint32_t* numbers) override {
    withContext([&](ContextState& state) {
      std::array<vtkTextureObject*, kVtkImages> images{};
      for (std::uint32_t slot = 0; slot < kVtkImages; ++slot) images[slot] = state.pass->numbers(slot);
      state.reader->gather(images, pixels, addresses, numbers);
    });
  }

  void read(std::uint32_t slot, std::uint32_t firstRow, std::uint32_t rows, std::uint32_t* numbers) override {
    withContext([&](ContextState& state) { state.reader->read(state.pass->numbers(slot), firstRow, rows, numbers); });
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
