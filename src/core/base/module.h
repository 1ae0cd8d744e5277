#pragma once

// Modules are shared libraries of the program that hold what is heavy and seldom needed: VTK, OpenGL and OpenImageIO.
// The program loads a module at its first use and keeps it until its own end, so that it starts quickly, and works
// without these libraries wherever they are not needed.
//
// A module is reached by its interface: an abstract class in a header of its library, which includes nothing of the
// heavy library. The interface has a constant `kFile` that says which file holds the module. The module derives a class
// from it and exports one object of that class by SCANMILL_MODULE. The program gets the object from
// moduleOf<Interface>().
//
// The headers of the interface and the compiler are the same on both sides, so objects, containers and exceptions cross
// between them as they do within the program. A module that was made otherwise is refused before anything of it is
// called. A module contains no compiled code of our libraries, and uses only what their headers define.

#include <string>
#include <string_view>
#include <vector>

#include "base/module_build.h"

namespace scanmill {

struct ModuleFile {
  std::string_view name;     // "libscanmill_images.so"
  std::string_view without;  // what fails without it: "images cannot be read or written"
  std::string_view install;  // what its libraries need: "install OpenImageIO (on Debian the package ...)"
};

// What a module exports by its only symbol, the function scanmillModule(). This struct stays as it is, so that each
// version can refuse the modules of every other.
struct ModuleEntry {
  std::string_view build;  // kModuleBuild as the module was made
  std::string_view file;   // ModuleFile::name of its interface
  const void* object;      // points to an object of its interface
};

// The folders in which the program looks for its libraries: those of its RUNPATH, in which the build and the
// installation name the modules' folder. Throws Error.
std::vector<std::string> programLibraryFolders();

// The object of the module, from the first of `folders` that has the file. Throws an Error that says what fails without
// the module, which files were looked for and what to install, where the file is missing, cannot be loaded, or was made
// from other sources than the program.
const void* loadModuleObject(const ModuleFile& file, const std::vector<std::string>& folders);

template <class Interface>
const Interface& loadModule(const std::vector<std::string>& folders) {
  return *static_cast<const Interface*>(loadModuleObject(Interface::kFile, folders));
}

// The module of an interface, loaded at the first call, from any thread. Throws Error as loadModuleObject() does; the
// next call tries again.
template <class Interface>
const Interface& moduleOf() {
  static const Interface* const loaded = &loadModule<Interface>(programLibraryFolders());
  return *loaded;
}

template <class Interface>
ModuleEntry moduleEntry(const Interface& object) {
  return {kModuleBuild, Interface::kFile.name, &object};
}

}  // namespace scanmill

// Stands once in a module, outside of all namespaces: exports an object of scanmill::Implementation.
#define SCANMILL_MODULE(Interface, Implementation)                                                         \
  extern "C" __attribute__((visibility("default"))) const scanmill::ModuleEntry* scanmillModule() {        \
    static const scanmill::Implementation implementation{};                                                \
    static const scanmill::ModuleEntry entry = scanmill::moduleEntry<scanmill::Interface>(implementation); \
    return &entry;                                                                                         \
  }
