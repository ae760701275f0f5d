// What mapping counts: what it made, what it rejected, what a full map forgot.
#pragma once

#include "core/base/counter.h"

namespace pirvs {

struct MappingCounters {
  Counter keyframes, keyframes_removed, adjustments, adjustments_failed;
  Counter points_stereo, points_temporal, points_removed, points_full, points_forgotten;
  Counter points_rejected, observations_removed, bundle_full, restarts, joins;
};

inline constexpr CounterRow<MappingCounters> kMappingCounters[] = {
    {"mapping_keyframes", &MappingCounters::keyframes},
    {"keyframes_removed", &MappingCounters::keyframes_removed},
    {"adjustments", &MappingCounters::adjustments},
    {"adjustments_failed", &MappingCounters::adjustments_failed},
    {"points_stereo", &MappingCounters::points_stereo},
    {"points_temporal", &MappingCounters::points_temporal},
    {"points_removed", &MappingCounters::points_removed},
    {"points_full", &MappingCounters::points_full},
    {"points_forgotten", &MappingCounters::points_forgotten},
    {"points_rejected", &MappingCounters::points_rejected},
    {"observations_removed", &MappingCounters::observations_removed},
    {"bundle_full", &MappingCounters::bundle_full},
    {"restarts", &MappingCounters::restarts},
    {"mapping_joins", &MappingCounters::joins},
};
static_assert(every_counter_is_in(kMappingCounters));

}  // namespace pirvs
