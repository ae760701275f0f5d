#include "tools/view/page.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "tools/dataset/input_error.h"
#include "tools/map/map_files.h"
#include "tools/map/pool_items.h"
#include "tools/view/recorded_page.h"

namespace pirvs::tools {

namespace fs = std::filesystem;

std::string page_file() {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path().parent_path();
  const fs::path installed = folder / "share/pirvs/view.html";
  const fs::path page = fs::exists(installed, error) ? installed : folder / "view/view.html";
  if (!fs::is_regular_file(page, error)) {
    throw InputError("the page is not built", page.string(), "run `make view`, which needs npm");
  }
  return page.string();
}

void save_page(const std::vector<ViewMessage>& messages, const std::string& path) {
  const std::string page = recorded_page(messages);
  std::ofstream file(path, std::ios::binary);
  file << page;
  file.close();
  if (!file) throw InputError("cannot write", path, "check space and permissions");
}

std::vector<Eigen::Vector3f> read_ply(const std::string& path) {
  std::ifstream file(path);
  std::string line, word;
  size_t count = 0;
  bool is_ply = std::getline(file, line) && line == "ply", is_text = false;
  while (is_ply && std::getline(file, line) && line != "end_header") {
    std::istringstream words(line);
    if (words >> word && word == "format") is_text = words >> word && word == "ascii";
    if (word == "element" && words >> word && word == "vertex") words >> count;
  }
  if (!is_ply || !is_text || !file) {
    throw InputError("not a PLY file of text", path, "give map.ply of a run");
  }
  std::vector<Eigen::Vector3f> out;
  Eigen::Vector3f p;
  while (out.size() < count && std::getline(file, line)) {
    std::istringstream numbers(line);
    if (!(numbers >> p.x() >> p.y() >> p.z())) {
      throw InputError("a point that is none, line " + std::to_string(out.size()), path,
                       "give map.ply of a run");
    }
    out.push_back(p);
  }
  return out;
}

std::vector<Eigen::Vector3f> read_points(const std::string& path) {
  std::string begin(3, ' ');
  std::ifstream(path, std::ios::binary).read(begin.data(), 3);
  if (begin == "ply") return read_ply(path);
  const auto map = std::make_unique<Map>();
  read_map_file(path, [&](const MapSource& source) { return load_map(source, *map); });
  std::vector<Eigen::Vector3f> out;
  for_each(map->landmarks,
           [&](LandmarkId, const Landmark& point) { out.push_back(point.p_W.cast<float>()); });
  return out;
}

}  // namespace pirvs::tools
