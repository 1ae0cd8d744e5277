#include "passes/vtk/vtk_interface.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

TEST(VtkModule, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  EXPECT_THAT(messageOf<Error>([&] {
                loadModule<VtkModule>({"/absent", folder.path()});
              }),
              HasSubstr("looked for in /absent, " + folder.path().string()));
  const std::string garbage =
      messageOf<Error>([&] { loadModule<VtkModule>({folder.write("libscanmill_passes.so", "text").parent_path()}); });
  EXPECT_THAT(garbage, HasSubstr("cannot be loaded"));
  EXPECT_THAT(garbage, HasSubstr("libvtk9-dev"));
}

}  // namespace
}  // namespace scanmill
