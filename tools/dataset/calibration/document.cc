#include "tools/dataset/calibration/document.h"

#include <Eigen/LU>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/math/so3.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

using Json = nlohmann::json;

constexpr int kDepthMax = 32;

YAML::Node node_of(const Json& json, int depth) {
  if (depth > kDepthMax) throw std::runtime_error("nested too deep");
  YAML::Node out;
  if (json.is_object()) {
    out = YAML::Node(YAML::NodeType::Map);
    for (const auto& [key, value] : json.items()) out[key] = node_of(value, depth + 1);
  } else if (json.is_array()) {
    out = YAML::Node(YAML::NodeType::Sequence);
    for (const Json& value : json) out.push_back(node_of(value, depth + 1));
  } else if (json.is_string()) {
    out = json.get<std::string>();
  } else {
    out = json.dump();
  }
  return out;
}

void append(const YAML::Node& node, std::vector<double>& out) {
  if (!node.IsSequence()) {
    out.push_back(node.as<double>());
    return;
  }
  for (const YAML::Node& value : node) {
    if (!value.IsSequence()) {
      out.push_back(value.as<double>());
      continue;
    }
    for (const YAML::Node& inner : value) out.push_back(inner.as<double>());
  }
}

// A key in quotes: YAML may begin with a bracket as well.
bool begins_as_json(const std::string& content) {
  constexpr const char* kSpace = " \t\r\n";
  const size_t first = content.find_first_not_of(kSpace);
  if (first == std::string::npos || content[first] != '{') return false;
  const size_t next = content.find_first_not_of(kSpace, first + 1);
  return next == std::string::npos || content[next] == '"' || content[next] == '}';
}

}  // namespace

Document::Document(const std::string& path) : path_(path) {
  if (!std::filesystem::is_regular_file(path)) {
    throw InputError("no calibration file", path, "add it, or give one with --calib");
  }
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  const std::string content = text.str();
  const bool json = begins_as_json(content);
  try {
    if (json) {
      const Json parsed = Json::parse(content, nullptr, false, true);
      root_ = parsed.is_discarded() ? YAML::Load(content) : node_of(parsed, 0);
    } else {
      root_ = YAML::Load(content);
    }
  } catch (const YAML::Exception& error) {
    fail(json ? "not JSON, or cut off" : "not YAML", "line " + std::to_string(error.mark.line + 1),
         json ? "write the file again" : "repair the calibration");
  } catch (const std::runtime_error& error) {
    fail(error.what(), "the file");
  }
  if (!root_.IsMap()) fail("not a calibration", "the file");
}

std::string Document::beside(const std::string& file) const {
  return (std::filesystem::path(path_).parent_path() / file).string();
}

bool Document::has(const YAML::Node& node, const char* key) const {
  return node.IsMap() && node[key] && !node[key].IsNull();
}

void Document::fail(const std::string& what, const std::string& key,
                    const std::string& what_to_do) const {
  throw InputError(what, path_ + ", " + key, what_to_do);
}

double Document::number(const YAML::Node& node, const char* key) const {
  const double value = get<double>(node, key);
  if (!std::isfinite(value)) fail("the number is not finite", key);
  return value;
}

double Document::number(const YAML::Node& node, const char* key, double if_missing) const {
  return has(node, key) ? number(node, key) : if_missing;
}

double Document::positive(const YAML::Node& node, const char* key) const {
  const double value = number(node, key);
  if (!(value > 0)) fail("needs a number above 0", key);
  return value;
}

std::vector<double> Document::numbers(const YAML::Node& node, const char* key) const {
  if (!has(node, key)) fail("missing value", key);
  const bool opencv = node[key].IsMap() && node[key]["data"];
  std::vector<double> out;
  try {
    append(opencv ? node[key]["data"] : node[key], out);
  } catch (const YAML::Exception&) {
    fail("value of the wrong kind", key);
  }
  for (const double v : out) {
    if (!std::isfinite(v)) fail("a number is not finite", key);
  }
  return out;
}

std::vector<double> Document::numbers(const YAML::Node& node, const char* key, size_t count) const {
  const auto out = numbers(node, key);
  if (out.size() == count) return out;
  fail("needs " + std::to_string(count) + " numbers, has " + std::to_string(out.size()), key);
}

Mat3 Document::rotation(const Mat3& R, const char* key) const {
  constexpr double kPrinted = 1e-3;  // what rounding to a few digits may cost
  const double error = (R * R.transpose() - Mat3::Identity()).norm();
  if (!(error < kPrinted && R.determinant() > 0)) {
    fail("the 3 x 3 part is not a rotation", key);
  }
  // What is one to the last bits stays, so that a recording of a recording gives the same run.
  constexpr double kExact = 4e-15;
  return error > kExact ? orthonormalized(R) : R;
}

SE3 Document::transform(const YAML::Node& node, const char* key) const {
  const auto m = numbers(node, key);
  if (m.size() != 16 && m.size() != 12) {
    fail("needs 4 rows of 4 numbers, has " + std::to_string(m.size()) + " numbers", key);
  }
  SE3 T;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) T.R(i, j) = m[size_t(4 * i + j)];
    T.p[i] = m[size_t(4 * i + 3)];
  }
  T.R = rotation(T.R, key);
  return T;
}

}  // namespace pirvs::tools
