#pragma once

// Points, triangles or segments on the canvas.

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

enum class ItemKind : std::uint32_t { Points = 1, Segments = 2, Triangles = 3 };  // by the corners of an element

// What is drawn of an item is a list of indices beside its positions: neither another list nor other colours touch
// them.
class Item {
 public:
  explicit Item(ItemKind kind);

  ItemKind kind() const { return kind_; }
  std::uint32_t count() const { return count_; }  // of elements
  // Replaces all elements and shows them. Throws std::length_error where there are too many.
  void set(std::span<const Vec3f> corners, std::span<const Rgb> colors);
  void setColors(std::span<const Rgb> colors);
  // Shows only these elements (ascending); nullopt: all.
  void show(std::optional<std::vector<std::uint32_t>> indices);
  void setLook(const ItemLook& look);
  const ItemLook& look() const { return look_; }

  // Makes ready what is drawn where only so many points shall be drawn; 0: all.
  void choose(std::uint64_t mostPoints);
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
  vtkNew<vtkUnsignedCharArray> colors_;               // rgba, one a corner: VTK takes these as they are
  std::optional<std::vector<std::uint32_t>> finite_;  // elements whose coordinates are; nullopt: all
  std::optional<std::vector<std::uint32_t>> drawn_;   // of these, those shown; nullopt: all
  vtkNew<vtkMatrix4x4> canvasFromItem_;
  vtkNew<vtkProperty> property_;
  Part all_;
  Part few_;
  std::uint64_t chosen_ = 0;  // the number of points that few_ was made for; 0: for none
};

}  // namespace scanmill
