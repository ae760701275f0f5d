// Prints the edges of a pin instead of running: to check the wiring of a board, and its stamps.
// In      The command line:
//           watch=BANK.LINE   which pin, 4.26 for instance
//           watch_edges=N     end after so many (default 10)
//           watch_poll_ms=N   how often to look (default 10): a stamp must not depend on it
// Out     pin_watch_wanted: the word is there. pin_watch: "watching", then for each edge one line
//         `edge BANK.LINE LEVEL STAMP POLLED`, both in seconds; the exit code: 0 all edges came,
//         2 no such pin.
// Errors  Lost edges are said.
// Cost    Waits for the edges, for ever if need be.
// Source  bsp/api/gpio.h; docs/board-bringup.md.
#pragma once

namespace pirvs::board {

bool pin_watch_wanted();
int pin_watch();

}  // namespace pirvs::board
