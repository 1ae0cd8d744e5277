#include "methods/field/cache.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "base/random.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using std::chrono::hours;

const std::string kGeometry = sha256("some scene");
constexpr Vec3d kOrigin{4e5, 5e6, 100};

FieldShape someShape(bool lists) {
  FieldShape shape;
  shape.voxel = 0.1;
  shape.centre = {1.6, -0.8, 0};
  shape.levels = {{{-4, 0, 4}, {4, 5, 6}}, {{-3, -2, -1}, {3, 3, 3}}};
  shape.reach = 23;
  shape.lists = lists;
  return shape;
}

// Arrays of the sizes that a field of the shape has; what is in them does not matter to the cache.
DistanceField someField(const FieldShape& shape, std::uint32_t fullBricks, std::uint32_t listed = 1000) {
  DistanceField field;
  field.shape = shape;
  std::size_t bricks = 0;
  for (const LevelBox& box : shape.levels) {
    field.levels.push_back({{1, 2, 3}, 0.5f, box.bricks, static_cast<std::uint32_t>(bricks)});
    bricks += box.size();
  }
  field.table.resize(bricks);
  field.distance.resize(std::size_t{fullBricks} * kBrickStride);
  field.word.resize(field.distance.size());
  field.lists.resize(shape.lists ? listed : 0);
  std::uint32_t beam = 0;
  const auto fill = [&](auto& array) {
    for (auto& value : array) {
      value = static_cast<std::remove_reference_t<decltype(value)>>(randomBlock({.seed = 3, .beam = beam++})[0]);
    }
  };
  fill(field.table);
  fill(field.distance);
  fill(field.word);
  fill(field.lists);
  return field;
}

template <class T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same(const DistanceField& a, const DistanceField& b) {
  return a.shape == b.shape && sameBytes(a.levels, b.levels) && sameBytes(a.table, b.table) &&
         sameBytes(a.distance, b.distance) && sameBytes(a.word, b.word) && sameBytes(a.lists, b.lists);
}

// Without the fsync of writeFile().
void put(const fs::path& file, std::string_view bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

std::vector<fs::path> filesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

class FieldCacheTest : public testing::Test {
 protected:
  // Stores the field and gives its file.
  fs::path stored(const DistanceField& field) const {
    cache_.store(field, kOrigin);
    const std::vector<fs::path> files = filesIn(folder());
    EXPECT_EQ(files.size(), 1u);
    return files.at(0);
  }
  fs::path folder() const { return folder_.path() / "deep" / "fields"; }

  TemporaryFolder folder_;
  FieldCache cache_{folder_.path() / "deep" / "fields", kGeometry};
};

TEST_F(FieldCacheTest, GivesBackEveryByte) {
  for (const bool lists : {false, true}) {
    // None full; few; more than one slice of an array is hashed alone.
    for (const std::uint32_t fullBricks : {0u, 3u, 700u}) {
      const DistanceField field = someField(someShape(lists), fullBricks, fullBricks * 100);
      EXPECT_EQ(cache_.find(field.shape, kOrigin) != nullptr, fullBricks > 0);
      cache_.store(field, kOrigin);
      const auto found = cache_.find(field.shape, kOrigin);
      ASSERT_NE(found, nullptr);
      EXPECT_TRUE(same(field, *found)) << lists << " " << fullBricks;
    }
  }
}

TEST_F(FieldCacheTest, TheFileDoesNotDependOnThreads) {
  const DistanceField field = someField(someShape(true), 700);
  std::vector<std::string> files;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    files.push_back(readFile(stored(field)));
    EXPECT_NE(cache_.find(field.shape, kOrigin), nullptr);
  }
  EXPECT_EQ(files[0], files[1]);
  EXPECT_EQ(files[0], files[2]);
}

TEST_F(FieldCacheTest, FindsOnlyThisGeometryShapeAndOrigin) {
  const FieldShape shape = someShape(true);
  cache_.store(someField(shape, 2), kOrigin);
  ASSERT_NE(cache_.find(shape, kOrigin), nullptr);
  EXPECT_EQ(FieldCache(folder(), sha256("another scene")).find(shape, kOrigin), nullptr);
  for (const Vec3d& step : {Vec3d{1, 0, 0}, Vec3d{0, 1e-9, 0}, Vec3d{0, 0, -1}}) {
    EXPECT_EQ(cache_.find(shape, kOrigin + step), nullptr);
  }
  const std::vector<std::function<void(FieldShape&)>> changes = {
      [](FieldShape& s) { s.voxel = std::nextafter(0.1, 1); },
      [](FieldShape& s) { s.centre.x += 0.8; },
      [](FieldShape& s) { s.centre.y += 0.8; },
      [](FieldShape& s) { s.centre.z += 0.8; },
      [](FieldShape& s) { s.levels.pop_back(); },
      [](FieldShape& s) { s.levels[1].firstBrick[2] += 1; },
      [](FieldShape& s) { s.reach += 1; },
      [](FieldShape& s) { s.lists = false; },
      [](FieldShape& s) { std::swap(s.levels[0].bricks[0], s.levels[0].bricks[1]); }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    FieldShape other = shape;
    changes[i](other);
    EXPECT_EQ(cache_.find(other, kOrigin), nullptr) << i;
  }
  EXPECT_NE(cache_.find(shape, kOrigin), nullptr);
}

