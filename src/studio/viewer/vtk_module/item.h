#pragma once

// An item on the canvas: points, triangles or segments.

#include <vtkActor.h>
#include <vtkFloatArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

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

}  // namespace scanmill
