// What    Draws what one camera sees: rays through its lens model, edges smoothed, exposure time,
//         vignetting, sensor noise.
// In      Camera, scene, path; the time and length of the exposure.
// Out     8-bit grey image, width x height of the camera.
// Frames  pixels: (0,0) = centre of the first one; T_BC of the camera.
// Units   s, px; noise in grey values.
// Errors  none; pixels that the lens model does not reach stay black.
// Cost    ~45 ns a pixel and sub-image, one thread; from one and the same place, only where boxes
//         have moved. One Renderer per thread: it holds buffers.
// Source  render loop our own; noise: constant + proportional to the signal (EMVA 1288).
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera/camera.h"
#include "tools/sim/scene.h"

namespace pirvs::tools {

struct Exposure {
  double t_s = 0;             // middle
  double length_s = 0;        // motion blur; 0: none
  int sub_images_max = 1;     // how finely the blur may be resolved
  double gain = 1;            // 1: well exposed
  double noise_grey = 0;      // sigma at mid grey
  uint64_t noise_stream = 0;  // differs for every image
};

class Renderer {
 public:
  // rays_C: those of the pixels, where the camera's own are not what its lens does; zero: none.
  Renderer(const Camera& camera, const Scene& scene, const Path& path,
           const std::vector<Vec3>& rays_C = {});

  void render(const Exposure& exposure, std::vector<uint8_t>& image);

 private:
  static constexpr int kTile = 16;

  struct Tile {
    int x0, y0, x1, y1;
    Ray3 axis_C;
    float half_angle;
    float pixel_angle;
    int first, count;  // range of candidates_
    bool stale;        // what it shows has changed since it was drawn
  };

  Camera camera_;
  const Scene& scene_;
  const Path& path_;
  std::vector<Ray3> rays_C_;
  std::vector<float> vignette_;  // 0: the lens does not reach this pixel
  std::vector<Tile> tiles_;
  std::vector<Box> boxes_, drawn_boxes_;
  SE3 drawn_T_WC_;
  std::vector<int> candidates_;
  std::vector<float> sum_;
  std::vector<float> grey_;
  std::vector<uint16_t> surface_;
  std::vector<float> noise_;

  void make_tiles();
  int sub_images(const Exposure& exposure) const;
  void draw(double t_s);
  void find_candidates(const Ray3& o, const Mat3& R_WC);
  void mark_stale();
  void draw_tile(const Tile& tile, const Ray3& o, const float (&R)[9]);
  void smooth_edges(const Tile& tile, const Ray3& o, const float (&R)[9]);
  void develop(const Exposure& exposure, int sub_images, std::vector<uint8_t>& image) const;
};

}  // namespace pirvs::tools
