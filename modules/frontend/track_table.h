// What somebody notes of each track of one camera, beside the front-end: addressed by the track's
// slot, checked by its id, which is never given out twice.
// In      tracks of one front-end. Out: the note, or nothing where the slot's owner was another.
// Errors  none: a note of a track that has ended is never found again.
// Cost    O(1); sizeof is kTracksMax notes.
#pragma once

#include "modules/frontend/track.h"

namespace pirvs {

template <class Note>
class TrackTable {
 public:
  // nullptr: nothing was noted of this track.
  const Note* find(const Track& track) const {
    const Entry& entry = entries_[track.slot];
    return entry.id == track.id ? &entry.note : nullptr;
  }
  // A copy; Note{} when nothing was noted.
  Note get(const Track& track) const {
    const Note* const note = find(track);
    return note != nullptr ? *note : Note{};
  }
  // To write: begins as Note{}.
  Note& operator[](const Track& track) {
    Entry& entry = entries_[track.slot];
    if (entry.id != track.id) entry = {track.id, Note{}};
    return entry.note;
  }

 private:
  struct Entry {
    TrackId id = 0;
    Note note{};
  };
  Entry entries_[kTracksMax];
};

}  // namespace pirvs
