#include "passes/exr/hits_exr.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "base/file.h"
#include "base/random.h"
#include "passes/exr/exr_file.h"
#include "tests/support/message_of.h"
#include "tests/support/same_hits.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

// Every third beam misses; ids reach the ends of their types.
Hits someHits(std::uint32_t rings, std::uint32_t columns, Channels channels, bool surfaceParameters) {
  Hits hits;
  hits.reset(rings, columns, channels);
  const std::uint32_t ids[] = {0, 1, 2049, (1u << 24) + 1, 0xFFFFFFFFu};
  if (surfaceParameters) {
    for (auto* column : {&hits.roughness, &hits.metallic, &hits.retroreflectance}) column->resize(hits.size());
  }
  for (std::uint32_t i = 0; i < hits.size(); ++i) {
    const RandomBlock random = randomBlock({.seed = 5, .beam = i});
    const auto share = [&](int k) { return static_cast<float>(uniform(random[k])); };
    const bool miss = i % 3 == 0;
    const auto fill = [&](auto& column, auto value) {
      using Value = typename std::remove_reference_t<decltype(column)>::value_type;
      if (!column.empty()) column[i] = miss ? Value{} : static_cast<Value>(value);
    };
    hits.range[i] = miss ? kMiss : 200 * share(0);
    if (!hits.normal.empty()) hits.normal[i] = miss ? Vec3f{} : normalized(Vec3f{share(1), -share(2), share(3)});
    fill(hits.instance, ids[i % 5]);
    fill(hits.semantic, i % 2 == 0 ? 65535u : i);
    fill(hits.material, i % 7);
    fill(hits.primitive, ids[(i + 1) % 5]);
    fill(hits.reflectance, share(1));
    fill(hits.incidence, share(2));
    fill(hits.roughness, share(3));
    fill(hits.metallic, i % 2);
    fill(hits.retroreflectance, 40 * share(0));
  }
  return hits;
}

TEST(HitsExr, EveryBitComesBack) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  for (const auto& [rings, columns] : {std::pair{1u, 1u}, {64u, 512u}, {3u, 2001u}, {512u, 1u}}) {
    for (const bool surfaceParameters : {false, true}) {
      const Hits hits = someHits(rings, columns, Channels::all(), surfaceParameters);
      writeHits(path, hits);
      Hits back;
      readHits(path, Channels::all(), back);
      expectSameHits(hits, back);
    }
  }
}

TEST(HitsExr, UnresolvedBeamsComeBackAndCostNothingWhereThereAreNone) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  Hits hits = someHits(3, 50, Channels::all(), true);
  writeHits(path, hits);
  const ExrReader without(path);
  for (const ExrChannel& channel : without.channels()) EXPECT_NE(channel.name, "unresolved");
  hits.unresolved = {0, 3, 99, 147};
  writeHits(path, hits);
  Hits back;
  readHits(path, Channels::all(), back);
  expectSameHits(hits, back);
  readHits(path, Channel::Range, back);
  EXPECT_EQ(back.unresolved, hits.unresolved);
}

TEST(HitsExr, UnresolvedBeamsThatHitAreRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  const std::vector<float> ranges{kMiss, kMiss, 5, kMiss};
  Hits hits;
  const auto write = [&](ExrType type, const void* marks) {
    const ExrPlane planes[] = {{"range", ExrType::Float32, ranges.data()}, {"unresolved", type, marks}};
    writeExr(path, 2, 2, {}, planes, ExrCompression::Zip);
  };
  const std::vector<std::uint32_t> atHit{0, 0, 1, 0};
  write(ExrType::Uint32, atHit.data());
  expectInputError([&] { readHits(path, Channel::Range, hits); }, {path.string(), "'unresolved'", "ring 1, column 0"});
  const std::vector<std::uint32_t> no{0, 7, 0, 0};
  write(ExrType::Uint32, no.data());
  expectInputError([&] { readHits(path, Channel::Range, hits); }, {path.string(), "'unresolved'", "is 7"});
  write(ExrType::Float32, ranges.data());
  expectInputError([&] { readHits(path, Channel::Range, hits); }, {path.string(), "'unresolved'", "FLOAT"});
}

TEST(HitsExr, OnlyWhatIsAskedForIsRead) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  const Hits hits = someHits(8, 100, Channels::all(), false);
  writeHits(path, hits);
  Hits back = someHits(2, 2, Channels::all(), true);
  readHits(path, Channel::Instance, back);
  Hits expected = someHits(8, 100, Channel::Instance, false);
  expectSameHits(expected, back);
}

