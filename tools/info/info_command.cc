// `pirvs info SEQ`: what is there, and whether it makes sense.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tools/cli/command.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/recording_options.h"
#include "tools/info/image_turn.h"
#include "tools/info/imu_sense.h"
#include "tools/info/info_report.h"
#include "tools/info/stereo_sense.h"

namespace pirvs::tools {
namespace {

constexpr double kDegree = M_PI / 180;

struct Options {
  std::string sequence, report;
  RecordingOptions recording;
};

template <class... Args>
void put(std::string& out, const char* how, Args... args) {
  char text[512];
  std::snprintf(text, sizeof text, how, args...);
  out += text;
}

struct Steps {
  double hz = 0, jitter_ms = 0, longest_s = 0;
};

template <class Rows>
Steps steps_of(const Rows& rows) {
  std::vector<double> steps;
  for (size_t i = 1; i < rows.size(); ++i) steps.push_back(to_seconds(rows[i].t - rows[i - 1].t));
  if (steps.empty()) return {};
  std::sort(steps.begin(), steps.end());
  const double middle = steps[steps.size() / 2];
  Steps out;
  out.hz = middle > 0 ? 1 / middle : 0;
  out.longest_s = steps.back();
  for (double& step : steps) step = std::abs(step - middle);
  std::sort(steps.begin(), steps.end());
  out.jitter_ms = 1e3 * steps[steps.size() * 95 / 100];
  return out;
}

void put_camera(const Recording& recording, int c, std::string& out) {
  const Camera& k = recording.calibration.camera[c];
  size_t images = 0;
  for (const FrameFiles& frame : recording.frames) {
    images += !frame.image[c].empty() || frame.pixels[c].data != nullptr;
  }
  Vec3 side_C, top_C;
  const bool seen = k.unproject(Vec2(0, k.cy), side_C) && k.unproject(Vec2(k.cx, 0), top_C);
  put(out, "%-8s %zu images, %d x %d, %s, fx %.1f fy %.1f cx %.1f cy %.1f",
      c == 0 ? "left" : "right", images, k.width, k.height,
      k.model == CameraModel::kPinholeRadtan ? "radtan" : "equidistant", k.fx, k.fy, k.cx, k.cy);
  if (seen) {
    put(out, ", sees %.0f degrees left, %.0f up", std::atan2(-side_C.x(), side_C.z()) / kDegree,
        std::atan2(-top_C.y(), top_C.z()) / kDegree);
  }
  put(out, "\n");
}

// The stillest second: what noise and gravity are there.
void put_rest(const Recording& recording, std::string& out) {
  constexpr TimeNs kSecond = 1'000'000'000;
  double least = INFINITY;
  Vec3 gyro_sigma = Vec3::Zero(), accel_sigma = Vec3::Zero(), force = Vec3::Zero();
  size_t end = 0;
  for (size_t begin = 0; begin < recording.imu.size(); begin += 20) {
    while (end < recording.imu.size() && recording.imu[end].t < recording.imu[begin].t + kSecond)
      ++end;
    if (end == recording.imu.size() || end - begin < 20) break;
    Vec3 w = Vec3::Zero(), f = Vec3::Zero(), w2 = Vec3::Zero(), f2 = Vec3::Zero();
    for (size_t i = begin; i < end; ++i) {
      w += recording.imu[i].w_B;
      f += recording.imu[i].f_B;
    }
    const double n = double(end - begin);
    w /= n, f /= n;
    for (size_t i = begin; i < end; ++i) {
      w2 += (recording.imu[i].w_B - w).cwiseAbs2();
      f2 += (recording.imu[i].f_B - f).cwiseAbs2();
    }
    if (w2.sum() / n >= least) continue;
    least = w2.sum() / n;
    gyro_sigma = (w2 / n).cwiseSqrt();
    accel_sigma = (f2 / n).cwiseSqrt();
    force = f;
  }
  if (!std::isfinite(least)) return;
  const ImuNoise& noise = recording.calibration.imu;
  const double root = std::sqrt(noise.rate_hz);
  put(out,
      "rest     the stillest second: force %.3f m/s^2; scatter of the gyro %.2g rad/s (the noise "
      "given: %.2g), "
      "of the force %.2g m/s^2 (%.2g)\n",
      force.norm(), gyro_sigma.norm() / std::sqrt(3.0), noise.gyro_noise * root,
      accel_sigma.norm() / std::sqrt(3.0), noise.accel_noise * root);
}

void put_streams(const Recording& recording, std::string& out) {
  const Steps frames = steps_of(recording.frames), imu = steps_of(recording.imu);
  put(out, "%s: %s, %.1f s\n", recording.folder.c_str(), recording.kind.c_str(),
      recording.duration_s());
  put(out, "frames   %zu at %.2f Hz, jitter %.2f ms, longest step %.3f s\n",
      recording.frames.size(), frames.hz, frames.jitter_ms, frames.longest_s);
  for (int c = 0; c < recording.calibration.cameras; ++c) put_camera(recording, c, out);
  if (recording.calibration.cameras == 2) {
    const SE3 T_C0C1 =
        recording.calibration.camera[0].T_BC.inverse() * recording.calibration.camera[1].T_BC;
    put(out, "baseline %.4f m\n", T_C0C1.p.norm());
  }
  put(out, "imu      %zu samples at %.1f Hz, jitter %.2f ms, longest step %.3f s\n",
      recording.imu.size(), imu.hz, imu.jitter_ms, imu.longest_s);
  put_rest(recording, out);
  put(out, "offset   %.4f s, t_imu = t_camera + offset\n",
      to_seconds(recording.calibration.camera_time_offset_ns));
  if (recording.truth.poses.empty()) {
    put(out, "truth    none\n");
  } else {
    put(out, "truth    %zu poses at %.1f Hz%s\n", recording.truth.poses.size(),
        steps_of(recording.truth.poses).hz,
        recording.truth.full_state ? ", with velocities and biases" : "");
  }
  if (!recording.gnss.empty()) put(out, "gnss     %zu fixes\n", recording.gnss.size());
}

// What was looked at besides, as far as it can be.
void put_turn(const ImageTurn& turn, std::string& out) {
  if (turn.enough) {
    put(out,
        "turn     of images and gyro agree by %.1f %% (as given: %.1f) over %zu pairs; stamps "
        "%+.1f ms, rotation %.1f degrees off, gyro over images %.3f\n",
        100 * turn.agreement, 100 * turn.as_given, turn.pairs, 1e3 * turn.late_s, turn.off_deg,
        turn.gyro_scale);
  } else {
    put(out, "turn     of images and gyro: too little to compare (%zu pairs, agreement %.0f %%)\n",
        turn.pairs, 100 * turn.agreement);
  }
}

void write_report(const std::string& path, const std::string& page) {
  std::ofstream file(path, std::ios::binary);
  file << page;
  file.close();
  if (!file) throw InputError("cannot write", path, "choose another --report");
}

int info(const Options& options) {
  const Recording recording = open_recording(options.sequence, options.recording);
  InfoFindings found;
  std::string& out = found.text;
  put_streams(recording, out);
  const ImuFault imu = find_imu_fault(recording.imu);
  if (!imu.what.empty()) found.faults.push_back(imu.what + ": " + imu.what_to_do);
  const StereoSense stereo = compare_cameras(recording);
  if (stereo.enough) {
    put(out, "pair     %zu matches, %.2f px off the epipolar curve, %.0f %% in front\n",
        stereo.matches, stereo.epipolar_px, 100 * stereo.in_front);
  }
  if (imu.what.empty()) {
    found.turn = compare_turns(recording);
    put_turn(found.turn, out);
    for (const std::string& fault : faults_of(found.turn)) found.faults.push_back(fault);
  }
  for (const std::string& fault : faults_of(stereo)) found.faults.push_back(fault);
  for (const std::string& note : recording.notes) out += "note     " + note + "\n";
  std::printf("%s", out.c_str());
  for (const std::string& fault : found.faults) std::fprintf(stderr, "pirvs: %s\n", fault.c_str());
  if (!options.report.empty()) write_report(options.report, info_report(recording, found));
  return found.faults.empty() ? kExitDone : kExitFailed;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("SEQ", o->sequence, "a recording, as for run")->required();
  add_recording_options(app, o->recording);
  app.add_option("--report", o->report, "FILE, also write a page with plots of it");
  app.footer("Exit status: 0 it makes sense, 1 it would run badly, and why, 2 it cannot be read.");
  return [o] { return info(*o); };
}

}  // namespace

const Command kInfoCommand = {"info", "Say what a recording holds and whether it makes sense",
                              declare};

}  // namespace pirvs::tools
