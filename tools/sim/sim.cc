#include "tools/sim/sim.h"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <thread>
#include <vector>

#include "core/base/text.h"
#include "modules/imu/imu_params.h"
#include "modules/mapping/mapping_params.h"
#include "modules/recorder/sensor_yaml.h"
#include "tools/dataset/calibration/rig_file.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/text_file.h"
#include "tools/sim/motion.h"
#include "tools/sim/random.h"
#include "tools/sim/render.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kBegin = 1'600'000'000'000'000'000;
constexpr double kFirstFrame_s = 0.1;  // some IMU samples come first
constexpr double kLastFrame_s = 0.05;  // and some last

struct Job {
  const SimOptions& options;
  Device device;
  Path path;
  Scene scene;
  std::vector<double> frame_s;
  std::vector<Vec3> rays_C[2];  // of a lens that the stack does not compute, else empty
};

using LongLong = long long;  // what %lld prints

TimeNs stamp(double t_s) { return kBegin + from_seconds(t_s); }

// On the cameras' clock.
TimeNs frame_stamp(const Job& job, size_t frame) {
  return stamp(job.frame_s[frame]) - job.device.calibration.camera_time_offset_ns;
}

std::string image_name(const Job& job, size_t frame) {
  return std::to_string(frame_stamp(job, frame)) + "." + job.options.format;
}

// One that was calibrated: its IMU has the errors that its calibration says, its cameras their
// clock.
Device calibrated_device(const std::string& path) {
  InputLog log;
  RigOptions how;
  how.as_mounted = true;
  Device out{"calibrated", read_rig(path, how, log).calibration, 30, {}};
  if (out.calibration.cameras < 2) throw InputError("one camera alone", path, "give one of both");
  Mat3 R_LC;  // the camera's right, down, forward in forward, left, up
  R_LC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  out.R_LB = R_LC * out.calibration.camera[0].T_BC.R.transpose();
  return out;
}

// What a file's lens does itself, where the calibration only comes near it.
void take_own_rays(const std::string& path, std::vector<Vec3>* rays_C /* [2] */) {
  if (find_device(path) != nullptr || fs::path(path).extension() == ".cfg") return;
  const RigFile file = read_rig_file(path);
  for (size_t c = 0; c < 2; ++c) {
    const Lens lens = lens_at(file, file.cameras.at(c), 0, 0, path);
    if (!fit(lens).exact) rays_C[c] = rays_of(lens);
  }
}

Device make_device(const SimOptions& options) {
  const Device* const found = find_device(options.device);
  if (!found && !fs::is_regular_file(options.device)) {
    throw InputError("unknown device '" + options.device + "'", "--camera",
                     "use euroc, ironsides, tumvi, t265, oakd or the file of a calibration");
  }
  Device device = found ? *found : calibrated_device(options.device);
  if (options.rate_hz > 0) device.camera_rate_hz = options.rate_hz;
  ImuNoise& noise = device.calibration.imu;
  if (options.gyro_noise >= 0) noise.gyro_noise = options.gyro_noise;
  if (options.gyro_walk >= 0) noise.gyro_walk = options.gyro_walk;
  if (options.accel_noise >= 0) noise.accel_noise = options.accel_noise;
  if (options.accel_walk >= 0) noise.accel_walk = options.accel_walk;
  return device;
}

Path make_path(const SimOptions& options, const Device& device) {
  if (options.path == "steady") {
    SteadyMotion steady;
    steady.rest_s = options.rest_s;
    steady.ramp_s = options.ramp_s;
    steady.v_L = Vec3(options.forward_m_s, options.left_m_s, 0);
    steady.turn_rad_s = options.turn_deg_s * M_PI / 180;
    return Path::steady(steady, options.duration_s, device.R_LB);
  }
  Motion motion = Motion::kHover;
  if (find_motion(options.path, motion)) {
    return make_motion(motion, options.seed, options.rest_s, options.duration_s, device.R_LB);
  }
  if (options.path != "spline" && options.path != "rest") {
    return Path::along(read_trajectory(options.path), options.duration_s);
  }
  const double rest_s = options.path == "rest" ? options.duration_s : options.rest_s;
  return Path::flight(options.seed, rest_s, options.duration_s, device.R_LB);
}

