#include "tools/dataset/recording_options.h"

#include <cstdio>
#include <map>

namespace pirvs::tools {

void add_recording_options(CLI::App& app, RecordingOptions& options) {
  app.add_option(
      "--calib", options.calibration,
      "a calibration to use instead: Kalibr's camchain-imucam.yaml, one of the others of "
      "docs/formats.md, or a device's *.cfg");
  app.add_option(
      "--imu", options.imu,
      "a file with the IMU's noise densities to use instead: Kalibr's imu.yaml or alike");
  app.add_option("--cameras", options.cameras,
                 "LEFT,RIGHT, or one alone, as numbered in the recording or calibration")
      ->delimiter(',')
      ->expected(1, 2)
      ->allow_extra_args(false)
      ->check(CLI::Range(0, 15));
  const std::map<std::string, StampUnit> units = {{"ns", StampUnit::kNanoseconds},
                                                  {"us", StampUnit::kMicroseconds},
                                                  {"ms", StampUnit::kMilliseconds},
                                                  {"s", StampUnit::kSeconds}};
  app.add_option("--stamps", options.stamps, "what stamps count, where the rates leave it open")
      ->transform(CLI::CheckedTransformer(units));
  app.add_option("--set-offset", options.late_s,
                 "S, the cameras' stamps are this late, against what the calibration says")
      ->check(CLI::Range(-1.0, 1.0));
  app.add_option("--topics", options.topics,
                 "of a log: cameras in the calibration's order, IMU, truth; where several would do")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_flag("--mono", options.mono, "use the left camera alone; the IMU gives the scale");
  app.add_option("--start", options.start_s, "skip this many seconds")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--duration", options.duration_s, "stop after this many seconds")
      ->check(CLI::NonNegativeNumber);
}

void print_notes(const InputLog& log) {
  for (const std::string& note : log.notes) std::fprintf(stderr, "pirvs: %s\n", note.c_str());
}

}  // namespace pirvs::tools
