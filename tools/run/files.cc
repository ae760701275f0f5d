#include "tools/run/files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/math/so3.h"
#include "tools/dataset/input_error.h"
#include "tools/map/point_files.h"
#include "tools/run/verdict.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kProbe = "probe";

Json statistics_json(const Statistics& s) {
  return {{"mean", s.mean}, {"median", s.median}, {"p95", s.p95}, {"p99", s.p99}, {"max", s.max}};
}

// null: not measured, as in a replay that is not in real time.
Json vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json latency_json(const LatencySummary& s) {
  if (s.count == 0) return nullptr;
  return {{"min", s.min_ms}, {"median", s.median_ms}, {"p99", s.p99_ms}, {"max", s.max_ms}};
}

Json counts_json(const std::vector<Count>& counts) {
  Json out = Json::object();
  for (const Count& count : counts) out[count.name] = count.value;
  return out;
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json evaluation_json(const Evaluation& e) {
  if (!e.ok) return nullptr;
  return {{"poses", e.poses},
          {"duration_s", e.duration_s},
          {"path_m", e.path_m},
          {"ate_rmse_m", e.ate_rmse_m},
          {"ate_std_m", e.ate_std_m},
          {"ate_max_m", e.ate_max_m},
          {"rpe_delta_s", e.delta_s},
          {"rpe_m", number(e.rpe_m)},
          {"rpe_deg", number(e.rpe_deg)},
          {"tilt_at_10_s_deg", number(e.tilt_at_10_s_deg)},
          {"tilt_at_end_deg", e.tilt_at_end_deg},
          {"tilt_max_deg", e.tilt_max_deg}};
}

// null: no GNSS; without a truth on the Earth the errors are null.
Json fused_json(const RunResult& result, const RunLog& log) {
  if (result.fused.empty()) return nullptr;
  const FusedResult& f = result.fused_result;
  const auto error = [&f](double value) { return f.ok ? Json(value) : Json(nullptr); };
  const Geodetic& origin = log.local_frame.origin();
  constexpr double kDegree = M_PI / 180;
  return {
      {"poses", result.fused.size()},
      {"origin", {origin.latitude_rad / kDegree, origin.longitude_rad / kDegree, origin.height_m}},
      {"health_at_end", name(result.fused.back().health)},
      {"ate_rmse_m", error(f.ate_rmse_m)},
      {"ate_max_m", error(f.ate_max_m)},
      {"ate_aligned_rmse_m", error(f.aligned_rmse_m)},
      {"fixes_rmse_m", error(f.fixes_rmse_m)},
      {"heading_rmse_deg", error(f.heading_rmse_deg)},
      {"nees_position", error(f.nees_position)},
      {"error_at_end_m", error(f.error_at_end_m)}};
}

Json nees_json(const Nees& nees) {
  if (!nees.ok) return nullptr;
  Json out = {{"frames", nees.frames.size()}};
  for (int part = 0; part < kNeesParts; ++part) out[kNeesNames[part]] = number(nees.mean[part]);
  return out;
}

Json health_json(const RunResult& result) {
  Json jumps = Json::array();
  for (const PoseJump& jump : result.jumps) {
    jumps.push_back({{"t_ns", jump.t}, {"m", jump.jump_m}, {"rad", jump.jump_rad}});
  }
  return {{"at_end", name(result.health_at_end)},
          {"frames_degraded", result.frames_degraded},
          {"confidence_mean", result.confidence.mean},
          {"confidence_min", result.confidence_min},
          {"resets", result.resets},
          {"jumps", jumps}};
}

std::string summary(const RunInfo& info, const Recording& recording, const RunLog& log,
                    const RunResult& result, const std::vector<Count>& player_rejected) {
  Json timing = Json::object();
  for (size_t i = 0; i < kTimingColumns.size(); ++i) {
    timing[kTimingColumns[i].name] = statistics_json(result.timing[i]);
  }
  Json pools = counts_json(log.pools);
  pools["sum"] = result.pool_bytes;
  Json input = counts_json(recording.rejected);
  input.update(counts_json(player_rejected));
  const Json root = {
      {"status", result.done ? "tracked" : "lost"},
      {"verdict", result.verdict},
      {"sequence", info.sequence},
      {"command", info.command},
      {"revision", info.revision},
      {"cores", info.cores},
      {"duration_s", result.duration_s},
      {"wall_s", result.wall_s},
      {"frames",
       {{"in", result.frames_in},
        {"tracked", result.frames_tracked},
        {"lost", result.frames_lost},
        {"before_start", result.frames_before_start},
        {"dropped", result.frames_dropped}}},
      {"health_at_end", name(result.health_at_end)},
      {"health", health_json(result)},
      {"localised_after_s",
       result.localised_after_s < 0 ? Json(nullptr) : Json(result.localised_after_s)},
      {"evaluation", evaluation_json(result.evaluation)},
      {"nees", nees_json(result.nees)},
      {"fused", fused_json(result, log)},
      {"timing_ms", timing},
      {"latency_ms",
       {{"imu_to_pose", latency_json(log.imu_to_pose)},
        {"exposure_to_fused", latency_json(log.exposure_to_fused)}}},
      {"self_calibration",
       {{"time_corrected_s", to_seconds(log.camera_correction)},
        {"time_left_s", log.calibration.time_s},
        {"time_sigma_s", log.calibration.time_sigma_s},
        {"turn_B_rad", vector_json(log.calibration.turn_B)},
        {"turn_sigma_B_rad", vector_json(log.calibration.turn_sigma_B)},
        {"wheel_scale", log.wheel_scale},
        {"wheel_scale_left", log.calibration.scale},
        {"wheel_scale_sigma", log.calibration.scale_sigma}}},
      {"pose_spacing_ms", latency_json(result.pose_spacing)},
      {"keyframes", log.keyframes.size()},
      {"points", log.points.size()},
      {"pools_bytes", pools},
      {"counters", counts_json(log.counters)},
      {"input_rejected", input},
      {"input_notes", recording.notes},
      {"faults", counts_json(info.faults)}};
  return root.dump(2) + "\n";
}

std::string keyframes_tum(const RunLog& log) {
  std::string out;
  for (const BodyState& state : log.keyframes) {
    out += tum_line(state.t, state.T_WB.p, quat_xyzw(state.T_WB.R));
  }
  return out;
}

std::string trajectory_tum(const RunResult& result) {
  std::string out;
  for (const TrajectoryPose& pose : result.trajectory.poses) {
    out += tum_line(pose.t, pose.p_WB, pose.q_WB);
  }
  return out;
}

void append(std::string& out, double value) {
  char text[32];
  std::snprintf(text, sizeof text, ",%.9g", value);
  out += text;
}

// The whole state at every frame that has a pose, with the upper triangle of the covariance of
// theta, p, v, row by row.
std::string state_csv(const RunLog& log) {
  std::string out = "#t_ns,health,px,py,pz,qx,qy,qz,qw,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz";
  for (int i = 0; i < 9; ++i) {
    for (int j = i; j < 9; ++j) out += ",cov" + std::to_string(i) + std::to_string(j);
  }
  out += ",confidence,reasons,resets,accepted,rejected\n";
  for (const FrameReport& frame : log.frames) {
    if (!frame.has_pose) continue;
    const BodyState& state = frame.pose.state;
    out += std::to_string(frame.t) + "," + name(frame.pose.health);
    for (int i = 0; i < 3; ++i) append(out, state.T_WB.p[i]);
    const Vec4 q = quat_xyzw(state.T_WB.R);
    for (int i = 0; i < 4; ++i) append(out, q[i]);
    for (const Vec3* v : {&state.v_WB, &state.b_g, &state.b_a}) {
      for (int i = 0; i < 3; ++i) append(out, (*v)[i]);
    }
    for (int i = 0; i < 9; ++i) {
      for (int j = i; j < 9; ++j) append(out, frame.pose.cov(i, j));
    }
    const Trust& trust = frame.pose.trust;
    append(out, double(trust.confidence));
    out += "," + reasons_text(trust.reasons) + "," + std::to_string(trust.resets) + "," +
           std::to_string(frame.accepted) + "," +
           std::to_string(frame.correspondences - frame.accepted) + "\n";
  }
  return out;
}

// NEES, errors and sigmas at every frame, seconds since the first.
std::string nees_csv(const RunLog& log, const Nees& nees) {
  std::string out = "#t_s";
  for (const char* part : kNeesNames) out += std::string(",") + part;
  for (const char* what : {"error_", "sigma_"}) {
    for (const char* part : kNeesNames) {
      for (const char axis : {'x', 'y', 'z'}) out += "," + (what + std::string(part)) + "_" + axis;
    }
  }
  out += "\n";
  for (const NeesFrame& frame : nees.frames) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", to_seconds(frame.t - log.frames.front().t));
    out += text;
    for (const double value : frame.nees) append(out, value);
    for (const auto* vectors : {&frame.error, &frame.sigma}) {
      for (const Vec3& v : *vectors) {
        for (int i = 0; i < 3; ++i) append(out, v[i]);
      }
    }
    out += "\n";
  }
  return out;
}

