// The device on USB under Debian's arm64 kernel in QEMU: device and PC are one guest, joined by the
// kernel's dummy_hcd; the PC's network is in a namespace of its own.
// PIRVS_USB_SECONDS: of poses; 60 by default, at least 20.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "modules/calibration/calibration_text.h"
#include "tests/device/guest_run.h"
#include "tests/recordings.h"
#include "tools/dataset/pack_file.h"

namespace pirvs::systems {
namespace {

constexpr double kRate_hz = 200;  // poses
constexpr double kFrames_hz = 10;

// Of guest time, with poses.
double seconds() {
  const char* const given = std::getenv("PIRVS_USB_SECONDS");
  return given != nullptr ? std::max(20, std::atoi(given)) : 60;
}

// A device at rest, which can be played again and again.
tools::Recording rest() {
  tools::SimOptions options;
  options.device = "ironsides";
  options.path = "rest";
  options.duration_s = 3;
  options.rate_hz = kFrames_hz;
  options.blur = 1;
  return made(options, "usb_rest");
}

struct UsbRun {
  int status = -1;
  std::string console, states, devices, usb, news, peer, recordings;
  std::vector<std::string> answers;
  std::map<std::string, double> values;  // of the peer, of pirvsd's counters

  double value(const std::string& name) const {
    const auto found = values.find(name);
    return found == values.end() ? -1 : found->second;
  }
};

// Lines `name value`, also behind a word.
void read_values(const std::string& text, const std::string& word, UsbRun& out) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("answer ", 0) == 0) out.answers.push_back(line.substr(7));
    std::istringstream words(line);
    std::string first, name;
    double value = 0;
    if (!word.empty() && (!(words >> first) || first != word)) continue;
    if (words >> name >> value) out.values[name] = value;
  }
}

std::string write_guest_files(const tools::Recording& recording) {
  const std::string in = scratch_folder("usb_in");
  Text<kCalibrationTextMax> calibration;
  write_calibration(recording.calibration, calibration);
  std::ofstream(in + "/calibration.cfg") << calibration.c_str();
  const Camera& camera = recording.calibration.camera[0];
  std::ofstream(in + "/device.cfg")
      << "calibration = calibration.cfg\n"
         "camera.left = /dev/video0\n"
         "camera.right = /dev/video1\n"
         "imu = iio:mpu6500\n"
         "output.text = frames\n"
         "output.poses = 192.168.7.2:14550\n"
         "output.serial = /dev/ttyGS0\n"
         "output.images = /run/pirvs/images\n"
         "recordings = /run/recordings\n"
         "usb.serial = 0001\n"
         "usb.video = left\n"
      << "usb.size = " << camera.width << " " << camera.height << "\n";
  std::ofstream(in + "/guest") << "width=" << camera.width << "\nheight=" << camera.height
                               << "\nseconds=" << seconds() << "\n";
  tools::write_pack(recording, in + "/recording.pack", [](size_t, size_t) {});
  return in;
}

UsbRun run_usb() {
  const char* const given = std::getenv("PIRVS_BUILD");
  const std::string build = given != nullptr ? given : "build", folder = build + "/test/usb";
  const std::string in = write_guest_files(rest());
  std::string command = "tools/device/run --kernel " + build + "/device --recording " + in +
                        "/recording.pack --out " + folder + " --timeout 500";
  for (const char* module :
       {"virtio_pci", "virtio_blk", "videodev", "videobuf2-v4l2", "videobuf2-vmalloc",
        "industrialio-triggered-buffer", "inv-mpu6050-i2c", "libcomposite", "usb_f_acm",
        "usb_f_ncm", "usb_f_uvc", "udc-core", "usbcore", "cdc-acm", "cdc_ncm", "uvcvideo"}) {
    command += std::string(" --module ") + module;
  }
  command += " /init=tests/device/guest/usb_init";
  for (const char* program : {"pirvsd", "pirvs-usb"}) {
    command += std::string(" /bin/") + program + "=" + build + "/ironsides/" + program;
  }
  for (const char* program : {"feeder", "usb_peer"}) {
    command += std::string(" /bin/") + program + "=" + build + "/device/" + program;
  }
  for (const char* module : {"test_camera.ko", "test_gpio.ko", "test_imu.ko", "dummy_hcd.ko"}) {
    command += std::string(" /modules/") + module + "=" + build + "/device/modules/" + module;
  }
  for (const char* file : {"device.cfg", "calibration.cfg", "guest"}) {
    command += std::string(" /config/") + file + "=" + in + "/" + file;
  }
  UsbRun out;
  out.status = std::system(command.c_str());
  out.console = text_of(folder + "/console");
  out.states = text_of(folder + "/states");
  out.devices = text_of(folder + "/devices");
  out.usb = text_of(folder + "/usb");
  out.news = text_of(folder + "/news");
  out.recordings = text_of(folder + "/recordings");
  out.peer = text_of(folder + "/peer") + text_of(folder + "/cost");
  read_values(out.peer, "", out);
  read_values(out.news, "counter", out);
  return out;
}

class usb : public testing::Test {
 protected:
  // Shared: a minute.
  static const UsbRun& run() {
    static const UsbRun once = run_usb();
    return once;
  }
  void SetUp() override { ASSERT_EQ(run().status, 0) << run().console; }
};

