// What    Reads order.csv: in which order everything came to the door when a recording was made;
//         and maps.csv: up to which keyframe mapping had come when each frame began.
// In      The files that modules/recorder wrote (order_row.h).
// Out     Its rows; cut off before the first that is not whole, as after a power cut.
// Units   ns.
// Errors  InputError: a whole row that makes no sense.
// Cost    ~1 us a row.
#pragma once

#include <string>
#include <vector>

#include "modules/recorder/order_row.h"

namespace pirvs::tools {

std::vector<OrderRow> read_order(const std::string& path);
std::vector<uint32_t> read_maps(const std::string& path);

}  // namespace pirvs::tools
