#include "tools/map/point_files.h"

#include <cmath>
#include <cstdio>

namespace pirvs::tools {
namespace {

std::string lines_of(const std::vector<Landmark>& points) {
  std::string out;
  for (const Landmark& point : points) {
    char line[128];
    std::snprintf(line, sizeof line, "%.4f %.4f %.4f %.4f %u\n", point.p_W.x(), point.p_W.y(),
                  point.p_W.z(), std::sqrt(point.cov.trace()), unsigned(point.views));
    out += line;
  }
  return out;
}

}  // namespace

std::string points_ply(const std::vector<Landmark>& points) {
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\n"
         "property float sigma_m\nproperty ushort views\nend_header\n" +
         lines_of(points);
}

std::string points_pcd(const std::vector<Landmark>& points) {
  const std::string count = std::to_string(points.size());
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z sigma_m views\nSIZE 4 4 4 4 2\nTYPE F F F F U\n"
         "COUNT 1 1 1 1 1\nWIDTH " +
         count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA ascii\n" +
         lines_of(points);
}

}  // namespace pirvs::tools
