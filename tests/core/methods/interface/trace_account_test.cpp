#include "methods/interface/method.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::Pair;

TraceAccount accountOf(double seconds, std::vector<BeamWarning> warnings) {
  TraceAccount account{{{"march", seconds}}, {}};
  for (BeamWarning& warning : warnings) account.warn(std::move(warning));
  return account;
}

TEST(TraceAccount, TheWorstScanIsToldWhateverTheOrder) {
  const TraceAccount a = accountOf(1, {{"top", 1, 5, "5 left"}, {"rear", 2, 1, "1 touches"}});
  const TraceAccount b = accountOf(2, {{"top", 1, 9, "9 left"}, {"top", 0, 2, "2 exhausted"}});
  const TraceAccount c = accountOf(4, {{"top", 1, 7, "7 left"}});
  const std::vector<std::vector<TraceAccount>> orders{{a, b, c}, {c, b, a}, {b, a, c}};
  for (const std::vector<TraceAccount>& order : orders) {
    TraceAccount sum;
    for (const TraceAccount& account : order) sum += account;
    EXPECT_THAT(sum.seconds, ElementsAre(Pair("march", 7)));
    EXPECT_THAT(sum.warningTexts(), ElementsAre("1 touches", "2 exhausted", "9 left"));
  }
}

}  // namespace
}  // namespace scanmill
