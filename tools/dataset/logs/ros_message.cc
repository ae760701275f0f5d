#include "tools/dataset/logs/ros_message.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/dataset/logs/mapped_file.h"

namespace pirvs::tools {
namespace {

constexpr TimeNs kSecond = 1'000'000'000;

// The fields of a message, from left to right; what is not there is zero, and good() false.
class Wire {
 public:
  Wire(Bytes bytes, bool cdr) : bytes_(bytes), cdr_(cdr) {
    if (!cdr) return;
    constexpr size_t kEncapsulation = 4;
    good_ = bytes.size >= kEncapsulation && bytes.data[0] == 0 && bytes.data[1] <= 1;
    swapped_ = good_ && bytes.data[1] == 0;  // big endian
    begin_ = at_ = good_ ? kEncapsulation : bytes.size;
  }
  template <class T>
  T number() {
    align(sizeof(T));
    if (bytes_.size - at_ < sizeof(T)) return fail<T>();
    uint8_t raw[sizeof(T)];
    for (size_t i = 0; i < sizeof(T); ++i) {
      raw[i] = bytes_.data[at_ + (swapped_ ? sizeof(T) - 1 - i : i)];
    }
    at_ += sizeof(T);
    T out;
    std::memcpy(&out, raw, sizeof out);
    return out;
  }
  std::string text() {
    const Bytes all = block(number<uint32_t>());
    const size_t size = cdr_ && all.size > 0 ? all.size - 1 : all.size;  // CDR counts the end
    return {reinterpret_cast<const char*>(all.data), size};
  }
  Bytes block(uint64_t size) {
    if (size > bytes_.size - at_) return fail<Bytes>();
    const Bytes out = {bytes_.data + at_, size_t(size)};
    at_ += size_t(size);
    return out;
  }
  Vec3 vector() {
    const double x = number<double>(), y = number<double>(), z = number<double>();
    return {x, y, z};
  }
  RosHeader header() {
    RosHeader out;
    if (!cdr_) (void)number<uint32_t>();  // sequence
    const auto s = number<uint32_t>();
    const auto ns = number<uint32_t>();
    out.t = TimeNs(s) * kSecond + TimeNs(ns);
    out.frame_id = text();
    return out;
  }
  bool good() const { return good_; }

 private:
  Bytes bytes_;
  bool cdr_, swapped_ = false, good_ = true;
  size_t begin_ = 0, at_ = 0;

