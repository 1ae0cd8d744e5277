#pragma once

// Draws the items, views and overlay of a canvas.

#include <vtkActor.h>
#include <vtkFloatArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLRenderer.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkTextureObject.h>
#include <vtkUnsignedCharArray.h>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gpu/opengl_module/gl_window.h"
#include "viewer/canvas/canvas.h"

namespace scanmill {

// Draws the elements of an item. A list of indices, separate from the positions, selects the elements, so that
// positions are not copied again if only the list or the colours change.
class Item {
 public:
  explicit Item(ItemKind kind);

  ItemKind kind() const { return kind_; }
  // Replaces all elements and shows all of them. Throws std::length_error if there are too many.
  void set(std::span<const Vec3f> corners, std::span<const Rgb> colors);
  void setColors(std::span<const Rgb> colors);
  // Shows only the elements with these indices (ascending); nullopt: all elements.
  void show(std::optional<std::vector<std::uint32_t>> indices);
  void setLook(const ItemLook& look);
  const ItemLook& look() const { return look_; }
  std::uint32_t count() const { return count_; }  // number of elements

  // Prepares for drawing at most `maxPoints` points; 0: all points.
  void choose(std::uint64_t maxPoints);
  std::array<vtkActor*, 2> actors() { return {all_.actor.Get(), few_.actor.Get()}; }

 private:
  struct Part {
    vtkNew<vtkPolyData> data;
    vtkNew<vtkOpenGLPolyDataMapper> mapper;
    vtkNew<vtkActor> actor;
    std::uint64_t elements = 0;
  };

  void prepare(Part& part);
  void fill(Part& part, const std::vector<std::uint32_t>* elements);
  std::uint32_t corners() const { return static_cast<std::uint32_t>(kind_); }

  ItemKind kind_;
  std::uint32_t count_ = 0;
  ItemLook look_;
  vtkNew<vtkPoints> points_;
  vtkNew<vtkUnsignedCharArray> colors_;               // RGBA, one per corner; VTK uses this format without copying
  std::optional<std::vector<std::uint32_t>> finite_;  // indices of elements with finite coordinates; nullopt: all
  std::optional<std::vector<std::uint32_t>> drawn_;  // indices of elements that are shown; nullopt: all finite elements
  vtkNew<vtkMatrix4x4> canvasFromItem_;
  vtkNew<vtkProperty> property_;
  Part all_;
  Part few_;
  std::uint64_t chosen_ = 0;  // number of points in few_; 0: few_ is empty
};

// Eye-dome lighting: darkens pixels beside the edge of a nearer surface, so that shapes are visible in point clouds,
// which have no normals for shading (Boucheny, "Interactive scientific visualization of large datasets: towards a
// perceptive-based approach", 2009).
class DepthEdges {
 public:
  // Darkens pixels in the view's rectangle, except the background; keeps depths. `height`: window's height (pixels).
  void darken(vtkOpenGLRenderWindow* window, const CanvasView& view, int height);
  void release(vtkWindow* window);

 private:
  unsigned vertexArray_ = 0;
  // A framebuffer with the window's colours, but not its depths, since the shader reads the depths.
  vtkNew<vtkOpenGLFramebufferObject> frame_;
};

// Draws one view: opaque items, then eye-dome lighting, then translucent items, whose depths are not written.
class ViewRenderer : public vtkOpenGLRenderer {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts
 public:
  static ViewRenderer* New();

  // Sets the camera and the rectangle of the view. `canvasWidth`, `canvasHeight`: size of the canvas in pixels.
  void setView(const CanvasView& view, int canvasWidth, int canvasHeight);
  void useEdges(DepthEdges* edges) { edges_ = edges; }

  void DeviceRenderOpaqueGeometry(vtkFrameBufferObjectBase* frame) override;
  void DeviceRenderTranslucentPolygonalGeometry(vtkFrameBufferObjectBase* frame) override;

 private:
  CanvasView view_{};
  int canvasHeight_ = 0;
  DepthEdges* edges_ = nullptr;
};

// Draws the overlay on top of the views.
class OverlayPainter {
 public:
  void setImage(vtkOpenGLRenderWindow* window, ImageId image, int width, int height, std::span<const Rgba> pixels);
  void set(Overlay overlay);
  // Draws to the bound framebuffer. `width`, `height`: size of the framebuffer (pixels).
  void draw(vtkOpenGLRenderWindow* window, int width, int height);
  void release(vtkWindow* window);

 private:
  void upload(vtkShaderProgram& program);

  std::map<ImageId, vtkNew<vtkTextureObject>> images_;
  Overlay overlay_;
  bool uploaded_ = false;  // true: the buffers contain the current overlay
  unsigned vertexArray_ = 0, vertices_ = 0, corners_ = 0;
};

// Holds the items, views and overlay of a canvas. Belongs to one OpenGL context, which must be current in all calls.
// The views that VTK has drawn are cached: if only the overlay changes, only the overlay is drawn again.
class CanvasScene {
 public:
  CanvasScene(int width, int height);
  ~CanvasScene();
  CanvasScene& operator=(CanvasScene&&) = delete;  // neither copied nor moved

  int width() const { return width_; }
  int height() const { return height_; }
  void resize(int width, int height);
  // Implement the functions of Canvas.
  void setViews(std::span<const CanvasView> views);
  void set(ItemId item, ItemKind kind, std::span<const Vec3f> corners, std::span<const Rgb> colors);
  void setColors(ItemId item, std::span<const Rgb> colors);
  void show(ItemId item, std::optional<std::vector<std::uint32_t>> indices);
  void setLook(ItemId item, const ItemLook& look);
  void drop(ItemId item);
  void setImage(ImageId image, int width, int height, std::span<const Rgba> pixels);
  void setOverlay(Overlay overlay) { overlay_.set(std::move(overlay)); }

  void draw(std::uint64_t maxPoints);
  // Copies the picture to `pixels` (width * height entries), row by row from the top. Throws if nothing has been drawn.
  void read(std::span<Rgb> pixels);
  // Copies the picture to the context's default framebuffer.
  void showPicture();

 private:
  Item& item(ItemId number);
  void place(Item& item);
  void remove(Item& item);
  void placeViews();

  int width_, height_;
  vtkNew<GlWindow> window_;
  vtkNew<vtkRenderer> uncovered_;  // black background below all views
  std::array<vtkNew<ViewRenderer>, kCanvasViews> renderers_;
  std::vector<CanvasView> views_;
  std::map<ItemId, std::unique_ptr<Item>> items_;
  DepthEdges edges_;
  OverlayPainter overlay_;
  bool viewsDrawn_ = false;           // true: the window's framebuffer contains the current views
  std::uint64_t drawnMaxPoints_ = 0;  // the limit with which the views were drawn, see Canvas::render()
  bool hasPicture_ = false;           // true: a picture with the canvas's size exists
};

}  // namespace scanmill