// At a fixed distance before the left camera's first place, as wide as its share of the image or a
// little wider.
Pillar make_pillar(const SimOptions& options, const Device& device, const Path& path) {
  constexpr double kDistance_m = 1.5;
  constexpr double kSway = 0.7;  // of its width
  Pillar pillar;
  if (options.mover <= 0) return pillar;
  const PathState at = path.at(0);
  const Camera& camera = device.calibration.camera[0];
  const SE3 T_WC = SE3{at.R_WB, at.p_WB} * camera.T_BC;
  const double width = camera.width * options.mover / camera.fx * kDistance_m;
  const Vec3 forward = Vec3(T_WC.R(0, 2), T_WC.R(1, 2), 0).normalized();
  pillar.sideways_W = Vec3(-forward.y(), forward.x(), 0);
  // Its sides are parallel to the hall's: seen askew, it is wider.
  pillar.width_m = width / (std::abs(forward.x()) + std::abs(forward.y()));
  pillar.sway_m = kSway * width;
  pillar.p_W = T_WC.p + kDistance_m * forward;
  pillar.from_s = options.mover_from_s;
  return pillar;
}

SceneOptions make_scene_options(const SimOptions& options, const Pillar& pillar) {
  SceneOptions out;
  out.room = options.room != 0;
  if (!out.room && (options.gone > 0 || options.relit)) {
    throw InputError("needs a room", "--gone, --relit", "add --room NUMBER");
  }
  if (out.room && options.path != "spline" && options.path != "rest") {
    throw InputError("a room is for flights", "--path " + options.path, "use spline or rest");
  }
  out.seed = out.room ? options.room : options.seed;
  out.visit = options.seed;
  out.boxes = options.boxes;
  out.movers = options.movers;
  out.gone = options.gone;
  out.relit = options.relit;
  out.surfaces = options.surfaces == "chequered" ? Surfaces::kChequered
                 : options.surfaces == "plain"   ? Surfaces::kPlain
                                                 : Surfaces::kMixed;
  out.pillar = pillar;
  return out;
}

void write_transform(TextFile& file, const SE3& T) {
  file.print("T_BS:\n  cols: 4\n  rows: 4\n  data: [");
  for (int i = 0; i < 3; ++i) {
    file.print("%.15g, %.15g, %.15g, %.15g,\n         ", T.R(i, 0), T.R(i, 1), T.R(i, 2), T.p[i]);
  }
  file.print("0.0, 0.0, 0.0, 1.0]\n");
}

void write_camera(const Job& job, int c) {
  const std::string folder = job.options.out + "/mav0/cam" + std::to_string(c);
  const Camera& camera = job.device.calibration.camera[c];
  TextFile sensor(folder + "/sensor.yaml");
  sensor.print("sensor_type: camera\ncomment: simulated %s cam%d\n", job.device.name, c);
  write_transform(sensor, camera.T_BC);
  sensor.print("rate_hz: %g\nresolution: [%d, %d]\ncamera_model: pinhole\n",
               job.device.camera_rate_hz, camera.width, camera.height);
  sensor.print("intrinsics: [%.9g, %.9g, %.9g, %.9g]\n", camera.fx, camera.fy, camera.cx,
               camera.cy);
  const bool radtan = camera.model == CameraModel::kPinholeRadtan;
  sensor.print("distortion_model: %s\n", radtan ? "radial-tangential" : "equidistant");
  sensor.print("distortion_coefficients: [%.12g, %.12g, %.12g, %.12g]\n", camera.d[0], camera.d[1],
               camera.d[2], camera.d[3]);
  const TimeNs offset = job.device.calibration.camera_time_offset_ns;
  if (offset != 0) sensor.print("timeshift_cam_imu: %.9f\n", to_seconds(offset));
  TextFile list(folder + "/data.csv");
  list.print("#timestamp [ns],filename\n");
  for (size_t i = 0; i < job.frame_s.size(); ++i) {
    list.print("%lld,%s\n", LongLong(frame_stamp(job, i)), image_name(job, i).c_str());
  }
  sensor.finish();
  list.finish();
}

