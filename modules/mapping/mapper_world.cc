// What moves the map as a whole, and how it leaves and enters the mapper.
#include <algorithm>

#include "modules/mapping/mapper.h"

namespace pirvs {

// The place was recognised: all that the run made moves to where it belongs.
void Mapper::join(const KeyframeMessage& message) {
  const SE3& T = message.T_join;
  for (size_t i = 0; i < order_.size(); ++i) {
    Keyframe& moved = keyframe(i);
    if (moved.epoch != message.joining) continue;
    move(T, moved.state);
    moved.epoch = message.epoch;
    moved.error = message.error;
  }
  run_error_ = message.error;
  for (size_t slot = 0; slot < map_.landmarks.capacity(); ++slot) {
    Landmark* moved = map_.landmarks.at(slot);
    if (moved == nullptr || moved->epoch != message.joining) continue;
    move(T, *moved);
    moved->epoch = message.epoch;
  }
  if (prior_.sequence != 0) move(T, prior_);
  ++counters_.joins;
}

// The newest keyframe is in order_ already. Each point goes with the keyframe that saw it last.
void Mapper::close(const KeyframeMessage& message) {
  size_t begin = run_begin();
  while (begin < order_.size() && keyframe(begin).sequence <= message.closes_to) ++begin;
  const size_t count = order_.size() - begin;
  for (size_t i = 0; i < count; ++i) {
    loop_steps_[i] = {keyframe(begin + i).state.T_WB.p, keyframe(begin + i).added};
  }
  spread_loop(loop_steps_, static_cast<int>(count), message.off, message.off_cov,
              loop_corrections_);
  const Keyframe* const old = begin > 0 ? &keyframe(begin - 1) : nullptr;
  for (size_t i = 0; i < count; ++i) {
    Keyframe& moved = keyframe(begin + i);
    loop_motions_[i] = motion_of(loop_corrections_[i].xi, moved.state.T_WB.p);
    moved.error = loop_corrections_[i].left;
    if (old != nullptr) {
      moved.error += error_about(moved.state.T_WB.p, old->state.T_WB.p, old->error);
    }
    move(loop_motions_[i], moved.state);
    if (moved.sequence == prior_.sequence) move(loop_motions_[i], prior_);
  }
  newest_error_ = keyframe(order_.size() - 1).error;
  const uint32_t sequence_begin = keyframe(begin).sequence;
  const uint32_t newest = keyframe(order_.size() - 1).sequence;
  for (size_t slot = 0; slot < map_.landmarks.capacity(); ++slot) {
    Landmark* point = map_.landmarks.at(slot);
    if (point == nullptr || point->last_keyframe < sequence_begin) continue;
    const uint32_t seen = std::min(point->last_keyframe, newest);
    const auto after = std::upper_bound(order_.begin() + begin, order_.end(), seen,
                                        [&](uint32_t sequence, KeyframeId id) {
                                          return sequence < map_.keyframes.find(id)->sequence;
                                        });
    move(loop_motions_[after - order_.begin() - begin - 1], *point);
  }
}

// The user says where the body is: W moves, so all in it does.
void Mapper::move_world(const SE3& T) {
  for (size_t i = 0; i < order_.size(); ++i) {
    Keyframe& moved = keyframe(i);
    move(T, moved.state);
    moved.error = turned(T, moved.error);
    moved.added = turned(T, moved.added);
  }
  for (size_t slot = 0; slot < map_.landmarks.capacity(); ++slot) {
    Landmark* point = map_.landmarks.at(slot);
    if (point != nullptr) move(T, *point);
  }
  if (prior_.sequence != 0) move(T, prior_);
  for (Mat6* error : {&run_error_, &held_error_, &newest_error_, &last_added_}) {
    *error = turned(T, *error);
  }
  if (!order_.empty()) publish(false);
}

Status Mapper::load(const MapSource& source) {
  PIRVS_ASSERT(order_.empty());
  PIRVS_TRY(load_map(source, map_));
  for (size_t slot = 0; slot < map_.keyframes.capacity(); ++slot) {
    if (map_.keyframes.at(slot) != nullptr) (void)order_.push_back(map_.keyframes.handle(slot));
  }
  if (order_.empty()) return Status::kOk;
  std::sort(order_.begin(), order_.end(), [&](KeyframeId a, KeyframeId b) {
    return map_.keyframes.find(a)->sequence < map_.keyframes.find(b)->sequence;
  });
  const Keyframe& newest = keyframe(order_.size() - 1);
  run_sequence_ = newest.sequence + 1;  // no adjustment reaches into an earlier run
  newest_error_ = newest.error;
  finished_.store(newest.sequence, std::memory_order_release);
  publish(false);
  return Status::kOk;
}

void Mapper::publish(bool adjusted) {
  MapSnapshot& snapshot = mailbox_->back();
  const Keyframe& newest = keyframe(order_.size() - 1);
  const Vec3 p_WB = newest.state.T_WB.p;
  snapshot.keyframe = newest.sequence;
  snapshot.epoch = newest.epoch;
  snapshot.adjusted = adjusted;
  snapshot.state = newest.state;
  snapshot.cov = newest_cov_;
  snapshot.error = newest_error_;
  snapshot.points.clear();
  const double sigma_rel2 = params_.point_sigma_rel_max * params_.point_sigma_rel_max;
  for (size_t slot = 0; slot < map_.landmarks.capacity(); ++slot) {
    const Landmark* landmark = map_.landmarks.at(slot);
    if (landmark == nullptr) continue;
    const double distance2 = (landmark->p_W - p_WB).squaredNorm();
    if (landmark->cov.trace() > sigma_rel2 * distance2) continue;
    MapPoint* point = snapshot.points.append();
    *point = {map_.landmarks.handle(slot),
              landmark->p_W,
              landmark->cov,
              landmark->descriptor,
              landmark->view_W,
              landmark->distance_m,
              {landmark->track[0], landmark->track[1]},
              landmark->last_keyframe == newest.sequence,
              landmark->first_keyframe,
              landmark->last_keyframe,
              landmark->epoch};
    if (!point->in_newest) point->track[0] = point->track[1] = 0;
  }
  mailbox_->publish();
}

}  // namespace pirvs
