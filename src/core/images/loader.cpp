#include "images/loader.h"

#include "base/module_loader.h"

namespace scanmill {

namespace {

const ModuleFile& imagesFile() {
  static const ModuleFile file{"libscanmill_images.so", kImagesModuleSymbol, "images cannot be read or written",
                               "install OpenImageIO (on Debian the package libopenimageio-dev)"};
  return file;
}

}  // namespace

const ScanmillImagesModule& loadImagesModule(const std::vector<std::string>& folders) {
  const auto entry = reinterpret_cast<decltype(&scanmillImagesModule)>(loadModule(imagesFile(), folders));
  const ScanmillImagesModule* module = entry != nullptr ? entry() : nullptr;
  if (module == nullptr || module->version != kImagesModuleVersion) failForeignModule(imagesFile());
  return *module;
}

const ScanmillImagesModule& imagesModule() {
  static const ScanmillImagesModule& module = loadImagesModule(programLibraryFolders());
  return module;
}

}  // namespace scanmill
