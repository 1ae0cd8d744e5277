#include "base/module.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <memory>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {

namespace {

constexpr const char* kInstallAgain = "build or install Scanmill again (cmake --install)";

std::string lastError() {
  const char* text = ::dlerror();
  return text != nullptr ? text : "for no reason given";
}

}  // namespace

// Returns the folders in which the dynamic linker looks for the program's libraries. dlopen() alone does not suffice:
// with a sanitizer, the sanitizer's library makes the call, and its RUNPATH is searched instead.
std::vector<std::string> programLibraryFolders() {
  // What contains this code: the program, or Python's extension, whose folders are not those of Python's own program.
  Dl_info own{};
  const bool isKnown = ::dladdr(reinterpret_cast<const void*>(&programLibraryFolders), &own) != 0;
  void* program = isKnown ? ::dlopen(own.dli_fname, RTLD_LAZY | RTLD_NOLOAD) : nullptr;
  if (program == nullptr) program = ::dlopen(nullptr, RTLD_LAZY);
  Dl_serinfo header{};  // states the size of the list of folders, and how many there are
  if (program == nullptr || ::dlinfo(program, RTLD_DI_SERINFOSIZE, &header) != 0) {
    throw Error("the folders of this program's libraries are unknown: {}", lastError());
  }
  const auto storage = std::make_unique<std::max_align_t[]>(header.dls_size / sizeof(std::max_align_t) + 1);
  auto* info = reinterpret_cast<Dl_serinfo*>(storage.get());
  *info = header;
  if (::dlinfo(program, RTLD_DI_SERINFO, info) != 0) {
    throw Error("the folders of this program's libraries are unknown: {}", lastError());
  }
  std::vector<std::string> folders;
  const Dl_serpath* paths = info->dls_serpath;
  for (unsigned i = 0; i < info->dls_cnt; ++i) {
    // Relative folders are skipped, because they depend on the working directory.
    if (paths[i].dls_name[0] == '/') folders.emplace_back(paths[i].dls_name);
  }
  return folders;
}

const void* loadModuleObject(const ModuleFile& module, const std::vector<std::string>& folders) {
  std::vector<std::string> searchedFolders;
  for (const std::string& folder : folders) {
    const std::string file = fmt::format("{}/{}", folder, module.name);
    if (!pathExists(file)) {
      searchedFolders.push_back(folder);
      continue;
    }
    // The module is loaded locally, so that no symbol of its libraries replaces a symbol of the program. It is never
    // closed, since its libraries keep threads and tables.
    void* library = ::dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (library == nullptr) {
      throw Error("{}, {} cannot be loaded: {}; {}, or {}", module.without, file, lastError(), module.install,
                  kInstallAgain);
    }
    const auto entryOf = reinterpret_cast<const ModuleEntry* (*)()>(::dlsym(library, "scanmillModule"));
    const ModuleEntry* entry = entryOf != nullptr ? entryOf() : nullptr;
    if (entry == nullptr || entry->build != kModuleBuild || entry->file != module.name) {
      throw Error("{}, {} belongs to another version of Scanmill: {}", module.without, file, kInstallAgain);
    }
    return entry->object;
  }
  constexpr std::size_t kMostNamed = 2;
  const std::size_t unnamed = searchedFolders.size() - std::min(searchedFolders.size(), kMostNamed);
  searchedFolders.resize(searchedFolders.size() - unnamed);
  throw Error(
      "{}, since {} is missing. It is not in every wheel; the archive and the Debian packages have it. "
      "Elsewhere, {}. It was looked for in {}{}",
      module.without, module.name, kInstallAgain, fmt::join(searchedFolders, ", "),
      unnamed > 0 ? fmt::format(" and {} more folders", unnamed) : "");
}

}  // namespace scanmill