std::string timing_csv(const RunLog& log) {
  std::string out = "t_ns";
  for (const TimingColumn& column : kTimingColumns) out += std::string(",") + column.name;
  out += "\n";
  for (const FrameReport& frame : log.frames) {
    out += std::to_string(frame.t);
    for (const TimingColumn& column : kTimingColumns) {
      char text[32];
      std::snprintf(text, sizeof text, ",%.4f", double(frame.*column.field));
      out += text;
    }
    out += "\n";
  }
  return out;
}

}  // namespace

OutputFolder::OutputFolder(const std::string& folder, bool force) : folder_(folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw InputError("cannot make the folder", folder, "choose another --out");
  }
  if (!force && fs::exists(folder + "/summary.json")) {
    throw InputError("holds the results of an earlier run", folder,
                     "choose another --out, or replace them with --force");
  }
  lock_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ >= 0 && flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    close(lock_);
    throw InputError("another run writes there", folder, "choose another --out");
  }
  write(kProbe, "x");
  fs::remove(folder + "/" + kProbe + kPart, error);
  parts_.clear();
}

OutputFolder::~OutputFolder() {
  if (lock_ >= 0) close(lock_);
  std::error_code error;
  for (const std::string& name : parts_) fs::remove(folder_ + "/" + name + kPart, error);
}

