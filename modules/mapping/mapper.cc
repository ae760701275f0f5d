#include "modules/mapping/mapper.h"

#include <new>

#include "modules/mapping/forgetting.h"
#include "modules/mapping/new_points.h"

namespace pirvs {

void Mapper::configure(const Camera* cameras, const ImuNoise& noise, const MappingParams& params,
                       KeyframeRing* keyframes, MapMailbox* snapshots) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  params_ = params;
  ring_ = keyframes;
  mailbox_ = snapshots;
  adjustment_.configure(cameras, noise, params, &counters_);
}

void Mapper::forget() {
  const MappingCounters counted = counters_;
  this->~Mapper();  // in place: no stack could hold another
  new (this) Mapper(counted);
}

void Mapper::on_keyframe_removed(void (*sink)(void*, const BodyState&), void* context) {
  map_.on_removed(sink, context);
}

void Mapper::step() {
  switch (phase_) {
    case Phase::kIdle: {
      const KeyframeMessage* message = ring_->front();
      if (message == nullptr) return;
      insert(*message);
      const uint32_t sequence = message->sequence;
      const bool adjust = message->adjust;
      if (adjust) {
        busy_.store(true, std::memory_order_release);
        phase_ = Phase::kBuild;
      }
      ring_->pop();  // before it counts as finished: tracking then knows of the room
      if (!adjust) finished_.store(sequence, std::memory_order_release);
      return;
    }
    case Phase::kBuild:
      adjustment_.build(map_);
      phase_ = Phase::kAdjust;
      return;
    case Phase::kAdjust:
      if (adjustment_.step()) phase_ = Phase::kFinish;
      return;
    case Phase::kFinish: {
      const bool adjusted = adjustment_.finish(map_);
      counters_.points_removed += remove_weak_points(map_);
      publish(adjusted);
      phase_ = Phase::kIdle;
      finished_.store(map_.newest().sequence, std::memory_order_release);
      busy_.store(false, std::memory_order_release);
      return;
    }
  }
}

void Mapper::insert(const KeyframeMessage& message) {
  if (message.restart) {
    if (message.renew) {
      remove_keyframe(map_.size() - 1);
    } else if (map_.size() > 0) {
      ++counters_.restarts;
    }
    adjustment_.forget_prior();
    map_.begin_run(message);
  }
  if (message.join) {
    // The place was recognised: all that the run made moves to where it belongs.
    const SE3 T = map_.join(message);
    if (adjustment_.prior().sequence != 0) move(T, adjustment_.prior());
    ++counters_.joins;
  }
  make_room();
  Keyframe& fresh = map_.append(message);
  if (message.close) loop_closer_.close(message, map_, adjustment_.prior());
  tie_sightings(message, fresh);
  counters_.points_forgotten += forget_points(map_, window());
  create_points(map_, camera_, params_, counters_);
  ++counters_.keyframes;
}

void Mapper::make_room() {
  if (map_.size() > kKeyframesMax / 2) weigh_keyframes(map_, weigh_next_);
  if (map_.full()) remove_keyframe(least_useful(map_, window()));
}

void Mapper::remove_keyframe(size_t place) {
  map_.remove(place);
  ++counters_.keyframes_removed;
}

void Mapper::tie_sightings(const KeyframeMessage& message, Keyframe& fresh) {
  for (int c = 0; c < kCamerasMax; ++c) {
    fresh.observations[c] = message.observations[c];
    for (Observation& sighting : fresh.observations[c]) {
      const LandmarkId id =
          sighting.landmark.valid() ? sighting.landmark : landmark_of_track(c, sighting.track);
      sighting.landmark = LandmarkId{};
      Landmark* landmark = map_.points().find(id);
      if (landmark == nullptr || landmark->epoch != fresh.epoch) continue;
      // Two tracks of one camera on one point: the second is a wrong match.
      if (landmark->last_keyframe == fresh.sequence && landmark->track[c] != 0) continue;
      if (landmark->last_keyframe != fresh.sequence) {
        landmark->track[0] = landmark->track[1] = 0;
        landmark->last_keyframe = fresh.sequence;
      }
      landmark->track[c] = sighting.track;
      WorkingMap::attach(sighting, id, *landmark);
    }
  }
}

// The point that a track had in the keyframe before the newest: tracking may not have heard of it
// yet.
LandmarkId Mapper::landmark_of_track(int camera, TrackId track) const {
  if (map_.size() < 2) return LandmarkId{};
  const Keyframe& before = map_.keyframe(map_.size() - 2);
  if (before.sequence < map_.run_sequence()) return LandmarkId{};
  for (const Observation& sighting : before.observations[camera]) {
    if (sighting.track == track) return sighting.landmark;
  }
  return LandmarkId{};
}

// The user says where the body is: W moves, so all in it does.
void Mapper::move_world(const SE3& T) {
  map_.move(T);
  if (adjustment_.prior().sequence != 0) move(T, adjustment_.prior());
  if (map_.size() > 0) publish(false);
}

Status Mapper::load(const MapSource& source) {
  PIRVS_TRY(map_.load(source));
  if (map_.size() == 0) return Status::kOk;
  if (params_.extend_map < 0.5f) keep_all(map_);
  finished_.store(map_.newest().sequence, std::memory_order_release);
  publish(false);
  return Status::kOk;
}

void Mapper::publish(bool adjusted) {
  MapSnapshot& snapshot = mailbox_->back();
  const Keyframe& newest = map_.newest();
  const Vec3 p_WB = newest.state.T_WB.p;
  snapshot.keyframe = newest.sequence;
  snapshot.epoch = newest.epoch;
  snapshot.adjusted = adjusted;
  snapshot.state = newest.state;
  snapshot.leveled = map_.leveled();
  snapshot.cov = adjustment_.newest_cov();
  snapshot.error = map_.errors().newest;
  snapshot.points.clear();
  const double sigma_rel2 = params_.point_sigma_rel_max * params_.point_sigma_rel_max;
  for (size_t slot = 0; slot < map_.points().capacity(); ++slot) {
    const Landmark* landmark = map_.points().at(slot);
    if (landmark == nullptr) continue;
    const double distance2 = (landmark->p_W - p_WB).squaredNorm();
    if (landmark->cov.trace() > sigma_rel2 * distance2) continue;
    MapPoint* point = snapshot.points.append();
    *point = {map_.points().handle(slot),
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
