// libscanmill_passes.so: VTK on an OpenGL context of our own, behind the functions of passes/vtk/vtk_module.h. It is
// not part of the program, which loads it when it draws the first image or computes by OpenGL (gl_compute.h).

#include <vtkAutoInit.h>
#include <vtkNew.h>
#include <vtkRenderState.h>
#include <vtkRenderer.h>
#include <vtk_glew.h>

#include <array>
#include <memory>
#include <string>

#include "passes/vtk/vtk_module.h"
#include "passes/vtk_module/egl_context.h"
#include "passes/vtk_module/gl_compute.h"
#include "passes/vtk_module/gl_thread.h"
#include "passes/vtk_module/gl_window.h"
#include "passes/vtk_module/guarded.h"
#include "passes/vtk_module/image_pass.h"
#include "passes/vtk_module/pixel_reader.h"
#include "passes/vtk_module/triangle_store.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)

using namespace scanmill;

struct ScanmillVtkRenderer {
  explicit ScanmillVtkRenderer(const std::string& device) : context(device) {}

  std::shared_ptr<GlThread> thread;
  EglContext context;
  vtkNew<GlWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<ImagePass> pass;
  std::unique_ptr<TriangleStore> triangles;
  std::unique_ptr<GlPixelReader> reader;

  void start() {
    window->start(8, 8);  // nothing is drawn to it
    if (!GLEW_VERSION_4_3) throw NoDevice("VTK does not find OpenGL 4.3");
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
    Quiet quiet;
    auto opened = std::make_unique<ScanmillVtkRenderer>(device != nullptr ? device : "");
    opened->thread = thread;
    opened->start();
    GLint size = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &size);
    *limits = {static_cast<std::uint32_t>(size), 0x7FFFFFFFu / 3};  // a vertex's index is signed
    put(*described, describeGl());
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
