#pragma once

// An X server of a test's own, with real keys and clicks.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/process.h"
#include "tests/support/temporary_folder.h"
#include "viewer/image.h"

#define SKIP_WITHOUT_X()                                                                 \
  if (scanmill::findProgram("Xvfb").empty() || scanmill::findProgram("xdotool").empty()) \
  GTEST_SKIP() << "Xvfb or xdotool is absent: scripts/setup --view installs them"

namespace scanmill {

// Xvfb, whose picture lies in a file. While it lives, DISPLAY names it.
class XDisplay {
 public:
  explicit XDisplay(const std::string& size = "640x480")
      : server_(std::make_unique<Process>(std::vector<std::string>{findProgram("Xvfb").string(), "-displayfd", "1",
                                                                   "-screen", "0", size + "x24", "-nolisten", "tcp",
                                                                   "-fbdir", folder_.path().string()})) {
    const std::optional<std::string> number = server_->readLine(20);
    if (!number) throw std::runtime_error("Xvfb does not start: " + server_->lastLines());
    name_ = ":" + *number;
    ::setenv("DISPLAY", name_.c_str(), 1);
  }
  ~XDisplay() { ::unsetenv("DISPLAY"); }
  XDisplay(const XDisplay&) = delete;
  XDisplay& operator=(const XDisplay&) = delete;

  const std::string& name() const { return name_; }
  void end() { server_.reset(); }

  // X's dump: a header of numbers of 32 bits, its own length first, the upper byte of each first.
  Image screen() const {
    std::ifstream file(folder_.path() / "Xvfb_screen0", std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    const auto number = [&](std::size_t field) {
      std::size_t value = 0;
      for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<std::uint8_t>(bytes.at(4 * field + k));
      return value;
    };
    const std::size_t first = number(0) + 12 * number(19);  // after the colours
    Image image(static_cast<int>(number(4)), static_cast<int>(number(5)), Rgb{});
    for (std::size_t y = 0; y < number(5); ++y) {
      for (std::size_t x = 0; x < number(4); ++x) {
        const std::size_t at = first + y * number(12) + 4 * x;  // blue, green, red, nothing
        for (std::size_t k = 0; k < 3; ++k) {
          image.at(static_cast<int>(x), static_cast<int>(y))[k] = static_cast<std::uint8_t>(bytes.at(at + 2 - k));
        }
      }
    }
    return image;
  }

 private:
  TemporaryFolder folder_;
  std::unique_ptr<Process> server_;
  std::string name_;
};

// xdotool: "mousemove", "120", "80", "click", "1".
inline void act(std::vector<std::string> words) {
  words.insert(words.begin(), findProgram("xdotool").string());
  Process process(words);
  ASSERT_EQ(process.wait(20), "exit code 0") << process.lastLines();
}

}  // namespace scanmill
