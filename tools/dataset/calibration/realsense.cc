// What `rs-enumerate-devices -c` prints of a RealSense: lenses at each size, transforms.
// Source  librealsense, tools/enumerate-devices, rs_types.h, doc/d435i.md: an extrinsic from X to Y
//         is p_Y = R p_X + t, R printed by rows, t in metres; the IMU's stream is turned to the
//         axes of its extrinsics, and corrected by its motion intrinsics, by librealsense itself.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "tools/dataset/calibration/rig_file.h"

namespace pirvs::tools {
namespace {

constexpr const char* kCalibrateAgain = "calibrate with Kalibr (docs/sensors.md)";
constexpr const char* kPrintAgain = "print it again: rs-enumerate-devices -c > FILE";

std::string text_of(const std::string& path) {
  std::ostringstream out;
  out << std::ifstream(path, std::ios::binary).rdbuf();
  return out.str();
}

// What stands between quotes.
std::vector<std::string> quoted(const std::string& line) {
  std::vector<std::string> out;
  for (size_t at = line.find('"'); at != std::string::npos;) {
    const size_t end = line.find('"', at + 1);
    if (end == std::string::npos) break;
    out.push_back(line.substr(at + 1, end - at - 1));
    at = line.find('"', end + 1);
  }
  return out;
}

// The finite numbers of a line; none if something else stands between them.
std::vector<double> numbers_of(const std::string& line) {
  constexpr const char* kBlank = " \t\r";
  std::vector<double> out;
  for (size_t at = line.find_first_not_of(kBlank); at != std::string::npos;) {
    const size_t end = std::min(line.find_first_of(kBlank, at), line.size());
    double value = 0;
    const auto [next, error] = std::from_chars(line.data() + at, line.data() + end, value);
    if (error != std::errc() || next != line.data() + end || !std::isfinite(value)) return {};
    out.push_back(value);
    at = line.find_first_not_of(kBlank, end);
  }
  return out;
}

struct Stream {
  std::string name;
  std::vector<Lens> sizes;
};

struct Extrinsic {
  std::string from, to;
  SE3 T;  // from -> to
};

class Printed {
 public:
  explicit Printed(const std::string& path) : file_(path, YAML::Node()) {
    std::istringstream text(text_of(path));
    for (std::string line; std::getline(text, line);) lines_.push_back(line);
    read();
  }

  const Document& file() const { return file_; }
  bool corrects_imu() const { return corrects_imu_; }
  const Stream* stream(const std::string& name) const {
    const auto found = std::find_if(streams_.begin(), streams_.end(),
                                    [&](const Stream& s) { return s.name == name; });
    return found == streams_.end() ? nullptr : &*found;
  }
  // Of either direction.
  std::optional<SE3> transform(const std::string& from, const std::string& to) const {
    for (const Extrinsic& e : extrinsics_) {
      if (e.from == from && e.to == to) return e.T;
      if (e.from == to && e.to == from) return e.T.inverse();
    }
    return std::nullopt;
  }

 private:
  Document file_;
  std::vector<std::string> lines_;
  std::vector<Stream> streams_;
  std::vector<Extrinsic> extrinsics_;
  bool corrects_imu_ = false;

  // What stands behind a label among the few lines behind `at`, before the next part begins.
  std::optional<std::string> behind(size_t at, const char* label) const {
    constexpr size_t kPart = 12;
    for (size_t i = at + 1; i < std::min(lines_.size(), at + kPart); ++i) {
      if (lines_[i].find('"') != std::string::npos) break;
      const size_t found = lines_[i].find(label);
      if (found != std::string::npos) return lines_[i].substr(found + std::string(label).size());
    }
    return std::nullopt;
  }

  std::vector<double> numbers(size_t at, const char* label, size_t count) const {
    const auto text = behind(at, label);
    const auto out = text ? numbers_of(*text) : std::vector<double>();
    if (out.size() == count) return out;
    file_.fail("needs " + std::to_string(count) + " numbers behind '" + label + "'", where(at),
               kPrintAgain);
  }
  std::string where(size_t at) const { return "line " + std::to_string(at + 1); }

  void read() {
    size_t devices = 0;
    for (size_t i = 0; i < lines_.size(); ++i) {
      const std::string& line = lines_[i];
      devices += line.find("Intrinsic Parameters:") != std::string::npos &&
                 line.find("Motion") == std::string::npos;
      const auto names = quoted(line);
      if (names.size() == 1 && line.find("Motion Intrinsic of") != std::string::npos) {
        read_motion(i);
      } else if (names.size() == 1 && line.find("Intrinsic of") != std::string::npos) {
        read_lens(i, names[0]);
      } else if (names.size() == 2 && line.find("Extrinsic from") != std::string::npos) {
        read_extrinsic(i, names[0], names[1]);
      }
    }
    if (devices > 1) {
      file_.fail("several devices", "Intrinsic Parameters", "leave one device's part in the file");
    }
  }

