#include "tools/sim/texture.h"

#include <algorithm>
#include <cmath>

#include "tools/sim/random.h"

namespace pirvs::tools {
namespace {

constexpr int kSize = Texture::kSize;
using Canvas = std::vector<float>;  // kSize x kSize, 0..1

float hash01(uint64_t seed, int x, int y) {
  return float(mix64(seed ^ (uint64_t(uint32_t(x)) << 32 | uint32_t(y))) >> 40) * 0x1p-24f;
}

float smooth(float t) { return t * t * (3 - 2 * t); }

// Adds periodic value noise of cells_x x cells_y cells, range +-amplitude.
void add_noise(Canvas& canvas, uint64_t seed, int cells_x, int cells_y, float amplitude) {
  std::vector<float> row(size_t(cells_x) + 1);  // the lattice at one y
  for (int y = 0; y < kSize; ++y) {
    const float fy = float(y) * float(cells_y) / kSize;
    const int y0 = int(fy);
    const float ay = smooth(fy - float(y0));
    for (int c = 0; c <= cells_x; ++c) {
      const float top = hash01(seed, c % cells_x, y0);
      const float bottom = hash01(seed, c % cells_x, (y0 + 1) % cells_y);
      row[size_t(c)] = 2 * (top + ay * (bottom - top)) - 1;
    }
    float* const out = canvas.data() + size_t(y) * kSize;
    for (int x = 0; x < kSize; ++x) {
      const float fx = float(x) * float(cells_x) / kSize;
      const int x0 = int(fx);
      const float ax = smooth(fx - float(x0));
      out[x] += amplitude * (row[size_t(x0)] + ax * (row[size_t(x0) + 1] - row[size_t(x0)]));
    }
  }
}

void add_octaves(Canvas& canvas, Random& random, int from, int to, float amplitude, float decay) {
  for (int cells = from; cells <= to; cells *= 2) {
    add_noise(canvas, random.bits(), cells, cells, amplitude);
    amplitude *= decay;
  }
}

void fill_rectangle(Canvas& canvas, int x0, int y0, int w, int h, float value) {
  for (int y = y0; y < y0 + h; ++y) {
    for (int x = x0; x < x0 + w; ++x) {
      canvas[size_t(y & (kSize - 1)) * kSize + size_t(x & (kSize - 1))] = value;
    }
  }
}

void fill_disc(Canvas& canvas, int x0, int y0, int radius, float value) {
  for (int y = -radius; y <= radius; ++y) {
    const int half = int(std::sqrt(float(radius * radius - y * y)));
    fill_rectangle(canvas, x0 - half, y0 + y, 2 * half + 1, 1, value);
  }
}

void draw_bricks(Canvas& canvas, Random& random, int columns, int rows, bool shifted) {
  const int w = kSize / columns;
  const int h = kSize / rows;
  const int joint = std::max(3, h / 14);
  std::fill(canvas.begin(), canvas.end(), 0.25f);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int x = c * w + (shifted && r % 2 ? w / 2 : 0);
      fill_rectangle(canvas, x, r * h, w - joint, h - joint, float(random.uniform(0.35, 0.85)));
    }
  }
}

// Lines of made-up letters: each is a grid of 3 x 5 cells, about half of them black.
void draw_text(Canvas& canvas, Random& random) {
  std::fill(canvas.begin(), canvas.end(), 0.85f);
  int y = 16;
  while (y < kSize - 40) {
    const int cell = random.integer(4) == 0 ? 5 + random.integer(4) : 2 + random.integer(2);
    if (y + 7 * cell > kSize - 8) break;
    int x = 24;
    const int end = kSize - 24 - random.integer(300);
    while (x + 4 * cell < end) {
      const float ink = float(random.uniform(0.05, 0.3));
      const uint64_t glyph = random.bits();
      const bool blank = random.integer(6) == 0;
      for (int k = 0; k < 15 && !blank; ++k) {
        if (!(glyph >> k & 1)) continue;
        fill_rectangle(canvas, x + k % 3 * cell, y + k / 3 * cell, cell, cell, ink);
      }
      x += 4 * cell;
    }
    y += 8 * cell;
  }
}

