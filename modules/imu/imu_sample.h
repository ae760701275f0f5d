// The IMU sample of the bsp contract, for modules that only compute with it.
#pragma once

#include "bsp/api/imu.h"
