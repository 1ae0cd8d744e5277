// libscanmill_viewer.so: VTK on an X window, or on EGL without one, behind the functions of
// viewer/canvas/canvas_module.h. It is not part of the program, which loads it when it opens the first canvas.

#include <vtkAutoInit.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "passes/vtk_module/egl_context.h"
#include "passes/vtk_module/gl_window.h"
#include "viewer/canvas/canvas_module.h"
#include "viewer/vtk_module/canvas_scene.h"
#include "viewer/vtk_module/x_window.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)

using namespace scanmill;

struct ScanmillCanvas {
  std::unique_ptr<XWindow> window;      // of a window
  std::unique_ptr<EglContext> context;  // of an image
  std::unique_ptr<CanvasScene> scene;   // last: it ends before its context

  void makeCurrent() {
    if (window != nullptr) {
      window->makeCurrent();
    } else {
      context->makeCurrent();
    }
  }
};

namespace {

void put(ScanmillCanvasText& to, std::string_view text) {
  const std::size_t size = std::min(text.size(), sizeof to.text - 1);
  std::copy_n(text.data(), size, to.text);
  to.text[size] = '\0';
}

// Lets no exception out.
template <class Work>
ScanmillCanvasStatus guardedCall(ScanmillCanvasText& error, const Work& work) noexcept {
  try {
    work();
    put(error, "");
    return kScanmillCanvasDone;
  } catch (const std::bad_alloc&) {
    put(error, "out of memory");
    return kScanmillCanvasOutOfMemory;
  } catch (const NoScreen& e) {
    put(error, e.what());
    return kScanmillCanvasNoDisplay;
  } catch (const NoDevice& e) {
    put(error, e.what());
    return kScanmillCanvasNoDevice;
  } catch (const std::exception& e) {
    put(error, e.what());
  } catch (...) {
    put(error, "for no reason given");
  }
  return kScanmillCanvasFailed;
}

// The same with VTK quiet and the canvas's context current.
template <class Work>
ScanmillCanvasStatus withCanvas(ScanmillCanvas& canvas, ScanmillCanvasText& error, const Work& work) noexcept {
  return guardedCall(error, [&] {
    Quiet quiet;
    canvas.makeCurrent();
    work(*canvas.scene);
    if (const std::string errors = quiet.errors(); !errors.empty()) throw std::runtime_error(errors);
    if (canvas.window != nullptr) canvas.window->check();
  });
}

void close(ScanmillCanvas* canvas) {
  ScanmillCanvasText ignored;
  guardedCall(ignored, [&] {
    Quiet quiet;
    const std::unique_ptr<ScanmillCanvas> closed(canvas);
    closed->makeCurrent();
    closed->scene.reset();
  });
}

ScanmillCanvasStatus open(const ScanmillCanvasOptions* options, ScanmillCanvas** canvas, ScanmillCanvasText* described,
                          ScanmillCanvasText* error) {
  return guardedCall(*error, [&] {
    Quiet quiet;
    auto opened = std::make_unique<ScanmillCanvas>();
    if (options->window != 0) {
      opened->window =
          std::make_unique<XWindow>(options->title != nullptr ? options->title : "", options->width, options->height);
    } else {
      opened->context = std::make_unique<EglContext>(options->device != nullptr ? options->device : "");
    }
    opened->scene = std::make_unique<CanvasScene>(options->width, options->height);
    put(*described, describeGl());
    if (const std::string errors = quiet.errors(); !errors.empty()) throw std::runtime_error(errors);
    *canvas = opened.release();
  });
}

ScanmillCanvasStatus resize(ScanmillCanvas* canvas, std::uint32_t width, std::uint32_t height,
                            ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error, [&](CanvasScene& scene) {
    scene.resize(width, height);
    if (canvas->window != nullptr) canvas->window->resize(width, height);
  });
}

