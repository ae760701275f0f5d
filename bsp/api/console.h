// Text for a person: serial console or standard error.
// In      A zero-terminated text; the caller adds the newline.
// Out     The text, unbuffered.
// Errors  Lost silently: nobody can be told.
// Cost    May block for the length of the text on a serial line; never from a timed step.
// Source  STYLE principle 3.
#pragma once

namespace pirvs::bsp {

void console_write(const char* text);

}  // namespace pirvs::bsp