TEST(HitsExr, NegativeZeroAndTheSmallestNumbersStay) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  Hits hits;
  hits.reset(1, 4, Channel::Range | Channel::Normal);
  hits.range = {1e-45f, 3.4e38f, kMiss, 0.1f};
  hits.normal = {{-0.0f, 0, 1}, {1e-45f, -0.0f, -1}, {}, {0, 0, -0.0f}};
  writeHits(path, hits);
  Hits back;
  readHits(path, hits.channels, back);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    EXPECT_EQ(std::bit_cast<std::uint32_t>(hits.range[i]), std::bit_cast<std::uint32_t>(back.range[i]));
    EXPECT_EQ(std::signbit(hits.normal[i].x), std::signbit(back.normal[i].x));
    EXPECT_EQ(std::signbit(hits.normal[i].y), std::signbit(back.normal[i].y));
    EXPECT_EQ(std::signbit(hits.normal[i].z), std::signbit(back.normal[i].z));
  }
}

TEST(HitsExr, TheSameHitsGiveTheSameBytes) {
  const TemporaryFolder folder;
  const Hits hits = someHits(16, 300, Channels::all(), true);
  writeHits(folder.path() / "a.exr", hits);
  writeHits(folder.path() / "b.exr", hits);
  EXPECT_EQ(readFile(folder.path() / "a.exr"), readFile(folder.path() / "b.exr"));
}

// Whoever stores recordings may compress them.
TEST(HitsExr, CompressedHitsAreReadToo) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  const Hits hits = someHits(33, 65, Channel::Range | Channel::Instance, false);
  const ExrPlane planes[] = {{"range", ExrType::Float32, hits.range.data()},
                             {"instance", ExrType::Uint32, hits.instance.data()}};
  writeExr(path, 65, 33, {}, planes, ExrCompression::Zip);
  Hits back;
  readHits(path, hits.channels, back);
  expectSameHits(hits, back);
}

TEST(HitsExr, AnAbsentChannelIsNamed) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  writeHits(path, someHits(4, 4, Channel::Range | Channel::Semantic, false));
  Hits hits;
  expectInputError([&] { readHits(path, Channel::Instance, hits); }, {path.string(), "'instance'", "absent"});
  expectInputError([&] { readHits(path, Channel::Normal, hits); }, {path.string(), "'N.X'", "absent"});
}

TEST(HitsExr, WrongTypesAndValuesAreRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  std::vector<float> reals{1, 2, 3, 4};
  const std::vector<std::uint32_t> ids{1, 2, 70000, 4};
  Hits hits;
  const auto write = [&](const char* name, ExrType type, const void* pixels) {
    const ExrPlane planes[] = {{"range", ExrType::Float32, reals.data()}, {name, type, pixels}};
    writeExr(path, 2, 2, {}, planes, ExrCompression::Zip);
  };
  write("instance", ExrType::Float32, reals.data());
  expectInputError([&] { readHits(path, Channel::Instance, hits); }, {"'instance'", "FLOAT", "UINT"});
  write("incidence", ExrType::Uint32, ids.data());
  expectInputError([&] { readHits(path, Channel::Incidence, hits); }, {"'incidence'", "UINT", "FLOAT"});
  write("semantic", ExrType::Uint32, ids.data());
  expectInputError([&] { readHits(path, Channel::Semantic, hits); }, {path.string(), "'semantic'", "70000"});
  for (const float bad : {-1.0f, std::nanf(""), -INFINITY}) {
    reals[3] = bad;
    write("semantic", ExrType::Uint32, ids.data());
    expectInputError([&] { readHits(path, Channel::Range, hits); }, {"'range'", "ring 1, column 1"});
  }
}

TEST(HitsExr, DamageIsAnErrorAndNeverACrash) {
  const TemporaryFolder folder;
  const auto whole = folder.path() / "hits.exr";
  writeHits(whole, someHits(40, 50, Channels::all(), true));
  const std::string bytes = readFile(whole);
  const auto path = folder.path() / "bad.exr";
  Hits hits;
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 17) {
    folder.write("bad.exr", bytes.substr(0, size));
    expectInputError([&] { readHits(path, Channels::all(), hits); }, {path.string()});
  }
  for (std::uint32_t i = 0; i < 400; ++i) {
    std::string flipped = bytes;
    const RandomBlock random = randomBlock({.seed = 9, .beam = i});
    // Half of the flips hit the header.
    const std::size_t place = random[0] % (i % 2 == 0 ? 700 : bytes.size());
    flipped[place] = static_cast<char>(flipped[place] ^ (1 << random[1] % 8));
    folder.write("bad.exr", flipped);
    try {
      readHits(path, Channels::all(), hits);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(path.string()));
    }
  }
}

TEST(HitsExr, ColumnsThatDoNotFitAreNotWritten) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hits.exr";
  Hits hits = someHits(4, 4, Channels::all(), false);
  hits.material.pop_back();
  EXPECT_THAT(messageOf<Error>([&] { writeHits(path, hits); }), testing::HasSubstr("material"));
  hits.reset(0, 0, Channel::Range);
  EXPECT_THROW(writeHits(path, hits), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace scanmill
