#include "viewer/canvas/canvas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <iterator>
#include <map>
#include <new>

#include "viewer/canvas/canvas_loader.h"
#include "viewer/canvas/canvas_module.h"

namespace scanmill {

namespace {

static_assert(sizeof(Vec3f) == 3 * sizeof(float) && sizeof(Rgb) == 3 && sizeof(Rgba) == 4);

void require(ScanmillCanvasStatus status, const ScanmillCanvasText& error) {
  switch (status) {
    case kScanmillCanvasDone:
      return;
    case kScanmillCanvasOutOfMemory:
      throw std::bad_alloc();
    case kScanmillCanvasNoDisplay:
      throw NoDisplay(error.text);
    case kScanmillCanvasNoDevice:
      throw Error(
          fmt::format("nothing can be shown, there is no OpenGL that will do ({}): install Mesa (on Debian the "
                      "packages libegl-mesa0 and libgl1-mesa-dri) or a graphics card's driver",
                      error.text));
    case kScanmillCanvasFailed:
      break;
  }
  throw Error(fmt::format("the viewer's canvas: {}", error.text));
}

ScanmillCanvasView viewOf(const CanvasView& view) {
  const ViewCamera& camera = view.camera;
  const auto pixels = [](int value) { return static_cast<std::uint32_t>(value); };
  const Vec3d& eye = camera.eye;
  const Vec3d& forward = camera.forward;
  const Vec3d up = -camera.down;
  return {pixels(view.rect.left),
          pixels(view.rect.top),
          pixels(view.rect.width),
          pixels(view.rect.height),
          {view.background[0], view.background[1], view.background[2], 0},
          {eye.x, eye.y, eye.z},
          {forward.x, forward.y, forward.z},
          {up.x, up.y, up.z},
          camera.focal,
          camera.nearest,
          view.farthest,
          camera.orthographic ? 1u : 0u,
          view.depthEdges ? 1u : 0u};
}

ScanmillCanvasLook lookOf(const ItemLook& look) {
  const Mat3& m = look.canvasFromItem.linear;
  const Vec3d& t = look.canvasFromItem.translation;
  return {{m.x.x, m.y.x, m.z.x, t.x, m.x.y, m.y.y, m.z.y, t.y, m.x.z, m.y.z, m.z.z, t.z, 0, 0, 0, 1},
          static_cast<float>(look.size),
          static_cast<float>(std::clamp(look.opacity, 0.0, 1.0)),
          look.views,
          look.lit ? 1u : 0u};
}

CanvasEvent eventOf(const ScanmillCanvasEvent& event) {
  CanvasEvent out;
  switch (event.kind) {
    case kScanmillCanvasKey:
      out.kind = CanvasEvent::Kind::Key;
      break;
    case kScanmillCanvasMove:
      out.kind = CanvasEvent::Kind::Move;
      break;
    case kScanmillCanvasDown:
      out.kind = CanvasEvent::Kind::Down;
      break;
    case kScanmillCanvasUp:
      out.kind = CanvasEvent::Kind::Up;
      break;
    case kScanmillCanvasWheel:
      out.kind = CanvasEvent::Kind::Wheel;
      break;
    case kScanmillCanvasResize:
      out.kind = CanvasEvent::Kind::Resize;
      break;
    case kScanmillCanvasExpose:
      out.kind = CanvasEvent::Kind::Expose;
      break;
    case kScanmillCanvasTick:
      out.kind = CanvasEvent::Kind::Tick;
      break;
    case kScanmillCanvasClose:
      out.kind = CanvasEvent::Kind::Close;
      break;
  }
  out.key = event.key;
  out.text = event.text;
  out.x = event.x;
  out.y = event.y;
  out.button = static_cast<int>(event.button);
  out.clicks = std::max(static_cast<int>(event.clicks), 1);
  out.shift = event.shift != 0;
  out.control = event.control != 0;
  out.amount = event.amount;
  out.width = static_cast<int>(event.width);
  out.height = static_cast<int>(event.height);
  return out;
}

// A canvas of the module, with the sizes of its items: the module trusts the pointers that it gets.
class VtkCanvas : public Canvas {
 public:
  VtkCanvas(const ScanmillCanvasModule& module, const ScanmillCanvasOptions& options)
      : module_(module), width_(static_cast<int>(options.width)), height_(static_cast<int>(options.height)) {
    ScanmillCanvasText described{};
    ScanmillCanvasText error{};
    require(module_.open(&options, &canvas_, &described, &error), error);
    device_ = described.text;
  }
  ~VtkCanvas() override { module_.close(canvas_); }
  VtkCanvas(const VtkCanvas&) = delete;
  VtkCanvas& operator=(const VtkCanvas&) = delete;

  std::string device() const override { return device_; }
  int width() const override { return width_; }
  int height() const override { return height_; }

  void resize(int width, int height) override {
    call(module_.resize, static_cast<std::uint32_t>(std::max(width, 0)),
         static_cast<std::uint32_t>(std::max(height, 0)));
    width_ = width;
    height_ = height;
  }

  void setViews(std::span<const CanvasView> views) override {
    std::vector<ScanmillCanvasView> list;
    std::ranges::transform(views, std::back_inserter(list), viewOf);
    call(module_.views, list.data(), static_cast<std::uint32_t>(list.size()));
  }

  void setPoints(ItemId item, std::span<const Vec3f> positions, std::span<const Rgb> colors) override {
    const ScanmillCanvasPoints points{elements(positions, colors, 1), floats(positions), bytes(colors)};
    call(module_.points, item, &points);
    elements_[item] = points.count;
  }

