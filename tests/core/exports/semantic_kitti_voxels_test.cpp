#include <cstdlib>
#include <random>

#include "dataset/voxels.h"
#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

ScanVoxels emptyGrid(const std::array<std::uint32_t, 3>& counts, const Vec3d& low) {
  ScanVoxels voxels;
  voxels.grid = {1, low, counts};
  voxels.label.resize(voxels.grid.voxels());
  for (auto* flags : {&voxels.input, &voxels.invalid, &voxels.unseen}) flags->resize(voxels.grid.voxels());
  return voxels;
}

template <class Visit>
void forVoxels(const VoxelGrid& grid, const Visit& visit) {
  for (std::uint32_t x = 0; x < grid.counts[0]; ++x) {
    for (std::uint32_t y = 0; y < grid.counts[1]; ++y) {
      for (std::uint32_t z = 0; z < grid.counts[2]; ++z) visit(x, y, z, grid.index(x, y, z));
    }
  }
}

// All behind a wall, and nothing before it.
TEST(OccludedVoxels, OfAWallAreThoseBehindIt) {
  ScanVoxels voxels = emptyGrid({20, 30, 8}, {0, -15, -2});
  forVoxels(voxels.grid, [&](std::uint32_t x, auto, auto, std::size_t i) { voxels.label[i] = x == 7 ? 50 : 0; });
  const std::vector<std::uint8_t> occluded = occludedVoxels(voxels);
  forVoxels(voxels.grid, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z, std::size_t i) {
    // Lines that come from beside the grid or above it pass the wall where there is no grid.
    const double share = 7.5 / (x + 0.5);
    const double wallY = (y - 14.5) * share, wallZ = (z - 1.5) * share;
    if (std::fabs(wallY) > 14 || wallZ < -1 || wallZ > 5) return;
    EXPECT_EQ(occluded[i], x > 7 ? 1 : 0) << x << " " << y << " " << z;
  });
}

// Against lines that are followed in small steps: where no voxel about such a line is full, none is in the way, and
// where a line goes through the middle of something large, that is.
TEST(OccludedVoxels, FollowLinesOfSight) {
  ScanVoxels voxels = emptyGrid({40, 40, 16}, {-20, -20, -8});
  std::mt19937 random(5);
  for (int box = 0; box < 12; ++box) {
    const auto from = [&](std::uint32_t count) { return static_cast<std::uint32_t>(random() % (count - 4)); };
    const std::uint32_t x = from(40), y = from(40), z = from(16);
    if (std::abs(static_cast<int>(x) - 18) < 5 && std::abs(static_cast<int>(y) - 18) < 5) continue;  // about the sensor
    for (std::uint32_t i = 0; i < 64; ++i) {
      voxels.input[voxels.grid.index(x + i / 16, y + i / 4 % 4, z + i % 4)] = 1;
    }
  }
  const auto isFull = [&](const Vec3d& p) {
    const auto in = [](double value, std::uint32_t count) { return value >= 0 && value < count; };
    return in(p.x, 40) && in(p.y, 40) && in(p.z, 16) &&
           voxels.input[voxels.grid.index(static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y),
                                          static_cast<std::uint32_t>(p.z))] != 0;
  };
  const std::vector<std::uint8_t> occluded = occludedVoxels(voxels);
  const Vec3d sensor = voxels.grid.inVoxels({});
  std::size_t clear = 0, hidden = 0;
  forVoxels(voxels.grid, [&](std::uint32_t x, std::uint32_t y, std::uint32_t z, std::size_t i) {
    const Vec3d middle{x + 0.5, y + 0.5, z + 0.5};
    const double distance = length(middle - sensor);
    int most = 0;  // full voxels about the line
    for (double along = 0; along < distance; along += 0.2) {
      const Vec3d p = sensor + (middle - sensor) * (along / distance);
      int full = 0;
      for (int around = 0; around < 27; ++around) {
        full += isFull(p + Vec3d{around / 9 - 1.0, around / 3 % 3 - 1.0, around % 3 - 1.0}) ? 1 : 0;
      }
      most = std::max(most, full);
    }
    if (most == 0) {
      ++clear;
      EXPECT_EQ(occluded[i], 0) << x << " " << y << " " << z;
    } else if (most == 27 && !isFull(middle)) {
      ++hidden;
      EXPECT_EQ(occluded[i], 1) << x << " " << y << " " << z;
    }
  });
  EXPECT_GT(clear, 5000u);
  EXPECT_GT(hidden, 100u);
}

class VoxelExport : public ExportWorld {
 protected:
  VoxelExport() {
    use("semantic_kitti");
    voxels_ = emptyGrid({6, 5, 4}, {0, -2.5, -2});
    std::mt19937 random(1);
    for (std::size_t i = 0; i < voxels_.grid.voxels(); ++i) {
      voxels_.label[i] = random() % 3 == 0 ? classId("building") : random() % 5 == 0 ? classId("car") : 0;
      voxels_.input[i] = random() % 2;
      voxels_.invalid[i] = random() % 4 == 0;
    }
  }
  ScanVoxels voxels_;
};

// Unpacked as the API does: by numpy, the highest bit first, x slowest.
TEST_F(VoxelExport, IsReadAsTheApiDoes) {
  const std::unique_ptr<ExportLayout> layout = makeSemanticKitti();
  writeChanged(*layout, 1, 0, [](const ExportSample&) {});
  writeChanged(*layout, 1, 1, [&](ExportSample& changed) { changed.voxels = voxels_; });
  EXPECT_EQ(written().size(), 2u + 6u) << "only the second sample has voxels";
  std::string input, label;
  for (std::size_t i = 0; i < voxels_.grid.voxels(); ++i) {
    input += voxels_.input[i] != 0 ? '1' : '0';
    label += voxels_.label[i] == 0 ? '0' : voxels_.label[i] == classId("car") ? 'c' : 'b';
  }
  const std::string printed = python(R"(
path = folder / 'sequences/08/voxels'
def flags(name):
    return np.unpackbits(np.fromfile(path / name, np.uint8))[:120].reshape(6, 5, 4)
label = np.fromfile(path / '000001.label', np.uint16).reshape(6, 5, 4)
assert set(np.unique(label)) == {0, 10, 50}, np.unique(label)
print(''.join(map(str, flags('000001.bin').ravel())))
print(''.join({0: '0', 10: 'c', 50: 'b'}[int(i)] for i in label.ravel()))
assert flags('000001.invalid').sum() > 10 and flags('000001.occluded').sum() > 10
)");
  EXPECT_EQ(printed, input + "\n" + label + "\n");
}

}  // namespace
}  // namespace scanmill
