#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include "passes/exr/exr_file.h"
#include "tests/core/passes/exr/foreign_file.h"

namespace scanmill {
namespace {

class ExrReaderTest : public ForeignFile {};

TEST_F(ExrReaderTest, TheDataWindowIsTheDisplayWindow) {
  add("Z", Imf::FLOAT, 5);
  header.displayWindow().max.x += 1;
  expectRefused({"data window", "display window"});
  header.displayWindow() = {{1, 0}, {kWidth, kHeight - 1}};
  expectRefused({"data window", "display window"});
}

TEST_F(ExrReaderTest, AWindowMayStandAnywhere) {
  header.dataWindow() = header.displayWindow() = {{-100, 33}, {-100 + kWidth - 1, 33 + kHeight - 1}};
  add("Z", Imf::FLOAT, 5, 6);
  const PassImage image = read();
  EXPECT_EQ(image.camera.width, 8u);
  EXPECT_EQ(image.camera.cx, 4);
  EXPECT_EQ(image.planes.depth.front(), 5);
  EXPECT_EQ(image.planes.depth.back(), 6);
}

TEST_F(ExrReaderTest, LossyCompressionIsRefused) {
  add("Z", Imf::FLOAT, 5);
  for (const Imf::Compression lossy : {Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::DWAA_COMPRESSION}) {
    header.compression() = lossy;
    expectRefused({"ZIP"});
  }
  for (const Imf::Compression exact :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::PIZ_COMPRESSION}) {
    header.compression() = exact;
    EXPECT_EQ(read().planes.depth[0], 5);
  }
}

TEST_F(ExrReaderTest, FewerSamplesThanPixelsAreRefused) {
  add("Z", Imf::FLOAT, 5);
  header.channels().insert("BY", Imf::Channel(Imf::HALF, 2, 2));
  expectRefused({"'BY'", "samples"});
}

TEST_F(ExrReaderTest, TilesAreRead) {
  add("Z", Imf::FLOAT, 5, 6);
  header.setTileDescription({3, 4, Imf::ONE_LEVEL});
  {
    Imf::TiledOutputFile out(path.c_str(), header, 0);
    out.setFrameBuffer(frame);
    out.writeTiles(0, out.numXTiles() - 1, 0, out.numYTiles() - 1);
  }
  const PassImage image = readPasses(path, {});
  EXPECT_EQ(image.planes.depth.front(), 5);
  EXPECT_EQ(image.planes.depth.back(), 6);
}

TEST_F(ExrReaderTest, PartsAreLayers) {
  const auto write = [&](int depthRows) {
    Imf::Header headers[] = {{kWidth, kHeight}, {kWidth, kHeight}};
    headers[0].dataWindow().max.y = depthRows - 1;
    headers[0].setName("depth");
    headers[0].channels().insert("Z", Imf::Channel(Imf::FLOAT));
    headers[0].insert("worldFromCamera", header["worldFromCamera"]);
    headers[1].setName("N");
    headers[1].insert("cameraMatrix", header["cameraMatrix"]);
    for (const char* axis : {"X", "Y", "Z"}) headers[1].channels().insert(axis, Imf::Channel(Imf::FLOAT));
    for (Imf::Header& part : headers) part.setType(Imf::SCANLINEIMAGE);
    Imf::MultiPartOutputFile file(path.c_str(), headers, 2, false, 0);
    std::vector<float> depth(std::size_t{kWidth * kHeight}, 5);
    depth.back() = 6;
    std::vector<float> minusOne(depth.size(), -1);
    std::vector<float> zero(depth.size());
    const auto slice = [&](std::vector<float>& plane) {
      return Imf::Slice::Make(Imf::FLOAT, plane.data(), headers[1].dataWindow());
    };
    Imf::FrameBuffer first;
    first.insert("Z", slice(depth));
    Imf::FrameBuffer second;
    second.insert("X", slice(minusOne));
    second.insert("Y", slice(zero));
    second.insert("Z", slice(zero));
    Imf::OutputPart depthPart(file, 0);
    depthPart.setFrameBuffer(first);
    depthPart.writePixels(depthRows);
    Imf::OutputPart normalPart(file, 1);
    normalPart.setFrameBuffer(second);
    normalPart.writePixels(kHeight);
  };
  write(kHeight);
  const PassImage image = readPasses(path, {Channel::Normal, false});
  EXPECT_EQ(image.planes.depth.front(), 5);
  EXPECT_EQ(image.planes.depth.back(), 6);
  EXPECT_EQ(image.planes.normal.back(), (Vec3f{-1, 0, 0}));
  write(kHeight - 1);
  expectInputError([&] { readPasses(path, {}); }, {path.string(), "data window", "display window"});
}

TEST_F(ExrReaderTest, DeepPixelsAreRefused) {
  header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
  header.setType(Imf::DEEPSCANLINE);
  header.compression() = Imf::ZIPS_COMPRESSION;
  {
    std::vector<unsigned> counts(std::size_t{kWidth * kHeight}, 1);
    std::vector<float> values(counts.size(), 5);
    std::vector<float*> pointers;
    for (float& value : values) pointers.push_back(&value);
    Imf::DeepFrameBuffer deep;
    deep.insertSampleCountSlice(Imf::Slice::Make(Imf::UINT, counts.data(), header.dataWindow()));
    deep.insert("Z", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers.data()), sizeof(float*),
                                    sizeof(float*) * kWidth, sizeof(float)));
    Imf::DeepScanLineOutputFile out(path.c_str(), header, 0);
    out.setFrameBuffer(deep);
    out.writePixels(kHeight);
  }
  expectInputError([&] { readPasses(path, {}); }, {path.string(), "deep"});
}

}  // namespace
}  // namespace scanmill
