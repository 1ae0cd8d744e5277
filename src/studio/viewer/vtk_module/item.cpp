#include <vtkCellArray.h>
#include <vtkOpenGLVertexBufferObject.h>
#include <vtkPointData.h>
#include <vtkShaderProperty.h>
#include <vtkTypeInt32Array.h>

#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "base/random.h"
#include "viewer/vtk_module/canvas_scene.h"

namespace scanmill {

namespace {

// The fraction of a triangle's colour that remains if the triangle is seen edge-on.
constexpr double kAmbient = 0.35;

// Shader code for a light at the eye. VTK's headlight shines along the camera's axis, so that surfaces in the corners
// of a wide picture would be darker even if they face the eye.
constexpr const char* kLightAtTheEye = R"(
  float facing = cameraParallel == 1 ? normalVCVSOutput.z : -dot(normalVCVSOutput, normalize(vertexVC.xyz));
  gl_FragData[0] = vec4(ambientColor + max(facing, 0.0) * diffuseColor, opacity);
)";

// Divides the indices 0 to count - 1 into `ranges` equal ranges and returns a random index in the range with index
// `range`. If the index were not random, the rings and columns of a scan would cause visible patterns.
std::uint64_t randomIndex(std::uint64_t range, std::uint64_t ranges, std::uint64_t count) {
  const std::uint64_t first = range * count / ranges;
  const std::uint64_t end = (range + 1) * count / ranges;
  return first + philox4x32({static_cast<std::uint32_t>(range)}, {})[0] % (end - first);
}

// Returns the indices of finite elements; nothing if all are finite. `values`: number of coordinates per element.
std::optional<std::vector<std::uint32_t>> finiteElements(std::span<const float> coordinates, std::uint32_t values) {
  unsigned notFinite = 0;
  for (const float value : coordinates) {
    // Written without a branch, so that the compiler can use SIMD.
    notFinite |= !(std::abs(value) <= std::numeric_limits<float>::max());
  }
  if (notFinite == 0) return {};
  std::vector<std::uint32_t> elements;
  for (std::uint32_t i = 0; std::uint64_t{i} * values < coordinates.size(); ++i) {
    const auto element = coordinates.subspan(std::size_t{i} * values, values);
    if (std::ranges::all_of(element, [](float value) { return std::isfinite(value); })) elements.push_back(i);
  }
  return elements;
}

}  // namespace

Item::Item(ItemKind kind) : kind_(kind) {
  points_->SetDataTypeToFloat();
  colors_->SetNumberOfComponents(4);
  prepare(all_);
  prepare(few_);
  few_.actor->VisibilityOff();
  setLook({});
}

void Item::prepare(Part& part) {
  part.data->GetPointData()->SetScalars(colors_);
  part.mapper->SetInputData(part.data);
  part.mapper->SetColorModeToDirectScalars();
  part.mapper->SetScalarModeToUsePointData();
  part.mapper->SetVBOShiftScaleMethod(vtkOpenGLVertexBufferObject::DISABLE_SHIFT_SCALE);
  part.actor->SetMapper(part.mapper);
  part.actor->SetProperty(property_);
  part.actor->SetUserMatrix(canvasFromItem_);
  part.actor->PickableOff();
}

void Item::set(std::span<const Vec3f> vertices, std::span<const Rgb> colors) {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  const auto* positions = reinterpret_cast<const float*>(vertices.data());
  const std::uint64_t count = colors.size();
  if (count > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()) / corners()) {
    throw std::length_error("an item of the canvas has too many points");
  }
  count_ = static_cast<std::uint32_t>(count);
  vtkNew<vtkFloatArray> array;
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(static_cast<vtkIdType>(vertices.size()));
  std::copy_n(positions, 3 * vertices.size(), array->GetPointer(0));
  points_->SetData(array);
  colors_->SetNumberOfTuples(static_cast<vtkIdType>(vertices.size()));

  finite_ = finiteElements({positions, 3 * vertices.size()}, 3 * corners());
  setColors(colors);
  for (Part* part : {&all_, &few_}) part->data->SetPoints(points_);
  show({});
}

void Item::setColors(std::span<const Rgb> colors) {
  std::uint8_t* next = colors_->GetPointer(0);
  for (const Rgb& color : colors) {
    for (std::uint32_t k = 0; k < corners(); ++k) {
      next = std::ranges::copy(color, next).out;
      *next++ = 255;  // alpha
    }
  }
  colors_->Modified();
  for (Part* part : {&all_, &few_}) part->data->Modified();
}

