#pragma once

// Modules: libraries that are heavy and seldom needed, loaded by the program at their first use.

#include <string>
#include <vector>

namespace scanmill {

struct ModuleFile {
  std::string file;     // "libscanmill_images.so"
  std::string symbol;   // the function that gives its table
  std::string without;  // what fails without it: "images cannot be read or written"
  std::string install;  // what its libraries need: "install OpenImageIO (on Debian the package ...)"
};

// Where the program looks for its libraries: its RUNPATH, in which the build and the installation name the modules'
// folder. Throws Error.
std::vector<std::string> programLibraryFolders();

// The address of the module's symbol, from the first of `folders` that has the file; null where that lacks the symbol.
// The module stays loaded. Throws Error.
void* loadModule(const ModuleFile& module, const std::vector<std::string>& folders);

// The error of a module that was built from other sources than the program.
[[noreturn]] void failForeignModule(const ModuleFile& module);

}  // namespace scanmill
