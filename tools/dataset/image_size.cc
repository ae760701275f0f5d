#include "tools/dataset/image_size.h"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

namespace pirvs::tools {

namespace fs = std::filesystem;

std::pair<int, int> image_size_in(const std::vector<std::string>& folders) {
  constexpr size_t kTries = 20;
  for (const std::string& folder : folders) {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      if (entry.is_regular_file(error)) names.push_back(entry.path().string());
    }
    const auto end = names.begin() + std::ptrdiff_t(std::min(kTries, names.size()));
    std::partial_sort(names.begin(), end, names.end());
    for (auto name = names.begin(); name != end; ++name) {
      const cv::Mat image = cv::imread(*name, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
      if (!image.empty()) return {image.cols, image.rows};
    }
  }
  return {0, 0};
}

}  // namespace pirvs::tools
