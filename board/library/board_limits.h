// As a PC's recordings: the library is the same.
#pragma once

#include "board/host/board_limits.h"