void Item::show(std::optional<std::vector<std::uint32_t>> indices) {
  if (!indices) {
    drawn_ = finite_;
  } else if (!finite_) {
    drawn_ = std::move(indices);
  } else {
    drawn_.emplace();
    std::ranges::set_intersection(*indices, *finite_, std::back_inserter(*drawn_));
  }
  fill(all_, drawn_ ? &*drawn_ : nullptr);
  chosen_ = 0;
}

void Item::setLook(const ItemLook& look) {
  look_ = look;
  canvasFromItem_->DeepCopy(matrixRows(look.canvasFromItem).data());
  const bool lit = look.lit && kind_ == ItemKind::Triangles;
  const auto opacity = static_cast<float>(std::clamp(look.opacity, 0.0, 1.0));
  property_->SetPointSize(static_cast<float>(look.size));
  property_->SetLineWidth(static_cast<float>(look.size));
  property_->SetOpacity(opacity);
  property_->SetLighting(lit);
  property_->SetInterpolationToFlat();
  property_->SetAmbient(lit ? kAmbient : 0);
  property_->SetDiffuse(lit ? 1 - kAmbient : 1);
  const bool opaque = opacity >= 1;
  for (Part* part : {&all_, &few_}) {
    part->actor->SetForceOpaque(opaque);
    part->actor->SetForceTranslucent(!opaque);
    vtkShaderProperty* shaders = part->actor->GetShaderProperty();
    if (shaders->GetNumberOfShaderReplacements() != (lit ? 1 : 0)) {
      shaders->ClearAllShaderReplacements();
      if (lit) shaders->AddFragmentShaderReplacement("//VTK::Light::Impl", true, kLightAtTheEye, false);
    }
  }
}

void Item::choose(std::uint64_t maxPoints) {
  const std::uint64_t count = all_.elements;
  const bool drawsFew = kind_ == ItemKind::Points && maxPoints != 0 && maxPoints < count;
  if (drawsFew && chosen_ != maxPoints) {
    std::vector<std::uint32_t> elements(maxPoints);
    for (std::uint64_t k = 0; k < maxPoints; ++k) {
      const std::uint64_t index = randomIndex(k, maxPoints, count);
      elements[k] = drawn_ ? (*drawn_)[index] : static_cast<std::uint32_t>(index);
    }
    fill(few_, &elements);
    chosen_ = maxPoints;
  }
  const bool isVisible = count > 0 && look_.opacity > 0;
  all_.actor->SetVisibility(isVisible && !drawsFew);
  few_.actor->SetVisibility(isVisible && drawsFew);
}

// Sets the elements that the part draws; null: all. Points form a single cell, since VTK needs time for each cell.
void Item::fill(Part& part, const std::vector<std::uint32_t>* elements) {
  part.elements = elements != nullptr ? elements->size() : count_;
  const vtkIdType vertices = static_cast<vtkIdType>(part.elements) * static_cast<vtkIdType>(corners());
  vtkNew<vtkTypeInt32Array> connectivity;  // indices of vertices, element by element
  connectivity->SetNumberOfValues(vertices);
  std::int32_t* next = connectivity->GetPointer(0);
  if (elements == nullptr) {
    std::iota(next, next + vertices, 0);
  } else {
    for (const std::uint32_t element : *elements) {
      for (std::uint32_t k = 0; k < corners(); ++k) *next++ = static_cast<std::int32_t>(element * corners() + k);
    }
  }
  const auto cellSize = static_cast<std::int32_t>(kind_ == ItemKind::Points ? vertices : vtkIdType{corners()});
  const vtkIdType cells = cellSize > 0 ? vertices / cellSize : 0;
  vtkNew<vtkTypeInt32Array> offsets;  // index in `connectivity` at which each cell begins; last, its length
  offsets->SetNumberOfValues(cells + 1);
  for (vtkIdType cell = 0; cell <= cells; ++cell) offsets->SetValue(cell, static_cast<std::int32_t>(cell * cellSize));
  vtkNew<vtkCellArray> array;
  array->SetData(offsets, connectivity);
  if (kind_ == ItemKind::Points) part.data->SetVerts(array);
  if (kind_ == ItemKind::Segments) part.data->SetLines(array);
  if (kind_ == ItemKind::Triangles) part.data->SetPolys(array);
}

}  // namespace scanmill
