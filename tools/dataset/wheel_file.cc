#include "tools/dataset/wheel_file.h"

#include <cmath>

#include "tools/dataset/input_error.h"
#include "tools/dataset/text_table.h"

namespace pirvs::tools {

std::vector<WheelSample> read_wheels(const std::string& path, WheelKind kind, InputLog& log) {
  TextTable table(path, "wheels");
  std::vector<WheelSample> samples;
  while (table.next()) {
    const auto t = table.stamp();
    const bool whole = t && table.columns() >= 3 && table.number(1) && table.number(2);
    if (!whole) {
      if (!table.cut_off()) table.fail("needs time and two numbers", "remove or repair the line");
      log.count("wheel_rows_truncated");
      continue;
    }
    const WheelSample sample{*t, {*table.number(1), *table.number(2)}, kind};
    if (!std::isfinite(sample.value[0]) || !std::isfinite(sample.value[1])) {
      log.count("wheel_samples_not_finite");
    } else if (!samples.empty() && sample.t <= samples.back().t) {
      log.count("wheel_stamps_not_rising");
    } else {
      samples.push_back(sample);
    }
  }
  if (samples.empty()) throw InputError("no wheel samples", path, "check the file");
  return samples;
}

}  // namespace pirvs::tools
