#pragma once

// What is on a canvas, and its picture.

#include <vtkNew.h>
#include <vtkRenderer.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "passes/vtk_module/gl_window.h"
#include "viewer/canvas/canvas_module.h"
#include "viewer/vtk_module/depth_edges.h"
#include "viewer/vtk_module/item.h"
#include "viewer/vtk_module/overlay.h"
#include "viewer/vtk_module/view_renderer.h"

namespace scanmill {

// Of one OpenGL context, which is current whenever it is used. The views are drawn by VTK and kept: as long as only the
// overlay changes, a picture costs no more than that. Errors are std::invalid_argument.
class CanvasScene {
 public:
  CanvasScene(std::uint32_t width, std::uint32_t height);
  ~CanvasScene();
  CanvasScene(const CanvasScene&) = delete;
  CanvasScene& operator=(const CanvasScene&) = delete;

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  void resize(std::uint32_t width, std::uint32_t height);
  void setViews(std::span<const ScanmillCanvasView> views);
  // See ScanmillCanvasModule.
  void set(std::uint32_t item, ItemKind kind, std::uint64_t count, const float* positions, const std::uint8_t* colors);
  void setColors(std::uint32_t item, const std::uint8_t* colors);
  void show(std::uint32_t item, const std::uint32_t* indices, std::uint64_t count);
  void setLook(std::uint32_t item, const ScanmillCanvasLook& look);
  void drop(std::uint32_t item);
  void setOverlay(std::uint32_t width, std::uint32_t height, const std::uint8_t* rgba);

  void draw(std::uint64_t mostPoints);
  void read(std::uint8_t* rgb);
  // Copies the picture to the context's own framebuffer.
  void showPicture();

 private:
  Item& item(std::uint32_t number);
  void place(Item& item);
  void remove(Item& item);
  void placeViews();

  std::uint32_t width_;
  std::uint32_t height_;
  vtkNew<GlWindow> window_;
  vtkNew<vtkRenderer> uncovered_;  // black, under all views
  std::array<vtkNew<ViewRenderer>, kCanvasViews> renderers_;
  std::vector<ScanmillCanvasView> views_;
  std::map<std::uint32_t, std::unique_ptr<Item>> items_;
  DepthEdges edges_;
  Overlay overlay_;
  bool drawn_ = false;  // the window's framebuffer holds the views as they are
  std::uint64_t drawnPoints_ = 0;
  bool pictured_ = false;  // there is a picture of the canvas's size
};

}  // namespace scanmill