TEST_F(usb, is_a_network_a_serial_line_and_a_camera) {
  std::printf("%s%s", run().peer.c_str(), run().usb.c_str());
  for (const char* device : {"usb0", "usb1", "/dev/ttyACM0", "/dev/ttyGS0"}) {
    EXPECT_NE(run().devices.find(device), std::string::npos) << device << "\n" << run().devices;
  }
  EXPECT_EQ(run().value("video.width"), 640);
  EXPECT_EQ(run().value("video.height"), 480);
  EXPECT_EQ(run().value("video.grey"), 1);
}

// A predecessor that was killed takes the gadget from the bus, and nothing of it stands in the way.
TEST_F(usb, comes_and_goes_in_order) {
  EXPECT_NE(run().states.find("before the kill: gadget pirvs, host ttyACM0"), std::string::npos);
  EXPECT_NE(run().states.find("after it: gadget pirvs, host \n"), std::string::npos);
  EXPECT_NE(run().states.find("held: gadget pirvs, host ttyACM0"), std::string::npos);
  EXPECT_NE(run().states.find("ended: gadget , host \n"), std::string::npos) << run().states;
  EXPECT_NE(run().usb.find("pirvs-usb ended with 0"), std::string::npos) << run().usb;
  EXPECT_NE(run().news.find("pirvsd ended with 0"), std::string::npos) << run().news;
}

TEST_F(usb, no_pose_is_missing) {
  for (const std::string way : {"network", "serial"}) {
    EXPECT_GE(run().value(way + ".lines"), kRate_hz * (seconds() - 1)) << way;
    EXPECT_NEAR(run().value(way + ".seconds"), seconds(), 1) << way;
    EXPECT_EQ(run().value(way + ".missing"), 0) << way;
    EXPECT_EQ(run().value(way + ".torn"), 0) << way;
  }
  EXPECT_EQ(run().value("output.dropped"), -1) << "counters that are zero are not told";
}

// Both ends count, and dummy_hcd's polling beside them: an upper bound of what the device does.
TEST_F(usb, poses_cost_little) {
  constexpr double kCore = 0.05, kBytes_s = 60'000;
  EXPECT_LT(run().value("network.bytes_a_second"), kBytes_s);
  EXPECT_GT(run().value("network.bytes_a_second"), 0.25 * kBytes_s);
  for (const char* way : {"cost.datagrams", "cost.serial"}) {
    EXPECT_GT(run().value(way), 0) << way;
    EXPECT_LT(run().value(way), kCore) << way;
  }
}

TEST_F(usb, the_line_obeys) {
  const std::vector<std::string> first = {
      "ok help: stop, reset",
      "ok pose ",
      "ok parameter",
      "error parameter: not found",
      "error a line that is too long, or no text",
      "error a line that is too long, or no text",
      "error map save|load NAME",
      "ok record start",
      "ok record stop",
      "ok counters ",
      "ok record start",
      "ok record stop",
  };
  // Once the cable is back; what the terminal echoed before it was raw may have an answer before.
  const std::vector<std::string> last = {"ok reset", "ok stop"};
  const std::vector<std::string>& answers = run().answers;
  ASSERT_GE(answers.size(), first.size() + last.size()) << run().peer;
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(answers[i].substr(0, first[i].size()), first[i]);
  }
  EXPECT_TRUE(std::equal(last.rbegin(), last.rend(), answers.rbegin())) << run().peer;
  EXPECT_GT(run().value("disk.flushes"), 0) << "of the recording that was started by command";
  // Of two, neither over the other, nor over what was there before.
  EXPECT_EQ(run().recordings, "0007\n0008\n0009\n0008/mav0/order.csv\n0009/mav0/order.csv\n");
}

TEST_F(usb, shows_the_cameras_pixels) {
  EXPECT_EQ(run().value("video.other"), 0) << "another image than any that was fed";
  EXPECT_EQ(run().value("video.damaged"), 0);
  EXPECT_EQ(run().value("video.skipped"), 0);
  EXPECT_EQ(run().value("images.lost"), -1);
}

TEST_F(usb, the_camera_comes_back_when_its_program_is_killed) {
  EXPECT_EQ(run().value("killed"), 1);
  constexpr double kBefore_s = 3, kAfter_s = 6;  // as usb_peer.cc has it
  EXPECT_GE(run().value("video.before_kill"), kFrames_hz * (kBefore_s - 0.5));
  EXPECT_GE(run().value("video.after_kill"), kFrames_hz * (kAfter_s - 2.5));
  EXPECT_NE(run().usb.find("pirvs-video: ended, starting it again"), std::string::npos);
}

TEST_F(usb, all_comes_back_when_the_cable_is_put_back) {
  EXPECT_EQ(run().value("replug.gone"), 1);
  EXPECT_GE(run().value("replug.lines"), 2 * kRate_hz);
  EXPECT_EQ(run().value("replug.missing"), 0);
  EXPECT_GE(run().value("replug.same"), kFrames_hz);
  EXPECT_EQ(run().value("serial.opened"), 2);
  EXPECT_GT(run().value("serial.dropped"), 0) << "nobody read the line for a while";
  EXPECT_LT(run().value("serial.dropped"), 3 * kRate_hz);
}

// pirvsd copies images while a host looks, and no others but those on their way at its end.
TEST_F(usb, no_image_leaves_pirvsd_while_nobody_looks) {
  constexpr double kOnTheWay = 4;
  const double seen = run().value("video.same") + run().value("replug.same");
  EXPECT_GE(run().value("images.sent"), seen);
  EXPECT_LE(run().value("images.sent"), seen + 4 * kOnTheWay);
}

}  // namespace
}  // namespace pirvs::systems
