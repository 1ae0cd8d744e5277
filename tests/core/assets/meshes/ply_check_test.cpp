#include "assets/meshes/ply_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "base/error.h"
#include "tests/core/assets/read_assets.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A tetrahedron, with a quality after each list and an element after the faces.
struct Ply {
  std::string format = "binary_little_endian";
  std::string newline = "\n";
  std::string countType = "uchar";
  std::vector<int> lengths{3, 3, 3, 3};  // as written; each list has three indices all the same
  float firstX = 0;

  std::string header() const {
    std::string text;
    for (const std::string& line :
         {std::string("ply"), "format " + format + " 1.0", std::string("comment of no use"),
          std::string("element vertex 4"), std::string("property float x"), std::string("property float y"),
          std::string("property float z"), std::string("element face 4"),
          "property list " + countType + " int vertex_indices", std::string("property double quality"),
          std::string("element end 1"), std::string("property short mark"), std::string("end_header")}) {
      text += line + newline;
    }
    return text;
  }

  template <class T>
  std::string bytes(T value) const {
    std::string out(reinterpret_cast<const char*>(&value), sizeof value);
    const bool swapped = (format == "binary_big_endian") == (std::endian::native == std::endian::little);
    if (swapped) std::reverse(out.begin(), out.end());
    return out;
  }

  std::string length(int value) const {
    if (countType == "float") return bytes(static_cast<float>(value));
    if (countType == "double") return bytes(static_cast<double>(value));
    if (countType == "char" || countType == "uchar") return bytes(static_cast<std::int8_t>(value));
    if (countType == "short" || countType == "ushort") return bytes(static_cast<std::int16_t>(value));
    return bytes(value);
  }

  std::string body() const {
    static constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
    std::string out;
    if (format == "ascii") {
      for (const char* vertex : {"0 0 0", "1 0 0", "0 1 0", "0 0 1"}) out += vertex + newline;
      for (std::size_t i = 0; i < 4; ++i) {
        out += std::to_string(lengths[i]);
        for (const int index : kFaces[i]) out += " " + std::to_string(index);
        out += " 0.25" + newline;
      }
      return out + "-7" + newline;
    }
    for (const float value : {firstX, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) out += bytes(value);
    for (std::size_t i = 0; i < 4; ++i) {
      out += length(lengths[i]);
      for (const int index : kFaces[i]) out += bytes(index);
      out += bytes(0.25);
    }
    return out + bytes(std::int16_t{-7});
  }
};

class PlyCheck : public testing::Test {
 protected:
  void accept(const std::string& text, const std::string& what) {
    EXPECT_NO_THROW(checkPly(folder_.write("a.ply", text))) << what;
    EXPECT_EQ(trianglesOf(readAsset(folder_.path() / "a.ply", {})), 4u) << what;
  }

  std::string failure(const std::string& text) {
    return messageOf([&] { checkPly(folder_.write("a.ply", text)); });
  }

  TemporaryFolder folder_;
};

TEST_F(PlyCheck, WholeFilesAreRead) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* newline : {"\n", "\r\n"}) {
      for (const char* type : {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"}) {
        const Ply ply{.format = format, .newline = newline, .countType = type};
        accept(ply.header() + ply.body(), ply.header());
        accept(ply.header() + ply.body() + "more", ply.header());
      }
    }
  }
}

TEST_F(PlyCheck, ALineFeedAfterAMacHeaderIsData) {
  Ply ply{.newline = "\r"};
  ply.firstX = std::bit_cast<float>(std::uint32_t{0x3f00000a});
  EXPECT_NO_THROW(checkPly(folder_.write("a.ply", ply.header() + ply.body())));
  ply.format = "ascii";
  EXPECT_NO_THROW(checkPly(folder_.write("a.ply", ply.header() + ply.body())));
}

TEST_F(PlyCheck, EveryCutIsRefused) {
  for (const Ply& ply : {Ply{}, Ply{.format = "binary_big_endian", .countType = "int"}}) {
    const std::string header = ply.header();
    const std::string whole = header + ply.body();
    for (std::size_t size = 0; size < whole.size(); size += size < header.size() - 10 ? 10 : 1) {
      EXPECT_THAT(failure(whole.substr(0, size)), AllOf(HasSubstr("a.ply"), HasSubstr("truncated"))) << size;
    }
  }
  const Ply ply;
  const std::string body = ply.body();
  EXPECT_THAT(failure(ply.header() + body.substr(0, 47)), HasSubstr("it ends within 'vertex' 4 of 4"));
  EXPECT_THAT(failure(ply.header() + body.substr(0, 48)), HasSubstr("it ends within 'face' 1 of 4"));
  EXPECT_THAT(failure(ply.header() + body.substr(0, 48 + 3 * 21)), HasSubstr("it ends within 'face' 4 of 4"));
  EXPECT_THAT(failure(ply.header() + body.substr(0, body.size() - 1)), HasSubstr("it ends within 'end' 1 of 1"));
  EXPECT_THROW(readAsset(folder_.path() / "a.ply", {}), InputError);
}