TEST_F(FieldCacheTest, AFileUnderAnothersNameIsNotTrusted) {
  const DistanceField field = someField(someShape(true), 2);
  const fs::path ours = stored(field);
  DistanceField other = field;
  other.shape.voxel = 0.2;
  cache_.store(other, kOrigin);
  for (const fs::path& file : filesIn(folder())) {
    if (file != ours) fs::rename(file, ours);
  }
  EXPECT_EQ(cache_.find(field.shape, kOrigin), nullptr);
  EXPECT_EQ(cache_.find(other.shape, kOrigin), nullptr);
}

TEST_F(FieldCacheTest, TruncatedFilesAreMisses) {
  const DistanceField field = someField(someShape(true), 40);
  const fs::path file = stored(field);
  const std::string bytes = readFile(file);
  std::vector<std::size_t> sizes{0, 1, 15, 16, 23, 24, 87, 88, 127, 128, 129, 191, 192, 193};
  for (std::size_t size = 200; size < bytes.size(); size += 1 + size / 9) sizes.push_back(size);
  for (std::size_t back = 1; back < 70; ++back) sizes.push_back(bytes.size() - back);
  for (const std::size_t size : sizes) {
    put(file, bytes.substr(0, size));
    EXPECT_EQ(cache_.find(field.shape, kOrigin), nullptr) << size;
  }
  put(file, bytes + '\0');
  EXPECT_EQ(cache_.find(field.shape, kOrigin), nullptr);
  put(file, bytes);
  EXPECT_NE(cache_.find(field.shape, kOrigin), nullptr);
}

TEST_F(FieldCacheTest, NoFlippedByteIsTrusted) {
  const DistanceField field = someField(someShape(true), 40);
  const fs::path file = stored(field);
  const std::string bytes = readFile(file);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < 250; ++i) places.push_back(i);
  for (std::uint32_t i = 0; i < 150; ++i) places.push_back(randomBlock({.seed = 7, .beam = i})[0] % bytes.size());
  for (std::size_t back = 1; back <= 70; ++back) places.push_back(bytes.size() - back);
  for (const std::size_t place : places) {
    std::string flipped = bytes;
    flipped[place] = static_cast<char>(flipped[place] ^ (1 << place % 8));
    put(file, flipped);
    EXPECT_EQ(cache_.find(field.shape, kOrigin), nullptr) << place;
  }
}

// Sizes that do not fit the file are refused before anything is allocated for them.
TEST_F(FieldCacheTest, LyingSizesAreMisses) {
  const DistanceField field = someField(someShape(true), 4);
  const fs::path file = stored(field);
  const std::string bytes = readFile(file);
  constexpr std::size_t kCounts = 88;  // where the header's five counts begin
  for (std::size_t array = 0; array < 5; ++array) {
    for (const std::uint64_t count :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1} << 32, std::uint64_t{1} << 62, ~std::uint64_t{0}}) {
      std::string lying = bytes;
      std::memcpy(lying.data() + kCounts + 8 * array, &count, sizeof count);
      put(file, lying);
      EXPECT_EQ(cache_.find(field.shape, kOrigin), nullptr) << array << " " << count;
    }
  }
}

