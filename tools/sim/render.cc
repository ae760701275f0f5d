#include "tools/sim/render.h"

#include <algorithm>
#include <cmath>

#include "tools/sim/random.h"

namespace pirvs::tools {
namespace {

constexpr size_t kNoiseTable = 1 << 16;

Ray3 rotate(const float (&R)[9], const Ray3& d) {
  return {R[0] * d.x + R[1] * d.y + R[2] * d.z, R[3] * d.x + R[4] * d.y + R[5] * d.z,
          R[6] * d.x + R[7] * d.y + R[8] * d.z};
}

float dot(const Ray3& a, const Ray3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

float angle_between(const Ray3& a, const Ray3& b) {
  return std::acos(std::clamp(dot(a, b), -1.0f, 1.0f));
}

}  // namespace

Renderer::Renderer(const Camera& camera, const Scene& scene, const Path& path,
                   const std::vector<Vec3>& rays_C)
    : camera_(camera), scene_(scene), path_(path) {
  const size_t pixels = size_t(camera.width) * size_t(camera.height);
  rays_C_.resize(pixels);
  vignette_.resize(pixels);
  sum_.resize(pixels);
  grey_.resize(pixels);
  surface_.resize(pixels);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const size_t i = size_t(y) * size_t(camera.width) + size_t(x);
      Vec3 bearing_C;
      if (!rays_C.empty()) bearing_C = rays_C[i];
      const bool seen =
          rays_C.empty() ? camera.unproject(Vec2(x, y), bearing_C) : !bearing_C.isZero(0);
      if (!seen) bearing_C = Vec3(0, 0, 1);
      rays_C_[i] = {float(bearing_C.x()), float(bearing_C.y()), float(bearing_C.z())};
      const float c = std::max(0.0f, rays_C_[i].z);
      vignette_[i] = seen ? 0.45f + 0.55f * c : 0.0f;
    }
  }
  Random random(0, 6);
  noise_.resize(kNoiseTable);
  for (float& n : noise_) n = float(random.normal());
  make_tiles();
}

void Renderer::make_tiles() {
  const int w = camera_.width;
  const int h = camera_.height;
  const auto ray = [&](int x, int y) { return rays_C_[size_t(y) * size_t(w) + size_t(x)]; };
  for (int y0 = 0; y0 < h; y0 += kTile) {
    for (int x0 = 0; x0 < w; x0 += kTile) {
      Tile tile{};
      tile.x0 = x0;
      tile.y0 = y0;
      tile.x1 = std::min(w, x0 + kTile);
      tile.y1 = std::min(h, y0 + kTile);
      const int mx = (tile.x0 + tile.x1 - 1) / 2;
      const int my = (tile.y0 + tile.y1 - 1) / 2;
      tile.axis_C = ray(mx, my);
      for (const int x : {tile.x0, tile.x1 - 1}) {
        for (const int y : {tile.y0, tile.y1 - 1}) {
          tile.half_angle = std::max(tile.half_angle, angle_between(tile.axis_C, ray(x, y)));
        }
      }
      const int beside = mx + 1 < w ? mx + 1 : mx - 1;
      tile.pixel_angle = std::max(1e-4f, angle_between(tile.axis_C, ray(beside, my)));
      tile.half_angle += 3 * tile.pixel_angle;  // edges are smoothed with rays of the neighbours
      tiles_.push_back(tile);
    }
  }
}

// One sub-image per kStep_px that the picture moves while the shutter is open.
int Renderer::sub_images(const Exposure& exposure) const {
  constexpr double kTypicalDistance_m = 2.5;
  constexpr double kStep_px = 1.5;
  const PathState state = path_.at(exposure.t_s);
  const double rate = state.w_B.norm() + state.v_WB.norm() / kTypicalDistance_m;
  const double smear_px = rate * exposure.length_s * camera_.fx;
  return std::clamp(int(std::ceil(smear_px / kStep_px)), 1, std::max(1, exposure.sub_images_max));
}

void Renderer::render(const Exposure& exposure, std::vector<uint8_t>& image) {
  const int n = sub_images(exposure);
  std::fill(sum_.begin(), sum_.end(), 0.0f);
  for (int k = 0; k < n; ++k) {
    draw(exposure.t_s + exposure.length_s * ((k + 0.5) / n - 0.5));
    for (size_t i = 0; i < sum_.size(); ++i) sum_[i] += grey_[i];
  }
  develop(exposure, n, image);
}

void Renderer::draw(double t_s) {
  const PathState state = path_.at(t_s);
  const Mat3 R_WC = state.R_WB * camera_.T_BC.R;
  const Vec3 p_WC = state.p_WB + state.R_WB * camera_.T_BC.p;
  const Ray3 o = {float(p_WC.x()), float(p_WC.y()), float(p_WC.z())};
  float R[9];
  for (int i = 0; i < 9; ++i) R[i] = float(R_WC(i / 3, i % 3));
  scene_.boxes_at(t_s, boxes_);
  const bool moved = drawn_boxes_.empty() || R_WC != drawn_T_WC_.R || p_WC != drawn_T_WC_.p;
  for (Tile& tile : tiles_) tile.stale = moved;
  if (!moved) mark_stale();  // where a box leaves
  find_candidates(o, R_WC);
  if (!moved) mark_stale();  // where one comes
  drawn_boxes_ = boxes_;
  drawn_T_WC_ = {R_WC, p_WC};
  for (const Tile& tile : tiles_) {
    if (tile.stale) draw_tile(tile, o, R);
  }
  for (const Tile& tile : tiles_) {
    if (tile.stale) smooth_edges(tile, o, R);
  }
}

