#include "tools/sim/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tools/sim/random.h"

namespace pirvs::tools {
namespace {

constexpr double kClearance_m = 0.8;  // no box nearer to the path
constexpr double kHallMargin_m = 3.0;
constexpr double kPathStep_s = 0.1;
constexpr int kTexturesPerKind = 2;
constexpr double kSway_rad_s = 1.2;  // of the pillar
constexpr double kAside = 6;         // pillar widths: out of the widest view
constexpr double kComeIn_s = 2;

double distance_outside(const Box& box, const Vec3& p) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    const double d = std::max({double(box.lo[a]) - p[a], 0.0, p[a] - double(box.hi[a])});
    sum += d * d;
  }
  return std::sqrt(sum);
}

bool clear(const Box& box, const std::vector<Vec3>& path, double distance_m) {
  return std::all_of(path.begin(), path.end(),
                     [&](const Vec3& p) { return distance_outside(box, p) > distance_m; });
}

bool overlaps(const Box& box, const Vec3& lo, const Vec3& hi) {
  for (int a = 0; a < 3; ++a) {
    if (double(box.hi[a]) < lo[a] || double(box.lo[a]) > hi[a]) return false;
  }
  return true;
}

// Straight lines between the powers of two, 0.09 below at most: mip levels need no more.
float log2_roughly(float x) {
  uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return float(bits) * 0x1p-23f - 127.0f;
}

// In a face, u runs along the first of the two other axes, v along the second.
void face_axes(int axis, int& u, int& v) {
  u = axis == 0 ? 1 : 0;
  v = axis == 2 ? 1 : 2;
}

}  // namespace

Scene::Scene(const Path& path, const SceneOptions& options) : options_(options) {
  for (int k = 0; k < int(TextureKind::kCount) * kTexturesPerKind; ++k) {
    const auto kind = options.surfaces == Surfaces::kMixed
                          ? TextureKind(k % int(TextureKind::kCount))
                      : options.surfaces == Surfaces::kChequered ? TextureKind::kChequers
                                                                 : TextureKind::kWhitewash;
    textures_.push_back(std::make_unique<Texture>(kind, mix64(options.seed) + uint64_t(k)));
  }
  std::vector<Vec3> points;
  for (double t_s = 0; t_s < path.duration_s(); t_s += kPathStep_s) {
    points.push_back(path.at(t_s).p_WB);
  }
  points.push_back(path.at(path.duration_s()).p_WB);
  if (options.room) {
    build_hall(kFlightLo, kFlightHi);
  } else {
    Vec3 lo = points[0], hi = points[0];
    for (const Vec3& p : points) {
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    }
    build_hall(lo, hi);
  }
  place_boxes(points);
  place_pillar();
  paint();
  take_away();
}

void Scene::build_hall(const Vec3& lo, const Vec3& hi) {
  // A short flight still gets a hall, not a cupboard.
  const Vec3 grow = (Vec3(4, 3, 0) - (hi - lo)).cwiseMax(0) / 2;
  lo_ = lo - (grow + Vec3(kHallMargin_m, kHallMargin_m, 1.0));
  hi_ = hi + (grow + Vec3(kHallMargin_m, kHallMargin_m, 1.8));
  Box hall{};
  for (int a = 0; a < 3; ++a) {
    hall.lo[a] = float(lo_[a]);
    hall.hi[a] = float(hi_[a]);
  }
  boxes_.push_back(hall);
}

