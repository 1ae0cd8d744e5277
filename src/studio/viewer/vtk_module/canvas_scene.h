#pragma once

// The items, views and overlay of a canvas, and the picture drawn of them.

#include <vtkNew.h>
#include <vtkRenderer.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gpu/opengl_module/gl_window.h"
#include "viewer/canvas/canvas.h"
#include "viewer/vtk_module/depth_edges.h"
#include "viewer/vtk_module/item.h"
#include "viewer/vtk_module/overlay_painter.h"
#include "viewer/vtk_module/view_renderer.h"

namespace scanmill {

// A scene belongs to one OpenGL context, which must be current in every call. The views that VTK has drawn are kept: as
// long as only the overlay changes, only the overlay is drawn again. Wrong use throws std::invalid_argument.
class CanvasScene {
 public:
  CanvasScene(int width, int height);
  ~CanvasScene();
  CanvasScene(const CanvasScene&) = delete;
  CanvasScene& operator=(const CanvasScene&) = delete;

  int width() const { return width_; }
  int height() const { return height_; }
  // See Canvas.
  void resize(int width, int height);
  void setViews(std::span<const CanvasView> views);
  void set(ItemId item, ItemKind kind, std::span<const Vec3f> corners, std::span<const Rgb> colors);
  void setColors(ItemId item, std::span<const Rgb> colors);
  // Draws only these elements (ascending); nullopt: all.
  void show(ItemId item, std::optional<std::vector<std::uint32_t>> indices);
  void setLook(ItemId item, const ItemLook& look);
  void drop(ItemId item);
  void setImage(ImageId image, int width, int height, std::span<const Rgba> pixels);
  void setOverlay(Overlay overlay);

  void draw(std::uint64_t mostPoints);
  // Reads width * height pixels, the upper row first.
  void read(std::span<Rgb> pixels);
  // Copies the picture to the context's own framebuffer.
  void showPicture();

 private:
  Item& item(ItemId number);
  void place(Item& item);
  void remove(Item& item);
  void placeViews();

  int width_;
  int height_;
  vtkNew<GlWindow> window_;
  vtkNew<vtkRenderer> uncovered_;  // black background under all views
  std::array<vtkNew<ViewRenderer>, kCanvasViews> renderers_;
  std::vector<CanvasView> views_;
  std::map<ItemId, std::unique_ptr<Item>> items_;
  DepthEdges edges_;
  OverlayPainter overlay_;
  bool drawn_ = false;  // the window's framebuffer holds the views in their current state
  std::uint64_t drawnPoints_ = 0;
  bool pictured_ = false;  // a picture of the canvas's size exists
};

}  // namespace scanmill
