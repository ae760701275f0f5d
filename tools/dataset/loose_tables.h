// What    Tables as phones and loggers leave them beside a video or images.
// In      open_frame_stamps: a stamp for each frame, perhaps a file name behind it, perhaps a
//         column in front that counts rows from 0 or 1 on. read_triples: stamp, x, y, z of one
//         sensor. put_gyro_first: samples of a table whose columns nothing names.
// Out     open_frame_stamps: the table without that column. read_triples: samples of which
//         `vector` is set, in order of time. put_gyro_first: exchanges gyro and force where
//         gravity is in the first three columns, and notes it (PennCOSYVIO's imu.txt).
// Units   ns; as the file has them.
// Errors  InputError: a line that is no row, fewer than two rows. Counted: rows that are cut off,
//         not finite, out of order, repeated.
// Cost    ~1 us a row.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bsp/api/imu.h"
#include "tools/dataset/input_log.h"
#include "tools/dataset/text_table.h"

namespace pirvs::tools {

std::unique_ptr<TextTable> open_frame_stamps(const std::string& path, const StampRule& rule);
std::vector<ImuSample> read_triples(TextTable& table, Vec3 ImuSample::*vector,
                                    const std::string& path, InputLog& log);
void put_gyro_first(std::vector<ImuSample>& samples, InputLog& log);

}  // namespace pirvs::tools
