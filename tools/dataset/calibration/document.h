// What    A calibration file as a tree, YAML, OpenCV's YAML or JSON, that says where it was wrong.
// In      A file.
// Out     Its nodes; numbers and matrices in the forms that people write them.
// Errors  InputError with file and key: no file, not YAML or JSON, missing, of the wrong kind, not
//         finite, not a rotation.
// Source  YAML 1.2 (yaml-cpp), JSON (nlohmann); OpenCV's FileStorage is YAML with a heading.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "core/math/se3.h"

namespace pirvs::tools {

class Document {
 public:
  explicit Document(const std::string& path);
  // What was read by other means, and where.
  Document(std::string path, const YAML::Node& root) : path_(std::move(path)), root_(root) {}

  const YAML::Node& root() const { return root_; }
  const std::string& path() const { return path_; }
  // A file that this one names, relative to its own folder.
  std::string beside(const std::string& file) const;

  bool has(const YAML::Node& node, const char* key) const;
  // Throws InputError about the key.
  [[noreturn]] void fail(const std::string& what, const std::string& key,
                         const std::string& what_to_do = "repair the calibration") const;

  template <class T>
  T get(const YAML::Node& node, const char* key) const {
    if (!has(node, key)) fail("missing value", key);
    try {
      return node[key].as<T>();
    } catch (const YAML::Exception&) {
      fail("value of the wrong kind", key);
    }
  }
  double number(const YAML::Node& node, const char* key) const;  // finite
  double number(const YAML::Node& node, const char* key, double if_missing) const;
  double positive(const YAML::Node& node, const char* key) const;
  // A list of finite numbers, perhaps in rows, or OpenCV's matrix.
  std::vector<double> numbers(const YAML::Node& node, const char* key) const;
  std::vector<double> numbers(const YAML::Node& node, const char* key, size_t count) const;
  // 4 x 4 or 3 x 4, in rows or one list.
  SE3 transform(const YAML::Node& node, const char* key) const;
  // Made exact; `key` is what a fault names.
  Mat3 rotation(const Mat3& R, const char* key) const;

 private:
  std::string path_;
  YAML::Node root_;
};

}  // namespace pirvs::tools
