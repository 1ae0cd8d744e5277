#include "viewer/canvas/canvas_loader.h"

#include "base/module_loader.h"

namespace scanmill {

namespace {

const ModuleFile& canvasFile() {
  static const ModuleFile file{
      "libscanmill_viewer.so", kCanvasModuleSymbol, "nothing can be shown by VTK",
      "install VTK, EGL and X11 (on Debian the packages libvtk9-dev, libegl-dev and libx11-dev)"};
  return file;
}

}  // namespace

const ScanmillCanvasModule& loadCanvasModule(const std::vector<std::string>& folders) {
  const auto entry = reinterpret_cast<decltype(&scanmillCanvasModule)>(loadModule(canvasFile(), folders));
  const ScanmillCanvasModule* module = entry != nullptr ? entry() : nullptr;
  if (module == nullptr || module->version != kCanvasModuleVersion) failForeignModule(canvasFile());
  return *module;
}

const ScanmillCanvasModule& canvasModule() {
  static const ScanmillCanvasModule& module = loadCanvasModule(programLibraryFolders());
  return module;
}

}  // namespace scanmill
