#include "board/pc/jpeg.h"

#include <setjmp.h>

#include <cstdio>  // jpeglib.h wants it before

#include <jpeglib.h>

namespace pirvs::board {
namespace {

struct Failure {
  jpeg_error_mgr manager;
  jmp_buf jump;
};

[[noreturn]] void give_up(j_common_ptr info) {
  longjmp(reinterpret_cast<Failure*>(info->err)->jump, 1);
}

// Level -1: something is wrong with the data, and the library would make do.
void on_message(j_common_ptr info, int level) {
  if (level < 0) give_up(info);
}

void be_quiet(j_common_ptr) {}

bool decode(jpeg_decompress_struct& info, int width, int height, uint8_t* out) {
  if (jpeg_read_header(&info, TRUE) != JPEG_HEADER_OK) return false;
  const bool size = info.image_width == static_cast<JDIMENSION>(width) &&
                    info.image_height == static_cast<JDIMENSION>(height);
  const bool luma = info.jpeg_color_space == JCS_YCbCr || info.jpeg_color_space == JCS_GRAYSCALE;
  if (!size || !luma) return false;
  info.out_color_space = JCS_GRAYSCALE;
  info.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = out + size_t{info.output_scanline} * static_cast<size_t>(width);
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  return true;
}

}  // namespace

// Nothing that has a destructor lives between setjmp and the library.
bool jpeg_to_grey(const uint8_t* data, size_t size, int width, int height, uint8_t* out) {
  if (size == 0) return false;
  static_assert(offsetof(Failure, manager) == 0, "give_up() comes back to it");
  Failure failure;
  jpeg_decompress_struct info{};
  info.err = jpeg_std_error(&failure.manager);
  failure.manager.error_exit = give_up;
  failure.manager.emit_message = on_message;
  failure.manager.output_message = be_quiet;
  if (setjmp(failure.jump) != 0) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, data, size);
  const bool good = decode(info, width, height, out);
  jpeg_destroy_decompress(&info);
  return good;
}

}  // namespace pirvs::board
