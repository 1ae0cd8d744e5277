#include "formats/reasons_png.h"

#include "base/error.h"
#include "images/images.h"
#include "scan/reasons.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

std::vector<std::uint8_t> everyReason(std::size_t count) {
  std::vector<std::uint8_t> values;
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(static_cast<std::uint8_t>(reasons()[i * i % reasons().size()].reason));
  }
  return values;
}

TEST(ReasonsPng, GivesBackWhatWasWritten) {
  for (const auto& [rings, columns] : {std::pair{1u, 1u}, {7u, 33u}, {64u, 2083u}}) {
    const std::vector<std::uint8_t> values = everyReason(std::size_t{rings} * columns);
    const std::string bytes = encodeReasons(values, rings, columns);
    EXPECT_LE(bytes.size(), mostReasonsBytes(rings, columns));
    const ReasonsImage image = decodeReasons(bytes, "r.png");
    EXPECT_EQ(image.rings, rings);
    EXPECT_EQ(image.columns, columns);
    EXPECT_EQ(image.reasonOfBeam, values);
  }
}

// Other programs see the reasons' colours, the first ring on top.
TEST(ReasonsPng, IsAnImageOfTheReasonsColours) {
  const std::vector<std::uint8_t> values = everyReason(12);
  const DecodedImage image = decodeImage(encodeReasons(values, 3, 4), "r.png");
  ASSERT_EQ(image.width, 4u);
  ASSERT_EQ(image.height, 3u);
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(image.rgba[4 * i + c], findReason(values[i])->color[c]) << i;
  }
}

TEST(ReasonsPng, RefusesWhatIsNone) {
  const std::string bytes = encodeReasons(everyReason(64), 8, 8);
  EXPECT_THROW(encodeReasons({1, 2}, 1, 1), Error);
  for (const std::string& wrong : {std::string(), std::string("text"), bytes.substr(0, bytes.size() / 2)}) {
    expectInputError([&] { decodeReasons(wrong, "a.reasons.png"); }, {"a.reasons.png", "no image of reasons"});
  }
  const std::vector<std::uint8_t> green{0, 255, 0};
  expectInputError([&] { decodeReasons(encodePng(green.data(), 1, 1), "a.reasons.png"); }, {"stands for no reason"});
}

}  // namespace
}  // namespace scanmill
