#include "images/loader.h"

#include <dlfcn.h>
#include <fmt/core.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <system_error>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr const char* kFile = "libscanmill_images.so";
constexpr const char* kInstallAgain = "build or install Scanmill again (cmake --install)";

std::string lastError() {
  const char* text = ::dlerror();
  return text != nullptr ? text : "for no reason given";
}

// Asked for instead of left to dlopen, which takes the RUNPATH of whoever calls it: under a sanitizer that is the
// sanitizer's library, and not the program.
std::vector<std::string> programLibraryFolders() {
  void* program = ::dlopen(nullptr, RTLD_LAZY);
  Dl_serinfo need{};
  if (program == nullptr || ::dlinfo(program, RTLD_DI_SERINFOSIZE, &need) != 0) {
    throw Error(fmt::format("the folders of this program's libraries are unknown: {}", lastError()));
  }
  const auto storage = std::make_unique<std::max_align_t[]>(need.dls_size / sizeof(std::max_align_t) + 1);
  auto* info = reinterpret_cast<Dl_serinfo*>(storage.get());
  *info = need;
  if (::dlinfo(program, RTLD_DI_SERINFO, info) != 0) {
    throw Error(fmt::format("the folders of this program's libraries are unknown: {}", lastError()));
  }
  std::vector<std::string> folders;
  const Dl_serpath* paths = info->dls_serpath;
  for (unsigned i = 0; i < info->dls_cnt; ++i) {
    if (paths[i].dls_name[0] == '/') folders.emplace_back(paths[i].dls_name);  // never the working directory
  }
  return folders;
}

}  // namespace

const ScanmillImagesModule& loadImagesModule(const std::vector<std::string>& folders) {
  std::string sought;
  for (const std::string& folder : folders) {
    const std::string file = folder + "/" + kFile;
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) {
      sought += (sought.empty() ? "" : ", ") + file;
      continue;
    }
    // Local: nothing of its libraries may stand in for a symbol of ours. Never closed: they keep threads and tables.
    void* library = ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (library == nullptr) {
      throw Error(
          fmt::format("images cannot be read or written, {} cannot be loaded: {}; install OpenImageIO (on Debian the "
                      "package libopenimageio-dev), or {}",
                      file, lastError(), kInstallAgain));
    }
    const auto entry = reinterpret_cast<decltype(&scanmillImagesModule)>(::dlsym(library, kImagesModuleSymbol));
    const ScanmillImagesModule* module = entry != nullptr ? entry() : nullptr;
    if (module == nullptr || module->version != kImagesModuleVersion) {
      throw Error(fmt::format("images cannot be read or written, {} belongs to another version of Scanmill: {}", file,
                              kInstallAgain));
    }
    return *module;
  }
  throw Error(
      fmt::format("images cannot be read or written, {} is missing: looked for {}; {}", kFile, sought, kInstallAgain));
}

const ScanmillImagesModule& imagesModule() {
  static const ScanmillImagesModule& module = loadImagesModule(programLibraryFolders());
  return module;
}

}  // namespace scanmill
