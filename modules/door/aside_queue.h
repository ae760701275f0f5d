// Fixes, wheel samples and edges that wait until the IMU has come to their time, oldest first.
// Errors  Counted: aside_stamp_impossible, aside_full; the item is dropped. aside_before_imu: one
//         of before the IMU's first sample; while there was none, the oldest that wait make room.
// Cost    at most kMax copies of an item.
#pragma once

#include "core/store/fixed_vector.h"
#include "modules/door/door_item.h"
#include "modules/door/door_params.h"

namespace pirvs {

class AsideQueue {
 public:
  static constexpr size_t kMax = 8     // wheel samples of 40 ms at 200 Hz
                                 + 4   // edges of two encoders
                                 + 4;  // fixes of two receivers

  static constexpr TimeNs kImuToCome = INT64_MAX;

  // kGnss, kWheel or kEdge. imu_begin: the time of the IMU's first sample.
  void push(const Arrival& arrival, TimeNs imu_begin, DoorLosses& losses) {
    DoorItem item;
    TimeNs t = arrival.edge.t;
    item.kind = DoorItemKind::kEdge;
    item.edge = arrival.edge;
    if (arrival.kind == ArrivalKind::kGnss) {
      item.kind = DoorItemKind::kGnss;
      item.gnss = arrival.gnss;
      t = arrival.gnss.t;
    } else if (arrival.kind == ArrivalKind::kWheel) {
      item.kind = DoorItemKind::kWheel;
      item.wheel = arrival.wheel;
      t = arrival.wheel.t;
    }
    if (!is_stamp(t)) return losses.add(DoorLoss::kAsideStampImpossible);
    if (imu_begin == kImuToCome) {
      if (waiting_.size() == kMax) drop_before(waiting_[0].t + 1, losses);
    } else if (t < imu_begin) {
      return losses.add(DoorLoss::kAsideBeforeImu);
    }
    if (!waiting_.push_back({t, item})) return losses.add(DoorLoss::kAsideFull);
    // Of equal times the first to come is the first to go.
    for (size_t i = waiting_.size() - 1; i > 0 && waiting_[i - 1].t > t; --i) {
      const Waiting later = waiting_[i - 1];
      waiting_[i - 1] = waiting_[i];
      waiting_[i] = later;
    }
  }

  // The IMU begins at t.
  void drop_before(TimeNs t, DoorLosses& losses) {
    for (DoorItem none; take(t - 1, none);) losses.add(DoorLoss::kAsideBeforeImu);
  }

  // The oldest item, if it is no later than `until`.
  bool take(TimeNs until, DoorItem& out) {
    if (waiting_.empty() || waiting_[0].t > until) return false;
    out = waiting_[0].item;
    for (size_t i = 1; i < waiting_.size(); ++i) waiting_[i - 1] = waiting_[i];
    waiting_.pop_back();
    return true;
  }

 private:
  struct Waiting {
    TimeNs t;
    DoorItem item;
  };
  FixedVector<Waiting, kMax> waiting_;
};

}  // namespace pirvs