void draw_posters(Canvas& canvas, Random& random) {
  std::fill(canvas.begin(), canvas.end(), 0.55f);
  for (int k = 0; k < 260; ++k) {
    const int size = 8 + random.integer(k < 40 ? 220 : 60);
    const float value = float(random.uniform(0.08, 0.95));
    const int x = random.integer(kSize);
    const int y = random.integer(kSize);
    if (random.integer(3) == 0) {
      fill_disc(canvas, x, y, size / 2, value);
    } else {
      fill_rectangle(canvas, x, y, size, 8 + random.integer(size), value);
    }
  }
}

void draw_planks(Canvas& canvas, Random& random) {
  constexpr int kPlank = 64;
  for (int x = 0; x < kSize; x += kPlank) {
    fill_rectangle(canvas, x, 0, kPlank - 3, kSize, float(random.uniform(0.4, 0.7)));
    fill_rectangle(canvas, x + kPlank - 3, 0, 3, kSize, 0.15f);
    const int joint = random.integer(kSize);
    fill_rectangle(canvas, x, joint, kPlank - 3, 3, 0.15f);
    for (int k = 0; k < 5; ++k) {
      fill_disc(canvas, x + 8 + random.integer(44), random.integer(kSize), 2 + random.integer(5),
                0.2f);
    }
  }
  for (int cells = 32; cells <= 256; cells *= 2) {
    add_noise(canvas, random.bits(), cells, cells / 8, 0.06f);
  }
}

// Every field is as all others: nothing tells one corner from another.
void draw_chequers(Canvas& canvas) {
  constexpr int kField = kSize / 32;
  for (int y = 0; y < kSize; y += kField) {
    for (int x = 0; x < kSize; x += kField) {
      fill_rectangle(canvas, x, y, kField, kField, (x + y) / kField % 2 == 0 ? 0.2f : 0.8f);
    }
  }
}

void draw(TextureKind kind, Canvas& canvas, Random& random) {
  switch (kind) {
    case TextureKind::kPlaster:
      std::fill(canvas.begin(), canvas.end(), 0.5f);
      add_octaves(canvas, random, 8, 512, 0.34f, 0.8f);
      break;
    case TextureKind::kTiles:
      draw_bricks(canvas, random, 8, 8, false);
      add_octaves(canvas, random, 32, 512, 0.08f, 0.9f);
      break;
    case TextureKind::kBricks:
      draw_bricks(canvas, random, 8, 16, true);
      add_octaves(canvas, random, 64, 512, 0.09f, 0.9f);
      break;
    case TextureKind::kText:
      draw_text(canvas, random);
      add_octaves(canvas, random, 4, 64, 0.04f, 0.8f);
      break;
    case TextureKind::kPosters:
      draw_posters(canvas, random);
      add_octaves(canvas, random, 64, 512, 0.04f, 0.9f);
      break;
    case TextureKind::kChequers:
      draw_chequers(canvas);
      break;
    case TextureKind::kWhitewash:
      std::fill(canvas.begin(), canvas.end(), 0.6f);
      add_octaves(canvas, random, 16, 256, 0.008f, 0.8f);
      break;
    case TextureKind::kPlanks:
    case TextureKind::kCount:
      draw_planks(canvas, random);
      break;
  }
}

}  // namespace

Texture::Texture(TextureKind kind, uint64_t seed) {
  Random random(seed, 3);
  Canvas canvas(size_t(kSize) * kSize, 0.0f);
  draw(kind, canvas, random);
  level_[0].resize(canvas.size());
  for (size_t i = 0; i < canvas.size(); ++i) {
    level_[0][i] = uint8_t(std::clamp(canvas[i], 0.02f, 1.0f) * 255.0f);
  }
  for (int level = 1; level < kLevels; ++level) {
    const int size = kSize >> level;
    const auto& fine = level_[level - 1];
    level_[level].resize(size_t(size) * size_t(size));
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const size_t at = size_t(2 * y) * size_t(2 * size) + size_t(2 * x);
        const size_t below = at + size_t(2 * size);
        const int sum = fine[at] + fine[at + 1] + fine[below] + fine[below + 1];
        level_[level][size_t(y) * size_t(size) + size_t(x)] = uint8_t((sum + 2) / 4);
      }
    }
  }
}

}  // namespace pirvs::tools
