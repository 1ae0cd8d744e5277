#include "assets/meshes/blend.h"

#include <fmt/core.h>

#include <array>
#include <cstddef>
#include <fstream>
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

BlendExport::BlendExport(const std::filesystem::path& file) {
  checkKind(file);
  std::optional<BlenderJob> job;
  try {
    job.emplace("export", folder_.path(), std::vector<std::string>{std::filesystem::absolute(file).string()});
  } catch (const Error& e) {  // Blender cannot be started; the file may be sound
    throw Error(fmt::format("{}: {}", file.string(), e.what()));
  }
  try {
    job->answer();
  } catch (const InputError& e) {
    throw InputError({file.string()}, e.what());
  } catch (const Error& e) {
    throw InputError({file.string()}, fmt::format("cannot be read: {}", e.what()));
  }
}

}  // namespace scanmill
