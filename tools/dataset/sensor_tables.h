// What    The tables that a recording is made of: a list of images, samples of an IMU.
// In      Text tables (text_table.h). Images: stamp, file name; without names, the stamp is the
//         name. IMU: stamp, w x y z, a x y z, or as the heading's names say (w_, gyro, omega; a_,
//         acc); a heading's [g], [deg/s] are converted.
// Out     kInOrderOfTime: rows in the order of their stamps, each stamp once. kAsRecorded: as they
//         stand.
// Units   ns; rad/s; m/s^2.
// Errors  InputError: no rows, a line that is not a row, columns that nobody can tell apart.
//         Counted: rows cut off at the end, not finite, out of order, of a stamp that was there.
// Cost    ~1 us a row.
#pragma once

#include <string>
#include <vector>

#include "bsp/api/imu.h"
#include "tools/dataset/input_log.h"
#include "tools/dataset/stamps.h"

namespace pirvs::tools {

class TextTable;

struct ListedImage {
  TimeNs t = 0;
  std::string file;
};

enum class Rows : uint8_t { kInOrderOfTime, kAsRecorded };

std::vector<ListedImage> read_image_list(const std::string& path, InputLog& log,
                                         Rows rows = Rows::kInOrderOfTime,
                                         const StampRule& rule = {kCameraRates, {}, {}});
std::vector<ImuSample> read_imu_samples(const std::string& path, InputLog& log,
                                        Rows rows = Rows::kInOrderOfTime,
                                        const StampRule& rule = {kImuRates, {}, {}});

// The same of tables that are open; `path` is what errors name.
std::vector<ListedImage> read_image_list(TextTable& table, const std::string& path, InputLog& log,
                                         Rows rows);
std::vector<ImuSample> read_imu_samples(TextTable& table, const std::string& path, InputLog& log,
                                        Rows rows);

// Sorts by stamp and drops what repeats one; both are counted, as `what`_out_of_order and
// `what`_repeated.
void put_in_order(std::vector<ListedImage>& images, const std::string& what, InputLog& log);
void put_in_order(std::vector<ImuSample>& samples, const std::string& what, InputLog& log);

}  // namespace pirvs::tools