  void align(size_t to) {
    if (!cdr_) return;
    const size_t over = (at_ - begin_) % to;
    if (over == 0) return;
    (void)block(to - over);
  }
  template <class T>
  T fail() {
    good_ = false;
    at_ = bytes_.size;
    return T{};
  }
};

// What an encoding's bytes are, and how they become grey; -1: they are.
struct Encoding {
  const char* name;
  int type;
  int to_grey;
};
constexpr Encoding kEncodings[] = {{"mono8", CV_8UC1, -1},
                                   {"8UC1", CV_8UC1, -1},
                                   {"mono16", CV_16UC1, -1},
                                   {"16UC1", CV_16UC1, -1},
                                   {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY},
                                   {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY},
                                   {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY},
                                   {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY},
                                   {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY},
                                   {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY},
                                   {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2},
                                   {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY},
                                   {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY},
                                   {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY},
                                   {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY}};

// 16 bits hold 10, 12 or 16 that count, as the decoder of image files takes them.
void narrow(cv::Mat& image, bool big_endian) {
  if (big_endian) {
    for (int y = 0; y < image.rows; ++y) {
      auto* const row = image.ptr<uint16_t>(y);
      for (int x = 0; x < image.cols; ++x) row[x] = uint16_t(row[x] << 8 | row[x] >> 8);
    }
  }
  image.convertTo(image, CV_8U, 1.0 / 256);
}

}  // namespace

bool decode_header(Bytes bytes, bool cdr, RosHeader& out) {
  Wire wire(bytes, cdr);
  out = wire.header();
  return wire.good();
}

bool decode_imu(Bytes bytes, bool cdr, ImuSample& out) {
  constexpr int kOrientation = 4 + 9, kCovariance = 9;
  Wire wire(bytes, cdr);
  out.t = wire.header().t;
  for (int i = 0; i < kOrientation; ++i) (void)wire.number<double>();
  out.w_B = wire.vector();
  for (int i = 0; i < kCovariance; ++i) (void)wire.number<double>();
  out.f_B = wire.vector();
  return wire.good();
}

bool decode_image(Bytes bytes, bool cdr, cv::Mat& grey) {
  constexpr uint32_t kSide_max = 1 << 16;
  Wire wire(bytes, cdr);
  (void)wire.header();
  const auto height = wire.number<uint32_t>(), width = wire.number<uint32_t>();
  const std::string encoding = wire.text();
  const bool big_endian = wire.number<uint8_t>() != 0;
  const auto stride = wire.number<uint32_t>();
  const Bytes pixels = wire.block(wire.number<uint32_t>());
  if (!wire.good() || width == 0 || height == 0 || width > kSide_max || height > kSide_max) {
    return false;
  }
  for (const Encoding& known : kEncodings) {
    if (encoding != known.name) continue;
    const size_t row = size_t(width) * size_t(CV_ELEM_SIZE(known.type));
    if (stride < row || pixels.size / stride < height) return false;
    const cv::Mat image(int(height), int(width), known.type, const_cast<uint8_t*>(pixels.data),
                        stride);
    if (known.to_grey >= 0) {
      cv::cvtColor(image, grey, known.to_grey);
    } else {
      grey = image.clone();
    }
    if (grey.depth() == CV_16U) narrow(grey, big_endian);
    return true;
  }
  return false;
}

Bytes compressed_image(Bytes bytes, bool cdr) {
  Wire wire(bytes, cdr);
  (void)wire.header();
  (void)wire.text();  // the format, which its bytes say as well
  const Bytes file = wire.block(wire.number<uint32_t>());
  return wire.good() && file.size <= INT32_MAX ? file : Bytes{};
}

bool decode_compressed_image(Bytes bytes, bool cdr, cv::Mat& grey) {
  const Bytes file = compressed_image(bytes, cdr);
  if (file.size == 0) return false;
  const cv::Mat all(1, int(file.size), CV_8UC1, const_cast<uint8_t*>(file.data));
  grey = cv::imdecode(all, cv::IMREAD_GRAYSCALE);
  return !grey.empty();
}

bool is_pose(const std::string& type) {
  return type == "nav_msgs/Odometry" || type == "geometry_msgs/PoseStamped" ||
         type == "geometry_msgs/PoseWithCovarianceStamped" ||
         type == "geometry_msgs/TransformStamped";
}

bool decode_pose(const std::string& type, Bytes bytes, bool cdr, TrajectoryPose& out) {
  Wire wire(bytes, cdr);
  out.t = wire.header().t;
  out.t_s = to_seconds(out.t);
  if (type == "nav_msgs/Odometry" || type == "geometry_msgs/TransformStamped") (void)wire.text();
  out.p_WB = wire.vector();
  for (int i = 0; i < 4; ++i) out.q_WB[i] = wire.number<double>();
  const double norm = out.q_WB.norm();
  if (!wire.good() || !out.p_WB.allFinite() || !(norm > 0.5 && norm < 2)) return false;
  out.q_WB /= norm;
  return true;
}

bool decode_camera_info(Bytes bytes, bool cdr, CameraInfo& out) {
  constexpr uint32_t kCoefficientsMax = 64;
  Wire wire(bytes, cdr);
  out.frame_id = wire.header().frame_id;
  out.height = wire.number<uint32_t>();
  out.width = wire.number<uint32_t>();
  out.distortion_model = wire.text();
  const auto count = wire.number<uint32_t>();
  if (!wire.good() || count > kCoefficientsMax) return false;
  out.D.resize(count);
  bool finite = true;
  const auto next = [&] {
    const auto value = wire.number<double>();
    finite = finite && std::isfinite(value);
    return value;
  };
  for (double& value : out.D) value = next();
  for (int i = 0; i < 9; ++i) out.K(i / 3, i % 3) = next();
  for (int i = 0; i < 9; ++i) out.R(i / 3, i % 3) = next();
  for (int i = 0; i < 12; ++i) out.P(i / 4, i % 4) = next();
  out.binning_x = wire.number<uint32_t>();
  out.binning_y = wire.number<uint32_t>();
  out.roi_x = wire.number<uint32_t>();
  out.roi_y = wire.number<uint32_t>();
  out.roi_height = wire.number<uint32_t>();
  out.roi_width = wire.number<uint32_t>();
  return wire.good() && finite;
}

bool decode_transforms(Bytes bytes, bool cdr, std::vector<RosTransform>& out) {
  Wire wire(bytes, cdr);
  const auto count = wire.number<uint32_t>();
  for (uint32_t i = 0; i < count && wire.good(); ++i) {
    RosTransform link;
    link.parent = wire.header().frame_id;
    link.child = wire.text();
    link.T.p = wire.vector();
    Eigen::Quaterniond q;
    for (int k = 0; k < 4; ++k) q.coeffs()[k] = wire.number<double>();  // x y z w
    const double norm = q.norm();
    if (!wire.good() || !link.T.p.allFinite() || !(norm > 0.5 && norm < 2)) return false;
    link.T.R = q.normalized().toRotationMatrix();
    out.push_back(link);
  }
  return wire.good();
}

}  // namespace pirvs::tools
