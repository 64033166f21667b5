#pragma once

#include <string_view>

namespace modsearch::app {

/// Makes the descriptors 0, 1 and 2 safe to use, before anything else is opened. One that the caller closed is put on
/// /dev/null, so that no file can ever get its number and, with it, what is meant for the screen; what is written to a
/// stdout that was closed still fails, because output that is lost is no success. A reader that has gone away and a
/// file that may not grow become errors of the write, which is where they are handled, instead of a signal that ends
/// the program with the work it has done.
void secure_standard_streams();

/// Says `text` on stderr, as far as it will have it at once: what the reader of a full pipe or a stopped terminal
/// misses is lost, and so is everything where stderr is closed or full. Never throws, never waits.
void tell(std::string_view text) noexcept;

/// The same for the last sentence of a program: waits for a slow reader.
void tell_at_last(std::string_view text) noexcept;

}  // namespace modsearch::app
