#include "modules/map/map_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

#include "modules/map/nodes.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;

struct File {
  std::vector<uint8_t> bytes;
  size_t at = 0;

  MapSink sink() {
    return {this, [](void* file, const void* data, size_t size) {
              auto& to = static_cast<File*>(file)->bytes;
              const auto* from = static_cast<const uint8_t*>(data);
              to.insert(to.end(), from, from + size);
              return Status::kOk;
            }};
  }
  MapSource source() {
    at = 0;
    return {this, [](void* file, void* data, size_t size) {
              File& self = *static_cast<File*>(file);
              if (self.bytes.size() - self.at < size) return Status::kBadData;
              std::memcpy(data, self.bytes.data() + self.at, size);
              self.at += size;
              return Status::kOk;
            }};
  }
};

// Points with holes between them, two keyframes that see some of them in both cameras.
std::unique_ptr<Map> some_map() {
  auto map = std::make_unique<Map>();
  Random random(5);
  std::vector<LandmarkId> ids;
  for (int i = 0; i < 40; ++i) {
    ids.push_back(map->landmarks.acquire().value());
    Landmark& point = *map->landmarks.find(ids.back());
    point.p_W = random.vec(3);
    point.cov = random.spd<3>(0.01);
    point.view_W = random.vec(1).normalized();
    point.distance_m = float(random.uniform(1, 5));
    point.descriptor.w[2] = uint64_t(i) * 77;
    point.first_keyframe = 1;
    point.last_keyframe = 2;
    point.epoch = 3;
  }
  for (int i = 0; i < 40; i += 5) (void)map->landmarks.release(ids[size_t(i)]);
  for (uint32_t k = 1; k <= 2; ++k) {
    Keyframe& keyframe = *map->keyframes.find(map->keyframes.acquire().value());
    keyframe.sequence = k;
    keyframe.epoch = 3;
    keyframe.state = random.state();
    keyframe.error = random.spd<6>(0.1);
    for (int c = 0; c < kCamerasMax; ++c) {
      for (int i = 0; i < 40; ++i) {
        Observation& o = *keyframe.observations[c].append();
        o = Observation{};
        o.landmark = ids[size_t(i)];
        o.x = float(i + 100 * c);
        o.stereo = int16_t(i);
        if (Landmark* point = map->landmarks.find(o.landmark)) ++point->views;
      }
    }
  }
  for (const char* name : {"dock", "shelf-2"}) {
    EXPECT_EQ(set_node(*map, name, random.state().T_WB, 3), Status::kOk);
  }
  return map;
}

MapIndex index;

TEST(map_file, brings_back_points_keyframes_and_who_sees_what) {
  const auto map = some_map();
  File file;
  ASSERT_EQ(save_map(*map, file.sink(), index), Status::kOk);
  EXPECT_EQ(verify_map(file.source()), Status::kOk);
  auto again = std::make_unique<Map>();
  ASSERT_EQ(load_map(file.source(), *again), Status::kOk);
  EXPECT_EQ(again->landmarks.size(), 32u);
  EXPECT_EQ(again->keyframes.size(), 2u);
  const Keyframe& keyframe = *again->keyframes.at(1);
  EXPECT_EQ(keyframe.sequence, 2u);
  ASSERT_EQ(keyframe.observations[0].size(), 32u) << "those of released points stay behind";
  for (size_t i = 0; i < 32; ++i) {
    const Observation& left = keyframe.observations[0][i];
    const Observation& right = keyframe.observations[1][size_t(left.stereo)];
    EXPECT_EQ(left.landmark, right.landmark);
    EXPECT_FLOAT_EQ(right.x, left.x + 100);
    const Landmark* point = again->landmarks.find(left.landmark);
    ASSERT_NE(point, nullptr);
    EXPECT_EQ(point->views, 4);
    EXPECT_EQ(point->descriptor.w[2], uint64_t(left.x) * 77);
  }
  for (const char* name : {"dock", "shelf-2"}) {
    const SE3 before = node_pose(*map, name).value(), after = node_pose(*again, name).value();
    EXPECT_EQ((before.p - after.p).norm(), 0) << name;
    EXPECT_EQ((before.R - after.R).norm(), 0) << name;
  }
  File second;
  ASSERT_EQ(save_map(*again, second.sink(), index), Status::kOk);
  EXPECT_TRUE(file.bytes == second.bytes) << "saved again, the same bytes";
}

TEST(map_file, refuses_a_file_cut_off_anywhere) {
  File file;
  ASSERT_EQ(save_map(*some_map(), file.sink(), index), Status::kOk);
  for (size_t size = 0; size < file.bytes.size(); size += 97) {
    File cut;
    cut.bytes.assign(file.bytes.begin(), file.bytes.begin() + std::ptrdiff_t(size));
    EXPECT_NE(verify_map(cut.source()), Status::kOk) << size;
    auto map = std::make_unique<Map>();
    EXPECT_NE(load_map(cut.source(), *map), Status::kOk) << size;
    EXPECT_EQ(map->landmarks.size() + map->keyframes.size(), 0u) << "nothing is left of it";
  }
}

TEST(map_file, refuses_any_damaged_byte) {
  File file;
  ASSERT_EQ(save_map(*some_map(), file.sink(), index), Status::kOk);
  Random random(9);
  for (int i = 0; i < 200; ++i) {
    File damaged = file;
    damaged.bytes[size_t(random.uniform(0, double(file.bytes.size())))] ^= 0x10;
    EXPECT_NE(verify_map(damaged.source()), Status::kOk);
    auto map = std::make_unique<Map>();
    EXPECT_NE(load_map(damaged.source(), *map), Status::kOk);
  }
}

}  // namespace
}  // namespace pirvs
