#pragma once

// A viewer without a window, whose keys and pointer a test moves.

#include <memory>
#include <sstream>

#include "tests/studio/viewer/window/fake_canvas.h"
#include "tests/studio/viewer/window/fake_frames.h"
#include "viewer/window/session.h"

namespace scanmill {

struct SessionWorld {
  static constexpr int kWidth = 960;
  static constexpr int kHeight = 640;

  explicit SessionWorld(std::shared_ptr<FakeFrames> shown, const ViewOptions& options = {})
      : frames(std::move(shown)),
        canvas(kWidth, kHeight),
        session(std::make_unique<ViewSession>(frames, canvas, options)) {
    session->drawWhenLoaded();
  }
  explicit SessionWorld(std::size_t count, std::vector<std::string> methods = {"ray_tracing"},
                        const ViewOptions& options = {})
      : SessionWorld(std::make_shared<FakeFrames>(count, std::move(methods)), options) {}

  bool send(CanvasEvent event) { return session->handle(event); }
  bool key(const std::string& name) {
    return send({.kind = CanvasEvent::Kind::Key, .key = name, .text = name.size() == 1 ? name : ""});
  }
  // A key, and all that it has loaded in the background.
  void press(const std::string& name) {
    key(name);
    session->drawWhenLoaded();
  }
  void type(const std::string& text) {
    for (const char c : text) key(std::string(1, c));
  }
  bool pointer(CanvasEvent::Kind kind, int x, int y, int button = 1, bool shift = false, int clicks = 1) {
    const CanvasEvent event{.kind = kind,
                            .x = x,
                            .y = y,
                            .button = kind == CanvasEvent::Kind::Move ? 0 : button,
                            .clicks = clicks,
                            .shift = shift};
    return send(event);
  }
  void click(int x, int y, bool shift = false) {
    pointer(CanvasEvent::Kind::Move, x, y);
    pointer(CanvasEvent::Kind::Down, x, y, 1, shift);
    pointer(CanvasEvent::Kind::Up, x, y, 1, shift);
  }
  void drag(int x, int y, int right, int down, int button = 1, bool shift = false) {
    pointer(CanvasEvent::Kind::Down, x, y, button, shift);
    pointer(CanvasEvent::Kind::Move, x + right / 2, y + down / 2);
    pointer(CanvasEvent::Kind::Move, x + right, y + down);
    pointer(CanvasEvent::Kind::Up, x + right, y + down, button, shift);
  }
  void wheel(double amount) {
    const CanvasEvent event{
        .kind = CanvasEvent::Kind::Wheel, .x = canvas.width() / 2, .y = canvas.height() / 2, .amount = amount};
    send(event);
  }
  bool tick() { return send({}); }

  // Where a point of the first view is drawn, px of the canvas.
  std::pair<int, int> pixelOf(std::size_t item, std::size_t point) const {
    const auto& shown = canvas.items.at(static_cast<ItemId>(item));
    const CanvasView& view = canvas.views().front();
    const Projected p = view.camera.project(shown.look.canvasFromItem * Vec3d(shown.places[point]));
    return {view.rect.left + static_cast<int>(std::floor(p.x)), view.rect.top + static_cast<int>(std::floor(p.y))};
  }

  std::optional<std::pair<int, int>> inOverlay(const Rgb& color) const { return canvas.inOverlay(color); }

  // All that is drawn.
  std::string drawn() const {
    std::ostringstream out;
    out.precision(17);
    const auto put = [&](const Vec3d& v) { out << v.x << ' ' << v.y << ' ' << v.z << ' '; };
    for (const CanvasView& v : canvas.views()) {
      put(v.camera.eye);
      put(v.camera.forward);
      put(v.camera.down);
      out << v.camera.focal << v.camera.orthographic << v.depthEdges << v.rect.left << v.rect.top << ' ' << v.rect.width
          << ' ' << v.rect.height << int{v.background[0]} << '\n';
    }
    for (const auto& [id, item] : canvas.items) {
      out << id << ' ' << item.look.size << ' ' << item.look.views << ' ' << item.look.opacity << ' ';
      put(item.look.canvasFromItem.translation);
      if (item.shown) out << "shown " << item.shown->size();
      for (const Vec3f& p : item.places) put(Vec3d(p));
      for (const Rgb& c : item.colors) out << int{c[0]} << int{c[1]} << int{c[2]};
      out << '\n';
    }
    out << std::string(reinterpret_cast<const char*>(canvas.overlay().data()), canvas.overlay().size() * sizeof(Rgba));
    return out.str();
  }

  std::shared_ptr<FakeFrames> frames;
  FakeCanvas canvas;
  std::unique_ptr<ViewSession> session;
};

// The first scan's item.
inline ItemId firstCloud(const SessionWorld& world) {
  return world.canvas.pointItems().front();
}

// Returns the value of a picked element's row; empty if it has no row of this name.
inline std::string rowOf(const PickedElement& picked, const std::string& name) {
  for (const auto& [key, value] : picked.rows) {
    if (key == name) return value;
  }
  return "";
}

}  // namespace scanmill
