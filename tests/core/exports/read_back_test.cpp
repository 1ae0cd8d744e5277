// What is exported can be read like scans that somebody recorded.

#include <map>

#include "dataset/scan_store.h"
#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

class ReadBack : public ExportWorld {
 protected:
  // The exported frames, and of each the names of the points' classes by their places.
  void expectSame(const std::string& labels, std::unique_ptr<Layout> layout) {
    use(labels);
    write(*layout);
    const ScanStore store(folder_.path());
    ASSERT_EQ(store.keys().size(), 4u);
    for (std::size_t sample = 0; sample < 4; ++sample) {
      const Scan read = store.decode(sample, store.scans(sample).front());
      const Scan own = scan(0, sample % 2);
      ASSERT_EQ(read.size(), own.size()) << store.keys()[sample];
      std::map<float, std::size_t> byRange;
      for (std::size_t i = 0; i < own.size(); ++i) byRange[rounded(own.position[i])] = i;
      for (std::size_t i = 0; i < read.size(); ++i) {
        const auto found = byRange.find(rounded(read.position[i]));
        ASSERT_NE(found, byRange.end());
        ASSERT_EQ(read[kLabel].empty(), false);
        if (store.ontology() != nullptr) {
          const SemanticClass* const c = store.ontology()->find(read[kLabel][i]);
          ASSERT_NE(c, nullptr);
          const std::uint16_t still = c->movingOf.value_or(c->id);
          ASSERT_EQ(still, plan_.classes.of(own[kLabel][found->second]));
        }
      }
    }
  }
  static float rounded(const Vec3f& p) { return std::round(static_cast<float>(length(Vec3d(p))) * 1000); }
};

TEST_F(ReadBack, SemanticKitti) {
  expectSame("semantic_kitti", makeSemanticKitti());
}

TEST_F(ReadBack, NuScenes) {
  expectSame("nuscenes", makeNuScenes());
}

TEST_F(ReadBack, Npz) {
  expectSame("", makeNpz());
}

TEST_F(ReadBack, Ply) {
  expectSame("", makePly());
}

}  // namespace
}  // namespace scanmill
