// The recordings that system tests run on.
// In      PIRVS_DATA: the folder of real recordings (default ../shared/data).
// Out     clip(): 30 s of EuRoC MH_01, from a moving start to a standstill; nullptr and a printed
//         reason when it is not there. simulated(): about 6 s of one device, made on first use,
//         deleted at the end. made(): any other, deleted when the process ends. scratch_folder():
//         empty, deleted at the end.
// Errors  an exception of tools, which fails the test, when the disk refuses.
// Cost    a simulated recording: ~6 s of two cores, 50 to 100 MB of disk.
// Source  DESIGN, "Frames, units, names": the two devices.
#pragma once

#include <string>

#include "tools/dataset/recording.h"
#include "tools/sim/sim.h"

namespace pirvs::systems {

enum class SimulatedDevice { kEuroc, kIronsides };

const tools::Recording* clip();
const tools::Recording& simulated(SimulatedDevice device);
// `out` is chosen here.
tools::Recording made(tools::SimOptions options, const std::string& name);
std::string scratch_folder(const std::string& name);

}  // namespace pirvs::systems
