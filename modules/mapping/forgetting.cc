#include "modules/mapping/forgetting.h"

#include <algorithm>
#include <tuple>

namespace pirvs {

void weigh_keyframes(WorkingMap& map, size_t& next) {
  for (size_t n = 0; n < kWeighedAtOnce; ++n) {
    next = next + 1 < map.size() ? next + 1 : 0;
    Keyframe& weighed = map.keyframe(next);
    weighed.worth = 0;
    map.for_each_sighting(weighed, [&](int, Observation&, const Landmark& landmark) {
      weighed.worth += 1.0f / static_cast<float>(landmark.views);
    });
  }
}

size_t least_useful(const WorkingMap& map, size_t window) {
  const size_t kept = window + 1;  // the prior stands on one of them
  size_t least = 0;
  for (size_t i = 1; i + kept < map.size(); ++i) {
    if (map.keyframe(i).worth < map.keyframe(least).worth) least = i;
  }
  return least;
}

uint32_t forget_points(WorkingMap& map, size_t window) {
  constexpr size_t kRoom = kCamerasMax * kTracksMax;
  auto& points = map.points();
  if (points.size() + kRoom <= points.capacity()) return 0;
  const size_t recent = std::min(map.size(), window);
  const uint32_t recent_sequence = map.keyframe(map.size() - recent).sequence;
  FixedVector<uint16_t, kLandmarksMax> slots;
  for (size_t slot = 0; slot < points.capacity(); ++slot) {
    const Landmark* landmark = points.at(slot);
    if (landmark == nullptr || landmark->last_keyframe >= recent_sequence) continue;
    (void)slots.push_back(static_cast<uint16_t>(slot));
  }
  const auto strength = [&](uint16_t slot) {
    const Landmark& landmark = *points.at(slot);
    return std::make_tuple(landmark.views, landmark.last_keyframe, slot);
  };
  const size_t count = std::min(slots.size(), 2 * kRoom);  // once in a few keyframes
  std::nth_element(slots.begin(), slots.begin() + count, slots.end(),
                   [&](uint16_t a, uint16_t b) { return strength(a) < strength(b); });
  for (size_t i = 0; i < count; ++i) (void)points.release(points.handle(slots[i]));
  return static_cast<uint32_t>(count);
}

uint32_t remove_weak_points(WorkingMap& map) {
  const uint32_t newest = map.newest().sequence;
  auto& points = map.points();
  uint32_t removed = 0;
  for (size_t slot = 0; slot < points.capacity(); ++slot) {
    const Landmark* landmark = points.at(slot);
    if (landmark == nullptr) continue;
    const uint16_t wanted = newest - landmark->last_keyframe > 2 ? 3 : 2;
    if (landmark->views >= wanted) continue;
    (void)points.release(points.handle(slot));
    ++removed;
  }
  return removed;
}

}  // namespace pirvs
