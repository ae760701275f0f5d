#include "tools/sim/sensor_folder.h"

#include <filesystem>
#include <fstream>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {

void write_sensor_folder(const std::string& folder, const std::string& rows,
                         const std::string& yaml) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const auto write = [](const std::string& path, const std::string& text) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw InputError("cannot write", path, "check space and permissions");
  };
  write(folder + "/data.csv", rows);
  write(folder + "/sensor.yaml", yaml);
}

}  // namespace pirvs::tools
