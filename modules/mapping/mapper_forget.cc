// What leaves a full map: keyframes and points that are missed least.
#include <algorithm>
#include <tuple>

#include "modules/mapping/mapper.h"

namespace pirvs {

// What would be missed without a keyframe: its points, each by its share of their views. A slice of
// the map each time.
void Mapper::weigh_keyframes() {
  for (size_t n = 0; n < kWeighedAtOnce; ++n) {
    weigh_next_ = weigh_next_ + 1 < order_.size() ? weigh_next_ + 1 : 0;
    Keyframe& weighed = keyframe(weigh_next_);
    weighed.worth = 0;
    for_each_sighting(weighed, [&](int, Observation&, const Landmark& landmark) {
      weighed.worth += 1.0f / static_cast<float>(landmark.views);
    });
  }
}

// The map is full: of the keyframes that no adjustment moves any more, the one leaves that is
// missed least. Whoever hovers does not forget where he came from.
void Mapper::forget_keyframe() {
  const size_t kept = static_cast<size_t>(params_.window) + 1;  // the prior stands on one of them
  size_t leaving = 0;
  for (size_t i = 1; i + kept < order_.size(); ++i) {
    if (keyframe(i).worth < keyframe(leaving).worth) leaving = i;
  }
  remove_keyframe(leaving);
}

// Makes room for all points that a keyframe can bring. Leave: those with the fewest views that no
// recent keyframe sees; of equals, those not seen for longest.
void Mapper::forget_points() {
  constexpr size_t kRoom = kCamerasMax * kTracksMax;
  if (map_.landmarks.size() + kRoom <= map_.landmarks.capacity()) return;
  const size_t recent = std::min(order_.size(), static_cast<size_t>(params_.window));
  const uint32_t recent_sequence = keyframe(order_.size() - recent).sequence;
  FixedVector<uint16_t, kLandmarksMax> slots;
  for (size_t slot = 0; slot < map_.landmarks.capacity(); ++slot) {
    const Landmark* landmark = map_.landmarks.at(slot);
    if (landmark == nullptr || landmark->last_keyframe >= recent_sequence) continue;
    (void)slots.push_back(static_cast<uint16_t>(slot));
  }
  const auto strength = [&](uint16_t slot) {
    const Landmark& landmark = *map_.landmarks.at(slot);
    return std::make_tuple(landmark.views, landmark.last_keyframe, slot);
  };
  const size_t count = std::min(slots.size(), 2 * kRoom);  // once in a few keyframes
  std::nth_element(slots.begin(), slots.begin() + count, slots.end(),
                   [&](uint16_t a, uint16_t b) { return strength(a) < strength(b); });
  for (size_t i = 0; i < count; ++i) {
    (void)map_.landmarks.release(map_.landmarks.handle(slots[i]));
    ++counters_.points_forgotten;
  }
}

}  // namespace pirvs
