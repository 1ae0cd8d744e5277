// The compute programs are valid GLSL on any machine: the reference compiler reads each of them as a device would.

#include <sys/wait.h>

#include <cstdio>
#include <map>

#include "base/file.h"
#include "gpu/compute.h"
#include "methods/gpu/device_march.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// All programs as a device gets them.
std::map<std::string, std::string> programs() {
  std::map<std::string, std::string> all;
  for (const bool lists : {false, true}) {
    const std::string variant = lists ? " with lists" : " without lists";
    all["launch" + variant] = computeShaderText(launchShader(lists));
    all["march" + variant] = computeShaderText(marchShader(lists));
    all["hits" + variant] = computeShaderText(resolveShader(lists));
  }
  return all;
}

struct Validated {
  bool there = false;  // the compiler is installed
  bool valid = false;
  std::string output;
};

Validated validate(const std::string& text) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "program.comp";
  writeFile(file, text);
  std::FILE* const pipe = ::popen(("glslangValidator -S comp '" + file.string() + "' 2>&1").c_str(), "r");
  if (pipe == nullptr) return {};
  Validated seen;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) seen.output += static_cast<char>(c);
  const int status = ::pclose(pipe);
  seen.there = !WIFEXITED(status) || WEXITSTATUS(status) != 127;
  seen.valid = status == 0;
  return seen;
}

TEST(Shaders, AreValid) {
  for (const auto& [name, text] : programs()) {
    const Validated seen = validate(text);
    if (!seen.there)
      GTEST_SKIP() << "glslangValidator is not installed: it would show that the programs are valid GLSL";
    EXPECT_TRUE(seen.valid) << name << ":\n" << seen.output;
  }
}

TEST(Shaders, FaultsAreFound) {
  std::string text = programs().at("march with lists");
  const std::size_t at = text.find("uvec4 origin");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 5, "float");
  const Validated seen = validate(text);
  if (!seen.there) GTEST_SKIP() << "glslangValidator is not installed: it would show that faults are found";
  EXPECT_FALSE(seen.valid);
  EXPECT_THAT(seen.output, HasSubstr("ERROR"));
}

// No file is left over, and none is pasted in twice.
TEST(Shaders, HoldEveryFileOnce) {
  const std::filesystem::path folder = std::filesystem::path(SCANMILL_SOURCE_DIR) / "src/core/methods/gpu/shaders";
  const auto all = programs();
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string text = readFile(entry.path());
    const std::size_t include = text.rfind("#include");
    const std::string own = text.substr(include == std::string::npos ? 0 : text.find('\n', include) + 1);
    bool used = false;
    for (const auto& [name, program] : all) {
      const std::size_t found = program.find(own);
      used = used || found != std::string::npos;
      EXPECT_TRUE(found == std::string::npos || program.find(own, found + 1) == std::string::npos)
          << name << " holds " << entry.path() << " twice";
    }
    EXPECT_TRUE(used) << entry.path() << " is in no program";
    ++files;
  }
  EXPECT_EQ(files, 11u);
}

}  // namespace
}  // namespace scanmill
