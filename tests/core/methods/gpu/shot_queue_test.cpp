#include "methods/gpu/shot_queue.h"

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "base/error.h"
#include "tests/support/gl.h"

namespace scanmill {
namespace {

using testing::ElementsAre;

// Goes with others of its kind.
struct Piece {
  int number;
  int kind;
  std::size_t rays() const { return 10; }
  std::uint64_t bytes() const { return 100; }
  bool canShareDispatch(const Piece& other) const { return kind == other.kind; }
};

using Queue = ShotQueue<Piece>;

// Calls `submit` with pieces 0, 1, 2 ... of a queue, each on a thread of its own. The first waits on the device until
// the others stand in the queue. What became of each: where its rays begin in which batch, or what went wrong.
struct QueueOutcome {
  std::size_t from = 0, rays = 0;
  std::string failure;
};

std::vector<QueueOutcome> giveAll(const std::vector<Piece>& pieces, std::uint64_t most,
                                  const std::function<void(const std::vector<int>&)>& given) {
  const ComputeDevice device({"the test cannot run", "there is nothing instead"});
  ComputeBuffer buffer(device);
  buffer.reserve(4096);
  std::atomic<std::size_t> started = 0;
  Queue queue(device, most, [&](const std::vector<const Piece*>& together, Queue::Batch& batch) {
    while (started < pieces.size()) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::vector<int> numbers;
    for (const Piece* piece : together) numbers.push_back(piece->number);
    given(numbers);
    batch.hits.start(buffer, 4096);
  });
  std::vector<QueueOutcome> outcomes(pieces.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    threads.emplace_back([&, i] {
      ++started;
      try {
        const Queue::Submitted made = queue.submit(pieces[i]);
        EXPECT_EQ(made.batch->hits.wait().size(), 4096u);
        outcomes[i] = {made.firstRay, made.batch->rays, ""};
      } catch (const Error& error) {
        outcomes[i].failure = error.what();
      }
    });
    while (started <= i) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // they stand in the queue in this order
  }
  for (std::thread& thread : threads) thread.join();
  return outcomes;
}

TEST(ShotQueue, WhatWaitsGoesTogether) {
  SKIP_WITHOUT_GL();
  std::vector<std::vector<int>> given;
  const auto outcomes = giveAll({{0, 1}, {1, 1}, {2, 2}, {3, 1}, {4, 2}}, 1000,
                                [&](const std::vector<int>& numbers) { given.push_back(numbers); });
  EXPECT_THAT(given, ElementsAre(std::vector{0}, std::vector{1, 3}, std::vector{2, 4}));
  EXPECT_EQ(outcomes[3].from, 10u);
  EXPECT_EQ(outcomes[3].rays, 20u);
  EXPECT_EQ(outcomes[2].from, 0u);
}

TEST(ShotQueue, OnlySoMuchGoesTogether) {
  SKIP_WITHOUT_GL();
  std::vector<std::size_t> sizes;
  giveAll({{0, 1}, {1, 1}, {2, 1}, {3, 1}, {4, 1}, {5, 1}}, 300,
          [&](const std::vector<int>& numbers) { sizes.push_back(numbers.size()); });
  EXPECT_THAT(sizes, ElementsAre(1, 3, 2));
}

// More than batches may be in flight, so that each must be let go as soon as it has its own.
TEST(ShotQueue, WhatDoesNotGoTogetherIsTriedAlone) {
  SKIP_WITHOUT_GL();
  const std::vector<Piece> pieces{{0, 1}, {1, 1}, {2, 1}, {3, 1}, {4, 1}, {5, 1}, {6, 1}};
  const auto outcomes = giveAll(pieces, 1000, [&](const std::vector<int>& numbers) {
    if (numbers.size() > 1) throw Error("memory is out");
    if (numbers.front() == 4) throw Error("this one fails");
  });
  for (const Piece& piece : pieces) {
    const QueueOutcome& outcome = outcomes[static_cast<std::size_t>(piece.number)];
    EXPECT_EQ(outcome.failure, piece.number == 4 ? "this one fails" : "");
    EXPECT_EQ(outcome.rays, piece.number == 4 ? 0u : 10u);
  }
}

}  // namespace
}  // namespace scanmill