ScanmillCanvasStatus views(ScanmillCanvas* canvas, const ScanmillCanvasView* list, std::uint32_t count,
                           ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error, [&](CanvasScene& scene) { scene.setViews({list, count}); });
}

ScanmillCanvasStatus points(ScanmillCanvas* canvas, std::uint32_t item, const ScanmillCanvasPoints* p,
                            ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error,
                    [&](CanvasScene& scene) { scene.set(item, ItemKind::Points, p->count, p->positions, p->colors); });
}

ScanmillCanvasStatus triangles(ScanmillCanvas* canvas, std::uint32_t item, const ScanmillCanvasTriangles* t,
                               ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error,
                    [&](CanvasScene& scene) { scene.set(item, ItemKind::Triangles, t->count, t->corners, t->colors); });
}

ScanmillCanvasStatus lines(ScanmillCanvas* canvas, std::uint32_t item, const ScanmillCanvasLines* l,
                           ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error,
                    [&](CanvasScene& scene) { scene.set(item, ItemKind::Segments, l->count, l->ends, l->colors); });
}

ScanmillCanvasStatus colors(ScanmillCanvas* canvas, std::uint32_t item, const std::uint8_t* rgb,
                            ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error, [&](CanvasScene& scene) { scene.setColors(item, rgb); });
}

ScanmillCanvasStatus shown(ScanmillCanvas* canvas, std::uint32_t item, const std::uint32_t* indices,
                           std::uint64_t count, ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error, [&](CanvasScene& scene) { scene.show(item, indices, count); });
}

ScanmillCanvasStatus look(ScanmillCanvas* canvas, std::uint32_t item, const ScanmillCanvasLook* wanted,
                          ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error, [&](CanvasScene& scene) { scene.setLook(item, *wanted); });
}

void drop(ScanmillCanvas* canvas, std::uint32_t item) {
  ScanmillCanvasText ignored;
  withCanvas(*canvas, ignored, [&](CanvasScene& scene) { scene.drop(item); });
}

ScanmillCanvasStatus overlay(ScanmillCanvas* canvas, std::uint32_t width, std::uint32_t height,
                             const std::uint8_t* rgba, ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error, [&](CanvasScene& scene) { scene.setOverlay(width, height, rgba); });
}

ScanmillCanvasStatus render(ScanmillCanvas* canvas, std::uint64_t mostPoints, ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error, [&](CanvasScene& scene) {
    scene.draw(mostPoints);
    if (canvas->window == nullptr) return;
    scene.showPicture();
    canvas->window->present();
  });
}

ScanmillCanvasStatus read(ScanmillCanvas* canvas, std::uint8_t* rgb, ScanmillCanvasText* error) {
  return withCanvas(*canvas, *error, [&](CanvasScene& scene) { scene.read(rgb); });
}

// VTK is quiet in the calls of the handler only: they see to it themselves.
ScanmillCanvasStatus run(ScanmillCanvas* canvas, std::uint32_t tickMilliseconds, ScanmillCanvasHandler handler,
                         void* self, ScanmillCanvasText* error) {
  return guardedCall(*error, [&] {
    if (canvas->window == nullptr) throw std::invalid_argument("a canvas without a window has no events");
    canvas->window->run(tickMilliseconds, [&](const ScanmillCanvasEvent& event) {
      if (event.kind == kScanmillCanvasResize) {
        canvas->makeCurrent();
        canvas->scene->resize(event.width, event.height);
      }
      return handler(self, &event) != 0;
    });
  });
}

constexpr ScanmillCanvasModule kModule{kCanvasModuleVersion,
                                       open,
                                       close,
                                       resize,
                                       views,
                                       points,
                                       triangles,
                                       lines,
                                       colors,
                                       shown,
                                       look,
                                       drop,
                                       overlay,
                                       render,
                                       read,
                                       run};

}  // namespace

extern "C" __attribute__((visibility("default"))) const ScanmillCanvasModule* scanmillCanvasModule() {
  return &kModule;
}
