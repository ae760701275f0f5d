// A recording as an ASL folder.
#include <filesystem>
#include <fstream>

#include "core/base/text.h"
#include "modules/recorder/sensor_yaml.h"
#include "tools/convert/image_files.h"
#include "tools/convert/writers.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/text_file.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

constexpr size_t kRow = 1024;

// Gone unless it got its name.
class Unfinished {
 public:
  explicit Unfinished(const std::string& out) : out_(out), part_(out + ".part") {
    if (fs::exists(out_)) throw InputError("is there already", out_, "choose another OUT");
    std::error_code error;
    fs::remove_all(part_, error);
  }
  ~Unfinished() {
    std::error_code error;
    fs::remove_all(part_, error);
  }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;
  std::string mav0() const { return part_ + "/mav0"; }
  void finish() const {
    std::error_code error;
    fs::rename(part_, out_, error);
    if (error) throw InputError("cannot write", out_, "check space and permissions");
  }

 private:
  std::string out_, part_;
};

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw InputError("cannot make the folder", path, "choose another OUT");
}

void put_triple(TextWriter& row, const Vec3& v) {
  for (int i = 0; i < 3; ++i) row.put(',').exact(v[i]);
}

void write_camera_yaml(const std::string& folder, const Camera& camera, TimeNs shift) {
  Text<4096> text;
  put_camera_yaml(text, camera, shift);
  TextFile file(folder + "/sensor.yaml");
  file.put(text.c_str());
  file.finish();
}

void write_imu(const std::string& folder, const Recording& recording) {
  Text<2048> text;
  put_imu_yaml(text, recording.calibration.imu, recording.calibration.imu_intrinsics);
  TextFile yaml(folder + "/sensor.yaml"), table(folder + "/data.csv");
  yaml.put(text.c_str());
  table.put(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y,w_RS_S_z,a_RS_S_x [m s^-2],a_RS_S_y,"
      "a_RS_S_z\n");
  for (const ImuSample& sample : recording.imu) {
    Text<kRow> row;
    row.number(sample.t);
    put_triple(row, sample.w_B);
    put_triple(row, sample.f_B);
    table.put(row.put('\n').c_str());
  }
  yaml.finish();
  table.finish();
}

void write_truth(const std::string& folder, const Trajectory& truth) {
  make_folder(folder);
  TextFile table(folder + "/data.csv");
  table.put("#timestamp [ns],p_RS_R_x [m],p_RS_R_y,p_RS_R_z,q_RS_w [],q_RS_x,q_RS_y,q_RS_z");
  if (truth.full_state) {
    table.put(
        ",v_RS_R_x [m s^-1],v_RS_R_y,v_RS_R_z,b_w_RS_S_x [rad s^-1],b_w_RS_S_y,b_w_RS_S_z,"
        "b_a_RS_S_x [m s^-2],b_a_RS_S_y,b_a_RS_S_z");
  }
  table.put("\n");
  for (const TrajectoryPose& pose : truth.poses) {
    Text<kRow> row;
    row.number(pose.t);
    put_triple(row, pose.p_WB);
    for (const int i : {3, 0, 1, 2}) row.put(',').exact(pose.q_WB[i]);
    if (truth.full_state) {
      for (const Vec3* v : {&pose.v_WB, &pose.b_g, &pose.b_a}) put_triple(row, *v);
    }
    table.put(row.put('\n').c_str());
  }
  table.finish();
}

void write_image(const std::string& path, const EncodedImage& image) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(image.bytes.data()),
             std::streamsize(image.bytes.size()));
  file.close();
  if (!file) throw InputError("cannot write", path, "check space and permissions");
}

void write_images(const std::string& mav0, const Recording& recording, const FrameDone& done,
                  InputLog& log) {
  const int cameras = recording.calibration.cameras;
  std::vector<TextFile> tables;
  for (int c = 0; c < cameras; ++c) {
    const std::string folder = mav0 + "/cam" + std::to_string(c);
    make_folder(folder + "/data");
    write_camera_yaml(folder, recording.calibration.camera[c],
                      recording.calibration.camera_time_offset_ns);
    tables.emplace_back(folder + "/data.csv");
    tables.back().put("#timestamp [ns],filename\n");
  }
  ImageFiles images(recording);
  for (size_t i = 0; i < recording.frames.size(); ++i) {
    EncodedImage image[2];
    images.next(image);
    const std::string t = std::to_string(recording.frames[i].t);
    for (int c = 0; c < cameras; ++c) {
      if (image[c].format.empty()) continue;
      const std::string name = t + "." + image[c].format;
      write_image(mav0 + "/cam" + std::to_string(c) + "/data/" + name, image[c]);
      tables[size_t(c)].put((t + "," + name + "\n").c_str());
    }
    done(i + 1);
  }
  for (TextFile& table : tables) table.finish();
  for (const Count& count : images.rejected()) log.count(count.name, count.value);
}

// GNSS and wheels, as the folder has them.
void copy_sensor(const Recording& recording, const char* sensor, size_t rows,
                 const std::string& mav0, InputLog& log) {
  if (rows == 0) return;
  for (const char* between : {"/mav0/", "/"}) {
    const std::string from = recording.folder + between + sensor;
    if (!fs::is_regular_file(from + "/data.csv")) continue;
    std::error_code error;
    fs::copy(from, mav0 + "/" + sensor, fs::copy_options::recursive, error);
    if (error) throw InputError("cannot copy", from, "check space and permissions");
    return;
  }
  log.note(std::to_string(rows) + " rows of " + sensor + " are left out");
}

}  // namespace

void write_asl(const Recording& recording, const std::string& out, const FrameDone& done,
               InputLog& log) {
  const Unfinished folder(out);
  const std::string mav0 = folder.mav0();
  make_folder(mav0 + "/imu0");
  write_imu(mav0 + "/imu0", recording);
  if (!recording.truth.poses.empty()) {
    write_truth(mav0 + "/state_groundtruth_estimate0", recording.truth);
  }
  copy_sensor(recording, "gnss0", recording.gnss.size(), mav0, log);
  copy_sensor(recording, "wheel0", recording.wheels.size(), mav0, log);
  write_images(mav0, recording, done, log);
  folder.finish();
}

}  // namespace pirvs::tools
