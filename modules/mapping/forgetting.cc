#include "modules/mapping/forgetting.h"

#include <algorithm>
#include <tuple>

#include "core/base/assert.h"

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
  size_t least = map.size() - 1;
  for (size_t i = 0; i + kept < map.size(); ++i) {
    const Keyframe& one = map.keyframe(i);
    const bool first = least == map.size() - 1;
    if (!one.kept && (first || one.worth < map.keyframe(least).worth)) least = i;
  }
  PIRVS_ASSERT(least !=
               map.size() - 1);  // make_room_to_localise() has left more room than a window
  return least;
}

namespace {

// Of those last seen before keyframe `recent`, up to `count` with the fewest views leave.
uint32_t forget_weakest(Pool<Landmark, kLandmarksMax>& points, uint32_t recent, size_t count) {
  FixedVector<uint16_t, kLandmarksMax> slots;
  for (size_t slot = 0; slot < points.capacity(); ++slot) {
    const Landmark* landmark = points.at(slot);
    if (landmark == nullptr || landmark->kept || landmark->last_keyframe >= recent) continue;
    (void)slots.push_back(static_cast<uint16_t>(slot));
  }
  const auto strength = [&](uint16_t slot) {
    const Landmark& landmark = *points.at(slot);
    return std::make_tuple(landmark.views, landmark.last_keyframe, slot);
  };
  count = std::min(slots.size(), count);
  std::nth_element(slots.begin(), slots.begin() + count, slots.end(),
                   [&](uint16_t a, uint16_t b) { return strength(a) < strength(b); });
  for (size_t i = 0; i < count; ++i) (void)points.release(points.handle(slots[i]));
  return static_cast<uint32_t>(count);
}

}  // namespace

uint32_t forget_points(WorkingMap& map, size_t window) {
  constexpr size_t kRoom = kCamerasMax * kTracksMax;
  auto& points = map.points();
  if (points.size() + kRoom <= points.capacity()) return 0;
  const uint32_t recent = map.keyframe(map.size() - std::min(map.size(), window)).sequence;
  return forget_weakest(points, recent, 2 * kRoom);  // once in a few keyframes
}

void keep_all(WorkingMap& map) {
  constexpr size_t kPoints = kLandmarksMax * 3 / 4, kKeyframes = kKeyframesMax * 3 / 4;
  size_t next = 0;
  for (size_t n = 0; n < map.size(); n += kWeighedAtOnce) weigh_keyframes(map, next);
  while (map.size() > kKeyframes) {
    map.remove(least_useful(map, 0));
    weigh_keyframes(map, next);  // what is left is worth more
  }
  auto& points = map.points();
  if (points.size() > kPoints) {
    (void)forget_weakest(points, UINT32_MAX, points.size() - kPoints);
  }
  for (size_t i = 0; i < map.size(); ++i) map.keyframe(i).kept = true;
  for (size_t slot = 0; slot < points.capacity(); ++slot) {
    if (points.at(slot) != nullptr) points.at(slot)->kept = true;
  }
}

uint32_t remove_weak_points(WorkingMap& map) {
  const uint32_t newest = map.newest().sequence;
  auto& points = map.points();
  uint32_t removed = 0;
  for (size_t slot = 0; slot < points.capacity(); ++slot) {
    const Landmark* landmark = points.at(slot);
    if (landmark == nullptr) continue;
    const uint16_t wanted = newest - landmark->last_keyframe > 2 ? 3 : 2;
    if (landmark->views >= wanted || landmark->kept) continue;
    (void)points.release(points.handle(slot));
    ++removed;
  }
  return removed;
}

}  // namespace pirvs
