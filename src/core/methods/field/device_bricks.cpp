#include "methods/field/device_bricks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "base/parallel.h"
#include "gpu/compute.h"
#include "methods/device/device_tables.h"
#include "methods/device/wide_hierarchy.h"
#include "methods/field/brick.h"
#include "methods/field/bricks_shader.h"

namespace scanmill {

namespace {

using enum ComputeTable::Texel;

const ComputeErrorWords kWords{"fields cannot be built by OpenGL", "'backend: cpu' does without it"};

constexpr std::size_t kBricksAtOnce = 2048;  // 12 MB come back of so many
constexpr std::size_t kGrain = 16384;

std::vector<BrickPlaceWords> wordsOf(std::span<const BrickPlace> places) {
  std::vector<BrickPlaceWords> words;
  words.reserve(places.size());
  for (const BrickPlace& p : places) words.push_back({p.centre.x, p.centre.y, p.centre.z, p.voxel, 1 / p.voxel});
  return words;
}

// All triangles of a block in the order of equally near ones.
std::vector<std::uint32_t> orderedTriangles(const TriangleBlock& block) {
  std::vector<std::uint32_t> triangles(block.triangles.size());
  std::iota(triangles.begin(), triangles.end(), 0u);
  std::ranges::stable_sort(triangles, {}, [&](std::uint32_t t) { return orderOf(block, t); });
  return triangles;
}

}  // namespace

class DeviceBricks::Inside {
 public:
  explicit Inside(std::uint64_t most) : device_(kWords), most_(most), embree_(makeDevice()) {}

