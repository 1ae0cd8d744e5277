#include "passes/vtk/vtk_loader.h"

#include "base/module_loader.h"

namespace scanmill {

namespace {

const ModuleFile& passesFile() {
  static const ModuleFile file{"libscanmill_passes.so", kVtkModuleSymbol, "images cannot be drawn by VTK",
                               "install VTK and EGL (on Debian the packages libvtk9-dev and libegl-dev)"};
  return file;
}

}  // namespace

const ScanmillVtkModule& loadVtkModule(const std::vector<std::string>& folders) {
  const auto entry = reinterpret_cast<decltype(&scanmillVtkModule)>(loadModule(passesFile(), folders));
  const ScanmillVtkModule* module = entry != nullptr ? entry() : nullptr;
  if (module == nullptr || module->version != kVtkModuleVersion) failForeignModule(passesFile());
  return *module;
}

const ScanmillVtkModule& vtkModule() {
  static const ScanmillVtkModule& module = loadVtkModule(programLibraryFolders());
  return module;
}

}  // namespace scanmill
