#include "modules/mapping/working_map.h"

#include <algorithm>

#include "core/base/assert.h"
#include "modules/map/nodes.h"

namespace pirvs {

void WorkingMap::on_removed(void (*sink)(void*, const BodyState&), void* context) {
  removed_sink_ = sink;
  removed_context_ = context;
}

// ---- keyframes --------------------------------------------------------------------------------

Keyframe& WorkingMap::append(const KeyframeMessage& message) {
  const Result<KeyframeId> id = map_.keyframes.acquire();
  PIRVS_ASSERT(id.ok());  // order_ holds every live keyframe and is not full
  Keyframe& fresh = *map_.keyframes.find(id.value());
  fresh.sequence = message.sequence;
  fresh.state = message.state;
  pirvs::move(leveled_ * message.leveled.inverse(), fresh.state);  // it may not know of the last
  fresh.from_previous = message.from_previous;
  fresh.way_from_previous = message.way_from_previous;
  fresh.at_rest = message.at_rest;
  fresh.epoch = message.epoch;
  if (message.restart || message.join || message.close) drift_ = Drift{};
  if (!message.drift.isZero(0)) drift_ = {message.sequence, fresh.state.T_WB.p, message.drift};
  errors_.newest += message.drift;
  fresh.error = errors_.newest;
  fresh.added = errors_.added + message.drift;  // until an adjustment knows better
  fresh.linked =
      message.linked && !message.restart && size() > 0 && newest().sequence + 1 == message.sequence;
  const bool added = order_.push_back(id.value());
  PIRVS_ASSERT(added);
  return fresh;
}

// What the next one knew against this one, it knows against the one before from now on.
void WorkingMap::remove(size_t place) {
  Keyframe& leaving = keyframe(place);
  if (place + 1 < size()) {
    Keyframe& next = keyframe(place + 1);
    next.linked = false;
    next.added += error_about(next.state.T_WB.p, leaving.state.T_WB.p, leaving.added);
  }
  for (Observations& observations : leaving.observations) {
    for (Observation& sighting : observations) detach(sighting);
  }
  carry_nodes(map_, order_[place]);
  if (removed_sink_ != nullptr) removed_sink_(removed_context_, leaving.state);
  (void)map_.keyframes.release(order_[place]);
  for (size_t i = place + 1; i < size(); ++i) order_[i - 1] = order_[i];
  order_.pop_back();
}

size_t WorkingMap::place_after(uint32_t sequence, size_t begin) const {
  const auto after = std::upper_bound(
      order_.begin() + begin, order_.end(), sequence,
      [&](uint32_t wanted, KeyframeId id) { return wanted < map_.keyframes.find(id)->sequence; });
  return static_cast<size_t>(after - order_.begin());
}

// ---- the run since the last start -------------------------------------------------------------

void WorkingMap::begin_run(const KeyframeMessage& first) {
  run_sequence_ = first.sequence;
  errors_.first = errors_.newest = first.error;
}

size_t WorkingMap::run_begin() const {
  size_t i = size();
  while (i > 0 && keyframe(i - 1).sequence >= run_sequence_) --i;
  return i;
}

Mat6 WorkingMap::drift_since(uint32_t sequence, const Vec3& at) const {
  if (drift_.sequence <= sequence) return Mat6::Zero();
  return error_about(at, drift_.at, drift_.error);
}

// ---- points -----------------------------------------------------------------------------------

void WorkingMap::attach(Observation& sighting, LandmarkId id, Landmark& landmark) {
  sighting.landmark = id;
  ++landmark.views;
}

void WorkingMap::detach(Observation& sighting) {
  Landmark* landmark = map_.landmarks.find(sighting.landmark);
  sighting.landmark = LandmarkId{};
  if (landmark != nullptr) --landmark->views;
}

// ---- as a whole -------------------------------------------------------------------------------

void WorkingMap::move(const SE3& T) {
  for (size_t i = 0; i < size(); ++i) {
    Keyframe& moved = keyframe(i);
    pirvs::move(T, moved.state);
    moved.error = turned(T, moved.error);
    moved.added = turned(T, moved.added);
  }
  for (size_t slot = 0; slot < map_.landmarks.capacity(); ++slot) {
    Landmark* point = map_.landmarks.at(slot);
    if (point != nullptr) pirvs::move(T, *point);
  }
  for (Mat6* error : {&errors_.first, &errors_.newest, &errors_.added}) {
    *error = turned(T, *error);
  }
  drift_.at = T * drift_.at;
  drift_.error = turned(T, drift_.error);
}

void WorkingMap::level(const SE3& T) {
  move(T);
  leveled_ = T * leveled_;
}

SE3 WorkingMap::join(const KeyframeMessage& message) {
  const SE3 since = leveled_ * message.leveled.inverse();
  const SE3 T = since * message.T_join * since.inverse();
  for (size_t i = 0; i < size(); ++i) {
    Keyframe& moved = keyframe(i);
    if (moved.epoch != message.joining) continue;
    pirvs::move(T, moved.state);
    moved.epoch = message.epoch;
    moved.error = message.error;
  }
  errors_.first = message.error;
  for (size_t slot = 0; slot < map_.landmarks.capacity(); ++slot) {
    Landmark* moved = map_.landmarks.at(slot);
    if (moved == nullptr || moved->epoch != message.joining) continue;
    pirvs::move(T, *moved);
    moved->epoch = message.epoch;
  }
  return T;
}

Status WorkingMap::load(const MapSource& source) {
  PIRVS_ASSERT(size() == 0);
  PIRVS_TRY(load_map(source, map_));
  for (size_t slot = 0; slot < map_.keyframes.capacity(); ++slot) {
    if (map_.keyframes.at(slot) != nullptr) (void)order_.push_back(map_.keyframes.handle(slot));
  }
  if (size() == 0) return Status::kOk;
  std::sort(order_.begin(), order_.end(), [&](KeyframeId a, KeyframeId b) {
    return map_.keyframes.find(a)->sequence < map_.keyframes.find(b)->sequence;
  });
  run_sequence_ = newest().sequence + 1;  // no adjustment reaches into an earlier run
  errors_.newest = newest().error;
  return Status::kOk;
}

}  // namespace pirvs