  void setTriangles(ItemId item, std::span<const Vec3f> corners, std::span<const Rgb> colors) override {
    const ScanmillCanvasTriangles triangles{elements(corners, colors, 3), floats(corners), bytes(colors)};
    call(module_.triangles, item, &triangles);
    elements_[item] = triangles.count;
  }

  void setLines(ItemId item, std::span<const Vec3f> ends, std::span<const Rgb> colors) override {
    const ScanmillCanvasLines lines{elements(ends, colors, 2), floats(ends), bytes(colors)};
    call(module_.lines, item, &lines);
    elements_[item] = lines.count;
  }

  void setColors(ItemId item, std::span<const Rgb> colors) override {
    if (colors.size() != count(item)) {
      throw Error(
          fmt::format("the viewer's canvas: item {} has {} elements, not {}", item, count(item), colors.size()));
    }
    call(module_.colors, item, bytes(colors));
  }

  void showAll(ItemId item) override { call(module_.shown, item, nullptr, std::uint64_t{0}); }

  void showOnly(ItemId item, std::span<const std::uint32_t> indices) override {
    const bool ascending = std::ranges::adjacent_find(indices, std::greater_equal<>()) == indices.end();
    if (!ascending || (!indices.empty() && indices.back() >= count(item))) {
      throw Error(fmt::format("the viewer's canvas: indices of item {} do not ascend below {}", item, count(item)));
    }
    constexpr std::uint32_t kNone = 0;  // an address, for null stands for all
    call(module_.shown, item, indices.empty() ? &kNone : indices.data(), std::uint64_t{indices.size()});
  }

  void setLook(ItemId item, const ItemLook& look) override {
    const ScanmillCanvasLook wanted = lookOf(look);
    call(module_.look, item, &wanted);
  }

  void drop(ItemId item) override {
    module_.drop(canvas_, item);
    elements_.erase(item);
  }

  void setOverlay(int width, int height, std::span<const Rgba> pixels) override {
    const bool some = width > 0 && height > 0;
    if (some && pixels.size() != std::size_t(width) * std::size_t(height)) {
      throw Error(
          fmt::format("the viewer's canvas: {} pixels are no {} x {} of an overlay", pixels.size(), width, height));
    }
    call(module_.overlay, static_cast<std::uint32_t>(some ? width : 0), static_cast<std::uint32_t>(some ? height : 0),
         some ? pixels.data()->data() : nullptr);
  }

  void render(std::uint64_t mostPoints) override { call(module_.render, mostPoints); }

  Image read() override {
    Image image(width_, height_, Rgb{});
    call(module_.read, image.pixels.data()->data());
    return image;
  }

  void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handle) override {
    Running running{this, handle, {}};
    ScanmillCanvasText error{};
    const auto milliseconds = static_cast<std::uint32_t>(std::max(tickMilliseconds, 0));
    const ScanmillCanvasStatus status = module_.run(canvas_, milliseconds, &VtkCanvas::take, &running, &error);
    if (running.failure) std::rethrow_exception(running.failure);
    require(status, error);
  }

 private:
  struct Running {
    VtkCanvas* canvas;
    const std::function<bool(const CanvasEvent&)>& handle;
    std::exception_ptr failure;
  };

  // Called by the module, which must not see an exception.
  static std::int32_t take(void* self, const ScanmillCanvasEvent* event) noexcept {
    Running& running = *static_cast<Running*>(self);
    try {
      if (event->kind == kScanmillCanvasResize) {
        running.canvas->width_ = static_cast<int>(event->width);
        running.canvas->height_ = static_cast<int>(event->height);
      }
      return running.handle(eventOf(*event)) ? 1 : 0;
    } catch (...) {
      running.failure = std::current_exception();
      return 0;
    }
  }

  template <class Function, class... Arguments>
  void call(Function function, Arguments... arguments) {
    ScanmillCanvasText error{};
    require(function(canvas_, arguments..., &error), error);
  }

  static std::uint64_t elements(std::span<const Vec3f> corners, std::span<const Rgb> colors, std::size_t each) {
    if (corners.size() != colors.size() * each) {
      throw Error(fmt::format("the viewer's canvas: {} colors for {} corners", colors.size(), corners.size()));
    }
    return colors.size();
  }

  static const float* floats(std::span<const Vec3f> corners) { return reinterpret_cast<const float*>(corners.data()); }
  static const std::uint8_t* bytes(std::span<const Rgb> colors) {
    return reinterpret_cast<const std::uint8_t*>(colors.data());
  }

  std::uint64_t count(ItemId item) const {
    const auto found = elements_.find(item);
    return found != elements_.end() ? found->second : 0;
  }

  const ScanmillCanvasModule& module_;
  ScanmillCanvas* canvas_ = nullptr;
  std::string device_;
  int width_;
  int height_;
  std::map<ItemId, std::uint64_t> elements_;
};

std::uint32_t sideOf(int pixels) {
  return static_cast<std::uint32_t>(std::max(pixels, 0));
}

}  // namespace

std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height) {
  return std::make_unique<VtkCanvas>(canvasModule(),
                                     ScanmillCanvasOptions{title.c_str(), sideOf(width), sideOf(height), 1, nullptr});
}

std::unique_ptr<Canvas> openOffscreen(int width, int height) {
  const char* device = std::getenv("SCANMILL_GL_DEVICE");
  return std::make_unique<VtkCanvas>(canvasModule(),
                                     ScanmillCanvasOptions{"", sideOf(width), sideOf(height), 0, device});
}

}  // namespace scanmill
