#include "tests/device/guest_run.h"
#include "tests/programs.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <utility>

#include "modules/calibration/calibration_text.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/dataset/pack_file.h"

namespace pirvs::systems {
namespace {

constexpr double kDuration_s = 8;

void write_guest_files(const tools::Recording& recording, const std::string& folder,
                       const GuestSetup& setup) {
  Text<kCalibrationTextMax> calibration;
  write_calibration(recording.calibration, calibration);
  std::ofstream(folder + "/calibration.cfg") << calibration.c_str();
  std::ofstream(folder + "/device.cfg")
      << "calibration = calibration.cfg\n"
         "camera.left = /dev/video0\n"
         "camera.right = /dev/video1\n"
         "output.text = frames\n"
         "output.poses = 127.0.0.1:14550\n"
      << (setup.icm20602 ? "imu = icm20602:0:68\nimu.data_ready = DATA_READY\n"
                         : "imu = iio:mpu6500\n")
      << (setup.record ? "record = /run/out/record\n" : "")
      << (setup.trouble ? "record = /run/small/record\n" : "")
      << (setup.cut_s > 0 ? "record = /run/disk/record\n" : "") << setup.config;
  const Camera& camera = recording.calibration.camera[0];
  std::ofstream(folder + "/guest")
      << "width=" << camera.width << "\nheight=" << camera.height
      << "\nicm20602=" << (setup.icm20602 ? 1 : 0) << "\nfeed=\"" << (setup.faults ? "faults " : "")
      << (setup.icm20602 ? "icm20602 " : "") << (setup.grid ? "grid " : "") << "loop "
      << setup.loop_s << "\"\nrobot=\"" << setup.robot << "\"\ncamera=\"" << setup.camera
      << "\"\ntrouble=" << (setup.trouble ? "yes" : "no") << "\ncut=" << setup.cut_s << "\n";
}

std::string command_of(const GuestSetup& setup, const std::string& in, const std::string& out) {
  const std::string build = build_folder();
  std::string command = "tools/device/run --kernel " + build + "/device --recording " + in +
                        "/recording.pack --out " + out + " --timeout " +
                        std::to_string(setup.timeout_s);
  if (setup.cut_s > 0) command += " --module ext4 --module crc32c_generic --disk " + setup.disk;
  for (const char* module :
       {"virtio_pci", "virtio_blk", "videodev", "videobuf2-v4l2", "videobuf2-vmalloc",
        "industrialio-triggered-buffer", "inv-mpu6050-i2c", "i2c-dev"}) {
    command += std::string(" --module ") + module;
  }
  command += " /init=tests/device/guest/init /bin/pirvsd=" + build + "/ironsides/pirvsd";
  for (const char* program : {"feeder", "robot"}) {
    command += std::string(" /bin/") + program + "=" + build + "/device/" + program;
  }
  for (const char* module : {"test_camera.ko", "test_gpio.ko", "test_imu.ko"}) {
    command += std::string(" /modules/") + module + "=" + build + "/device/modules/" + module;
  }
  for (const char* file : {"device.cfg", "calibration.cfg", "guest"}) {
    command += std::string(" /config/") + file + "=" + in + "/" + file;
  }
  return command;
}

}  // namespace

std::string text_of(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

std::vector<TimeNs> DeviceRun::robot_times(const std::string& what, int level) const {
  std::vector<TimeNs> out;
  std::istringstream all(pins);
  for (std::string line; std::getline(all, line);) {
    std::istringstream words(line);
    std::string word;
    long long t = 0;
    int value = -1;
    if (!(words >> word >> t) || word != what) continue;
    words >> value;
    if (level < 0 || value == level) out.push_back(t);
  }
  return out;
}

DeviceRun run_guest(const tools::Recording& recording, const GuestSetup& setup) {
  const std::string in = scratch_folder("device_in");
  write_guest_files(recording, in, setup);
  tools::write_pack(recording, in + "/recording.pack", [](size_t, size_t) {});
  DeviceRun run;
  run.folder = build_folder() + "/test/" + setup.name;
  run.status = std::system(command_of(setup, in, run.folder).c_str());
  run.news = text_of(run.folder + "/news");
  run.console = text_of(run.folder + "/console");
  run.fed = text_of(run.folder + "/fed");
  run.lines = text_of(run.folder + "/lines");
  run.pins = text_of(run.folder + "/pins");
  std::istringstream news(run.news);
  for (std::string line; std::getline(news, line);) {
    std::istringstream words(line);
    std::string word, name;
    uint64_t value = 0;
    if (words >> word >> name >> value && word == "counter") run.counters[name] = value;
  }
  long long shift = 0;
  if (std::sscanf(run.fed.c_str(), "shift %lld", &shift) == 1) run.shift = shift;
  return run;
}

namespace {

DeviceRun run_with_pins(bool icm20602, bool faults) {
  GuestSetup setup;
  setup.name = std::string("device") + (icm20602 ? "_icm20602" : "") + (faults ? "_faults" : "");
  setup.icm20602 = icm20602;
  setup.faults = faults;
  setup.record = !faults;
  // Until shortly before the last frame: when the feeder ends, its memory keeps the kernel busy for
  // so long that gpiolib merges edges.
  setup.robot = "9 79000 500";
  setup.config =
      "pin.sync_out = SYNC_OUT\n"
      "pin.health = test_gpio:4\n"
      "pin.sync_in = SYNC_IN\n"
      "pin.wheel_left = LEFT_A, LEFT_B\n"
      "output.stream = 127.0.0.1:14560\n";
  if (faults) setup.config += "pin.wheel_right = LEFT_A, LEFT_B\n";
  setup.trouble = faults && icm20602;
  return run_guest(fed_recording(), setup);
}

const DeviceRun& shared_run(bool icm20602, bool faults) {
  static std::map<std::pair<bool, bool>, DeviceRun> runs;
  const auto key = std::make_pair(icm20602, faults);
  if (runs.count(key) == 0) runs[key] = run_with_pins(icm20602, faults);
  return runs[key];
}

}  // namespace

const DeviceRun& good_run(bool icm20602) { return shared_run(icm20602, false); }
const DeviceRun& faulty_run(bool icm20602) { return shared_run(icm20602, true); }

const tools::Recording& fed_recording() {
  static const tools::Recording recording = [] {
    tools::RecordingOptions options;
    options.duration_s = kDuration_s;
    const std::string folder =
        clip() != nullptr ? clip()->folder : simulated(SimulatedDevice::kEuroc).folder;
    return tools::open_recording(folder, options);
  }();
  return recording;
}

}  // namespace pirvs::systems
