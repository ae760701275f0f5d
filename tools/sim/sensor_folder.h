// What    Writes the folder of a simulated sensor as an ASL folder has it: data.csv, sensor.yaml.
// Errors  InputError: it cannot be written.
#pragma once

#include <string>

namespace pirvs::tools {

void write_sensor_folder(const std::string& folder, const std::string& rows,
                         const std::string& yaml);

}  // namespace pirvs::tools
