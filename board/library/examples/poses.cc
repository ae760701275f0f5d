// Poses of an ASL recording with PGM images, one a line (TUM): poses FOLDER/mav0 CALIBRATION
//   c++ -std=c++17 poses.cc -lpirvs -o poses
#include <pirvs.h>

#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>

void check(pirvs_status status) {
  if (status < 0) throw std::runtime_error(pirvs_last_error());
}

// `cells` numbers of the next row; false: there is none.
bool next_row(std::ifstream& table, std::string (&cells)[8]) {
  std::string row;
  if (!std::getline(table, row)) return false;
  size_t at = 0, i = 0;
  for (size_t end; i < 7 && (end = row.find(',', at)) != std::string::npos; at = end + 1) {
    cells[i++] = row.substr(at, end - at);
  }
  cells[i] = row.substr(at, row.find_last_not_of(" \r") + 1 - at);
  return row[0] != '#' || next_row(table, cells);
}

std::string read_pgm(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  int width = 0, height = 0, white = 0;
  file.ignore(2) >> width >> height >> white;
  std::string pixels(size_t(width) * size_t(height), 0);
  file.ignore(1).read(pixels.data(), std::streamsize(pixels.size()));
  return pixels;
}

void print(void*, const pirvs_pose* p) {
  std::printf("%" PRId64 ".%09" PRId64 " %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n",
              p->t_ns / 1000000000, p->t_ns % 1000000000, p->p_m[0], p->p_m[1], p->p_m[2],
              p->q_xyzw[0], p->q_xyzw[1], p->q_xyzw[2], p->q_xyzw[3]);
}

int main(int argc, char** argv) try {
  if (argc != 3) throw std::runtime_error("usage: poses FOLDER/mav0 CALIBRATION");
  pirvs_config config = {};
  config.size = sizeof config;
  config.mode = PIRVS_STEPPED;
  config.calibration = argv[2];
  config.on_frame = print;
  pirvs_slam* made = nullptr;
  check(pirvs_create(&config, &made));
  const std::unique_ptr<pirvs_slam, decltype(&pirvs_destroy)> slam(made, pirvs_destroy);
  check(pirvs_start(made));

  const std::string mav0 = argv[1];
  std::ifstream samples(mav0 + "/imu0/data.csv"), frames(mav0 + "/cam0/data.csv");
  std::string sample[8], frame[8];
  bool more = next_row(frames, frame);
  while (next_row(samples, sample)) {
    const int64_t t = std::stoll(sample[0]);
    for (; more && std::stoll(frame[0]) < t; more = next_row(frames, frame)) {
      const std::string left = read_pgm(mav0 + "/cam0/data/" + frame[1]);
      const std::string right = read_pgm(mav0 + "/cam1/data/" + frame[1]);
      const auto bytes = [](const std::string& s) {
        return s.empty() ? nullptr : reinterpret_cast<const uint8_t*>(s.data());
      };
      const pirvs_images images = {
          sizeof images, 0, std::stoll(frame[0]), {bytes(left), bytes(right)}};
      check(pirvs_feed_images(made, &images));
    }
    pirvs_imu imu = {sizeof imu, 0, t, {}, {}};
    for (int i = 0; i < 3; ++i) {
      imu.w_rad_s[i] = std::stod(sample[1 + i]);
      imu.f_m_s2[i] = std::stod(sample[4 + i]);
    }
    check(pirvs_feed_imu(made, &imu));
  }
  check(pirvs_stop(made));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "poses: %s\n", error.what());
  return 2;
}
