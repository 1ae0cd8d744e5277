// libscanmill_passes.so: VTK on an OpenGL context of our own, behind the functions of passes/vtk/vtk_module.h. It is
// not part of the program, which loads it when it draws the first image or computes by OpenGL (gl_compute.h).

#include <fmt/format.h>
#include <vtkAutoInit.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkRenderState.h>
#include <vtkRenderer.h>
#include <vtkVersion.h>

#include <array>
#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "passes/vtk/vtk_module.h"
#include "passes/vtk_module/egl_context.h"
#include "passes/vtk_module/gl_compute.h"
#include "passes/vtk_module/gl_thread.h"
#include "passes/vtk_module/guarded.h"
#include "passes/vtk_module/image_pass.h"
#include "passes/vtk_module/pixel_reader.h"
#include "passes/vtk_module/triangle_store.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)

namespace {

using namespace scanmill;

// Keeps VTK's messages, which would go to standard error otherwise.
class Messages : public vtkOutputWindow {
 public:
  static Messages* New();

  void DisplayText(const char*) override {}
  void DisplayErrorText(const char* text) override { errors_ += text; }
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}

  std::string take() { return std::exchange(errors_, {}); }

 private:
  std::string errors_;
};

vtkStandardNewMacro(Messages);

// A window that is none: VTK needs one to hold its state of OpenGL.
class Window : public vtkGenericOpenGLRenderWindow {
 public:
  static Window* New();

  // GLEW finds OpenGL's functions, then asks for an X display, finds none and calls that an error. What counts is
  // whether the functions are there.
  void OpenGLInitContext() override {
    if (Initialized) return;
    const int display = GetGlobalWarningDisplay();
    GlobalWarningDisplayOff();
    vtkGenericOpenGLRenderWindow::OpenGLInitContext();
    SetGlobalWarningDisplay(display);
    if (!GLEW_VERSION_4_3) throw NoDevice("VTK does not find OpenGL 4.3");
    Initialized = true;
    GlewInitValid = true;
    MaximumHardwareLineWidth = 1;
  }
};

vtkStandardNewMacro(Window);

// While it lives, VTK's messages are kept.
class Quiet {
 public:
  Quiet() : before_(vtkOutputWindow::GetInstance()) { vtkOutputWindow::SetInstance(messages_); }
  ~Quiet() { vtkOutputWindow::SetInstance(before_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

  std::string errors() { return messages_->take(); }

 private:
  vtkSmartPointer<vtkOutputWindow> before_;
  vtkNew<Messages> messages_;
};

}  // namespace

struct ScanmillVtkRenderer {
  explicit ScanmillVtkRenderer(const std::string& device) : context(device) {}

  std::shared_ptr<GlThread> thread;
  EglContext context;
  vtkNew<Window> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<ImagePass> pass;
  std::unique_ptr<TriangleStore> triangles;
  std::unique_ptr<GlPixelReader> reader;

  void start() {
    window->SetReadyForRendering(true);
    window->SetIsCurrent(true);
    window->SetOwnContext(0);
    window->SetOffScreenRendering(1);
    window->SetMultiSamples(0);
    window->SetMapped(false);
    if (!window->InitializeFromCurrentContext()) throw NoDevice("VTK does not find OpenGL 4.3");
    window->SetSize(8, 8);  // nothing is drawn to it
    window->AddRenderer(renderer);
    reader = std::make_unique<GlPixelReader>();
  }

