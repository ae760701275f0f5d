#include "modules/tracking/associator.h"

#include <algorithm>
#include <cmath>

namespace pirvs {
namespace {

constexpr size_t kTracksSeeing = 8;  // fewer: the camera sees nothing

}  // namespace

void Associator::configure(const Camera* cameras, int count, const MatchingParams& params,
                           Frontend* frontends) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  cameras_ = count;
  params_ = params;
  frontends_ = frontends;
}

void Associator::take(const MapSnapshot& snapshot, const SE3& T_WB, uint32_t newest) {
  map_.assign(snapshot, T_WB, camera_, cameras_);
  struct Entry {
    TrackId id;
    uint16_t index;
  };
  for (int c = 0; c < kCamerasMax; ++c) {
    FixedVector<Entry, kTracksMax> sorted;
    for (size_t i = 0; i < tracks(c).size(); ++i) {
      const Track& track = tracks(c)[i];
      const MapPoint* shown = point(c, track);
      const bool freed =
          shown == nullptr || shown->epoch != map_.epoch() ||
          (snapshot.keyframe == newest && shown->in_newest && shown->track[c] != track.id);
      if (freed) set_landmark(c, track, LandmarkId{});
      (void)sorted.push_back({track.id, static_cast<uint16_t>(i)});
    }
    const auto less = [](const Entry& a, const Entry& b) { return a.id < b.id; };
    std::sort(sorted.begin(), sorted.end(), less);
    for (const MapPoint& point : snapshot.points) {
      if (point.track[c] == 0) continue;
      const Entry* found =
          std::lower_bound(sorted.begin(), sorted.end(), Entry{point.track[c], 0}, less);
      if (found == sorted.end() || found->id != point.track[c]) continue;
      set_landmark(c, tracks(c)[found->index], point.id);
    }
  }
}

void Associator::predict(const Mat3& R_BlBn) {
  for (int c = 0; c < kCamerasMax; ++c) {
    const Mat3 R_BC = camera_[c].T_BC.R;
    frontends_[c].predict(R_BC.transpose() * R_BlBn.transpose() * R_BC);
  }
}

void Associator::predict(const SE3& T_WB_last, const SE3& T_WB) {
  for (int c = 0; c < kCamerasMax; ++c) {
    const SE3 T_CW = (T_WB * camera_[c].T_BC).inverse();
    const SE3 T_CW_last = (T_WB_last * camera_[c].T_BC).inverse();
    frontends_[c].predict(T_CW.R * T_CW_last.R.transpose());
    for (size_t i = 0; i < tracks(c).size(); ++i) {
      Track& track = frontends_[c].track(i);
      const MapPoint* shown = point(c, track);
      Vec2 before, now;
      if (shown == nullptr || !camera_[c].project(T_CW_last * shown->p_W, before) ||
          !camera_[c].project(T_CW * shown->p_W, now)) {
        continue;
      }
      // The predicted motion of the point, from where the track is: its own offset stays.
      track.x_pred = track.x + static_cast<float>(now.x() - before.x());
      track.y_pred = track.y + static_cast<float>(now.y() - before.y());
    }
  }
}

int Associator::match(const PosePrediction& pose) {
  if (map_.empty()) return 0;
  int matched = 0;
  for (int c = 0; c < cameras_; ++c) {
    matched += match_by_projection(map_, pose, camera_[c], params_, tracks(c), landmarks_[c]);
  }
  return matched;
}

void Associator::adopt(const Recognition& found) {
  for (const Recognition::Match& match : found.matches) {
    set_landmark(match.camera, tracks(match.camera)[match.track], match.landmark);
  }
}

void Associator::forget_landmarks() {
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Track& track : tracks(c)) set_landmark(c, track, LandmarkId{});
  }
}

void Associator::vote(uint8_t present, double dt_s, StandstillDetector& standstill) const {
  for (int c = 0; c < cameras_; ++c) {
    if ((present >> c & 1) != 0) standstill.add_tracks(camera_[c], c, tracks(c), dt_s);
  }
}

void Associator::compare(uint8_t present, const Vec3& turn_B, double dt_s, TurnCheck& check) const {
  const int c = (present & 1) != 0 ? 0 : 1;
  check.add(camera_[c], tracks(c), turn_B, dt_s);
}

// Without a descriptor a track becomes no point, and is matched with none.
void Associator::drop_movers(const StandstillDetector& standstill) {
  for (int c = 0; c < cameras_; ++c) {
    for (size_t i = 0; i < tracks(c).size();) {
      Track& track = frontends_[c].track(i);
      if (standstill.slid(c, track)) {
        frontends_[c].erase(i);
        continue;
      }
      if (standstill.moves(c, track)) {
        set_landmark(c, track, LandmarkId{});
        track.described = false;
      }
      ++i;
    }
  }
}

