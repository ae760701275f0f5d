#include "tools/view/run_view.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "tools/dataset/input_error.h"
#include "tools/dataset/trajectory.h"
#include "tools/view/page.h"

namespace pirvs::tools {

using nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr const char* kColumns[] = {"t",       "px",      "py",          "pz",         "qx",
                                    "qy",      "qz",      "qw",          "vx",         "vy",
                                    "vz",      "sigma_p", "sigma_theta", "confidence", "health",
                                    "reasons", "resets",  "accepted",    "rejected",   "ms"};
constexpr size_t kColumnCount = std::size(kColumns);
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

size_t column(const std::string& name) {
  const auto* const at = std::find(std::begin(kColumns), std::end(kColumns), name);
  return static_cast<size_t>(at - std::begin(kColumns));
}

struct RunFiles {
  std::string folder, suffix;
  std::string operator()(const char* name) const { return folder + "/" + name + suffix; }
};

struct Row {
  double value[kColumnCount];
  Row() { std::fill(std::begin(value), std::end(value), kUnknown); }
  double& operator[](const char* name) { return value[column(name)]; }
};

// A file of commas, its first line the names of columns.
class Csv {
 public:
  explicit Csv(const std::string& path) : path_(path), file_(path) {
    std::string line;
    if (!std::getline(file_, line)) return;
    if (!line.empty() && line[0] == '#') line.erase(0, 1);
    names_ = split(line);
  }
  bool next() {
    std::string line;
    if (!std::getline(file_, line)) return false;
    ++row_;
    cells_ = split(line);
    if (cells_.size() == names_.size()) return true;
    if (file_.eof()) return false;  // cut off in the middle
    throw InputError(
        "a row of " + std::to_string(cells_.size()) + " columns, line " + std::to_string(row_ + 1),
        path_, "give the folder of a finished run");
  }
  // "": there is no such column.
  std::string text(const std::string& name) const {
    const auto at = std::find(names_.begin(), names_.end(), name);
    return at == names_.end() ? "" : cells_[static_cast<size_t>(at - names_.begin())];
  }
  double number(const std::string& name) const {
    const std::string cell = text(name);
    char* end = nullptr;
    const double value = std::strtod(cell.c_str(), &end);
    return cell.empty() || *end != 0 ? kUnknown : value;
  }

 private:
  static std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> out;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) out.push_back(cell);
    return out;
  }
  std::string path_;
  std::ifstream file_;
  std::vector<std::string> names_, cells_;
  size_t row_ = 0;
};

// Names as they first come; a row holds their places.
struct Names {
  std::vector<std::string> list;
  double place(const std::string& name) {
    const auto at = std::find(list.begin(), list.end(), name);
    if (at != list.end()) return double(at - list.begin());
    list.push_back(name);
    return double(list.size() - 1);
  }
};

struct Rows {
  std::vector<Row> rows;
  Names health, reasons;
};

Rows read_states(const std::string& path) {
  Rows out;
  Csv states(path);
  while (states.next()) {
    Row row;
    row["t"] = states.number("t_ns") * 1e-9;
    for (const char* name : {"px", "py", "pz", "qx", "qy", "qz", "qw", "vx", "vy", "vz",
                             "confidence", "resets", "accepted", "rejected"}) {
      row[name] = states.number(name);
    }
    const auto sigma = [&](const char* a, const char* b, const char* c) {
      return std::sqrt(states.number(a) + states.number(b) + states.number(c));
    };
    row["sigma_theta"] = sigma("cov00", "cov11", "cov22");
    row["sigma_p"] = sigma("cov33", "cov44", "cov55");
    row["health"] = out.health.place(states.text("health"));
    row["reasons"] = out.reasons.place(states.text("reasons"));
    out.rows.push_back(row);
  }
  return out;
}

// `pirvs listen` writes no states: poses alone, as many as the page can do with.
Rows read_poses(const std::string& path) {
  constexpr size_t kRowsMax = 200'000;
  const Trajectory trajectory = read_trajectory(path);
  const size_t step = trajectory.poses.size() / kRowsMax + 1;
  Rows out;
  for (size_t i = 0; i < trajectory.poses.size(); i += step) {
    const TrajectoryPose& pose = trajectory.poses[i];
    Row row;
    row["t"] = to_seconds(pose.t);
    for (int k = 0; k < 3; ++k) row.value[column("px") + size_t(k)] = pose.p_WB[k];
    for (int k = 0; k < 4; ++k) row.value[column("qx") + size_t(k)] = pose.q_WB[k];
    out.rows.push_back(row);
  }
  return out;
}

