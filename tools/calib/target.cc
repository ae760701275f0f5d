#include "tools/calib/target.h"

#include <yaml-cpp/yaml.h>

#include <fstream>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

double number(const YAML::Node& root, const std::string& path, const char* key, double least,
              double most) {
  double value = 0;
  try {
    value = root[key].as<double>();
  } catch (const YAML::Exception&) {
    throw InputError("no number", path + ", " + key, "repair the target's yaml");
  }
  if (!(value >= least && value <= most)) {
    throw InputError("out of range", path + ", " + key, "sizes are in metres, counts whole");
  }
  return value;
}

}  // namespace

Vec3 Target::p_T(int corner) const {
  const int tag = corner / 4, k = corner % 4;
  const double x = tag % columns * pitch_m(), y = tag / columns * pitch_m();
  const Vec3 flat(x + (k == 1 || k == 2 ? tag_m : 0), y + (k >= 2 ? tag_m : 0), 0);
  return shift_T.empty() ? flat : Vec3(flat + shift_T[size_t(tag)]);
}

Target read_target(const std::string& path) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
  } catch (const YAML::Exception&) {
    throw InputError("no target's yaml", path, "`pirvs calib target` writes one");
  }
  if (!root.IsMap() || !root["target_type"] ||
      root["target_type"].as<std::string>("") != "aprilgrid") {
    throw InputError("not an aprilgrid", path + ", target_type",
                     "`pirvs calib target` writes a board that is");
  }
  Target out;
  out.columns = int(number(root, path, "tagCols", 1, kTagsMax));
  out.rows = int(number(root, path, "tagRows", 1, kTagsMax));
  out.tag_m = number(root, path, "tagSize", 0.001, 10);
  out.spacing = number(root, path, "tagSpacing", 0.01, 10);
  if (out.tags() > kTagsMax) {
    throw InputError("more tags than the family 36h11 has", path,
                     "make tagCols or tagRows smaller");
  }
  return out;
}

void write_target(const Target& target, const std::string& path) {
  std::ofstream file(path);
  file << "target_type: aprilgrid   # 36h11, ids by rows from bottom left\n"
       << "tagCols: " << target.columns << "\ntagRows: " << target.rows
       << "\ntagSize: " << target.tag_m << "           # m, black square, edge to edge\n"
       << "tagSpacing: " << target.spacing << "          # gap between tags / tagSize\n";
  file.close();
  if (!file) throw InputError("cannot write", path, "check space and permissions");
}

}  // namespace pirvs::tools
