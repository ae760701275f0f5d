// What    Maps on a disk, as modules/map/map_file.h lays them out.
// Out     read_map_file: calls load with the bytes from the begin, after they were found whole.
//         write_map_file: replaces the file whole or not at all, also when power fails.
// Errors  InputError: no such file; not a map, of another version, cut off or damaged; it cannot be
//         written.
// Cost    ~10 ms for a full map, and what the disk takes to sync.
// Source  modules/map/map_file.h.
#pragma once

#include <functional>
#include <string>

#include "modules/map/map_file.h"

namespace pirvs::tools {

void read_map_file(const std::string& path, const std::function<Status(const MapSource&)>& load);
void write_map_file(const std::string& path, const Map& map);

}  // namespace pirvs::tools