void Renderer::mark_stale() {
  for (Tile& tile : tiles_) {
    for (int k = tile.first; k < tile.first + tile.count; ++k) {
      const size_t n = size_t(candidates_[size_t(k)]);
      for (int a = 0; a < 3; ++a) {
        tile.stale |= boxes_[n].lo[a] != drawn_boxes_[n].lo[a];
        tile.stale |= boxes_[n].hi[a] != drawn_boxes_[n].hi[a];
      }
    }
  }
}

// A tile's rays fill a cone, a box fits in a ball: do they meet?
void Renderer::find_candidates(const Ray3& o, const Mat3& R_WC) {
  float R[9];
  for (int i = 0; i < 9; ++i) R[i] = float(R_WC(i / 3, i % 3));
  struct Ball {
    Ray3 direction;
    float angle;
  };
  std::vector<Ball> balls(boxes_.size());
  for (size_t n = 1; n < boxes_.size(); ++n) {
    const Box& box = boxes_[n];
    const Ray3 to = {(box.lo[0] + box.hi[0]) / 2 - o.x, (box.lo[1] + box.hi[1]) / 2 - o.y,
                     (box.lo[2] + box.hi[2]) / 2 - o.z};
    const Ray3 half = {(box.hi[0] - box.lo[0]) / 2, (box.hi[1] - box.lo[1]) / 2,
                       (box.hi[2] - box.lo[2]) / 2};
    const float distance = std::sqrt(dot(to, to));
    const float radius = std::sqrt(dot(half, half));
    balls[n].direction = {to.x / distance, to.y / distance, to.z / distance};
    balls[n].angle = distance > radius ? std::asin(radius / distance) : float(M_PI);
  }
  candidates_.clear();
  for (Tile& tile : tiles_) {
    const Ray3 axis = rotate(R, tile.axis_C);
    tile.first = int(candidates_.size());
    for (size_t n = 1; n < boxes_.size(); ++n) {
      if (angle_between(axis, balls[n].direction) < tile.half_angle + balls[n].angle) {
        candidates_.push_back(int(n));
      }
    }
    tile.count = int(candidates_.size()) - tile.first;
  }
}

void Renderer::draw_tile(const Tile& tile, const Ray3& o, const float (&R)[9]) {
  const int* const candidates = candidates_.data() + tile.first;
  for (int y = tile.y0; y < tile.y1; ++y) {
    for (int x = tile.x0; x < tile.x1; ++x) {
      const size_t i = size_t(y) * size_t(camera_.width) + size_t(x);
      const Ray3 d = rotate(R, rays_C_[i]);
      const Hit hit = Scene::cast(boxes_.data(), candidates, tile.count, o, d);
      surface_[i] = uint16_t(6 * hit.box + hit.face);
      grey_[i] = scene_.shade(boxes_.data(), hit, o, d, tile.pixel_angle) * vignette_[i];
    }
  }
}

// Where two surfaces meet, four rays a quarter pixel off the centre; else edges would be stairs.
void Renderer::smooth_edges(const Tile& tile, const Ray3& o, const float (&R)[9]) {
  const int w = camera_.width;
  const int* const candidates = candidates_.data() + tile.first;
  const int x_end = std::min(tile.x1, w - 1);
  const int y_end = std::min(tile.y1, camera_.height - 1);
  for (int y = std::max(tile.y0, 1); y < y_end; ++y) {
    for (int x = std::max(tile.x0, 1); x < x_end; ++x) {
      const size_t i = size_t(y) * size_t(w) + size_t(x);
      const uint16_t own = surface_[i];
      if (own == surface_[i - 1] && own == surface_[i + 1] && own == surface_[i - size_t(w)] &&
          own == surface_[i + size_t(w)]) {
        continue;
      }
      float sum = 0;
      for (int k = 0; k < 4; ++k) {
        const Ray3& c = rays_C_[i];
        const Ray3& a = rays_C_[k & 1 ? i + 1 : i - 1];
        const Ray3& b = rays_C_[k & 2 ? i + size_t(w) : i - size_t(w)];
        const Ray3 d_C = {0.5f * c.x + 0.25f * (a.x + b.x), 0.5f * c.y + 0.25f * (a.y + b.y),
                          0.5f * c.z + 0.25f * (a.z + b.z)};
        const Ray3 d = rotate(R, d_C);
        const Hit hit = Scene::cast(boxes_.data(), candidates, tile.count, o, d);
        sum += scene_.shade(boxes_.data(), hit, o, d, tile.pixel_angle);
      }
      grey_[i] = 0.25f * sum * vignette_[i];
    }
  }
}

void Renderer::develop(const Exposure& exposure, int sub_images,
                       std::vector<uint8_t>& image) const {
  const float gain = float(exposure.gain / sub_images);
  // Half of the variance at mid grey is the amplifier's, half the light's own.
  float sigma[256];
  for (int v = 0; v < 256; ++v) {
    sigma[v] = float(exposure.noise_grey) * std::sqrt(0.5f + 0.5f * float(v) / 128);
  }
  const size_t w = size_t(camera_.width);
  image.resize(sum_.size());
  for (size_t y = 0; y < size_t(camera_.height); ++y) {
    const size_t from = mix64(exposure.noise_stream * 4099 + y) % kNoiseTable;
    for (size_t x = 0; x < w; ++x) {
      const float clean = std::clamp(sum_[y * w + x] * gain, 0.0f, 255.0f);
      const float noise = noise_[(from + x) % kNoiseTable] * sigma[int(clean)];
      image[y * w + x] = uint8_t(std::clamp(clean + noise + 0.5f, 0.0f, 255.0f));
    }
  }
}

}  // namespace pirvs::tools