void Associator::begin_collecting() {
  correspondences_.clear();
  corresponding_.clear();
}

void Associator::add(int c, const Track& track, const Vec2& uv, double sigma_px) {
  const MapPoint* shown = point(c, track);
  if (shown == nullptr || shown->epoch != map_.epoch()) return;
  (void)correspondences_.push_back({shown->p_W, shown->cov, uv, sigma_px, c, Gate::kAccepted});
  (void)corresponding_.push_back(&track);
}

Correspondences& Associator::collect(double sigma_px, const StandstillDetector& standstill) {
  begin_collecting();
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Track& track : tracks(c)) {
      if (standstill.at_rest() && !standstill.stands(c, track)) continue;
      add(c, track, Vec2(track.x, track.y), sigma_px);
    }
  }
  return correspondences_;
}

Correspondences& Associator::collect(double sigma_px, const RecentFrames& frames, uint32_t frame) {
  begin_collecting();
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Track& track : tracks(c)) {
      Vec2 uv;
      if (frames.place(c, track, frame, uv)) add(c, track, uv, sigma_px);
    }
  }
  return correspondences_;
}

int Associator::known_tracks() const {
  int count = 0;
  for (int c = 0; c < cameras_; ++c) {
    for (const Track& track : tracks(c)) count += point(c, track) != nullptr ? 1 : 0;
  }
  return count;
}

int Associator::lasting_tracks(int c) const {
  constexpr int kFrames = 4;
  int count = 0;
  for (const Track& track : tracks(c)) count += track.age >= kFrames ? 1 : 0;
  return count;
}

int Associator::lasting_tracks() const {
  int most = 0;
  for (int c = 0; c < cameras_; ++c) most = std::max(most, lasting_tracks(c));
  return most;
}

int Associator::occupied_cells() const {
  int most = 0;
  for (int c = 0; c < cameras_; ++c) {
    uint32_t cells = 0;
    for (const Correspondence& k : correspondences_) {
      if (k.camera != c || k.gate != Gate::kAccepted) continue;
      const int column = std::clamp(static_cast<int>(4 * k.uv.x() / camera_[c].width), 0, 3);
      const int row = std::clamp(static_cast<int>(3 * k.uv.y() / camera_[c].height), 0, 2);
      cells |= 1u << (4 * row + column);
    }
    int count = 0;
    for (; cells != 0; cells &= cells - 1) ++count;
    most = std::max(most, count);
  }
  return most;
}

int Associator::drop_misfits(float misses_max) {
  for (size_t i = 0; i < correspondences_.size(); ++i) {
    uint8_t& misses = misses_[correspondences_[i].camera][*corresponding_[i]];
    const bool fits = correspondences_[i].gate == Gate::kAccepted;
    misses = fits ? 0 : static_cast<uint8_t>(misses + 1);
  }
  int dropped = 0;
  for (int c = 0; c < kCamerasMax; ++c) {
    for (size_t i = 0; i < tracks(c).size();) {
      if (static_cast<float>(misses_[c].get(tracks(c)[i])) <= misses_max) {
        ++i;
        continue;
      }
      frontends_[c].erase(i);
      ++dropped;
    }
  }
  return dropped;
}

uint8_t Associator::seeing(uint8_t present) const {
  uint8_t out = 0;
  for (int c = 0; c < cameras_; ++c) {
    const bool sees = (present >> c & 1) != 0 && tracks(c).size() >= kTracksSeeing;
    out |= static_cast<uint8_t>(sees << c);
  }
  return out;
}

int Associator::tracked_made_by(uint32_t keyframe) const {
  int count = 0;
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Track& track : tracks(c)) {
      const MapPoint* shown = point(c, track);
      count += shown != nullptr && shown->first_keyframe <= keyframe ? 1 : 0;
    }
  }
  return count;
}

TrackUse Associator::use(int c, const Track& track) const {
  if (!landmark(c, track).valid()) return TrackUse::kNew;
  if (point(c, track) == nullptr) return TrackUse::kWaiting;
  return misses_[c].get(track) == 0 ? TrackUse::kUsed : TrackUse::kRejected;
}

int Associator::seen_points(SeenPoint* out, int max) const {
  if (frontends_ == nullptr) return 0;
  int count = 0;
  for (int c = 0; c < cameras_; ++c) {
    for (const Track& track : tracks(c)) {
      const MapPoint* const seen = point(c, track);
      if (seen == nullptr || count == max) continue;
      const auto same = [seen](const SeenPoint& other) { return other.id == seen->id; };
      if (c > 0 && std::any_of(out, out + count, same)) continue;
      out[count++] = {seen->id, seen->p_W, std::sqrt(seen->cov.trace() / 3)};
    }
  }
  return count;
}

}  // namespace pirvs
