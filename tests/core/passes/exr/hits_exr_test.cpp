#include "passes/exr/hits_exr.h"

#include "passes/exr/exr_file.h"
#include "tests/core/passes/exr/one_file.h"
#include "tests/support/same_hits.h"

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

class HitsExr : public OneFile {
 protected:
  Hits readHitsOf(Channels channels) const {
    Hits hits;
    readHits(path, channels, hits);
    return hits;
  }
};

TEST_F(HitsExr, EveryBitComesBack) {
  for (const auto& [rings, columns] : {std::pair{1u, 1u}, {64u, 512u}, {3u, 2001u}, {512u, 1u}}) {
    for (const bool surfaceParameters : {false, true}) {
      Hits hits = someHits(rings, columns, Channels::all(), surfaceParameters);
      if (hits.size() > 1) {
        hits.range[1] = 1e-45f;
        hits.normal[1] = {-0.0f, 1e-45f, -1};
      }
      writeHits(path, hits);
      const Hits back = readHitsOf(Channels::all());
      expectSameHits(hits, back);
    }
  }
}

TEST_F(HitsExr, UnresolvedBeamsComeBackAndCostNothingWhereThereAreNone) {
  Hits hits = someHits(3, 50, Channels::all(), true);
  writeHits(path, hits);
  const ExrReader without(path);
  for (const ExrChannel& channel : without.channels()) EXPECT_NE(channel.name, "unresolved");
  hits.unresolved = {0, 3, 99, 147};
  writeHits(path, hits);
  Hits back = readHitsOf(Channels::all());
  expectSameHits(hits, back);
  readHits(path, Channel::Range, back);
  EXPECT_EQ(back.unresolved, hits.unresolved);
}

TEST_F(HitsExr, UnresolvedBeamsThatHitAreRefused) {
  const std::vector<float> ranges{kMiss, kMiss, 5, kMiss};
  const auto write = [&](ExrType type, const void* marks) {
    const ExrPlane planes[] = {{"range", ExrType::Float32, ranges.data()}, {"unresolved", type, marks}};
    writeExr(path, 2, 2, {}, planes, ExrCompression::Zip);
  };
  const std::vector<std::uint32_t> atHit{0, 0, 1, 0};
  write(ExrType::Uint32, atHit.data());
  expectInputError([&] { readHitsOf(Channel::Range); }, {path.string(), "'unresolved'", "ring 1, column 0"});
  const std::vector<std::uint32_t> no{0, 7, 0, 0};
  write(ExrType::Uint32, no.data());
  expectInputError([&] { readHitsOf(Channel::Range); }, {path.string(), "'unresolved'", "is 7"});
  write(ExrType::Float32, ranges.data());
  expectInputError([&] { readHitsOf(Channel::Range); }, {path.string(), "'unresolved'", "FLOAT"});
}

TEST_F(HitsExr, OnlyWhatIsAskedForIsRead) {
  const Hits hits = someHits(8, 100, Channels::all(), false);
  writeHits(path, hits);
  Hits back = someHits(2, 2, Channels::all(), true);
  readHits(path, Channel::Instance, back);
  Hits expected = someHits(8, 100, Channel::Instance, false);
  expectSameHits(expected, back);
}

TEST_F(HitsExr, TheSameHitsGiveTheSameBytes) {
  const Hits hits = someHits(16, 300, Channels::all(), true);
  writeHits(folder.path() / "a.exr", hits);
  writeHits(folder.path() / "b.exr", hits);
  EXPECT_EQ(readFile(folder.path() / "a.exr"), readFile(folder.path() / "b.exr"));
}

// Whoever stores recordings may compress them.
TEST_F(HitsExr, CompressedHitsAreReadToo) {
  const Hits hits = someHits(33, 65, Channel::Range | Channel::Instance, false);
  const ExrPlane planes[] = {{"range", ExrType::Float32, hits.range.data()},
                             {"instance", ExrType::Uint32, hits.instance.data()}};
  writeExr(path, 65, 33, {}, planes, ExrCompression::Zip);
  const Hits back = readHitsOf(hits.channels);
  expectSameHits(hits, back);
}

TEST_F(HitsExr, AnAbsentChannelIsNamed) {
  writeHits(path, someHits(4, 4, Channel::Range | Channel::Semantic, false));
  expectInputError([&] { readHitsOf(Channel::Instance); }, {path.string(), "'instance'", "absent"});
  expectInputError([&] { readHitsOf(Channel::Normal); }, {path.string(), "'N.X'", "absent"});
}

TEST_F(HitsExr, WrongTypesAndValuesAreRefused) {
  std::vector<float> reals{1, 2, 3, 4};
  const std::vector<std::uint32_t> ids{1, 2, 70000, 4};
  const auto write = [&](const char* name, ExrType type, const void* pixels) {
    const ExrPlane planes[] = {{"range", ExrType::Float32, reals.data()}, {name, type, pixels}};
    writeExr(path, 2, 2, {}, planes, ExrCompression::Zip);
  };
  write("instance", ExrType::Float32, reals.data());
  expectInputError([&] { readHitsOf(Channel::Instance); }, {"'instance'", "FLOAT", "UINT"});
  write("incidence", ExrType::Uint32, ids.data());
  expectInputError([&] { readHitsOf(Channel::Incidence); }, {"'incidence'", "UINT", "FLOAT"});
  write("semantic", ExrType::Uint32, ids.data());
  expectInputError([&] { readHitsOf(Channel::Semantic); }, {path.string(), "'semantic'", "70000"});
  for (const float bad : {-1.0f, std::nanf(""), -INFINITY}) {
    reals[3] = bad;
    write("semantic", ExrType::Uint32, ids.data());
    expectInputError([&] { readHitsOf(Channel::Range); }, {"'range'", "ring 1, column 1"});
  }
}

TEST_F(HitsExr, DamageIsAnErrorAndNeverACrash) {
  writeHits(path, someHits(40, 50, Channels::all(), true));
  expectDamageIsRefused([&] { readHitsOf(Channels::all()); });
}

TEST_F(HitsExr, ColumnsThatDoNotFitAreNotWritten) {
  Hits hits = someHits(4, 4, Channels::all(), false);
  hits.material.pop_back();
  EXPECT_THAT(messageOf<Error>([&] { writeHits(path, hits); }), testing::HasSubstr("material"));
  hits.reset(0, 0, Channel::Range);
  EXPECT_THROW(writeHits(path, hits), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace scanmill
