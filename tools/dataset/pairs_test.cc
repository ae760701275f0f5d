#include "tools/dataset/pairs.h"

#include <gtest/gtest.h>

namespace pirvs::tools {
namespace {

constexpr TimeNs kMs = 1'000'000;

std::vector<ListedImage> images(std::initializer_list<double> at_ms) {
  std::vector<ListedImage> out;
  for (const double t : at_ms) out.push_back({TimeNs(t * double(kMs)), std::to_string(t)});
  return out;
}

// Which images each frame has: 1 left, 2 right, 3 both.
std::vector<int> present(const std::vector<PairedImages>& frames) {
  std::vector<int> out;
  for (const PairedImages& f : frames) out.push_back(!f.file[0].empty() + 2 * !f.file[1].empty());
  return out;
}

bool says(const InputLog& log, const std::string& part) {
  for (const std::string& note : log.notes) {
    if (note.find(part) != std::string::npos) return true;
  }
  return false;
}

TEST(pairs, a_constant_distance_is_one_exposure) {
  for (const double apart : {-9.0, -2.16, 0.0, 2.16, 12.0}) {
    InputLog log;
    const auto frames = pair_images(images({0, 50, 100, 150}),
                                    images({apart, 50 + apart, 100 + apart, 150 + apart}), 0, log);
    EXPECT_EQ(present(frames), std::vector<int>(4, 3)) << apart;
    EXPECT_EQ(frames[1].t, 50 * kMs);
    EXPECT_TRUE(log.rejected.empty());
    EXPECT_EQ(log.notes.size(), apart == 0 ? 0u : 1u);
  }
}

TEST(pairs, beyond_a_quarter_of_the_interval_they_play_alone_and_that_is_said) {
  InputLog log;
  const auto frames = pair_images(images({0, 50, 100}), images({20, 70, 120}), 0, log);
  EXPECT_EQ(present(frames), (std::vector<int>{1, 2, 1, 2, 1, 2}));
  EXPECT_EQ(log.counted("frames_without_right"), 3u);
  EXPECT_TRUE(says(log, "within 12.50 ms"));
  EXPECT_TRUE(says(log, "nearest is 20.00 ms"));
  // Unless the calibration says so.
  InputLog quiet;
  EXPECT_EQ(present(pair_images(images({0, 50, 100}), images({20, 70, 120}), 20 * kMs, quiet)),
            std::vector<int>(3, 3));
  EXPECT_TRUE(quiet.notes.empty());
}

TEST(pairs, the_nearest_are_taken) {
  InputLog log;
  // A right image that is late by nearly an interval belongs to the next left one.
  EXPECT_EQ(present(pair_images(images({0, 50, 100}), images({0, 41, 52, 100}), 0, log)),
            (std::vector<int>{3, 2, 3, 3}));
  // Half the rate, and images lost on either side.
  EXPECT_EQ(present(pair_images(images({0, 50, 100, 150}), images({0, 100}), 0, log)),
            (std::vector<int>{3, 1, 3, 1}));
  EXPECT_EQ(present(pair_images(images({50, 100}), images({0, 50, 100, 150}), 0, log)),
            (std::vector<int>{2, 3, 3, 2}));
}

TEST(pairs, cameras_that_run_free_are_told) {
  InputLog log;
  std::vector<ListedImage> left, right;
  for (int i = 0; i < 40; ++i) {
    left.push_back({i * 50 * kMs, "l"});
    right.push_back({i * 50 * kMs + (i % 10) * kMs, "r"});
  }
  EXPECT_EQ(pair_images(left, right, 0, log).size(), 40u);
  EXPECT_TRUE(says(log, "not exposed together"));
}

TEST(pairs, gaps_are_counted_and_the_longest_is_said) {
  InputLog log;
  note_gaps(images({0, 50, 100, 300, 350, 400, 1400, 1450}), "cam0", 20 * kMs, log);
  EXPECT_EQ(log.counted("cam0_gaps"), 2u);
  EXPECT_TRUE(says(log, "the longest 1.000 s, 0.4 s after"));
}

}  // namespace
}  // namespace pirvs::tools
