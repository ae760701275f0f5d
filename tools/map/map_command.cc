// `pirvs map info|export|crop|merge`: what to do with maps that `--save-map` and devices wrote.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "modules/map/nodes.h"
#include "tools/cli/command.h"
#include "tools/dataset/input_error.h"
#include "tools/map/map_files.h"
#include "tools/map/merge.h"

namespace pirvs::tools {
namespace {

std::unique_ptr<Map> read(const std::string& path) {
  auto map = std::make_unique<Map>();
  read_map_file(path, [&](const MapSource& source) { return load_map(source, *map); });
  return map;
}

template <class Pool, class Visit>
void for_each(Pool& pool, Visit&& visit) {
  for (size_t slot = 0; slot < pool.capacity(); ++slot) {
    if (auto* item = pool.at(slot)) visit(pool.handle(slot), *item);
  }
}

// ---- info --------------------------------------------------------------------------------------

int info(const std::string& path) {
  const std::unique_ptr<const Map> map = read(path);
  const double inf = HUGE_VAL;
  Vec3 lo = Vec3::Constant(inf), hi = -lo;
  double sigma_sum = 0;
  for_each(map->landmarks, [&](LandmarkId, const Landmark& point) {
    lo = lo.cwiseMin(point.p_W);
    hi = hi.cwiseMax(point.p_W);
    sigma_sum += std::sqrt(point.cov.trace() / 3);
  });
  std::set<uint16_t> epochs;
  TimeNs first = INT64_MAX, last = INT64_MIN;
  for_each(map->keyframes, [&](KeyframeId, const Keyframe& keyframe) {
    epochs.insert(keyframe.epoch);
    first = std::min(first, keyframe.state.t);
    last = std::max(last, keyframe.state.t);
  });
  const size_t points = map->landmarks.size();
  std::printf("%zu of %zu points, sigma %.4f m a coordinate in the mean\n", points, kLandmarksMax,
              points > 0 ? sigma_sum / double(points) : 0);
  std::printf("%zu of %zu keyframes over %.1f s\n", map->keyframes.size(), kKeyframesMax,
              map->keyframes.size() > 0 ? to_seconds(last - first) : 0);
  if (epochs.size() > 1) std::printf("%zu parts of no known relation\n", epochs.size());
  if (points > 0) {
    std::printf("from (%.2f, %.2f, %.2f) to (%.2f, %.2f, %.2f) m\n", lo.x(), lo.y(), lo.z(), hi.x(),
                hi.y(), hi.z());
  }
  for (const Node& node : map->nodes) {
    const Vec3 p = node_pose(*map, node.name).value().p;
    std::printf("node %s at (%.3f, %.3f, %.3f)\n", node.name, p.x(), p.y(), p.z());
  }
  return kExitDone;
}

// ---- export ------------------------------------------------------------------------------------

std::string point_lines(const Map& map) {
  std::string out;
  for_each(map.landmarks, [&](LandmarkId, const Landmark& point) {
    char line[128];
    std::snprintf(line, sizeof line, "%.4f %.4f %.4f %.4f %u\n", point.p_W.x(), point.p_W.y(),
                  point.p_W.z(), std::sqrt(point.cov.trace() / 3), unsigned{point.views});
    out += line;
  });
  return out;
}

int export_points(const std::string& path, const std::string& to) {
  const std::unique_ptr<const Map> map = read(path);
  const std::string count = std::to_string(map->landmarks.size());
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex " + count +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty float sigma\n"
      "property uint views\nend_header\n";
  const std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z sigma views\nSIZE 4 4 4 4 4\nTYPE F F F F U\n"
      "COUNT 1 1 1 1 1\nWIDTH " +
      count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA ascii\n";
  const bool is_pcd = to.size() > 4 && to.compare(to.size() - 4, 4, ".pcd") == 0;
  std::ofstream file(to);
  file << (is_pcd ? pcd : ply) << point_lines(*map);
  file.close();
  if (!file) throw InputError("cannot write the points", to, "check space and permissions");
  std::printf("%s points in %s\n", count.c_str(), to.c_str());
  return kExitDone;
}

// ---- crop --------------------------------------------------------------------------------------

bool inside(const Vec3& p, const std::vector<double>& box) {
  for (int a = 0; a < 3; ++a) {
    if (p[a] < box[size_t(a)] || p[a] > box[size_t(a) + 3]) return false;
  }
  return true;
}

bool sees_any(const Map& map, const Keyframe& keyframe) {
  for (const Observations& observations : keyframe.observations) {
    for (const Observation& o : observations) {
      if (map.landmarks.find(o.landmark) != nullptr) return true;
    }
  }
  return false;
}

int crop(const std::string& path, const std::vector<double>& box, const std::string& to) {
  const std::unique_ptr<Map> map = read(path);
  const size_t points = map->landmarks.size(), keyframes = map->keyframes.size();
  for_each(map->landmarks, [&](LandmarkId id, const Landmark& point) {
    if (!inside(point.p_W, box)) (void)map->landmarks.release(id);
  });
  for_each(map->keyframes, [&](KeyframeId id, const Keyframe& keyframe) {
    if (sees_any(*map, keyframe)) return;
    carry_nodes(*map, id);
    (void)map->keyframes.release(id);
  });
  if (map->keyframes.size() == 0) {
    throw InputError("nothing is left", path,
                     "give a --box that holds points of it (pirvs map info)");
  }
  write_map_file(to, *map);
  std::printf("%zu of %zu points and %zu of %zu keyframes in %s\n", map->landmarks.size(), points,
              map->keyframes.size(), keyframes, to.c_str());
  return kExitDone;
}

// ---- merge -------------------------------------------------------------------------------------

int merge(const std::string& first, const std::string& second, const std::string& to) {
  const std::unique_ptr<Map> a = read(first);
  const std::unique_ptr<const Map> b = read(second);
  const MergeReport report = merge_maps(*a, *b);
  write_map_file(to, *a);
  const Mat3& R = report.T_AB.R;
  std::printf("%zu points of both, %.4f m rms apart, out of %zu alike\n", report.shared,
              report.rms_m, report.matched);
  std::printf("%s stands at (%.3f, %.3f, %.3f) m, turned by %.2f degrees\n", second.c_str(),
              report.T_AB.p.x(), report.T_AB.p.y(), report.T_AB.p.z(),
              std::atan2(R(1, 0), R(0, 0)) * 180 / M_PI);
  if (report.points_left_out + report.keyframes_left_out > 0) {
    std::printf("no room for %zu points and %zu keyframes, the least seen\n",
                report.points_left_out, report.keyframes_left_out);
  }
  std::printf("%zu points and %zu keyframes in %s\n", a->landmarks.size(), a->keyframes.size(),
              to.c_str());
  return kExitDone;
}

struct Options {
  std::string map, second, out;
  std::vector<double> box;
};

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.require_subcommand(1);
  const auto add = [&](const char* name, const char* help) {
    CLI::App* const part = app.add_subcommand(name, help);
    part->add_option("MAP", o->map, "a map that was saved")->required();
    return part;
  };
  CLI::App* const info_part = add("info", "what a map holds");
  CLI::App* const export_part = add("export", "its points for other programs");
  export_part->add_option("--out", o->out, "X.ply or X.pcd")
      ->required()
      ->check([](const std::string& name) {
        const std::string end = name.size() > 4 ? name.substr(name.size() - 4) : "";
        return end == ".ply" || end == ".pcd" ? "" : "neither .ply nor .pcd: " + name;
      });
  CLI::App* const crop_part = add("crop", "what lies in a box alone");
  crop_part->add_option("--box", o->box, "X0 Y0 Z0 X1 Y1 Z1, m in the map's frame")
      ->expected(6)
      ->required();
  crop_part->add_option("--out", o->out, "the new map")->required();
  CLI::App* const merge_part =
      add("merge", "two maps of one place as one, in the frame of the first");
  merge_part->add_option("SECOND", o->second, "the map that is laid on the first")->required();
  merge_part->add_option("--out", o->out, "the new map")->required();
  return [=] {
    if (info_part->parsed()) return info(o->map);
    if (export_part->parsed()) return export_points(o->map, o->out);
    if (crop_part->parsed()) return crop(o->map, o->box, o->out);
    return merge(o->map, o->second, o->out);
  };
}

}  // namespace

const Command kMapCommand = {"map", "Look at saved maps, cut and merge them", declare};

}  // namespace pirvs::tools
