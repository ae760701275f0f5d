// What    A folder of loose files, as phones and loggers leave them: a video or images, tables of
//         stamps and of the IMU.
// In      A folder, or a video of it; its files are told by their names (docs/formats.md):
//           video        *.mp4 .mov .avi .mkv .m4v .webm, one or two (left before right by name)
//           images       else: the folder's own, or those of one or two folders in it
//           stamps       a table with "frame", "image", "video", "cam" or "stamp" in its name, or
//                        with the video's own name: stamp of each frame, a column that counts them
//                        may stand in front; of images, their names may stand behind
//           IMU          a table with "imu", or both "gyr" and "acc", in its name; or one with
//                        "gyr" and one with "acc": stamp, x, y, z. Without a heading gravity tells
//                        which columns are the accelerometer's
//           truth        "truth", "mocap", "pose"
// Out     recording, all of it, not yet cut. Frame i of a video has row i's stamp.
// Units, errors  as of recording.h. A video is counted where it has fewer frames than its table.
// Cost    a video is decoded from front to end; back in it, from its begin.
// Source  what phones' loggers write (MARS logger, ADVIO, OpenCamera Sensors).
#pragma once

#include "tools/dataset/recording.h"

namespace pirvs::tools {

// Whether it is or holds a video, or holds images and a table.
bool is_loose(const std::string& path);
void read_loose_files(const std::string& path, const RecordingOptions& options,
                      Recording& recording);

}  // namespace pirvs::tools
