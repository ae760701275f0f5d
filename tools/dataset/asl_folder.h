// What    Reads an ASL/EuRoC folder and its dialects into a Recording.
// In      The folder or its mav0: cam<k>/data.csv, or file names that are stamps; images in
//         cam<k>/data or where the table says; imu0/data.csv; sensor.yaml of each or options; a
//         truth in one of the usual places (docs/formats.md).
// Out     recording, all of it, not yet cut.
// Units, errors  as of recording.h.
// Source  Burri et al., IJRR 2016; TUM-VI, ILLIXR, what loggers write.
#pragma once

#include "tools/dataset/recording.h"

namespace pirvs::tools {

void read_asl_folder(const std::string& folder, const RecordingOptions& options,
                     Recording& recording);

}  // namespace pirvs::tools
