#pragma once

// Draws the items, views and overlay of a canvas.

#include <vtkNew.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextureObject.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gpu/opengl_module/gl_window.h"
#include "viewer/canvas/canvas.h"
#include "viewer/vtk_module/item.h"
#include "viewer/vtk_module/view_renderer.h"

namespace scanmill {

// Draws the overlay on top of the views.
class OverlayPainter {
 public:
  void setImage(vtkOpenGLRenderWindow* window, ImageId image, int width, int height, std::span<const Rgba> pixels);
  // Throws std::invalid_argument if an index in the overlay is out of range, or if one of its images does not exist.
  void set(Overlay overlay);
  // Draws to the framebuffer that is bound, which has this size (pixels).
  void draw(vtkOpenGLRenderWindow* window, int width, int height);
  void release(vtkWindow* window);

 private:
  std::map<ImageId, vtkNew<vtkTextureObject>> images_;
  Overlay overlay_;
  bool uploaded_ = false;  // true: the buffers contain the current overlay
  unsigned vertexArray_ = 0;
  unsigned vertices_ = 0;
  unsigned corners_ = 0;
};

// Holds the items, views and overlay of a canvas. Belongs to one OpenGL context, which must be current in all calls.
// The views that VTK has drawn are cached: if only the overlay changes, only the overlay is drawn again. Throws
// std::invalid_argument for wrong arguments.
class CanvasScene {
 public:
  CanvasScene(int width, int height);
  ~CanvasScene();
  CanvasScene(const CanvasScene&) = delete;
  CanvasScene& operator=(const CanvasScene&) = delete;

  int width() const { return width_; }
  int height() const { return height_; }
  // Implement the functions of Canvas; set() implements setPoints(), setTriangles() and setLines().
  void resize(int width, int height);
  void setViews(std::span<const CanvasView> views);
  void set(ItemId item, ItemKind kind, std::span<const Vec3f> corners, std::span<const Rgb> colors);
  void setColors(ItemId item, std::span<const Rgb> colors);
  // Implements showOnly(): draws only the elements with these indices (ascending); nullopt: all, as showAll().
  void show(ItemId item, std::optional<std::vector<std::uint32_t>> indices);
  void setLook(ItemId item, const ItemLook& look);
  void drop(ItemId item);
  void setImage(ImageId image, int width, int height, std::span<const Rgba> pixels);
  void setOverlay(Overlay overlay);

  void draw(std::uint64_t mostPoints);
  // Copies the picture to `pixels`, which has width * height entries, row by row from top to bottom.
  void read(std::span<Rgb> pixels);
  // Copies the picture to the context's default framebuffer.
  void showPicture();

 private:
  Item& item(ItemId number);
  void place(Item& item);
  void remove(Item& item);
  void placeViews();

  int width_;
  int height_;
  vtkNew<GlWindow> window_;
  vtkNew<vtkRenderer> uncovered_;  // black background below all views
  std::array<vtkNew<ViewRenderer>, kCanvasViews> renderers_;
  std::vector<CanvasView> views_;
  std::map<ItemId, std::unique_ptr<Item>> items_;
  DepthEdges edges_;
  OverlayPainter overlay_;
  bool drawn_ = false;  // true: the window's framebuffer contains the current views
  std::uint64_t drawnPoints_ = 0;
  bool pictured_ = false;  // true: a picture with the canvas's size exists
};

}  // namespace scanmill