void Scene::place_boxes(const std::vector<Vec3>& path) {
  // What moves is another each day, and whatever stands in the room stands without it.
  Random random(options_.seed, 4), visit(options_.visit, 6);
  const int movers = options_.room ? options_.movers : std::min(options_.movers, options_.boxes);
  const int static_boxes = options_.room ? options_.boxes : options_.boxes - movers;
  const auto standing = [&] { return int(boxes_.size() - movers_.size()) - 1; };
  for (int tries = 0; tries < 20000; ++tries) {
    // In a room they come last.
    const bool moves =
        int(movers_.size()) < movers && (!options_.room || standing() == static_boxes);
    if (!moves && standing() == static_boxes) break;
    Random& from = moves && options_.room ? visit : random;
    const double size[3] = {from.uniform(0.2, 1.5), from.uniform(0.2, 1.5), from.uniform(0.3, 2.2)};
    const bool stands = from.uniform() < 0.75;
    Box box{};
    for (int a = 0; a < 3; ++a) {
      const double begin = a == 2 && stands ? lo_[a] : from.uniform(lo_[a], hi_[a] - size[a]);
      box.lo[a] = float(begin);
      box.hi[a] = float(begin + size[a]);
    }
    const float v[2] = {float(from.uniform(-0.4, 0.4)), float(from.uniform(-0.4, 0.4))};
    const bool fits = options_.room ? !overlaps(box, kFlightLo, kFlightHi)
                                    : clear(box, path, kClearance_m + (moves ? 0.6 : 0));
    if (!fits) continue;
    if (moves) movers_.push_back({int(boxes_.size()), {v[0], v[1]}, float(from.uniform(0, 6))});
    boxes_.push_back(box);
  }
}

// The last box, so that all others are as they would be without it.
void Scene::place_pillar() {
  const Pillar& pillar = options_.pillar;
  if (pillar.width_m <= 0) return;
  const Box& hall = boxes_[0];
  Box box{};
  for (int a = 0; a < 2; ++a) {
    box.lo[a] = float(pillar.p_W[a] - pillar.width_m / 2);
    box.hi[a] = float(pillar.p_W[a] + pillar.width_m / 2);
  }
  box.lo[2] = hall.lo[2];
  box.hi[2] = hall.hi[2];
  pillar_box_ = int(boxes_.size());
  boxes_.push_back(box);
}

void Scene::paint() {
  Random random(options_.seed, 5), visit(options_.visit, 8);
  const Box& hall = boxes_[0];
  for (auto& lamp : lamps_) {
    for (int a = 0; a < 2; ++a) lamp[a] = float(random.uniform(hall.lo[a], hall.hi[a]));
    if (options_.relit) {
      for (int a = 0; a < 2; ++a) lamp[a] = float(visit.uniform(hall.lo[a], hall.hi[a]));
    }
    lamp[2] = hall.hi[2] - 0.2f;
  }
  faces_.resize(boxes_.size() * 6);
  for (size_t i = 0; i < faces_.size(); ++i) {
    Face& face = faces_[i];
    const bool wall = i < 6;
    face.texture = textures_[size_t(random.integer(int(textures_.size())))].get();
    face.texels_per_m = float((wall ? 200 : 300) * random.uniform(0.75, 1.35));
    face.offset_u = float(random.uniform(0, Texture::kSize));
    face.offset_v = float(random.uniform(0, Texture::kSize));
    light_face(boxes_[i / 6], int(i % 6), face, float(random.uniform(0.75, 1.25)));
  }
}

// Behind the walls, where no ray comes: all others keep their numbers.
void Scene::take_away() {
  constexpr float kFar_m = 1000;
  Random random(options_.visit, 7);
  const int standing = int(boxes_.size() - movers_.size()) - 1 - (pillar_box_ > 0 ? 1 : 0);
  int wanted = int(std::lround(options_.gone * standing));
  for (int left = standing, box = 1; left > 0 && wanted > 0; --left, ++box) {
    if (random.integer(left) >= wanted) continue;
    boxes_[size_t(box)].lo[2] -= kFar_m;
    boxes_[size_t(box)].hi[2] -= kFar_m;
    --wanted;
  }
}

