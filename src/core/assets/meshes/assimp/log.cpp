#include <algorithm>
#include <array>
#include <assimp/DefaultLogger.hpp>
#include <assimp/LogStream.hpp>
#include <string_view>

#include "assets/meshes/assimp/parts.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostProblems = 4;

// Words of errors that do not change what is read.
constexpr std::array<std::string_view, 5> kHarmless{"tangent layer", "binormal layer", "no material assigned",
                                                    "animation", "unsupported chunk"};

class ProblemStream final : public Assimp::LogStream {
 public:
  explicit ProblemStream(std::vector<std::string>& problems) : problems_(problems) {}

  // Takes a line such as "Error, T0: AC3D: Unexpected EOF".
  void write(const char* message) override {
    std::string_view text(message);
    text.remove_prefix(std::min(text.find(": ") + 2, text.size()));
    text = text.substr(0, std::min<std::size_t>(text.find('\n'), 200));
    const std::string problem(text);
    if (problems_.size() == kMostProblems ||
        std::find(problems_.begin(), problems_.end(), problem) != problems_.end() ||
        std::any_of(kHarmless.begin(), kHarmless.end(),
                    [&](std::string_view words) { return text.find(words) != std::string_view::npos; })) {
      return;
    }
    problems_.push_back(problem);
  }

 private:
  std::vector<std::string>& problems_;
};

}  // namespace

ImporterLog::ImporterLog() {
  Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0, nullptr);
  Assimp::DefaultLogger::get()->attachStream(new ProblemStream(problems), Assimp::Logger::Err);
}

ImporterLog::~ImporterLog() {
  Assimp::DefaultLogger::kill();
}

}  // namespace scanmill
