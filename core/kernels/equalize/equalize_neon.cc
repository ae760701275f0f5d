#include <cstring>

#include "core/kernels/equalize/equalize.h"
#include "core/kernels/equalize/equalize_table.h"
#include "core/kernels/neon.h"

namespace pirvs {
namespace {

// The compilers may not look through p. They would fold an entry's address into its load and its
// store, which takes a Cortex-A72 one more operation each, and x86-64 none.
inline uint32_t* hidden(uint32_t* p) {
#if defined(__aarch64__)
  asm("" : "+r"(p));
#endif
  return p;
}

// Four histograms: neighbouring pixels are often equal, and a count that was just stored would have
// to be waited for. Scalar on every machine, as a histogram has no vector form.
void count(const ImageView& in, int every, uint32_t (&histogram)[256]) {
  uint32_t counts[4][256] = {};
  uint32_t* const tables[4] = {hidden(counts[0]), hidden(counts[1]), hidden(counts[2]),
                               hidden(counts[3])};
  const int width = in.width;
  for (int y = 0; y < in.height; y += every) {
    const uint8_t* p = in.row(y);
    int x = 0;
    for (; x + 8 <= width; x += 8) {
      uint64_t bytes;
      std::memcpy(&bytes, p + x, 8);
      for (int i = 0; i < 8; ++i) ++*hidden(tables[i & 3] + (bytes >> (8 * i) & 255));
    }
    for (; x < width; ++x) ++counts[x & 3][p[x]];
  }
  for (int v = 0; v < 256; ++v)
    histogram[v] = counts[0][v] + counts[1][v] + counts[2][v] + counts[3][v];
}

#if defined(__aarch64__)

// 64 entries per lookup; an index outside leaves the lane as it was.
void map_row(const uint8_t* in, const uint8_t (&table)[256], int width, uint8_t* out) {
  const uint8x16x4_t t0 = vld1q_u8_x4(table), t1 = vld1q_u8_x4(table + 64);
  const uint8x16x4_t t2 = vld1q_u8_x4(table + 128), t3 = vld1q_u8_x4(table + 192);
  const uint8x16_t block = vdupq_n_u8(64);
  int x = 0;
  for (; x + 16 <= width; x += 16) {
    uint8x16_t index = vld1q_u8(in + x);
    uint8x16_t mapped = vqtbl4q_u8(t0, index);
    mapped = vqtbx4q_u8(mapped, t1, index = vsubq_u8(index, block));
    mapped = vqtbx4q_u8(mapped, t2, index = vsubq_u8(index, block));
    vst1q_u8(out + x, vqtbx4q_u8(mapped, t3, vsubq_u8(index, block)));
  }
  for (; x < width; ++x) out[x] = table[in[x]];
}

#else

// x86 has no lookup in 256 bytes, and emulating vqtbl4 costs more than scalar loads do. Four
// lookups come before their stores, as the compiler must assume that out overlaps in.
void map_row(const uint8_t* in, const uint8_t (&table)[256], int width, uint8_t* out) {
  int x = 0;
  for (; x + 4 <= width; x += 4) {
    const uint8_t a = table[in[x]], b = table[in[x + 1]];
    const uint8_t c = table[in[x + 2]], d = table[in[x + 3]];
    out[x] = a;
    out[x + 1] = b;
    out[x + 2] = c;
    out[x + 3] = d;
  }
  for (; x < width; ++x) out[x] = table[in[x]];
}

#endif

}  // namespace

void equalize_neon(const ImageView& in, uint8_t* out, int out_stride, int count_every) {
  equalize_detail::check(in, out_stride, count_every);
  uint32_t histogram[256];
  count(in, count_every, histogram);
  uint8_t table[256];
  equalize_detail::make_table(histogram, in, count_every, table);
  for (int y = 0; y < in.height; ++y)
    map_row(in.row(y), table, in.width, out + static_cast<int64_t>(y) * out_stride);
}

}  // namespace pirvs