void write_imu(const Job& job) {
  const std::string mav0 = job.options.out + "/mav0";
  const ImuNoise& told = job.device.calibration.imu;
  ImuModel model{told, job.options.gyro_bias_rad_s, job.options.accel_bias_m_s2};
  if (job.options.imu_as_expected) {
    const MappingParams expected;
    model = {scaled(told, ImuParams{}), double(expected.start_sigma_gyro_bias),
             double(expected.start_sigma_accel_bias)};
  }
  TextFile sensor(mav0 + "/imu0/sensor.yaml");
  sensor.print("sensor_type: imu\ncomment: simulated %s IMU\n", job.device.name);
  write_transform(sensor, SE3{});
  // A recording without noise still needs densities above zero to be estimated with.
  const auto density = [](double value, double least) { return std::max(value, least); };
  sensor.print("rate_hz: %g\n", told.rate_hz);
  sensor.print("gyroscope_noise_density: %.6g\n", density(told.gyro_noise, 1e-5));
  sensor.print("gyroscope_random_walk: %.6g\n", density(told.gyro_walk, 1e-6));
  sensor.print("accelerometer_noise_density: %.6g\n", density(told.accel_noise, 1e-4));
  sensor.print("accelerometer_random_walk: %.6g\n", density(told.accel_walk, 1e-5));
  const ImuIntrinsics& errors = job.device.calibration.imu_intrinsics;
  Text<2048> intrinsics;
  put_intrinsics(intrinsics, errors);
  sensor.put(intrinsics.c_str());
  TextFile samples(mav0 + "/imu0/data.csv");
  samples.print("#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y,w_RS_S_z,a_RS_S_x [m s^-2],");
  samples.print("a_RS_S_y,a_RS_S_z\n");
  TextFile truth(mav0 + "/state_groundtruth_estimate0/data.csv");
  truth.print("#timestamp [ns],p_RS_R_x [m],p_RS_R_y,p_RS_R_z,q_RS_w [],q_RS_x,q_RS_y,q_RS_z,");
  truth.print("v_RS_R_x [m s^-1],v_RS_R_y,v_RS_R_z,b_w_RS_S_x [rad s^-1],b_w_RS_S_y,");
  truth.print("b_w_RS_S_z,b_a_RS_S_x [m s^-2],b_a_RS_S_y,b_a_RS_S_z\n");
  for (const SimulatedImu& imu : simulate_imu(job.path, model, kBegin, job.options.seed)) {
    const auto triple = [](TextFile& file, const Vec3& v) {
      file.print(",%.9f,%.9f,%.9f", v.x(), v.y(), v.z());
    };
    samples.print("%lld", LongLong(imu.sample.t));
    // Zeros of either sign are written as they are.
    const Vec3 w_B = errors.gyro * imu.sample.w_B + errors.b_g;
    const Vec3 f_B = errors.accel * imu.sample.f_B + errors.b_a;
    triple(samples, errors.given() ? w_B : imu.sample.w_B);
    triple(samples, errors.given() ? f_B : imu.sample.f_B);
    samples.print("\n");
    const Vec4& q = imu.truth.q_WB;
    truth.print("%lld", LongLong(imu.sample.t));
    triple(truth, imu.truth.p_WB);
    truth.print(",%.9f,%.9f,%.9f,%.9f", q[3], q[0], q[1], q[2]);
    triple(truth, imu.truth.v_WB);
    triple(truth, imu.b_g);
    triple(truth, imu.b_a);
    truth.print("\n");
  }
  for (TextFile* file : {&sensor, &samples, &truth}) file->finish();
}

Exposure exposure_of(const Job& job, size_t frame, int camera) {
  const SimOptions& o = job.options;
  const double t_s = job.frame_s[frame];
  Exposure exposure;
  exposure.t_s = t_s;
  exposure.length_s = o.blur > 1 ? o.exposure_ms * 1e-3 : 0;
  exposure.sub_images_max = o.blur;
  exposure.gain = 1 + o.exposure_change * (0.67 * std::sin(2.1 * t_s) + 0.33 * std::sin(7.3 * t_s));
  if (camera == 1) exposure.gain *= 1.04;  // no two sensors are alike
  const double dark_until_s = o.dark_for_s > 0 ? o.dark_from_s + o.dark_for_s : 1e9;
  if (t_s >= o.dark_from_s && t_s < dark_until_s) exposure.gain *= 1 - o.dark;
  exposure.noise_grey = o.image_noise;
  exposure.noise_stream = mix64(o.seed) + 2 * frame + uint64_t(camera);
  return exposure;
}