TEST_F(PlyCheck, EveryMissingWordIsRefused) {
  for (const char* newline : {"\n", "\r\n"}) {
    const Ply ply{.format = "ascii", .newline = newline};
    const std::string body = ply.body();
    accept(ply.header() + body.substr(0, body.size() - ply.newline.size()), "without its last newline");
    EXPECT_THAT(failure(ply.header() + newline + body), HasSubstr("a.ply:14: 'vertex' 1 of 4 lacks values"));
    for (std::size_t size = 0; size < body.size(); ++size) {
      if (body[size] != ' ') continue;
      EXPECT_THAT(failure(ply.header() + body.substr(0, size)), HasSubstr("truncated")) << size;
      std::string gap = body;  // the line lacks one word, the file goes on
      while (gap[size] != newline[0]) gap.erase(size, 1);
      EXPECT_THAT(failure(ply.header() + gap), HasSubstr("truncated")) << size;
    }
  }
}

TEST_F(PlyCheck, ListsThatAreTooLongAreRefused) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    Ply ply{.format = format, .countType = "int"};
    for (const int length : {1 << 30, 2000, -3}) {
      ply.lengths[1] = length;
      EXPECT_THAT(failure(ply.header() + ply.body()), HasSubstr("'face' 2 of 4")) << format << " " << length;
    }
  }
}

TEST_F(PlyCheck, WhatTheImporterWouldMakeUpIsRefused) {
  const Ply ply{.format = "ascii"};
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = ply.header() + ply.body();
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_THAT(failure(with("float z", "float height")), HasSubstr("its vertices have no property z"));
  EXPECT_THAT(failure(with("element face 4", "element tristrips 4")), HasSubstr("export it with faces"));
  EXPECT_THAT(failure(with("1 0 0", "1,5 0 0")), HasSubstr("a.ply:15: '1,5' is not a number"));
}

TEST_F(PlyCheck, LongFilesAreWalkedToTheEnd) {
  // 50,000 faces of 3 to 6 corners reach over many blocks of the reader.
  std::string body(12, '\0');
  constexpr int kFaces = 50000;
  for (int i = 0; i < kFaces; ++i) {
    const int corners = 3 + i % 4;
    body += static_cast<char>(corners) + std::string(static_cast<std::size_t>(corners) * 4, '\0');
  }
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face " +
      std::to_string(kFaces) + "\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_NO_THROW(checkPly(folder_.write("a.ply", header + body)));
  EXPECT_THAT(failure(header + body.substr(0, body.size() - 1)), HasSubstr("'face' 50000 of 50000"));
}

TEST_F(PlyCheck, WhatNoSurfaceIsMadeFromIsTold) {
  const TemporaryFolder folder;
  const std::string head =
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty uchar red\n"
      "property int label\nelement face 1\nproperty list uchar int vertex_indices\nproperty int "
      "object_id\nend_header\n";
  std::string binary;
  for (const float x : {0.0f, 1.0f, 2.0f}) {
    for (const float c : {x, x * x, 0.0f, 0.0f}) binary.append(reinterpret_cast<const char*>(&c), 4);
    binary.append(5, '\0');
  }
  binary += std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0\7\0\0\0", 17);
  for (const std::string& bytes :
       {"ply\nformat binary_little_endian 1.0\n" + head + binary,
        "ply\nformat ascii 1.0\n" + head + "0 0 0 0 0 0\n1 1 0 0 0 0\n2 4 0 0 0 0\n3 0 1 2 7\n"}) {
    const auto file = folder.write(bytes.find("ascii") == std::string::npos ? "b.ply" : "a.ply", bytes);
    testing::internal::CaptureStderr();
    readAsset(file, {});
    EXPECT_THAT(testing::internal::GetCapturedStderr(),
                HasSubstr("left out: 1 channels of colours, 1 unknown 'label', 1 unknown 'object_id'"));
  }
}

TEST_F(PlyCheck, SpellingsThatAreNoNumbersAreRefusedWithTheLine) {
  const TemporaryFolder folder;
  for (const std::string word : {"1,5", "1.0f", "1D3", "1'000", "0x1", "1.#QNAN"}) {
    const auto file =
        folder.write("a.ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                     "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 +0\n1 1 " +
                         word + "\n2 4 0\n3 0 1 2\n");
    EXPECT_THAT(messageOf([&] { readAsset(file, {}); }),
                AllOf(HasSubstr("a.ply:11: '" + word), HasSubstr("is not a number")));
  }
}

}  // namespace
}  // namespace scanmill
