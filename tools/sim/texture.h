// What    Procedural grey textures with all their smaller versions (a mip pyramid).
// In      Kind, seed.
// Out     kSize x kSize texels, periodic in both directions; sample() between texels and levels.
// Units   u, v in texels of level 0; level: log2 of texels per pixel.
// Errors  none.
// Cost    Making one ~60 ms; a sample ~10 ns when the level fits the cache.
// Source  Williams, "Pyramidal parametrics", SIGGRAPH 1983; value noise with a smooth lattice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pirvs::tools {

// Up to kCount: those of a hall whose surfaces are mixed.
enum class TextureKind : uint8_t {
  kPlaster,
  kTiles,
  kBricks,
  kText,
  kPosters,
  kPlanks,
  kCount,
  kChequers,
  kWhitewash
};

class Texture {
 public:
  static constexpr int kLog2Size = 10;
  static constexpr int kSize = 1 << kLog2Size;
  static constexpr int kLevels = kLog2Size - 1;  // the smallest has 4 x 4 texels

  Texture(TextureKind kind, uint64_t seed);

  float sample(float u, float v, float level) const;

 private:
  std::vector<uint8_t> level_[kLevels];

  float bilinear(float u, float v, int level) const;
};

inline float Texture::bilinear(float u, float v, int level) const {
  const int mask = (kSize >> level) - 1;
  const float scale = 1.0f / float(1 << level);
  const float x = u * scale - 0.5f;
  const float y = v * scale - 0.5f;
  const int ix = int(x) - (x < 0);
  const int iy = int(y) - (y < 0);
  const float ax = x - float(ix);
  const float ay = y - float(iy);
  const uint8_t* const row0 = level_[level].data() + size_t(iy & mask) * size_t(mask + 1);
  const uint8_t* const row1 = level_[level].data() + size_t((iy + 1) & mask) * size_t(mask + 1);
  const int x0 = ix & mask;
  const int x1 = (ix + 1) & mask;
  const float top = float(row0[x0]) + ax * float(row0[x1] - row0[x0]);
  const float bottom = float(row1[x0]) + ax * float(row1[x1] - row1[x0]);
  return top + ay * (bottom - top);
}

inline float Texture::sample(float u, float v, float level) const {
  if (level <= 0) return bilinear(u, v, 0);
  const int fine = int(level);
  if (fine >= kLevels - 1) return bilinear(u, v, kLevels - 1);
  const float a = bilinear(u, v, fine);
  return a + (level - float(fine)) * (bilinear(u, v, fine + 1) - a);
}

}  // namespace pirvs::tools