  void read_lens(size_t at, const std::string& name) {
    if (behind(at, "NOT available")) return;
    Lens lens;
    const std::string key = name + ", " + where(at);
    const auto one = [&](const char* label) { return numbers(at, label, 1)[0]; };
    set_size(file_, one("Width:"), one("Height:"), key.c_str(), lens);
    set_intrinsics(file_, {one("Fx:"), one("Fy:"), one("PPX:"), one("PPY:")}, key.c_str(), lens);
    set_model(behind(at, "Distortion:").value_or(""), numbers(at, "Coeffs:", 5), key, lens);
    if (stream(name) == nullptr) streams_.push_back({name, {}});
    for (Stream& found : streams_) {
      if (found.name != name) continue;
      const bool known =
          std::any_of(found.sizes.begin(), found.sizes.end(), [&](const Lens& before) {
            return before.width == lens.width && before.height == lens.height;
          });
      if (!known) found.sizes.push_back(lens);
    }
  }

  void set_model(const std::string& text, std::vector<double> d, const std::string& key,
                 Lens& lens) const {
    const size_t begin = std::min(text.find_first_not_of(" \t"), text.size());
    const std::string model = text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
    const bool zero = std::all_of(d.begin(), d.end(), [](double k) { return k == 0; });
    const char* ours = model.c_str();
    if (zero) {
      ours = "none";
      d.clear();
    } else if (model == "Brown Conrady") {
      ours = "radtan";
    } else if (model == "Kannala Brandt4") {
      ours = "equidistant";
      d.resize(4);
    } else if (model == "Ftheta" || model == "F-Theta") {
      ours = "fov";
      d.resize(1);
    } else if (model == "Inverse Brown Conrady" || model == "Modified Brown Conrady") {
      file_.fail("the lens model '" + model + "' is not computed here", key, kCalibrateAgain);
    }
    set_distortion(file_, ours, key.c_str(), d, key.c_str(), lens);
  }

  void read_motion(size_t at) {
    constexpr size_t kRows = 3;
    for (size_t i = at + 1; i < lines_.size() && i < at + 6; ++i) {
      if (lines_[i].find("Sensitivity") == std::string::npos) continue;
      for (size_t row = 0; row < kRows && i + 1 + row < lines_.size(); ++row) {
        const auto values = numbers_of(lines_[i + 1 + row]);
        for (size_t k = 0; k < values.size(); ++k) {
          corrects_imu_ |= values[k] != (k == row ? 1.0 : 0.0);
        }
      }
    }
  }

  void read_extrinsic(size_t at, const std::string& from, const std::string& to) {
    if (behind(at, "N/A") || !behind(at, "Rotation Matrix:")) return;
    size_t row = at + 1;
    while (lines_[row].find("Rotation Matrix:") == std::string::npos) ++row;
    SE3 T;
    for (size_t i = 0; i < 3; ++i) {
      const auto values = ++row < lines_.size() ? numbers_of(lines_[row]) : std::vector<double>();
      if (values.size() != 3) file_.fail("needs 3 rows of 3 numbers", where(row), kPrintAgain);
      for (int j = 0; j < 3; ++j) T.R(int(i), j) = values[size_t(j)];
    }
    T.R = file_.rotation(T.R, where(at).c_str());
    const auto t = numbers(at, "Translation Vector:", 3);
    T.p = Vec3(t[0], t[1], t[2]);
    extrinsics_.push_back({from, to, T});
  }
};

}  // namespace

bool is_realsense(const std::string& path) {
  constexpr size_t kHead = 1 << 20;
  std::ifstream file(path, std::ios::binary);
  std::string head(kHead, '\0');
  file.read(head.data(), kHead);
  head.resize(size_t(file.gcount()));
  return head.find("Intrinsic of \"") != std::string::npos ||
         head.find("Extrinsic from \"") != std::string::npos;
}

RigFile read_realsense(const std::string& path) {
  const Printed printed(path);
  const bool fisheye = printed.stream("Fisheye 1") != nullptr;
  const std::string left = fisheye ? "Fisheye 1" : "Infrared 1";
  const std::string right = fisheye ? "Fisheye 2" : "Infrared 2";
  RigFile out;
  for (const std::string& name : {left, right, std::string("Color")}) {
    const Stream* const stream = printed.stream(name);
    if (stream == nullptr && name != "Color") {
      printed.file().fail("no lens of \"" + name + "\"", "Intrinsic of", kPrintAgain);
    }
    if (stream == nullptr) continue;
    // An IMU is one chip: both its sensors have the same pose.
    auto T_BC = printed.transform(name, "Gyro");
    if (!T_BC) T_BC = printed.transform(name, "Accel");
    if (!T_BC) {
      printed.file().fail("no extrinsic of \"" + name + "\" to \"Gyro\"", "Extrinsic from",
                          "a device without an IMU needs one: " + std::string(kCalibrateAgain));
    }
    RigCamera camera;
    camera.name = "cam" + std::to_string(out.cameras.size());
    camera.lens = stream->sizes[0];
    camera.sizes = stream->sizes;
    camera.T_BC = *T_BC;
    out.cameras.push_back(camera);
  }
  out.usual = small_imu("a BMI055's");
  if (printed.corrects_imu()) {
    out.notes.push_back(
        "the IMU's scale and bias in the file are not taken out: librealsense does that itself "
        "where it is not turned off");
  }
  return out;
}

}  // namespace pirvs::tools
