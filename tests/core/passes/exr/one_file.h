#pragma once

// Tests of one EXR file in a folder of its own.

#include <cstdint>
#include <string>

#include "base/error.h"
#include "base/file.h"
#include "base/random.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

class OneFile : public testing::Test {
 protected:
  // Cuts the file anywhere, and flips bits of it, mostly of its header: `read` must refuse it with its name, or not
  // mind.
  template <class Read>
  void expectDamageIsRefused(const Read& read) const {
    const std::string bytes = readFile(path);
    for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 17) {
      folder.write(path.filename().string(), bytes.substr(0, size));
      expectInputError(read, {path.string()});
    }
    for (std::uint32_t i = 0; i < 600; ++i) {
      std::string flipped = bytes;
      const RandomBlock random = randomBlock({.seed = 11, .beam = i});
      const std::size_t place = random[0] % (i % 3 == 0 ? bytes.size() : i % 3 == 1 ? 700 : 1500);
      flipped[place] = static_cast<char>(flipped[place] ^ (1 << random[1] % 8));
      folder.write(path.filename().string(), flipped);
      try {
        read();
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(path.string()));
      }
    }
  }

  TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "file.exr";
};

}  // namespace scanmill