void Scene::light_face(const Box& box, int side, Face& face, float albedo) const {
  const int axis = side / 2;
  int u = 0;
  int v = 0;
  face_axes(axis, u, v);
  face.cells_per_m[0] = kLightCells / (box.hi[u] - box.lo[u]);
  face.cells_per_m[1] = kLightCells / (box.hi[v] - box.lo[v]);
  face.light.resize((kLightCells + 1) * (kLightCells + 1));
  for (int j = 0; j <= kLightCells; ++j) {
    for (int i = 0; i <= kLightCells; ++i) {
      float p[3];
      p[axis] = side % 2 ? box.hi[axis] : box.lo[axis];
      p[u] = box.lo[u] + float(i) / face.cells_per_m[0];
      p[v] = box.lo[v] + float(j) / face.cells_per_m[1];
      float light = 0.55f;
      for (const auto& lamp : lamps_) {
        const float d[3] = {lamp[0] - p[0], lamp[1] - p[1], lamp[2] - p[2]};
        const float d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + 1e-3f;
        light += 3.5f * std::abs(d[axis]) / std::sqrt(d2) / (5 + d2);
      }
      face.light[size_t(j * (kLightCells + 1) + i)] = albedo * std::min(light, 1.5f);
    }
  }
}

void Scene::boxes_at(double t_s, std::vector<Box>& out) const {
  out = boxes_;
  for (const Mover& mover : movers_) {
    const float way = 1.5f * float(std::sin(t_s + double(mover.phase)));
    for (int a = 0; a < 2; ++a) {
      out[size_t(mover.box)].lo[a] += mover.velocity[a] * way;
      out[size_t(mover.box)].hi[a] += mover.velocity[a] * way;
    }
  }
  if (pillar_box_ == 0) return;
  const Pillar& pillar = options_.pillar;
  double way_m = pillar.sway_m * std::sin(kSway_rad_s * t_s);
  if (pillar.from_s > 0) {
    const double come = std::clamp((t_s - pillar.from_s) / kComeIn_s, 0.0, 1.0);
    way_m += kAside * pillar.width_m * (1 - come * come * (3 - 2 * come));
  }
  for (int a = 0; a < 2; ++a) {
    const float step_m = float(way_m * pillar.sideways_W[a]);
    out[size_t(pillar_box_)].lo[a] += step_m;
    out[size_t(pillar_box_)].hi[a] += step_m;
  }
}

float Scene::shade(const Box* boxes, const Hit& hit, const Ray3& o, const Ray3& d,
                   float angle) const {
  const Box& box = boxes[hit.box];
  const Face& face = faces_[size_t(6 * hit.box + hit.face)];
  const int axis = hit.face / 2;
  const float p[3] = {o.x + hit.distance * d.x - box.lo[0], o.y + hit.distance * d.y - box.lo[1],
                      o.z + hit.distance * d.z - box.lo[2]};
  const float in_u = p[axis == 0 ? 1 : 0];
  const float in_v = p[axis == 2 ? 1 : 2];
  const float cosine = std::max(0.15f, std::abs(axis == 0 ? d.x : axis == 1 ? d.y : d.z));
  // Texels under one pixel, the mean of the stretched and the unstretched direction.
  const float texels = face.texels_per_m * hit.distance * angle / std::sqrt(cosine);
  const float level = texels > 1 ? log2_roughly(texels) : 0.0f;
  const float grey = face.texture->sample(face.offset_u + face.texels_per_m * in_u,
                                          face.offset_v + face.texels_per_m * in_v, level);
  const float x = std::clamp(in_u * face.cells_per_m[0], 0.0f, float(kLightCells) - 0.001f);
  const float y = std::clamp(in_v * face.cells_per_m[1], 0.0f, float(kLightCells) - 0.001f);
  const int ix = int(x);
  const int iy = int(y);
  const float* const l = face.light.data() + iy * (kLightCells + 1) + ix;
  const float ax = x - float(ix);
  const float ay = y - float(iy);
  const float top = l[0] + ax * (l[1] - l[0]);
  const float bottom = l[kLightCells + 1] + ax * (l[kLightCells + 2] - l[kLightCells + 1]);
  return grey * (top + ay * (bottom - top));
}

}  // namespace pirvs::tools