void OutputFolder::write(const std::string& name, const std::string& content) {
  parts_.push_back(name);
  const std::string path = folder_ + "/" + name;
  std::ofstream file(path + kPart, std::ios::binary);
  file << content;
  file.close();
  if (file) return;
  std::error_code error;
  fs::remove(path + kPart, error);
  throw InputError("cannot write", path, "check space and permissions");
}

void OutputFolder::commit() {
  for (const std::string& name : parts_) {
    const std::string path = folder_ + "/" + name;
    std::error_code error;
    fs::rename(path + kPart, path, error);
    if (error) throw InputError("cannot write", path, "check what is there now");
  }
  parts_.clear();
}

void write_run_files(OutputFolder& out, const RunInfo& info, const Recording& recording,
                     const RunLog& log, const RunResult& result,
                     const std::vector<Count>& player_rejected) {
  out.write("trajectory.tum", trajectory_tum(result));
  out.write("state.csv", state_csv(log));
  if (result.nees.ok) out.write("nees.csv", nees_csv(log, result.nees));
  if (!result.fused.empty()) {
    out.write("fused.tum", fused_tum(result.fused));
    out.write("fused.csv", fused_csv(result.fused));
  }
  out.write("keyframes.tum", keyframes_tum(log));
  out.write("map.ply", points_ply(log.points));
  out.write("timing.csv", timing_csv(log));
  out.write("summary.json", summary(info, recording, log, result, player_rejected));
}

}  // namespace pirvs::tools
