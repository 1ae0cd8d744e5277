#pragma once

// Modules are plug-ins: shared libraries of the program that bring heavy libraries which are seldom needed, such as
// VTK, OpenGL and OpenImageIO. The program loads a module at its first use and never unloads it.
//
// The program uses a module through an interface: an abstract class in a header that includes nothing of the heavy
// library, with a constant `kFile` that says which file holds the module. The module derives a class from the interface
// and exports one object of that class by SCANMILL_MODULE. The program gets the object from moduleOf<Interface>().
//
// Objects, containers and exceptions may cross between the program and a module, since both are built by the same
// compiler from the same headers. A module of another build is refused before its object is used. A module contains no
// compiled code of the program's libraries, and uses only what their headers define.

#include <string>
#include <string_view>
#include <vector>

#include "base/module_build.h"

namespace scanmill {

struct ModuleFile {
  std::string_view name;     // "libscanmill_images.so"
  std::string_view without;  // what fails without it: "rasters of heights cannot be read"
  std::string_view install;  // how to get missing libraries: "install OpenImageIO (on Debian the package ...)"
};

// A module exports this struct through its only symbol, the function scanmillModule(). Never change it: each version
// must be able to refuse the modules of every other version.
struct ModuleEntry {
  std::string_view build;  // value of kModuleBuild when the module was built
  std::string_view file;   // ModuleFile::name of the module's interface
  const void* object;      // points to an object of the module's interface
};

// Returns the folders in which the program, or Python's extension, looks for its libraries: the folders of
// LD_LIBRARY_PATH, the RUNPATH (which contains the modules' folder) and the system. Throws Error.
std::vector<std::string> programLibraryFolders();

// Returns the module's object, from the first of `folders` that has the file. If the file is missing, cannot be loaded,
// or was built from other sources than the program, throws an Error that says what fails without it, and what to build
// or install.
const void* loadModuleObject(const ModuleFile& file, const std::vector<std::string>& folders);

template <class Interface>
const Interface& loadModule(const std::vector<std::string>& folders) {
  return *static_cast<const Interface*>(loadModuleObject(Interface::kFile, folders));
}

// Returns the module of an interface, and loads it at the first call. Any thread may call it. Throws Error as
// loadModuleObject() does; after an error the next call tries again.
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

// Exports an object of scanmill::Implementation from a module. Use it once per module, outside of all namespaces.
#define SCANMILL_MODULE(Interface, Implementation)                                                         \
  extern "C" __attribute__((visibility("default"))) const scanmill::ModuleEntry* scanmillModule() {        \
    static const scanmill::Implementation implementation{};                                                \
    static const scanmill::ModuleEntry entry = scanmill::moduleEntry<scanmill::Interface>(implementation); \
    return &entry;                                                                                         \
  }
