#include "bsp/linux/disk_sync.h"

#include <gtest/gtest.h>

#include "bsp/api/clock.h"
#include "bsp/linux/clock.h"

namespace pirvs::bsp {
namespace {

constexpr TimeNs kMs = 1'000'000;

TEST(disk_sync, flushes_from_when_there_is_something_to_its_end) {
  DiskSync sync;
  sync.begin();  // of nothing
  ASSERT_EQ(sync.start("no such folder", kMs), Status::kOk);
  sync.begin();
  sync.stop();
  EXPECT_EQ(sync.flushes(), 0u);
  ASSERT_EQ(sync.start(".", 5 * kMs), Status::kOk);
  sleep_until(now() + 50 * kMs);
  EXPECT_EQ(sync.flushes(), 0u) << "nothing is recorded";
  sync.begin();
  sync.begin();
  const TimeNs late = now() + 60'000 * kMs;  // a disk may be busy with something else
  while (sync.flushes() < 3 && now() < late) sleep_until(now() + 5 * kMs);
  const uint32_t before = sync.flushes();
  EXPECT_GE(before, 3u);
  sync.stop();
  EXPECT_GT(sync.flushes(), before) << "a last one";
  ASSERT_EQ(sync.start(".", 5 * kMs), Status::kOk);
  const uint32_t again = sync.flushes();
  sync.stop();
  EXPECT_EQ(sync.flushes(), again) << "nothing was recorded";
}

}  // namespace
}  // namespace pirvs::bsp
