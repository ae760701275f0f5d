#include "tools/calib/corner_input.h"

#include <cmath>
#include <cstdio>

#include "tools/calib/board_images.h"
#include "tools/calib/lens.h"
#include "tools/calib/result_files.h"
#include "tools/dataset/calibration/rig_file.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

void print_lens(const CameraResult& result, int c) {
  const LensVector lens = lens_of(result.rig.camera[c]);
  for (int i = 0; i < kLensSize; ++i) {
    const int k = 8 * c + i;
    std::printf("cam%d %s %13.6f +- %.6f\n", c, kLensNames[i], lens[i],
                std::sqrt(result.adjustment.covariance(k, k)));
  }
  std::printf("cam%d reprojection %.3f px, on shots left out %.3f px\n", c,
              result.adjustment.rms_px[c], result.held_out.within_px[c]);
}

void read_images(const CornerOptions& options, CornerInput& out) {
  InputLog log;
  BoardImages found =
      find_boards(options.sequence, out.target, options.rate_hz, options.duration_s_max, log);
  print_log(options.sequence, log);
  out.tags_twice = log.counted("tags_seen_twice");
  out.left_out_s = found.left_out_s;
  out.how.size = found.size;
  out.cameras = found.cameras;
  std::vector<View> views[2];
  for (int c = 0; c < found.cameras; ++c) {
    TagCounts counts;
    for (ImageCorners& image : found.images[c]) {
      View view = whole_tags(image.t, image.corners, counts);
      if (!view.tags.empty()) views[c].push_back(std::move(view));
    }
  }
  out.shots = pair_views(views[0], views[1]);
}

}  // namespace

void print_log(const std::string& path, const InputLog& log) {
  for (const Count& count : log.rejected) {
    std::fprintf(stderr, "pirvs: calib: %s: %zu %s\n", path.c_str(), count.value,
                 count.name.c_str());
  }
  for (const std::string& note : log.notes) {
    std::fprintf(stderr, "pirvs: calib: %s: %s\n", path.c_str(), note.c_str());
  }
}

ImuNoise read_noise(const std::string& path) {
  const std::optional<RigNoise> found = find_noise(path);
  if (!found) {
    throw InputError("no noise densities", path,
                     "give Kalibr's imu.yaml, an ASL sensor.yaml, or what `calib noise` wrote");
  }
  return found->noise;
}

void declare_corners(CLI::App& app, CornerOptions& options) {
  CLI::Option* const sequence =
      app.add_option("SEQ", options.sequence, "an ASL folder with images of the board");
  app.add_option("--corners", options.files,
                 "instead, tables of corners, one a camera: cam0.csv,cam1.csv")
      ->delimiter(',')
      ->expected(1, 2)
      ->excludes(sequence);
  app.add_option("--rate", options.rate_hz, "images a second to look at, at most")
      ->check(CLI::Range(0.1, 1000.0));
  app.add_option("--target", options.target, "the board's yaml, Kalibr's or `calib target`'s")
      ->required();
  app.add_option("--size", options.size, "with --corners: width and height of the images, px")
      ->expected(2)
      ->check(CLI::Range(16, 65536));
  app.add_option("--model", options.model, "radtan or equidistant; else the better one")
      ->check(CLI::IsMember({"radtan", "equidistant"}));
}

CornerInput read_corner_input(const CornerOptions& options) {
  CornerInput out;
  out.target = read_target(options.target);
  if (options.model == "radtan") out.how.model = CameraModel::kPinholeRadtan;
  if (options.model == "equidistant") out.how.model = CameraModel::kKannalaBrandt;
  if (!options.sequence.empty()) {
    read_images(options, out);
    return out;
  }
  if (options.files.empty() || options.size.size() != 2) {
    throw InputError("no images", "SEQ", "give a recording, or --corners and --size");
  }
  out.how.size = {options.size[0], options.size[1]};
  out.cameras = int(options.files.size());
  std::vector<View> views[2];
  for (size_t c = 0; c < options.files.size(); ++c) {
    InputLog log;
    views[c] = read_views(options.files[c], out.target, out.how.size, log);
    print_log(options.files[c], log);
    out.tags_twice += log.counted("tags_seen_twice");
  }
  out.shots = pair_views(views[0], views[1]);
  return out;
}

void print_cameras(const CameraResult& result) {
  const Adjustment& a = result.adjustment;
  std::printf("model %s, %zu shots of %zu, %zu tags, %zu outliers, noise of a tag %.3f px\n",
              model_name(result.rig.camera[0].model), result.used.size(), result.all.size(),
              a.tags[0] + a.tags[1], a.outliers, a.sigma_px);
  if (result.other_model_px > 0) {
    std::printf("the other model: %.3f px on shots left out\n", result.other_model_px);
  }
  for (int c = 0; c < result.rig.cameras; ++c) print_lens(result, c);
  if (result.rig.cameras < 2) return;
  const Vec3 p = result.rig.T_C1C0.p, unit = p.normalized();
  const double variance = unit.dot(a.covariance.block<3, 3>(19, 19) * unit);
  std::printf("baseline %.3f mm +- %.3f, across cameras %.3f px on shots left out\n",
              1e3 * p.norm(), 1e3 * std::sqrt(variance), result.held_out.across_px);
}

}  // namespace pirvs::tools
