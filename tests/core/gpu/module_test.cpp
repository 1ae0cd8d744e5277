// Modules of other sources and other interfaces than the program's.

#include <string>

#include "base/error.h"
#include "base/file.h"
#include "gpu/compute_interface.h"
#include "images/images_interface.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kGpuFile(ComputeModule::kFile.name);

// The file of a module as the program loads it.
std::filesystem::path moduleFile(std::string_view name) {
  for (const std::filesystem::path folder : programLibraryFolders()) {
    if (std::filesystem::exists(folder / name)) return folder / name;
  }
  throw Error("there is no module " + std::string(name));
}

std::string loadFailure(const std::filesystem::path& folder) {
  return messageOf<Error>([&] { loadModule<ComputeModule>({"/absent", folder}); });
}

TEST(Module, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  EXPECT_THAT(loadFailure(folder.path()),
              AllOf(HasSubstr("nothing can be computed by OpenGL, since libscanmill_gpu.so is missing"),
                    HasSubstr("looked for in /absent, " + folder.path().string()), HasSubstr("cmake --install")));
  folder.write(kGpuFile, "text");
  EXPECT_THAT(loadFailure(folder.path()), AllOf(HasSubstr("cannot be loaded"), HasSubstr("libegl-dev")));
}

TEST(Module, OfOtherSourcesIsRefused) {
  std::string bytes = readFile(moduleFile(kGpuFile));
  std::size_t found = 0;
  for (std::size_t at = bytes.find(kModuleBuild); at != std::string::npos; at = bytes.find(kModuleBuild, at)) {
    bytes[at] = '?';
    ++found;
  }
  ASSERT_GT(found, 0u);
  const TemporaryFolder folder;
  folder.write(kGpuFile, bytes);
  EXPECT_THAT(loadFailure(folder.path()), HasSubstr("belongs to another version of Scanmill"));
}

TEST(Module, OfAnotherInterfaceIsRefused) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink(moduleFile(ImagesModule::kFile.name), folder.path() / kGpuFile);
  EXPECT_THAT(loadFailure(folder.path()), HasSubstr("belongs to another version of Scanmill"));
}

TEST(Module, IsTheSameAtEachUse) {
  EXPECT_EQ(&moduleOf<ImagesModule>(), &moduleOf<ImagesModule>());
}

}  // namespace
}  // namespace scanmill