void write_image(const std::string& path, const Camera& camera, std::vector<uint8_t>& pixels) {
  const cv::Mat image(camera.height, camera.width, CV_8UC1, pixels.data());
  const std::vector<int> how = {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_JPEG_QUALITY, 95};
  bool written = false;
  try {
    written = cv::imwrite(path, image, how);
  } catch (const cv::Exception&) {
  }
  if (!written) throw InputError("cannot write the image", path, "check space and --format");
}

void draw_frames(const Job& job, std::atomic<size_t>& next, const std::function<void()>& done) {
  std::unique_ptr<Renderer> renderer[2];
  for (int c = 0; c < 2; ++c) {
    const Camera& camera = job.device.calibration.camera[c];
    renderer[c] = std::make_unique<Renderer>(camera, job.scene, job.path, job.rays_C[c]);
  }
  std::vector<uint8_t> pixels;
  for (size_t i = next++; i < job.frame_s.size(); i = next++) {
    for (int c = 0; c < 2; ++c) {
      renderer[c]->render(exposure_of(job, i, c), pixels);
      const std::string folder = job.options.out + "/mav0/cam" + std::to_string(c) + "/data/";
      write_image(folder + image_name(job, i), job.device.calibration.camera[c], pixels);
    }
    done();
  }
}

void draw_all(const Job& job, const SimProgress& progress) {
  std::atomic<size_t> next{0};
  std::mutex mutex;
  size_t count = 0;
  std::exception_ptr failure;
  const auto done = [&] {
    const std::lock_guard<std::mutex> lock(mutex);
    progress(++count, job.frame_s.size());
  };
  std::vector<std::thread> threads;
  for (int k = 0; k < job.options.threads; ++k) {
    threads.emplace_back([&] {
      try {
        draw_frames(job, next, done);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        failure = std::current_exception();
        next = job.frame_s.size();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

void make_folders(const std::string& out) {
  for (const char* folder : {"cam0/data", "cam1/data", "imu0", "state_groundtruth_estimate0"}) {
    const std::string path = out + "/mav0/" + folder;
    std::error_code error;
    fs::create_directories(path, error);
    if (error) throw InputError("cannot make the folder", path, "choose another --out");
  }
}

}  // namespace

void simulate(const SimOptions& options, const SimProgress& progress) {
  constexpr const char* kTruth = "/state_groundtruth_estimate0/data.csv";
  if (!options.gnss_of.empty()) {
    const std::string mav0 =
        options.gnss_of + (fs::exists(options.gnss_of + "/mav0") ? "/mav0" : "");
    return write_gnss(options.gnss, read_trajectory(mav0 + kTruth), options.seed, options.out);
  }
  const Device device = make_device(options);
  Path path = make_path(options, device);
  Scene scene(path, make_scene_options(options, make_pillar(options, device, path)));
  Job job{options, device, std::move(path), std::move(scene), {}, {}};
  take_own_rays(options.device, job.rays_C);
  const double end_s = job.path.duration_s() - kLastFrame_s;
  for (size_t i = 0;; ++i) {
    const double t_s = kFirstFrame_s + double(i) / device.camera_rate_hz;
    if (t_s > end_s) break;
    job.frame_s.push_back(t_s);
  }
  if (job.frame_s.empty()) throw InputError("no frame fits", "--duration", "make it longer");
  make_folders(options.out);
  write_camera(job, 0);
  write_camera(job, 1);
  write_imu(job);
  const std::string mav0 = options.out + "/mav0";
  if (!options.gnss.kind.empty()) {
    write_gnss(options.gnss, read_trajectory(mav0 + kTruth), options.seed, mav0 + "/gnss0");
  }
  if (!options.wheels.kind.empty()) {
    const Mat3 R_BL = device.R_LB.transpose();
    const SE3 T_BV{R_BL, R_BL * axle_L(options.path)};
    write_wheels(options.wheels, read_trajectory(mav0 + kTruth), T_BV, options.seed,
                 mav0 + "/wheel0");
  }
  draw_all(job, progress);
}

}  // namespace pirvs::tools