TEST_F(FieldCacheTest, GarbageIsAMissAndTheNextStoreReplacesIt) {
  const DistanceField field = someField(someShape(false), 5);
  const fs::path file = stored(field);
  std::string noise(100'000, '\0');
  for (std::uint32_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<char>(randomBlock({.beam = i})[0]);
  for (const std::string& garbage : {std::string(), std::string("x"), noise, std::string(300'000, '\0')}) {
    put(file, garbage);
    EXPECT_EQ(cache_.find(field.shape, kOrigin), nullptr);
    cache_.store(field, kOrigin);
    EXPECT_NE(cache_.find(field.shape, kOrigin), nullptr);
  }
  fs::remove(file);
  EXPECT_EQ(cache_.find(field.shape, kOrigin), nullptr);
  fs::create_directory(file);
  EXPECT_EQ(cache_.find(field.shape, kOrigin), nullptr);
  const std::size_t warnings = warningCount();
  cache_.store(field, kOrigin);
  EXPECT_EQ(warningCount(), warnings + 1);
}

TEST_F(FieldCacheTest, WithoutAFolderNothingIsKept) {
  const FieldCache none({}, kGeometry);
  const DistanceField field = someField(someShape(false), 1);
  none.store(field, kOrigin);
  EXPECT_EQ(none.find(field.shape, kOrigin), nullptr);
  EXPECT_FALSE(fs::exists(folder_.path() / "deep"));
}

TEST_F(FieldCacheTest, AFolderThatCannotBeMadeIsAWarning) {
  const DistanceField field = someField(someShape(false), 1);
  const FieldCache below(folder_.write("file", "text") / "fields", kGeometry);
  const std::size_t warnings = warningCount();
  below.store(field, kOrigin);
  EXPECT_EQ(warningCount(), warnings + 1);
  EXPECT_EQ(below.find(field.shape, kOrigin), nullptr);
}

TEST_F(FieldCacheTest, AFolderThatMayNotBeWrittenIsAWarning) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const DistanceField field = someField(someShape(false), 1);
  const fs::path file = stored(field);
  fs::permissions(folder(), fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_NE(cache_.find(field.shape, kOrigin), nullptr);
  const std::size_t warnings = warningCount();
  DistanceField other = field;
  other.shape.reach = 11;
  cache_.store(other, kOrigin);
  EXPECT_EQ(warningCount(), warnings + 1);
  fs::permissions(folder(), fs::perms::owner_all);
  EXPECT_EQ(filesIn(folder()), std::vector{file});
}

// Files with holes stand for large fields.
class EvictionTest : public FieldCacheTest {
 protected:
  fs::path large(char digit, std::uint64_t bytes, hours age) const {
    const fs::path file = folder() / (std::string(64, digit) + ".field");
    fs::create_directories(folder());
    put(file, "");
    fs::resize_file(file, bytes);
    fs::last_write_time(file, fs::file_time_type::clock::now() - age);
    return file;
  }
  static constexpr std::uint64_t kThird = FieldCache::kCacheBytes / 3;
};

TEST_F(EvictionTest, TheLongestUnusedGoFirst) {
  const fs::path oldest = large('a', kThird, hours(5));
  const fs::path middle = large('c', kThird, hours(3));
  const fs::path newest = large('b', kThird, hours(1));
  const DistanceField field = someField(someShape(false), 5);
  cache_.store(field, kOrigin);
  EXPECT_FALSE(fs::exists(oldest));
  EXPECT_TRUE(fs::exists(middle) && fs::exists(newest));
  EXPECT_NE(cache_.find(field.shape, kOrigin), nullptr);
  large('d', 2 * kThird, hours(2));
  cache_.store(field, kOrigin);
  EXPECT_FALSE(fs::exists(middle));
}

TEST_F(EvictionTest, WhatWasFoundIsUsed) {
  const DistanceField used = someField(someShape(false), 5);
  DistanceField unused = used;
  unused.shape.reach = 11;
  cache_.store(used, kOrigin);
  cache_.store(unused, kOrigin);
  for (const fs::path& file : filesIn(folder())) {
    fs::last_write_time(file, fs::file_time_type::clock::now() - hours(10));
  }
  EXPECT_NE(cache_.find(used.shape, kOrigin), nullptr);
  large('a', FieldCache::kCacheBytes, hours(5));
  DistanceField third = used;
  third.shape.reach = 12;
  cache_.store(third, kOrigin);
  EXPECT_EQ(cache_.find(unused.shape, kOrigin), nullptr);
  EXPECT_NE(cache_.find(used.shape, kOrigin), nullptr);
  EXPECT_NE(cache_.find(third.shape, kOrigin), nullptr);
}

TEST_F(EvictionTest, OnlyFieldsAndWhatKilledRunsLeftAreDeleted) {
  large('a', FieldCache::kCacheBytes, hours(5));
  const std::string name = std::string(64, 'b') + ".field";
  const auto old = [&](const std::string& file, hours age) {
    put(folder() / file, "x");
    fs::last_write_time(folder() / file, fs::file_time_type::clock::now() - age);
    return folder() / file;
  };
  const fs::path notes = old("thesis.txt", hours(9000));
  const fs::path alike = old(std::string(64, 'g') + ".field", hours(9000));
  const fs::path partial = old(name + ".partial-1", hours(50));
  const fs::path writing = old(name + ".partial-2", hours(0));
  cache_.store(someField(someShape(false), 5), kOrigin);
  EXPECT_TRUE(fs::exists(notes) && fs::exists(alike) && fs::exists(writing));
  EXPECT_FALSE(fs::exists(partial));
  EXPECT_EQ(filesIn(folder()).size(), 4u);
}

TEST_F(FieldCacheTest, ThreadsMayStoreAndFindTheSame) {
  const DistanceField field = someField(someShape(true), 100);
  std::vector<std::thread> threads;
  std::array<std::uint32_t, 4> found{};
  for (std::size_t t = 0; t < found.size(); ++t) {
    threads.emplace_back([&, t] {
      const FieldCache own(folder(), kGeometry);
      for (int i = 0; i < 8; ++i) {
        own.store(field, kOrigin);
        const auto back = own.find(field.shape, kOrigin);
        found[t] += back != nullptr && same(field, *back) ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::uint32_t n : found) EXPECT_EQ(n, 8u);
  EXPECT_EQ(filesIn(folder()).size(), 1u);
}

Scene twoBoxes() {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  appendBox(mesh, 0, {}, {1, 2, 3});
  const std::uint32_t box = builder.addMesh(std::move(mesh));
  builder.place(box, at(5, 0, 0), "first");
  builder.place(box, at(0, 7, 0), "second");
  return builder.finish();
}

TEST(GeometryHash, FollowsWhatFieldsFollow) {
  const Scene scene = twoBoxes();
  const std::string hash = geometryHash(scene);
  EXPECT_EQ(hash.size(), 64u);
  EXPECT_EQ(geometryHash(twoBoxes()), hash);
  const auto texture = std::make_shared<const Texture>();
  const std::vector<std::function<void(Scene&)>> changes = {
      [](Scene& s) { s.meshes[0].positions[3].y += 1e-6f; },
      [](Scene& s) { std::swap(s.meshes[0].triangles[0], s.meshes[0].triangles[1]); },
      [](Scene& s) {
        s.meshes[0].triangles.pop_back();
        s.meshes[0].surfaceOf.pop_back();
      },
      [](Scene& s) { s.instances[0].worldFromMesh.translation.z += 1e-9; },
      [](Scene& s) { s.instances[1].worldFromMesh.linear.x.x = -1; },
      [](Scene& s) { std::swap(s.instances[0], s.instances[1]); },
      [](Scene& s) { s.instances.pop_back(); },
      [](Scene& s) { s.instances[0].firstInstanceId += 1; },
      [](Scene& s) { s.meshes[0].surfaces[0].object += 1; },
      [&](Scene& s) {
        for (Material& m : s.materials) {
          m.alphaTested = true;
          m.texture = texture;
        }
      }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Scene other = twoBoxes();
    changes[i](other);
    EXPECT_NE(geometryHash(other), hash) << i;
  }
}

TEST(GeometryHash, DoesNotFollowNamesClassesAndReflectances) {
  Scene scene = twoBoxes();
  const std::string hash = geometryHash(scene);
  scene.name = "other";
  scene.seed += 1;
  scene.meshes[0].name = "cube";
  scene.meshes[0].surfaces[0].semantic += 1;
  scene.meshes[0].surfaces[0].node = "node";
  scene.instances[0].name = "third";
  for (Material& m : scene.materials) m.reflectance *= 0.5f;
  EXPECT_EQ(geometryHash(scene), hash);
  EXPECT_EQ(geometryHash(Scene{}).size(), 64u);
  EXPECT_NE(geometryHash(Scene{}), hash);
}

TEST(DefaultCacheFolder, IsInTheUsersCache) {
  const auto keep = [](const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? std::string() : std::string(value);
  };
  const std::string cache = keep("XDG_CACHE_HOME");
  const std::string home = keep("HOME");
  ::setenv("XDG_CACHE_HOME", "/caches", 1);
  ::setenv("HOME", "/home/me", 1);
  EXPECT_EQ(defaultCacheFolder(), "/caches/scanmill/fields");
  ::setenv("XDG_CACHE_HOME", "caches", 1);
  EXPECT_EQ(defaultCacheFolder(), "/home/me/.cache/scanmill/fields");
  ::unsetenv("XDG_CACHE_HOME");
  EXPECT_EQ(defaultCacheFolder(), "/home/me/.cache/scanmill/fields");
  ::unsetenv("HOME");
  EXPECT_TRUE(defaultCacheFolder().empty());
  if (!cache.empty()) ::setenv("XDG_CACHE_HOME", cache.c_str(), 1);
  if (!home.empty()) ::setenv("HOME", home.c_str(), 1);
}

}  // namespace
}  // namespace scanmill
