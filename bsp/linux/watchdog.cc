#include "bsp/api/watchdog.h"

namespace pirvs::bsp {

void watchdog_kick(const char*) {}

}  // namespace pirvs::bsp
