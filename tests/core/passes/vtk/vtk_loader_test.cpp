#include "passes/vtk/vtk_loader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "passes/renderer.h"
#include "tests/support/message_of.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

TEST(VtkModule, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  EXPECT_THAT(messageOf<Error>([&] {
                loadVtkModule({"/absent", folder.path()});
              }),
              HasSubstr("looked for /absent/libscanmill_passes.so, " + folder.path().string()));
  const std::string garbage =
      messageOf<Error>([&] { loadVtkModule({folder.write("libscanmill_passes.so", "text").parent_path()}); });
  EXPECT_THAT(garbage, HasSubstr("cannot be loaded"));
  EXPECT_THAT(garbage, HasSubstr("libvtk9-dev"));
}

}  // namespace
}  // namespace scanmill