  void hold(const std::shared_ptr<const World>& world) {
    if (world_.lock() == world) return;
    world_.reset();
    const TriangleBlock& block = world->baked;
    const WideHierarchy hierarchy = wideHierarchyOf(embree_.get(), block);
    triangles_ = orderedTriangles(block);
    std::vector<std::uint32_t> placeOf(triangles_.size());
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) placeOf[triangles_[i]] = i;
    std::vector<DeviceWord> words(3 * hierarchy.primitives.size());
    parallelFor(hierarchy.primitives.size(), kGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t t = hierarchy.primitives[i];
        std::ranges::copy(cornerWords(block, t, {placeOf[t], 0, 0}), &words[3 * i]);
      }
    });
    holdTable(device_, nodes_, Uint32x4, std::as_bytes(std::span(hierarchy.nodes)), most_, "scene's hierarchy");
    holdTable(device_, corners_, Uint32x4, std::as_bytes(std::span(words)), most_, "scene's triangles");
    world_ = world;
  }

  void centres(std::span<const BrickPlace> places, std::span<float> distances) {
    device_.atOnce([&] {
      holdPlaces(places);
      blocks_.reserve(places.size() * sizeof(std::uint32_t));
      run(findCentres_, places.size(), {&places_, &blocks_});
      read(blocks_, std::as_writable_bytes(distances));
    });
    for (float& distance : distances) {
      if (std::bit_cast<std::uint32_t>(distance) == kLeftBrick) distance = std::numeric_limits<float>::quiet_NaN();
    }
  }

  void make(std::span<const BrickPlace> places, bool lists, const std::function<void(std::size_t, const Made&)>& take) {
    for (std::size_t first = 0; first < places.size(); first += kBricksAtOnce) {
      const std::size_t count = std::min(kBricksAtOnce, places.size() - first);
      makeSome(places.subspan(first, count), lists, [&](std::size_t i, const Made& made) { take(first + i, made); });
    }
  }

  const ComputeDevice& device() const { return device_; }

 private:
  void makeSome(std::span<const BrickPlace> places, bool lists,
                const std::function<void(std::size_t, const Made&)>& take) {
    const std::size_t corners = places.size() * kCornersPerBrick;
    made_.resize(2 * corners);
    device_.atOnce([&] {
      holdPlaces(places);
      blocks_.reserve(places.size() * kBlocksPerBrick * sizeof(std::uint32_t));
      brick_.reserve(made_.size() * sizeof(std::uint32_t));
      run(findBlocks_, places.size() * kBlocksPerBrick, {&places_, &blocks_});
      run(findCorners_, corners, {&places_, &blocks_, &brick_});
      lists_.reserve(16);  // buffers without storage cannot be bound
      if (lists) run(countLists_, corners, {&places_, &brick_, &lists_});
      read(brick_, std::as_writable_bytes(std::span(made_)));
    });
    std::vector<std::size_t> firstList(places.size() + 1);
    if (lists) makeLists(places.size(), firstList);
    parallelFor(places.size(), 8, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        const std::span<std::uint32_t> words = std::span(made_).subspan(2 * kCornersPerBrick * i, 2 * kCornersPerBrick);
        const std::span<std::uint32_t> listed =
            std::span(entries_).subspan(firstList[i], firstList[i + 1] - firstList[i]);
        Made made{false, words, listed};
        const auto triangleAt = [&](std::uint32_t place) {
          const bool known = place < triangles_.size();  // a device that errs may name anything
          made.left = made.left || !known;
          return known ? triangles_[place] : 0;
        };
        for (std::uint32_t& entry : listed) entry = triangleAt(entry & ~kLastOfList) | (entry & kLastOfList);
        for (std::size_t c = 0; c < kCornersPerBrick; ++c) {
          std::uint32_t& word = words[2 * c + 1];
          made.left = made.left || words[2 * c] == kLeftBrick;
          if (word != kNoWord) word = lists ? word - static_cast<std::uint32_t>(firstList[i]) : triangleAt(word);
        }
        take(i, made);
      }
    });
  }

  // Turns the numbers of triangles in made_ into the places of their lists, and fetches these.
  void makeLists(std::size_t bricks, std::vector<std::size_t>& firstList) {
    std::uint64_t next = 0;
    ends_.clear();
    for (std::size_t i = 0; i < bricks; ++i) {
      firstList[i] = next;
      for (std::size_t c = kCornersPerBrick * i; c < kCornersPerBrick * (i + 1); ++c) {
        std::uint32_t& word = made_[2 * c + 1];
        if (word == kNoWord) continue;
        const std::uint32_t entries = word;
        word = static_cast<std::uint32_t>(next);
        next += entries;
        ends_.push_back(next);
      }
    }
    firstList[bricks] = next;
    const std::uint64_t bytes = next * sizeof(std::uint32_t);
    checkTable(device_, Uint32, bytes, std::min(most_, device_.mostBufferBytes()),
               "lists of triangles of " + std::to_string(bricks) + " bricks",
               ": take larger voxels, or 'refine: normal'");
    entries_.resize(next);
    if (next == 0) return;
    device_.atOnce([&] {
      lists_.reserve(bytes);
      const ComputeBuffer::Source places{0, std::as_bytes(std::span(made_))};
      brick_.write({&places, 1});
      run(fillLists_, bricks * kCornersPerBrick, {&places_, &brick_, &lists_});
      read(lists_, std::as_writable_bytes(std::span(entries_)));
    });
    parallelFor(ends_.size(), 256, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const auto list = std::span(entries_).first(ends_[i]).subspan(i == 0 ? 0 : ends_[i - 1]);
        if (list.size() > kMostSorted) std::ranges::sort(list);
        list.back() |= kLastOfList;
      }
    });
  }

  void holdPlaces(std::span<const BrickPlace> places) {
    const std::vector<BrickPlaceWords> words = wordsOf(places);
    places_.hold(std::span(words));
  }

  static void read(const ComputeBuffer& buffer, std::span<std::byte> bytes) {
    const ComputeBuffer::Target all{0, bytes};
    buffer.read({&all, 1});
  }

  void run(ComputeProgram& program, std::size_t invocations, std::initializer_list<const ComputeBuffer*> buffers) {
    program.run(invocations, buffers, {}, {{&nodes_, Uint32x4}, {&corners_, Uint32x4}});
  }

  ComputeDevice device_;
  const std::uint64_t most_;
  DeviceHandle embree_;
  ComputeProgram findCentres_{device_, "bricks' centres", brickCentresShader()};
  ComputeProgram findBlocks_{device_, "bricks' blocks", brickBlocksShader()};
  ComputeProgram findCorners_{device_, "bricks' corners", brickCornersShader()};
  ComputeProgram countLists_{device_, "bricks' counts", brickCountsShader()};
  ComputeProgram fillLists_{device_, "bricks' lists", brickListsShader()};
  ComputeBuffer nodes_{device_}, corners_{device_}, places_{device_}, blocks_{device_}, brick_{device_},
      lists_{device_};
  std::weak_ptr<const World> world_;      // whose triangles are there
  std::vector<std::uint32_t> triangles_;  // by their places in the order of equally near ones

  std::vector<std::uint32_t> made_;     // of the bricks at once: two words a corner
  std::vector<std::uint32_t> entries_;  // their lists
  std::vector<std::size_t> ends_;       // where each list ends
};

DeviceBricks::DeviceBricks(std::uint64_t most) : inside_(std::make_unique<Inside>(most)) {}

DeviceBricks::~DeviceBricks() = default;

void DeviceBricks::hold(const std::shared_ptr<const World>& world) {
  inside_->hold(world);
}

void DeviceBricks::centres(std::span<const BrickPlace> places, std::span<float> distances) {
  inside_->centres(places, distances);
}

void DeviceBricks::make(std::span<const BrickPlace> places, bool lists,
                        const std::function<void(std::size_t, const Made&)>& take) {
  inside_->make(places, lists, take);
}

std::string DeviceBricks::device() const {
  return inside_->device().name();
}

bool DeviceBricks::software() const {
  return inside_->device().software();
}

}  // namespace scanmill
