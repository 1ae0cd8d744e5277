#include "assets/meshes/blender_export.h"

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
#include "config/text.h"

namespace scanmill {

namespace {

// Throws InputError unless the content of the file fits its ending: Blender would also open a file of another kind.
void checkKind(const std::filesystem::path& file) {
  std::array<char, 18> head{};
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError({file.string()}, "cannot be read");
  in.read(head.data(), head.size());
  const std::string_view begin(head.data(), static_cast<std::size_t>(in.gcount()));
  const std::string kind = lowerExtension(file);
  if (kind == ".fbx" && begin != "Kaydara FBX Binary") {
    throw InputError({file.string()},
                     "is not binary FBX, which alone Blender imports: save it as binary FBX, or convert it to glTF");
  }
  // A .blend is uncompressed, gzip (until Blender 2.93) or Zstandard (since 3.0).
  const bool known =
      begin.starts_with("BLENDER") || begin.starts_with("\x1F\x8B") || begin.starts_with("\x28\xB5\x2F\xFD");
  if (kind == ".blend" && !known) {
    throw InputError({file.string()}, "is not a Blender file: its first bytes are not those of one");
  }
}

}  // namespace

const FormatSupport& blenderFormat() {
  static const FormatSupport format{
      "Blender, and what it imports",
      ".blend, .fbx, .abc, .x3d, .usd, .usda, .usdc, .usdz",
      {},
      "Surfaces of the active scene at its saved or first frame, of objects that both its viewport and its renders "
      "show, evaluated as in renders: modifiers, levels of subdivision, simplification, particles and other instances. "
      "Principled and other shaders, also mixed with a Transparent one: base colour and alpha (each a constant or an "
      "image placed by texture coordinates), roughness and metallic; slots of objects come before those of meshes. "
      "Images, packed or beside the file",
      "objects that the viewport or renders hide; objects of other scenes; edges, thin curves, hair, halos, point "
      "clouds, volumes and grease pencil; missing libraries, with all that is linked from them; opacities of materials "
      "whose blend mode is opaque; nodes of materials that are not read; animations (one frame counts); files that "
      "Inline of X3D names"};
  return format;
}

BlenderExport::BlenderExport(const std::filesystem::path& file) {
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
