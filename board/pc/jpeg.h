// The luma of a JPEG by libjpeg-turbo, for cameras that compress their images (MJPEG).
// In      The bytes of one image, and the size it must have; rows of `width` bytes to write to.
// Out     Its luma: colour is not decoded.
// Errors  False: no JPEG, another size, or broken in any way, also where the library would go on
//         with a warning. Then out may hold a part of it.
// Cost    640 x 480: about 1 ms on a PC. The library takes memory from the heap while it decodes.
// Source  ITU-T T.81; libjpeg-turbo 2.1, libjpeg.txt. Cameras leave out the Huffman tables, and the
//         library has them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::board {

bool jpeg_to_grey(const uint8_t* data, size_t size, int width, int height, uint8_t* out);

}  // namespace pirvs::board
