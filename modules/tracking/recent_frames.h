// Where the tracks were in the last frames, to be fused once more when mapping has refined the map
// and the keyframe before them.
// In      times of frames in order; the tracks of each frame.
// Out     the frames after a time; a track's place in one of them.
// Frames  distorted pixels, (0,0) = centre of the first pixel.
// Errors  a frame that is too old, or in which the track was not there, gives nothing.
// Cost    ~4 us to note a frame of two cameras, x86-64; 0.1 MB.
// Source  PIRVS paper, section VI (a window of frames in tracking: its future work).
#pragma once

#include "core/base/limits.h"
#include "core/base/time.h"
#include "core/math/types.h"
#include "modules/frontend/track_table.h"

namespace pirvs {

class RecentFrames {
 public:
  static constexpr uint32_t kFramesMax = 16;

  void clear() { begin_ = end_; }
  // A new frame; then its tracks.
  void add(TimeNs t) {
    t_[end_ % kFramesMax] = t;
    if (++end_ - begin_ > kFramesMax) begin_ = end_ - kFramesMax;
  }
  void note(int camera, const Tracks& tracks) {
    const uint32_t frame = end_ - 1;
    for (const Track& track : tracks) {
      places_[camera][track].at[frame % kFramesMax] = {end_, track.x, track.y};
    }
  }

  // Frames are numbered from the first ever on; those from begin() to end() - 1 are still there.
  uint32_t begin() const { return begin_; }
  uint32_t end() const { return end_; }
  // None after t is missing.
  bool covers(TimeNs t) const { return begin_ != end_ && time(begin_) <= t; }
  bool newer_than(TimeNs t) const { return begin_ != end_ && time(end_ - 1) > t; }
  TimeNs time(uint32_t frame) const { return t_[frame % kFramesMax]; }
  // False: the track was not seen in that frame.
  bool place(int camera, const Track& track, uint32_t frame, Vec2& uv) const {
    const Places* const places = places_[camera].find(track);
    if (places == nullptr) return false;
    const Place& place = places->at[frame % kFramesMax];
    if (place.after != frame + 1) return false;
    uv = Vec2(place.x, place.y);
    return true;
  }

 private:
  struct Place {
    uint32_t after = 0;  // its frame's number and 1; 0: none
    float x = 0, y = 0;
  };
  struct Places {
    Place at[kFramesMax];
  };

  TrackTable<Places> places_[kCamerasMax];
  TimeNs t_[kFramesMax] = {};
  uint32_t begin_ = 0, end_ = 0;
};

}  // namespace pirvs