  ~ScanmillVtkRenderer() {
    triangles.reset();
    reader.reset();
    pass->ReleaseGraphicsResources(window);
    window->Finalize();
  }
};

namespace {

// The same with the renderer's context.
template <class Work>
ScanmillVtkStatus withContext(ScanmillVtkRenderer& renderer, ScanmillVtkText& error, const Work& work) noexcept {
  return guarded(*renderer.thread, error, [&] {
    Quiet quiet;
    renderer.context.makeCurrent();
    try {
      work();
    } catch (...) {
      renderer.context.release();
      throw;
    }
    renderer.context.release();
    const std::string errors = quiet.errors();
    if (!errors.empty()) throw std::runtime_error(errors);
  });
}

std::string describe() {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return fmt::format("VTK {}.{} on {}", vtkVersion::GetVTKMajorVersion(), vtkVersion::GetVTKMinorVersion(),
                     name != nullptr ? name : "an unknown device");
}

ScanmillVtkStatus open(const char* device, ScanmillVtkRenderer** renderer, ScanmillVtkLimits* limits,
                       ScanmillVtkText* described, ScanmillVtkText* error) {
  std::shared_ptr<GlThread> thread;
  try {
    thread = GlThread::shared();
  } catch (const std::exception& e) {  // no thread to be had
    put(*error, e.what());
    return kScanmillVtkFailed;
  }
  return guarded(*thread, *error, [&] {
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);  // Messages has them
    Quiet quiet;
    auto opened = std::make_unique<ScanmillVtkRenderer>(device != nullptr ? device : "");
    opened->thread = thread;
    opened->start();
    GLint size = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &size);
    *limits = {static_cast<std::uint32_t>(size), 0x7FFFFFFFu / 3};  // a vertex's index is signed
    put(*described, describe());
    opened->context.release();
    *renderer = opened.release();
  });
}

void close(ScanmillVtkRenderer* renderer) {
  const std::shared_ptr<GlThread> thread = renderer->thread;  // outlives the renderer: it cannot end itself
  ScanmillVtkText ignored;
  guarded(*thread, ignored, [&] {
    Quiet quiet;
    const std::unique_ptr<ScanmillVtkRenderer> closed(renderer);
    closed->context.makeCurrent();
  });
}

ScanmillVtkStatus upload(ScanmillVtkRenderer* renderer, const ScanmillVtkScene* scene, ScanmillVtkText* error) {
  return withContext(*renderer, *error, [&] { renderer->triangles = std::make_unique<TriangleStore>(*scene); });
}

ScanmillVtkStatus draw(ScanmillVtkRenderer* renderer, std::uint32_t slot, const ScanmillVtkImage* image,
                       ScanmillVtkText* error) {
  return withContext(*renderer, *error, [&] {
    renderer->pass->next(renderer->triangles.get(), image, slot);
    // Not by way of the window, which would copy the result to a default framebuffer that there is not.
    const vtkRenderState state(renderer->renderer);
    renderer->pass->Render(&state);
  });
}

ScanmillVtkStatus finish(ScanmillVtkRenderer* renderer, ScanmillVtkText* error) {
  return withContext(*renderer, *error, [] { glFinish(); });
}

ScanmillVtkStatus gather(ScanmillVtkRenderer* renderer, const ScanmillVtkPixels* pixels, const std::uint32_t* addresses,
                         std::uint64_t count, std::uint32_t* numbers, ScanmillVtkText* error) {
  return withContext(*renderer, *error, [&] {
    std::array<vtkTextureObject*, kVtkImages> images{};
    for (std::uint32_t slot = 0; slot < kVtkImages; ++slot) images[slot] = renderer->pass->numbers(slot);
    renderer->reader->gather(images, *pixels, {addresses, count}, numbers);
  });
}

ScanmillVtkStatus read(ScanmillVtkRenderer* renderer, std::uint32_t slot, std::uint32_t firstRow, std::uint32_t rows,
                       std::uint32_t* numbers, ScanmillVtkText* error) {
  return withContext(*renderer, *error,
                     [&] { renderer->reader->read(renderer->pass->numbers(slot), firstRow, rows, numbers); });
}

constexpr ScanmillVtkModule kModule{
    kVtkModuleVersion, &kComputeFunctions, open, close, upload, draw, finish, gather, read};

}  // namespace

extern "C" __attribute__((visibility("default"))) const ScanmillVtkModule* scanmillVtkModule() {
  return &kModule;
}
