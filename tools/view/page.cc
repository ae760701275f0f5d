#include "tools/view/page.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {

namespace fs = std::filesystem;

namespace {

std::string base64(const std::string& bytes) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() / 3 * 4 + 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k) {
      three = three << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    }
    for (size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kLetters[three >> (18 - 6 * k) & 63];
    }
  }
  return out;
}

}  // namespace

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
  std::ostringstream text;
  text << std::ifstream(page_file(), std::ios::binary).rdbuf();
  std::string page = text.str();
  std::string recorded = "<script>window.pirvsRecorded=[";
  for (const ViewMessage& message : messages) {
    recorded += std::string("{binary:") + (message.binary ? "true" : "false") + ",base64:\"" +
                base64(*message.bytes) + "\"},\n";
  }
  recorded += "]</script>";
  constexpr char kPlace[] = "<!--recorded-->";
  const size_t at = page.find(kPlace);
  if (at != std::string::npos) page.replace(at, sizeof kPlace - 1, recorded);
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

}  // namespace pirvs::tools
