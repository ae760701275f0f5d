// The models that the profiler's plugin runs in the emulator, on sequences with a known outcome.
#include <gtest/gtest.h>

#include "tools/prof/branch_model.h"
#include "tools/prof/cache_model.h"

namespace {

constexpr uint32_t kBeq = 0x54000040, kCbz = 0xb4000040, kTbnz = 0x37000040, kB = 0x14000002;
constexpr uint32_t kBl = 0x94000002, kBr = 0xd61f0000, kBlr = 0xd63f0200, kRet = 0xd65f03c0;
constexpr uint32_t kAdd = 0x91000400;

class CacheModel : public testing::Test {
 protected:
  ~CacheModel() override {
    std::free(l1.lines);
    std::free(l2.lines);
  }
  Cache l1 = {}, l2 = {};
  Streams streams = {};
};

TEST_F(CacheModel, keeps_as_many_lines_of_a_set_as_it_has_ways) {
  cache_init(&l1, 4 * kLineBytes, 2);  // two sets
  EXPECT_FALSE(cache_touch(&l1, 2));
  EXPECT_FALSE(cache_touch(&l1, 4));
  EXPECT_TRUE(cache_touch(&l1, 2));
  EXPECT_FALSE(cache_touch(&l1, 6));  // pushes 4 out, the one not used for longest
  EXPECT_TRUE(cache_touch(&l1, 2));
  EXPECT_FALSE(cache_touch(&l1, 4));
  EXPECT_FALSE(cache_touch(&l1, 3));  // the other set
  EXPECT_TRUE(cache_touch(&l1, 4));
}

TEST_F(CacheModel, every_pass_misses_when_one_line_too_many_goes_round) {
  cache_init(&l1, 48 << 10, 3);
  constexpr uint64_t kLines = (48 << 10) / kLineBytes;
  for (uint64_t line = 0; line < kLines; ++line) EXPECT_FALSE(cache_touch(&l1, 1000 + line));
  for (uint64_t line = 0; line < kLines; ++line) EXPECT_TRUE(cache_touch(&l1, 1000 + line));
  for (int pass = 0; pass < 3; ++pass)
    for (uint64_t way = 0; way < 4; ++way) EXPECT_FALSE(cache_touch(&l1, way * l1.sets));
}

TEST_F(CacheModel, a_sequence_is_prefetched_from_its_third_line_on) {
  cache_init(&l1, 32 << 10, 2);
  cache_init(&l2, 1 << 20, 16);
  streams.used = kStreams;
  EXPECT_EQ(cache_access(&l1, &l2, &streams, 500), kMissL2);
  EXPECT_EQ(cache_access(&l1, &l2, &streams, 501), kMissL2);
  EXPECT_EQ(cache_access(&l1, &l2, &streams, 502), kMissL2Stream);
  EXPECT_EQ(cache_access(&l1, &l2, &streams, 502), kCacheHit);
  EXPECT_EQ(cache_access(&l1, &l2, &streams, 900), kMissL2);  // elsewhere; the sequence goes on
  EXPECT_EQ(cache_access(&l1, &l2, &streams, 503), kMissL2Stream);
}

TEST_F(CacheModel, follows_only_so_many_sequences) {
  streams.used = 2;
  for (uint64_t line = 1; line <= 3; ++line) {
    EXPECT_EQ(streams_follow(&streams, 1000 + line), line == 3);
    EXPECT_EQ(streams_follow(&streams, 2000 - line), line == 3);  // downwards as well
  }
  for (uint64_t line = 1; line <= 3; ++line)
    for (const uint64_t base : {3000, 4000, 5000})
      EXPECT_FALSE(streams_follow(&streams, base + line));
}

TEST_F(CacheModel, what_left_l1_is_found_in_l2) {
  cache_init(&l1, 2 * kLineBytes, 2);
  cache_init(&l2, 1 << 20, 16);
  streams.used = kStreams;
  for (const uint64_t line : {10, 20, 30})
    EXPECT_EQ(cache_access(&l1, &l2, &streams, line), kMissL2);
  EXPECT_EQ(cache_access(&l1, &l2, &streams, 10), kMissL1);
}

TEST(branch_model, knows_what_has_to_be_predicted) {
  for (const uint32_t word : {kBeq, kCbz, kTbnz}) EXPECT_EQ(branch_of(word), kConditional);
  for (const uint32_t word : {kBr, kBlr}) EXPECT_EQ(branch_of(word), kIndirect);
  for (const uint32_t word : {kB, kBl, kRet, kAdd}) EXPECT_EQ(branch_of(word), kStraight);
}

int missed(Predictor& predictor, int runs, bool (*taken)(int run)) {
  int count = 0;
  for (int run = 0; run < runs; ++run)
    count += !predictor_knew(&predictor, kConditional, 0x1000, taken(run) ? 0x800 : 0x1004);
  return count;
}

TEST(branch_model, learns_loops_and_patterns_but_not_chance) {
  Predictor predictor = {};
  EXPECT_LE(missed(predictor, 1000, [](int) { return true; }), 2 * kHistoryBits + 2);
  EXPECT_EQ(missed(predictor, 1000, [](int) { return true; }), 0);
  EXPECT_LE(missed(predictor, 1000, [](int run) { return run % 5 != 4; }), 60);
  EXPECT_EQ(missed(predictor, 1000, [](int run) { return run % 5 != 4; }), 0);
  static uint32_t random = 1;
  const int by_chance = missed(predictor, 4000, [](int) {
    random = random * 1664525u + 1013904223u;
    return random >> 31 != 0;
  });
  EXPECT_GT(by_chance, 1600);
  EXPECT_LT(by_chance, 2400);
}

TEST(branch_model, an_indirect_jump_goes_where_it_went_last) {
  Predictor predictor = {};
  EXPECT_FALSE(predictor_knew(&predictor, kIndirect, 0x1000, 0x2000));
  EXPECT_TRUE(predictor_knew(&predictor, kIndirect, 0x1000, 0x2000));
  EXPECT_FALSE(predictor_knew(&predictor, kIndirect, 0x1000, 0x3000));
  EXPECT_TRUE(predictor_knew(&predictor, kStraight, 0x1000, 0x9000));
}

}  // namespace
