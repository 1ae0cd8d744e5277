#include "methods/depth_camera/options.h"

#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

namespace scanmill {

namespace {

// Reads a key whose value is one of the names in `values`. Returns the value for that name, and the name in `name`.
template <class T, std::size_t n>
T choose(Fields& fields, std::string_view key, const std::pair<const char*, T> (&values)[n], std::string& name) {
  std::vector<std::string> names;
  for (const auto& [known, value] : values) names.emplace_back(known);
  name = fields.choice(key, names, names.front());
  for (const auto& [known, value] : values) {
    if (name == known) return value;
  }
  return values[0].second;
}

constexpr std::pair<const char*, CameraLayout> kLayouts[] = {{"auto", CameraLayout::Auto},
                                                             {"three_120", CameraLayout::Three120},
                                                             {"four_90", CameraLayout::Four90},
                                                             {"cube_6", CameraLayout::Cube6}};
constexpr std::pair<const char*, Sampling> kSamplings[] = {{"plane", Sampling::Plane},
                                                           {"nearest", Sampling::Nearest},
                                                           {"bilinear", Sampling::Bilinear},
                                                           {"row_hyperbola", Sampling::RowHyperbola},
                                                           {"equirectangular", Sampling::Equirectangular},
                                                           {"pixel_row", Sampling::PixelRow}};
constexpr std::pair<const char*, DepthFormat> kDepths[] = {{"float32", DepthFormat::Float32},
                                                           {"uint24", DepthFormat::Unorm24},
                                                           {"uint16", DepthFormat::Unorm16},
                                                           {"half_500", DepthFormat::Half500}};
constexpr std::pair<const char*, std::uint32_t> kAntialiasing[] = {{"1", 1}, {"2", 2}, {"4", 4}};

}  // namespace

DepthCameraOptions readDepthCameraOptions(Fields& fields) {
  DepthCameraOptions options;
  options.renderer = fields.choice("renderer", {"vtk", "blender"}, "vtk");
  options.layout.layout = choose(fields, "layout", kLayouts, options.layoutName);
  options.layout.resolution = static_cast<std::uint32_t>(fields.integer("resolution", 128, 4096, 2048));
  options.sample.sampling = choose(fields, "sampling", kSamplings, options.samplingName);
  options.sample.depth = choose(fields, "depth", kDepths, options.depthName);
  std::string antialiasing;
  options.sample.antialiasing = choose(fields, "antialiasing", kAntialiasing, antialiasing);
  options.sample.nearest = fields.number("near_m", {1e-3, 1}, 0.01);
  options.farthest = fields.number("far_m", {10, 1e4}, 0);
  const Value* renders = fields.find("renders_per_turn");
  if (renders != nullptr && !(renders->kind == Value::Kind::Scalar && renders->text == "auto")) {
    options.rendersPerRevolution = static_cast<std::uint32_t>(fields.integer("renders_per_turn", 1, 65536));
  }
  fields.finish();
  return options;
}

}  // namespace scanmill
