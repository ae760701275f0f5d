// What    A textured hall with boxes in it, and what a ray through it hits.
// In      The flight to keep free of boxes, or a room that is the same for every flight; seed;
//         number of boxes, and how many of them move; a pillar, if wanted, that goes to and fro
//         before the camera.
// Out     Hit: distance and surface of the first thing on a ray; shade(): its brightness.
// Frames  W, z up. Walls are parallel to the axes.
// Units   m; brightness 0..255 at normal exposure.
// Errors  A ray from outside the hall hits nothing sensible.
// Cost    cast: ~4 ns a box, so give the boxes that can be seen alone; shade: ~20 ns.
// Source  Kay, Kajiya, SIGGRAPH 1986 (slabs).
#pragma once

#include <memory>
#include <vector>

#include "tools/sim/path.h"
#include "tools/sim/texture.h"

namespace pirvs::tools {

struct Ray3 {
  float x, y, z;
};

struct Box {
  float lo[3];
  float hi[3];
};

struct Hit {
  float distance;
  int box;   // 0: the hall itself
  int face;  // 2 * axis + (1: the side of larger coordinate)
};

// Stands from floor to ceiling, and sways sideways across the middle of the view.
struct Pillar {
  double width_m = 0;  // 0: there is none
  Vec3 p_W = Vec3::Zero();
  Vec3 sideways_W = Vec3::UnitY();  // horizontal unit vector
  double sway_m = 0;                // amplitude
  double from_s = 0;                // comes in from the side then; 0: is there from the start
};

// What covers the hall and its boxes.
enum class Surfaces : uint8_t {
  kMixed,
  kChequered,  // repeated texture: any match is as good as the next
  kPlain       // faint texture, within the images' noise
};

struct SceneOptions {
  uint64_t seed = 1;  // of hall, boxes and textures
  int boxes = 40, movers = 0;
  Surfaces surfaces = Surfaces::kMixed;
  bool room = false;   // boxes stand along the walls, outside of where any flight may go
  uint64_t visit = 1;  // seed of what is another in the same room on another day:
  double gone = 0;     // this share of the boxes
  bool relit = false;  // lamps hang elsewhere
  Pillar pillar;
};

class Scene {
 public:
  Scene(const Path& path, const SceneOptions& options);

  // The boxes as they stand at t_s; boxes[0] is the hall.
  void boxes_at(double t_s, std::vector<Box>& out) const;

  // d is a unit vector; candidates are indices of boxes but 0.
  static Hit cast(const Box* boxes, const int* candidates, int count, const Ray3& o, const Ray3& d);
  // angle: of one pixel, rad.
  float shade(const Box* boxes, const Hit& hit, const Ray3& o, const Ray3& d, float angle) const;

 private:
  static constexpr int kLightCells = 24;

  struct Face {
    const Texture* texture;
    float texels_per_m, offset_u, offset_v;
    float cells_per_m[2];
    std::vector<float> light;  // (kLightCells + 1)^2 corners
  };
  struct Mover {
    int box;
    float velocity[2];
    float phase;
  };

  std::vector<std::unique_ptr<Texture>> textures_;
  std::vector<Box> boxes_;
  std::vector<Face> faces_;  // 6 per box
  std::vector<Mover> movers_;
  SceneOptions options_;
  Vec3 lo_, hi_;        // of the hall
  int pillar_box_ = 0;  // 0: none
  float lamps_[4][3];

  void build_hall(const Vec3& lo, const Vec3& hi);
  void place_boxes(const std::vector<Vec3>& path);
  void place_pillar();
  void paint();
  void take_away();
  void light_face(const Box& box, int side, Face& face, float albedo) const;
};

inline Hit Scene::cast(const Box* boxes, const int* candidates, int count, const Ray3& o,
                       const Ray3& d) {
  const float o3[3] = {o.x, o.y, o.z};
  const float inverse[3] = {1 / d.x, 1 / d.y, 1 / d.z};
  Hit hit{1e30f, 0, 0};
  for (int a = 0; a < 3; ++a) {  // from inside: the nearest far wall
    const bool upper = inverse[a] > 0;
    const float t = ((upper ? boxes[0].hi[a] : boxes[0].lo[a]) - o3[a]) * inverse[a];
    if (t < hit.distance) hit = {t, 0, 2 * a + upper};
  }
  for (int k = 0; k < count; ++k) {
    const Box& box = boxes[candidates[k]];
    float near = 0.02f;
    float far = hit.distance;
    int axis = -1;
    for (int a = 0; a < 3; ++a) {
      const float t0 = (box.lo[a] - o3[a]) * inverse[a];
      const float t1 = (box.hi[a] - o3[a]) * inverse[a];
      const float first = t0 < t1 ? t0 : t1;
      const float last = t0 < t1 ? t1 : t0;
      axis = first > near ? a : axis;
      near = first > near ? first : near;
      far = last < far ? last : far;
    }
    if (near < far && axis >= 0) {
      hit = {near, candidates[k], 2 * axis + (inverse[axis] < 0)};
    }
  }
  return hit;
}

}  // namespace pirvs::tools
