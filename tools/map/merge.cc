#include "tools/map/merge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/LU>

#include "core/kernels/hamming/hamming.h"
#include "core/math/so3.h"
#include "modules/map/map_error.h"
#include "modules/map/nodes.h"
#include "tools/dataset/input_error.h"
#include "tools/sim/random.h"

namespace pirvs::tools {
namespace {

constexpr int kBits_max = 60;    // of 256 that may differ
constexpr double kRatio = 0.8;   // to the second nearest
constexpr double kFit_m = 0.15;  // and three sigmas
constexpr int kTries = 3000;
constexpr size_t kShared_min = 40;

struct Pair {
  uint16_t a, b;  // slots
};

template <class Visit>
void for_each_point(const Map& map, Visit&& visit) {
  for (size_t slot = 0; slot < map.landmarks.capacity(); ++slot) {
    if (const Landmark* point = map.landmarks.at(slot)) visit(static_cast<uint16_t>(slot), *point);
  }
}

std::vector<Pair> match(const Map& a, const Map& b) {
  std::vector<Descriptor> of_a;
  std::vector<uint16_t> slots;
  for_each_point(a, [&](uint16_t slot, const Landmark& point) {
    of_a.push_back(point.descriptor);
    slots.push_back(slot);
  });
  std::vector<Pair> out;
  for_each_point(b, [&](uint16_t slot, const Landmark& point) {
    int best = -1, bits = kHammingNone, second = kHammingNone;
    hamming_best(point.descriptor, of_a.data(), int(of_a.size()), best, bits, second);
    if (best >= 0 && bits <= kBits_max && bits < kRatio * second) {
      out.push_back({slots[size_t(best)], slot});
    }
  });
  return out;
}

SE3 motion(double yaw_rad, const Vec3& p) { return {so3_exp(Vec3(0, 0, yaw_rad)), p}; }

// The turn about the vertical and the shift that lay the pairs best on each other.
SE3 fit(const Map& a, const Map& b, const std::vector<Pair>& pairs) {
  Vec3 mean_a = Vec3::Zero(), mean_b = Vec3::Zero();
  for (const Pair& pair : pairs) {
    mean_a += a.landmarks.at(pair.a)->p_W / double(pairs.size());
    mean_b += b.landmarks.at(pair.b)->p_W / double(pairs.size());
  }
  double sine = 0, cosine = 0;
  for (const Pair& pair : pairs) {
    const Vec3 u = a.landmarks.at(pair.a)->p_W - mean_a, v = b.landmarks.at(pair.b)->p_W - mean_b;
    cosine += u.x() * v.x() + u.y() * v.y();
    sine += u.y() * v.x() - u.x() * v.y();
  }
  SE3 out = motion(std::atan2(sine, cosine), Vec3::Zero());
  out.p = mean_a - out.R * mean_b;
  return out;
}

std::vector<Pair> fitting(const Map& a, const Map& b, const std::vector<Pair>& pairs,
                          const SE3& T_AB) {
  std::vector<Pair> out;
  for (const Pair& pair : pairs) {
    const Landmark &u = *a.landmarks.at(pair.a), &v = *b.landmarks.at(pair.b);
    const Vec3 off = T_AB * v.p_W - u.p_W;
    const Mat3 cov = u.cov + T_AB.R * v.cov * T_AB.R.transpose();
    const double variance = off.squaredNorm() > 0 ? off.dot(cov * off) / off.squaredNorm() : 0;
    if (off.norm() < kFit_m + 3 * std::sqrt(variance)) out.push_back(pair);
  }
  return out;
}

std::vector<Pair> consensus(const Map& a, const Map& b, const std::vector<Pair>& pairs) {
  Random random(1, 1);
  std::vector<Pair> best;
  for (int i = 0; i < kTries && pairs.size() >= 2; ++i) {
    const Pair two[] = {pairs[size_t(random.integer(int(pairs.size())))],
                        pairs[size_t(random.integer(int(pairs.size())))]};
    const double apart_a = (a.landmarks.at(two[0].a)->p_W - a.landmarks.at(two[1].a)->p_W).norm();
    const double apart_b = (b.landmarks.at(two[0].b)->p_W - b.landmarks.at(two[1].b)->p_W).norm();
    if (apart_a < 0.5 || std::abs(apart_a - apart_b) > 2 * kFit_m) continue;
    std::vector<Pair> fits = fitting(a, b, pairs, fit(a, b, {two[0], two[1]}));
    if (fits.size() > best.size()) best = std::move(fits);
  }
  return best;
}

// The place of a point that both know, by the information of both.
void fuse(const Landmark& other, Landmark& point) {
  const Mat3 A = point.cov.inverse(), B = other.cov.inverse();
  const Mat3 cov = (A + B).inverse();
  point.p_W = cov * (A * point.p_W + B * other.p_W);
  point.cov = cov;
}

// Slots of what is there, what is seen most first.
template <class T, size_t N, class Worth>
std::vector<uint16_t> by_worth(const Pool<T, N>& pool, Worth&& worth) {
  std::vector<uint16_t> out;
  for (size_t slot = 0; slot < pool.capacity(); ++slot) {
    if (pool.at(slot) != nullptr) out.push_back(static_cast<uint16_t>(slot));
  }
  std::stable_sort(out.begin(), out.end(),
                   [&](uint16_t x, uint16_t y) { return worth(*pool.at(x)) > worth(*pool.at(y)); });
  return out;
}

struct Numbers {
  uint32_t sequence = 0;  // the newest keyframe's
  uint16_t epoch = 0;     // and its
};

Numbers numbers_of(const Map& map) {
  Numbers out;
  for (size_t slot = 0; slot < map.keyframes.capacity(); ++slot) {
    const Keyframe* keyframe = map.keyframes.at(slot);
    if (keyframe == nullptr || keyframe->sequence < out.sequence) continue;
    out = {keyframe->sequence, keyframe->epoch};
  }
  return out;
}

std::map<uint16_t, LandmarkId> add_points(Map& a, const Map& b, const SE3& T_AB,
                                          const std::vector<Pair>& shared, const Numbers& numbers,
                                          MergeReport& report) {
  std::map<uint16_t, LandmarkId> known_as;  // by the slot in b
  for (const Pair& pair : shared) {
    Landmark other = *b.landmarks.at(pair.b);
    move(T_AB, other);
    fuse(other, *a.landmarks.at(pair.a));
    known_as[pair.b] = a.landmarks.handle(pair.a);
  }
  const auto views = [](const Landmark& point) { return point.views; };
  for (const uint16_t slot : by_worth(b.landmarks, views)) {
    if (known_as.count(slot) > 0) continue;
    const Result<LandmarkId> id = a.landmarks.acquire();
    if (!id.ok()) {
      ++report.points_left_out;
      continue;
    }
    Landmark& fresh = *a.landmarks.find(id.value());
    fresh = *b.landmarks.at(slot);
    move(T_AB, fresh);
    fresh.first_keyframe += numbers.sequence;
    fresh.last_keyframe += numbers.sequence;
    fresh.epoch = numbers.epoch;
    fresh.views = 0;
    known_as[slot] = id.value();
  }
  return known_as;
}

void add_keyframe(Map& a, const Keyframe& of_b, const SE3& T_AB,
                  const std::map<uint16_t, LandmarkId>& known_as, const Map& b,
                  const Numbers& numbers, MergeReport& report) {
  const Result<KeyframeId> id = a.keyframes.acquire();
  if (!id.ok()) {
    ++report.keyframes_left_out;
    return;
  }
  Keyframe& fresh = *a.keyframes.find(id.value());
  fresh = of_b;
  move(T_AB, fresh.state);
  fresh.error = turned(T_AB, fresh.error);
  fresh.added = turned(T_AB, fresh.added);
  fresh.sequence += numbers.sequence;
  fresh.epoch = numbers.epoch;
  fresh.linked = false;
  for (Observations& observations : fresh.observations) {
    for (Observation& o : observations) {
      const bool lives = b.landmarks.find(o.landmark) != nullptr;
      const auto found = lives ? known_as.find(o.landmark.slot) : known_as.end();
      o.landmark = found != known_as.end() ? found->second : LandmarkId{};
      Landmark* const point = a.landmarks.find(o.landmark);
      if (point == nullptr) continue;
      ++point->views;
      point->last_keyframe = std::max(point->last_keyframe, fresh.sequence);
    }
  }
}

}  // namespace

MergeReport merge_maps(Map& a, const Map& b) {
  MergeReport report;
  const std::vector<Pair> matched = match(a, b);
  report.matched = matched.size();
  std::vector<Pair> shared = consensus(a, b, matched);
  for (int i = 0; i < 3 && shared.size() >= kShared_min; ++i) {
    report.T_AB = fit(a, b, shared);
    shared = fitting(a, b, matched, report.T_AB);
  }
  report.shared = shared.size();
  if (shared.size() < kShared_min) {
    throw InputError("the maps share too few points, " + std::to_string(shared.size()),
                     "of " + std::to_string(matched.size()) + " alike",
                     "fly through a place that the first knows");
  }
  for (const Pair& pair : shared) {
    const Vec3 off = report.T_AB * b.landmarks.at(pair.b)->p_W - a.landmarks.at(pair.a)->p_W;
    report.rms_m += off.squaredNorm() / double(shared.size());
  }
  report.rms_m = std::sqrt(report.rms_m);
  const Numbers numbers = numbers_of(a);
  const auto known_as = add_points(a, b, report.T_AB, shared, numbers, report);
  const auto sightings = [](const Keyframe& k) {
    return k.observations[0].size() + k.observations[1].size();
  };
  for (const uint16_t slot : by_worth(b.keyframes, sightings)) {
    add_keyframe(a, *b.keyframes.at(slot), report.T_AB, known_as, b, numbers, report);
  }
  for (const Node& node : b.nodes) {
    const Result<SE3> there = node_pose(b, node.name);
    if (!there.ok() || node_pose(a, node.name).ok()) continue;
    (void)set_node(a, node.name, report.T_AB * there.value(), numbers.epoch);
  }
  return report;
}

}  // namespace pirvs::tools
