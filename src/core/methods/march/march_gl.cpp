// Marches particles by a compute shader. Fields and triangles stay on the device between calls; particles go there and
// hit records come back, a slice at a time.

#include "methods/march/march_gl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <exception>
#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "gpu/compute.h"
#include "gpu/device.h"

namespace scanmill {

namespace {

using enum ComputeTable::Texel;

const ComputeErrorWords kWords{"particles cannot fly by OpenGL", "'backend: cpu' does without it"};

// As the shader declares it, by the rules of std140.
struct MarchBlock {
  std::int32_t lastLevel;
  float perReach;
  float metres;
  std::uint32_t steps;
  std::uint32_t count;
  std::uint32_t unused[3];
};
static_assert(sizeof(MarchBlock) == 32);

MarchBlock marchBlock(const DistanceField& field, std::uint32_t steps, std::size_t count) {
  MarchBlock block{};
  block.lastLevel = static_cast<std::int32_t>(field.levels.size()) - 1;
  block.perReach = 1.0f / field.shape.reach;
  block.metres = static_cast<float>(field.shape.voxel);
  block.steps = steps;
  block.count = static_cast<std::uint32_t>(count);
  return block;
}

// Bits of the offset and the first entry of the table, then the bricks.
using DeviceLevel = std::array<std::uint32_t, 8>;

std::vector<DeviceLevel> deviceLevels(const DistanceField& field) {
  std::vector<DeviceLevel> made;
  for (const FieldLevel& level : field.levels) {
    const auto bits = [&](std::size_t k) { return std::bit_cast<std::uint32_t>(level.offset[k]); };
    made.push_back({bits(0), bits(1), bits(2), level.firstEntry, level.bricks[0], level.bricks[1], level.bricks[2], 0});
  }
  return made;
}

using Columns = std::vector<const std::vector<float>*>;

Columns columnsOf(const Particles& p, bool lists) {
  if (!lists) return {&p.ox, &p.oy, &p.oz, &p.dx, &p.dy, &p.dz, &p.begin, &p.end};
  return {&p.ox, &p.oy, &p.oz, &p.dx, &p.dy, &p.dz, &p.begin, &p.end, &p.wx, &p.wy, &p.wz, &p.ix, &p.iy, &p.iz};
}

// A corner and the two edges from it.
using DeviceTriangle = std::array<std::array<float, 4>, 3>;

std::vector<DeviceTriangle> deviceTriangles(const TriangleBlock& block) {
  std::vector<DeviceTriangle> made(block.corners.size());
  parallelFor(made.size(), 16384, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      const Triangle& corners = block.corners[t];
      const Vec3f a = block.vertices[corners[0]];
      const Vec3f ab = block.vertices[corners[1]] - a;
      const Vec3f ac = block.vertices[corners[2]] - a;
      made[t] = {{{a.x, a.y, a.z, 0}, {ab.x, ab.y, ab.z, 0}, {ac.x, ac.y, ac.z, 0}}};
    }
  });
  return made;
}

class ComputeMarcher : public GlMarcher {
 public:
  explicit ComputeMarcher(const GlMarcherLimits& limits)
      : device_(kWords),
        mostTableBytes_(limits.tableBytes),
        slice_(std::min<std::uint64_t>(device_.mostBufferBytes() / (kMostColumns * sizeof(float)), limits.particles)) {
    // Buffers without storage cannot be read from.
    for (ComputeBuffer* buffer : {&table_, &distances_, &words_, &lists_, &triangles_}) buffer->reserve(16);
  }

  void march(std::shared_ptr<const DistanceField> field, std::shared_ptr<const World> world, std::uint32_t steps,
             const Particles& particles, HitRecords& records, StageClock& clock) override {
    const std::scoped_lock lock(mutex_);
    records.reset(particles.size());
    if (particles.size() == 0) return;
    upload(field, world, clock);
    for (std::size_t first = 0; first < particles.size(); first += slice_) {
      const std::size_t count = std::min<std::size_t>(slice_, particles.size() - first);
      marchSlice(*field, steps, particles, first, count, clock);
      const StageTimer timer(clock, "read_back");
      readRecords(*field, records, first, count);
    }
  }

  std::string device() const override { return device_.name(); }

 private:
  static constexpr std::uint64_t kMostColumns = 14;

  ComputeProgram& programOf(bool lists) {
    std::unique_ptr<ComputeProgram>& program = programs_[lists ? 1 : 0];
    if (program == nullptr) program = std::make_unique<ComputeProgram>(device_, "particle", marchShader(lists));
    return *program;
  }

  void upload(const std::shared_ptr<const DistanceField>& field, const std::shared_ptr<const World>& world,
              StageClock& clock) {
    const StageTimer timer(clock, "upload");
    const bool newField = field_.lock() != field;
    const bool newWorld = field->shape.lists && world_.lock() != world;
    if (!newField && !newWorld) return;
    if (newField) {
      field_.reset();  // what is there is of no field until all is there
      const std::string mend = "take coarser voxels (voxel_m) or fewer levels";
      const std::vector<DeviceLevel> levels = deviceLevels(*field);
      hold(levels_, Uint32x4, std::span(levels), "levels", mend);
      hold(table_, Uint32, std::span(field->table), "table of bricks", mend);
      hold(distances_, Uint16, std::span(field->distance), "distances", mend);
      hold(words_, Uint32, std::span(field->word), "triangles named at corners", mend);
      hold(lists_, Uint32, std::span(field->lists), "lists of triangles", mend);
      field_ = field;
    }
    if (newWorld) {
      world_.reset();
      const std::vector<DeviceTriangle> triangles = deviceTriangles(world->baked);
      hold(triangles_, Float32x4, std::span(triangles), "scene's triangles",
           "take 'refine: normal', which does not look at them");
      world_ = world;
    }
    device_.finish();
  }

