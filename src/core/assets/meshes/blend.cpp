#include "assets/meshes/blend.h"

#include <fmt/core.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assets/meshes/blender.h"
#include "base/error.h"

namespace scanmill {

namespace {

// Throws InputError unless the content of the file is a .blend: Blender would also read a file of another kind whose
// name ends in .blend.
void checkKind(const std::filesystem::path& file) {
  std::array<char, 7> head{};
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError({file.string()}, "cannot be read");
  in.read(head.data(), head.size());
  const std::string_view begin(head.data(), static_cast<std::size_t>(in.gcount()));
  // A .blend is uncompressed, gzip (until Blender 2.93) or Zstandard (since 3.0).
  const bool known = begin == "BLENDER" || begin.starts_with("\x1F\x8B") || begin.starts_with("\x28\xB5\x2F\xFD");
  if (!known) throw InputError({file.string()}, "is not a Blender file: its first bytes are not those of one");
}

}  // namespace

const FormatSupport& blendFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "Blender",
      ".blend",
      {{Read, "",
        "surfaces of the active scene at its saved frame, of objects that both its viewport and its renders show, "
        "evaluated as in renders: modifiers, levels of subdivision, simplification, particles and other instances"},
       {Read, "",
        "surfaces of Principled and other shaders, also mixed with a Transparent one: name, base colour and alpha "
        "(1 minus it, too; each a constant or an image placed by texture coordinates), roughness and metallic; "
        "constants are linear light, as in Blender; slots of objects come before "
        "those of meshes"},
       {Read, "", "images, packed or beside the file"},
       {LeftOut, "", "objects that the viewport or renders hide"},
       {LeftOut, "", "objects of other scenes"},
       {LeftOut, "", "objects without faces, such as edges and thin curves"},
       {LeftOut, "", "particle systems of hair, lines or halos"},
       {LeftOut, "", "hair curves"},
       {LeftOut, "", "point clouds"},
       {LeftOut, "", "volumes"},
       {LeftOut, "", "grease pencil objects"},
       {LeftOut, "", "missing libraries, with all that is linked from them"},
       {LeftOut, "", "opacities of materials whose blend mode is opaque"},
       {LeftOut, "", "materials with nodes that are not read (colour and alpha may differ)"},
       {LeftOut, "", "animations (the saved frame counts)"},
       {Unused, "", "cameras, lights, scripts, and other properties of materials, such as normal maps"}}};
  return format;
}

BlendExport::BlendExport(const std::filesystem::path& file) {
  checkKind(file);
  std::optional<BlenderJob> job;
  try {
    job.emplace("export", folder_.path(), std::vector<std::string>{std::filesystem::absolute(file).string()});
  } catch (const Error& e) {  // Blender cannot be started; the file may be sound
    throw Error(fmt::format("{}: {}", file.string(), e.what()));
  }
  try {
    LeftOut leftOut;
    const auto counts = nlohmann::json::parse(job->answer().text).get<std::map<std::string, std::uint64_t>>();
    for (const auto& [what, count] : counts) leftOut.add(what, count);
    leftOut.tell(file.string());
  } catch (const InputError& e) {
    throw InputError({file.string()}, e.what());
  } catch (const Error& e) {
    throw InputError({file.string()}, fmt::format("cannot be read: {}", e.what()));
  }
}

}  // namespace scanmill
