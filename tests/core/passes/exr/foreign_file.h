#pragma once

// EXR files as others might write them.

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>

#include <cstring>
#include <string>
#include <vector>

#include "passes/exr/exr_file.h"
#include "passes/exr/pass_exr.h"
#include "tests/core/passes/exr/one_file.h"

namespace scanmill {

// An image of 8 x 6 pixels whose camera looks along x from (10, 20, 30).
class ForeignFile : public OneFile {
 protected:
  static constexpr int kWidth = 8;
  static constexpr int kHeight = 6;

  ForeignFile() : header(kWidth, kHeight) {
    path = folder.path() / "foreign.exr";
    header.insert("cameraMatrix", Imf::M33dAttribute({4, 0, 4, 0, 4, 3, 0, 0, 1}));
    setPose({0, 0, 1, 10, -1, 0, 0, 20, 0, -1, 0, 30, 0, 0, 0, 1});
  }

  void setPose(const ExrMatrix4& m) {
    header.insert("worldFromCamera", Imf::M44dAttribute({m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9],
                                                         m[10], m[11], m[12], m[13], m[14], m[15]}));
  }

  // One value for all pixels, but for the last one.
  void add(const std::string& channel, Imf::PixelType type, float value, float last) {
    std::vector<char>& bytes = planes_.emplace_back(std::size_t{kWidth * kHeight} * 4);
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const float v = i + 1 < kWidth * kHeight ? value : last;
      char* const pixel = &bytes[static_cast<std::size_t>(i) * 4];
      if (type == Imf::UINT) {
        const auto id = static_cast<std::uint32_t>(v);
        std::memcpy(pixel, &id, sizeof id);
      } else if (type == Imf::HALF) {
        const half h(v);
        std::memcpy(pixel, &h, sizeof h);
      } else {
        std::memcpy(pixel, &v, sizeof v);
      }
    }
    header.channels().insert(channel, Imf::Channel(type));
    frame.insert(channel, Imf::Slice::Make(type, bytes.data(), header.dataWindow(), 4, kWidth * 4));
  }
  void add(const std::string& channel, Imf::PixelType type, float value) { add(channel, type, value, value); }
  void addNormal(const std::string& prefix, Imf::PixelType type = Imf::FLOAT) {
    add(prefix + "X", type, -1);
    add(prefix + "Y", type, 0);
    add(prefix + "Z", type, 0);
  }

  std::filesystem::path write() { return write(header); }
  std::filesystem::path write(const Imf::Header& used) {
    Imf::OutputFile out(path.c_str(), used, 0);
    out.setFrameBuffer(frame);
    out.writePixels(kHeight);
    return path;
  }

  PassImage read(PassChoice asked = {}) { return readPasses(write(), asked); }

  void expectRefused(const std::vector<std::string>& words, PassChoice asked = {}) {
    std::vector<std::string> all{path.string()};
    all.insert(all.end(), words.begin(), words.end());
    expectInputError([&] { read(asked); }, all);
  }

  Imf::Header header;
  Imf::FrameBuffer frame;

 private:
  std::vector<std::vector<char>> planes_;
};

}  // namespace scanmill
