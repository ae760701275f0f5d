// Every parameter of the stack.
#pragma once

#include "modules/door/door_params.h"
#include "modules/frontend/frontend_params.h"
#include "modules/imu/imu_params.h"
#include "modules/mapping/mapping_params.h"
#include "modules/tracking/tracker.h"

namespace pirvs {

struct AppParams {
  DoorParams door;
  ImuParams imu;
  FrontendParams frontend;
  TrackingParams tracking;
  MappingParams mapping;
};

}  // namespace pirvs
