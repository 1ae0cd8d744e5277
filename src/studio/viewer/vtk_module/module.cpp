// The plug-in libscanmill_viewer.so: canvases in a GLFW window or, without a window, with EGL (viewer/canvas/canvas.h).

#include <vtkAutoInit.h>

#include <new>
#include <utility>

#include "gpu/device.h"
#include "gpu/opengl_module/egl_context.h"
#include "gpu/opengl_module/gl_window.h"
#include "viewer/vtk_module/canvas_scene.h"
#include "viewer/vtk_module/glfw_window.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)

namespace scanmill {

namespace {

// Calls `work`, and converts its exceptions to those that Canvas documents.
decltype(auto) withCanvasErrors(const auto& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const NoDevice& e) {
    throw Error("nothing can be shown, there is no OpenGL that will do ({}): {}", e.what(), kInstallOpenGl);
  } catch (const Error&) {  // there is no display
    throw;
  } catch (const std::exception& e) {
    throw Error("the viewer's canvas: {}", e.what());
  }
}

class VtkCanvas final : public Canvas {
 public:
  VtkCanvas(std::unique_ptr<GlfwWindow> window, std::unique_ptr<EglContext> context, int width, int height)
      : window_(std::move(window)),
        context_(std::move(context)),
        scene_(std::make_unique<CanvasScene>(width, height)) {}

  ~VtkCanvas() override {
    Quiet quiet;
    if (window_ != nullptr) {
      window_->makeCurrent();
    } else {
      context_->tryMakeCurrent();
    }
    scene_.reset();
  }
  VtkCanvas& operator=(VtkCanvas&&) = delete;  // neither copied nor moved

  int width() const override { return scene_->width(); }
  int height() const override { return scene_->height(); }
  double scale() const override { return window_ != nullptr ? window_->scale() : 1; }

  void setViews(std::span<const CanvasView> views) override { change(&CanvasScene::setViews, views); }
  void set(ItemId item, ItemKind kind, std::span<const Vec3f> corners, std::span<const Rgb> colors) override {
    change(&CanvasScene::set, item, kind, corners, colors);
  }
  void setColors(ItemId item, std::span<const Rgb> colors) override { change(&CanvasScene::setColors, item, colors); }
  void show(ItemId item, std::optional<std::vector<std::uint32_t>> indices) override {
    change(&CanvasScene::show, item, std::move(indices));
  }
  void setLook(ItemId item, const ItemLook& look) override { change(&CanvasScene::setLook, item, look); }
  void drop(ItemId item) override { change(&CanvasScene::drop, item); }
  void setImage(ImageId image, int width, int height, std::span<const Rgba> pixels) override {
    change(&CanvasScene::setImage, image, width, height, pixels);
  }
  void setOverlay(Overlay overlay) override { change(&CanvasScene::setOverlay, std::move(overlay)); }

  void render(std::uint64_t maxPoints) override {
    change([&](CanvasScene& scene) {
      scene.draw(maxPoints);
      if (window_ == nullptr) return;
      scene.showPicture();
      window_->present();
    });
  }

  Image read() override {
    Image image(width(), height(), Rgb{});
    change(&CanvasScene::read, image.pixels);
    return image;
  }

  // VTK's messages are not collected here, but in the functions of the canvas that `handle` calls.
  void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handle) override {
    std::exception_ptr thrown;  // the exception that `handle` has thrown; it is rethrown unchanged
    // Resizes the canvas if necessary, then calls `handle`. Returns false if the window is to be closed.
    const auto resizeAndHandle = [&](const CanvasEvent& event) {
      if (event.kind == CanvasEvent::Kind::Resize) {
        makeCurrent();
        scene_->resize(event.width, event.height);
      }
      try {
        return handle(event);
      } catch (...) {
        thrown = std::current_exception();
        return false;
      }
    };
    try {
      withCanvasErrors([&] {
        if (window_ == nullptr) throw std::invalid_argument("a canvas without a window has no events");
        window_->run(tickMilliseconds, resizeAndHandle);
      });
    } catch (const Error&) {
      if (!thrown) throw;
    }
    if (thrown) std::rethrow_exception(thrown);
  }

 private:
  void makeCurrent() {
    if (window_ != nullptr) {
      window_->makeCurrent();
    } else {
      context_->makeCurrent();
    }
  }

  // Calls `work`, a function that changes or reads the scene, with the context current and VTK's messages collected.
  template <class Work, class... Arguments>
  void change(const Work& work, Arguments&&... arguments) {
    withCanvasErrors([&] {
      Quiet quiet;
      makeCurrent();
      std::invoke(work, *scene_, std::forward<Arguments>(arguments)...);
      quiet.check();
      if (window_ != nullptr) window_->check();
    });
  }

  std::unique_ptr<GlfwWindow> window_;   // null if there is no window
  std::unique_ptr<EglContext> context_;  // null if there is a window
  std::unique_ptr<CanvasScene> scene_;
};

class VtkCanvasModule final : public CanvasModule {
 public:
  std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height) const override {
    return open([&] {
      return std::make_unique<VtkCanvas>(std::make_unique<GlfwWindow>(title, width, height), nullptr, width, height);
    });
  }

  std::unique_ptr<Canvas> openOffscreen(const std::string& device, int width, int height) const override {
    return open(
        [&] { return std::make_unique<VtkCanvas>(nullptr, std::make_unique<EglContext>(device), width, height); });
  }

 private:
  static std::unique_ptr<Canvas> open(const auto& make) {
    return withCanvasErrors([&] {
      Quiet quiet;
      std::unique_ptr<Canvas> canvas = make();
      quiet.check();
      return canvas;
    });
  }
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(CanvasModule, VtkCanvasModule)
