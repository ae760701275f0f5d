// The robot's link of a board without an operating system, on serial port 0, for which the image
// has no other than the console's line: frames stand between lines of text, which a robot's parser
// skips as noise.
// In      open(): the stack, before it runs; poll(): after each of its steps; frame(), health(),
//         answer(): what it tells. All from core 0.
// Out     Frames to the line; commands, fixes and wheels that come by it to the stack. The clock is
//         that of the recording (modules/link/replay_link.h): the frames are those of `pirvs run
//         --mavlink FILE`.
// Errors  open: as serial_open and ReplayLink::open.
// Cost    As long as the line takes for a frame of 245 bytes, 50 times a second of the recording.
// Source  docs/integration.md.
#pragma once

#include "modules/app/app.h"

namespace pirvs::board {

Status robot_link_open(App& app, const ImuNoise& noise);
void robot_link_poll(void*);
void robot_link_frame(TimeNs t);
void robot_link_health(HealthState state, const char* what);
void robot_link_answer(const Answer& answer);
void robot_link_close();

}  // namespace pirvs::board