// Frames with a pose stand in both, in order of time. The time of the first frame.
double add_timing(const std::string& path, std::vector<Row>& rows) {
  Csv timing(path);
  size_t at = 0;
  double begin = kUnknown;
  while (at < rows.size() && timing.next()) {
    const double t = timing.number("t_ns") * 1e-9;
    if (std::isnan(begin)) begin = t;
    while (at < rows.size() && rows[at]["t"] < t - 1e-6) ++at;
    if (at < rows.size() && std::fabs(rows[at]["t"] - t) < 1e-6) {
      rows[at]["ms"] = timing.number("end_to_end_ms");
    }
  }
  return begin;
}

json read_summary(const std::string& path) {
  std::ifstream file(path);
  const json summary = json::parse(file, nullptr, false);
  if (!summary.is_object()) {
    throw InputError("not a summary", path, "give the folder of a finished run");
  }
  return summary;
}

// Those of a loaded map come first, and were taken on another day: not in order of time.
void show_keyframes(ViewScene& scene, const std::string& path) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream numbers(line);
    double t = 0;
    Vec3 p;
    Vec4 q;
    if (numbers >> t >> p[0] >> p[1] >> p[2] >> q[0] >> q[1] >> q[2] >> q[3]) {
      scene.keyframe(p, q);
    }
  }
}

void show_map(ViewScene& scene, const RunFiles& files) {
  show_keyframes(scene, files("keyframes.tum"));
  if (!fs::exists(files("map.ply"))) return;
  std::vector<ViewPoint> points;
  for (const Eigen::Vector3f& p : read_ply(files("map.ply"))) {
    points.push_back({static_cast<uint32_t>(points.size()), p, 0});
  }
  scene.points(points);
}

// localised_t: in the map that was loaded; NaN: never.
void show_events(ViewScene& scene, Rows& states, double localised_t) {
  double health = -1, resets = 0;
  bool localised = false;
  for (Row& row : states.rows) {
    if (std::isnan(row["health"])) return;
    const std::string now = states.health.list[static_cast<size_t>(row["health"])];
    HealthState state = HealthState::kInitializing;
    for (int i = 0; i < static_cast<int>(HealthState::kCount); ++i) {
      if (now == name(static_cast<HealthState>(i))) state = static_cast<HealthState>(i);
    }
    const TimeNs t = from_seconds(row["t"]);
    if (row["health"] != health) scene.health(t, state, "from here on");
    if (row["resets"] > resets && health >= 0) scene.health(t, state, "the pose jumped");
    if (!localised && row["t"] >= localised_t) {
      scene.health(t, state, "localised in the loaded map");
      localised = true;
    }
    health = row["health"];
    resets = row["resets"];
  }
}

}  // namespace

bool is_run_folder(const std::string& path) {
  return fs::exists(path + "/summary.json") && fs::exists(path + "/trajectory.tum");
}

void show_run(ViewScene& scene, const std::string& folder, const std::string& suffix) {
  const RunFiles files = {folder, suffix};
  const json summary = read_summary(files("summary.json"));
  const bool has_states = fs::exists(files("state.csv"));
  Rows states = has_states ? read_states(files("state.csv")) : read_poses(files("trajectory.tum"));
  if (states.rows.empty()) throw InputError("holds no pose", folder, "look at its summary.json");
  double begin_t = kUnknown;
  if (fs::exists(files("timing.csv"))) {
    begin_t = add_timing(files("timing.csv"), states.rows);
  }
  scene.begin({{"kind", "run"}, {"name", folder}, {"commands", json::array()}});
  scene.source_is("ended", summary.value("status", ""));
  const json header = {{"type", "run"},
                       {"count", states.rows.size()},
                       {"columns", kColumns},
                       {"health_names", states.health.list},
                       {"reasons_names", states.reasons.list},
                       {"summary", summary}};
  scene.lasting(view_message(header, states.rows.data(), states.rows.size() * sizeof(Row)));
  show_map(scene, files);
  const json localised = summary.value("localised_after_s", json());
  show_events(scene, states, localised.is_number() ? begin_t + localised.get<double>() : kUnknown);
  std::map<std::string, uint64_t> counters;
  const json told = summary.value("counters", json::object());
  for (const auto& [name, value] : told.items()) {
    if (value.is_number_unsigned()) counters[name] = value;
  }
  scene.counters(counters);
}

}  // namespace pirvs::tools