  template <class T>
  void hold(ComputeBuffer& buffer, ComputeTable::Texel texel, std::span<const T> array, const char* what,
            const std::string& mend) {
    const std::uint64_t most = std::min(mostTableBytes_, device_.mostTableTexels() * texelBytes(texel));
    if (array.size_bytes() > most) {
      constexpr double kMebi = 1 << 20;
      device_.fail(fmt::format("the {} take {:.1f} MiB, of which a table on {} holds {:.1f} MiB: {}", what,
                               static_cast<double>(array.size_bytes()) / kMebi, device_.name(),
                               static_cast<double>(most) / kMebi, mend));
    }
    if (!array.empty()) buffer.hold(array);
  }

  void marchSlice(const DistanceField& field, std::uint32_t steps, const Particles& particles, std::size_t first,
                  std::size_t count, StageClock& clock) {
    const StageTimer timer(clock, "march");
    const Columns columns = columnsOf(particles, field.shape.lists);
    particles_.reserve(columns.size() * count * sizeof(float));
    records_.reserve(5 * count * sizeof(float));
    std::vector<ComputeBuffer::Source> pieces;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      pieces.push_back({k * count * sizeof(float), std::as_bytes(std::span(*columns[k]).subspan(first, count))});
    }
    particles_.write(pieces);
    const MarchBlock block = marchBlock(field, steps, count);
    programOf(field.shape.lists)
        .run(count, {&particles_, &records_}, std::as_bytes(std::span(&block, 1)),
             {{&levels_, Uint32x4},
              {&table_, Uint32},
              {&distances_, Uint16},
              {&words_, Uint32},
              {&lists_, Uint32},
              {&triangles_, Float32x4}});
    device_.finish();
  }

  void readRecords(const DistanceField& field, HitRecords& records, std::size_t first, std::size_t count) {
    const std::size_t bytes = count * sizeof(float);
    const auto part = [&](auto& column) { return std::as_writable_bytes(std::span(column).subspan(first, count)); };
    std::vector<ComputeBuffer::Target> pieces{
        {0, part(records.way)}, {bytes, part(records.triangle)}, {2 * bytes, part(records.outcome)}};
    if (field.shape.lists) {
      numerator_.resize(count);
      denominator_.resize(count);
      pieces.push_back({3 * bytes, std::as_writable_bytes(std::span(numerator_))});
      pieces.push_back({4 * bytes, std::as_writable_bytes(std::span(denominator_))});
    }
    records_.read(pieces);
    if (!field.shape.lists) return;
    const auto metres = static_cast<float>(field.shape.voxel);
    parallelFor(count, 65536, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        if (records.outcomeOf(first + i) != Outcome::Hit) continue;
        records.way[first + i] += numerator_[i] / (denominator_[i] * metres);
      }
    });
  }

  std::mutex mutex_;
  ComputeDevice device_;
  const std::uint64_t mostTableBytes_;
  const std::uint64_t slice_;
  std::array<std::unique_ptr<ComputeProgram>, 2> programs_;  // made when first needed
  ComputeBuffer particles_{device_};
  ComputeBuffer levels_{device_};
  ComputeBuffer table_{device_};
  ComputeBuffer distances_{device_};
  ComputeBuffer words_{device_};
  ComputeBuffer lists_{device_};
  ComputeBuffer triangles_{device_};
  ComputeBuffer records_{device_};
  std::weak_ptr<const DistanceField> field_;  // whose data the buffers hold
  std::weak_ptr<const World> world_;
  std::vector<float> numerator_;  // of the slice
  std::vector<float> denominator_;
};

// Whether the kernel knows of a graphics card: loading OpenGL to ask would cost more than most scans, and
// OpenGL on the processor is slower than its own lanes (docs/particle.md).
bool kernelHasCard() {
  for (const std::string_view file : {"/dev/nvidiactl", "/dev/dxg"}) {
    if (std::filesystem::exists(file)) return true;
  }
  const std::filesystem::path folder = "/dev/dri";
  if (!std::filesystem::is_directory(folder)) return false;
  const std::filesystem::directory_iterator files(folder);
  return std::any_of(begin(files), end(files),
                     [](const auto& file) { return file.path().filename().string().starts_with("renderD"); });
}

}  // namespace

std::unique_ptr<GlMarcher> makeGlMarcher(const GlMarcherLimits& limits) {
  return std::make_unique<ComputeMarcher>(limits);
}

std::unique_ptr<GlMarcher> makeGlMarcher() {
  return makeGlMarcher(GlMarcherLimits{});
}

std::unique_ptr<GlMarcher> findGlMarcher() {
  try {
    return kernelHasCard() || !namedDevice().empty() ? makeGlMarcher() : nullptr;
  } catch (const std::exception&) {
    return nullptr;
  }
}

}  // namespace scanmill
